//! Receivers on the ground among rows of modules. In: rows with their modules, the scene without
//! them. Out: free places, a little above the surface.

use std::path::Path;

use glam::DVec2;

use super::modules::LaidRows;
use heliotile_builder::siting::Siting;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::observer::Observer;
use heliotile_scene::pv::ground::{GroundGrid, GroundPlace};

/// Largest number of places: more are a mix-up of metres and millimetres.
const MAX_PLACES: f64 = 1e6;

/// Distance of receivers of modules and of the ground off their surfaces, metres.
pub const OFF_M: f64 = 0.005;

/// Receiver on the ground, which faces straight up.
#[derive(Clone, Debug)]
pub struct GroundSpot {
    /// Name of the rows of modules around it.
    pub rows: String,
    pub place: GroundPlace,
}

impl GroundSpot {
    /// Returns the places of all rows that request some; `file` is the file of the rows, for
    /// messages.
    pub fn among(file: &Path, laid: &LaidRows, siting: &Siting, observer: &dyn Observer) -> Result<Vec<Self>> {
        let (mut all, mut wanted) = (Vec::new(), 0.0);
        for field in laid.fields() {
            let (name, Some(step_m)) = (&field.rows.name, field.rows.ground_step_m) else { continue };
            let grid = GroundGrid::new(&field.rows, step_m, field.north, &field.outline);
            wanted += grid.size();
            if wanted > MAX_PLACES {
                let what = "the number of places on the ground among rows".to_owned();
                return Err(Error::Limit { what: what.into(), value: wanted as u64, max: MAX_PLACES as u64 });
            }
            let below = |p: DVec2| siting.top(p.x, p.y).map(|top| top.z);
            let modules = laid.fields().iter().flat_map(|field| &field.modules);
            let found = grid.places(OFF_M, below, modules);
            let left_out = found.without_ground + found.in_modules;
            if found.list.is_empty() {
                let what = format!("the rows `{name}`: their area has no free place on the ground");
                return Err(Error::input(file, None, what, "give `ground` a smaller distance, or leave it out")
                    .because(Problem::Empty));
            }
            if left_out > 0 {
                observer.warn(format!(
                    "{}: the rows `{name}`: {left_out} of {} places on the ground are left out: they have no ground below, or lie inside of modules",
                    file.display(),
                    found.list.len() + left_out
                ));
            }
            let spot = |place: GroundPlace| GroundSpot { rows: name.clone(), place };
            all.extend(found.list.into_iter().map(spot));
        }
        Ok(all)
    }
}
