//! `heliotile archive copy`: an archive or an atlas to an object store, or from there. In: two
//! places. Out: the bytes of the first place at the second one, whole or not at all.

use super::console::terminal::Terminal;
use super::{Outcome, remark};
use heliotile::atlas::{Atlas, copied};
use heliotile::cases::Copy;
use heliotile::output::guard_output;
use heliotile::remote::{is_address, shown};
use heliotile::{Error, Provenance, Result};

/// `heliotile archive copy`.
pub fn run(args: &Copy, _: Provenance) -> Result<Outcome> {
    if !is_address(&args.from) && !is_address(&args.to) {
        let hint = "copy files with `cp`, or give an address such as s3://BUCKET/site.helio";
        return Err(Error::input(&args.to, None, "is a path, and so is the source", hint));
    }
    if let Some(atlas) = Atlas::find(&args.from)? {
        copied::copy(&atlas, &args.to, args.replace, &Terminal::watching())?;
        return Ok(Outcome::Fine);
    }
    if !is_address(&args.from) && args.from.is_dir() {
        let hint = "name an archive, another file, or the folder of an atlas";
        return Err(Error::input(&args.from, None, "is a folder without an atlas.json", hint));
    }
    if !is_address(&args.to) {
        guard_output(&args.to, &[])?;
    }
    let copied = heliotile::remote::copy(&args.from, &args.to, args.replace, &Terminal::default())?;
    let (to, megabytes) = (shown(&args.to), copied.bytes as f64 / 1e6);
    let to = to.display();
    match (copied.was_there, copied.beside) {
        (true, _) => remark(format!("{to}: up to date, nothing was sent\n"))?,
        (false, Some(beside)) => remark(format!("{to}: {megabytes:.2} MB, in {}\n", beside.display()))?,
        (false, None) => remark(format!("{to}: {megabytes:.2} MB\n"))?,
    }
    Ok(Outcome::Fine)
}
