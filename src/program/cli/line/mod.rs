//! The command line itself: options of all commands, parsing, quoting, wording of messages.

mod everywhere;
mod invocation;
mod misplaced;
mod report;
mod wording;

pub use everywhere::EverywhereArgs;
pub use invocation::again;
pub use invocation::quoted;
pub use misplaced::parse;
pub use report::report;
pub use wording::{option_of, worded_text};
