//! Parsing of the command line, with a hint if the command does not come first. In: words. Out: the
//! arguments, or the end of the program with a message.

use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::error::{ContextKind, ContextValue, Error, ErrorKind};
use clap::{ArgMatches, Command, FromArgMatches};

use super::invocation::provenance;
use super::report::report_usage;
use crate::cli::{Cli, CliCommand, EverywhereArgs, command_line, command_line_with, given, named};
use heliotile::Provenance;
use heliotile::cases;

/// Parses the words of a command line, the program's name first. Ends the program if they ask for
/// help or are wrong.
pub fn parse(words: &[OsString]) -> (Cli, Provenance) {
    let is_named = |name: &str| words.iter().any(|word| word == name);
    let parsed = command_line_with(&is_named).try_get_matches_from(words).and_then(|matches| {
        let cli = cli_of(&matches).map_err(|error| error.format(&mut command_line()))?;
        let about = match &cli.command {
            CliCommand::Case(command, given) => provenance(command, given),
            CliCommand::Completions(_) | CliCommand::Man(_) => Provenance::default(),
        };
        Ok((cli, about))
    });
    parsed.unwrap_or_else(|mut error| {
        if let Some(hint) = command_first(&error, words).or_else(|| of_others(&error)) {
            error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![hint.into()]));
        }
        if let Some(said) = report_usage(&error) {
            // Nobody is left to tell if standard error is closed.
            let _ = std::io::stderr().write_all(said.as_bytes());
            std::process::exit(error.exit_code());
        }
        error.exit()
    })
}

/// Names of commands that have moved, and what is typed now.
const MOVED: [(&str, &str); 18] = [
    ("verify", "heliotile archive verify"),
    ("audit", "heliotile archive audit"),
    ("repair", "heliotile archive repair"),
    ("extract", "heliotile archive extract"),
    ("merge", "heliotile archive merge"),
    ("diff", "heliotile archive diff"),
    ("copy", "heliotile archive copy"),
    ("partition", "heliotile atlas partition"),
    ("catalogue", "heliotile atlas catalogue"),
    ("find", "heliotile atlas find"),
    ("factors", "heliotile energyplus factors"),
    ("plan", "heliotile build --dry-run"),
    ("query", "heliotile replay --conditions TABLE, or with --sun, --dni and --dhi"),
    ("rules", "heliotile info --rule all"),
    ("completions", "heliotile --completions SHELL"),
    ("man", "heliotile --man FOLDER"),
    ("store", "heliotile build --from ARCHIVE, which takes from an archive what the scene still has"),
    ("study", "tools/paper/wall.py, a script of the sources"),
];

fn cli_of(matches: &ArgMatches) -> Result<Cli, Error> {
    let command = match (matches.subcommand(), matches.get_one("completions"), matches.get_one::<PathBuf>("man")) {
        (Some((name, inside)), ..) => case_of(name, inside),
        (None, Some(shell), _) => Some(CliCommand::Completions(*shell)),
        (None, None, folder) => folder.map(|folder| CliCommand::Man(folder.clone())),
    };
    let missing = || Error::raw(ErrorKind::MissingSubcommand, "a command is missing, such as heliotile run\n");
    Ok(Cli { command: command.ok_or_else(missing)?, everywhere: EverywhereArgs::from_arg_matches(matches)? })
}

/// Returns the command of a name, or the one that stands behind the name of its group.
fn case_of(name: &str, inside: &ArgMatches) -> Option<CliCommand> {
    let of_group = inside
        .subcommand()
        .and_then(|(last, inside)| cases::Command::by_name(&format!("{name} {last}")).map(|command| (command, inside)));
    let (command, inside) = of_group.or_else(|| Some((cases::Command::by_name(name)?, inside)))?;
    Some(CliCommand::Case(command, given(command, inside)))
}

