//! `heliotile query` in WebAssembly, to show that the engine needs no file system, no threads and no C. In: the bytes of an archive and of
//! a conditions table. Out: the rows of the query as CSV, or an error's message.
//!
//! The host asks for a buffer ([`archive_buffer`], [`conditions_buffer`]), writes the bytes there, calls [`query`] and reads the text at
//! [`text`]. Buffers are owned here, so no pointer is followed on this side.

use std::cell::RefCell;
use std::fmt::Write;
use std::path::Path;

use heliotile_core::archive::{Archive, verify_bytes};
use heliotile_core::error::Result;
use heliotile_core::replay::components::Component;
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::weather::conditions::parse_conditions;

thread_local! {
    static ARCHIVE: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static CONDITIONS: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static TEXT: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Room for an archive of `length` bytes.
#[unsafe(no_mangle)]
pub extern "C" fn archive_buffer(length: usize) -> *mut u8 {
    ARCHIVE.with_borrow_mut(|bytes| room(bytes, length))
}

/// Room for a conditions table of `length` bytes.
#[unsafe(no_mangle)]
pub extern "C" fn conditions_buffer(length: usize) -> *mut u8 {
    CONDITIONS.with_borrow_mut(|bytes| room(bytes, length))
}

fn room(bytes: &mut Vec<u8>, length: usize) -> *mut u8 {
    bytes.clear();
    bytes.resize(length, 0);
    bytes.as_mut_ptr()
}

/// Verifies the archive and replays the conditions: 0, or 1 if that cannot be done. Either way there is a text.
#[unsafe(no_mangle)]
pub extern "C" fn query() -> u32 {
    let archive = ARCHIVE.take();
    let answer = CONDITIONS.with_borrow(|conditions| rows(archive, conditions));
    let (code, text) = match answer {
        Ok(text) => (0, text),
        Err(error) => (1, error.to_string()),
    };
    TEXT.set(text);
    code
}

/// Where the text of the last query starts.
#[unsafe(no_mangle)]
pub extern "C" fn text() -> *const u8 {
    TEXT.with_borrow(|text| text.as_ptr())
}

/// Bytes of the text of the last query.
#[unsafe(no_mangle)]
pub extern "C" fn text_length() -> usize {
    TEXT.with_borrow(String::len)
}

/// The rows that `heliotile query` writes, with all digits.
fn rows(archive: Vec<u8>, conditions: &[u8]) -> Result<String> {
    let report = verify_bytes("archive", archive.clone(), true)?;
    if let Some(problem) = report.problems.first() {
        return Ok(format!("{} at byte {}: {}", problem.part, problem.offset, problem.reason));
    }
    let archive = Archive::of("archive", archive)?;
    let conditions = parse_conditions(Path::new("conditions.csv"), conditions)?.conditions;
    let patches = archive.manifest().settings.patches();
    let replay = Replay::new(&archive, &conditions, ReplaySettings { patches, ..ReplaySettings::default() })?;
    let mut text = String::from("condition,receiver");
    Component::ALL.iter().for_each(|component| text.extend([",", component.name()]));
    text.push('\n');
    for tile in replay.results(0..replay.tiles()) {
        let (receivers, values) = tile?;
        for (row, receiver) in receivers.iter().enumerate() {
            for (column, condition) in conditions.iter().enumerate() {
                // Writing into memory cannot fail.
                let _ = write!(text, "{},{receiver}", condition.label);
                for component in Component::ALL {
                    let value = values.row(component as usize, row).get(column).copied().unwrap_or(f32::NAN);
                    let _ = write!(text, ",{value}");
                }
                text.push('\n');
            }
        }
    }
    Ok(text)
}
