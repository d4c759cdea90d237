//! The observer of commands. In: stages, messages. Out: a progress bar on a terminal, nothing
//! elsewhere and with `--quiet`; reports; warnings and notes for the end; Ctrl-C as a request to
//! stop.

use std::collections::HashMap;
use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::{Mutex, MutexGuard, PoisonError};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use super::interrupt::{self, Watch};
use super::voice::{is_quiet, is_verbose, note, remark, remark_aside, warn};
use crate::cli::worded_text;
use heliotile::text::Message;
use heliotile::{Observer, Tone};

/// Observer of every command.
pub struct Terminal {
    /// Bars of the stages under way; `None`: no progress is shown.
    bars: Option<Mutex<Bars>>,
    /// Guard for work that can be resumed: while it lives, Ctrl-C is a request to stop.
    _watch: Option<Watch>,
    /// True if standard output is a table, so that reports go to standard error.
    is_beside_table: bool,
}

/// Bars by the name of their stage.
type Bars = HashMap<&'static str, ProgressBar>;

impl Default for Terminal {
    fn default() -> Self {
        let has_bars = !is_quiet() && std::io::stderr().is_terminal();
        Terminal { bars: has_bars.then(Mutex::default), _watch: None, is_beside_table: false }
    }
}

impl Terminal {
    /// Returns the observer of work that Ctrl-C stops where it can be resumed.
    pub fn watching() -> Self {
        Terminal { _watch: Some(interrupt::watch()), ..Terminal::default() }
    }

    /// Returns the observer of work that Ctrl-C stops, for a command whose standard output may be a
    /// table.
    pub fn watching_beside_table() -> Self {
        Terminal { is_beside_table: true, ..Terminal::watching() }
    }

    fn bars(&self) -> Option<MutexGuard<'_, Bars>> {
        // A thread that panicked leaves usable bars.
        self.bars.as_ref().map(|bars| bars.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Observer for Terminal {
    fn begin(&self, stage: &'static str, items: Option<u64>) {
        self.bars().into_iter().for_each(|mut bars| drop(bars.insert(stage, bar(stage, items))));
    }

    fn advance(&self, stage: &'static str, items: u64) {
        self.bars().iter().filter_map(|bars| bars.get(stage)).for_each(|bar| bar.inc(items));
    }

    fn end(&self, stage: &'static str) {
        self.bars().and_then(|mut bars| bars.remove(stage)).into_iter().for_each(|bar| bar.finish_and_clear());
    }

    fn tell(&self, tone: Tone, message: Message) {
        match tone {
            Tone::Warning => warn(message),
            Tone::Note => note(message),
            Tone::Detail if !is_verbose() => {}
            Tone::Report | Tone::Detail if self.is_beside_table => remark_aside(message),
            // A closed standard output does not end the work.
            Tone::Report | Tone::Detail => drop(remark(message)),
        }
    }

    fn in_words(&self, message: &Message) -> String {
        worded_text(message)
    }

    fn cancelled(&self) -> bool {
        interrupt::requested()
    }
}

/// Returns a bar over `total` items named `what`; `None` counts without an end.
fn bar(what: &'static str, total: Option<u64>) -> ProgressBar {
    let template = match total {
        Some(_) => "{prefix:>10} [{bar:30}] {human_pos}/{human_len} {rate} {eta} left",
        None => "{prefix:>10} {human_pos} {rate}",
    };
    let bar = ProgressBar::with_draw_target(total, ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style.with_key("rate", |state: &ProgressState, out: &mut dyn Write| {
            let per_s = state.per_sec();
            // Three digits at least, and no more than a person reads.
            let decimals = if per_s < 10.0 { 2 } else { 0 };
            let _ = write!(out, "{per_s:.decimals$}/s");
        }));
    }
    bar.set_prefix(what);
    bar
}
