//! The one error type of the crate: every message says what was being done, to which file, what was found, what to do. It names fields of
//! requests and commands in braces, as in `{every}` and `{command:verify}`; who shows it puts it into a user's words first ([`Error::in_words`]).

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use crate::text::{Named, Words, with_fields};

/// Result of everything that can fail.
pub type Result<T> = std::result::Result<T, Error>;

/// Why an operation could not be done. None of these is a panic; all of them end the program with exit code 2.
#[derive(Debug)]
#[non_exhaustive]
pub enum Error {
    /// A file given by the user holds something that cannot be used.
    Input {
        /// The file, as it was named.
        file: PathBuf,
        /// 1-based line, where the format has lines.
        line: Option<usize>,
        /// What was found.
        what: String,
        /// What to do.
        hint: String,
    },
    /// An interrupted build lies where an archive is to be written; what can be done depends on the command.
    Incomplete {
        /// The file of the interrupted build.
        partial: PathBuf,
        /// What it is.
        what: String,
        /// What to do.
        hint: String,
    },
    /// Work that the user asked to stop; what was finished is kept where that is said.
    Stopped {
        /// What had been done by then.
        what: String,
    },
    /// The operating system refused.
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was tried: `read`, `create`, `sync`.
        action: &'static str,
        /// What the system said.
        source: io::Error,
    },
    /// An archive's bytes are not what was written.
    Corrupt {
        /// The archive.
        path: PathBuf,
        /// Name of the block, such as `sky/3`, or of the part (`header`, `directory`, `manifest`).
        block: String,
        /// Where that starts in the file, bytes.
        offset: u64,
        /// What was found.
        got: String,
        /// What stands there in a good archive.
        expected: String,
        /// What to do.
        hint: Box<str>,
    },
    /// What is read is another one than when it was opened; nothing of both was mixed.
    SourceChanged {
        /// The archive.
        path: PathBuf,
        /// How that showed.
        what: String,
    },
    /// Blocks that are each as they were written do not fit together: what was checked when they were read does not hold.
    Defect {
        /// The archive.
        path: PathBuf,
        /// Name of the block that says something of another, such as `probes/3`.
        block: String,
        /// Its part.
        field: &'static str,
        /// What does not hold.
        what: String,
        /// What to do.
        hint: Box<str>,
    },
    /// A field of a request has a value that cannot be used.
    Argument {
        /// The field, `set`, or several: `latitude, longitude`.
        argument: String,
        /// What is wrong with it.
        what: String,
        /// What to do.
        hint: String,
    },
    /// The file or the request is valid, but this release cannot do it.
    Unsupported {
        /// What was being done, to which file.
        what: String,
        /// What was found.
        found: String,
        /// What this release can do.
        supported: String,
    },
    /// A number is beyond a stated limit.
    Limit {
        /// What the number counts.
        what: String,
        /// The number.
        value: u64,
        /// The largest one allowed.
        max: u64,
    },
}

impl Error {
    /// An error in a line of an input file.
    pub fn input(
        file: &Path,
        line: impl Into<Option<usize>>,
        what: impl Into<String>,
        hint: impl Into<String>,
    ) -> Self {
        Error::Input { file: file.to_path_buf(), line: line.into(), what: what.into(), hint: hint.into() }
    }

    /// Bytes of a block, or of another part of an archive, that are not those that were written.
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

    /// A broken invariant of a block.
    pub fn defect(path: &Path, block: impl Into<String>, field: &'static str, what: impl Into<String>) -> Self {
        let hint = format!(
            "run `{{command:verify_deep}} {}`; if it finds nothing, report this defect with the archive's root",
            path.display()
        );
        Error::Defect { path: path.to_path_buf(), block: block.into(), field, what: what.into(), hint: hint.into() }
    }

    /// A wrong value of a field of a request.
    pub fn argument(argument: impl Into<String>, what: impl Into<String>, hint: impl Into<String>) -> Self {
        Error::Argument { argument: argument.into(), what: what.into(), hint: hint.into() }
    }

    /// The error with the names that a user knows, of fields of requests and of commands, which its texts hold in braces, as in `{every}`.
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
                // Who holds bytes from afar says more of them.
                let source = source.downcast::<Error>().map(|inner| io::Error::new(kind, inner.in_words(words)));
                Error::Io { path, action, source: source.unwrap_or_else(|source| source) }
            }
            error @ (Error::Stopped { .. } | Error::SourceChanged { .. }) => error,
        }
    }

    /// What the command that runs offers where an interrupted build lies.
    pub fn advise(self, advice: &str) -> Self {
        match self {
            Error::Incomplete { partial, what, .. } => Error::Incomplete { partial, what, hint: advice.to_string() },
            other => other,
        }
    }

    /// Bytes that could not be read, for `map_err`; who holds them from afar may know more of it than a file system does.
    pub fn unread(path: &Path) -> impl FnOnce(io::Error) -> Self + '_ {
        move |error| error.downcast::<Error>().unwrap_or_else(Error::io(path, "read"))
    }

    /// For `map_err`: `File::open(p).map_err(Error::io(p, "open"))`.
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
                "{}: has changed while it was read: {what}\n  to fix: do it again, then the new one is read",
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

    /// Both messages of two lines name what is wrong and what to do: a defect its file, block and field, an argument the field of the request;
    /// the 3 names in them are said in the words of a face.
    #[test]
    fn messages() {
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
