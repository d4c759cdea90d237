//! `heliotile atlas`: regions in parts.

use std::path::Path;

use super::console::terminal::Terminal;
use super::{Outcome, remark, say};
use crate::cli::quoted;
use heliotile::atlas::{AtlasPlan, FILE, PartitionRequest};
use heliotile::cases::{Catalogue, Find};
use heliotile::remote::shown;
use heliotile::requests::Problem;
use heliotile::tables::tables;
use heliotile::text::counted;
use heliotile::{Error, Provenance, Result};

/// `heliotile atlas partition`.
pub fn partition(request: &PartitionRequest, _: Provenance) -> Result<Outcome> {
    let plan = heliotile::atlas::partition(request, &Terminal::default())?;
    remark(summary(&plan, &request.atlas))?;
    Ok(Outcome::Fine)
}

fn summary(plan: &AtlasPlan, atlas: &Path) -> String {
    let mut text = format!(
        "{}: {} of {} m with {} m around them, of {}\n",
        atlas.join(FILE).display(),
        counted(plan.parts.len() as u64, "part"),
        plan.cut.part_size_m,
        plan.cut.halo_m,
        counted(plan.files.len() as u64, "file")
    );
    if let Some(seams) = &plan.seams {
        text += &format!("  {}\n", seams.words());
    }
    let last = plan.parts.len() - 1;
    text + &format!(
        "  next: heliotile build {} --part K, K from 0 to {last}, in any order and anywhere; or --part all\n",
        quoted(&atlas.to_string_lossy())
    )
}

/// `heliotile atlas catalogue`.
pub fn catalogue(args: &Catalogue, about: Provenance) -> Result<Outcome> {
    heliotile::atlas::catalogue(&args.atlas, &args.request, about, &Terminal::default())?;
    Ok(Outcome::Fine)
}

/// `heliotile atlas find`: lists the parts that a box touches, one a line.
pub fn find(args: &Find, _: Provenance) -> Result<Outcome> {
    let found = heliotile::atlas::parts(&args.atlas, args.bbox)?;
    if found.is_empty() {
        let what = "no part of the atlas touches the box";
        return Err(Error::input(&shown(&args.atlas), None, what, "give {bbox} in the coordinates of the scene files")
            .because(Problem::Empty));
    }
    let mut out = String::from("part,x,y,state,archive\n");
    for part in found {
        let state = part.state.word();
        let path = part.archive().map(|path| shown(path).display().to_string()).unwrap_or_default();
        out += &format!("{},{},{},{state},{}\n", part.name, part.low.x, part.low.y, tables::quoted(&path));
    }
    say(&out)?;
    Ok(Outcome::Fine)
}
