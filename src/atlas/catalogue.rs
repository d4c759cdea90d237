//! A static STAC catalogue of an atlas. In: an atlas. Out: `collection.json` beside the plan and
//! `item.json` beside each archive, with pictures and the page that shows them.

use std::fs::File;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde_json::{Map, Value, json};

use crate::about::built;
use crate::listed::ListedPart;
use crate::listed::{PARTS, list};
use crate::opened::Atlas;
use crate::state::PartState;
use crate::thumbnails::Thumbnails;
use heliotile_core::archive::{Access, format};
use heliotile_core::error::{Error, Result};
use heliotile_core::observer::Observer;
use heliotile_core::text::{counted, message};
use heliotile_remote::places::open_archive;
use heliotile_requests::{DefaultRequest, Request};
use heliotile_results::crs_of;
use heliotile_results::outputs::provenance::Provenance;
use heliotile_results::outputs::sink::{write_file, write_texts};
use heliotile_results::outputs::stac::{
    COLLECTION, StacAsset, StacCollection, StacItem, THUMBNAIL, VIEWER, collection,
};
use heliotile_results::outputs::viewer_page::ViewerPage;

/// File name of the STAC item beside the archive of a part.
pub const ITEM: &str = "item.json";

/// Facts that a catalogue states beyond the contents of the atlas.
#[derive(Clone, Debug, Request, DefaultRequest)]
pub struct CatalogueRequest {
    /// Title of the catalogue [default: the folder's name].
    pub title: Option<String>,
    /// Licence of the data of the atlas, an SPDX name such as CC-BY-4.0.
    #[field(metavar = "NAME", default = "other")]
    pub license: String,
}

/// Writes the catalogue of the atlas at a path. `about` is the provenance that pictures state.
pub fn catalogue(atlas: &Path, request: &CatalogueRequest, about: Provenance, observer: &dyn Observer) -> Result<()> {
    let opened = Atlas::open(atlas)?;
    let whole = std::path::absolute(atlas).map_err(Error::io(atlas, "find"))?;
    let name = whole.file_name().map_or("atlas".into(), |name| name.to_string_lossy().into_owned());
    let listed = opened.parts(None)?;
    let done: Vec<(&ListedPart, &PathBuf)> = listed.iter().filter_map(|part| Some((part, part.archive()?))).collect();
    let Some((_, first)) = done.first() else { return built(&opened).map(drop) };
    let crs = crs_of(&open_archive(first, Access::Read)?);
    if !crs.has_degrees() {
        observer
            .warn("the atlas has no place on Earth, so items have no footprint: partition the region again with {crs}");
    }
    let pictures = Thumbnails::new(&done.iter().map(|(_, path)| path.as_path()).collect::<Vec<_>>(), about)?;
    if pictures.without() > 0 {
        let parts = counted(pictures.without() as u64, "part");
        observer.warn(message!(
            "{parts} without a thumbnail: it needs a known place ({{crs}}) and a stored scene (no {{no_scene}})"
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
    let title = request.title.as_deref().unwrap_or(&name);
    let json = collection(&StacCollection { id: &name, title, license: &request.license, assets }, &items, &crs);
    write_texts(atlas, &[(COLLECTION, text(&json))])?;
    let missing = listed.iter().filter(|part| part.state == PartState::Missing).count();
    if missing > 0 {
        observer.warn(format!("{} not built yet and left out of the catalogue", counted(missing as u64, "part")));
    }
    observer.report(format!("{}: {}\n", atlas.join(COLLECTION).display(), counted(items.len() as u64, "item")));
    Ok(())
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
    state("halo_m", plan.cut.halo_m.into());
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