/// Returns a hint for a file or an option that is typed where the command belongs.
fn command_first(error: &Error, words: &[OsString]) -> Option<String> {
    let first = words.get(1)?.to_string_lossy().into_owned();
    let names: Vec<String> = command_line().get_subcommands().map(|command| command.get_name().to_owned()).collect();
    if names.contains(&first) {
        return None;
    }
    if let Some((_, now)) = MOVED.iter().find(|(name, _)| *name == first) {
        return Some(format!("`{first}` is now: {now}"));
    }
    let wrong = match error.kind() {
        ErrorKind::InvalidSubcommand => error.get(ContextKind::InvalidSubcommand),
        _ => error.get(ContextKind::InvalidArg),
    };
    // An argument that a command does not know is reported by that command.
    let at_first = |word: &str| Some(word) == first.split('=').next();
    if !matches!(wrong, Some(ContextValue::String(word)) if at_first(word) || *word == first) {
        return None;
    }
    let command =
        words.iter().skip(2).map(|word| word.to_string_lossy()).find(|word| names.contains(&word.to_string()));
    let is_file = Path::new(&first).exists() || Path::new(&first).extension().is_some();
    match (error.kind(), command) {
        (ErrorKind::InvalidSubcommand | ErrorKind::UnknownArgument, Some(command)) => {
            Some(format!("the command comes first, files and options after it: heliotile {command} ..."))
        }
        (ErrorKind::InvalidSubcommand, None) if is_file => Some(match first.ends_with(".helio") {
            true => format!("a command comes first, such as heliotile info {first}"),
            false => format!("a command comes first, such as heliotile run {first} --weather WEATHER.epw"),
        }),
        _ => None,
    }
}

/// Returns a hint for an option that only other commands take.
fn of_others(error: &Error) -> Option<String> {
    let (ErrorKind::UnknownArgument, Some(ContextValue::String(wrong))) =
        (error.kind(), error.get(ContextKind::InvalidArg))
    else {
        return None;
    };
    let name = wrong.strip_prefix("--")?.split('=').next()?;
    let cli = command_line();
    let takes = |command: &Command| command.get_arguments().any(|arg| arg.get_long() == Some(name));
    let names: Vec<String> =
        named(&cli).into_iter().filter(|(_, command)| takes(command)).map(|(name, _)| name).collect();
    let (last, before) = names.split_last()?;
    let list = if before.is_empty() { last.clone() } else { format!("{} and {last}", before.join(", ")) };
    Some(format!("this command has no --{name}; {list} {}", if before.is_empty() { "has one" } else { "have one" }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hint(line: &str) -> Option<String> {
        let words: Vec<OsString> = line.split(' ').map(OsString::from).collect();
        command_first(&command_line().try_get_matches_from(&words).err()?, &words)
    }

    /// A scene, an archive and an option before the command get a hint, 4 of 4, and so does the
    /// former name of a command; a misspelt command and a command's own mistake do not.
    #[test]
    fn commands_come_first() {
        for (line, part) in [
            ("heliotile town.city.json --weather w.epw", "heliotile run town.city.json --weather"),
            ("heliotile town.helio", "heliotile info town.helio"),
            ("heliotile town.city.json run --weather w.epw", "heliotile run ..."),
            ("heliotile --weather w.epw replay a.helio", "heliotile replay ..."),
        ] {
            assert!(hint(line).is_some_and(|hint| hint.contains(part)), "{line}: {:?}", hint(line));
        }
        assert!(hint("heliotile verify a.helio").is_some_and(|hint| hint.contains("heliotile archive verify")));
        for line in ["heliotile rnu", "heliotile run --wether w.epw a.obj", "heliotile --threads 2 build --run a.obj"] {
            assert_eq!(hint(line), None, "{line}");
        }
    }

    /// An option of other commands is named with them: `run` has no --sky, `buildings` no
    /// --columns, `pv` no --temperature, 4 of 4; a misspelt option, which no command has, is left
    /// to clap.
    #[test]
    fn options_of_other_commands_are_named() {
        let hint = |line: &str| of_others(&command_line().try_get_matches_from(line.split(' ')).err()?);
        for (line, part) in [
            ("heliotile run a.obj --weather w.epw --sky perez1990", "this command has no --sky; "),
            ("heliotile buildings a.helio -w w.epw --columns=total", "replay"),
            ("heliotile run a.helio -w w.epw --sky perez1990", "pv"),
            ("heliotile pv a.obj --weather w.epw --temperature ground=5", "replay"),
        ] {
            assert!(hint(line).is_some_and(|hint| hint.contains(part)), "{line}: {:?}", hint(line));
        }
        assert_eq!(hint("heliotile run a.obj --wether w.epw"), None);
    }
}
