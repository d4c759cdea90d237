//! Output of a build: where the archive goes, and what happens to an interrupted build at that
//! place. In: a path. Out: a writer.

use std::io;
use std::path::PathBuf;
use std::time::Duration;

use heliotile_archives::writing::{Job, Progress, Writer};
use heliotile_core::error::{Error, Result};

/// Archive that a build writes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Output {
    /// Path of the archive. Its name is `PATH.partial` until it is finished.
    pub path: PathBuf,
    /// Action if an interrupted build is at this path.
    pub start: Start,
    /// Time between checkpoints: the most work that a crash costs.
    pub checkpoint_every: Duration,
}

impl Output {
    /// Creates an output for a new archive, with a checkpoint every 30 seconds.
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

/// Action if an interrupted build is at the path of the archive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Start {
    /// Refuse, and say what can be done.
    #[default]
    New,
    /// Resume it; refused if it was for another job.
    Resume,
    /// Delete it, and start again.
    Fresh,
}

/// Adds to an error of the disk what the user can do, if blocks are kept.
pub(super) fn kept(error: Error, kept: Option<Progress>) -> Error {
    match (error, kept) {
        (Error::Io { path, action, source }, Some(done)) => {
            let hint = format!(
                "free space or correct the cause, then repeat the command to continue after {} blocks",
                done.blocks
            );
            let source = io::Error::new(source.kind(), format!("{source}\n  to fix: {hint}"));
            Error::Io { path, action, source }
        }
        (error, _) => error,
    }
}
