//! The command line as files record it. In: the command line. Out: [`Provenance`]: the command
//! without options that change no values, and every option with its value.

use std::ffi::OsString;

use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Command};
use serde_json::{Map, Number, Value};

use super::shell_words::quoted;
use crate::cli::{Case, command_line};
use heliotile::Provenance;
use heliotile::text::without_secrets;

/// Returns the provenance that files state, from the matches of a command line. Paths stay as they
/// were typed.
pub fn provenance(matches: &ArgMatches) -> Provenance {
    of(&command_line(), matches)
}

/// Returns the command line that resumes stopped work: the same one, without `--fresh`, which would
/// discard what was kept.
pub fn again(words: &[OsString]) -> String {
    let words = words.iter().map(|word| word.to_string_lossy()).filter(|word| word != "--fresh");
    words.map(|word| quoted(&without_secrets(&word))).collect::<Vec<_>>().join(" ")
}

fn of(cli: &Command, matches: &ArgMatches) -> Provenance {
    let (mut command, mut matches) = (cli, matches);
    let mut words = vec![cli.get_name().to_string()];
    while let Some((name, inside)) = matches.subcommand() {
        let Some(found) = command.find_subcommand(name) else { break };
        words.push(name.to_string());
        (command, matches) = (found, inside);
    }
    let case = words.get(1).and_then(|name| Case::of(name));
    let mut options = Map::new();
    for arg in command.get_arguments() {
        let id = arg.get_id().as_str();
        let is_stated = case.is_none_or(|case| case.states(id));
        let (Ok(Some(raw)), true) = (matches.try_get_raw(id), is_stated) else { continue };
        let values: Vec<String> = raw.map(|value| without_secrets(&value.to_string_lossy())).collect();
        let is_flag = !arg.get_action().takes_values();
        let typed = matches.value_source(id) == Some(ValueSource::CommandLine);
        // A flag that was not typed is false, and is left out.
        if is_flag && !typed {
            continue;
        }
        if typed {
            words.extend(typed_words(arg, &values, is_flag));
        }
        let value = match values.as_slice() {
            _ if is_flag => Value::Bool(true),
            [one] if !matches!(arg.get_action(), ArgAction::Append) => value_of(one),
            all => all.iter().map(|one| value_of(one)).collect(),
        };
        options.insert(id.to_string(), value);
    }
    Provenance::new(words.join(" "), options)
}

/// Returns an argument as words of a command line.
fn typed_words(arg: &Arg, values: &[String], is_flag: bool) -> Vec<String> {
    let name = arg.get_long().map(|long| format!("--{long}"));
    match name {
        Some(name) if is_flag => vec![name],
        Some(name) => values.iter().flat_map(|value| [name.clone(), quoted(value)]).collect(),
        None => values.iter().map(|value| quoted(value)).collect(),
    }
}

/// Returns a JSON number if the word is one, else a string.
fn value_of(word: &str) -> Value {
    word.parse::<Number>().map_or_else(|_| Value::from(word), Value::Number)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(line: &str) -> Vec<(String, String)> {
        let cli = command_line();
        let matches = cli.clone().try_get_matches_from(line.split('|')).expect("a command line");
        of(&cli, &matches).entries()
    }

    /// The recorded command leaves out the output, the memory and the way of reading, and has one
    /// order whatever was typed, with 1 word quoted. Options have their defaults, numbers are
    /// numbers, repeatable options are lists.
    #[test]
    fn a_recorded_command_has_one_order() {
        let one = "heliotile|replay|a b.helio|--year|2019|-w|x.epw|-o|t.csv|--io|map|--reflectance|roof=0.3";
        let other = "heliotile|replay|--reflectance=roof=0.3|--weather=x.epw|a b.helio|--memory|1GiB|--year|2019";
        let entries_of_one = entries(one);
        assert_eq!(entries_of_one, entries(other));
        assert_eq!(
            entries_of_one[1].1,
            "heliotile replay 'a b.helio' --reflectance roof=0.3 --weather x.epw --year 2019"
        );
        let options: Value = serde_json::from_str(&entries_of_one[2].1).expect("JSON");
        assert_eq!((&options["year"], &options["every"]), (&Value::from(2019), &Value::from("hour")));
        assert_eq!(options["reflectance"], Value::from(vec!["roof=0.3"]));
        assert_eq!(options.get("output"), None);
    }

    /// A flag that was typed is `true`; a flag that was not typed is left out.
    #[test]
    fn only_flags_that_were_typed_are_recorded() {
        let options = |line: &str| serde_json::from_str::<Value>(&entries(line)[2].1).expect("JSON");
        let with = options("heliotile|export|site.helio|--view-factors|-o|v.csv");
        assert_eq!(with["view_factors"], Value::Bool(true));
        assert_eq!(options("heliotile|export|site.helio|-r|a|-o|v.png").get("view_factors"), None);
    }
}
