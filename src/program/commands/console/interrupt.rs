//! Ctrl-C and SIGTERM: the first signal asks long work to stop where it can be resumed, the second
//! one ends the program. In: signals. Out: a flag, an exit code.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::Duration;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::voice::aside;

/// State that signals set.
struct Signals {
    /// Number of the first signal that arrived, 0 for none.
    first: Arc<AtomicUsize>,
    /// True if the next signal ends the program.
    at_once: Arc<AtomicBool>,
}

/// Offset of exit codes of programs that a signal ended, as shells report them.
const ENDED_BY_SIGNAL: i32 = 128;

/// Interval between two checks for a signal, after which a message is printed.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// State of signals; empty until a command watches for signals.
static SIGNALS: OnceLock<Signals> = OnceLock::new();

fn registered() -> Signals {
    let signals = Signals { first: Arc::default(), at_once: Arc::default() };
    for signal in [SIGINT, SIGTERM] {
        // The order matters: the signal that sets the flag must not meet it. Where the system
        // refuses to register, a signal ends the program as usual.
        let _ = flag::register_conditional_shutdown(signal, ENDED_BY_SIGNAL + signal, Arc::clone(&signals.at_once));
        let _ = flag::register(signal, Arc::clone(&signals.at_once));
        let _ = flag::register_usize(signal, Arc::clone(&signals.first), signal as usize);
    }
    let first = Arc::clone(&signals.first);
    thread::spawn(move || {
        while first.load(Ordering::Relaxed) == 0 {
            thread::sleep(LOOK_EVERY);
        }
        aside("stopping at the next checkpoint; interrupt again to stop immediately\n");
    });
    signals
}

/// Guard of a watch: while it lives, Ctrl-C is a request to stop.
pub struct Watch(());

/// Starts a watch: until the guard is dropped, Ctrl-C is a request to stop.
pub fn watch() -> Watch {
    let signals = SIGNALS.get_or_init(registered);
    signals.at_once.store(requested(), Ordering::Relaxed);
    Watch(())
}

impl Drop for Watch {
    fn drop(&mut self) {
        SIGNALS.get().into_iter().for_each(|signals| signals.at_once.store(true, Ordering::Relaxed));
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

/// Returns the exit code of work that was stopped: 130 for Ctrl-C, 143 for SIGTERM.
pub fn exit_code() -> u8 {
    let signal = match first() {
        0 => SIGINT,
        signal => signal as i32,
    };
    (ENDED_BY_SIGNAL + signal) as u8
}
