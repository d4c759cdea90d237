//! The command line itself: options of all commands, parsing, quoting, wording of messages.

mod everywhere;
mod invocation;
mod misplaced;
mod report;
mod shell_words;
mod wording;

pub use everywhere::EverywhereArgs;
pub use invocation::again;
pub use misplaced::parse;
pub use report::report;
pub use shell_words::quoted;
pub use wording::{option_of, worded_text};
