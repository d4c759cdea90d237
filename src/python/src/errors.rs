//! Errors as exceptions. In: an error of the engine. Out: an exception of `heliotile.errors`, with
//! the text that the program prints.

use pyo3::prelude::*;

use heliotile::Error;
use heliotile::text::{Named, with_fields};
use heliotile_program::{command_of, option_of};

/// Returns the exception of an error.
pub fn raised(py: Python<'_>, error: Error) -> PyErr {
    exception(py, &about_weather(error).in_words(&in_python)).unwrap_or_else(|failed| failed)
}

/// Fields that describe weather; functions of Python take them from a `Weather`.
const OF_WEATHER: [&str; 5] =
    ["{time_zone}", "{weather_stamp}", "{shift}", "{date_order}", "{latitude} and {longitude} in degrees"];

/// Adds to the advice of an error about weather where its keywords belong.
fn about_weather(error: Error) -> Error {
    match error {
        Error::Input { file, line, what, hint } if OF_WEATHER.iter().any(|field| hint.contains(field)) => {
            Error::Input { file, line, what, hint: hint + "; `heliotile.Weather(weather, ...)` takes these keywords" }
        }
        other => other,
    }
}

/// Returns a text with Python's names of fields and commands.
pub fn worded_text(text: &str) -> String {
    with_fields(text, &in_python)
}

/// Returns the keyword of a request's field, or the command that starts the program from Python.
fn in_python(named: Named) -> Option<String> {
    match named {
        Named::Field(field) => option_of(field).map(|_| keyword(field).to_owned()),
        Named::Command(command) => Some(format!("python -m heliotile {}", command_of(command)?)),
    }
}

/// Returns Python's keyword for a field of a request: the name on the command line, with these
/// exceptions.
fn keyword(field: &str) -> &str {
    match field {
        "from" => "start",
        "to" => "end",
        "weather_stamp" => "stamp",
        "set" => "settings",
        "surface" => "surfaces",
        "object" => "objects",
        "no_ground" => "ground=False",
        "no_scene" => "with_scene=False",
        "io" => "access",
        "rule" => "rules",
        field => field,
    }
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
        Error::Input { file, line, what, hint } => {
            made.setattr("file", file)?;
            made.setattr("line", line)?;
            made.setattr("what", what)?;
            made.setattr("hint", hint)?;
        }
        Error::Incomplete { partial: file, what, hint } => {
            made.setattr("file", file)?;
            made.setattr("what", what)?;
            made.setattr("hint", hint)?;
        }
        Error::Argument { argument, what, hint } => {
            made.setattr("argument", argument)?;
            made.setattr("what", what)?;
            made.setattr("hint", hint)?;
        }
        Error::Io { path, .. } | Error::SourceChanged { path, .. } => made.setattr("file", path)?,
        Error::Corrupt { path, block, offset, hint, .. } => {
            made.setattr("file", path)?;
            made.setattr("block", block)?;
            made.setattr("offset", offset)?;
            made.setattr("hint", &**hint)?;
        }
        Error::Defect { path, block, what, hint, .. } => {
            made.setattr("file", path)?;
            made.setattr("block", block)?;
            made.setattr("what", what)?;
            made.setattr("hint", &**hint)?;
        }
        _ => {}
    }
    Ok(PyErr::from_value(made))
}

/// Returns a function for `map_err` that names the argument: `text.parse().map_err(wrong("sky",
/// hint))`.
pub fn wrong<E: std::fmt::Display>(argument: &'static str, hint: &'static str) -> impl FnOnce(E) -> Error {
    move |what| Error::argument(argument, what.to_string(), hint)
}
