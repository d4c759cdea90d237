//! `heliotile catalogue` and `heliotile find`: what an atlas holds, for programs that know STAC, and which parts lie where. In: an atlas.
//! Out: `collection.json` beside the plan and `item.json` beside each archive, with pictures, the page
//! that shows them; a list of parts.

use std::fs::File;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde_json::{Map, Value, json};

use super::about::built;
use super::listed::{ListedPart, parts};
use super::opened::Atlas;
use super::page::{PARTS, list};
use super::part::PartState;
use super::thumbnails::Thumbnails;
use crate::cli::{CatalogueArgs, FindArgs};
use crate::commands::{Outcome, remark, say, warn};
use crate::files::{open_archive, shown};
use crate::outputs::provenance::Provenance;
use crate::outputs::sink::{write_file, write_texts};
use crate::outputs::stac::{COLLECTION, StacAsset, StacCollection, StacItem, THUMBNAIL, VIEWER, collection};
use crate::outputs::tables::quoted;
use crate::outputs::viewer_page::ViewerPage;
use crate::results::crs_of;
use heliotile_core::archive::{Access, format};
use heliotile_core::error::{Error, Result};
use heliotile_core::text::counted;

/// Beside the archive of a part.
pub(super) const ITEM: &str = "item.json";

/// `heliotile catalogue`.
pub fn catalogue(args: &CatalogueArgs, about: Provenance) -> Result<Outcome> {
    let opened = Atlas::open(&args.atlas)?;
    let atlas = args.atlas.as_path();
    let whole = std::path::absolute(atlas).map_err(Error::io(atlas, "find"))?;
    let name = whole.file_name().map_or("atlas".into(), |name| name.to_string_lossy().into_owned());
    let listed = opened.parts(None)?;
    let done: Vec<(&ListedPart, &PathBuf)> = listed.iter().filter_map(|part| Some((part, part.archive()?))).collect();
    let Some((_, first)) = done.first() else { return built(&opened).map(|_| Outcome::Fine) };
    let crs = crs_of(&open_archive(first, Access::Read)?);
    if !crs.has_degrees() {
        warn("nobody says where the atlas lies on Earth: items have no footprint (partition it with --crs)");
    }
    let pictures = Thumbnails::of(&done.iter().map(|(_, path)| path.as_path()).collect::<Vec<_>>(), about)?;
    if pictures.without() > 0 {
        let parts = counted(pictures.without() as u64, "part");
        warn(&format!(
            "{parts} without a thumbnail: a clear year is stored where the place is known (--crs) and scenes are (no --no-scene)"
        ));
    }
    let item = |(number, (part, path)): (usize, &(&ListedPart, &PathBuf))| {
        let mut found = item(part, path, &opened, &name)?;
        if let Some(png) = pictures.part(number)? {
            write_file(&path.with_file_name(THUMBNAIL), &png)?;
            found.0.assets.push(StacAsset::thumbnail(&png, pictures.top_kwh_m2()));
        }
        Ok(found)
    };
    let items: Vec<(StacItem, String)> = done.par_iter().enumerate().map(item).collect::<Result<_>>()?;
    for ((item, _), (_, path)) in items.iter().zip(&done) {
        let folder = path.parent().unwrap_or(atlas);
        write_texts(folder, &[(ITEM, text(&item.json(&crs)))])?;
    }
    write_texts(atlas, &[(PARTS, list(&listed))])?;
    ViewerPage::default().with_option("parts", PARTS).write(&atlas.join(VIEWER))?;
    let mut assets = Vec::new();
    if let Some(png) = pictures.all()? {
        write_file(&atlas.join(THUMBNAIL), &png)?;
        assets.push(StacAsset::thumbnail(&png, pictures.top_kwh_m2()));
    }
    let title = args.title.as_deref().unwrap_or(&name);
    let json = collection(&StacCollection { id: &name, title, license: &args.license, assets }, &items, &crs);
    write_texts(atlas, &[(COLLECTION, text(&json))])?;
    let missing = listed.iter().filter(|part| part.state == PartState::Missing).count();
    if missing > 0 {
        warn(&format!("{} not built yet, and not in the catalogue", counted(missing as u64, "part")));
    }
    remark(&format!("{}: {}\n", atlas.join(COLLECTION).display(), counted(items.len() as u64, "item")))?;
    Ok(Outcome::Fine)
}

fn text(json: &Value) -> String {
    format!("{json:#}\n")
}

fn item(part: &ListedPart, path: &Path, atlas: &Atlas, name: &str) -> Result<(StacItem, String)> {
    let plan = &atlas.plan;
    let archive = open_archive(path, Access::Read)?;
    if let Some(planned) = plan.parts.iter().find(|planned| planned.name == part.name) {
        atlas.check_place(planned, &archive)?;
    }
    let manifest = archive.manifest();
    let file = File::open(path).map_err(Error::io(path, "open"))?;
    let about = file.metadata().map_err(Error::io(path, "read the length of"))?;
    let checksum = blake3::Hasher::new().update_reader(file).map_err(Error::io(path, "read"))?.finalize();
    let mut properties = Map::new();
    let mut state = |key: &str, value: Value| properties.insert(format!("heliotile:{key}"), value);
    state("root", format::hex(&archive.root()).into());
    state("receivers", manifest.receivers.count.into());
    state("quality", manifest.settings.quality.clone().into());
    state(
        "settings",
        manifest.settings.numbers().map(|(setting, value)| (setting.name.to_owned(), json!(value))).collect(),
    );
    state("halo_m", plan.halo_m.into());
    if let Some(seams) = &plan.seams {
        state("seams_rmse_percent", seams.rmse_percent.into());
        state("seams_at_most_percent", seams.at_most_percent.into());
    }
    let written = about.modified().map_err(Error::io(path, "read the time of"))?;
    let file_name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let item = StacItem {
        id: part.name.clone(),
        collection: name.to_owned(),
        low: part.low,
        high: part.high,
        written,
        properties,
        assets: vec![StacAsset::archive(&file_name, about.len(), checksum)],
    };
    Ok((item, format!("parts/{}/{ITEM}", part.name)))
}

/// `heliotile find`: parts that a box touches, one a line.
pub fn find(args: &FindArgs) -> Result<Outcome> {
    let found = parts(&args.atlas, args.bbox)?;
    if found.is_empty() {
        let what = "no part of it lies in the box";
        return Err(Error::input(&shown(&args.atlas), None, what, "--bbox is in the coordinates of the scene files"));
    }
    let mut out = String::from("part,x,y,state,archive\n");
    for part in found {
        let state = part.state.word();
        let path = part.archive().map(|path| shown(path).display().to_string()).unwrap_or_default();
        out += &format!("{},{},{},{state},{}\n", part.name, part.low.x, part.low.y, quoted(&path));
    }
    say(&out)?;
    Ok(Outcome::Fine)
}
