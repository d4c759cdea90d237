//! Interrupted builds: which jobs may resume them, which are refused, and what remains of a damaged
//! one.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::writing::disk::Disk;
use crate::writing::journal::{BATCH_SIZE, HEADER_SIZE, SUM_SIZE};
use crate::writing::memory_disk::{Event, MemoryDisk, Random};
use crate::writing::test_site::{Build, JOB};
use crate::writing::writer::Interrupted;
use crate::writing::{Job, Progress, Writer};
use heliotile_core::archive::format;
use heliotile_core::archive::format::TileNumber;
use heliotile_core::error::{Error, Result};

fn beside(path: &Path, ending: &str) -> PathBuf {
    PathBuf::from(format!("{}{ending}", path.display()))
}

/// Starts a build in a new folder and appends `blocks`, with a checkpoint after each whose bit is
/// set.
fn started(build: &Build, path: &Path, blocks: usize, checkpoints: u64) -> Writer {
    let mut writer = Writer::create(path, &JOB).unwrap();
    for (row, block) in build.blocks.iter().take(blocks).enumerate() {
        writer.append(block.clone()).unwrap();
        if checkpoints >> row & 1 == 1 {
            writer.checkpoint().unwrap();
        }
    }
    writer
}

/// Appends the missing blocks and finishes.
fn finish(build: &Build, mut writer: Writer) {
    for block in &build.blocks {
        if !writer.has(block.entry().kind, block.entry().tile) {
            writer.append(block.clone()).unwrap();
        }
    }
    writer.finish(&build.manifest).unwrap();
}

/// Returns the disk in memory of a build that was interrupted after `blocks`, with a checkpoint
/// after each.
fn interrupted(build: &Build, path: &Path, blocks: usize) -> MemoryDisk {
    let disk = MemoryDisk::default();
    let mut writer = Writer::start(Arc::new(disk.clone()), path, &JOB, Interrupted::Refuse).unwrap();
    for block in build.blocks.iter().take(blocks) {
        writer.append(block.clone()).unwrap();
        writer.checkpoint().unwrap();
    }
    disk
}

/// 200 builds are killed after a random block, half of them in the middle of the next one, with
/// checkpoints at random. The files that the kill leaves, resumed in another folder, become the
/// bytes of an undisturbed build.
#[test]
fn killed_builds_go_on() {
    let build = Build::new();
    let mut resumed = 0;
    for case in 0..200 {
        let mut random = Random(case);
        let folder = tempfile::tempdir().unwrap();
        let [killed, path] = ["killed.helio", "site.helio"].map(|name| folder.path().join(name));
        let blocks = random.below(build.blocks.len() as u64 + 1) as usize;
        let writer = started(&build, &killed, blocks, random.below(1 << build.blocks.len()));
        let mut partial = std::fs::read(beside(&killed, ".partial")).unwrap();
        if case % 2 == 0 {
            partial.extend(vec![0xAB; random.below(5000) as usize]);
        }
        std::fs::write(beside(&path, ".partial"), partial).unwrap();
        if writer.committed().is_some() {
            std::fs::copy(beside(&killed, ".partial.log"), beside(&path, ".partial.log")).unwrap();
        }
        let next = Writer::resume(&path, &JOB).unwrap();
        assert_eq!(next.resumed(), writer.committed(), "case {case}");
        resumed += u64::from(next.resumed().is_some());
        finish(&build, next);
        assert!(std::fs::read(&path).unwrap() == build.bytes, "case {case}");
        assert!(!beside(&path, ".partial").exists() && !beside(&path, ".partial.log").exists());
    }
    assert!(resumed > 100, "{resumed} of 200 had a checkpoint");
}

/// An interrupted build with 4 of 11 blocks is refused by `create`, which says so and changes no
/// byte of its 2 files. `resume` continues it, and `create_fresh` starts again: both end with equal
/// bytes.
#[test]
fn interrupted_work_is_not_overwritten() {
    let build = Build::new();
    for fresh in [false, true] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("site.helio");
        drop(started(&build, &path, 5, 0b1000));
        let files = || [".partial", ".partial.log"].map(|ending| std::fs::read(beside(&path, ending)).unwrap());
        let before = files();
        let error = Writer::create(&path, &JOB).unwrap_err();
        assert!(matches!(error, Error::Incomplete { .. }));
        for part in ["site.helio.partial", "4 blocks", " bytes are done", "remove it to start again"] {
            assert!(error.to_string().contains(part), "`{part}` is not in: {error}");
        }
        assert!(files() == before);
        let writer = if fresh { Writer::create_fresh(&path, &JOB) } else { Writer::resume(&path, &JOB) }.unwrap();
        assert_eq!(writer.resumed().map(|progress| progress.blocks), (!fresh).then_some(4));
        assert_eq!(writer.has(format::SKY, TileNumber::FIRST), !fresh);
        // During the resume no other writer may have the file.
        assert!(Writer::resume(&path, &JOB).unwrap_err().to_string().contains("another process"));
        finish(&build, writer);
        assert!(std::fs::read(&path).unwrap() == build.bytes);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}

