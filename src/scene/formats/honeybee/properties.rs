//! In: the properties of a Honeybee model and of its objects. Out: names of modifiers and
//! constructions, and their contents, typed but unchecked.

use std::fmt;
use std::marker::PhantomData;

use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};

/// An item by its name in a list of the model (the abridged form), or the item itself.
pub(super) enum Named<T> {
    By(String),
    Itself(Box<T>),
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Named<T> {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        struct Either<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Either<T> {
            type Value = Named<T>;

            fn expecting(&self, to: &mut fmt::Formatter) -> fmt::Result {
                to.write_str("an identifier or an object")
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Named<T>, E> {
                Ok(Named::By(text.to_owned()))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Named<T>, A::Error> {
                T::deserialize(MapAccessDeserializer::new(map)).map(|itself| Named::Itself(Box::new(itself)))
            }
        }
        source.deserialize_any(Either(PhantomData))
    }
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct ModelProperties {
    pub radiance: Option<ModelRadiance>,
    pub energy: Option<ModelEnergy>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct ModelRadiance {
    pub global_modifier_set: Option<Named<Set<Modifier>>>,
    pub modifier_sets: Option<Vec<Set<Modifier>>>,
    pub modifiers: Option<Vec<Modifier>>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct ModelEnergy {
    pub global_construction_set: Option<Named<Set<Construction>>>,
    pub construction_sets: Option<Vec<Set<Construction>>>,
    pub constructions: Option<Vec<Construction>>,
    pub materials: Option<Vec<Layer>>,
    pub schedules: Option<Vec<Schedule>>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct RoomProperties {
    pub radiance: Option<RoomRadiance>,
    pub energy: Option<RoomEnergy>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct RoomRadiance {
    pub modifier_set: Option<Named<Set<Modifier>>>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct RoomEnergy {
    pub construction_set: Option<Named<Set<Construction>>>,
}

/// Properties of a face, an opening or a shade.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct ObjectProperties {
    pub radiance: Option<ObjectRadiance>,
    pub energy: Option<ObjectEnergy>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct ObjectRadiance {
    pub modifier: Option<Named<Modifier>>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct ObjectEnergy {
    pub construction: Option<Named<Construction>>,
    /// Transmittance schedule; shades only.
    pub transmittance_schedule: Option<Named<Schedule>>,
}

/// A modifier set or construction set: the defaults for objects that name nothing of their own, by
/// kind.
#[derive(Deserialize)]
#[serde(bound = "T: Deserialize<'de>")]
pub(super) struct Set<T> {
    pub identifier: Option<String>,
    pub wall_set: Option<SubSet<T>>,
    pub floor_set: Option<SubSet<T>>,
    pub roof_ceiling_set: Option<SubSet<T>>,
    pub aperture_set: Option<SubSet<T>>,
    pub door_set: Option<SubSet<T>>,
    pub shade_set: Option<SubSet<T>>,
    pub shade_construction: Option<Named<T>>,
    #[serde(alias = "context_modifier", alias = "context_construction")]
    pub context: Option<Named<T>>,
    /// Modifiers or constructions that a global set carries with it.
    #[serde(alias = "modifiers", alias = "constructions")]
    pub members: Option<Vec<T>>,
    pub materials: Option<Vec<Layer>>,
}

#[derive(Deserialize)]
#[serde(bound = "T: Deserialize<'de>")]
pub(super) struct SubSet<T> {
    #[serde(alias = "exterior_modifier", alias = "exterior_construction")]
    pub exterior: Option<Named<T>>,
    #[serde(alias = "interior_modifier", alias = "interior_construction")]
    pub interior: Option<Named<T>>,
    #[serde(alias = "ground_construction")]
    pub ground: Option<Named<T>>,
    #[serde(alias = "window_modifier", alias = "window_construction")]
    pub window: Option<Named<T>>,
    #[serde(alias = "skylight_modifier", alias = "skylight_construction")]
    pub skylight: Option<Named<T>>,
    #[serde(alias = "operable_modifier", alias = "operable_construction")]
    pub operable: Option<Named<T>>,
    #[serde(alias = "exterior_glass_modifier", alias = "exterior_glass_construction")]
    pub exterior_glass: Option<Named<T>>,
    #[serde(alias = "overhead_modifier", alias = "overhead_construction")]
    pub overhead: Option<Named<T>>,
}

/// A Radiance material of any type.
#[derive(Deserialize)]
pub(super) struct Modifier {
    #[serde(rename = "type")]
    pub kind: String,
    #[serde(default)]
    pub identifier: String,
    pub r_reflectance: Option<f64>,
    pub g_reflectance: Option<f64>,
    pub b_reflectance: Option<f64>,
    pub specularity: Option<f64>,
    pub roughness: Option<f64>,
    pub transmitted_diff: Option<f64>,
    pub front_diffuse_reflectance: Option<[f64; 3]>,
}

/// A construction of any type.
#[derive(Deserialize)]
pub(super) struct Construction {
    #[serde(rename = "type")]
    pub kind: String,
    #[serde(default)]
    pub identifier: String,
    /// Layers from the outside inwards; named `layers` before version 1.40 of the schema.
    #[serde(alias = "layers")]
    pub materials: Option<Vec<Named<Layer>>>,
    /// Solar reflectance; shades only, as the next two fields.
    pub solar_reflectance: Option<f64>,
    pub visible_reflectance: Option<f64>,
    pub is_specular: Option<bool>,
    /// Construction of a window without its shade.
    pub window_construction: Option<Box<Construction>>,
    /// States of a window that changes in the course of a year.
    pub constructions: Option<Vec<Construction>>,
}

/// A layer of a construction, of any type.
#[derive(Deserialize)]
pub(super) struct Layer {
    #[serde(rename = "type")]
    pub kind: String,
    #[serde(default)]
    pub identifier: String,
    pub solar_absorptance: Option<f64>,
    pub visible_absorptance: Option<f64>,
    pub leaf_reflectivity: Option<f64>,
    pub u_factor: Option<f64>,
}

/// A schedule of days, or of consecutive values.
#[derive(Deserialize)]
pub(super) struct Schedule {
    #[serde(default)]
    pub identifier: String,
    pub day_schedules: Option<Vec<Day>>,
    pub values: Option<Vec<f64>>,
}

#[derive(Deserialize)]
pub(super) struct Day {
    pub values: Vec<f64>,
}
