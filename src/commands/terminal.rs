//! What a person sees of long work: a bar on a terminal, silence in a pipe, warnings on standard error, and Ctrl-C as the wish to stop.

use std::collections::HashMap;
use std::fmt::Write;
use std::sync::{Mutex, MutexGuard, PoisonError};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use super::{interrupt, warn};
use heliotile_builder::observer::Observer;

/// The observer of every command.
#[derive(Default)]
pub struct Terminal {
    bars: Mutex<HashMap<&'static str, ProgressBar>>,
}

impl Terminal {
    fn bars(&self) -> MutexGuard<'_, HashMap<&'static str, ProgressBar>> {
        // A bar of a thread that ended badly is still a bar.
        self.bars.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Observer for Terminal {
    fn begin(&self, stage: &'static str, items: Option<u64>) {
        self.bars().insert(stage, bar(stage, items));
    }

    fn advance(&self, stage: &'static str, items: u64) {
        if let Some(bar) = self.bars().get(stage) {
            bar.inc(items);
        }
    }

    fn end(&self, stage: &'static str) {
        if let Some(bar) = self.bars().remove(stage) {
            bar.finish_and_clear();
        }
    }

    fn warn(&self, text: &str) {
        warn(text);
    }

    fn cancelled(&self) -> bool {
        interrupt::requested()
    }
}

/// A bar over `total` items named `what`; `None` counts without an end.
fn bar(what: &'static str, total: Option<u64>) -> ProgressBar {
    let template = match total {
        Some(_) => "{prefix:>10} [{bar:30}] {human_pos}/{human_len} {rate} {eta} left",
        None => "{prefix:>10} {human_pos} {rate}",
    };
    // standard error that is not a terminal draws nothing.
    let bar = ProgressBar::with_draw_target(total, ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style.with_key("rate", |state: &ProgressState, out: &mut dyn Write| {
            let per_s = state.per_sec();
            // Three digits at least, no more than a person reads.
            let decimals = if per_s < 10.0 { 2 } else { 0 };
            let _ = write!(out, "{per_s:.decimals$}/s");
        }));
    }
    bar.set_prefix(what);
    bar
}
