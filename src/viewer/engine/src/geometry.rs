//! Geometry for the page. In: blocks of the archive. Out: the scene's triangles, places and patches
//! of receivers, relative to the scene's origin, metres.

use glam::DVec3;
use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::{format, tables};
use heliotile_core::site::patch::Patch;

use crate::Answered;
use crate::answer::{Answer, Numbers};
use crate::open::Opened;

/// Area of the square drawn for a receiver whose area is not given, m2.
const AREA_M2: f64 = 1.0;

/// Side of the box that stands for receivers of one place, metres: the width of a person.
const BOX_M: f64 = 0.6;

/// Answers a chunk of the scene's triangles.
pub fn scene(opened: &Opened, chunk: u32) -> Answered {
    let table = tables::GeometryTable::from_block(&opened.site.block(format::SCENE, TileNumber(chunk))?)?;
    Ok(Answer::of(())
        .with("vertices", Numbers::F32(table.vertex.as_flattened()))
        .with("corners", Numbers::U32(table.corner.as_flattened()))
        .with("materials", Numbers::U16(&table.material)))
}

/// Answers the shapes that stand for the receivers of a tile, from the tile's overview or else from
/// the receivers' places. A receiver without a patch is drawn as a square of its area. Receivers
/// that look to several sides from one place are drawn as a box around it.
pub fn overview(opened: &Opened, tile: u32) -> Answered {
    let tile = opened.tile(tile)?;
    let rows = opened.archive.entries_of(format::RECEIVERS).iter().find(|entry| entry.tile.0 == tile);
    match opened.site.tile_overview(tile, rows.map_or(0, |entry| entry.items as usize))? {
        Some(table) => Ok(Drawn {
            places: table.position.clone(),
            normals: table.normals().map(|normal| normal.as_vec3().to_array()).collect(),
            areas: table.area.clone(),
            patches: table.patches(),
            sky: table.sky_views().collect(),
            clear_year: table.clear_year,
        }
        .answer()),
        None => {
            let table = opened.site.tile_receivers(tile)?;
            let origin = DVec3::from(opened.archive.manifest().scene.origin_m);
            let place = |place: &[f64; 3]| (DVec3::from(*place) - origin).as_vec3().to_array();
            Ok(Drawn {
                places: table.position.iter().map(place).collect(),
                normals: table.normal.iter().map(|normal| normal.map(|x| x as f32)).collect(),
                areas: table.area.iter().map(|area| *area as f32).collect(),
                patches: vec![Patch::default(); table.rows()],
                sky: table.sky_view.clone(),
                clear_year: Vec::new(),
            }
            .answer())
        }
    }
}

/// Receivers of a tile as they are drawn; places are relative to the scene's origin.
struct Drawn {
    places: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    /// Areas, m2; 0 where not given.
    areas: Vec<f32>,
    /// Patches; an empty patch where none is given.
    patches: Vec<Patch>,
    sky: Vec<f32>,
    /// Sums of a clear year, kWh/m2; empty where not given.
    clear_year: Vec<f32>,
}

impl Drawn {
    /// Returns the offset of the box face that stands for a receiver, metres, or `None` if it is no
    /// face. A receiver is a face if another one at its place looks sideways of it or the other
    /// way, and one of the two has no patch.
    fn face(&self, row: usize) -> Option<[f32; 3]> {
        let (place, &[x, y, z]) = (self.places.get(row)?, self.normals.get(row)?);
        let is_bare = |row: usize| {
            let (patch, area) = (self.patches.get(row), self.areas.get(row));
            patch.is_some_and(Patch::is_empty) && area == Some(&0.0)
        };
        let here = (0..self.places.len()).filter(|other| *other != row && self.places.get(*other) == Some(place));
        let mut beside =
            here.filter(|other| is_bare(row) || is_bare(*other)).filter_map(|other| self.normals.get(other));
        let half_m = 0.5 * BOX_M as f32;
        let is_face = beside.any(|[a, b, c]| {
            let along = x * a + y * b + z * c;
            along.abs() < 0.5 || along < -0.99
        });
        is_face.then_some([half_m * x, half_m * y, half_m * z])
    }

    fn answer(&self) -> Answer {
        let (mut points, mut corners): (Vec<[f32; 3]>, Vec<[u32; 3]>) = (Vec::new(), Vec::new());
        let mut owner: Vec<u32> = Vec::new();
        let mut draw = |row: usize, place: [f32; 3], patch: &Patch| {
            for polygon in patch.polygons() {
                let first = points.len() as u32;
                points.extend(polygon.iter().map(|mm| [0, 1, 2].map(|axis| place[axis] + mm[axis] as f32 * 1e-3)));
                for last in 2..polygon.len() as u32 {
                    corners.push([first, first + last - 1, first + last]);
                    owner.push(row as u32);
                }
            }
        };
        let facing = self.normals.iter().zip(&self.areas);
        for (row, (place, (patch, (normal, area)))) in
            self.places.iter().zip(self.patches.iter().zip(facing)).enumerate()
        {
            let normal = DVec3::from(normal.map(f64::from));
            draw(row, *place, patch);
            if let Some(off_m) = self.face(row) {
                let place = [0, 1, 2].map(|axis| place[axis] + off_m[axis]);
                draw(row, place, &Patch::square(normal, BOX_M * BOX_M));
            } else if patch.is_empty() {
                let area_m2 = if *area > 0.0 { f64::from(*area) } else { AREA_M2 };
                draw(row, *place, &Patch::square(normal, area_m2));
            }
        }
        let unknown = vec![f32::NAN; self.places.len()];
        let reference = if self.clear_year.is_empty() { &unknown } else { &self.clear_year };
        Answer::of(())
            .with("middle", Numbers::F32(self.places.as_flattened()))
            .with("normal", Numbers::F32(self.normals.as_flattened()))
            .with("points", Numbers::F32(points.as_flattened()))
            .with("corners", Numbers::U32(corners.as_flattened()))
            .with("owner", Numbers::U32(&owner))
            .with("sky", Numbers::F32(&self.sky))
            .with("reference", Numbers::F32(reference))
    }
}