/// Each of 4 differences, that of the program in two ways, and all at once, is refused by its name
/// and no other, by `resume` and by `create`, and leaves both files. The job that fits can resume
/// afterwards.
#[test]
fn another_job_is_refused_by_name() {
    let build = Build::new();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("site.helio");
    drop(started(&build, &path, 3, 0b100));
    let log = beside(&path, ".partial.log");
    let ours = std::fs::read(&log).unwrap();
    // A journal of heliotile 1.1.0 with its one batch, and one whose batches have another layout.
    let [mut later, mut newer] = [ours.clone(), ours.clone()];
    later[122] = b'1';
    newer[8] = 2;
    for bytes in [&mut later, &mut newer] {
        let header = *blake3::hash(&bytes[..HEADER_SIZE - SUM_SIZE]).as_bytes();
        bytes[HEADER_SIZE - SUM_SIZE..HEADER_SIZE].copy_from_slice(&header);
        let end = bytes.len() - SUM_SIZE;
        let batch = *blake3::hash(&[&header, &bytes[HEADER_SIZE..end]].concat()).as_bytes();
        bytes[end..].copy_from_slice(&batch);
    }
    let names = ["scene", "receivers", "settings", "program version"];
    let cases = [
        (Job { scene: [9; 32], ..JOB }, &ours, vec!["scene"]),
        (Job { receivers: [9; 32], ..JOB }, &ours, vec!["receivers"]),
        (Job { settings: [9; 32], ..JOB }, &ours, vec!["settings"]),
        (JOB, &later, vec!["program version (it was written by heliotile 1.1.0, "]),
        (JOB, &newer, vec!["program version"]),
        (Job { scene: [9; 32], receivers: [9; 32], settings: [9; 32] }, &newer, names.to_vec()),
    ];
    for (job, bytes, differences) in cases {
        std::fs::write(&log, bytes).unwrap();
        for result in [Writer::resume(&path, &job), Writer::create(&path, &job)] {
            let message = result.unwrap_err().to_string();
            let listed = format!("differs in: {}", differences.join(", "));
            assert!(message.contains(&listed) && message.contains("remove it to start again"), "{message}");
            assert_eq!(names.iter().filter(|name| message.contains(**name)).count(), differences.len(), "{message}");
        }
        assert!(std::fs::read(&log).unwrap() == *bytes);
    }
    std::fs::write(&log, &ours).unwrap();
    finish(&build, Writer::resume(&path, &JOB).unwrap());
    assert!(std::fs::read(&path).unwrap() == build.bytes);
}

/// One bit is changed in each byte of the journal and of the partial file, and both are cut at each
/// length. The blocks before the damage count, those after it are written again, and all of over 10
/// 000 results have equal bytes. A partial file whose first 8 bytes are not those of an archive may
/// be another file: 8 of 8 are refused and stay.
#[test]
fn damage_costs_what_follows_it() {
    let build = Build::new();
    let path = Path::new("site.helio");
    let disk = interrupted(&build, path, 6);
    let [partial, log] = [".partial", ".partial.log"].map(|ending| disk.get(&beside(path, ending)).unwrap());
    assert_eq!(log.len(), HEADER_SIZE + 6 * (BATCH_SIZE + 80 + SUM_SIZE));
    let flip = |bytes: &[u8], place: usize| {
        let mut bytes = bytes.to_vec();
        bytes[place] ^= 1 << (place % 8);
        bytes
    };
    // A batch is 128 bytes. Damage to one loses it and all batches after it.
    let before = |place: usize| place.saturating_sub(HEADER_SIZE) / 128;
    let mut cases = Vec::new();
    for place in 0..log.len() {
        cases.push((partial.clone(), flip(&log, place), Some(before(place))));
        cases.push((partial.clone(), log[..place].to_vec(), Some(before(place))));
    }
    for place in 0..partial.len() {
        if place >= format::MAGIC.len() {
            cases.push((flip(&partial, place), log.clone(), (place < 8192).then_some(6)));
        }
        cases.push((partial[..place].to_vec(), log.clone(), None));
    }
    for place in 0..format::MAGIC.len() {
        let disk = MemoryDisk::default();
        let foreign = flip(&partial, place);
        disk.put(&beside(path, ".partial"), &foreign);
        let refused = Writer::start(Arc::new(disk.clone()), path, &JOB, Interrupted::Resume);
        assert!(refused.is_err_and(|error| error.to_string().contains("no interrupted build")), "{place}");
        assert_eq!(disk.get(&beside(path, ".partial")), Some(foreign), "{place}");
    }
    assert!(cases.len() > 10_000, "{}", cases.len());
    for (row, (partial, log, blocks)) in cases.into_iter().enumerate() {
        let disk = MemoryDisk::default();
        disk.put(&beside(path, ".partial"), &partial);
        disk.put(&beside(path, ".partial.log"), &log);
        let shared: Arc<dyn Disk> = Arc::new(disk.clone());
        let writer = Writer::start(Arc::clone(&shared), path, &JOB, Interrupted::Resume).unwrap();
        let found = writer.resumed().map_or(0, |progress| progress.blocks as usize);
        assert!(found <= 6 && blocks.is_none_or(|expected| expected == found), "case {row}: {found}");
        finish(&build, writer);
        assert!(disk.get(path).unwrap() == build.bytes, "case {row}");
        assert_eq!(disk.names(), [path], "case {row}");
    }
}

