//! Reader of EnergyPlus models. In: an epJSON or IDF file. Out: the outer hull of its buildings
//! with windows cut out, and their shades; normals outwards, x to the east. Multipliers draw
//! nothing twice.

mod epjson;
pub(crate) mod ground;
#[cfg(test)]
mod hostile_tests;
pub(crate) mod idf;
mod layout;
mod materials;
mod model;
mod panes;
mod place;
#[cfg(test)]
mod scene_tests;
mod shades;
mod surfaces;
#[cfg(test)]
mod tests;
mod turned;

use std::path::Path;

use crate::formats::ReadOptions;
use crate::formats::building::notes::Notes;
use crate::formats::building::standing::{Shades, ground_elevation_m};
use crate::geometry::Geometry;
use crate::model_version::doubt;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::Message;
use heliotile_files::input;
use heliotile_place::reference::Reference;
use materials::Materials;
use model::Model;
use place::PlaceObject;
use surfaces::Surfaces;

/// Returns true if a JSON file is an EnergyPlus model.
pub(super) fn is_model(bytes: &[u8]) -> bool {
    epjson::looks_like(bytes)
}

/// Reads a model: IDF text if the name ends with `.idf`, otherwise JSON.
pub(super) fn parse(bytes: &[u8], file: &Path, asked: &ReadOptions) -> Result<Geometry> {
    let model = if input::ending(file) == "idf" {
        idf::parse(bytes, file, asked.assume_version)?
    } else {
        epjson::parse(bytes, file)?
    };
    assemble(&model, file, asked)
}

fn assemble(model: &Model, file: &Path, asked: &ReadOptions) -> Result<Geometry> {
    let mut geometry = Geometry::default();
    let mut notes = Notes::default();
    if asked.assume_version.is_none() {
        geometry.warnings.extend(doubt(model.version, file).into_iter().map(Message::from));
    }
    let place = PlaceObject::read(model, file, &mut geometry.warnings)?;
    geometry.reference = reference(model, file, &mut notes)?;
    for object in model.of("GeometryTransform") {
        notes.add("GeometryTransform objects are ignored: the building keeps its proportions", &object.name);
    }
    for zone in model.of("Zone") {
        if zone.number_or(file, "multiplier", 1.0)? > 1.0 {
            notes.add("zones have a multiplier above 1 and are drawn once", &zone.name);
        }
    }
    let mut materials = Materials::new(model, file);
    let surfaces = Surfaces::read(model, file, &place, &mut geometry, &mut notes)?;
    surfaces.write(file, &mut geometry, &mut materials, &mut notes)?;
    shades::write(model, file, &place, &surfaces, &mut geometry, &mut materials, &mut notes)?;
    // Only surfaces of zones belong to the building: shades have no zone.
    if let Some(building) = model.of("Building").next() {
        for note in geometry.object_notes.values_mut().filter(|note| !note.object.is_empty()) {
            note.building.clone_from(&building.name);
        }
    }
    let elevation_m = ground_elevation_m(&mut geometry, Shades::Pass, file);
    geometry.ground = Some(ground::read(model, file, elevation_m, &mut notes)?);
    notes.say(file, &mut geometry.warnings);
    if asked.reflectances {
        geometry.stated = materials.into_stated();
    }
    if geometry.face_count() == 0 {
        let what = format!("no surface of the {} objects that were read faces outdoors", model.objects.len());
        let hint = "give a model with building or shading surfaces, such as BuildingSurface:Detailed";
        return Err(Error::input(file, None, what, hint));
    }
    Ok(geometry)
}

fn reference(model: &Model, file: &Path, notes: &mut Notes) -> Result<Option<Reference>> {
    let Some(site) = model.of("Site:Location").next() else { return Ok(None) };
    let (Some(latitude_deg), Some(longitude_deg)) = (site.number(file, "latitude")?, site.number(file, "longitude")?)
    else {
        return Ok(None);
    };
    if latitude_deg.abs() > 90.0 || longitude_deg.abs() > 180.0 {
        notes.add("locations have no valid latitude and longitude and are ignored", &site.name);
        return Ok(None);
    }
    Ok(Some(Reference::Place { latitude_deg, longitude_deg }))
}
