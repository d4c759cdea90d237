//! Damage to a complete archive gives an error that names the part, or the same answer; never
//! another answer.

use std::path::Path;

use crate::writing::test_site;
use heliotile_core::archive::tables::{CellsTable, IndexTable, MaterialsTable, ReceiversTable};
use heliotile_core::archive::{Access, Archive, format, verify};
use heliotile_core::error::{Error, Result};

/// All answers of an archive: the manifest, and each block's name, rows and bytes. Tables are
/// decoded, too.
type Answers = (String, Vec<(String, u32, Vec<u8>)>);

fn ask(path: &Path, access: Access) -> Result<Answers> {
    let archive = Archive::open_with(path, access)?;
    let mut blocks = Vec::new();
    for entry in archive.entries() {
        let block = archive.block(entry.kind, entry.tile)?;
        match entry.kind {
            format::RECEIVERS => drop(ReceiversTable::from_block(&block)?),
            format::MATERIALS => drop(MaterialsTable::from_block(&block)?),
            format::PROBES | format::BOUNCE => drop(CellsTable::from_block(&block)?),
            format::INDEX => drop(IndexTable::from_block(&block)?),
            _ => {}
        }
        blocks.push((entry.name(), block.items(), block.bytes().to_vec()));
    }
    Ok((format!("{:?}", archive.manifest()), blocks))
}

/// One bit is changed in each byte of an archive. Every change gives an error or the same answer,
/// never another one, and `verify` finds every change, also in padding.
#[test]
fn no_changed_byte_is_silent() {
    let site = test_site::written();
    let original = std::fs::read(&site.path).unwrap();
    let answers = ask(&site.path, Access::Mapped).unwrap();
    let (mut errors, mut same) = (0, 0);
    let path = site.folder.path().join("damaged.helio");
    for place in 0..original.len() {
        let mut bytes = original.clone();
        bytes[place] ^= 1 << (place % 8);
        std::fs::write(&path, bytes).unwrap();
        match ask(&path, Access::Read) {
            Ok(found) => {
                assert!(found == answers, "byte {place} changed the answer");
                same += 1;
            }
            Err(Error::Corrupt { .. }) => errors += 1,
            Err(other) => panic!("byte {place}: {other}"),
        }
        assert!(!verify(&path, Access::Read, false).unwrap().problems.is_empty(), "byte {place} was not found");
    }
    // Each header slot backs the other up, and readers ignore padding. All other bytes are blocks,
    // directory and manifest.
    assert_eq!(errors + same, original.len());
    assert!(same >= 8192 && errors > 2000, "{errors} errors, {same} same");
}

/// The file cut at each of its lengths is an error at each. 1 KiB of garbage after its end changes
/// nothing.
#[test]
fn no_truncation_is_silent() {
    let site = test_site::written();
    let original = std::fs::read(&site.path).unwrap();
    let answers = ask(&site.path, Access::Mapped).unwrap();
    let path = site.folder.path().join("cut.helio");
    let refused = (0..original.len()).filter(|&length| {
        std::fs::write(&path, &original[..length]).unwrap();
        [Access::Mapped, Access::Read].into_iter().all(|access| ask(&path, access).is_err())
    });
    assert_eq!(refused.count(), original.len());
    std::fs::write(&path, [original, vec![0xAB; 1024]].concat()).unwrap();
    assert_eq!(ask(&path, Access::Mapped).unwrap(), answers);
    let report = verify(&path, Access::Read, false).unwrap();
    assert_eq!((report.problems.len(), report.trailing_bytes), (0, 1024));
}

/// Two builds of one site have the same bytes and the same root hash, whatever name and folder: 2
/// of 2.
#[test]
fn equal_sites_have_equal_bytes() {
    let (first, second) = (test_site::bytes(), test_site::bytes());
    assert_eq!(first, second);
    assert_eq!(first.0.len() as u64, first.1.bytes);
}

/// An empty file, a text, 9000 zeros, a folder and a missing file are 5 errors that say so.
/// `verify` gives errors, too, not reports.
#[test]
fn what_is_no_archive_says_so() {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in [("empty", vec![]), ("text", b"time,ghi\n".repeat(2000)), ("zeros", vec![0; 9000])] {
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        let error = Archive::open(&path).unwrap_err().to_string();
        assert!(error.contains("is not a heliotile archive"), "{error}");
        assert!(verify(&path, Access::Read, false).is_err());
    }
    assert!(Archive::open(folder.path()).is_err());
    let error = Archive::open(&folder.path().join("missing")).unwrap_err();
    assert!(matches!(error, Error::Io { action: "open", .. }));
}
