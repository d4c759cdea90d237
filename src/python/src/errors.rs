//! Errors as exceptions. In: an error of the engine. Out: an exception of `heliotile.errors`, with
//! the text that the program prints.

use pyo3::prelude::*;

use heliotile::Error;
use heliotile::cases::{Aim, COMMANDS};
use heliotile::requests::Problem;
use heliotile::text::{Message, Named};
use heliotile_program::option_of;

/// Returns the exception of an error.
pub fn raised(py: Python<'_>, error: Error) -> PyErr {
    exception(py, &about_weather(error).in_words(&in_python)).unwrap_or_else(|failed| failed)
}

/// Fields that describe weather; functions of Python take them from a `Weather`.
const OF_WEATHER: [&str; 6] = ["time_zone", "weather_stamp", "shift", "date_order", "latitude", "longitude"];

/// Adds to the advice of an error about weather where its keywords belong.
fn about_weather(error: Error) -> Error {
    match error {
        Error::Input { file, line, problem, what, hint } if OF_WEATHER.iter().any(|field| hint.names(field)) => {
            let hint = hint.and("; `heliotile.Weather(weather, ...)` takes these keywords");
            Error::Input { file, line, problem, what, hint }
        }
        other => other,
    }
}

/// Returns a text with Python's names of fields and commands.
pub fn worded_text(text: &Message) -> String {
    text.in_words(&in_python)
}

/// Returns the keyword of a request's field, or the command that starts the program from Python.
fn in_python(named: Named) -> Option<String> {
    match named {
        Named::Field(field) => option_of(field).map(|_| keyword(field)),
        Named::Command(words) => Some(format!("python -m heliotile {words}")),
    }
}

/// Returns Python's keyword for a field of a request.
fn keyword(field: &str) -> String {
    // Days bound more results than archives before a change.
    let named = COMMANDS.iter().rev().filter(|command| field != "from" || command.aim == Aim::Ask);
    let row = named.flat_map(|command| (command.rows)()).find(|row| row.name == field);
    row.map_or_else(
        || field.to_owned(),
        |row| if row.is_off() { format!("{}=False", row.in_python()) } else { row.in_python().to_owned() },
    )
}

fn exception(py: Python<'_>, error: &Error) -> PyResult<PyErr> {
    let class = match error {
        Error::Input { .. } => "InputError",
        Error::Argument { .. } => "ArgumentError",
        Error::Incomplete { .. } => "IncompleteError",
        Error::Stopped { .. } => "StoppedError",
        Error::Io { source, .. } if source.kind() == std::io::ErrorKind::NotFound => "MissingFileError",
        Error::Io { .. } => "FileError",
        Error::Corrupt { .. } | Error::Defect { .. } => "CorruptError",
        Error::SourceChanged { .. } => "ChangedError",
        Error::Unsupported { .. } => "UnsupportedError",
        Error::Limit { .. } => "LimitError",
        // The base class, for errors that get a class of their own later.
        _ => "Error",
    };
    let made = py.import("heliotile.errors")?.getattr(class)?.call1((error.to_string(),))?;
    match error {
        Error::Input { file, line, what, hint, .. } => {
            made.setattr("file", file)?;
            made.setattr("line", line)?;
            made.setattr("what", what.plain())?;
            made.setattr("hint", hint.plain())?;
        }
        Error::Incomplete { partial: file, what, hint } => {
            made.setattr("file", file)?;
            made.setattr("what", what.plain())?;
            made.setattr("hint", hint.plain())?;
        }
        Error::Argument { argument, what, hint, .. } => {
            made.setattr("argument", argument)?;
            made.setattr("what", what.plain())?;
            made.setattr("hint", hint.plain())?;
        }
        Error::Io { path, .. } | Error::SourceChanged { path, .. } => made.setattr("file", path)?,
        Error::Corrupt { path, block, offset, hint, .. } => {
            made.setattr("file", path)?;
            made.setattr("block", block)?;
            made.setattr("offset", offset)?;
            made.setattr("hint", hint.plain())?;
        }
        Error::Defect { path, block, what, hint, .. } => {
            made.setattr("file", path)?;
            made.setattr("block", block)?;
            made.setattr("what", what)?;
            made.setattr("hint", hint.plain())?;
        }
        _ => {}
    }
    if let Some(problem) = error.problem() {
        made.setattr("problem", problem.name())?;
        match problem {
            Problem::Unknown { found, known } => {
                made.setattr("found", found)?;
                made.setattr("known", known)?;
            }
            Problem::OutOfRange { found, least, most } => {
                made.setattr("found", found)?;
                made.setattr("range", (least, most))?;
            }
            Problem::Unreadable { found }
            | Problem::Duplicate(found)
            | Problem::OtherKind(found)
            | Problem::OtherVersion(found) => made.setattr("found", found)?,
            Problem::Value { name, found } => {
                made.setattr("name", name)?;
                made.setattr("found", found)?
            }
            Problem::Lacks(name) => made.setattr("name", name)?,
            Problem::NoColumn { column } => made.setattr("column", column)?,
            Problem::Excludes { other } => made.setattr("other", keyword(other))?,
            Problem::Needs { others } => {
                made.setattr("other", others.iter().map(|name| keyword(name)).collect::<Vec<_>>())?
            }
            Problem::SameFile { other } => made.setattr("other", other)?,
            _ => {}
        }
    }
    Ok(PyErr::from_value(made))
}
