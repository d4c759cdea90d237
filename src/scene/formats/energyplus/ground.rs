//! Ground of a model. No surface draws it: EnergyPlus has an endless plane. In: the ground
//! reflectance that the file states, and the height of the plane. Out: the plane.

use std::path::Path;

use crate::formats::building::notes::Notes;
use crate::formats::energyplus::model::{Model, share};
use crate::ground::model::{ModelGround, USUAL};
use heliotile_core::error::Result;

/// Fields of `Site:GroundReflectance`, January to December.
pub const GROUND_MONTHS: [&str; 12] = [
    "january_ground_reflectance",
    "february_ground_reflectance",
    "march_ground_reflectance",
    "april_ground_reflectance",
    "may_ground_reflectance",
    "june_ground_reflectance",
    "july_ground_reflectance",
    "august_ground_reflectance",
    "september_ground_reflectance",
    "october_ground_reflectance",
    "november_ground_reflectance",
    "december_ground_reflectance",
];

/// Reads the ground of a model.
pub(super) fn read(model: &Model, file: &Path, elevation_m: f64, notes: &mut Notes) -> Result<ModelGround> {
    let mut ground = ModelGround::usual(elevation_m);
    if let Some(stated) = model.of("Site:GroundReflectance").next() {
        ground.stated = true;
        for (value, key) in ground.reflectance.iter_mut().zip(GROUND_MONTHS) {
            *value = share(stated, file, key, USUAL, notes)?;
        }
    }
    if let Some(stated) = model.of("Site:GroundReflectance:SnowModifier").next() {
        let modifier = stated.number_or(file, "ground_reflected_solar_modifier", 1.0)?;
        if modifier < 0.0 {
            notes.add("snow modifiers of the ground are below 0; 0 is taken", &stated.name);
        }
        ground.snow_modifier = modifier.max(0.0);
        ground.stated = true;
    }
    Ok(ground)
}
