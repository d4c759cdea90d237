//! Outputs of `pv`: sums a point and side, months, energy, sums on the ground, hours in the names
//! of pvlib, horizons in PVGIS's format, shade in the layouts of other programs, and the
//! orientations that a search tried. In: values in kWh/m2 or W/m2. Out: files, each complete or
//! not there.

pub mod energy;
pub mod ground;
pub mod horizon;
pub mod hourly;
pub mod places;
pub mod polar;
pub mod search;
pub mod shade;
pub mod sums;
