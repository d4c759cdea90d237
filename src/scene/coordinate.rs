//! Range of coordinates. In: a position. Out: true if it can be one in metres.

use glam::DVec3;

/// Largest coordinate that is accepted as a position in metres; larger ones are accidents.
pub(crate) const MAX_COORDINATE_M: f64 = 1e9;

/// Returns true if a position is finite and at most [`MAX_COORDINATE_M`] in size.
pub(crate) fn is_position(position: DVec3) -> bool {
    // NaN compares false.
    position.to_array().iter().all(|metres| metres.abs() <= MAX_COORDINATE_M)
}
