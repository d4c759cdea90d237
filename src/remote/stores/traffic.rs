//! Counts of this process's requests to stores. In: nothing. Out: counts.

use std::sync::atomic::{AtomicU64, Ordering};

static REQUESTS: AtomicU64 = AtomicU64::new(0);
static RECEIVED: AtomicU64 = AtomicU64::new(0);
static CACHED: AtomicU64 = AtomicU64::new(0);

/// Counts since the process began.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Traffic {
    /// Objects or ranges that were requested; retries do not count.
    pub requests: u64,
    /// Bytes received from stores.
    pub received: u64,
    /// Bytes that came from the cache in place of a store.
    pub cached: u64,
}

/// Returns the counts so far.
pub fn so_far() -> Traffic {
    let [requests, received, cached] = [&REQUESTS, &RECEIVED, &CACHED].map(|count| count.load(Ordering::Relaxed));
    Traffic { requests, received, cached }
}

pub(crate) fn asked() {
    REQUESTS.fetch_add(1, Ordering::Relaxed);
}

pub(crate) fn received(bytes: usize) {
    RECEIVED.fetch_add(bytes as u64, Ordering::Relaxed);
}

pub(crate) fn cached(bytes: usize) {
    CACHED.fetch_add(bytes as u64, Ordering::Relaxed);
}
