//! Long work beside Python. In: a function. Out: its result. Meanwhile Python's other threads run
//! and `progress` is called. Ctrl-C or an exception of `progress` stops the work at its next check.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::errors::{raised, worded_text};
use heliotile::text::Message;
use heliotile::{Observer, Result, Tone};

/// Interval at which signals and progress are checked.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Number of frames from a warning to the user's line; the frames between are of `heliotile/*.py`.
const STACK_LEVEL: i32 = 2;

/// Number of tiles whose irradiance this process has computed.
static TILES: AtomicU64 = AtomicU64::new(0);

/// Adds `tiles` to the number of computed tiles.
pub fn count_tiles(tiles: usize) {
    TILES.fetch_add(tiles as u64, Ordering::Relaxed);
}

/// Returns the number of tiles of 64 receivers that this process has computed so far.
#[pyfunction]
pub fn tiles_computed() -> u64 {
    TILES.load(Ordering::Relaxed)
}

/// Sets the number of threads of this process, unless work has begun already. Returns the number in
/// use.
#[pyfunction]
pub fn use_threads(count: usize) -> usize {
    // It fails if the threads exist already: the number in use stays.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(count).build_global();
    rayon::current_num_threads()
}

/// Progress and warnings of the work, and the request to stop it.
#[derive(Default)]
pub struct Watch {
    stop: AtomicBool,
    told: Mutex<PendingMessages>,
    finished: Mutex<bool>,
    changed: Condvar,
}

#[derive(Default)]
struct PendingMessages {
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

    fn tell(&self, tone: Tone, message: Message) {
        if matches!(tone, Tone::Warning | Tone::Note) {
            locked(&self.told).warnings.push(worded_text(&message));
        }
    }

    fn in_words(&self, message: &Message) -> String {
        worded_text(message)
    }

    fn cancelled(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

impl Watch {
    /// Waits until the work ends, but not longer than [`LOOK_EVERY`]. Returns true if it has ended.
    fn wait(&self) -> bool {
        let finished = locked(&self.finished);
        let waited = self.changed.wait_timeout_while(finished, LOOK_EVERY, |finished| !*finished);
        *waited.unwrap_or_else(PoisonError::into_inner).0
    }

    /// Calls `progress(stage, done, items)` for each stage that has advanced.
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

/// Marks the work as ended when dropped, after a panic too.
struct End<'a>(&'a Watch);

impl Drop for End<'_> {
    fn drop(&mut self) {
        *locked(&self.0.finished) = true;
        self.0.changed.notify_all();
    }
}

/// Runs `work` on a thread of its own. Its error becomes an exception. Ctrl-C and an exception of
/// `progress` stop the work and are raised.
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
        // Python handles signals on its main thread, so the calling thread waits and looks while
        // the worker computes. After a failure it waits on until the worker has stopped.
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

/// Raises each text as a Python warning.
pub fn warn(py: Python<'_>, texts: &[String]) -> PyResult<()> {
    let class = || py.import("heliotile.errors")?.getattr("HeliotileWarning");
    texts.iter().try_for_each(|text| {
        let text = std::ffi::CString::new(text.replace('\0', " "))?;
        PyErr::warn(py, &class()?, &text, STACK_LEVEL)
    })
}

/// Returns an error in a forked process: the threads that compute tiles do not exist there, so the
/// work would wait for them forever.
fn refuse_forks() -> PyResult<()> {
    static FIRST: OnceLock<u32> = OnceLock::new();
    if *FIRST.get_or_init(std::process::id) == std::process::id() {
        return Ok(());
    }
    Err(PyRuntimeError::new_err(
        "this process was forked after heliotile had started its threads, which a fork does not have\n  to fix: start processes with \
         multiprocessing.get_context(\"spawn\") or \"forkserver\"",
    ))
}
