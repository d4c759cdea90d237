//! The trace cache that `build --store` fills (`store ls|gc|verify`).

use super::{Outcome, say};
use crate::cli::{StoreArgs, StoreCommand};
use heliotile::archive::{Archive, Folder, Store};
use heliotile::text::counted;
use heliotile::{Access, Result, archive};

/// `heliotile store`.
pub fn run(args: &StoreArgs) -> Result<Outcome> {
    match &args.command {
        StoreCommand::Ls { folder } => list(&Folder::open(folder)?),
        StoreCommand::Gc { folder, keep } => collect(&Folder::open(folder)?, keep.0),
        StoreCommand::Verify { folder } => verify(&Folder::open(folder)?),
    }
}

fn list(store: &dyn Store) -> Result<Outcome> {
    let mut text = String::from("scene             receivers        bytes  days unused  archive\n");
    for stored in store.list()? {
        let days = stored.used.elapsed().unwrap_or_default().as_secs_f64() / 86_400.0;
        let about = match Archive::open_with(&stored.path, Access::Read) {
            Ok(archive) => {
                let manifest = archive.manifest();
                let scene: String = manifest.scene.content_hash.chars().take(16).collect();
                format!("{scene:<16} {:>10}", manifest.receivers.count)
            }
            Err(_) => format!("{:<16} {:>10}", "damaged", "-"),
        };
        text += &format!("{about} {:>12} {days:>12.1}  {}\n", stored.bytes, stored.path.display());
    }
    say(&text)?;
    Ok(Outcome::Fine)
}

/// Removes the least recently used archives until the rest takes at most `keep` bytes.
fn collect(store: &dyn Store, keep: u64) -> Result<Outcome> {
    let all = store.list()?;
    let mut total: u64 = all.iter().map(|stored| stored.bytes).sum();
    let (before, mut removed) = (total, 0);
    for stored in &all {
        if total <= keep {
            break;
        }
        store.remove(stored)?;
        total -= stored.bytes;
        removed += 1;
    }
    let all = counted(all.len() as u64, "archive");
    say(&format!("{removed} of {all} removed, {} of {before} bytes\n", before - total))?;
    Ok(Outcome::Fine)
}

/// Checks every archive. A damaged one only costs time, as builds check what they use.
fn verify(store: &dyn Store) -> Result<Outcome> {
    let (mut text, mut bad) = (String::new(), 0);
    let all = store.list()?;
    for stored in &all {
        let found = match archive::verify(&stored.path, Access::Read, true) {
            Ok(report) if report.problems.is_empty() => continue,
            Ok(report) => {
                report.problems.iter().map(|p| format!("{}: {}", p.part, p.reason)).collect::<Vec<_>>().join("; ")
            }
            Err(error) => error.to_string(),
        };
        bad += 1;
        text += &format!("{}: {}\n", stored.path.display(), found);
    }
    say(&format!("{text}{} checked, {bad} bad\n", counted(all.len() as u64, "archive")))?;
    Ok(if bad == 0 { Outcome::Fine } else { Outcome::ProblemFound })
}
