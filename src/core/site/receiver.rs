//! Receivers: points that get irradiance, and the number of them in a tile.

use glam::DVec3;

use crate::site::model_part::ModelPart;
use crate::site::patch::Patch;

/// Receivers of one tile: neighbours along the Morton curve that share compressed blocks.
pub const TILE: usize = 64;

/// Point that gets irradiance, with its unit normal.
#[derive(Clone, Debug, PartialEq)]
pub struct Receiver {
    /// Name in results, unique in an archive.
    pub id: String,
    /// Position in input coordinates, metres.
    pub position: DVec3,
    /// Normal of unit length.
    pub normal: DVec3,
    /// Area, m2, > 0 where given.
    pub area: Option<f64>,
    /// Name of the surface that it stands for, if it has one.
    pub surface: Option<String>,
    /// Part of the model that it stands for.
    pub part: ModelPart,
    /// Part of its surface that it stands for; empty if unknown.
    pub patch: Patch,
}

impl Receiver {
    /// Returns a receiver with a name, a position and a unit normal only.
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

/// Length of the longest name that an archive holds, bytes.
pub const MAX_NAME_BYTES: usize = 1024;
