//! The best orientation of a surface. In: limits of tilt and azimuth, values of some orientations.
//! Out: orientations to try, and the best one, by a fit through the values. It knows nothing of
//! receivers, archives or weather: degrees by true north, and values of any unit.

pub mod best;
pub mod fan;
