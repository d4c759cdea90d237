//! `heliotile partition`, `catalogue` and `find`: regions in parts.

use super::console::terminal::Terminal;
use super::{Outcome, remark, say};
use crate::cli::{CatalogueArgs, FindArgs, PartitionArgs, quoted};
use heliotile::atlas::{AtlasPlan, CatalogueRequest, CutRequest, FILE, PartitionRequest};
use heliotile::remote::shown;
use heliotile::tables::tables;
use heliotile::text::counted;
use heliotile::{AccuracyRequest, Error, Provenance, Result};

/// `heliotile partition`.
pub fn partition(args: &PartitionArgs) -> Result<Outcome> {
    let request = PartitionRequest {
        cut: CutRequest {
            part_size_m: args.part_size.0,
            halo_m: args.halo.0,
            skyline_deg: args.skyline,
            scene: args.scene.request(),
            cover: args.cover.request(),
            accuracy: AccuracyRequest { quality: args.quality, set: args.set.clone(), ..AccuracyRequest::default() },
            no_scene: args.no_scene,
        },
        atlas: args.output.clone(),
        replace: args.replace,
        sample: args.sample,
        memory: args.memory.into(),
    };
    let plan = heliotile::atlas::partition(&request, &Terminal::default())?;
    remark(&summary(&plan, args))?;
    Ok(Outcome::Fine)
}

fn summary(plan: &AtlasPlan, args: &PartitionArgs) -> String {
    let atlas = &args.output;
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

/// `heliotile catalogue`.
pub fn catalogue(args: &CatalogueArgs, about: Provenance) -> Result<Outcome> {
    let request = CatalogueRequest { title: args.title.clone(), license: args.license.clone() };
    heliotile::atlas::catalogue(&args.atlas, &request, about, &Terminal::default())?;
    Ok(Outcome::Fine)
}

/// `heliotile find`: lists the parts that a box touches, one a line.
pub fn find(args: &FindArgs) -> Result<Outcome> {
    let found = heliotile::atlas::parts(&args.atlas, args.bbox)?;
    if found.is_empty() {
        let what = "no part of the atlas touches the box";
        return Err(Error::input(&shown(&args.atlas), None, what, "give --bbox in the coordinates of the scene files"));
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
