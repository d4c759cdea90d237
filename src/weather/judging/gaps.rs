//! Gaps of a row. In: GHI, DNI and DHI, some of them missing. Out: DNI and DHI.

use glam::DVec3;

use crate::erbs::diffuse_fraction;
use crate::findings::Finding;
use crate::judging::raw_weather::RawRow;
use heliotile_core::weather::time::sun::{Location, extraterrestrial_w_m2};

/// Least cosine of the zenith angle at which GHI is used for DNI. Below it (GHI - DHI) / cos z
/// would blow up.
const SMALLEST_COSINE: f64 = 0.05;

/// Number of sub-steps over which the cosine of a row is averaged.
const STEPS: usize = 4;

/// DNI and DHI after filling, and the kind of gap.
pub struct Filled {
    pub dni_w_m2: f64,
    pub dhi_w_m2: f64,
    pub gap: Option<Finding>,
}

/// Returns DNI and DHI of a row: as given, else from the closure GHI = DHI + DNI cos z with the
/// mean cosine of the sunlit part, else from GHI alone, else 0. `sun` is that of mid-interval.
pub fn fill(raw: &RawRow, site: &Location, sun: DVec3) -> Filled {
    let cosine = || {
        let suns = site.sunlit(&raw.interval, sun.into(), STEPS);
        suns.iter().map(|s| s.z).sum::<f64>() / suns.len().max(1) as f64
    };
    let (dni_w_m2, dhi_w_m2, gap) = match (raw.ghi, raw.dni, raw.dhi) {
        (_, Some(dni), Some(dhi)) => (dni, dhi, None),
        (Some(ghi), Some(dni), None) => (dni, (ghi - dni * cosine()).max(0.0), Some(Finding::ComputedDhi)),
        (Some(ghi), None, dhi) => {
            let gap = if dhi.is_some() { Finding::ComputedDni } else { Finding::SplitGhi };
            let cosine = cosine();
            // DNI is limited to the light that the sun sends while it is up. The rest is diffuse or
            // an error of the file.
            let lit = site.sunlit_hours(&raw.interval, sun.into()) / raw.interval.hours();
            let most = extraterrestrial_w_m2(raw.interval.date) * lit;
            if cosine < SMALLEST_COSINE {
                (0.0, ghi, Some(gap))
            } else if let Some(dhi) = dhi {
                (((ghi - dhi) / cosine).clamp(0.0, most), dhi, Some(gap))
            } else {
                let dni = (ghi * (1.0 - diffuse_fraction(ghi / (most * cosine))) / cosine).clamp(0.0, most);
                (dni, ghi - dni * cosine, Some(gap))
            }
        }
        (None, dni, dhi) => (dni.unwrap_or(0.0), dhi.unwrap_or(0.0), Some(Finding::Zeroed)),
    };
    Filled { dni_w_m2, dhi_w_m2, gap }
}
