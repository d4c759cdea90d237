//! Each operation of a build fails once, on the real disk.

use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use crate::writing::Writer;
use crate::writing::disk::{Disk, DiskFile, SystemDisk};
use crate::writing::test_site::{Build, JOB};
use crate::writing::writer::Interrupted;
use heliotile_core::error::{Error, Result};

/// Failure of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Failure {
    /// Input or output error (EIO).
    Broken,
    /// Disk full (ENOSPC).
    Full,
    /// Half of a write, then disk full (ENOSPC).
    Short,
}

#[derive(Debug, Default)]
struct Plan {
    operations: u64,
    at: u64,
    failure: Option<Failure>,
    /// Action and path of the operation that failed.
    failed: Option<(&'static str, PathBuf)>,
    /// Number of operations after the failure, except removals.
    after: u64,
}

/// Real disk, one operation of which fails.
#[derive(Clone, Debug, Default)]
struct FaultyDisk(Arc<Mutex<Plan>>);

#[derive(Debug)]
struct Faulty {
    disk: FaultyDisk,
    path: PathBuf,
    file: Box<dyn DiskFile>,
}

impl FaultyDisk {
    fn step(&self, action: &'static str, path: &Path) -> io::Result<()> {
        let mut plan = self.0.lock().unwrap();
        plan.operations += 1;
        if plan.failed.is_some() && action != "remove" {
            plan.after += 1;
        }
        if plan.operations != plan.at {
            return Ok(());
        }
        plan.failed = Some((action, path.to_path_buf()));
        match plan.failure {
            Some(Failure::Broken) => Err(io::Error::from_raw_os_error(5)),
            Some(Failure::Full | Failure::Short) => Err(ErrorKind::StorageFull.into()),
            None => Ok(()),
        }
    }

    fn wrap(&self, path: &Path, file: Box<dyn DiskFile>) -> Box<dyn DiskFile> {
        Box::new(Faulty { disk: self.clone(), path: path.to_path_buf(), file })
    }
}

impl Disk for FaultyDisk {
    fn lock(&self, path: &Path) -> Result<Box<dyn DiskFile>> {
        self.step("create", path).map_err(Error::io(path, "create"))?;
        Ok(self.wrap(path, SystemDisk.lock(path)?))
    }

    fn open(&self, path: &Path) -> io::Result<Box<dyn DiskFile>> {
        self.step("open", path)?;
        Ok(self.wrap(path, SystemDisk.open(path)?))
    }

    fn create(&self, path: &Path) -> io::Result<Box<dyn DiskFile>> {
        self.step("create", path)?;
        Ok(self.wrap(path, SystemDisk.create(path)?))
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        self.step("rename", to)?;
        SystemDisk.rename(from, to)
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        self.step("remove", path)?;
        SystemDisk.remove(path)
    }

    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        self.step("sync", path)?;
        SystemDisk.sync_folder(path)
    }
}

impl DiskFile for Faulty {
    fn length(&self) -> io::Result<u64> {
        self.disk.step("read", &self.path)?;
        self.file.length()
    }

    fn read_at(&self, bytes: &mut [u8], offset: u64) -> io::Result<()> {
        self.disk.step("read", &self.path)?;
        self.file.read_at(bytes, offset)
    }

    fn write_at(&self, bytes: &[u8], offset: u64) -> io::Result<()> {
        let failed = self.disk.step("write", &self.path);
        if failed.is_err() && self.disk.0.lock().unwrap().failure == Some(Failure::Short) {
            self.file.write_at(&bytes[..bytes.len() / 2], offset)?;
        }
        failed?;
        self.file.write_at(bytes, offset)
    }

    fn set_len(&self, length: u64) -> io::Result<()> {
        self.disk.step("set the length", &self.path)?;
        self.file.set_len(length)
    }

    fn sync(&self) -> io::Result<()> {
        self.disk.step("sync", &self.path)?;
        self.file.sync()
    }
}

