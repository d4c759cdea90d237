//! Places of files: paths, and addresses of archives in object stores and on web servers.
//!
//! # Map
//!
//! | room | in | out |
//! | --- | --- | --- |
//! | [`naming`] | a path or an address | which of the two it is, the name that messages give it |
//! | [`places`] | a path or an address | the archive there, its bytes |
//! | [`directory`] | a folder or an address below which objects lie | which files are there, and what small ones hold |
//! | `stores` (feature `stores`) | an address | ranges of an object, all of one version; objects that are published whole |
//!
//! # What never happens
//!
//! - Bytes of two versions of an object are never mixed: every answer is of the version that was
//!   opened, or an error.
//! - Bytes from the cache are never served unchecked.
//! - No password, signature or key stands in a message or in a cache.
//! - No wait is endless: every request and every wait has a time limit.
//! - Nothing is printed; tokio stays inside.
//!
//! Without the feature `stores`, which brings some 130 packages, addresses are refused with a hint
//! how to build with it.

#![deny(missing_docs)]

#[cfg(feature = "stores")]
mod copying;
pub mod directory;
pub mod naming;
pub mod places;
#[cfg(feature = "stores")]
mod stored;
#[cfg(feature = "stores")]
pub mod stores;
#[cfg(any(test, not(feature = "stores")))]
mod without_stores;

#[cfg(not(feature = "stores"))]
use without_stores as stored;

#[cfg(feature = "stores")]
pub use copying::copy;
pub use directory::Directory;
pub use naming::{Copied, is_address, shown};
pub use places::{open_archive, verify_archive};
pub use stored::{check_writable, traffic};
#[cfg(not(feature = "stores"))]
pub use without_stores::copy;
