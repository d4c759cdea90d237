//! The one error type of the crate. Every message says what was being done, to which file, what was
//! found and what to do. A message names fields of requests and commands in braces, as in `{every}`
//! and `{command:verify}`; the program that shows it first puts the names that its user knows in
//! their place ([`Error::in_words`]).

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use crate::text::{Named, Words, with_fields};

/// Result of every function that can fail.
pub type Result<T> = std::result::Result<T, Error>;

/// Reason why an operation could not be done. Errors are never panics, and each ends the program
/// with exit code 2.
#[derive(Debug)]
#[non_exhaustive]
pub enum Error {
    /// A file given by the user holds something that cannot be used.
    Input {
        /// The file, as it was named.
        file: PathBuf,
        /// Line, counted from 1, where the format has lines.
        line: Option<usize>,
        /// Description of what was found.
        what: String,
        /// Advice on what to do.
        hint: String,
    },
    /// An interrupted build lies where an archive is to be written. The possible remedies depend on
    /// the command.
    Incomplete {
        /// The file of the interrupted build.
        partial: PathBuf,
        /// Description of the file.
        what: String,
        /// Advice on what to do.
        hint: String,
    },
    /// The user asked for the work to stop. Finished work is kept where `what` says so.
    Stopped {
        /// Description of what had been done by then.
        what: String,
    },
    /// The operating system refused an operation.
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The operation: `read`, `create`, `sync`.
        action: &'static str,
        /// The error of the system.
        source: io::Error,
    },
    /// An archive's bytes are not what was written.
    Corrupt {
        /// The archive.
        path: PathBuf,
        /// Name of the block, such as `sky/3`, or of the part (`header`, `directory`, `manifest`).
        block: String,
        /// Offset in the file where the block or part starts, bytes.
        offset: u64,
        /// Description of what was found.
        got: String,
        /// Description of what stands there in a good archive.
        expected: String,
        /// Advice on what to do.
        hint: Box<str>,
    },
    /// The archive has changed since it was opened. Data of the two versions were not mixed.
    SourceChanged {
        /// The archive.
        path: PathBuf,
        /// Description of the sign of the change.
        what: String,
    },
    /// Blocks that are intact each by itself do not fit together: an invariant that was checked
    /// when they were read does not hold.
    Defect {
        /// The archive.
        path: PathBuf,
        /// Name of the block with the broken reference, such as `probes/3`.
        block: String,
        /// Field of the block.
        field: &'static str,
        /// Description of what does not hold.
        what: String,
        /// Advice on what to do.
        hint: Box<str>,
    },
    /// A field of a request has a value that cannot be used.
    Argument {
        /// Name of the field, such as `set`, or several: `latitude, longitude`.
        argument: String,
        /// Description of what is wrong with the value.
        what: String,
        /// Advice on what to do.
        hint: String,
    },
    /// The file or the request is valid, but this release cannot do it.
    Unsupported {
        /// Description of what was being done, to which file.
        what: String,
        /// Description of what was found.
        found: String,
        /// Description of what this release supports.
        supported: String,
    },
    /// A number is beyond a stated limit.
    Limit {
        /// Description of what the number counts.
        what: String,
        /// The number.
        value: u64,
        /// The largest one allowed.
        max: u64,
    },
}

impl Error {
    /// Returns the error of a line of an input file.
    pub fn input(
        file: &Path,
        line: impl Into<Option<usize>>,
        what: impl Into<String>,
        hint: impl Into<String>,
    ) -> Self {
        Error::Input { file: file.to_path_buf(), line: line.into(), what: what.into(), hint: hint.into() }
    }

    /// Returns the error of a block, or of another part of an archive, whose bytes are not those
    /// that were written.
    pub fn corrupt(
        path: &Path,
        block: impl Into<String>,
        offset: u64,
        got: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        let hint = format!(
            "run `{{command:verify}} {}` for the full list, `{{command:repair}}`, or restore a copy",
            path.display()
        );
        let (path, block, hint) = (path.to_path_buf(), block.into(), hint.into());
        Error::Corrupt { path, block, offset, got: got.into(), expected: expected.into(), hint }
    }

    /// Returns the error of a broken invariant of a block.
    pub fn defect(path: &Path, block: impl Into<String>, field: &'static str, what: impl Into<String>) -> Self {
        let hint = format!(
            "run `{{command:verify_deep}} {}`; if it finds nothing, report this defect with the archive's root",
            path.display()
        );
        Error::Defect { path: path.to_path_buf(), block: block.into(), field, what: what.into(), hint: hint.into() }
    }

    /// Returns the error of a wrong value of a field of a request.
    pub fn argument(argument: impl Into<String>, what: impl Into<String>, hint: impl Into<String>) -> Self {
        Error::Argument { argument: argument.into(), what: what.into(), hint: hint.into() }
    }

