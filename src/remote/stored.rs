//! Archives in stores and on web servers, with the settings of the environment. In: addresses. Out:
//! their bytes; copies to and from them.

use std::env;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::stores::failure::Failure;
use crate::stores::listing;
use crate::stores::publish::check_target;
use crate::stores::traffic::so_far;
use crate::stores::{Address, Cache, Connection, RemoteFile};
use heliotile_core::error::{Error, Result};
use heliotile_core::text::counted;
use heliotile_core::units::Bytes;

/// Environment variable of the cache: its folder, or `off`.
const CACHE: &str = "HELIOTILE_CACHE";
/// Environment variable of the largest size of the cache, such as `500MB`.
const CACHE_SIZE: &str = "HELIOTILE_CACHE_SIZE";
/// Environment variable of the time limit of one request, seconds.
const TIMEOUT: &str = "HELIOTILE_TIMEOUT";

/// Largest size of the cache, unless the environment says otherwise.
const USUAL_SIZE: Bytes = Bytes(2_000_000_000);

/// Shortest and longest time limit that is accepted, seconds.
const TIMES_S: std::ops::RangeInclusive<f64> = 0.1..=3600.0;

/// Opens the object at an address. With `kept`, blocks may be read from the cache and are written
/// to it.
pub fn hold(place: &Path, kept: bool) -> Result<RemoteFile> {
    let address = Address::parse(place)?;
    RemoteFile::open(&address, connection()?, if kept { cache()? } else { None })
}

/// Opens the object at an address, or returns `None` if nothing is there. With `sure`, an object
/// that may not be read is an error; without it, it counts as absent.
pub fn find(place: &Path, kept: bool, sure: bool) -> Result<Option<RemoteFile>> {
    let absent = if sure { Failure::is_absence } else { Failure::may_be_absence };
    RemoteFile::find(&Address::parse(place)?, connection()?, if kept { cache()? } else { None }, absent)
}

/// Returns true if an object is at an address.
pub fn exists(place: &Path) -> Result<bool> {
    listing::exists(&Address::parse(place)?, connection()?)
}

/// Returns the names of the objects below an address, or `None` if the server gives no list.
pub fn names_below(place: &Path) -> Result<Option<Vec<String>>> {
    listing::names_below(&Address::parse_folder(place)?, connection()?)
}

/// Refuses an address that cannot be written to.
pub fn check_writable(place: &Path) -> Result<()> {
    check_target(&Address::parse(place)?)
}

/// Describes the requests to stores so far in words, or returns `None` if there were none.
pub fn traffic() -> Option<String> {
    let traffic = so_far();
    let [received, cached] = [traffic.received, traffic.cached].map(|bytes| bytes as f64 / 1e6);
    let requests = counted(traffic.requests, "request");
    (traffic.requests > 0).then(|| format!("{requests}, {received:.2} MB received, {cached:.2} MB from the cache"))
}

pub(crate) fn connection() -> Result<Connection> {
    let Some(text) = variable(TIMEOUT) else { return Ok(Connection::default()) };
    let seconds = text.parse().ok().filter(|seconds| TIMES_S.contains(seconds));
    let refuse = || {
        Error::argument(TIMEOUT, format!("`{text}` is not a time limit"), "give seconds from 0.1 to 3600, such as 60")
    };
    Ok(Connection { timeout: Duration::from_secs_f64(seconds.ok_or_else(refuse)?) })
}

/// Opens the cache that the environment asks for, or `None` if it is switched off. A default folder
/// that cannot be made is no error: the cache is left out.
fn cache() -> Result<Option<Cache>> {
    let asked = variable(CACHE);
    let size = match variable(CACHE_SIZE) {
        Some(text) => text.parse().map_err(|what: String| {
            Error::argument(CACHE_SIZE, what, "give a size such as 2GB, or 0MB for no cache")
        })?,
        None => USUAL_SIZE,
    };
    if size.0 == 0 || asked.as_deref() == Some("off") {
        return Ok(None);
    }
    match asked {
        Some(folder) => Cache::open(Path::new(&folder), size.0).map(Some),
        None => Ok(usual_folder().and_then(|folder| Cache::open(&folder, size.0).ok())),
    }
}

/// Returns the value of an environment variable that is set and not empty.
fn variable(name: &str) -> Option<String> {
    env::var(name).ok().filter(|value| !value.is_empty())
}

/// Returns the folder where programs of this system keep data that they can fetch again.
fn usual_folder() -> Option<PathBuf> {
    let absolute = |name: &str| variable(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let home = || env::home_dir().filter(|home| home.is_absolute());
    let folder = match () {
        () if cfg!(windows) => absolute("LOCALAPPDATA"),
        () if cfg!(target_os = "macos") => home().map(|home| home.join("Library").join("Caches")),
        () => absolute("XDG_CACHE_HOME").or_else(|| Some(home()?.join(".cache"))),
    };
    folder.map(|folder| folder.join("heliotile"))
}
