//! Progress of long work: a bar on a terminal, silence in a pipe.

use std::fmt::Write;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

/// A bar over `total` items named `what`; `None` counts without an end.
pub fn bar(what: &'static str, total: Option<u64>) -> ProgressBar {
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
