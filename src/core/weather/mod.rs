//! Weather: series of conditions and the sun above them. In: bytes of weather files. Out: checked
//! rows, conditions with the sun's position, and findings about doubtful data. Never: layers,
//! reflectances, results.

pub mod air;
pub mod clear;
pub mod closure;
pub mod conditions;
pub mod dated;
pub mod distance;
pub mod emission;
mod erbs;
pub mod findings;
pub mod formats;
mod judging;
pub mod monthly;
pub mod options;
pub mod row;
pub mod series;
pub mod span;
pub mod temperatures;
pub mod time;
