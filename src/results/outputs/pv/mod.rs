//! Outputs of `pv`: sums a point and side, months, sums on the ground, hours in the names of pvlib, horizons as PVGIS has them, turns that were
//! tried. In: values in kWh/m2 or W/m2. Out: files, each complete or not there.

pub mod ground;
pub mod horizon;
pub mod hourly;
pub mod places;
pub mod polar;
pub mod search;
pub mod sums;
