//! Traces a scene's receivers once and writes their archive.
//!
//! # Map
//!
//! ```text
//! settings spill receiver_tiles held | trace | writing pack | pipeline | accuracy | planning | judge siting | transfer store study
//! ```
//!
//! | room | in | out |
//! | --- | --- | --- |
//! | [`settings`] | a quality, names and numbers | numbers in range |
//! | [`trace`] | a mesh, points to look from | raw hemispheres: sky bits, cells that are seen; the only place where rays are cast |
//! | [`writing`] | encoded blocks | an archive, whole or not there, which an interrupted build goes on with |
//! | [`pipeline`] | a prepared scene, receivers | a plan with its forecast, then an archive |
//! | [`accuracy`] | a target in percent | the cheapest settings that keep within it |
//! | [`planning`] | what is wished, weather | settings, effects that may be left out, and what they rest on |
//! | [`judge`] | a prepared scene, a receiver, suns and skies | what it gets, by paths of light and with a standard error: no texture, cell or patch |
//! | [`siting`] | a prepared scene, points in it | what lies below a point, whether it is inside something, its horizon |
//! | [`held`] | an archive | the triangles, materials and objects that it was traced of |
//! | [`transfer`] | archives | parts, unions and differences of them, without a ray |
//! | [`store`] | finished archives | those that a build can look things up in |
//!
//! # What never happens
//!
//! - Nothing is printed and no command line is known: an [`Observer`](heliotile_core::observer::Observer) is told, and asked whether to stop.
//! - A cell depends on the scene and its key only, never on who asked first, on threads or on the order of tiles: equal inputs give equal
//!   bytes, and parts of a site fit together.
//! - After a failed sync nothing more is written.
//!
//! # Ten words
//!
//! - **prepared scene**: a scene with its tree of boxes, its mirrors and canopies.
//! - **packet**: sixteen rays that go through the tree together.
//! - **viewpoint**: a receiver's place and normal, where its rays start.
//! - **surroundings**: the cells that a probe or bounce cell sees.
//! - **plan**: the settings of a build and the forecast they rest on; **effect**: a kind of light path that may be left out.
//! - **rung**: one step of the ladder of a source of error.
//! - **pilot**: some receivers built with several settings, to choose among them.
//! - **checkpoint**: what is on the disk from then on, whatever happens.
//! - **journal**: the list of checkpoints beside an archive that is not finished.
//! - **spill**: sorting with temporary files what memory does not hold.

#![deny(missing_docs)]

pub mod accuracy;
pub mod held;
pub mod judge;
pub mod pack;
pub mod pipeline;
pub mod planning;
pub mod receiver_tiles;
pub mod settings;
pub mod siting;
pub mod spill;
pub mod store;
pub mod study;
pub mod trace;
pub mod transfer;
pub mod writing;
