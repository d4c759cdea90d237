//! Optical properties of a building's layers. In: shares of light, panes and heat losses as models
//! state them. Out: checked shares, glass, and materials under unique names.

use heliotile_core::site::bands::{Band, BandValues};
use heliotile_core::site::material::{Glass, Material};

use crate::formats::building::notes::Notes;
use crate::geometry::Geometry;
use crate::materials::select::MaterialTable;

/// Default of `Solar Absorptance` (EnergyPlus Input Output Reference, `Material`; honeybee-schema,
/// `EnergyMaterial`).
pub(in crate::formats) const ABSORPTANCE: f64 = 0.7;
/// Default of `Leaf Reflectivity` (`Material:RoofVegetation`; `EnergyMaterialVegetation`).
pub(in crate::formats) const LEAF_REFLECTANCE: f64 = 0.22;
/// Heat loss below which a glazing system has two panes, W/(m2 K): a single clear pane loses 5.8,
/// two lose 2.7 (ASHRAE Fundamentals, chapter 15).
const TWO_PANES_BELOW: f64 = 4.0;

/// Returns the number of panes of a glazing system that states only its heat loss, in W/(m2 K).
pub(in crate::formats) fn panes_of_system(loss_w_m2k: f64) -> usize {
    if loss_w_m2k < TWO_PANES_BELOW { 2 } else { 1 }
}

/// Returns the glass of `panes` panes; `None` for 0. Three panes or more are taken for two.
pub(in crate::formats) fn glass_of_panes(panes: usize) -> Option<Glass> {
    match panes {
        0 => None,
        1 => Some(Glass::Single),
        _ => Some(Glass::Double),
    }
}

/// Returns a share of light, clamped to 0..=1, with a note if it lies outside.
pub(in crate::formats) fn share(value: f64, name: &str, notes: &mut Notes) -> f64 {
    if !(0.0..=1.0).contains(&value) {
        notes.add("reflectances or other optical properties lie outside 0 to 1; the nearest limit is used", name);
    }
    value.clamp(0.0, 1.0)
}

/// Returns a value for visible light; none if the model states none, or the same value as for all
/// solar light.
pub(in crate::formats) fn visible(value: Option<f64>, solar: f64) -> BandValues {
    value.filter(|value| *value != solar).map_or(BandValues::default(), |value| BandValues::new(Band::Visible, value))
}

/// Materials that a model states.
#[derive(Debug, Default)]
pub(in crate::formats) struct Stated(pub MaterialTable);

impl Stated {
    /// Adds a material and returns its number. If its name already stands for another material, the
    /// name gets a number behind it.
    pub(in crate::formats) fn add(&mut self, material: Material, geometry: &mut Geometry) -> u32 {
        let mut material = material;
        let plain = material.name.clone();
        let mut number = 2;
        while self.0.get(&material.name).is_some_and(|known| *known != material) {
            material.name = format!("{plain} ({number})");
            number += 1;
        }
        let id = geometry.materials.id(&material.name);
        self.0.insert(material.name.clone(), material);
        id
    }
}
