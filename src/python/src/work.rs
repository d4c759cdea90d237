//! Long work beside Python. In: what is to be done. Out: its result; meanwhile Python's other threads run, progress is told, and Ctrl-C or an
//! exception of whoever is told stops the work where it can stop.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::errors::{raised, worded_text};
use heliotile_core::error::Result;
use heliotile_core::observer::Observer;

/// How often signals and progress are looked at.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Frames between a warning's text and the user's line: `heliotile/*.py`.
const STACK_LEVEL: i32 = 2;

/// Tiles whose irradiance this process has computed.
static TILES: AtomicU64 = AtomicU64::new(0);

/// Counts tiles that were computed.
pub fn count_tiles(tiles: usize) {
    TILES.fetch_add(tiles as u64, Ordering::Relaxed);
}

/// Tiles of 64 receivers that this process has computed since it began.
#[pyfunction]
pub fn tiles_computed() -> u64 {
    TILES.load(Ordering::Relaxed)
}

/// Makes all work of this process run on so many threads; one that has begun already keeps its own. How many they are.
#[pyfunction]
pub fn use_threads(count: usize) -> usize {
    // An error: there are threads already.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(count).build_global();
    rayon::current_num_threads()
}

/// What the work tells, and whether it is to stop.
#[derive(Default)]
pub struct Watch {
    stop: AtomicBool,
    told: Mutex<Told>,
    finished: Mutex<bool>,
    changed: Condvar,
}

#[derive(Default)]
struct Told {
    stages: Vec<StageCount>,
    warnings: Vec<String>,
}

struct StageCount {
    name: &'static str,
    done: u64,
    items: Option<u64>,
    is_new: bool,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Observer for Watch {
    fn begin(&self, stage: &'static str, items: Option<u64>) {
        let mut told = locked(&self.told);
        told.stages.retain(|known| known.name != stage);
        told.stages.push(StageCount { name: stage, done: 0, items, is_new: true });
    }

    fn advance(&self, stage: &'static str, items: u64) {
        let mut told = locked(&self.told);
        for known in told.stages.iter_mut().filter(|known| known.name == stage) {
            (known.done, known.is_new) = (known.done + items, true);
        }
    }

    fn warn(&self, text: &str) {
        locked(&self.told).warnings.push(worded_text(text));
    }

    fn note(&self, text: &str) {
        self.warn(text);
    }

    fn in_words(&self, text: &str) -> String {
        worded_text(text)
    }

    fn cancelled(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

impl Watch {
    /// Waits a while, or until the work has ended: whether it has.
    fn wait(&self) -> bool {
        let finished = locked(&self.finished);
        let waited = self.changed.wait_timeout_while(finished, LOOK_EVERY, |finished| !*finished);
        *waited.unwrap_or_else(PoisonError::into_inner).0
    }

    /// Calls `progress(stage, done, items)` for each stage that has gone on.
    fn tell(&self, progress: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let Some(progress) = progress else { return Ok(()) };
        let news: Vec<_> = {
            let mut told = locked(&self.told);
            let news = told.stages.iter_mut().filter(|stage| stage.is_new);
            let tell = |stage: &mut StageCount| {
                stage.is_new = false;
                (stage.name, stage.done, stage.items)
            };
            news.map(tell).collect()
        };
        news.into_iter().try_for_each(|stage| progress.call1(stage).map(drop))
    }
}

/// Says that the work has ended, however it did.
struct End<'a>(&'a Watch);

impl Drop for End<'_> {
    fn drop(&mut self) {
        *locked(&self.0.finished) = true;
        self.0.changed.notify_all();
    }
}

/// Does something long. An error is an exception; so are Ctrl-C and what `progress` raises, after which nothing goes on.
pub fn run<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watch) -> Result<T> + Send,
) -> PyResult<T> {
    refuse_forks()?;
    let watch = Watch::default();
    let mut failed = None;
    let done = thread::scope(|scope| {
        let worker = scope.spawn(|| {
            let _end = End(&watch);
            work(&watch)
        });
        loop {
            let finished = py.detach(|| watch.wait());
            if failed.is_none()
                && let Err(error) = py.check_signals().and_then(|()| watch.tell(progress))
            {
                watch.stop.store(true, Ordering::Relaxed);
                failed = Some(error);
            }
            if finished {
                break py.detach(|| worker.join());
            }
        }
    });
    if let Some(error) = failed {
        return Err(error);
    }
    let done = done.map_err(|_| PyRuntimeError::new_err("this is a fault of heliotile: please report it"))?;
    let done = done.map_err(|error| raised(py, error))?;
    warn(py, &std::mem::take(&mut locked(&watch.told).warnings))?;
    Ok(done)
}

/// Gives sentences to Python's `warnings`.
pub fn warn(py: Python<'_>, texts: &[String]) -> PyResult<()> {
    let class = || py.import("heliotile.errors")?.getattr("HeliotileWarning");
    texts.iter().try_for_each(|text| {
        let text = std::ffi::CString::new(text.replace('\0', " "))?;
        PyErr::warn(py, &class()?, &text, STACK_LEVEL)
    })
}

/// A process that was forked off has none of the threads that tiles are computed on, and would wait for them for ever.
fn refuse_forks() -> PyResult<()> {
    static FIRST: OnceLock<u32> = OnceLock::new();
    if *FIRST.get_or_init(std::process::id) == std::process::id() {
        return Ok(());
    }
    Err(PyRuntimeError::new_err(
        "heliotile was at work before this process was forked off, and its threads are not here\n  to fix: start processes with \
         multiprocessing.get_context(\"spawn\") or \"forkserver\"",
    ))
}
