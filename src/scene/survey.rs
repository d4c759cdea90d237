//! Survey of a site: where its objects lie. In: a site, whose files may be many. Out: the box of
//! each file and of each object in it. No mesh of all files is built: each thread reads one file
//! after the other.

use std::path::PathBuf;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::formats;
use crate::formats::{Content, ReadOptions};
use crate::geometry::Geometry;
use crate::site::{Part, SceneFiles};
use crate::surface_city::read::{no_raster, windows_of};
use heliotile_core::error::{Error, Result};
use heliotile_core::site::semantics::SurfaceKind;
use heliotile_place::reference::Reference;

/// Cells along a side of the windows in which a raster of surface heights is read.
const WINDOW: usize = 4096;

/// Box of a file and its objects.
#[derive(Clone, Debug)]
pub struct FileSurvey {
    /// Path of the file.
    pub file: PathBuf,
    /// Lowest and highest corner, scene coordinates, metres.
    pub bounds: [DVec3; 2],
    /// Objects of the file; empty for terrain.
    pub objects: Vec<SurveyedObject>,
}

/// Box of an object.
#[derive(Clone, Copy, Debug)]
pub struct SurveyedObject {
    /// Lowest and highest corner, scene coordinates, metres.
    pub bounds: [DVec3; 2],
    /// True if receivers are placed on the object by default: it is neither ground nor beside the
    /// buildings of a city model.
    pub is_usual: bool,
}

impl SceneFiles {
    /// Surveys all files, in their order.
    pub fn survey(&self) -> Result<Vec<FileSurvey>> {
        let all: Vec<Surveyed> = self.parts.par_iter().map(|part| survey(part, self)).collect::<Result<_>>()?;
        let mut systems = all.iter().filter_map(|one| Some((&one.found.file, one.system?)));
        let first = systems.next();
        let other = systems.find(|(_, system)| first.is_some_and(|(_, first)| !first.is_same(system)));
        if let (Some((first, system)), Some((file, other))) = (first, other) {
            let what = format!(
                "its coordinates are converted to metres of {other}, but those of {} to {system}",
                first.display()
            );
            return Err(Error::input(file, None, what, "give one coordinate system for all files as {crs}"));
        }
        Ok(all.into_iter().map(|one| one.found).collect())
    }
}

/// Survey of a file, and the plane system whose coordinates its reader converted to metres.
struct Surveyed {
    found: FileSurvey,
    system: Option<Reference>,
}

fn survey(part: &Part, site: &SceneFiles) -> Result<Surveyed> {
    let asked = ReadOptions {
        lod: part.lod.clone(),
        assume_version: part.assume_version,
        system: site.frame.epsg,
        footprints: part.footprints.clone(),
        ..ReadOptions::default()
    };
    let mut system = None;
    let (bounds, objects) = match formats::read(&part.file, &asked)? {
        Content::Polygons(_) if part.surface.is_some() => return Err(no_raster(&part.file)),
        Content::Polygons(geometry) => {
            // Geocentric files would get one origin each, so that their boxes could not be
            // compared.
            if geometry.local_frame.is_some() {
                let hint = "reproject the files to a system in metres with z up, for instance to UTM";
                return Err(Error::input(&part.file, None, "its coordinates are geocentric", hint));
            }
            let part = part.in_frame(&site.frame);
            let objects = objects(&geometry, |p| part.place(p));
            system = geometry.reference.filter(|_| geometry.in_metres);
            (joined(objects.iter().map(|object| object.bounds)), objects)
        }
        Content::Terrain(raster) if part.surface.is_some() => {
            let options = part.surface.clone().unwrap_or_default();
            let windows = windows_of(part, raster, &options, &site.frame, WINDOW)?;
            let objects: Vec<_> = windows.iter().flat_map(|geometry| objects(geometry, |p| p)).collect();
            (joined(objects.iter().map(|object| object.bounds)), objects)
        }
        Content::Terrain(raster) => {
            (raster.placed(part, &site.frame, part.reference.or(site.frame.references()[0]))?.extent(), Vec::new())
        }
    };
    if !(bounds[0].is_finite() && bounds[1].is_finite()) {
        return Err(Error::input(&part.file, None, "holds no face and no height", "leave it out of the site"));
    }
    Ok(Surveyed { found: FileSurvey { file: part.file.clone(), bounds, objects }, system })
}