/// A journal without its partial file, as a crash between rename and removal leaves it, is dropped
/// by 3 of 3 ways to start.
#[test]
fn a_stale_journal_is_dropped() {
    let build = Build::new();
    let path = Path::new("site.helio");
    let log = interrupted(&build, path, 6).get(&beside(path, ".partial.log")).unwrap();
    for start in [Interrupted::Refuse, Interrupted::Discard, Interrupted::Resume] {
        for job in [JOB, Job { scene: [9; 32], ..JOB }] {
            let disk = MemoryDisk::default();
            disk.put(&beside(path, ".partial.log"), &log);
            let writer = Writer::start(Arc::new(disk.clone()), path, &job, start).unwrap();
            assert_eq!(writer.resumed(), None);
            assert_eq!(disk.names(), [beside(path, ".partial")]);
            finish(&build, writer);
            assert!(disk.get(path).unwrap() == build.bytes);
        }
    }
}

/// A dropped writer leaves 2 files after a checkpoint and 0 before one. `keep` writes the
/// checkpoint. A checkpoint without new blocks takes 0 operations.
#[test]
fn a_dropped_writer_leaves_its_checkpoint() {
    let build = Build::new();
    let path = Path::new("site.helio");
    let left = |blocks: usize, checkpoint: bool, keep: bool| {
        let disk = MemoryDisk::default();
        let mut writer = Writer::start(Arc::new(disk.clone()), path, &JOB, Interrupted::Refuse).unwrap();
        build.blocks[..blocks].iter().for_each(|block| writer.append(block.clone()).unwrap());
        if checkpoint {
            writer.checkpoint().unwrap();
            let before = disk.operations();
            writer.checkpoint().unwrap();
            assert_eq!(disk.operations(), before);
        }
        match keep {
            true => writer.keep().unwrap(),
            false => drop(writer),
        }
        disk.names().len()
    };
    assert_eq!([left(3, false, false), left(3, true, false), left(3, false, true)], [0, 2, 2]);
    assert_eq!([left(0, false, true), left(0, true, false)], [0, 0]);
}

/// After a failed write and after a failed sync nothing is tried again: 3 of 3 calls are errors
/// without an operation.
#[test]
fn a_failure_ends_the_writer() {
    let build = Build::new();
    let path = Path::new("site.helio");
    let attempts: [fn(&mut Writer, &Build) -> Result<()>; 2] =
        [|writer, build| writer.append(build.blocks[4].clone()), |writer, _| writer.checkpoint()];
    for fail in attempts {
        let disk = interrupted(&build, path, 3);
        let mut writer = Writer::start(Arc::new(disk.clone()), path, &JOB, Interrupted::Resume).unwrap();
        writer.append(build.blocks[3].clone()).unwrap();
        disk.plan(Some((1, Event::Fail)));
        assert!(fail(&mut writer, &build).is_err());
        let operations = disk.operations();
        let later = [writer.append(build.blocks[5].clone()), writer.checkpoint(), writer.keep()];
        for error in later.map(Result::unwrap_err) {
            assert!(error.to_string().contains("an earlier write or sync of this build failed"), "{error}");
        }
        assert_eq!((operations, disk.operations()), (1, 1));
        assert_eq!(disk.names().len(), 2);
    }
}

/// A checkpoint is due after 64 MiB, not before, and never without a new block.
#[test]
fn checkpoints_fall_due() {
    let mut random = Random(1);
    let raw: Vec<u8> = (0..(8 << 20) / 8).flat_map(|_| random.below(u64::MAX).to_le_bytes()).collect();
    let disk = MemoryDisk::default();
    let mut writer = Writer::start(Arc::new(disk), Path::new("site.helio"), &JOB, Interrupted::Refuse).unwrap();
    for tile in 0..8 {
        assert!(!writer.due(), "after {tile} blocks of 8 MiB");
        writer
            .append(heliotile_core::archive::encode(format::HIT, format::TileNumber(tile), 1, 1, &raw, 1).unwrap())
            .unwrap();
    }
    assert!(writer.due());
    writer.checkpoint().unwrap();
    assert!(!writer.due());
    assert_eq!(writer.committed(), Some(Progress { blocks: 8, bytes: 8192 + (64 << 20) }));
}
