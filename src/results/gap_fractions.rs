//! Gap fractions: shares of the sky that are seen through leaves, by rings of zenith angles, as
//! foresters take them from hemispherical photographs. In: a site. Out: five shares for each
//! receiver that faces the zenith, and the leaf area index that follows from them.

use glam::DVec3;

use heliotile_core::error::Result;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::time::bins::Bins;

/// Number of rings.
pub const RINGS: usize = 5;

/// Ring of zenith angles of the plant canopy analyser LAI-2000 (Welles and Norman 1991).
struct Ring {
    middle_deg: f64,
    width_deg: f64,
    /// Weight in the leaf area index: sin(zenith) times width, summing to 1.
    weight: f64,
}

/// Rings from the zenith down.
const ALL: [Ring; RINGS] = [
    Ring { middle_deg: 7.0, width_deg: 12.2, weight: 0.041 },
    Ring { middle_deg: 23.0, width_deg: 12.2, weight: 0.131 },
    Ring { middle_deg: 38.0, width_deg: 11.8, weight: 0.201 },
    Ring { middle_deg: 53.0, width_deg: 13.2, weight: 0.290 },
    Ring { middle_deg: 68.0, width_deg: 13.2, weight: 0.337 },
];

/// Number of zenith and azimuth angles at which a ring is looked at.
const ZENITHS: usize = 6;
const AZIMUTHS: usize = 60;

/// Irradiance of an open ring, W/m2. Any value would do: results are shares of it.
const OPEN_W_M2: f64 = 100.0;

/// Least height of a unit normal that faces the zenith.
const LEVEL: f64 = 0.999;

/// Gaps above a receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaps {
    /// Shares of the rings, from the zenith down.
    pub shares: [f64; RINGS],
    /// Effective leaf area index, m2 of leaves (one side) per m2 of ground (Miller 1967); `None` if
    /// a ring has no gap.
    pub leaf_area_index: Option<f64>,
}

impl Gaps {
    fn new(shares: [f64; RINGS]) -> Self {
        let of_ring = |(share, ring): (&f64, &Ring)| -share.ln() * ring.middle_deg.to_radians().cos() * ring.weight;
        let index = 2.0 * shares.iter().zip(&ALL).map(of_ring).sum::<f64>();
        // A share above 1 by rounding is no negative index.
        Gaps { shares, leaf_area_index: index.is_finite().then_some(index.max(0.0)) }
    }
}

/// Gap fractions of a site. Each direction in which a ring is looked at is that of a sun.
pub struct GapFractions<'a>(Replay<'a>);

impl<'a> GapFractions<'a> {
    /// Prepares the gap fractions of a site, with the leaves of the archive.
    pub fn new(site: &OpenSite<'a>) -> Result<Self> {
        let (mut suns, mut of_condition) = (Vec::new(), Vec::new());
        for (number, ring) in ALL.iter().enumerate() {
            let low = ring.middle_deg - 0.5 * ring.width_deg;
            let zenith = |i: usize| (low + ring.width_deg * (i as f64 + 0.5) / ZENITHS as f64).to_radians();
            let all: f64 = (0..ZENITHS).map(|i| zenith(i).sin()).sum();
            for i in 0..ZENITHS {
                let (sin, cos) = zenith(i).sin_cos();
                let turn =
                    |k: usize| ((k as f64 + i as f64 / ZENITHS as f64) / AZIMUTHS as f64) * std::f64::consts::TAU;
                let ways: Vec<DVec3> =
                    (0..AZIMUTHS).map(|k| DVec3::new(sin * turn(k).cos(), sin * turn(k).sin(), cos)).collect();
                // Each zenith angle counts by its solid angle.
                let normal_w_m2 = OPEN_W_M2 * sin / all / cos;
                suns.push(Condition::new(format!("ring {number}"), &ways, DVec3::Z, normal_w_m2, 0.0));
                of_condition.push((number, 1.0));
            }
        }
        let components = ComponentSet::new(&[Component::SunDirect]);
        let settings = ReplaySettings { components, ..ReplaySettings::default() };
        let bins = Bins { count: RINGS, of_condition };
        Replay::builder(site, &suns, settings).summed(&bins).build().map(GapFractions)
    }

    /// Returns the gaps of each receiver of a tile, `[row]`, from their unit normals; a receiver
    /// that does not face the zenith has none.
    pub fn tile(&self, tile: u32, normals: &[[f64; 3]]) -> Result<Vec<Option<Gaps>>> {
        let is_level = |normal: &[f64; 3]| normal[2] >= LEVEL;
        if !normals.iter().any(is_level) {
            return Ok(vec![None; normals.len()]);
        }
        let Some((_, values)) = self.0.results([tile]).next().transpose()? else { return Ok(Vec::new()) };
        let gaps = |(row, normal): (usize, &[f64; 3])| {
            let shares = values.row(Component::SunDirect, row);
            let share = |ring: usize| f64::from(shares.get(ring).copied().unwrap_or(0.0)) / OPEN_W_M2;
            is_level(normal).then(|| Gaps::new(std::array::from_fn(share)))
        };
        Ok(normals.iter().enumerate().map(gaps).collect())
    }
}
