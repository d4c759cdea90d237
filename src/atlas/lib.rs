//! A region in parts. An atlas is a folder, local or in a store, with the plan and a folder for
//! each part that is built. It is queried like one archive.
//!
//! # Map
//!
//! | room | in | out |
//! | --- | --- | --- |
//! | [`plan`] | how a region is to be cut, where objects lie | `atlas.json`: parts with their places, and the site of each |
//! | [`partition`] | scene files, however many | a plan, and what the halo costs |
//! | [`part`] | an atlas, a part | its receivers and its archive |
//! | [`opened`], [`listed`] | the place of an atlas | its plan, the state of its parts, their archives |
//! | [`sources`] | the place of an archive or of an atlas, a box | the archives that results are computed from |
//! | `verify` | the place of an archive or of an atlas | the damaged blocks |
//! | `export` | a receiver, or all of them | pictures and values of its layers; view factors |
//! | [`catalogue`] | an atlas | a static STAC catalogue with pictures and a page |
//! | [`copied`] | an atlas, a place | a copy of the atlas at that place |
//! | [`about`] | an atlas | a summary as text |
//!
//! # What never happens
//!
//! - Nothing is printed: messages go to an [`Observer`](heliotile_core::observer::Observer).
//! - A part depends only on the plan and the files near it, not on who builds it or where.

#![deny(missing_docs)]

pub mod about;
pub mod catalogue;
pub mod copied;
mod export;
pub mod listed;
pub mod opened;
pub mod part;
pub mod partition;
pub mod plan;
pub mod seam_trial;
pub mod seams;
pub mod sources;
pub mod state;
mod thumbnails;
mod verify;

pub use export::{ExportRequest, SunPosition};
pub use listed::{ListedPart, parts};
pub use opened::Atlas;
pub use plan::AtlasPlan;
pub use state::PartState;
pub use verify::{CheckedArchive, VerifyRequest};
