//! Places on Earth. In: coordinate reference systems by their EPSG numbers. Out: latitude,
//! longitude and the direction of true north.

#![deny(missing_docs)]

pub mod epsg_numbers;
pub mod reference;
