//! The header: choice of the current slot, and a check of its numbers. In: a source. Out: a slot
//! whose numbers are safe to allocate by, section 4 steps 1 to 5 of `schema/heliotile-1.md`.

use std::path::Path;

use crate::archive::format;
use crate::archive::format::{
    COMPLETE, ENTRY_SIZE, FIRST_BLOCK, MAGIC, MAJOR, MAX_ENTRIES, MAX_MANIFEST, MINOR, RETIRED_BITS, SLOT_OFFSETS,
    SLOT_SIZE, Slot,
};
use crate::archive::source::Source;
use crate::error::{Error, Problem, Result};

/// The current slot of a file, and the damaged ones.
#[derive(Clone, Debug)]
pub struct Header {
    /// The slot of the current generation.
    pub slot: Slot,
    /// Names of the slots that are ignored because they are damaged.
    pub damaged: Vec<&'static str>,
}

/// Reads and checks the header.
pub fn read(source: &Source) -> Result<Header> {
    let path = source.path();
    if source.length() < FIRST_BLOCK {
        return Err(not_an_archive(path, format!("it has {} bytes, fewer than a header", source.length())));
    }
    let mut valid: Vec<Slot> = Vec::new();
    let mut damaged = Vec::new();
    let mut magic = false;
    for (offset, name) in SLOT_OFFSETS.into_iter().zip(["slot A", "slot B"]) {
        let bytes = source.read(offset, SLOT_SIZE as u64)?;
        magic |= bytes.starts_with(&MAGIC);
        match Slot::decode(&bytes) {
            Some(slot) => valid.push(slot),
            None => damaged.push(name),
        }
    }
    if valid.is_empty() {
        return Err(match magic {
            true => {
                corrupt(path, "two slots with a wrong checksum".to_string(), "one with a right checksum".to_string())
            }
            false => not_an_archive(path, "its first bytes are not those of an archive".to_string()),
        });
    }
    valid.iter().try_for_each(|slot| check_supported(path, slot))?;
    // The first of equal generations counts.
    let newest = |best: Option<Slot>, slot: Slot| best.filter(|b| b.generation >= slot.generation).or(Some(slot));
    let Some(slot) = valid.into_iter().filter(|slot| slot.state == COMPLETE).fold(None, newest) else {
        let hint = "build it again: only a finished archive can be read";
        return Err(Error::input(path, None, "was not finished", hint));
    };
    check_numbers(&slot, source.length()).map_err(|(got, expected)| corrupt(path, got, expected))?;
    Ok(Header { slot, damaged })
}

/// Refuses a slot of another format, or with an unknown required bit, because the rest cannot be
/// understood.
fn check_supported(path: &Path, slot: &Slot) -> Result<()> {
    if (slot.major, slot.minor) != (MAJOR, MINOR) {
        return Err(Error::Unsupported {
            what: format!("{}: format of the archive", path.display()).into(),
            found: format!("format {}.{}", slot.major, slot.minor),
            supported: format!("format {MAJOR}.{MINOR} only: build the archive again with this release").into(),
        });
    }
    let unknown = slot.unknown_bits();
    if unknown.is_empty() {
        return Ok(());
    }
    let named = |bit: &u32| match RETIRED_BITS.get(*bit as usize) {
        Some(name) => format!("{bit} ({name}, set before the first release)"),
        None => bit.to_string(),
    };
    let bits = unknown.iter().map(named).collect::<Vec<_>>().join(", ");
    Err(Error::Unsupported {
        what: format!("{}: required features of the archive", path.display()).into(),
        found: format!("feature bit {bits}"),
        supported: "none: build the archive again with this release".into(),
    })
}

