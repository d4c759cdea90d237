//! `heliotile receivers`: receivers on the surfaces of a scene, or along lines in it. In: a scene.
//! Out: `receivers.csv`, without receivers that are buried in a neighbour or the terrain; these are
//! counted.

use std::path::Path;

use super::console::terminal::Terminal;
use super::console::voice::remark_aside;
use super::{Outcome, remark};
use heliotile::cases::Receivers;
use heliotile::covering::{cover_site, summary, write, write_points};
use heliotile::output::{guard_output, guard_site};
use heliotile::text::counted;
use heliotile::tracing::{Placement, in_hulls};
use heliotile::{Observer, Provenance, Result};

/// `heliotile receivers`.
pub fn run(args: &Receivers, _: Provenance) -> Result<Outcome> {
    let site = args.scene.site()?;
    let to_file = args.output() != Path::new("-");
    if to_file {
        guard_site(args.output(), &site, &[])?;
    }
    if let Some(buried) = &args.buried {
        guard_site(buried, &site, &[Some(args.output())])?;
    }
    if let Some(along) = args.lines() {
        if to_file {
            guard_output(args.output(), &[&along.lines])?;
        }
        let points = along.points(&site, &Terminal::default())?;
        write_points(args.output(), &points)?;
        let text = format!("{}, {} m above the road\n", counted(points.len() as u64, "receiver"), along.height_m);
        return tell(to_file, args.output(), &text);
    }
    let (scene, covered) = cover_site(&site, &args.cover, &Terminal::default())?;
    // A build warns of them itself.
    in_hulls(covered.in_hulls).iter().for_each(|text| Terminal::default().warn(text));
    let offset_m = args.cover.offset_m;
    write(args.output(), &covered, covered.free(), offset_m, false)?;
    if let Some(path) = &args.buried {
        let buried = covered.all().filter(|row| row.3 != Placement::Free);
        write(path, &covered, buried, offset_m, true)?;
    }
    let text = summary(&covered, &scene);
    tell(to_file, args.output(), &text)
}

/// Prints a summary.
fn tell(to_file: bool, output: &Path, text: &str) -> Result<Outcome> {
    // Standard output may hold the table, so the summary goes to standard error.
    if to_file {
        remark(&format!("{}: {text}", output.display()))?
    } else {
        remark_aside(text)
    }
    Ok(Outcome::Fine)
}
