//! City models in XML. In: a CityGML file of version 1.0 to 3.0 (`.gml`, `.xml`), packed or not, or
//! a zip of several. Out: polygons with holes, named after city objects, with materials named after
//! thematic surfaces, as for CityJSON, whose reader makes them.
//!
//! | file | content |
//! | --- | --- |
//! | `xml` | elements, one after the other, with limits for hostile files |
//! | `scan` | a file, city object by city object |
//! | `feature`, `attributes` | buildings, their parts and surfaces, their attributes |
//! | `drawing` | solids, surfaces and rings of GML |
//! | `srs_name`, `northing_first`, `coordinates` | coordinate systems; conversion to metres |
//! | `store`, `members` | geometry of one city object, and resolution of its references |
//! | `library` | geometry that several objects refer to |
//! | `closed`, `levels` | choice of the level of detail |
//! | `assembly` | conversion to a CityJSON document |
//! | `plain_features` | collections of other features than city objects |
//!
//! A file is read piece by piece: besides the polygons, memory holds one city object with its
//! parts. A file is read twice if its objects refer to geometry of objects that come later.
//!
//! # What never happens
//!
//! - Entities are not expanded, and no other file is opened, whatever a reference says.
//! - Appearance, code lists, addresses, time series and extensions (ADE) are skipped, not stored.
//! - An error in one object does not affect other objects; an error in the XML makes the whole file
//!   unreadable.

mod assembly;
mod attributes;
#[cfg(test)]
mod case_tests;
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
mod plain_features;
mod scan;
mod srs_name;
mod store;
#[cfg(test)]
mod tests;

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::io::Read;
use std::path::Path;

use crate::formats::ReadOptions;
use crate::formats::cityjson::frame::Frame;
use crate::formats::cityjson::objects::Reader;
use crate::formats::cityjson::{finish, level};
use crate::formats::xml::Xml;
use crate::geometry::Geometry;
use coordinates::Coordinates;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::{Message, with_list};
use heliotile_files::input;
use heliotile_files::input::budget::WorkBudget;
use levels::Levels;
use library::Library;
pub(super) use plain_features::ENDINGS;
use scan::{Draft, MEND, Scan};

/// Reads a city model.
pub(super) fn read(path: &Path, asked: &ReadOptions) -> Result<Geometry> {
    let left_out = RefCell::new(Vec::new());
    let found = read_all(path, asked, &|take| {
        let found = input::members::each(path, &ENDINGS, &asked.footprints.layer, take)?;
        *left_out.borrow_mut() = found;
        Ok(())
    });
    let mut geometry = match found {
        // The collection may hold other features than city objects.
        Err(error @ Error::Input { .. }) => plain_features::read(path, asked).map(|found| found.ok_or(error))?,
        found => found,
    }?;
    let left_out = left_out.into_inner();
    if !left_out.is_empty() {
        let sentence = "themes of the zip that are no buildings and are left out, which {layer} NAME reads instead";
        geometry.doubts.push(with_list(sentence, left_out));
    }
    Ok(geometry)
}

/// Function that reads the bytes of a file.
type Opener<'o> = dyn FnMut(Box<dyn Read + '_>) -> Result<()> + 'o;

/// Reads all files that `open` opens: once, or twice if objects refer to geometry that comes later.
fn read_all(path: &Path, asked: &ReadOptions, open: &dyn Fn(&mut Opener) -> Result<()>) -> Result<Geometry> {
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
            budget: WorkBudget::of_file(path),
            coarser: Vec::new(),
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
    // The second pass only collects the geometry that waiting objects refer to.
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
    geometry
        .notes
        .extend(coordinates.notes.iter().map(|note| Message::from(format!("{}: ", path.display())).and(note)));
    geometry.doubts.append(&mut coordinates.doubts);
    geometry.doubts.extend(levels.doubt());
    Ok(geometry)
}

/// A city model that is being read.
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
            // References that are still missing lead nowhere, and `assembly` counts them.
            self.library.supply(&mut draft);
            assembly::add(&mut self.reader, &mut self.levels, draft)?;
        }
        Ok(())
    }
}
