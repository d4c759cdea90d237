//! Surroundings that each plane sees. In: a receiver's normal, shares of its hemisphere, sky and
//! surfaces. Out: [`ViewShares`].

use glam::DVec3;

use crate::clear_sky::ClearSky;
use crate::surroundings::{SeenSurfaces, ViewShares};
use heliotile_core::layers::sky_bitmap::SkyBitmap;
use heliotile_core::weather::conditions::Condition;

/// Diffuse irradiance of an open horizontal surface below [`uniform_sky`], W/m2.
const OPEN_W_M2: f64 = 100.0;

/// Returns a sky of equal radiance. The light that a plane gets directly from it tells which share
/// of its hemisphere is sky behind leaves and screens.
pub fn uniform_sky() -> Condition {
    Condition::new("uniform".into(), &[], DVec3::Z, 0.0, OPEN_W_M2)
}

/// Returns the share of the hemisphere, weighted by the cosine, that is sky, reduced by the leaves
/// before it. `sky_direct` is the irradiance that a plane gets directly from [`uniform_sky`], W/m2.
pub fn open_share(sky_direct: &[f32]) -> f64 {
    sky_direct.iter().copied().map(f64::from).sum::<f64>() / OPEN_W_M2
}

/// Surroundings that a plane of a person sees, as archives hold them.
pub struct SeenByPlane<'a> {
    /// Shares of its hemisphere: sky, ground and obstructions.
    pub shares: [f32; 3],
    /// Sky bitmap of the receiver.
    pub sky: &'a SkyBitmap,
    /// Share of its hemisphere that is sky behind leaves ([`open_share`]), if there are any.
    pub open: Option<f64>,
    /// Materials of the surfaces that it sees.
    pub surfaces: SeenSurfaces,
}

/// Computes views. It keeps the clear sky of the last size, so planes with skies of one size should
/// follow each other.
#[derive(Default)]
pub struct PlaneViews {
    clear: Option<ClearSky>,
}

impl PlaneViews {
    /// Returns the surroundings that a plane of this normal sees.
    pub fn of(&mut self, normal: DVec3, seen: &SeenByPlane) -> ViewShares {
        let clear = match &mut self.clear {
            Some(clear) if clear.side() == seen.sky.side() => clear,
            other => other.insert(ClearSky::new(seen.sky.side())),
        };
        let [sky, _, obstruction] = seen.shares.map(f64::from);
        // Leaves before the sky are as warm as the air and black, as far as light does not pass
        // them.
        let through = seen.open.map_or(1.0, |open| (open / sky).min(1.0));
        let missed = through * clear.missed(normal, seen.sky);
        ViewShares { sky, obstruction, missed, surfaces: seen.surfaces }
    }
}
