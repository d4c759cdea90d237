//! Weather files. In: their bytes. Out: checked rows, series of conditions, and findings about
//! doubtful data; skies from tables and matrices.

#![deny(missing_docs)]

pub mod closure;
pub mod dated;
pub mod distance;
mod erbs;
pub mod findings;
pub mod formats;
mod joined;
mod judging;
pub mod monthly;
pub mod series;
pub mod skies;
pub mod temperatures;
