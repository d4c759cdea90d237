//! Builds that lose power, are killed or get an error at any operation, again and again, on a disk in memory that keeps any
//! part of what was not synced.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use super::disk::Disk;
use super::memory_disk::{Event, MemoryDisk, Random};
use super::test_site::Build;
use super::writer::Interrupted;

const OLD: &[u8] = b"an older archive";

/// Operations of an undisturbed build with a checkpoint after each block.
fn operations(build: &Build) -> u64 {
    let path = Path::new("site.helio");
    let disk = MemoryDisk::with(path, OLD);
    let shared: Arc<dyn Disk> = Arc::new(disk.clone());
    build.run(&shared, path, Interrupted::Refuse, u64::MAX, &mut 0).unwrap();
    disk.operations()
}

/// 20 000 builds, disturbed up to four times each by loss of power, a kill or a failed operation: `NAME` is the old or the whole
/// new file after every one, a resume finds the blocks of the last acknowledged checkpoint, and the end has the bytes of
/// an undisturbed build. Every operation is hit first at least 100 times, and over 10 000 losses of power come out of it.
#[test]
fn no_crash_loses_a_checkpoint() {
    let build = Build::new();
    let path = Path::new("site.helio");
    let most = operations(&build);
    let (mut losses, mut resumed, mut firsts) = (0, 0, BTreeSet::new());
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
    assert!(firsts.len() as u64 >= most - 1, "{} of {most} operations were hit first", firsts.len());
    assert!(20_000 / 2 / most > 100, "{most} operations");
}
