//! The command line: commands from the fields of their requests, and clap types of the few commands
//! without requests.
//!
//! | room | what it holds |
//! | --- | --- |
//! | `cases` | the commands, as clap parses them |
//! | `line` | the line itself: options of all commands, parsing, wording of messages, completions |
//! | `store`, `study` | arguments of `store` and `study` |

mod cases;
mod line;
mod store;
mod study;

use clap::{Args, Command, Subcommand};

pub use self::cases::{Case, Given};
pub use self::line::{
    CompletionsArgs, EverywhereArgs, ManArgs, again, command_of, option_of, parse, quoted, worded, worded_text,
};
pub use self::store::{StoreArgs, StoreCommand};
pub use self::study::{RaySquare, StudyArgs, StudyCommand, WallArgs};

/// A command line.
pub struct Cli {
    pub command: Asked,
    pub everywhere: EverywhereArgs,
}

/// A command with what it is asked.
pub enum Asked {
    /// Command whose request declares its fields.
    Case(&'static Case, Given),
    Other(Other),
}

/// Commands without requests.
#[derive(Debug, Subcommand)]
pub enum Other {
    /// List, thin out or check the cache of traces that `build --store` fills
    Store(StoreArgs),
    /// Repeat studies of the paper behind the method (src/book/studies.md)
    Study(StudyArgs),
    /// Write completions of this command line for a shell
    Completions(CompletionsArgs),
    /// Write manual pages of all commands
    Man(ManArgs),
}

/// What the program does, at the top of its help.
const ABOUT: &str = "Trace the sun and sky of a site once, replay any weather";

/// Returns the whole command line as clap parses it.
pub fn command_line() -> Command {
    let program = Command::new("heliotile")
        .version(env!("CARGO_PKG_VERSION"))
        .max_term_width(100)
        .subcommand_required(true)
        .arg_required_else_help(true)
        .subcommands(cases::CASES.iter().map(Case::command));
    EverywhereArgs::augment_args(Other::augment_subcommands(program)).about(ABOUT)
}
