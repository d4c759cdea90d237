//! Oddities of a file, by kind. In: a kind and a name for each oddity. Out: one warning for each
//! kind, with its count and the first name.

use std::collections::BTreeMap;
use std::path::Path;

use crate::text::excerpt;
use heliotile_core::text::Message;

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

/// Reason for faces that have fewer than three corners.
pub(in crate::formats) const TOO_FEW: &str = "with fewer than three corners";
/// Reason for faces that lie beyond all positions on Earth.
pub(in crate::formats) const TOO_FAR: &str = "because they lie more than 1e9 m away";
/// Reason for faces inside the building.
pub(in crate::formats) const INSIDE: &str = "because they lie inside the building";
/// Reason for walls that are windows altogether.
pub(in crate::formats) const ALL_WINDOW: &str = "because a window fills them completely";
/// Note on openings that look the other way than their wall.
pub(in crate::formats) const TURNED_OPENINGS: &str = "windows or doors face against their wall and are turned round";
/// Note on openings that do not fit into their wall.
pub(in crate::formats) const BEYOND: &str = "windows or doors are left out, and their wall stays whole there: they reach over its edge, \
                                             overlap each other or lie off its plane";
