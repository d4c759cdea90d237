//! Outdoor thermal comfort: the effect of air, wind, humidity and radiation on a person. In:
//! numbers of one place and moment. Out: mean radiant temperature, UTCI, PET, solar gain.
//!
//! | file | content |
//! | --- | --- |
//! | `mean_radiant` | mean radiant temperature from irradiance of six directions, and of a sun on a cylinder |
//! | `utci` | Universal Thermal Climate Index and its ten stress categories |
//! | `utci_polynomial` | the 210 published coefficients of the UTCI |
//! | `pet` | Physiological Equivalent Temperature |
//! | `pet_balance`, `pet_body` | heat balance of a person behind the PET |
//! | `clear_sky` | decrease of a clear sky's longwave radiance towards the zenith |
//! | `surroundings` | longwave irradiance of six planes from sky, ground and obstructions |
//! | `index_curve` | an index of an hour at many places |
//! | `people` | points of an archive: their planes, the climate of an hour, their values |
//! | `humidity` | saturation pressure and vapour pressure of water |
//! | `wind` | wind at the height of a body |
//! | `bracketed_root` | root of a function of one variable |
//!
//! Temperatures are in degrees Celsius, irradiance in W/m2, wind in m/s, pressures in hPa, relative
//! humidity in percent. A function returns `None` where an input is missing (NaN), infinite or
//! outside the range of its formula. It never returns NaN.
//!
//! Nothing here reads files, opens archives, or keeps state.

mod bracketed_root;
pub mod clear_sky;
pub mod humidity;
pub mod index_curve;
pub mod mean_radiant;
pub mod people;
pub mod pet;
mod pet_balance;
mod pet_body;
pub mod surroundings;
pub mod utci;
mod utci_polynomial;
#[cfg(test)]
mod validation_tests;
pub mod wind;
