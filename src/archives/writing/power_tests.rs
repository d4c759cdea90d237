//! Builds that lose power, are killed or get an error at any operation, again and again, on a disk
//! in memory that keeps any part of the unsynced bytes.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use crate::writing::disk::Disk;
use crate::writing::memory_disk::{Event, MemoryDisk, Random};
use crate::writing::test_site::{Build, JOB};
use crate::writing::writer::Interrupted;
use crate::writing::{Job, Writer};
use heliotile_core::archive::format::{COMPLETE, SLOT_OFFSETS, Slot};

const OLD: &[u8] = b"an older archive";

/// Returns the number of operations of an undisturbed build with a checkpoint after each block.
fn operations(build: &Build) -> u64 {
    let path = Path::new("site.helio");
    let disk = MemoryDisk::with(path, OLD);
    let shared: Arc<dyn Disk> = Arc::new(disk.clone());
    build.run(&shared, path, Interrupted::Refuse, u64::MAX, &mut 0).unwrap();
    disk.operations()
}

/// Returns true if a slot of the partial file says "complete". The file must then be the whole
/// archive.
fn says_complete(disk: &MemoryDisk, build: &Build) -> bool {
    let Some(bytes) = disk.get(Path::new("site.helio.partial")) else { return false };
    let slots = SLOT_OFFSETS.map(|offset| bytes.get(offset as usize..).and_then(Slot::decode));
    let complete = slots.into_iter().flatten().any(|slot| slot.state == COMPLETE);
    assert!(!complete || bytes[8192..] == build.bytes[8192..], "complete, but not whole");
    complete
}

/// 20 000 builds are disturbed up to four times each by loss of power, a kill or a failed
/// operation. After every one, `NAME` is the old file or the complete new one, a resume finds the
/// blocks of the last acknowledged checkpoint, and the end has the bytes of an undisturbed build. A
/// partial file that says "complete" is complete. Every operation is hit first at least 100 times,
/// and there are over 10 000 losses of power.
#[test]
fn no_crash_loses_a_checkpoint() {
    let build = Build::new();
    let path = Path::new("site.helio");
    let most = operations(&build);
    let (mut losses, mut resumed, mut complete, mut firsts) = (0, 0, 0, BTreeSet::new());
    for case in 0..20_000 {
        let mut random = Random(case);
        let mut disk = MemoryDisk::with(path, OLD);
        let mut acknowledged = 0;
        let disturbances = 1 + random.below(4);
        for round in 0..=disturbances {
            let at = if round == 0 { 1 + case / 2 % most } else { 1 + random.below(most) };
            let kind = random.below(4);
            let event = if kind == 0 { Event::Fail } else { Event::Stop };
            disk.plan((round < disturbances).then_some((at, event)));
            let shared: Arc<dyn Disk> = Arc::new(disk.clone());
            // With all checkpoints, every operation of the longest build can be the first one hit.
            let checkpoints = if case % 2 == 0 { u64::MAX } else { random.below(1 << build.blocks.len()) };
            let done = build.run(&shared, path, Interrupted::Resume, checkpoints, &mut acknowledged);
            drop(shared);
            disk.plan(None);
            assert!(done.is_ok() || round < disturbances, "case {case}: {done:?}");
            if round == 0 && done.is_err() {
                firsts.insert(at);
            }
            // A kill leaves everything as the process saw it; loss of power does not.
            if kind > 1 {
                disk = disk.lose_power(&mut random);
                losses += 1;
                complete += u64::from(says_complete(&disk, &build));
            }
            let found = disk.get(path).unwrap();
            let whole = found == build.bytes;
            assert!(whole || (found == OLD && done.is_err()), "case {case}, round {round}: {} bytes", found.len());
            if whole {
                break;
            }
            resumed += u64::from(acknowledged > 0);
        }
        assert_eq!(disk.get(path).unwrap(), build.bytes, "case {case}");
    }
    assert!(losses > 10_000 && resumed > 10_000, "{losses} losses of power, {resumed} resumes");
    assert!(complete > 100, "{complete} partial files were complete");
    assert!(firsts.len() as u64 >= most - 1, "{} of {most} operations were hit first", firsts.len());
    assert!(20_000 / 2 / most > 100, "{most} operations");
}

/// A discarded build does not come back. Power is lost 1000 times after another job with the same
/// first blocks was started with `--fresh`, and that job always starts again, never refused because
/// of the old journal.
#[test]
fn discarded_builds_stay_so() {
    let build = Build::new();
    let path = Path::new("site.helio");
    let other = Job { settings: [9; 32], ..JOB };
    for case in 0..1000 {
        let mut random = Random(case);
        let disk = MemoryDisk::default();
        let start = |disk: &MemoryDisk, job, how| Writer::start(Arc::new(disk.clone()), path, job, how);
        let mut old = start(&disk, &JOB, Interrupted::Refuse).unwrap();
        build.blocks[..4].iter().for_each(|block| old.append(block.clone()).unwrap());
        old.keep().unwrap();
        let mut new = start(&disk, &other, Interrupted::Discard).unwrap();
        build.blocks[..4].iter().for_each(|block| new.append(block.clone()).unwrap());
        let disk = disk.lose_power(&mut random);
        assert_eq!(start(&disk, &other, Interrupted::Resume).unwrap().resumed(), None, "case {case}");
    }
}
