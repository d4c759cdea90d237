//! Ground of a building model. In: its faces. Out: the height of the ground plane, and warnings if
//! the model reaches below z = 0 or stands far above it.
//!
//! EnergyPlus has its ground at z = 0 for every model: `SolarReflectionManager` of version 25.2
//! never sets `GroundLevelZ`.

use std::path::Path;

use crate::geometry::{Geometry, Polygon};
use heliotile_core::site::semantics::SurfaceKind;

/// Depth below z = 0 that is taken for rounding of coordinates, metres.
const ROUNDED_M: f64 = 0.01;
/// Height of the lowest surface in the sun above which a model gets a warning, metres.
const HIGH_M: f64 = 10.0;

/// Effect of shading surfaces on the height of the ground, besides the surfaces in the sun of the
/// building.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::formats) enum Shades {
    /// Shades count: they may be terrain and lie on the ground.
    Count,
    /// Shades do not count: they may stand in a pit.
    Pass,
}

/// Returns the height of a model's ground, metres: 0, or the height of the lowest corner of its
/// surfaces in the sun if that lies below 0.
pub(in crate::formats) fn ground_elevation_m(geometry: &mut Geometry, shades: Shades, file: &Path) -> f64 {
    let corner = |corner: &u32| geometry.vertices.get(*corner as usize).map(|p| p.z);
    let lowest_of = |face: &Polygon| face.corners().iter().filter_map(corner).reduce(f64::min);
    let mut lowest = Vec::new();
    for (face, source) in geometry.faces().zip(geometry.source_faces()) {
        let counts = shades == Shades::Count || source.note.kind != Some(SurfaceKind::Shade);
        if counts && source.note.exposed == Some(true) {
            lowest.extend(lowest_of(&face));
        }
    }
    let Some(lowest_m) = lowest.iter().copied().reduce(f64::min) else { return 0.0 };
    let below = lowest.iter().filter(|z| **z < -ROUNDED_M).count();
    if below > 0 {
        geometry.warnings.push(format!(
            "{}: {below} surfaces in the sun reach below z = 0, down to {lowest_m:.2} m, where the ground plane is placed; raise the \
             model if it stands on the ground. EnergyPlus keeps its ground at z = 0; it hides nothing and sends no light to points \
             below it",
            file.display()
        ).into());
    }
    if lowest_m > HIGH_M {
        geometry.warnings.push(format!(
            "{}: the lowest surface in the sun lies {lowest_m:.2} m above the ground, which is at z = 0 as in EnergyPlus; lower the \
             model if it stands on the ground",
            file.display()
        ).into());
    }
    lowest_m.min(0.0)
}
