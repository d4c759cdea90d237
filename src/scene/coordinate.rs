//! Which numbers are taken for positions.

use glam::DVec3;

/// Largest coordinate that is taken for a position in metres and not for an accident.
pub(crate) const MAX_COORDINATE_M: f64 = 1e9;

/// Whether a position may be one on Earth: finite and of metres.
pub(crate) fn is_position(position: DVec3) -> bool {
    // NaN compares false.
    position.to_array().iter().all(|metres| metres.abs() <= MAX_COORDINATE_M)
}
