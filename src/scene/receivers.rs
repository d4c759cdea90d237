//! Receivers.

use glam::DVec3;

/// A point and its unit normal that gets irradiance.
#[derive(Clone, Debug, PartialEq)]
pub struct Receiver {
    pub id: String,
    /// Input coordinates, metres.
    pub position: DVec3,
    /// Unit length.
    pub normal: DVec3,
    /// m2, > 0 where given.
    pub area: Option<f64>,
    pub surface: Option<String>,
}
