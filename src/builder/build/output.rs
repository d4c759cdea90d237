//! Where an archive goes, and how its build starts where an interrupted one lies.

use std::io;
use std::path::PathBuf;
use std::time::Duration;

use crate::writing::{Job, Progress, Writer};
use heliotile_core::error::{Error, Result};

/// The archive that a build writes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Output {
    /// The archive; it has this name once it is finished, `PATH.partial` until then.
    pub path: PathBuf,
    /// What to do where an interrupted build lies.
    pub start: Start,
    /// What a crash costs at most.
    pub checkpoint_every: Duration,
}

impl Output {
    /// A new archive, with a checkpoint every 30 seconds.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Output { path: path.into(), start: Start::New, checkpoint_every: Duration::from_secs(30) }
    }

    pub(super) fn writer(&self, job: &Job) -> Result<Writer> {
        let mut writer = match self.start {
            Start::New => Writer::create(&self.path, job),
            Start::Resume | Start::GoOn => Writer::resume(&self.path, job),
            Start::Fresh => Writer::create_fresh(&self.path, job),
        }
        .map_err(|error| error.advise(self.start.advice()))?;
        writer.set_checkpoint_every(self.checkpoint_every);
        Ok(writer)
    }
}

/// What to do where an interrupted build lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Start {
    /// Refuse, and say what can be done.
    #[default]
    New,
    /// Go on with it; refused if it was for something else.
    Resume,
    /// Throw it away, and begin anew.
    Fresh,
    /// As `Resume`, for a command without options of that kind.
    GoOn,
}

impl Start {
    /// What can be done where another interrupted build lies.
    fn advice(self) -> &'static str {
        match self {
            Start::GoOn => "remove it to start again",
            _ => {
                "give the inputs that it was started with and --resume to go on with it, or --fresh to discard it and start \
                 again"
            }
        }
    }

    /// How work that was stopped goes on.
    pub(super) fn again(self) -> &'static str {
        match self {
            Start::GoOn => "give the same command again to go on",
            _ => "give the same command with --resume to go on",
        }
    }

    /// An error of the disk, with what can be done about it if something is kept.
    pub(super) fn kept(self, error: Error, kept: Option<Progress>) -> Error {
        match (error, kept) {
            (Error::Io { path, action, source }, Some(done)) => {
                let hint =
                    format!("make room or mend what is wrong, then {} after {} blocks", self.again(), done.blocks);
                let source = io::Error::new(source.kind(), format!("{source}\n  to fix: {hint}"));
                Error::Io { path, action, source }
            }
            (error, _) => error,
        }
    }
}
