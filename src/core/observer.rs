//! Progress of long work, and the question if it is to stop. In: nothing. Out: calls that a program
//! turns into bars, lines or nothing. The library itself never prints.

use crate::error::{Error, Result};
use crate::text::Message;

/// Receiver of the progress and the messages of long work. All methods may be called from any
/// thread.
pub trait Observer: Sync {
    /// Begins a stage, of `items` items if their number is known.
    fn begin(&self, _stage: &'static str, _items: Option<u64>) {}

    /// Adds `items` to the finished items of a stage.
    fn advance(&self, _stage: &'static str, _items: u64) {}

    /// Ends a stage.
    fn end(&self, _stage: &'static str) {}

    /// Takes a message.
    fn tell(&self, _tone: Tone, _message: Message) {}

    /// Returns a message in the words of this observer's user.
    fn in_words(&self, message: &Message) -> String {
        message.plain()
    }

    /// Returns true if the work is to stop at the next place where it can go on later.
    fn cancelled(&self) -> bool {
        false
    }

    /// Returns [`Error::Stopped`] with `what`, which says what was going on, if the work is to
    /// stop; called between two steps.
    fn stop_if_cancelled(&self, what: &str) -> Result<()> {
        if self.cancelled() { Err(Error::Stopped { what: what.to_owned() }) } else { Ok(()) }
    }
}
/// Kind of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// Warning that the user should see; the work goes on.
    Warning,
    /// Note that the user may want to see; nothing is wrong.
    Note,
    /// Report of work that is done or about to begin, in lines that end with a line break.
    Report,
    /// Report of how work is done, such as rays and seconds, in lines that end with a line break.
    Detail,
}

impl dyn Observer + '_ {
    /// Hands on a warning.
    pub fn warn(&self, text: impl Into<Message>) {
        self.tell(Tone::Warning, text.into());
    }

    /// Hands on a note.
    pub fn note(&self, text: impl Into<Message>) {
        self.tell(Tone::Note, text.into());
    }

    /// Hands on a report.
    pub fn report(&self, text: impl Into<Message>) {
        self.tell(Tone::Report, text.into());
    }

    /// Hands on a report of how work is done.
    pub fn detail(&self, text: impl Into<Message>) {
        self.tell(Tone::Detail, text.into());
    }
}

/// Observer that ignores everything and never stops the work.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {}

/// A stage under way; dropping the value ends it.
pub struct Stage<'a> {
    observer: &'a dyn Observer,
    name: &'static str,
}

impl<'a> Stage<'a> {
    /// Begins a stage, of `items` items if their number is known.
    pub fn begin(observer: &'a dyn Observer, name: &'static str, items: Option<u64>) -> Self {
        observer.begin(name, items);
        Stage { observer, name }
    }

    /// Adds `items` to the finished items.
    pub fn advance(&self, items: u64) {
        self.observer.advance(self.name, items);
    }
}

impl Drop for Stage<'_> {
    fn drop(&mut self) {
        self.observer.end(self.name);
    }
}
