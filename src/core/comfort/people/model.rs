//! How people and surfaces are taken: the same in all hours and at all points. In: choices, materials. Out: numbers.

use crate::comfort::mean_radiant::RadiantBody;
use crate::comfort::pet::PetPerson;
use crate::comfort::surroundings::{USUAL_FILM_W_M2_K, USUAL_GROUND_EMISSIVITY, USUAL_OBSTRUCTION_EMISSIVITY};
use crate::named::NamedValues;
use crate::site::material::{Class, Material};

/// How the sun falls on a person.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SunOnPerson {
    /// On an upright cylinder, from all azimuths alike.
    #[default]
    Cylinder,
    /// On the planes of a box, as instruments measure it.
    Box,
}

/// The surfaces of a class.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceModel {
    /// Longwave emissivity.
    pub emissivity: f64,
    /// The share of light that they absorb, where they have their sol-air temperature; none: they are as warm as the emission of the hour says.
    pub sol_air: Option<f64>,
}

/// People and surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComfortModel {
    /// The body that absorbs radiation.
    pub body: RadiantBody,
    /// The person of the PET.
    pub person: PetPerson,
    /// How the sun falls on a person.
    pub sun: SunOnPerson,
    /// Heat transfer coefficient between surfaces and air, radiation included, W/m2K.
    pub film_w_m2_k: f64,
    /// The ground.
    pub ground: SurfaceModel,
    /// Obstructions.
    pub obstruction: SurfaceModel,
}

impl ComfortModel {
    /// Standing people among surfaces of sol-air temperatures, which absorb what their materials do not reflect.
    pub fn usual(materials: &[Material]) -> Self {
        let surfaces = |class, emissivity| SurfaceModel { emissivity, sol_air: Some(absorptance(class, materials)) };
        ComfortModel {
            body: RadiantBody::STANDING,
            person: PetPerson::VDI_3787,
            sun: SunOnPerson::default(),
            film_w_m2_k: USUAL_FILM_W_M2_K,
            ground: surfaces(Class::Ground, USUAL_GROUND_EMISSIVITY),
            obstruction: surfaces(Class::Obstruction, USUAL_OBSTRUCTION_EMISSIVITY),
        }
    }
}

/// What the surfaces of a class absorb of light: what its materials do not reflect in the mean.
pub fn absorptance(class: Class, materials: &[Material]) -> f64 {
    let of_class = materials.iter().filter(|material| material.class == class && material.transmittance.is_none());
    let absorbed: Vec<f64> = of_class.map(|material| 1.0 - material.diffuse - material.specular).collect();
    let share = absorbed.iter().sum::<f64>() / absorbed.len() as f64;
    // A class without materials is not seen.
    if share.is_finite() { share.clamp(0.0, 1.0) } else { 1.0 }
}

impl NamedValues for SunOnPerson {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("cylinder", "On an upright cylinder, from all azimuths alike", SunOnPerson::Cylinder),
        ("box", "On the six planes of a box, as instruments measure it", SunOnPerson::Box),
    ];
}

crate::serde_by_name!(SunOnPerson);
