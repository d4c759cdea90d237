//! Ctrl-C and its like: the first one asks long work to stop where it can go on later, the second one ends the program.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::Duration;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::voice::aside;

/// What signals set.
struct Signals {
    /// The first one that came, 0 for none.
    first: Arc<AtomicUsize>,
    /// Whether the next one ends the program.
    at_once: Arc<AtomicBool>,
}

/// Shells count a program that a signal ended so.
const ENDED_BY_SIGNAL: i32 = 128;

/// How often is looked whether a signal came, to say so.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Empty until a command wants to know of signals.
static SIGNALS: OnceLock<Signals> = OnceLock::new();

fn registered() -> Signals {
    let signals = Signals { first: Arc::default(), at_once: Arc::default() };
    for signal in [SIGINT, SIGTERM] {
        // In this order: the signal that sets the flag must not meet it. Where the system refuses, a signal ends the program as ever.
        let _ = flag::register_conditional_shutdown(signal, ENDED_BY_SIGNAL + signal, Arc::clone(&signals.at_once));
        let _ = flag::register(signal, Arc::clone(&signals.at_once));
        let _ = flag::register_usize(signal, Arc::clone(&signals.first), signal as usize);
    }
    let first = Arc::clone(&signals.first);
    thread::spawn(move || {
        while first.load(Ordering::Relaxed) == 0 {
            thread::sleep(LOOK_EVERY);
        }
        aside("stopping at the next checkpoint; once more to stop at once\n");
    });
    signals
}

/// While it lives, Ctrl-C is a request.
pub struct Watch(());

/// From now on, until the value is dropped, Ctrl-C is a request.
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

/// Whether the user wants the work to stop.
pub fn requested() -> bool {
    first() != 0
}

/// The first signal that came, 0 for none.
fn first() -> usize {
    SIGNALS.get().map_or(0, |signals| signals.first.load(Ordering::Relaxed))
}

/// The exit code of work that was stopped: 130 for Ctrl-C, 143 for SIGTERM.
pub fn exit_code() -> u8 {
    let signal = match first() {
        0 => SIGINT,
        signal => signal as i32,
    };
    (ENDED_BY_SIGNAL + signal) as u8
}
