//! In: the JSON text of a Honeybee model. Out: its properties that describe surfaces, their kinds
//! and their materials, typed but unchecked; everything else is skipped. Names are those of
//! honeybee-schema 2.3.

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::formats::honeybee::properties::{ModelProperties, ObjectProperties, RoomProperties};

#[derive(Deserialize)]
pub(super) struct Model {
    #[serde(rename = "type")]
    pub kind: String,
    #[serde(default)]
    pub identifier: String,
    #[serde(default)]
    pub units: Units,
    /// Tolerance, in units of the model.
    pub tolerance: Option<f64>,
    pub rooms: Option<Vec<Room>>,
    pub orphaned_faces: Option<Vec<Face>>,
    pub orphaned_apertures: Option<Vec<Opening>>,
    pub orphaned_doors: Option<Vec<Opening>>,
    pub orphaned_shades: Option<Vec<Shade>>,
    pub shade_meshes: Option<Vec<ShadeMesh>>,
    #[serde(default)]
    pub properties: ModelProperties,
    /// Present in Dragonfly models, whose type has the same name.
    pub buildings: Option<IgnoredAny>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
pub(super) enum Units {
    #[default]
    Meters,
    Millimeters,
    Centimeters,
    Feet,
    Inches,
}

impl Units {
    /// Returns the length of a unit in metres; foot and inch are the international ones of 1959.
    pub(super) fn metres(self) -> f64 {
        match self {
            Units::Meters => 1.0,
            Units::Millimeters => 1e-3,
            Units::Centimeters => 1e-2,
            Units::Feet => 0.3048,
            Units::Inches => 0.0254,
        }
    }
}

#[derive(Deserialize)]
pub(super) struct Room {
    pub identifier: String,
    pub faces: Vec<Face>,
    pub outdoor_shades: Option<Vec<Shade>>,
    pub indoor_shades: Option<Vec<IgnoredAny>>,
    pub multiplier: Option<f64>,
    #[serde(default)]
    pub properties: RoomProperties,
}

#[derive(Deserialize)]
pub(super) struct Face {
    pub identifier: String,
    pub geometry: Face3D,
    pub face_type: FaceType,
    pub boundary_condition: BoundaryCondition,
    pub apertures: Option<Vec<Opening>>,
    pub doors: Option<Vec<Opening>>,
    pub outdoor_shades: Option<Vec<Shade>>,
    pub indoor_shades: Option<Vec<IgnoredAny>>,
    #[serde(default)]
    pub properties: ObjectProperties,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub(super) enum FaceType {
    Wall,
    RoofCeiling,
    Floor,
    AirBoundary,
}

#[derive(Deserialize)]
pub(super) struct BoundaryCondition {
    #[serde(rename = "type")]
    pub kind: Boundary,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub(super) enum Boundary {
    Outdoors,
    Ground,
    Surface,
    Adiabatic,
    /// Another temperature outside: the face is part of the hull.
    OtherSideTemperature,
}

/// A window or a door.
#[derive(Deserialize)]
pub(super) struct Opening {
    pub identifier: String,
    pub geometry: Face3D,
    pub boundary_condition: BoundaryCondition,
    /// True if a window can be opened.
    #[serde(default)]
    pub is_operable: bool,
    /// True if a door is of glass.
    #[serde(default)]
    pub is_glass: bool,
    pub outdoor_shades: Option<Vec<Shade>>,
    pub indoor_shades: Option<Vec<IgnoredAny>>,
    #[serde(default)]
    pub properties: ObjectProperties,
}

#[derive(Deserialize)]
pub(super) struct Shade {
    pub identifier: String,
    pub geometry: Face3D,
    #[serde(default)]
    pub is_detached: bool,
    #[serde(default)]
    pub properties: ObjectProperties,
}

#[derive(Deserialize)]
pub(super) struct ShadeMesh {
    pub identifier: String,
    pub geometry: Mesh3D,
    #[serde(default = "detached")]
    pub is_detached: bool,
    #[serde(default)]
    pub properties: ObjectProperties,
}

fn detached() -> bool {
    true
}

#[derive(Deserialize)]
pub(super) struct Face3D {
    pub boundary: Vec<[f64; 3]>,
    pub holes: Option<Vec<Vec<[f64; 3]>>>,
    pub plane: Option<Plane>,
}

#[derive(Deserialize)]
pub(super) struct Plane {
    /// Normal of the plane.
    pub n: [f64; 3],
}

#[derive(Deserialize)]
pub(super) struct Mesh3D {
    pub vertices: Vec<[f64; 3]>,
    /// Faces of three or four vertex indices each.
    pub faces: Vec<Vec<u64>>,
}
