//! Light that arrives by way of surfaces. In: layers and tables of an archive, reflectances. Out:
//! responses, one vector per sky texel. Never: weather of an hour, rays.

pub mod canopies;
pub mod fresnel;
pub mod mirrors;
pub mod paths;
pub mod radiosity;
pub mod reflector;
pub mod response;
pub mod response_solver;
pub mod scratch;
mod slots;
pub mod states;
pub mod tables;
pub mod tile_view;