    /// Returns the error with the user's names in place of the names in braces, such as `{every}`,
    /// of request fields and commands.
    pub fn in_words(self, words: &Words) -> Self {
        let text = |text: String| with_fields(&text, words);
        let field = |field: &str| words(Named::Field(field)).unwrap_or_else(|| field.to_owned());
        match self {
            Error::Input { file, line, what, hint } => Error::Input { file, line, what: text(what), hint: text(hint) },
            Error::Incomplete { partial, what, hint } => {
                Error::Incomplete { partial, what: text(what), hint: text(hint) }
            }
            Error::Argument { argument, what, hint } => {
                let argument = argument.split(", ").map(field).collect::<Vec<_>>().join(", ");
                Error::Argument { argument, what: text(what), hint: text(hint) }
            }
            Error::Unsupported { what, found, supported } => {
                Error::Unsupported { what: text(what), found, supported: text(supported) }
            }
            Error::Limit { what, value, max } => Error::Limit { what: text(what), value, max },
            Error::Corrupt { path, block, offset, got, expected, hint } => {
                Error::Corrupt { path, block, offset, got, expected, hint: with_fields(&hint, words).into() }
            }
            Error::Defect { path, block, field, what, hint } => {
                Error::Defect { path, block, field, what, hint: with_fields(&hint, words).into() }
            }
            Error::Io { path, action, source } => {
                let kind = source.kind();
                // The inner error, from a remote reader for example, has braces of its own to fill.
                let source = source.downcast::<Error>().map(|inner| io::Error::new(kind, inner.in_words(words)));
                Error::Io { path, action, source: source.unwrap_or_else(|source| source) }
            }
            error @ (Error::Stopped { .. } | Error::SourceChanged { .. }) => error,
        }
    }

    /// Replaces the hint of [`Error::Incomplete`] by the advice of the command that runs; other
    /// errors stay.
    pub fn advise(self, advice: &str) -> Self {
        match self {
            Error::Incomplete { partial, what, .. } => Error::Incomplete { partial, what, hint: advice.to_string() },
            other => other,
        }
    }

    /// Returns a function for `map_err` on reads. It unpacks an [`Error`] that a remote reader put
    /// into the I/O error, because that error tells more than a file system does.
    pub fn unread(path: &Path) -> impl FnOnce(io::Error) -> Self + '_ {
        move |error| error.downcast::<Error>().unwrap_or_else(Error::io(path, "read"))
    }

    /// Returns a function for `map_err`: `File::open(p).map_err(Error::io(p, "open"))`.
    pub fn io<'a>(path: &'a Path, action: &'static str) -> impl FnOnce(io::Error) -> Self + 'a {
        move |source| Error::Io { path: path.to_path_buf(), action, source }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Input { file, line, what, hint } => {
                write!(f, "{}", file.display())?;
                if let Some(line) = line {
                    write!(f, ", line {line}")?;
                }
                write!(f, ": {what}")?;
                if !hint.is_empty() {
                    write!(f, "\n  to fix: {hint}")?;
                }
                Ok(())
            }
            Error::Incomplete { partial, what, hint } => write!(f, "{}: {what}\n  to fix: {hint}", partial.display()),
            Error::Stopped { what } => write!(f, "stopped {what}"),
            Error::Io { path, action, source } => write!(f, "cannot {action} {}: {source}", path.display()),
            Error::Corrupt { path, block, offset, got, expected, hint } => write!(
                f,
                "{}: block {block} at byte {offset} is damaged: found {got}, expected {expected}\n  to fix: {hint}",
                path.display()
            ),
            Error::SourceChanged { path, what } => write!(
                f,
                "{}: has changed while it was read: {what}\n  to fix: try again to read the new archive",
                path.display()
            ),
            Error::Defect { path, block, field, what, hint } => write!(
                f,
                "{}: block {block}, {field}: {what}: a fault of the program, or a file that was forged\n  to fix: {hint}",
                path.display()
            ),
            Error::Argument { argument, what, hint } => write!(f, "{argument}: {what}\n  to fix: {hint}"),
            Error::Unsupported { what, found, supported } => {
                write!(f, "{what}: found {found}, this release supports {supported}")
            }
            Error::Limit { what, value, max } => {
                write!(f, "{what} is {value}, the limit is {max}")
            }
        }
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Error::Io { source, .. } => Some(source),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A message has two lines: what is wrong, and what to do. A defect names its file, block and
    /// field, an argument its request field. The 3 names in braces become the words of the
    /// interface.
    #[test]
    fn a_message_says_what_is_wrong_and_what_to_do() {
        let text = Error::defect(Path::new("a.helio"), "probes/3", "seen", "names no cell").to_string();
        assert!(text.starts_with("a.helio: block probes/3, seen: names no cell: a fault of the program"), "{text}");
        assert_eq!((text.lines().count(), text.contains("{command:verify_deep} a.helio")), (2, true));
        let error = Error::argument("set, sky", "hit is 3", "leave {set} out, see `{command:info}`");
        let words = |named: Named| match named {
            Named::Field("sky") => None,
            Named::Field(field) => Some(format!("--{field}")),
            Named::Command(command) => Some(format!("heliotile {command}")),
        };
        let text = error.in_words(&words).to_string();
        assert_eq!(text, "--set, sky: hit is 3\n  to fix: leave --set out, see `heliotile info`");
    }
}
