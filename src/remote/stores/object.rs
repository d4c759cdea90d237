//! One object as it was when it was opened. In: ranges. Out: their bytes, of that version; another
//! version is a failure.

use std::ops::Range;
use std::time::Instant;

use bytes::{Bytes, BytesMut};
use futures_util::StreamExt;
use object_store::{GetOptions, GetRange, GetResult, ObjectMeta, ObjectStoreExt};
use tokio::sync::{Semaphore, SemaphorePermit};

use crate::stores::failure::{Cause, Failure};
use crate::stores::store::Locator;
use crate::stores::traffic;

/// Times that a range is requested if its answer is cut off.
const ATTEMPTS: usize = 4;

/// Bytes of one of many requests for a long range.
pub const PART: u64 = 2 << 20;
/// Most such requests under way for one range.
const AT_ONCE: usize = 8;

/// Most requests under way in the whole process, over all objects: servers and systems limit
/// connections.
const ALL_AT_ONCE: usize = 64;
static TURNS: Semaphore = Semaphore::const_new(ALL_AT_ONCE);

/// Largest object that is read from a server without ranges, bytes.
pub const WHOLE_LIMIT: u64 = 50_000_000;

/// Marks that tell one version of an object from another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Version {
    /// ETag that the store gives; some servers give none.
    pub etag: Option<String>,
    /// Time of writing, ms since 1970, for objects without an ETag.
    modified_ms: i64,
    /// Length, bytes.
    pub length: u64,
}

impl Version {
    fn from_meta(meta: &ObjectMeta) -> Self {
        Version { etag: meta.e_tag.clone(), modified_ms: meta.last_modified.timestamp_millis(), length: meta.size }
    }

    /// Returns why `now` is another version, or `None` if it is the same.
    fn differs(&self, now: &Version) -> Option<String> {
        match (&self.etag, &now.etag) {
            _ if self.length != now.length => Some(format!("it had {} bytes and now has {}", self.length, now.length)),
            (Some(a), Some(b)) if a == b => None,
            (None, None) if self.modified_ms == now.modified_ms => None,
            _ => Some("its ETag changed".into()),
        }
    }
}

/// An object of a fixed version.
#[derive(Clone, Debug)]
pub struct Object {
    place: Locator,
    version: Version,
}

impl Object {
    /// Opens an object by requesting a first range; the answer states the version.
    pub async fn open(place: &Locator, first: GetRange) -> Result<(Object, Bytes), Failure> {
        let mut result = Err(Failure::new(Cause::Passing, ""));
        let _turn = turn().await;
        let begun = Instant::now();
        for _ in 0..ATTEMPTS {
            let options = GetOptions { range: Some(first.clone()), ..GetOptions::default() };
            result = match get(place, options).await {
                Ok(answer) => {
                    let (version, range) = (Version::from_meta(&answer.meta), answer.range.clone());
                    let bytes = match check_length(&range, &first) {
                        Ok(()) => body(answer, &range).await,
                        Err(failure) => Err(failure),
                    };
                    bytes.map(|bytes| (Object { place: place.clone(), version }, bytes))
                }
                Err(failure) => Err(failure),
            };
            if !again(&result, place, begun) {
                break;
            }
        }
        result
    }

    /// Reads a whole object whose server has no ranges, if it has at most [`WHOLE_LIMIT`] bytes.
    pub async fn whole(place: &Locator) -> Result<Bytes, Failure> {
        let _turn = turn().await;
        let answer = get(place, GetOptions::default()).await?;
        if answer.meta.size > WHOLE_LIMIT {
            let what = format!(
                "has {} bytes, but its server does not support byte ranges, and at most {WHOLE_LIMIT} bytes are read without",
                answer.meta.size
            );
            return Err(Failure::new(Cause::NoRanges, what));
        }
        let range = answer.range.clone();
        body(answer, &range).await
    }

    /// Returns the version that was opened.
    pub fn version(&self) -> &Version {
        &self.version
    }

    /// Returns the client and name of the object.
    pub fn place(&self) -> &Locator {
        &self.place
    }

    /// Checks that another opening found the same version.
    pub fn same(&self, other: &Object) -> Result<(), Failure> {
        self.version.differs(&other.version).map_or(Ok(()), |what| Err(Failure::new(Cause::Changed, what)))
    }

    /// Reads the bytes of a range, which lies inside the object. An answer that was cut off is
    /// requested again, at most `ATTEMPTS` times in all.
    pub async fn range(&self, range: Range<u64>) -> Result<Bytes, Failure> {
        if range.is_empty() {
            return Ok(Bytes::new());
        }
        let mut result = Err(Failure::new(Cause::Passing, ""));
        let _turn = turn().await;
        let begun = Instant::now();
        for _ in 0..ATTEMPTS {
            result = self.once(&range).await;
            if !again(&result, &self.place, begun) {
                break;
            }
        }
        result
    }

