//! A region in parts. An atlas is a folder, here or in a store, with the plan and a folder for each part that is built; it is asked like one
//! archive.
//!
//! # Map
//!
//! | room | in | out |
//! | --- | --- | --- |
//! | [`plan`] | how a region is to be cut, where objects lie | `atlas.json`: parts with their places, and the site of each |
//! | [`partition`] | scene files, however many | a plan, and what the halo costs |
//! | [`part`] | an atlas, a part | its receivers and its archive |
//! | [`opened`], [`listed`] | the place of an atlas | its plan, the state of its parts, their archives |
//! | [`sources`] | the place of an archive or of an atlas, a box | the archives that results are made of |
//! | `site_request` | the place of an archive or of an atlas, requests | files of results |
//! | `verify` | the place of an archive or of an atlas | what is damaged |
//! | `export` | a receiver, or all of them | pictures and values of its layers; view factors |
//! | [`catalogue`] | an atlas | a static STAC catalogue with pictures and a page |
//! | [`copied`] | an atlas, a place | the same atlas there |
//! | [`about`] | an atlas | what it holds, as text |
//!
//! # What never happens
//!
//! - Nothing is printed: an [`Observer`](heliotile_core::observer::Observer) is told.
//! - A part depends on the plan and the files near it only, whoever builds it and wherever.

#![deny(missing_docs)]

pub mod about;
pub mod catalogue;
pub mod copied;
mod export;
pub mod listed;
pub mod opened;
pub mod page;
pub mod part;
pub mod partition;
pub mod plan;
pub mod seam_trial;
pub mod seams;
mod site_request;
pub mod sources;
pub mod state;
mod thumbnails;
mod verify;

pub use export::{ExportRequest, SunPosition};
pub use listed::{ListedPart, parts};
pub use opened::Atlas;
pub use plan::AtlasPlan;
pub use site_request::{ReceiverTotal, SiteRequest};
pub use state::PartState;
pub use verify::{CheckedArchive, VerifyRequest};
