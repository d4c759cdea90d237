//! Progress where no terminal draws a bar, such as in a log. In: stages and their progress. Out:
//! plain lines at growing intervals.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use indicatif::HumanCount;

/// Time of the first line; the next lines follow at growing intervals.
pub const FIRST_LINE: Duration = Duration::from_secs(10);

/// Stages under way, and the thread that prints their progress.
pub struct ProgressLines {
    shared: Arc<Shared>,
    teller: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    wake: Condvar,
}

#[derive(Default)]
struct State {
    /// Stages under way, the newest last.
    stages: Vec<StageUnderWay>,
    ended: bool,
}

struct StageUnderWay {
    name: &'static str,
    items: Option<u64>,
    done: u64,
    began: Instant,
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        // A thread that panicked leaves a usable count.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl ProgressLines {
    /// Starts the thread. Lines are due `first` after `start`, and then as [`next_after`] says;
    /// `tell` prints them.
    pub fn new(start: Instant, first: Duration, tell: impl Fn(&str) + Send + 'static) -> Self {
        let shared = Arc::new(Shared::default());
        let seen = Arc::clone(&shared);
        let teller = thread::spawn(move || {
            let mut state = seen.state();
            let mut due = next_after(start.elapsed(), first);
            while !state.ended {
                let rest = due.saturating_sub(start.elapsed());
                if rest > Duration::ZERO {
                    state = seen.wake.wait_timeout(state, rest).unwrap_or_else(PoisonError::into_inner).0;
                    continue;
                }
                // The newest stage is the part of the others that is worked on.
                if let Some(stage) = state.stages.last() {
                    tell(&line(stage.name, stage.items, stage.done, stage.began.elapsed()));
                }
                due = next_after(start.elapsed(), first);
            }
        });
        ProgressLines { shared, teller: Some(teller) }
    }

    pub fn begin(&self, name: &'static str, items: Option<u64>) {
        self.shared.state().stages.push(StageUnderWay { name, items, done: 0, began: Instant::now() });
    }

    pub fn advance(&self, name: &'static str, items: u64) {
        if let Some(stage) = self.shared.state().stages.iter_mut().rev().find(|stage| stage.name == name) {
            stage.done = stage.done.saturating_add(items);
        }
    }

    pub fn end(&self, name: &'static str) {
        let mut state = self.shared.state();
        if let Some(i) = state.stages.iter().rposition(|stage| stage.name == name) {
            state.stages.remove(i);
        }
    }
}

impl Drop for ProgressLines {
    fn drop(&mut self) {
        self.shared.state().ended = true;
        self.shared.wake.notify_all();
        if let Some(teller) = self.teller.take() {
            // The thread can only have panicked while it printed.
            let _ = teller.join();
        }
    }
}

/// Returns the first time after `passed` at which a line is due. With `first` of 10 s lines are due
/// after 10, 40, 70, 100, 130, 162 s and so on, a quarter longer each time.
fn next_after(passed: Duration, first: Duration) -> Duration {
    let mut due = first;
    // The intervals grow, so the loop is short: a year has 60 of them.
    while due <= passed {
        due += (3 * first).max(due / 4);
    }
    due
}

/// Words the progress of a stage.
fn line(name: &str, items: Option<u64>, done: u64, passed: Duration) -> String {
    let Some(items) = items.filter(|items| *items > 0) else {
        return format!("{name}: {} so far", HumanCount(done));
    };
    let done = done.min(items);
    let percent = 100.0 * done as f64 / items as f64;
    let left = match done {
        0 => String::new(),
        _ => format!(", about {} left", duration(passed.as_secs_f64() * (items - done) as f64 / done as f64)),
    };
    format!("{name}: {:.0} % ({} of {}){left}", percent.floor(), HumanCount(done), HumanCount(items))
}

/// Words a duration with one or two digits.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 90.0 => format!("{:.0} s", (s / 10.0).ceil() * 10.0),
        s if s < 90.0 * 60.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.0} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    /// 12,000 of 35,000 after 62 s are 34 % and two minutes to go. A stage without an end, or with
    /// nothing done yet, gets its count alone.
    #[test]
    fn a_line_states_share_and_time_left() {
        let after = |s| Duration::from_secs(s);
        let text = line("receivers", Some(35_000), 12_000, after(62));
        assert_eq!(text, "receivers: 34 % (12,000 of 35,000), about 2 min left");
        assert_eq!(line("cells", None, 1234, after(9)), "cells: 1,234 so far");
        assert_eq!(line("cells", Some(10), 0, after(9)), "cells: 0 % (0 of 10)");
        assert_eq!(line("cells", Some(10), 11, after(9)), "cells: 100 % (10 of 10), about 0 s left");
        assert_eq!([31.0, 600.0, 9000.0].map(duration), ["40 s", "10 min", "2 h"]);
    }

    /// Lines come after 10 and 40 s, every 30 s at first; a day has at most 35.
    #[test]
    fn progress_lines_come_ever_more_seldom() {
        let (first, mut at, mut times) = (Duration::from_secs(10), Duration::ZERO, Vec::new());
        while at < Duration::from_secs(86_400) {
            at = next_after(at, first);
            times.push(at.as_secs());
        }
        assert_eq!(times[..5], [10, 40, 70, 100, 130]);
        assert!(times.len() <= 35, "{}", times.len());
        assert!(times.array_windows().all(|[a, b]| b - a >= 30));
    }

    /// A stage of 8 items of which 2 are done is printed with these numbers, the newest of two
    /// first; no line is printed once it has ended.
    #[test]
    fn the_newest_stage_is_printed() {
        let (sender, lines) = mpsc::channel();
        let tell = move |text: &str| drop(sender.send(text.to_owned()));
        let progress = ProgressLines::new(Instant::now(), Duration::from_millis(20), tell);
        progress.begin("outer", None);
        progress.begin("inner", Some(8));
        progress.advance("inner", 2);
        let text = lines.recv_timeout(Duration::from_secs(60)).expect("a line");
        assert!(text.starts_with("inner: 25 % (2 of 8)"), "{text}");
        progress.end("inner");
        progress.end("outer");
        drop(progress);
        assert!(lines.try_iter().count() <= 1);
    }
}
