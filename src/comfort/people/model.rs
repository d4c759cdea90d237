//! Model of people and surfaces, equal in all hours and at all points. In: choices, materials. Out:
//! numbers.

use crate::mean_radiant::RadiantBody;
use crate::pet::PetPerson;
use crate::surroundings::{SurfaceMean, USUAL_FILM_W_M2_K};
use heliotile_core::named::NamedValues;
use heliotile_core::site::material::{Class, Material};

/// Shape of a person in direct sun.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SunOnPerson {
    /// Upright cylinder, which all azimuths of the sun meet alike.
    #[default]
    Cylinder,
    /// Six planes of a box, as instruments measure them.
    Box,
}

/// Surfaces of a class, where the surfaces that a plane sees are not known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceModel {
    /// Longwave emissivity.
    pub emissivity: f64,
    /// Share of light that they absorb, if they have their sol-air temperature. `None`: they emit
    /// as the hour's emission states.
    pub sol_air: Option<f64>,
}

/// Model of people and surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComfortModel {
    /// The body that absorbs radiation.
    pub body: RadiantBody,
    /// The person of the PET.
    pub person: PetPerson,
    /// Shape of a person in direct sun.
    pub sun: SunOnPerson,
    /// Heat transfer coefficient between surfaces and air, radiation included, W/m2K.
    pub film_w_m2_k: f64,
    /// Model of the ground.
    pub ground: SurfaceModel,
    /// Model of obstructions.
    pub obstruction: SurfaceModel,
}

impl ComfortModel {
    /// Returns the model of standing people among surfaces of sol-air temperatures, which absorb
    /// the light that their materials do not reflect.
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

heliotile_core::serde_by_name!(SunOnPerson);

heliotile_core::parse_by_name!(SunOnPerson);
