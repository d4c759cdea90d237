//! Recombine: layers of an archive and the weather of an hour become irradiance. In: an archive, `conditions.csv` or an EPW
//! file, the choice of a sky. Out: six components and their total for every receiver and condition, and longwave irradiance where
//! it is asked for. It never casts a ray: nothing here imports the trace stage.

pub mod air;
pub mod bins;
pub mod bounces;
pub mod calendar;
pub mod canopies;
pub mod closure;
pub mod components;
pub mod conditions;
pub mod disc;
pub mod epw;
pub mod erbs;
pub mod findings;
pub mod fresnel;
pub mod load;
pub mod longwave;
pub mod maps;
pub mod mirrors;
pub mod patches;
pub mod perez;
pub mod projection;
pub mod receiver_view;
pub mod reflectances;
pub mod replay;
pub mod responder;
pub mod response;
mod schedule_csv;
mod scratch;
pub mod shaded;
pub mod skies;
pub mod sky;
mod slots;
pub mod sources;
pub mod span;
pub mod specular;
pub mod states;
pub mod sun;
pub mod sun_path;
pub mod suns;
pub mod temperatures;
pub mod tile;
pub mod values;
pub mod weather;
pub mod years;
