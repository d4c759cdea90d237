//! Weather: conditions and the sun above them. In: rows, times, places. Out: conditions with the
//! sun's position. Never: weather files, layers, reflectances, results.

pub mod air;
pub mod clear;
pub mod conditions;
pub mod emission;
pub mod options;
pub mod row;
pub mod span;
pub mod time;