fn objects(geometry: &Geometry, place: impl Fn(DVec3) -> DVec3) -> Vec<SurveyedObject> {
    let mut found = vec![SurveyedObject { bounds: NOTHING, is_usual: false }; geometry.objects.as_slice().len()];
    for (face, source) in geometry.faces().zip(geometry.source_faces()) {
        let Some(object) = found.get_mut(face.object as usize) else { continue };
        let corners = face.corners().iter().filter_map(|&corner| geometry.vertices.get(corner as usize));
        object.bounds = corners.fold(object.bounds, |[low, high], p| {
            let p = place(*p);
            [low.min(p), high.max(p)]
        });
        object.is_usual |= source.note.kind != Some(SurfaceKind::Ground);
    }
    for (number, note) in &geometry.object_notes {
        if let Some(object) = found.get_mut(*number as usize) {
            object.is_usual &= !note.beside;
        }
    }
    for footprint in &geometry.footprints {
        let [low, high] = footprint.bounds();
        let [foot_m, roof_m] = [footprint.heights.foot_m, footprint.heights.roof_m];
        let corners = [
            low.extend(foot_m),
            DVec3::new(low.x, high.y, foot_m),
            DVec3::new(high.x, low.y, foot_m),
            high.extend(roof_m),
        ];
        let bounds = corners.map(&place).into_iter().fold(NOTHING, |[low, high], p| [low.min(p), high.max(p)]);
        found.push(SurveyedObject { bounds, is_usual: true });
    }
    for tree in &geometry.trees {
        let half = DVec2::splat(0.5 * tree.crown.width_m);
        let bounds = [(tree.at - half).extend(0.0), (tree.at + half).extend(tree.crown.top_m)].map(&place);
        found.push(SurveyedObject { bounds: [bounds[0].min(bounds[1]), bounds[0].max(bounds[1])], is_usual: false });
    }
    found.retain(|object| object.bounds[0].is_finite());
    found
}

/// Box without a point.
const NOTHING: [DVec3; 2] = [DVec3::INFINITY, DVec3::NEG_INFINITY];

fn joined(boxes: impl Iterator<Item = [DVec3; 2]>) -> [DVec3; 2] {
    boxes.fold(NOTHING, |[low, high], [from, to]| [low.min(from), high.max(to)])
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// Two triangles of 1 and 2 m in two objects of an OBJ file, moved by 10 m, have their boxes
    /// exactly, and the file's box holds both.
    #[test]
    fn objects_have_their_exact_boxes() {
        let folder = tempfile::tempdir().expect("a folder");
        let square = |x: f64, size: f64, first: usize| {
            let f = first + 1;
            format!("v {x} 0 0\nv {} 0 0\nv {x} {size} {size}\nf {f} {} {}\n", x + size, f + 1, f + 2)
        };
        let path = folder.path().join("two.obj");
        std::fs::write(&path, format!("o a\n{}o b\n{}", square(0.0, 1.0, 0), square(5.0, 2.0, 3))).expect("written");
        let part = Part { offset: DVec3::new(10.0, 0.0, 0.0), ..Part::plain(Path::new(&path), None) };
        let found = SceneFiles { parts: vec![part], ..SceneFiles::default() }.survey().expect("readable");
        let boxes: Vec<[DVec3; 2]> = found[0].objects.iter().map(|object| object.bounds).collect();
        let at = |x: f64, size: f64| [DVec3::new(x, 0.0, 0.0), DVec3::new(x + size, size, size)];
        assert_eq!(boxes, [at(10.0, 1.0), at(15.0, 2.0)]);
        assert_eq!(found[0].bounds, [boxes[0][0], boxes[1][1]]);
        assert!(found[0].objects.iter().all(|object| object.is_usual));
    }
}
