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
        Error::Argument { argument, .. } => facts([("fields", json!(argument.split(", ").collect::<Vec<_>>()))]),
        Error::Input { file, line, .. } => facts([("file", json!(shown(file))), ("line", json!(line))]),
        Error::Incomplete { partial: path, .. } | Error::Io { path, .. } | Error::SourceChanged { path, .. } => {
            facts([("file", json!(shown(path)))])
        }
        Error::Corrupt { path, block, .. } | Error::Defect { path, block, .. } => {
            facts([("file", json!(shown(path))), ("block", json!(block))])
        }
        Error::Unsupported { found, .. } => facts([("found", json!(found))]),
        Error::Limit { value, max, .. } => facts([("found", json!(value)), ("most", json!(max))]),
        _ => Map::new(),
    };
    let mut all = facts([("kind", error.kind().into())]);
    all.extend(about.into_iter().chain(error.problem().into_iter().flat_map(found)));
    line(all, &format!("{error:#}"), error.to_string().split_once("\n  to fix: ").map(|(_, fix)| fix))
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
    let mut all = facts([("kind", "argument".into()), ("fields", fields.into())]);
    all.extend(words(ContextKind::InvalidValue).pop().map(|found| ("found".into(), found)));
    all.extend(words(ContextKind::PriorArg).pop().map(|other| ("others".into(), json!([other]))));
    match error.source().and_then(|source| source.downcast_ref::<Wrong>()) {
        Some(wrong) => all.extend(found(&wrong.problem)),
        None => all.extend(facts([("problem", problem_of(error.kind()).into())])),
    }
    let text = error.render().to_string();
    let text = text.strip_prefix("error: ").unwrap_or(&text).trim_end();
    Some(line(all, text, None))
}

/// Returns the name of a problem, and what was found.
fn found(problem: &Problem) -> Map<String, Value> {
    let option = |field: &String| option_of(field).unwrap_or(field).to_owned();
    let mut all = match problem {
        Problem::Unreadable { found }
        | Problem::Duplicate(found)
        | Problem::OtherKind(found)
        | Problem::OtherVersion(found) => facts([("found", json!(found))]),
        Problem::Unknown { found, known } => facts([("found", json!(found)), ("known", json!(known))]),
        Problem::OutOfRange { found, least, most } => {
            facts([("found", json!(found)), ("least", json!(least)), ("most", json!(most))])
        }
        Problem::Value { name, found } => facts([("name", json!(name)), ("found", json!(found))]),
        Problem::NoColumn { column } => facts([("name", json!(column))]),
        Problem::Lacks(name) => facts([("name", json!(name))]),
        Problem::Excludes { other } => facts([("others", json!([option(other)]))]),
        Problem::Needs { others } => facts([("others", json!(others.iter().map(option).collect::<Vec<_>>()))]),
        Problem::SameFile { other } => facts([("others", json!([other]))]),
        _ => Map::new(),
    };
    all.insert("problem".into(), problem.name().into());
    all
}

fn facts<const N: usize>(of: [(&str, Value); N]) -> Map<String, Value> {
    of.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
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
