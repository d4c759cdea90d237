//! The message of an error that ends the program. In: an error. Out: text for people, or a line of
//! JSON for programs, as `HELIOTILE_ERRORS=json` asks.

use std::error::Error as _;
use std::path::Path;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use serde_json::{Map, Value, json};

use super::wording::{option_of, worded};
use heliotile::Error;
use heliotile::requests::{Problem, Wrong};

/// Variable of the environment that, with the value `json`, asks for JSON.
const ERRORS: &str = "HELIOTILE_ERRORS";

/// Returns the message of an error, with a line break at its end.
pub fn report(error: Error) -> String {
    let error = worded(error);
    if !is_json() {
        return format!("heliotile: {error}\n");
    }
    let shown = |path: &Path| path.display().to_string();
    let about = match &error {
        Error::Argument { argument, .. } => json!({ "fields": argument.split(", ").collect::<Vec<_>>() }),
        Error::Input { file, line, .. } => json!({ "file": shown(file), "line": line }),
        Error::Incomplete { partial: path, .. } | Error::Io { path, .. } | Error::SourceChanged { path, .. } => {
            json!({ "file": shown(path) })
        }
        Error::Corrupt { path, block, .. } | Error::Defect { path, block, .. } => {
            json!({ "file": shown(path), "block": block })
        }
        Error::Unsupported { found, .. } => json!({ "found": found }),
        Error::Limit { value, max, .. } => json!({ "found": value, "most": max }),
        _ => json!({}),
    };
    let mut facts = Map::from_iter([("kind".to_owned(), error.kind().into())]);
    let found = error.problem().map(found).unwrap_or_default();
    for more in [about, found] {
        facts.extend(more.as_object().cloned().unwrap_or_default());
    }
    line(facts, &format!("{error:#}"), error.to_string().split_once("\n  to fix: ").map(|(_, fix)| fix))
}

/// Returns the message of a command line that cannot be parsed, if JSON is asked for.
pub fn report_usage(error: &clap::Error) -> Option<String> {
    if !is_json() || !error.use_stderr() {
        return None;
    }
    let words = |context| {
        let words = match error.get(context) {
            Some(ContextValue::String(word)) => std::slice::from_ref(word),
            Some(ContextValue::Strings(words)) => words,
            _ => &[],
        };
        words
            .iter()
            .map(|word| word.trim_start_matches('<').split([' ', '=']).next().unwrap_or_default().into())
            .collect::<Vec<Value>>()
    };
    let fields = [ContextKind::InvalidArg, ContextKind::InvalidSubcommand].map(words).concat();
    let mut facts = Map::from_iter([("kind".into(), "argument".into()), ("fields".into(), fields.into())]);
    facts.extend(words(ContextKind::InvalidValue).pop().map(|found| ("found".into(), found)));
    facts.extend(words(ContextKind::PriorArg).pop().map(|other| ("others".into(), json!([other]))));
    match error.source().and_then(|source| source.downcast_ref::<Wrong>()) {
        Some(wrong) => facts.extend(found(&wrong.problem).as_object().cloned().unwrap_or_default()),
        None => drop(facts.insert("problem".into(), problem_of(error.kind()).into())),
    }
    let text = error.render().to_string();
    let text = text.strip_prefix("error: ").unwrap_or(&text).trim_end();
    Some(line(facts, text, None))
}

/// Returns the name of a problem, and what was found.
fn found(problem: &Problem) -> Value {
    let option = |field: &String| option_of(field).unwrap_or(field).to_owned();
    let mut facts = match problem {
        Problem::Unreadable { found }
        | Problem::Duplicate(found)
        | Problem::OtherKind(found)
        | Problem::OtherVersion(found) => json!({ "found": found }),
        Problem::Unknown { found, known } => json!({ "found": found, "known": known }),
        Problem::OutOfRange { found, least, most } => json!({ "found": found, "least": least, "most": most }),
        Problem::Value { name, found } => json!({ "name": name, "found": found }),
        Problem::NoColumn { column } => json!({ "name": column }),
        Problem::Lacks(name) => json!({ "name": name }),
        Problem::Excludes { other } => json!({ "others": [option(other)] }),
        Problem::Needs { others } => json!({ "others": others.iter().map(option).collect::<Vec<_>>() }),
        Problem::SameFile { other } => json!({ "others": [other] }),
        _ => json!({}),
    };
    facts["problem"] = problem.name().into();
    facts
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
