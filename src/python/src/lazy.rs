//! A replay on demand. In: an archive and a series of conditions, then numbers of receivers. Out:
//! rows of these receivers. Only the tiles that hold them are computed, and the latest tiles are
//! kept.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::{PyIndexError, PyKeyError};
use pyo3::prelude::*;
use self_cell::self_cell;

use crate::arrays::{Frame, FrameHandle, no_column};
use crate::memory::Block;
use crate::work;
use heliotile::archive::{OpenSite, Replay, format};
use heliotile::{ComponentSet, Error, Observer, Result, Site, SiteReplay};

self_cell!(
    /// A replay with the archive that it reads.
    struct Held {
        owner: Site,
        #[not_covariant]
        dependent: Replay,
    }
);

/// Requested columns of a tile: `[column][receiver][label]`.
type Tile = Arc<Vec<f32>>;

/// A replay that computes tiles on demand.
#[pyclass(frozen, module = "heliotile._heliotile")]
pub struct LazyReplay {
    held: Held,
    frame: Arc<Frame>,
    /// `[tile]`: number of its first receiver; the last entry is the number of all receivers.
    starts: Vec<usize>,
    kept: Mutex<VecDeque<(u32, Tile)>>,
    /// Largest number of tiles that are kept.
    most: usize,
    /// Number of tiles that are computed between two checks for a request to stop.
    at_once: usize,
}

impl LazyReplay {
    /// Returns a replay of all receivers of the first open archive that keeps up to `cache` bytes
    /// of tiles.
    pub fn new(owner: &Site, replay: &SiteReplay, frame: Frame, cache: usize) -> Result<Self> {
        let stream = replay.stream();
        let mut starts = vec![0];
        let mut count = 0;
        for entry in owner.archives().first().entries_of(format::RECEIVERS) {
            count += entry.items as usize;
            starts.push(count);
        }
        let components = ComponentSet::new(frame.components());
        let held = Held::try_new(owner.clone(), |owner| {
            let archive = owner.archives().first();
            let site = OpenSite::open(archive)?;
            let site = if owner.has_grid_north() { site.with_y_for_north() } else { site };
            stream.replay_of(archive, &site, components)
        })?;
        let tile_bytes = 4 * 64 * frame.labels.len().max(1) * frame.components().len().max(1);
        let half = usize::try_from(stream.resources.memory.total() / 2).unwrap_or(usize::MAX);
        Ok(LazyReplay {
            held,
            frame: Arc::new(frame),
            starts,
            kept: Mutex::default(),
            most: cache / tile_bytes,
            at_once: (half / tile_bytes).clamp(1, 64),
        })
    }

    /// Returns tiles in the order of `wanted`, from the kept ones where possible. Fails if the
    /// observer wants the work to stop.
    fn tiles(&self, wanted: &[u32], observer: &dyn Observer) -> Result<Vec<Tile>> {
        if observer.cancelled() {
            return Err(Error::Stopped { what: "before all tiles were replayed".into() });
        }
        let mut found: Vec<(u32, Option<Tile>)> = {
            let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
            let of = |tile: u32| kept.iter().find(|(number, _)| *number == tile).map(|(_, tile)| Arc::clone(tile));
            wanted.iter().map(|tile| (*tile, of(*tile))).collect()
        };
        let missing: Vec<u32> = found.iter().filter(|(_, tile)| tile.is_none()).map(|(number, _)| *number).collect();
        let mut made = VecDeque::new();
        self.held.with_dependent(|_, replay| -> Result<()> {
            for (number, result) in missing.iter().zip(replay.results(missing.iter().copied())) {
                let (_, values) = result?;
                let columns = self.frame.components().iter().flat_map(|component| values.component(*component));
                made.push_back((*number, Arc::new(columns.copied().collect::<Vec<f32>>())));
                work::count_tiles(1);
            }
            Ok(())
        })?;
        let mut new = made.iter();
        for (_, tile) in found.iter_mut().filter(|(_, tile)| tile.is_none()) {
            *tile = new.next().map(|(_, tile)| Arc::clone(tile));
        }
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        // The lock was free during the work, so another thread may have kept the tile already.
        for (number, tile) in made {
            if kept.iter().all(|(known, _)| *known != number) {
                kept.push_back((number, tile));
            }
        }
        let surplus = kept.len().saturating_sub(self.most);
        kept.drain(..surplus);
        Ok(found.into_iter().filter_map(|(_, tile)| tile).collect())
    }
}

#[pymethods]
impl LazyReplay {
    /// Returns the number of receivers, labels, columns and provenance of the rows.
    fn frame(&self) -> FrameHandle {
        FrameHandle(Arc::clone(&self.frame))
    }

    /// Returns rows of a column, `[receiver][label]`, for receivers by their numbers in the
    /// archive, in any order.
    fn rows(&self, py: Python<'_>, column: &str, receivers: Vec<usize>) -> PyResult<Block> {
        let frame = &self.frame;
        let place = frame.column(column).ok_or_else(|| PyKeyError::new_err(no_column(frame, column)))?;
        if let Some(beyond) = receivers.iter().find(|receiver| **receiver >= frame.receivers) {
            return Err(PyIndexError::new_err(format!(
                "receiver {beyond} is out of range: there are {} receivers",
                frame.receivers
            )));
        }
        let tile_of = |receiver: usize| self.starts.partition_point(|start| *start <= receiver).saturating_sub(1);
        let mut wanted: Vec<u32> = receivers.iter().map(|receiver| tile_of(*receiver) as u32).collect();
        wanted.sort_unstable();
        wanted.dedup();
        let labels = frame.labels.len();
        let values = work::run(py, None, |watch| {
            let mut values = vec![0.0_f32; receivers.len() * labels];
            // Tiles are taken in groups: their memory is far larger than that of the rows.
            for some in wanted.chunks(self.at_once) {
                let tiles = self.tiles(some, watch)?;
                for (to, receiver) in values.chunks_mut(labels.max(1)).zip(&receivers) {
                    let tile = tile_of(*receiver);
                    let found = some.binary_search(&(tile as u32)).ok().and_then(|at| tiles.get(at));
                    let ends = self.starts.get(tile).zip(self.starts.get(tile + 1));
                    let row = found.zip(ends).and_then(|(values, (first, end))| {
                        let row = place * (end - first) + receiver - first;
                        values.get(row * labels..(row + 1) * labels)
                    });
                    row.into_iter().for_each(|row| to.copy_from_slice(row));
                }
            }
            Ok(values)
        })?;
        Ok(Block::new(values, &[receivers.len(), labels]))
    }
}
