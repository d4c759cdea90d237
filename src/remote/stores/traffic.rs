//! What was asked of others so far, by this process. In: nothing. Out: counts.

use std::sync::atomic::{AtomicU64, Ordering};

static REQUESTS: AtomicU64 = AtomicU64::new(0);
static RECEIVED: AtomicU64 = AtomicU64::new(0);
static CACHED: AtomicU64 = AtomicU64::new(0);

/// Counts since the process began.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Traffic {
    /// Objects or ranges that were asked for; those that a store had to be asked for again count once.
    pub requests: u64,
    /// Bytes of them that came.
    pub received: u64,
    /// Bytes that the cache gave in place of a store.
    pub cached: u64,
}

/// The counts now.
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
