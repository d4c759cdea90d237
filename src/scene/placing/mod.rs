//! Place of a scene and checks of it. In: the statements of files and of the user, and the extent
//! of the geometry. Out: the place, and warnings about geometry that looks as if it were in another
//! unit or place. This module knows neither files nor materials.

pub(crate) mod axis_order;
pub mod extent;
pub mod frame;
pub(crate) mod from_degrees;
pub mod plausible;
#[cfg(test)]
mod tests;
pub mod whereabouts;
pub(crate) mod y_up;
