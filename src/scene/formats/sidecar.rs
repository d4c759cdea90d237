//! Small files beside a raster. In: the path of the raster. Out: the position of its cells from its
//! world file, its coordinate system from its `.prj`, and notes on its band from its `.aux.xml`.

use std::path::{Path, PathBuf};

use glam::DVec2;

use crate::formats::gdal_metadata::AuxNotes;
use crate::formats::wkt::TextSystem;
use crate::terrain::raster::{Meaning, degrees, geocentric};
use crate::text::{excerpt, utf8};
use heliotile_core::error::{Error, Result};
use heliotile_core::text::{Message, message};
use heliotile_files::input;
use heliotile_place::epsg_numbers::Axes;

/// Position of a raster: centre of its first cell, and cell size east and south, in units of its
/// system.
pub(super) struct WorldFile {
    pub first: DVec2,
    pub step: DVec2,
}

/// Returns the path of the file that has the name of `raster` and another ending, in lower or upper
/// case.
fn beside(raster: &Path, endings: &[&str]) -> Option<PathBuf> {
    let name = raster.file_name()?.to_string_lossy();
    let plain = input::without_packing(&name);
    let (stem, _) = plain.rsplit_once('.')?;
    let names = endings.iter().flat_map(|ending| [(*ending).to_owned(), ending.to_uppercase()]);
    names.map(|ending| raster.with_file_name(format!("{stem}.{ending}"))).find(|path| path.is_file())
}

/// Returns the bytes of the file that has the name of `file` and another ending, if it exists.
pub(super) fn bytes_beside(file: &Path, ending: &str) -> Result<Option<Vec<u8>>> {
    beside(file, &[ending]).map(|path| input::read(&path)).transpose()
}

/// Returns the text of a file beside a raster, decoded to UTF-8.
fn text_of(path: &Path) -> Result<String> {
    Ok(String::from_utf8_lossy(&utf8(input::read(path)?)).into_owned())
}

/// Reads the world file of a raster: `.tfw`, `.tifw`, `.tiffw` or `.wld`, six numbers, one a line
/// (Esri; the GDAL manual, "World files").
pub(super) fn world_file(raster: &Path) -> Result<Option<WorldFile>> {
    let Some(path) = beside(raster, &["tfw", "tifw", "tiffw", "wld"]) else { return Ok(None) };
    let text = text_of(&path)?;
    let numbers: Vec<Option<f64>> = text.split_whitespace().map(|word| word.replace(',', ".").parse().ok()).collect();
    let hint = "write six lines: width of a cell, 0, 0, minus its height, x and y of the middle of the first cell";
    let refuse = |what: String| Err(Error::input(&path, None, what, hint));
    match numbers.as_slice() {
        [Some(wide), Some(turned), Some(other), Some(high), Some(x), Some(y), ..] => {
            if *turned != 0.0 || *other != 0.0 || *wide <= 0.0 || *high >= 0.0 {
                return refuse(format!(
                    "the world file turns or mirrors the raster ({wide}, {turned}, {other}, {high})"
                ));
            }
            Ok(Some(WorldFile { first: DVec2::new(*x, *y), step: DVec2::new(*wide, -*high) }))
        }
        _ => refuse(format!("the world file holds `{}`, not six numbers", excerpt(text.trim().as_bytes()))),
    }
}

/// Returns the position of a raster by the `GeoTransform` of its `.aux.xml`; `None` if it is absent
/// or rotated.
pub(super) fn place_of_aux(aux: &AuxNotes) -> Option<WorldFile> {
    let numbers: Vec<f64> = aux.transform.as_ref()?.split(',').map_while(|word| word.trim().parse().ok()).collect();
    match numbers.as_slice() {
        [x, wide, turned, y, other, high] if *turned == 0.0 && *other == 0.0 && *wide > 0.0 && *high < 0.0 => {
            let step = DVec2::new(*wide, -*high);
            Some(WorldFile { first: DVec2::new(*x, *y) + DVec2::new(0.5, -0.5) * step, step })
        }
        _ => None,
    }
}

/// Returns the notes in the `.aux.xml` of a raster, which is named after the raster's whole name.
pub(super) fn aux(raster: &Path) -> Result<AuxNotes> {
    let Some(name) = raster.file_name().map(|name| name.to_string_lossy()) else { return Ok(AuxNotes::default()) };
    let path = raster.with_file_name(format!("{}.aux.xml", input::without_packing(&name)));
    if path.is_file() { text_of(&path).map(|xml| AuxNotes::parse(&xml)) } else { Ok(AuxNotes::default()) }
}

/// Completes `meaning` from the `.prj` or `.aux.xml` beside a raster: its coordinate system and its
/// units. Does nothing if the raster states its own system.
pub(super) fn complete(
    meaning: &mut Meaning,
    raster: &Path,
    aux: &AuxNotes,
    warnings: &mut Vec<Message>,
) -> Result<()> {
    if meaning.reference.is_some() {
        return Ok(());
    }
    let (path, text) = match (beside(raster, &["prj"]), &aux.srs) {
        (Some(path), _) => (path.clone(), text_of(&path)?),
        (None, Some(text)) => (raster.to_owned(), text.clone()),
        (None, None) => return Ok(()),
    };
    let shown = path.display();
    let Some(system) = TextSystem::parse(&text) else {
        let text = excerpt(text.trim().as_bytes());
        warnings.push(message!(
            "{shown}: `{text}` is not a coordinate system in well-known text (WKT); the place on Earth stays unknown: give {{crs}}"
        ));
        return Ok(());
    };
    let why = format!("{shown} names `{}`", system.name);
    match system.axes {
        Some(Axes::Degrees) => return Err(degrees(raster, &why)),
        Some(Axes::Geocentric) => return Err(geocentric(raster, &why)),
        Some(Axes::Plane) if system.epsg.is_none() => warnings.push(message!(
            "{shown}: no EPSG code was found for the coordinate system `{}`; the place on Earth stays unknown: give {{crs}}",
            system.name
        )),
        _ => {}
    }
    meaning.reference = system.reference();
    meaning.projected |= system.axes == Some(Axes::Plane);
    meaning.plane_unit_m = meaning.plane_unit_m.or(system.plane_unit_m);
    meaning.height_unit_m = meaning.height_unit_m.or(system.height_unit_m);
    Ok(())
}
