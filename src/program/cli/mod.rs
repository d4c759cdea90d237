//! The command line: commands from the fields of their requests, and clap types of the few commands
//! without requests.
//!
//! | room | what it holds |
//! | --- | --- |
//! | `commands` | the commands, as clap parses them |
//! | `line` | the line itself: options of all commands, parsing, wording of messages, completions |
//! | `store`, `study` | arguments of `store` and `study` |

mod commands;
mod line;
mod store;
mod study;

use clap::{Args, Command, Subcommand};
use heliotile::cases::{self, Given};

pub use self::commands::given;
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
    Case(&'static cases::Command, Given),
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

/// Purpose of the program, at the top of its help.
const ABOUT: &str = "How much sun does every point of a building, a solar module or a street get, hour by hour? heliotile traces a site once, \
with its neighbours, terrain, trees and mirrors, and replays any weather from the archive.

A year of sun from scene files:  heliotile run block.city.json --weather city.epw";

/// Returns the whole command line as clap parses it.
pub fn command_line() -> Command {
    command_line_with(&|_| true)
}

/// Returns the command line as clap parses it, in which commands that `is_named` does not tell have
/// no options: making all of them takes a millisecond.
pub fn command_line_with(is_named: &dyn Fn(&str) -> bool) -> Command {
    let program = Command::new("heliotile")
        .version(env!("CARGO_PKG_VERSION"))
        .max_term_width(100)
        .subcommand_required(true)
        .arg_required_else_help(true)
        .help_template("{about-with-newline}\n{usage-heading} {usage}\n{after-help}\n\n{options}")
        .subcommands(cases::COMMANDS.iter().map(|command| commands::parsed(command, is_named(command.name))));
    let program = EverywhereArgs::augment_args(Other::augment_subcommands(program)).about(ABOUT);
    let listed = listed(&program);
    program.after_help(listed)
}

/// Returns the commands under headings of what they are for.
fn listed(program: &Command) -> String {
    let mut text = String::new();
    let mut list = |heading: &str, is_of: &dyn Fn(&str) -> bool| {
        text += &format!("\n{heading}\n");
        for command in program.get_subcommands().filter(|command| is_of(command.get_name())) {
            let about = command.get_about().map(ToString::to_string).unwrap_or_default();
            let about =
                about.split(". ").next().and_then(|first| first.split([':', ';', '(']).next()).unwrap_or_default();
            text += &format!("  {:<12} {}\n", command.get_name(), about.trim_end());
        }
    };
    for (aim, heading) in cases::Aim::ALL {
        let of = |name: &str| cases::Command::of(name).map(|command| command.aim);
        list(heading, &|name| of(name) == Some(aim) || (aim == cases::Aim::Large && name == "store"));
    }
    list("The program", &|name| ["study", "completions", "man"].contains(&name));
    text.trim_start().to_owned() + "\n`heliotile COMMAND --help` lists the options of a command."
}
