//! `heliotile receivers`: the surfaces of a scene covered with receivers. In: a scene. Out: `receivers.csv`, without those that are
//! buried in a neighbour or the terrain, which are counted.

use std::path::Path;

use super::terminal::Terminal;
use super::voice::remark_aside;
use super::{Outcome, guard_site, remark, warn};
use crate::cli::{CoverArgs, ReceiversArgs};
use crate::covering::{CoverRequest, Covered, cover_scene, summary, write};
use heliotile_builder::trace::placement::Lying;
use heliotile_core::error::Result;
use heliotile_scene::Scene;
use heliotile_scene::load::Soup;
use heliotile_scene::site::Site;

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
    let (scene, covered) = cover_site(&site, &args.cover)?;
    let offset_m = args.cover.offset.0;
    write(&args.output, &covered, covered.free(), offset_m, false)?;
    if let Some(path) = &args.buried {
        let buried = covered.all().filter(|row| row.3 != Lying::Free);
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

/// Reads a scene and covers it; says what is odd about it.
pub(super) fn cover_site(site: &Site, args: &CoverArgs) -> Result<(Scene, Covered)> {
    let (scene, soup) = Scene::load_with_objects(site)?;
    // Before what may fail.
    say_of(&scene);
    cover(scene, soup, site, args)
}

/// The same, and says nothing of the scene.
pub(super) fn cover_quietly(site: &Site, args: &CoverArgs) -> Result<(Scene, Covered)> {
    let (scene, soup) = Scene::load_with_objects(site)?;
    cover(scene, soup, site, args)
}

fn cover(scene: Scene, soup: Soup, site: &Site, args: &CoverArgs) -> Result<(Scene, Covered)> {
    let asked = CoverRequest { within: site.within, ..args.request() };
    let covered = cover_scene(&scene, soup, &asked, &Terminal::default())?;
    Ok((scene, covered))
}

/// Says what is odd about a scene.
pub(super) fn say_of(scene: &Scene) {
    scene.report.warnings.iter().for_each(|w| warn(w));
    // Standard output may be a table.
    scene.report.notes.iter().for_each(|note| remark_aside(&format!("{note}\n")));
}
