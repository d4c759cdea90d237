//! Ctrl-C: the first one asks long work to stop where it can go on later, the second one ends the program.

use std::sync::atomic::{AtomicBool, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// From now on Ctrl-C is a request. Where the system refuses to tell, it ends the program as ever.
pub fn watch() {
    let _ = ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::Relaxed) {
            // As a shell counts a program that SIGINT ended.
            std::process::exit(130);
        }
        crate::commands::warn("stopping at the next checkpoint; once more to stop at once");
    });
}

/// Whether the user wants the work to stop.
pub fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}
