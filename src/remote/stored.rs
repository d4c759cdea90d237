//! Archives in stores and on web servers, as the environment says. In: addresses. Out: their bytes; copies from there and to there.

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

/// Folder of the cache, or `off`.
const CACHE: &str = "HELIOTILE_CACHE";
/// What it may take, such as `500MB`.
const CACHE_SIZE: &str = "HELIOTILE_CACHE_SIZE";
/// Seconds that one request may take.
const TIMEOUT: &str = "HELIOTILE_TIMEOUT";

/// What the cache may take, unless the environment says otherwise.
const USUAL_SIZE: Bytes = Bytes(2_000_000_000);

/// Longest and shortest time that may be asked for, s.
const TIMES_S: std::ops::RangeInclusive<f64> = 0.1..=3600.0;

/// The object of an address, open; `kept`: its blocks may come from the cache, and go there.
pub fn hold(place: &Path, kept: bool) -> Result<RemoteFile> {
    let address = Address::parse(place)?;
    RemoteFile::open(&address, connection()?, if kept { cache()? } else { None })
}

/// The same where nothing may be there; `sure`: what may not be read is an error, and not taken for nothing.
pub fn find(place: &Path, kept: bool, sure: bool) -> Result<Option<RemoteFile>> {
    let absent = if sure { Failure::is_absence } else { Failure::may_be_absence };
    RemoteFile::find(&Address::parse(place)?, connection()?, if kept { cache()? } else { None }, absent)
}

/// Whether an object is there.
pub fn exists(place: &Path) -> Result<bool> {
    listing::exists(&Address::parse(place)?, connection()?)
}

/// Names of what lies below an address; none where nobody says.
pub fn names_below(place: &Path) -> Result<Option<Vec<String>>> {
    listing::names_below(&Address::parse_folder(place)?, connection()?)
}

/// Refuses an address that nothing can be written to.
pub fn check_writable(place: &Path) -> Result<()> {
    check_target(&Address::parse(place)?)
}

/// What was asked of stores so far, in words; none if nothing was.
pub fn traffic() -> Option<String> {
    let traffic = so_far();
    let [received, cached] = [traffic.received, traffic.cached].map(|bytes| bytes as f64 / 1e6);
    let requests = counted(traffic.requests, "request");
    (traffic.requests > 0).then(|| format!("{requests}, {received:.2} MB received, {cached:.2} MB from the cache"))
}

pub(crate) fn connection() -> Result<Connection> {
    let Some(text) = variable(TIMEOUT) else { return Ok(Connection::default()) };
    let seconds = text.parse().ok().filter(|seconds| TIMES_S.contains(seconds));
    let refuse =
        || Error::argument(TIMEOUT, format!("`{text}` is no time"), "give seconds from 0.1 to 3600, such as 60");
    Ok(Connection { timeout: Duration::from_secs_f64(seconds.ok_or_else(refuse)?) })
}

/// The cache that the environment asks for; a usual one that cannot be made is done without.
fn cache() -> Result<Option<Cache>> {
    let asked = variable(CACHE);
    let size = match variable(CACHE_SIZE) {
        Some(text) => {
            text.parse().map_err(|what: String| Error::argument(CACHE_SIZE, what, "such as 2GB; 0MB for none"))?
        }
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

/// A variable that says something.
fn variable(name: &str) -> Option<String> {
    env::var(name).ok().filter(|value| !value.is_empty())
}

/// Where programs of this system keep what they can fetch again.
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
