//! The one error type of the crate. Every message says what was being done, to which file, what was
//! found and what to do. Messages name fields of requests and commands; the program that shows them
//! first puts the names that its user knows in their place ([`Error::in_words`]).

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

pub use heliotile_requests::Problem;
use heliotile_requests::{Message, Named, Refused, Request, Words, message};

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
        /// Kind of the problem.
        problem: Box<Problem>,
        /// Description of what was found.
        what: Message,
        /// Advice on what to do; empty if the description says it.
        hint: Message,
    },
    /// An interrupted build lies where an archive is to be written. The possible remedies depend on
    /// the command.
    Incomplete {
        /// The file of the interrupted build.
        partial: PathBuf,
        /// Description of the file.
        what: Message,
        /// Advice on what to do.
        hint: Message,
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
        hint: Message,
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
        hint: Message,
    },
    /// A field of a request has a value that cannot be used.
    Argument {
        /// Name of the field, such as `set`, or several: `latitude, longitude`.
        argument: String,
        /// Kind of the problem.
        problem: Box<Problem>,
        /// Description of what is wrong with the value.
        what: Message,
        /// Advice on what to do; empty if the description says it.
        hint: Message,
    },
    /// The file or the request is valid, but this release cannot do it.
    Unsupported {
        /// Description of what was being done, to which file.
        what: Message,
        /// Description of what was found.
        found: String,
        /// Description of what this release supports.
        supported: Message,
    },
    /// A number is beyond a stated limit.
    Limit {
        /// Description of what the number counts.
        what: Message,
        /// The number.
        value: u64,
        /// The largest one allowed.
        max: u64,
    },
}

/// Refuses a request with a number outside of the range of its field.
pub fn check_ranges(request: &impl Request) -> Result<()> {
    request.in_range().map_err(Error::refused)
}

impl Error {
    /// Returns the error of a line of an input file.
    pub fn input(
        file: &Path,
        line: impl Into<Option<usize>>,
        what: impl Into<Message>,
        hint: impl Into<Message>,
    ) -> Self {
        let (file, line, problem) = (file.to_path_buf(), line.into(), Box::default());
        Error::Input { file, line, problem, what: what.into(), hint: hint.into() }
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
        let hint = message!(
            "run `{{command:archive verify}} {}` for the full list, `{{command:archive repair}}`, or restore a copy",
            path.display()
        );
        let (path, block) = (path.to_path_buf(), block.into());
        Error::Corrupt { path, block, offset, got: got.into(), expected: expected.into(), hint }
    }

    /// Returns the error of a broken invariant of a block.
    pub fn defect(path: &Path, block: impl Into<String>, field: &'static str, what: impl Into<String>) -> Self {
        let hint = message!(
            "run `{{command:archive verify --deep}} {}`; if it finds nothing, report this defect with the archive's root",
            path.display()
        );
        Error::Defect { path: path.to_path_buf(), block: block.into(), field, what: what.into(), hint }
    }

    /// Returns the error of a wrong value of a field of a request.
    pub fn argument(argument: impl Into<String>, what: impl Into<Message>, hint: impl Into<Message>) -> Self {
        Error::Argument { argument: argument.into(), problem: Box::default(), what: what.into(), hint: hint.into() }
    }

    /// Returns the error of a refused request.
    pub fn refused(refused: Refused) -> Self {
        let Refused { fields, problem, what, hint } = refused;
        Error::argument(fields.join(", "), what, hint).because(problem)
    }

    /// Returns the error of an input file, or of an argument, with the kind of its problem.
    pub fn because(mut self, kind: Problem) -> Self {
        if let Error::Input { problem, .. } | Error::Argument { problem, .. } = &mut self {
            **problem = kind;
        }
        self
    }

