//! The message of an error that ends the program. In: an error. Out: text for people, or a line of
//! JSON for programs, as `HELIOTILE_ERRORS=json` asks.

use std::error::Error as _;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use serde_json::{Map, Value, json};

use super::wording::worded;
use heliotile::Error;
use heliotile::requests::Wrong;

/// Variable of the environment that, with the value `json`, asks for JSON.
const ERRORS: &str = "HELIOTILE_ERRORS";

/// Returns the message of an error, with a line break at its end.
pub fn report(error: Error) -> String {
    let error = worded(error);
    if !is_json() {
        return format!("heliotile: {error}\n");
    }
    let mut facts = Map::new();
    let mut state = |name: &str, value: Value| facts.insert(name.into(), value);
    state("kind", error.kind().into());
    if let Some(problem) = error.problem() {
        state("problem", problem.name().into());
    }
    match &error {
        Error::Argument { argument, .. } => {
            state("fields", argument.split(", ").collect());
        }
        Error::Input { file, line, .. } => {
            state("file", file.display().to_string().into());
            state("line", json!(line));
        }
        Error::Io { path, .. } | Error::Corrupt { path, .. } | Error::Defect { path, .. } => {
            state("file", path.display().to_string().into());
        }
        _ => {}
    }
    line(facts, &format!("{error:#}"), error.to_string().split_once("\n  to fix: ").map(|(_, fix)| fix))
}

/// Returns the message of a command line that cannot be parsed, if JSON is asked for.
pub fn report_usage(error: &clap::Error) -> Option<String> {
    if !is_json() || !error.use_stderr() {
        return None;
    }
    let word = |context| match error.get(context)? {
        ContextValue::String(word) => Some(word.split([' ', '=']).next().unwrap_or_default().to_owned()),
        _ => None,
    };
    let fields: Vec<String> =
        word(ContextKind::InvalidArg).or_else(|| word(ContextKind::InvalidSubcommand)).into_iter().collect();
    let wrong = error.source().and_then(|source| source.downcast_ref::<Wrong>());
    let problem = wrong.map_or_else(|| problem_of(error.kind()), |wrong| wrong.problem.name());
    let facts = [("kind", "argument".into()), ("problem", problem.into()), ("fields", json!(fields))];
    let text = error.render().to_string();
    let text = text.strip_prefix("error: ").unwrap_or(&text).trim_end();
    Some(line(facts.into_iter().map(|(name, value)| (name.to_owned(), value)).collect(), text, None))
}

fn is_json() -> bool {
    std::env::var_os(ERRORS).is_some_and(|value| value == "json")
}

fn line(mut facts: Map<String, Value>, message: &str, fix: Option<&str>) -> String {
    facts.insert("message".into(), message.into());
    facts.extend(fix.map(|fix| ("fix".to_owned(), fix.into())));
    Value::Object(facts).to_string() + "\n"
}

/// Returns the name of the problem that a command line has, as requests name it.
fn problem_of(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::InvalidValue | ErrorKind::UnknownArgument | ErrorKind::InvalidSubcommand => "unknown",
        ErrorKind::MissingRequiredArgument | ErrorKind::MissingSubcommand => "missing",
        ErrorKind::ArgumentConflict => "excludes",
        _ => "other",
    }
}
