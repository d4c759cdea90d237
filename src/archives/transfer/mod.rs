//! Archives from archives: a part of one (`extract`), two as one (`merge`), and the differences of
//! two (`diff`). In: finished archives. Out: an archive with the same bytes as a build of its
//! receivers, or a list of differences.
//!
//! That is possible because a probe depends only on the scene and its key, and because tiles and
//! chunks are cut from one sorted sequence. All work is merging or filtering such sequences, and
//! packing them as the build does. Only some tiles and chunks are in memory at a time; ids are
//! sorted in temporary files. No ray is cast.

mod compare;
mod diff;
mod digests;
mod extract;
mod merge;
mod output;
mod reach;
mod rows;
mod selection;
mod union;

pub use compare::{Difference, differences};
pub use diff::{Differences, Names, Parted, diff};
pub use extract::{ExtractContent, Extracted, Whole, extract};
pub use merge::{Merged, merge};
pub use output::Assembled;
pub use rows::{ArchiveReceivers, LayeredReceiver, Layers, Shown};
pub use selection::{Bounds, Selection};
