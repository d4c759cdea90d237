//! Existence and names of objects, without their bytes. In: addresses. Out: which of them are
//! objects; names below one of them, where the store has lists.

use futures_util::TryStreamExt;
use heliotile_core::error::{Error, Result};

use crate::stores::address::{Address, Scheme};
use crate::stores::failure::{Cause, Failure};
use crate::stores::object::look;
use crate::stores::store::{Connection, Locator, runtime};
use crate::stores::traffic;

/// Names that a store gives in one page of a list.
const PAGE: u64 = 1000;

/// Returns true if an object is at an address.
pub fn exists(address: &Address, connection: Connection) -> Result<bool> {
    let place = Locator::connect(address, connection)?;
    let found = runtime()?.block_on(look(&place));
    found.map(|found| found.is_some()).map_err(|failure| failure.at(address))
}

/// Returns the names of the objects below an address, relative to it; `None` if a server has no
/// lists or does not show them to everybody.
pub fn names_below(address: &Address, connection: Connection) -> Result<Option<Vec<String>>> {
    if address.scheme() == Scheme::Web {
        return Ok(None);
    }
    let place = Locator::connect(address, connection)?;
    let name = |location: &object_store::path::Path| -> Option<String> {
        let parts: Vec<String> = location.prefix_match(&place.path)?.map(|part| part.as_ref().to_owned()).collect();
        Some(parts.join("/"))
    };
    let listed = place.store.list(Some(&place.path)).map_ok(|meta| name(&meta.location)).try_collect::<Vec<_>>();
    match runtime()?.block_on(listed).map_err(|error| Failure::from_store(&error)) {
        Ok(names) => {
            (0..(names.len() as u64).div_ceil(PAGE).max(1)).for_each(|_| traffic::asked());
            Ok(Some(names.into_iter().flatten().collect()))
        }
        Err(failure) if matches!(failure.cause, Cause::Denied | Cause::Refused) => Ok(None),
        Err(failure) => Err::<_, Error>(failure.at(address)),
    }
}
