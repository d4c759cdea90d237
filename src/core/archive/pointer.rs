//! A pointer: the small object that stands under an archive's name where the archive itself lies
//! beside it, as `schema/pointer.md` says. In: bytes. Out: root, length and name of the archive;
//! and back.
//!
//! An object store cannot create a large object on the condition that none is there. It can do that
//! with a small one, so the pointer is written last.

use serde::{Deserialize, Serialize};

use crate::archive::format;

/// Longest pointer, bytes.
pub const MAX_POINTER: usize = 4096;

/// First bytes of every pointer.
const START: &[u8] = b"{\"heliotile_pointer\":";

/// Name, length and root of the archive that a pointer leads to.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pointer {
    /// Version of the layout of this text, 1.
    heliotile_pointer: u32,
    /// Name of the archive, in the same folder.
    pub name: String,
    /// Length of the archive, bytes.
    pub length: u64,
    /// Root hash of the archive, hexadecimal.
    pub root: String,
}

impl Pointer {
    /// Returns a pointer to an archive of `length` bytes, which lies beside it: `site.ROOT.helio`
    /// for a pointer `site.helio`.
    pub fn new(own_name: &str, root: &[u8; 32], length: u64) -> Self {
        let root = format::hex(root);
        Pointer { heliotile_pointer: 1, name: Pointer::name_of(own_name, &root), length, root }
    }

    /// Returns the name of the archive that a pointer leads to: `site.ROOT.helio` for a pointer
    /// `site.helio`.
    fn name_of(own_name: &str, root: &str) -> String {
        let stem = own_name.strip_suffix(".helio").unwrap_or(own_name);
        format!("{stem}.{root}.helio")
    }

    /// Returns true if bytes begin as a pointer does.
    pub fn begins(head: &[u8]) -> bool {
        head.starts_with(START)
    }

    /// Reads a pointer; `None` if the bytes are no pointer that this release understands, or lead
    /// out of their folder.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let bytes = Some(bytes).filter(|bytes| bytes.len() <= MAX_POINTER && Pointer::begins(bytes))?;
        let pointer: Pointer = serde_json::from_slice(bytes).ok()?;
        let name = pointer.name.as_str();
        let plain = !name.is_empty() && ![".", ".."].contains(&name) && !name.contains(['/', '\\', '?', '#', '%', ':']);
        let hex =
            pointer.root.len() == 64 && pointer.root.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'));
        (pointer.heliotile_pointer == 1 && plain && hex && !name.contains(char::is_control)).then_some(pointer)
    }

    /// Returns the bytes of the pointer.
    pub fn to_bytes(&self) -> Vec<u8> {
        // Texts and numbers always become JSON.
        serde_json::to_vec(self).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pointer comes back from its 201 bytes. Nine other texts are no pointer: with another
    /// layout, cut, longer than 4096 bytes, with a bad root, or with a name in another folder.
    #[test]
    fn pointers_come_back_and_other_texts_are_none() {
        let pointer = Pointer::new("site.helio", &[7; 32], 145_284_198);
        let bytes = pointer.to_bytes();
        assert_eq!((pointer.name.len(), bytes.len()), (75, 201));
        assert_eq!(Pointer::from_bytes(&bytes), Some(pointer.clone()));
        assert_eq!(Pointer::new("a", &[7; 32], 1).name.len(), 72);
        let text = String::from_utf8(bytes).unwrap();
        for (from, to) in [
            ("_pointer\":1", "_pointer\":2"),
            ("\"site.", "\"../site."),
            ("\"site.", "\"/site."),
            ("\"site.", "\"a\\\\site."),
            ("\"site.", "\"http:site."),
            ("\"root\":\"07", "\"root\":\"7"),
            ("\"root\":\"07", "\"root\":\"0G"),
            ("}", ""),
        ] {
            assert_ne!(text.replacen(from, to, 1), text);
            assert_eq!(Pointer::from_bytes(text.replacen(from, to, 1).as_bytes()), None, "{to}");
        }
        assert_eq!(Pointer::from_bytes(format!("{text}{}", " ".repeat(4096)).as_bytes()), None);
    }
}