    /// Returns the name of the kind.
    pub fn kind(&self) -> &'static str {
        match self {
            Error::Input { .. } => "input",
            Error::Argument { .. } => "argument",
            Error::Incomplete { .. } => "incomplete",
            Error::Stopped { .. } => "stopped",
            Error::Io { source, .. } if source.kind() == io::ErrorKind::NotFound => "missing-file",
            Error::Io { .. } => "file",
            Error::Corrupt { .. } => "corrupt",
            Error::SourceChanged { .. } => "changed",
            Error::Defect { .. } => "defect",
            Error::Unsupported { .. } => "unsupported",
            Error::Limit { .. } => "limit",
        }
    }

    /// Returns the kind of the problem of an input file or of an argument.
    pub fn problem(&self) -> Option<&Problem> {
        match self {
            Error::Input { problem, .. } | Error::Argument { problem, .. } => Some(problem),
            _ => None,
        }
    }

    /// Returns the error with the user's names of the request fields and commands that it names.
    pub fn in_words(self, words: &Words) -> Self {
        let text = |message: Message| Message::from(message.in_words(words));
        let field = |field: &str| words(Named::Field(field)).unwrap_or_else(|| field.to_owned());
        match self {
            Error::Input { file, line, problem, what, hint } => {
                Error::Input { file, line, problem, what: text(what), hint: text(hint) }
            }
            Error::Incomplete { partial, what, hint } => {
                Error::Incomplete { partial, what: text(what), hint: text(hint) }
            }
            Error::Argument { argument, problem, what, hint } => {
                let argument = argument.split(", ").map(field).collect::<Vec<_>>().join(", ");
                Error::Argument { argument, problem, what: text(what), hint: text(hint) }
            }
            Error::Unsupported { what, found, supported } => {
                Error::Unsupported { what: text(what), found, supported: text(supported) }
            }
            Error::Limit { what, value, max } => Error::Limit { what: text(what), value, max },
            Error::Corrupt { path, block, offset, got, expected, hint } => {
                Error::Corrupt { path, block, offset, got, expected, hint: text(hint) }
            }
            Error::Defect { path, block, field, what, hint } => {
                Error::Defect { path, block, field, what, hint: text(hint) }
            }
            Error::Io { path, action, source } => {
                let kind = source.kind();
                // The inner error, from a remote reader for example, has names of its own.
                let source = source.downcast::<Error>().map(|inner| io::Error::new(kind, inner.in_words(words)));
                Error::Io { path, action, source: source.unwrap_or_else(|source| source) }
            }
            error @ (Error::Stopped { .. } | Error::SourceChanged { .. }) => error,
        }
    }

    /// Replaces the hint of [`Error::Incomplete`] by the advice of the command that runs; other
    /// errors stay.
    pub fn advise(self, advice: &'static str) -> Self {
        match self {
            Error::Incomplete { partial, what, .. } => Error::Incomplete { partial, what, hint: advice.into() },
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

/// `{:#}` leaves out what to do, for a message of its own.
impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Input { file, line, what, hint, .. } => {
                write!(f, "{}", file.display())?;
                if let Some(line) = line {
                    write!(f, ", line {line}")?;
                }
                write!(f, ": {}", what.plain())?;
                to_fix(f, hint)
            }
            Error::Incomplete { partial, what, hint } => {
                write!(f, "{}: {}", partial.display(), what.plain())?;
                to_fix(f, hint)
            }
            Error::Stopped { what } => write!(f, "stopped {what}"),
            Error::Io { path, action, source } => write!(f, "cannot {action} {}: {source}", path.display()),
            Error::Corrupt { path, block, offset, got, expected, hint } => {
                write!(
                    f,
                    "{}: block {block} at byte {offset} is damaged: found {got}, expected {expected}",
                    path.display()
                )?;
                to_fix(f, hint)
            }
            Error::SourceChanged { path, what } => write!(
                f,
                "{}: has changed while it was read: {what}\n  to fix: try again to read the new archive",
                path.display()
            ),
            Error::Defect { path, block, field, what, hint } => {
                write!(
                    f,
                    "{}: block {block}, {field}: {what}: a fault of the program, or a file that was forged",
                    path.display()
                )?;
                to_fix(f, hint)
            }
            Error::Argument { argument, what, hint, .. } => {
                write!(f, "{argument}: {}", what.plain())?;
                to_fix(f, hint)
            }
            Error::Unsupported { what, found, supported } => {
                write!(f, "{}: found {found}, this release supports {}", what.plain(), supported.plain())
            }
            Error::Limit { what, value, max } => {
                write!(f, "{} is {value}, the limit is {max}", what.plain())
            }
        }
    }
}

fn to_fix(f: &mut fmt::Formatter<'_>, hint: &Message) -> fmt::Result {
    if hint.is_empty() || f.alternate() { Ok(()) } else { write!(f, "\n  to fix: {}", hint.plain()) }
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
    /// field, an argument its request field. Three names become the words of the interface.
    #[test]
    fn a_message_says_what_is_wrong_and_what_to_do() {
        let text = Error::defect(Path::new("a.helio"), "probes/3", "seen", "names no cell").to_string();
        assert!(text.starts_with("a.helio: block probes/3, seen: names no cell: a fault of the program"), "{text}");
        assert_eq!((text.lines().count(), text.contains("heliotile archive verify --deep a.helio")), (2, true));
        let error = Error::input(Path::new("a.csv"), 2, "no rows", "give one");
        assert_eq!(format!("{error:#}"), "a.csv, line 2: no rows");
        let error = Error::argument("set, sky", "hit is 3", "leave {set} out, see `{command:info}`");
        let words = |named: Named| match named {
            Named::Field("sky") => None,
            Named::Field(field) => Some(format!("--{field}")),
            Named::Command(command) => Some(format!("heliotile {command}")),
        };
        let text = error.in_words(&words).to_string();
        assert_eq!(text, "--set, sky: hit is 3\n  to fix: leave --set out, see `heliotile info`");
        let error = Error::input(Path::new("{sky}.csv"), 2, "no column".to_owned() + " {set}", Message::default());
        let error = error.because(Problem::NoColumn { column: "set".to_owned() }).in_words(&words);
        assert_eq!(error.to_string(), "{sky}.csv, line 2: no column {set}");
        assert_eq!(error.problem().map(Problem::name), Some("no-column"));
    }
}
