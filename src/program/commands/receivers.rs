//! `heliotile receivers`: the surfaces of a scene covered with receivers. In: a scene. Out: `receivers.csv`, without those that are
//! buried in a neighbour or the terrain, which are counted.

use std::path::Path;

use super::console::terminal::Terminal;
use super::console::voice::remark_aside;
use super::{Outcome, remark};
use crate::cli::ReceiversArgs;
use heliotile_builder::trace::placement::Placement;
use heliotile_builder::writing::guards::guard_site;
use heliotile_core::error::Result;
use heliotile_results::covering::{cover_site, summary, write};

/// `heliotile receivers`.
pub fn run(args: &ReceiversArgs) -> Result<Outcome> {
    let site = args.scene.site()?;
    let to_file = args.output != Path::new("-");
    if to_file {
        guard_site(&args.output, &site, &[])?;
    }
    if let Some(buried) = &args.buried {
        guard_site(buried, &site, &[Some(&args.output)])?;
    }
    let (scene, covered) = cover_site(&site, &args.cover.request(), &Terminal::default())?;
    let offset_m = args.cover.offset.0;
    write(&args.output, &covered, covered.free(), offset_m, false)?;
    if let Some(path) = &args.buried {
        let buried = covered.all().filter(|row| row.3 != Placement::Free);
        write(path, &covered, buried, offset_m, true)?;
    }
    let text = summary(&covered, &scene);
    // Standard output may be the table.
    if to_file {
        remark(&format!("{}: {text}", args.output.display()))?
    } else {
        remark_aside(&text)
    }
    Ok(Outcome::Fine)
}
