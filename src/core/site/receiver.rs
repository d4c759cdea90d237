//! A point that gets irradiance, and how many of them stand together.

use glam::DVec3;

use crate::site::model_part::ModelPart;
use crate::site::patch::Patch;

/// Receivers of one tile: neighbours along the Morton curve that share compressed blocks.
pub const TILE: usize = 64;

/// A point and its unit normal that gets irradiance.
#[derive(Clone, Debug, PartialEq)]
pub struct Receiver {
    /// Name in results; no two receivers of an archive have one.
    pub id: String,
    /// Input coordinates, metres.
    pub position: DVec3,
    /// Unit length.
    pub normal: DVec3,
    /// m2, > 0 where given.
    pub area: Option<f64>,
    /// Name of the surface that it stands for, if it has one.
    pub surface: Option<String>,
    /// What of the model it stands for.
    pub part: ModelPart,
    /// The part of its surface that it stands for, if anyone says.
    pub patch: Patch,
}

impl Receiver {
    /// One of which only the place is known; `normal` is of unit length.
    pub fn new(id: String, position: DVec3, normal: DVec3) -> Self {
        Receiver {
            id,
            position,
            normal,
            area: None,
            surface: None,
            part: ModelPart::default(),
            patch: Patch::default(),
        }
    }
}

/// Longest name that an archive holds.
pub const MAX_NAME_BYTES: usize = 1024;
