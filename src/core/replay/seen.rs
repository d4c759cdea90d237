//! Classes of the surfaces that a receiver sees, by direction of the world's upper hemisphere, and
//! their places on a disc. In: a [`ReceiverView`]. Out: classes.
//!
//! The disc is equidistant: the distance from its middle is the angle from the zenith. The site's y
//! is up and x is right, as on a map under the disc and on printed sun-path diagrams.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use crate::hemisphere::{Frame, texel_of};
use crate::replay::direct::canopy_transmittance::CanopyTransmittance;
use crate::replay::receiver_view::ReceiverView;
use crate::site::material::Class;

/// Class of the surface that is seen in a direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// Open sky.
    Sky,
    /// The sky through leaves or screens.
    Canopy,
    /// A surface of class ground.
    Ground,
    /// Any other surface, and directions without a known surface.
    Obstruction,
    /// Surface that reflects like a mirror, whatever its class.
    Mirror,
    /// Nothing: the direction lies behind the receiver's own surface.
    Behind,
}

/// Hemisphere of a receiver as a disc of radius 1.
pub struct SkyDisc<'v> {
    view: &'v ReceiverView,
    frame: Frame,
    /// Shares of light that canopies let through; `None` if no canopy stands before the sky.
    veil: Option<CanopyTransmittance>,
}

impl<'v> SkyDisc<'v> {
    /// Returns the disc of a receiver.
    pub fn new(view: &'v ReceiverView) -> Self {
        SkyDisc { view, frame: Frame::new(view.receiver.normal), veil: view.veil() }
    }

    /// Returns the place of a direction above the horizon: x to the right, y up.
    pub fn place_of(direction: DVec3) -> (f64, f64) {
        let horizontal = direction.x.hypot(direction.y);
        let r = horizontal.atan2(direction.z) / FRAC_PI_2;
        let scale = if horizontal > 0.0 { r / horizontal } else { 0.0 };
        (direction.x * scale, direction.y * scale)
    }

    /// Returns the direction at a place, or `None` outside the horizon.
    pub fn direction_at(x: f64, y: f64) -> Option<DVec3> {
        let r = x.hypot(y);
        let zenith_rad = r * FRAC_PI_2;
        let scale = if r > 0.0 { zenith_rad.sin() / r } else { 0.0 };
        (r <= 1.0).then(|| DVec3::new(x * scale, y * scale, zenith_rad.cos()))
    }

    /// Returns the class that is seen in a direction.
    pub fn seen(&self, direction: DVec3) -> Seen {
        let (view, local) = (self.view, self.frame.to_local(direction));
        if local.z <= 0.0 {
            return Seen::Behind;
        }
        // The texture of the sky ends at the horizon.
        let (column, row) = texel_of(direction, view.sky.side() * view.sky.block());
        if direction.z > 0.0 && view.sky.get(column, row) {
            let through = self.veil.as_ref().map_or(1.0, |veil| veil.at_fine(column, row));
            return if through < 1.0 { Seen::Canopy } else { Seen::Sky };
        }
        let texel = view.nearest_seen(local);
        match texel.map(|texel| (view.class(texel), view.is_mirror(texel))) {
            Some((_, true)) => Seen::Mirror,
            Some((Some(Class::Ground), _)) => Seen::Ground,
            _ => Seen::Obstruction,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::direction_from_degrees;

    /// The zenith is in the middle, north up, east right, and 45 degrees of altitude half way. The
    /// places of 500 directions lead back to them.
    #[test]
    fn the_view_is_equidistant_with_north_up() {
        assert_eq!(SkyDisc::place_of(DVec3::Z), (0.0, 0.0));
        for (azimuth, x, y) in [(0.0, 0.0, 1.0), (90.0, 1.0, 0.0), (180.0, 0.0, -1.0), (270.0, -1.0, 0.0)] {
            for (altitude, r) in [(0.0, 1.0), (45.0, 0.5)] {
                let at = SkyDisc::place_of(direction_from_degrees(azimuth, altitude));
                assert!((at.0 - r * x).abs() < 1e-12 && (at.1 - r * y).abs() < 1e-12, "{at:?}");
            }
        }
        for i in 0..500 {
            let d = direction_from_degrees(f64::from(i) * 137.5, f64::from(i % 90) + 0.5);
            let (x, y) = SkyDisc::place_of(d);
            assert!(SkyDisc::direction_at(x, y).is_some_and(|back| (back - d).length() < 1e-12));
        }
        assert_eq!(SkyDisc::direction_at(1.01, 0.0), None);
    }
}
