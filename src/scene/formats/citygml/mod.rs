//! City models in XML. In: a CityGML file of version 1.0 to 3.0 (`.gml`, `.xml`), packed or not, or a zip of several. Out: polygons with holes,
//! named after city objects, of materials named after thematic surfaces, as of CityJSON: the same reader makes them.
//!
//! | file | what it does |
//! | --- | --- |
//! | `xml` | elements, one after the other, with limits for hostile files |
//! | `scan` | city object by city object |
//! | `feature`, `attributes` | buildings, their parts and surfaces, their attributes |
//! | `drawing` | solids, surfaces and rings of GML |
//! | `srs_name`, `northing_first`, `coordinates` | names of coordinate systems, and metres of what is in them |
//! | `store`, `members` | geometry of one city object, and where its references lead |
//! | `library` | geometry that several objects refer to |
//! | `closed`, `levels` | which level of detail is read |
//! | `assembly` | all that as a document of CityJSON |
//!
//! A file is read piece by piece: besides the polygons, memory holds one city object with its parts. A file whose objects refer to
//! geometry of others that comes later is read twice.
//!
//! # What never happens
//!
//! - Entities are not expanded, and no other file is opened, whatever a reference says.
//! - Appearance, code lists, addresses, time series and extensions (ADE) are passed, not stored.
//! - What is wrong with one object costs no other one; what breaks the XML costs the file.

mod assembly;
mod attributes;
mod closed;
mod coordinates;
mod drawing;
mod feature;
#[cfg(test)]
mod hostile_tests;
mod levels;
mod library;
mod members;
mod northing_first;
mod scan;
mod srs_name;
mod store;
#[cfg(test)]
mod tests;
mod xml;

use std::collections::BTreeSet;
use std::io::Read;
use std::path::Path;

use crate::formats::Asked;
use crate::formats::cityjson::frame::Frame;
use crate::formats::cityjson::objects::Reader;
use crate::formats::cityjson::{finish, level};
use crate::geometry::Geometry;
use crate::input;
use coordinates::Coordinates;
use heliotile_core::error::Result;
use levels::Levels;
use library::Library;
use scan::{Draft, MEND, Scan};
use xml::Xml;

/// Endings of names of CityGML.
pub(super) const ENDINGS: [&str; 2] = ["gml", "xml"];

/// Reads a city model.
pub(super) fn read(path: &Path, asked: &Asked) -> Result<Geometry> {
    read_all(path, asked, &|take| input::members::each(path, &ENDINGS, take))
}

/// Takes the bytes of a file.
type Opener<'o> = dyn FnMut(Box<dyn Read + '_>) -> Result<()> + 'o;

/// Reads all files that `open` gives, as often as need be.
fn read_all(path: &Path, asked: &Asked, open: &dyn Fn(&mut Opener) -> Result<()>) -> Result<Geometry> {
    let asked_lod = asked.lod.as_deref().map(|text| level(text, path)).transpose()?;
    let mut coordinates = Coordinates::new(asked.system);
    let mut model = Model {
        reader: Reader {
            file: path,
            line: None,
            asked: asked_lod,
            frame: Frame::METRES,
            templates: &[],
            geometry: Geometry::default(),
            objects: 0,
            levels: BTreeSet::new(),
            instanced: 0,
            skipped: Vec::new(),
            mend: MEND,
        },
        levels: Levels::default(),
        library: Library::default(),
    };
    let mut corners = 0;
    open(&mut |bytes| {
        corners = Scan::new(Xml::new(bytes, path), &mut coordinates, corners).all(&mut |draft| model.take(draft))?;
        Ok(())
    })?;
    if model.library.has_waiting() {
        open(&mut |bytes| {
            let scan = Scan::new(Xml::new(bytes, path), &mut coordinates, 0);
            scan.all(&mut |draft| {
                model.library.keep_wanted(&draft);
                Ok(())
            })?;
            Ok(())
        })?;
        model.take_waiting()?;
    }
    let Model { reader, levels, .. } = model;
    let mut geometry = finish(reader)?;
    geometry.reference = coordinates.reference();
    geometry.in_metres = coordinates.made_metres();
    geometry.notes.extend(coordinates.notes.iter().map(|note| format!("{}: {note}", path.display())));
    geometry.doubts.append(&mut coordinates.doubts);
    geometry.doubts.extend(levels.doubt());
    Ok(geometry)
}

/// A city model as far as it is read.
struct Model<'f> {
    reader: Reader<'f, 'f>,
    levels: Levels,
    library: Library,
}

impl Model<'_> {
    /// Adds an object, or puts it aside until all that it refers to is known.
    fn take(&mut self, mut draft: Draft) -> Result<()> {
        self.library.keep_templates(&draft);
        let missing = self.library.supply(&mut draft);
        let draft = if missing.is_empty() { Some(draft) } else { self.library.wait(draft, missing) };
        draft.map_or(Ok(()), |draft| assembly::add(&mut self.reader, &mut self.levels, draft))
    }

    /// Adds the objects that were put aside.
    fn take_waiting(&mut self) -> Result<()> {
        for mut draft in self.library.take_waiting() {
            // What is missing still leads nowhere, and is counted as such.
            self.library.supply(&mut draft);
            assembly::add(&mut self.reader, &mut self.levels, draft)?;
        }
        Ok(())
    }
}
