//! What long work tells while it runs, and asks. In: nothing. Out: calls that a program turns into bars, lines or nothing. The library itself
//! never prints.

use crate::error::{Error, Result};
use crate::text::{Named, with_fields};

/// Who is told. All methods may be called from any thread.
pub trait Observer: Sync {
    /// A stage begins, of so many items if that is known.
    fn begin(&self, _stage: &'static str, _items: Option<u64>) {}

    /// So many more items of a stage are done.
    fn advance(&self, _stage: &'static str, _items: u64) {}

    /// A stage has ended.
    fn end(&self, _stage: &'static str) {}

    /// Something that the user should know of; the work goes on.
    fn warn(&self, _text: &str) {}

    /// Something that the user may want to know, and that nothing is wrong with.
    fn note(&self, _text: &str) {}

    /// What was done or is about to be done, in lines that end with a line break.
    fn report(&self, _text: &str) {}

    /// Returns a text with the fields that it names, as in `{every}`, in the words of this observer's user.
    fn in_words(&self, text: &str) -> String {
        with_fields(text, &|named| match named {
            Named::Field(name) | Named::Command(name) => Some(name.to_owned()),
        })
    }

    /// Whether the work is to stop at the next place where it can go on later.
    fn cancelled(&self) -> bool {
        false
    }

    /// Stops between two steps of the work, if that is wanted. An error: [`Error::Stopped`], which says what was going on.
    fn stop_if_cancelled(&self, what: &str) -> Result<()> {
        if self.cancelled() { Err(Error::Stopped { what: what.to_owned() }) } else { Ok(()) }
    }
}
/// An observer that passes over everything and never stops the work.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {}

/// A stage under way; it ends with this value.
pub struct Stage<'a> {
    observer: &'a dyn Observer,
    name: &'static str,
}

impl<'a> Stage<'a> {
    /// Begins a stage of so many items, if that is known.
    pub fn begin(observer: &'a dyn Observer, name: &'static str, items: Option<u64>) -> Self {
        observer.begin(name, items);
        Stage { observer, name }
    }

    /// So many more items are done.
    pub fn advance(&self, items: u64) {
        self.observer.advance(self.name, items);
    }
}

impl Drop for Stage<'_> {
    fn drop(&mut self) {
        self.observer.end(self.name);
    }
}
