//! Archives as files, without casting a ray.
//!
//! | module | in | out |
//! | --- | --- | --- |
//! | [`writing`] | encoded blocks | an archive, complete or absent; an interrupted build can resume |
//! | [`pack`] | tables of a site | encoded blocks |
//! | [`transfer`] | archives | parts, unions and differences of archives |
//! | [`receiver_ids`] | a CSV file | ids of receivers |

#![deny(missing_docs)]

pub mod pack;
pub mod receiver_ids;
pub mod transfer;
mod workspace;
pub mod writing;

pub use workspace::Workspace;
