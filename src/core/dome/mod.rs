//! The sky in patches, as files give it. In: bytes of tables and matrices, pixels of photographs.
//! Out: values of patches, radiances or transmittances, by row, on any subdivision. Never: models
//! of the sky, suns, receivers.

pub mod grid;
pub mod image;
pub mod series;
