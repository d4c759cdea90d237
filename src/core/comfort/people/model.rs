//! How people and surfaces are taken: the same in all hours and at all points. In: choices, materials. Out: numbers.

use crate::comfort::mean_radiant::RadiantBody;
use crate::comfort::pet::PetPerson;
use crate::comfort::surroundings::{SurfaceMean, USUAL_FILM_W_M2_K};
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

/// The surfaces of a class, where nothing is known of those that a plane sees.
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
        let surfaces = |class| {
            let SurfaceMean { emissivity, absorptance } = SurfaceMean::of_class(class, materials);
            SurfaceModel { emissivity, sol_air: Some(absorptance) }
        };
        ComfortModel {
            body: RadiantBody::STANDING,
            person: PetPerson::VDI_3787,
            sun: SunOnPerson::default(),
            film_w_m2_k: USUAL_FILM_W_M2_K,
            ground: surfaces(Class::Ground),
            obstruction: surfaces(Class::Obstruction),
        }
    }
}

impl NamedValues for SunOnPerson {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("cylinder", "On an upright cylinder, from all azimuths alike", SunOnPerson::Cylinder),
        ("box", "On the six planes of a box, as instruments measure it", SunOnPerson::Box),
    ];
}

crate::serde_by_name!(SunOnPerson);
