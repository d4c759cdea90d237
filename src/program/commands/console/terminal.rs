//! The observer of commands. In: stages, messages. Out: a progress bar on a terminal, a line now
//! and then elsewhere, nothing with `--quiet`; warnings on standard error; Ctrl-C as a request to
//! stop.

use std::collections::HashMap;
use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::{LazyLock, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use super::interrupt::{self, Watch};
use super::progress_lines::{FIRST_LINE, ProgressLines};
use super::voice::{aside, is_quiet, note, remark, remark_aside, warn};
use crate::cli::worded_text;
use heliotile::text::Message;
use heliotile::{Observer, Tone};

/// Observer of every command.
pub struct Terminal {
    progress: Progress,
    /// Guard for work that can be resumed: while it lives, Ctrl-C is a request to stop.
    _watch: Option<Watch>,
    /// True if standard output is a table, so that reports go to standard error.
    is_beside_table: bool,
}

enum Progress {
    Bars(Mutex<HashMap<&'static str, ProgressBar>>),
    /// Plain lines; the thread starts with the first stage.
    Lines(OnceLock<ProgressLines>),
    Nothing,
}

/// Time when the command began, approximately: lines of progress count from here.
static START: LazyLock<Instant> = LazyLock::new(Instant::now);

impl Default for Terminal {
    fn default() -> Self {
        LazyLock::force(&START);
        let progress = match (is_quiet(), std::io::stderr().is_terminal()) {
            (true, _) => Progress::Nothing,
            (_, true) => Progress::Bars(Mutex::default()),
            _ => Progress::Lines(OnceLock::new()),
        };
        Terminal { progress, _watch: None, is_beside_table: false }
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
}

fn locked<'a>(
    bars: &'a Mutex<HashMap<&'static str, ProgressBar>>,
) -> MutexGuard<'a, HashMap<&'static str, ProgressBar>> {
    // A thread that panicked leaves usable bars.
    bars.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Observer for Terminal {
    fn begin(&self, stage: &'static str, items: Option<u64>) {
        match &self.progress {
            Progress::Bars(bars) => drop(locked(bars).insert(stage, bar(stage, items))),
            Progress::Lines(lines) => {
                let tell = |text: &str| aside(&format!("{text}\n"));
                lines.get_or_init(|| ProgressLines::new(*START, FIRST_LINE, tell)).begin(stage, items);
            }
            Progress::Nothing => {}
        }
    }

    fn advance(&self, stage: &'static str, items: u64) {
        match &self.progress {
            Progress::Bars(bars) => locked(bars).get(stage).into_iter().for_each(|bar| bar.inc(items)),
            Progress::Lines(lines) => lines.get().into_iter().for_each(|lines| lines.advance(stage, items)),
            Progress::Nothing => {}
        }
    }

    fn end(&self, stage: &'static str) {
        match &self.progress {
            Progress::Bars(bars) => locked(bars).remove(stage).into_iter().for_each(|bar| bar.finish_and_clear()),
            Progress::Lines(lines) => lines.get().into_iter().for_each(|lines| lines.end(stage)),
            Progress::Nothing => {}
        }
    }

    fn tell(&self, tone: Tone, message: Message) {
        match tone {
            Tone::Warning => warn(message),
            Tone::Note => note(message),
            Tone::Report if self.is_beside_table => remark_aside(message),
            // A closed standard output does not end the work.
            Tone::Report => drop(remark(message)),
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