const OLD: &[u8] = b"an older archive";
/// Checkpoints after blocks 2, 5 and 6 of 11.
const CHECKPOINTS: u64 = 0b11_0010;

/// Runs `interrupted` with a failure at each of its operations, on what `prepare` leaves in a
/// folder. Returns the number of runs.
fn fail_everywhere(build: &Build, interrupted: Interrupted, prepare: impl Fn(&Path)) -> u64 {
    let mut runs = 0;
    for failure in [Failure::Broken, Failure::Full, Failure::Short] {
        for at in 1.. {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("site.helio");
            std::fs::write(&path, OLD).unwrap();
            prepare(&path);
            let disk = FaultyDisk::default();
            *disk.0.lock().unwrap() = Plan { at, failure: Some(failure), ..Plan::default() };
            let shared: Arc<dyn Disk> = Arc::new(disk.clone());
            let done = build.run(&shared, &path, interrupted, CHECKPOINTS, &mut 0);
            let found = std::fs::read(&path).unwrap();
            let plan = disk.0.lock().unwrap();
            let Some((action, where_)) = &plan.failed else {
                assert!(done.is_ok() && found == build.bytes);
                break;
            };
            runs += 1;
            match done {
                // Only the removal of the journal of a finished build may fail silently.
                Ok(_) => assert!(*action == "remove" && found == build.bytes, "{at}: {action}"),
                Err(error) => {
                    let message = error.to_string();
                    for part in [*action, where_.to_str().unwrap()] {
                        assert!(message.contains(part), "{at}: `{part}` is not in: {message}");
                    }
                    assert!(matches!(error, Error::Io { .. }), "{message}");
                    // The folder is synced after the rename, and before the first checkpoint
                    // counts.
                    assert!(found == OLD || (*action == "sync" && found == build.bytes), "{at}: {message}");
                    assert_eq!(plan.after, 0, "{at}: went on after: {message}");
                }
            }
            let healthy: Arc<dyn Disk> = Arc::new(SystemDisk);
            build.run(&healthy, &path, Interrupted::Resume, CHECKPOINTS, &mut 0).unwrap();
            assert!(std::fs::read(&path).unwrap() == build.bytes, "{failure:?} at {at}");
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "{failure:?} at {at}");
        }
    }
    runs
}

/// Leaves a build that was interrupted a block after its second checkpoint, in the middle of a
/// third.
fn interrupt(build: &Build, path: &Path) {
    let mut writer = Writer::create(path, &JOB).unwrap();
    for (row, block) in build.blocks.iter().take(6).enumerate() {
        writer.append(block.clone()).unwrap();
        if row == 1 || row == 4 {
            writer.checkpoint().unwrap();
        }
    }
    let log = path.with_file_name("site.helio.partial.log");
    std::fs::OpenOptions::new().append(true).open(log).unwrap().write_all(&[1; 50]).unwrap();
}

/// Each operation of a build with three checkpoints fails with EIO, ENOSPC or half a write, in over
/// 90 runs. The old file is there byte for byte, the message names path and action, nothing is
/// written after the failure, and a resume ends with equal bytes.
#[test]
fn a_build_survives_every_failure() {
    let build = Build::new();
    let runs = fail_everywhere(&build, Interrupted::Refuse, |_| {});
    assert!(runs > 90, "{runs} runs");
}

/// Each operation of a resume, and of a start that discards the interrupted build, fails in over 90
/// and 60 runs. The old file, the message and the resume are as they must be.
#[test]
fn a_resume_survives_every_failure() {
    let build = Build::new();
    let runs = fail_everywhere(&build, Interrupted::Resume, |path| interrupt(&build, path));
    assert!(runs > 90, "{runs} runs");
    let runs = fail_everywhere(&build, Interrupted::Discard, |path| interrupt(&build, path));
    assert!(runs > 60, "{runs} runs");
}
