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
            Start::Resume => Writer::resume(&self.path, job),
            Start::Fresh => Writer::create_fresh(&self.path, job),
        }?;
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
}

/// An error of the disk, with what can be done about it if something is kept.
pub(super) fn kept(error: Error, kept: Option<Progress>) -> Error {
    match (error, kept) {
        (Error::Io { path, action, source }, Some(done)) => {
            let hint = format!(
                "make room or mend what is wrong, then give the same command again to go on after {} blocks",
                done.blocks
            );
            let source = io::Error::new(source.kind(), format!("{source}\n  to fix: {hint}"));
            Error::Io { path, action, source }
        }
        (error, _) => error,
    }
}
