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
//! | [`address`] | what a user typed | an address, and its name without what must not be told |
//! | [`failure`] | what a store answered | what was found and what to do |
//! | [`cache`] | blocks with their checksums | the same from this machine's disk |
//! | [`store`] | an address, the environment | a connection |
//! | [`object`] | a connection | ranges of one object that has not changed since it was opened |
//! | [`listing`] | addresses | which of them are objects, and names below them |
//! | [`remote_file`] | an address | [`ReadAt`](heliotile_core::archive::ReadAt): blocks that were told of come together, many at a time |
//! | [`publish`] | a file | an object that is whole and that nobody else wrote meanwhile |
//! | [`download`] | an object | a file that is whole |

pub mod address;
mod ahead;
pub mod cache;
pub mod download;
pub mod failure;
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