/// Checks that every number of a slot fits the file, the limits and the other numbers; the error is
/// (found, expected).
fn check_numbers(slot: &Slot, length: u64) -> std::result::Result<(), (String, String)> {
    let same = |what: &str, got: u64, expected: Option<u64>| match expected {
        Some(right) if right == got => Ok(()),
        Some(right) => Err((format!("{what} {got}"), right.to_string())),
        None => Err((format!("{what} {got}"), "a number below 2^64".to_string())),
    };
    let at_most = |what: &str, got: u64, max: u64| match got <= max {
        true => Ok(()),
        false => Err((format!("{what} {got}"), format!("at most {max}"))),
    };
    if slot.committed > length {
        return Err((format!("a file of {length} bytes"), format!("{} bytes: it is truncated", slot.committed)));
    }
    at_most("directory count", slot.directory_count, MAX_ENTRIES)?;
    same("directory length", slot.directory_length, slot.directory_count.checked_mul(ENTRY_SIZE as u64))?;
    same("directory offset", slot.directory_offset, format::align(slot.directory_offset.max(FIRST_BLOCK)))?;
    let directory_end = slot.directory_offset.checked_add(slot.directory_length);
    same("manifest offset", slot.manifest_offset, directory_end.and_then(format::align))?;
    at_most("manifest length", slot.manifest_length, MAX_MANIFEST)?;
    same("committed length", slot.committed, slot.manifest_offset.checked_add(slot.manifest_length))
}

fn not_an_archive(path: &Path, why: String) -> Error {
    Error::input(path, None, format!("is not a heliotile archive: {why}"), "name a file that a build wrote")
        .because(Problem::other_kind("not an archive"))
}

fn corrupt(path: &Path, got: String, expected: String) -> Error {
    Error::corrupt(path, "header", 0, got, expected)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_slots(slots: [Slot; 2], length: u64) -> Result<Header> {
        let mut bytes = vec![0; length as usize];
        bytes[..512].copy_from_slice(&slots[0].encode());
        bytes[4096..4608].copy_from_slice(&slots[1].encode());
        read(&Source::new(Path::new("site.helio"), Box::new(bytes)))
    }

    fn complete(generation: u64) -> Slot {
        Slot { state: COMPLETE, generation, ..Slot::building() }
    }

    /// The highest complete generation counts: 3 of (3, 2), 2 of (1, 2), 4 of (4, 5 still
    /// building).
    #[test]
    fn the_newest_complete_slot_counts() {
        let building = Slot { generation: 5, ..Slot::building() };
        for (slots, expected) in
            [([complete(3), complete(2)], 3), ([complete(1), complete(2)], 2), ([complete(4), building], 4)]
        {
            assert_eq!(read_slots(slots, 8192).unwrap().slot.generation, expected);
        }
        let error = read_slots([building; 2], 8192).unwrap_err().to_string();
        assert!(error.contains("was not finished"), "{error}");
    }

    /// Formats 1.0, 1.6, 1.8 and 2.7 are refused, 4 of 4, with the file, the format found, the one
    /// supported and what to do. Required bits 0 and 7 are refused by number, and by name if they
    /// have one. An optional bit is ignored.
    #[test]
    fn other_formats_are_refused_by_name() {
        for (major, minor) in [(1, 0), (1, 6), (1, 8), (2, 7)] {
            let error = read_slots([complete(1), Slot { major, minor, ..complete(1) }], 8192).unwrap_err();
            let expected = format!(
                "site.helio: format of the archive: found format {major}.{minor}, this release supports format 1.7 only: \
                 build the archive again with this release"
            );
            assert_eq!(error.to_string(), expected);
        }
        let error = read_slots([Slot { required: 0x81, ..complete(1) }; 2], 8192).unwrap_err().to_string();
        assert!(
            error.contains("feature bit 0 (experimental, set before the first release), 7, this release"),
            "{error}"
        );
        assert_eq!(read_slots([Slot { optional: 99, ..complete(1) }; 2], 8192).unwrap().slot.optional, 99);
    }

    /// Each of 10 false numbers, with right checksums, is damage of the header.
    #[test]
    fn lying_numbers_are_refused() {
        let good = complete(1);
        let lies = [
            Slot { committed: 8193, ..good },
            Slot { committed: 8191, ..good },
            Slot { committed: u64::MAX, ..good },
            Slot { directory_count: 1 << 36, directory_length: 80 << 36, ..good },
            Slot { directory_count: u64::MAX, directory_length: u64::MAX - 79, ..good },
            Slot { directory_length: 80, ..good },
            Slot { directory_offset: 0, ..good },
            Slot { directory_offset: u64::MAX, ..good },
            Slot { manifest_offset: 64, ..good },
            Slot { manifest_length: 1 << 40, ..good },
        ];
        for lie in lies {
            let error = read_slots([lie; 2], 8192).unwrap_err();
            assert!(matches!(&error, Error::Corrupt { block, .. } if block == "header"), "{lie:?}: {error}");
        }
    }
}
