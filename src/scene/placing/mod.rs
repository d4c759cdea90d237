//! Where a scene lies, and whether that can be meant. In: what files and the user say, and how far geometry reaches. Out: the place, and
//! sentences about what looks as if it were in another unit or place. Never: files, materials.

pub mod extent;
pub mod frame;
pub(crate) mod from_degrees;
pub mod plausible;
#[cfg(test)]
mod tests;
pub mod whereabouts;
