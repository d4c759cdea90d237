//! Oddities of a file, by kind. In: a kind and a name for each oddity. Out: one warning for each
//! kind, with its count and the first name.

use std::collections::BTreeMap;
use std::path::Path;

use heliotile_core::text::Message;

use crate::text::excerpt;

#[derive(Debug, Default)]
pub(in crate::formats) struct Notes(BTreeMap<&'static str, (usize, String)>);

impl Notes {
    /// Counts an oddity. `kind` continues a sentence such as "3 ...".
    pub(in crate::formats) fn add(&mut self, kind: &'static str, name: &str) {
        let note = self.0.entry(kind).or_insert_with(|| (0, excerpt(name.as_bytes())));
        note.0 += 1;
    }

    pub(in crate::formats) fn say(&self, file: &Path, warnings: &mut Vec<Message>) {
        for (kind, (count, first)) in &self.0 {
            warnings.push(format!("{}: {count} {kind} (first: `{first}`)", file.display()).into());
        }
    }
}
