//! The command line itself.

mod everywhere;
mod misplaced;
mod shells;
mod words;

pub use everywhere::EverywhereArgs;
pub use misplaced::parse;
pub use shells::{CompletionsArgs, ManArgs};
pub use words::{give, words};
