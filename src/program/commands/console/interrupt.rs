//! Ctrl-C, SIGTERM and SIGHUP: the first signal asks long work to stop where it can be resumed, the
//! second one ends the program. Without such work the first one ends it. Unfinished files are
//! removed. In: signals. Out: a flag, an exit code.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::Duration;

use heliotile::output::remove_unfinished;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::flag;

use super::voice::{aside, tell_waiting};

/// State that signals set.
struct Signals {
    /// Number of the first signal that arrived, 0 for none.
    first: Arc<AtomicUsize>,
    /// True if the next signal ends the program, without removing anything.
    at_once: Arc<AtomicBool>,
    /// True while long work watches for a request to stop.
    is_watched: Arc<AtomicBool>,
}

/// Offset of exit codes of programs that a signal ended, as shells report them.
const ENDED_BY_SIGNAL: i32 = 128;

/// Interval between two checks for a signal, after which a message is printed.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// State of signals; empty until a command watches for signals.
static SIGNALS: OnceLock<Signals> = OnceLock::new();

fn registered() -> Signals {
    let signals = Signals { first: Arc::default(), at_once: Arc::default(), is_watched: Arc::default() };
    let hang_up = (!is_hang_up_ignored()).then_some(SIGHUP);
    for signal in [SIGINT, SIGTERM].into_iter().chain(hang_up) {
        // The order matters: the signal that sets the flag must not meet it. Where the system
        // refuses to register, a signal ends the program as usual.
        let _ = flag::register_conditional_shutdown(signal, ENDED_BY_SIGNAL + signal, Arc::clone(&signals.at_once));
        let _ = flag::register(signal, Arc::clone(&signals.at_once));
        let _ = flag::register_usize(signal, Arc::clone(&signals.first), signal as usize);
    }
    // A file that grows beyond the limit of the shell is then an error of its writer.
    let _ = flag::register(SIGXFSZ, Arc::default());
    let (first, is_watched) = (Arc::clone(&signals.first), Arc::clone(&signals.is_watched));
    thread::spawn(move || {
        while first.load(Ordering::Relaxed) == 0 {
            thread::sleep(LOOK_EVERY);
        }
        if !is_watched.load(Ordering::Relaxed) {
            remove_unfinished();
            tell_waiting();
            std::process::exit(ENDED_BY_SIGNAL + first.load(Ordering::Relaxed) as i32);
        }
        aside("stopping at the next checkpoint; interrupt again to stop immediately\n");
    });
    signals
}

/// Returns true if the program goes on after its terminal is gone, as `nohup` wants, or if that is
/// not known.
fn is_hang_up_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
    ignored.is_none_or(|mask| mask >> (SIGHUP - 1) & 1 == 1)
}

/// Removes unfinished files if a signal ends the program.
pub fn clean_up() {
    SIGNALS.get_or_init(registered);
}

/// Guard of a watch: while it lives, Ctrl-C is a request to stop.
pub struct Watch(());

/// Starts a watch: until the guard is dropped, Ctrl-C is a request to stop.
pub fn watch() -> Watch {
    let signals = SIGNALS.get_or_init(registered);
    signals.at_once.store(requested(), Ordering::Relaxed);
    signals.is_watched.store(true, Ordering::Relaxed);
    Watch(())
}

impl Drop for Watch {
    fn drop(&mut self) {
        SIGNALS.get().into_iter().for_each(|signals| signals.is_watched.store(false, Ordering::Relaxed));
    }
}

/// Returns true if the user asked the work to stop.
pub fn requested() -> bool {
    first() != 0
}

/// Returns the number of the first signal that arrived, 0 for none.
fn first() -> usize {
    SIGNALS.get().map_or(0, |signals| signals.first.load(Ordering::Relaxed))
}

/// Returns the exit code of work that was stopped: 130 for Ctrl-C, 143 for SIGTERM, 129 for SIGHUP.
pub fn exit_code() -> u8 {
    let signal = match first() {
        0 => SIGINT,
        signal => signal as i32,
    };
    (ENDED_BY_SIGNAL + signal) as u8
}
