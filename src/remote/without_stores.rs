//! Stand-ins for stores in a program that is built without the feature `remote`. In: addresses.
//! Out: errors that say how to build with it.

use std::path::Path;

use crate::naming::{Copied, is_address, shown};
use heliotile_core::error::{Error, Result};
use heliotile_core::observer::Observer;

fn refuse<T>(place: &Path) -> Result<T> {
    let what = "is an address, but this heliotile was built without support for addresses";
    Err(Error::input(
        &shown(place),
        None,
        what,
        "build heliotile with support for them: cargo build --locked --release --features remote",
    ))
}

/// Refuses to open an object.
pub fn hold(place: &Path, _: bool) -> Result<Vec<u8>> {
    refuse(place)
}

/// Refuses to look for an object.
pub fn find(place: &Path, _: bool, _: bool) -> Result<Option<Vec<u8>>> {
    refuse(place)
}

/// Refuses to ask if an object exists.
pub fn exists(place: &Path) -> Result<bool> {
    refuse(place)
}

/// Refuses to list names.
pub fn names_below(place: &Path) -> Result<Option<Vec<String>>> {
    refuse(place)
}

/// Refuses an address to be written to.
pub fn check_writable(place: &Path) -> Result<()> {
    refuse(place)
}

/// Refuses to copy.
pub fn copy(from: &Path, to: &Path, _: bool, _: &dyn Observer) -> Result<Copied> {
    refuse(if is_address(from) { from } else { to })
}

/// Returns `None`: no requests are made.
pub fn traffic() -> Option<String> {
    None
}

#[cfg(test)]
mod tests {
    use heliotile_core::observer::Silent;

    use super::*;

    /// A program without stores refuses an address that is read, copied from, copied to or written
    /// to, 7 ways. Each message says how to build a program that takes it and leaves the signature
    /// out. 0 requests are counted.
    #[test]
    fn a_build_without_stores_refuses_addresses() {
        let (address, file) = (Path::new("https://me:secret@host/site.helio?sig=secret"), Path::new("a.helio"));
        let copied = [(address, file), (file, address)].map(|(from, to)| copy(from, to, false, &Silent).err());
        let looked = [
            hold(address, true).err(),
            find(address, true, true).err(),
            exists(address).err(),
            names_below(address).err(),
            check_writable(address).err(),
        ];
        let told: Vec<String> = looked.into_iter().chain(copied).flatten().map(|e| e.to_string()).collect();
        assert_eq!(told.len(), 7);
        for text in told {
            assert!(text.contains("https://host/site.helio: is an address"), "{text}");
            assert!(text.contains("cargo build --locked --release --features remote"), "{text}");
            assert!(!text.contains("secret"), "{text}");
        }
        assert_eq!(traffic(), None);
    }
}