    /// Reads the bytes of a range that may be long, in parts that are requested at the same time.
    pub async fn parts(&self, range: Range<u64>) -> Result<Bytes, Failure> {
        if range.end.saturating_sub(range.start) <= PART {
            return self.range(range).await;
        }
        let mut bytes = BytesMut::new();
        let starts: Vec<u64> = range.clone().step_by(PART as usize).collect();
        for group in starts.chunks(AT_ONCE) {
            let part = |&start: &u64| {
                let (object, part) = (self.clone(), start..range.end.min(start + PART));
                tokio::spawn(async move { object.range(part).await })
            };
            for task in group.iter().map(part).collect::<Vec<_>>() {
                let ended = |error| Failure::new(Cause::Passing, format!("request failed: {error}"));
                bytes.extend_from_slice(&task.await.map_err(ended)??);
            }
        }
        Ok(bytes.freeze())
    }

    async fn once(&self, range: &Range<u64>) -> Result<Bytes, Failure> {
        // A weak ETag never matches on the server, so it is compared here only.
        let if_match = self.version.etag.clone().filter(|etag| !etag.starts_with("W/"));
        let options = GetOptions { range: Some(GetRange::Bounded(range.clone())), if_match, ..GetOptions::default() };
        let answer = get(&self.place, options).await?;
        if let Some(what) = self.version.differs(&Version::from_meta(&answer.meta)) {
            return Err(Failure::new(Cause::Changed, what));
        }
        body(answer, range).await
    }
}

/// Waits until fewer than [`ALL_AT_ONCE`] requests are under way. The turn ends when the permit is
/// dropped.
async fn turn() -> Option<SemaphorePermit<'static>> {
    // The semaphore is never closed, so a permit is always given.
    TURNS.acquire().await.ok()
}

/// Returns true if the request is to be made again: the failure may pass and time is left.
fn again<T>(result: &Result<T, Failure>, place: &Locator, begun: Instant) -> bool {
    matches!(result, Err(failure) if failure.cause == Cause::Passing) && begun.elapsed() < 2 * place.connection.timeout
}

async fn get(place: &Locator, options: GetOptions) -> Result<GetResult, Failure> {
    traffic::asked();
    place.store.get_opts(&place.path, options).await.map_err(|error| Failure::from_store(&error))
}

/// Reads the body of an answer and checks that it is as long as the range. Reading ends where the
/// server sends more: what it states and what it sends may both be without end.
async fn body(answer: GetResult, range: &Range<u64>) -> Result<Bytes, Failure> {
    let expected = range.end.saturating_sub(range.start);
    let mut bytes = BytesMut::new();
    let mut stream = answer.into_stream();
    while let Some(piece) = stream.next().await {
        let piece = piece.map_err(|error| Failure::from_store(&error))?;
        traffic::received(piece.len());
        if (bytes.len() + piece.len()) as u64 > expected {
            let what = format!("its server sends more than the {expected} bytes that were requested");
            return Err(Failure::new(Cause::Refused, what));
        }
        bytes.extend_from_slice(&piece);
    }
    if (bytes.len() as u64) < expected {
        let what = format!("was cut off: {} of {expected} bytes came", bytes.len());
        return Err(Failure::new(Cause::Passing, what));
    }
    Ok(bytes.freeze())
}

/// Checks that the range that a server states is not longer than the requested one.
fn check_length(stated: &Range<u64>, requested: &GetRange) -> Result<(), Failure> {
    let most = match requested {
        GetRange::Bounded(range) => range.end.saturating_sub(range.start),
        GetRange::Suffix(length) => *length,
        GetRange::Offset(_) => u64::MAX,
    };
    let length = stated.end.saturating_sub(stated.start);
    if length > most {
        let what = format!("its server states {length} bytes where {most} were requested");
        return Err(Failure::new(Cause::Refused, what));
    }
    Ok(())
}

/// Requests the metadata of an object, or returns `None` if it is not there.
pub async fn look(place: &Locator) -> Result<Option<ObjectMeta>, Failure> {
    let answered = {
        let _turn = turn().await;
        traffic::asked();
        place.store.head(&place.path).await.map_err(|error| Failure::from_store(&error))
    };
    match answered {
        Ok(meta) => Ok(Some(meta)),
        Err(failure) if failure.is_absence() => Ok(None),
        Err(failure) if failure.cause == Cause::Denied => Err(why(place, failure).await),
        Err(failure) => Err(failure),
    }
}

/// Finds out why access is denied: an answer to HEAD has no body, the answer to GET says more.
async fn why(place: &Locator, denied: Failure) -> Failure {
    let options = GetOptions { range: Some(GetRange::Bounded(0..1)), ..GetOptions::default() };
    match get(place, options).await {
        Err(failure) if matches!(failure.cause, Cause::Denied | Cause::Clock) => failure,
        _ => denied,
    }
}
