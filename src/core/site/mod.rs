//! The nouns of a site: cells, materials, bands of sunlight, the ground by month, receivers and
//! their parts of a model, objects, chains of mirrors, the place and its north. In: numbers of
//! readers and of archives. Out: types that the builder and the replay share. Never: files, rays,
//! weather.

pub mod bands;
pub mod cells;
pub mod chain;
pub mod content;
pub mod crossing;
pub mod grid;
pub mod ground;
pub mod material;
pub mod model_part;
pub mod morton;
pub mod north;
pub mod ordered;
pub mod patch;
pub mod place;
pub mod receiver;
pub mod scene_object;
pub mod semantics;
