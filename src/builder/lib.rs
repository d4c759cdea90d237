//! Traces a scene's receivers once; [`heliotile_archives`] writes their archive.
//!
//! # Map
//!
//! ```text
//! settings receiver_tiles held | trace | pipeline | accuracy | planning
//! | reference siting
//! ```
//!
//! | module | in | out |
//! | --- | --- | --- |
//! | [`settings`] | a quality, names and numbers | numbers in range |
//! | [`trace`] | a mesh, points to look from | raw hemispheres: sky bits and the cells that are seen; the only module that casts rays |
//! | [`pipeline`] | a prepared scene, receivers | a plan with its forecast, then an archive |
//! | [`accuracy`] | a target in percent | the cheapest settings that keep within it |
//! | [`planning`] | a request, weather | settings, effects that may be left out, and the estimates behind both |
//! | [`mod@reference`] | a prepared scene, a receiver, suns and skies | irradiance from the reference path tracer, with a standard error: no texture, cell or patch |
//! | [`siting`] | a prepared scene, points in it | the ground below a point, a test whether it is inside a solid, its horizon |
//! | [`held`] | an archive | the triangles, materials, objects and receivers that it was traced from |
//!
//! # What never happens
//!
//! - The engine prints nothing and knows no command line: it reports to an
//!   [`Observer`](heliotile_core::observer::Observer), which can also stop it.
//! - A cell depends only on the scene and its key, never on threads, on the order of tiles or on
//!   which receiver saw it first: equal inputs give equal bytes, and parts of a site fit together.
//! - After a failed sync nothing more is written.
//!
//! # Eleven words
//!
//! - **prepared scene**: a scene with its bounding volume hierarchy, mirrors and canopies.
//! - **packet**: sixteen rays that traverse the hierarchy together.
//! - **viewpoint**: position and normal of a receiver, where its rays start.
//! - **surroundings**: the cells that a probe or bounce cell sees.
//! - **plan**: the settings of a build and the forecast behind them; **effect**: a kind of light
//!   path that a build may leave out.
//! - **rung**: one step of the accuracy ladder of a source of error.
//! - **pilot**: a sample of receivers built with several settings, to choose among them.
//! - **checkpoint**: a state of the file that stays on the disk even if the power fails.
//! - **journal**: the list of checkpoints beside an unfinished archive.
//! - **spill**: sorting with temporary files when the records do not fit in memory.

#![deny(missing_docs)]

pub mod accuracy;
pub mod held;
pub mod pipeline;
pub mod planning;
pub mod receiver_tiles;
pub mod reference;
pub mod settings;
pub mod siting;
pub mod trace;
