//! Scene: checked geometry, materials and receivers. In: files of the user. Out: types that can only hold checked values.
//! It never casts a ray and knows nothing of archives.

pub mod materials;
pub mod mesh;
pub mod receivers;
