//! Object stores and web servers: archives read by ranges, published whole.
//!
//! # Map
//!
//! Rooms from left to right; none imports one to its right.
//!
//! ```text
//! address failure traffic cache | store | object | listing opening spans | ahead | remote_file | publish download
//! ```
//!
//! | room | in | out |
//! | --- | --- | --- |
//! | [`address`] | the text that a user typed | an address, and its name without secrets |
//! | [`failure`] | the answer of a store | the finding and a remedy |
//! | [`cache`] | blocks with their checksums | their bytes from this machine's disk |
//! | [`store`] | an address, the environment | a connection |
//! | [`object`] | a connection | ranges of one object that has not changed since it was opened |
//! | [`listing`] | addresses | which of them are objects, and names below them |
//! | [`remote_file`] | an address | [`ReadAt`](heliotile_core::archive::ReadAt): announced blocks arrive together, many at a time |
//! | [`publish`] | a file | a whole object that no other program wrote meanwhile |
//! | [`download`] | an object | a whole file |

pub mod address;
mod ahead;
pub mod cache;
pub mod download;
pub mod failure;
#[cfg(test)]
mod liar_tests;
pub mod listing;
pub mod object;
mod opening;
pub mod publish;
pub mod remote_file;
mod spans;
pub mod store;
pub mod traffic;

pub use address::Address;
pub use cache::Cache;
pub use remote_file::RemoteFile;
pub use store::Connection;
