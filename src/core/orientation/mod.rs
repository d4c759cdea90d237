//! How a surface is best turned. In: limits of tilt and azimuth, what some turns get. Out: turns to try, and the best one, by a fit through
//! what was found. It knows nothing of receivers, archives or weather: degrees by true north, and values of any unit.

pub mod best;
pub mod fan;
