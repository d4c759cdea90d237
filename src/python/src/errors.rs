//! Errors as exceptions. In: an error of the engine. Out: its class of `heliotile.errors`, with the text that the program prints.

use pyo3::prelude::*;

use heliotile_core::error::Error;

/// The exception of an error.
pub fn raised(py: Python<'_>, error: Error) -> PyErr {
    exception(py, &error.in_words(&str::to_owned)).unwrap_or_else(|failed| failed)
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
        Error::Corrupt { path, block, offset, .. } => {
            made.setattr("file", path)?;
            made.setattr("block", block)?;
            made.setattr("offset", offset)?;
        }
        Error::Defect { path, block, .. } => {
            made.setattr("file", path)?;
            made.setattr("block", block)?;
        }
        Error::Stopped { .. } | Error::Unsupported { .. } | Error::Limit { .. } => {}
    }
    Ok(PyErr::from_value(made))
}

/// For `map_err` of texts of options: `text.parse().map_err(wrong("sky", text))`.
pub fn wrong<E: std::fmt::Display>(argument: &'static str, hint: &'static str) -> impl FnOnce(E) -> Error {
    move |what| Error::argument(argument, what.to_string(), hint)
}
