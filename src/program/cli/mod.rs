//! The command line: commands from the fields of their requests.
//!
//! | room | what it holds |
//! | --- | --- |
//! | `commands` | the commands, as clap parses them |
//! | `line` | the line itself: options of all commands, parsing, wording of messages |

mod commands;
mod line;

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::builder::EnumValueParser;
use clap::{Arg, Args, Command, value_parser};
use clap_complete::Shell;
use heliotile::cases::{self, Given};

pub use self::commands::given;
pub use self::line::{EverywhereArgs, again, option_of, parse, quoted, report, worded_text};

/// A command line.
pub struct Cli {
    pub command: CliCommand,
    pub everywhere: EverywhereArgs,
}

/// A command with what it is asked.
pub enum CliCommand {
    /// Command whose request declares its fields.
    Case(&'static cases::Command, Given),
    /// Completions of this command line for a shell.
    Completions(Shell),
    /// Manual pages of all commands, into a folder.
    Man(PathBuf),
}

/// Purpose of the program, at the top of its help.
const ABOUT: &str = "How much sun does every point of a building, a solar module or a street get, hour by hour? heliotile traces a site once, \
with its neighbours, terrain, trees and mirrors, and replays any weather from the archive.

A year of sun from scene files:  heliotile run block.city.json --weather city.epw";

/// Returns the whole command line as clap parses it.
pub fn command_line() -> Command {
    command_line_with(&|_| true)
}

/// Returns the command line as clap parses it, in which commands that `is_named` does not tell by
/// the last word of their names have no options: making all of them takes a millisecond.
pub fn command_line_with(is_named: &dyn Fn(&str) -> bool) -> Command {
    let mut program = Command::new("heliotile")
        .version(env!("CARGO_PKG_VERSION"))
        .max_term_width(100)
        .arg_required_else_help(true)
        .help_template("{about-with-newline}\n{usage-heading} {usage}\n{after-help}\n\n{options}")
        .arg(
            Arg::new("completions")
                .long("completions")
                .value_name("SHELL")
                .value_parser(EnumValueParser::<Shell>::new())
                .exclusive(true)
                .help("Write completions of this command line for a shell to standard output"),
        )
        .arg(
            Arg::new("man")
                .long("man")
                .value_name("FOLDER")
                .value_parser(value_parser!(PathBuf))
                .exclusive(true)
                .help("Write manual pages of all commands, heliotile.1 and so on, into a folder"),
        );
    for (name, about) in cases::GROUPS {
        let group = Command::new(name).about(about).subcommand_required(true).arg_required_else_help(true);
        program = program.subcommand(group);
    }
    for command in cases::COMMANDS {
        let made = commands::parsed(command, is_named(command.last_word()));
        program = match command.name.split_once(' ') {
            None => program.subcommand(made),
            Some((group, _)) => program.mut_subcommand(group, |parent| {
                parent.args_conflicts_with_subcommands(true).subcommand_negates_reqs(true).subcommand(made)
            }),
        };
    }
    let listed = listed(&program);
    EverywhereArgs::augment_args(program).about(ABOUT).after_help(listed)
}

/// Returns the commands under headings of what they are for, each group of commands once.
fn listed(program: &Command) -> String {
    let mut text = String::new();
    let mut shown = BTreeSet::new();
    for (aim, heading) in cases::Aim::ALL {
        text += &format!("\n{heading}\n");
        let of_aim = cases::COMMANDS.iter().filter(|command| command.aim == aim);
        let names = of_aim.filter_map(|command| command.name.split(' ').next());
        let names: Vec<&str> = names.filter(|name| shown.insert(*name)).collect();
        for command in names.iter().filter_map(|name| program.find_subcommand(name)) {
            let about = command.get_about().map(ToString::to_string).unwrap_or_default();
            let about = about.split(". ").next().and_then(|first| first.split([':', ';']).next()).unwrap_or_default();
            text += &format!("  {:<12} {}\n", command.get_name(), about.trim_end());
        }
    }
    text.trim_start().to_owned() + "\n`heliotile COMMAND --help` lists the options of a command."
}

/// Returns the commands with their whole names, those in groups among them.
pub fn named(program: &Command) -> Vec<(String, &Command)> {
    let mut all = Vec::new();
    for command in program.get_subcommands() {
        all.push((command.get_name().to_owned(), command));
        let inside = command.get_subcommands();
        all.extend(inside.map(|inside| (format!("{} {}", command.get_name(), inside.get_name()), inside)));
    }
    all.retain(|(name, _)| cases::Command::by_name(name).is_some());
    all
}
