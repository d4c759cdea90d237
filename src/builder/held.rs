//! The scene and receivers that an archive was built from. In: an archive. Out: its triangles,
//! materials, objects and receivers.

use glam::DVec3;
use rayon::prelude::*;

use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::tables::{GeometryTable, ObjectsTable, OverviewTable, PartsTable};
use heliotile_core::archive::{Archive, format};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::opened::OpenSite;
use heliotile_core::site::grid::Grid;
use heliotile_core::site::receiver::Receiver;
use heliotile_scene::change::TracedScene;
use heliotile_scene::mesh_objects::MeshObjects;

/// Refuses an archive that does not hold its scene.
pub fn check_scene(archive: &Archive) -> Result<()> {
    if archive.has(format::SCENE, TileNumber::FIRST) {
        return Ok(());
    }
    Err(Error::input(
        archive.path(),
        None,
        "the archive does not hold its scene, so what changes cannot be found",
        "build it again without {no_scene}, or trace the changed scene anew, without {from}",
    )
    .because(Problem::Lacks("scene")))
}

/// Returns the scene that an archive was traced from, or an error if the archive does not hold it.
pub fn held_scene(archive: &Archive) -> Result<TracedScene> {
    check_scene(archive)?;
    let site = OpenSite::open(archive)?;
    let chunks = archive.entries_of(format::SCENE).len() as u32;
    let read = |chunk: u32| GeometryTable::from_block(&site.block(format::SCENE, TileNumber(chunk))?);
    let tables: Vec<GeometryTable> = (0..chunks).into_par_iter().map(read).collect::<Result<_>>()?;
    let scene = &archive.manifest().scene;
    let corners = |table: &GeometryTable| -> Vec<[DVec3; 3]> {
        // A checked table has no corner beyond its vertices.
        let point = |corner: u32| DVec3::from(table.vertex[corner as usize].map(f64::from));
        table.corner.iter().map(|corners| corners.map(point)).collect()
    };
    Ok(TracedScene {
        grid: Grid { origin: scene.origin_m.into(), step: scene.grid_step_m },
        triangles: tables.iter().flat_map(corners).collect(),
        triangle_material: tables.iter().flat_map(|table| table.material.iter().copied()).collect(),
        materials: site.materials().to_vec(),
        objects: held_objects(archive, &tables)?,
    })
}

/// Returns the objects of all triangles, chunk by chunk, or no objects if the archive holds none.
fn held_objects(archive: &Archive, scene: &[GeometryTable]) -> Result<MeshObjects> {
    if !archive.has(format::OBJECTS, TileNumber::FIRST) {
        return Ok(MeshObjects::default());
    }
    let (mut objects, mut of_triangle) = (Vec::new(), Vec::new());
    for (chunk, geometry) in (0..).zip(scene) {
        let block = archive.block(format::OBJECTS, TileNumber(chunk))?;
        let table = ObjectsTable::from_block(&block)?;
        if table.rows() != geometry.rows() {
            return Err(block.corrupt(format!("{} rows", table.rows()), format!("{} triangles", geometry.rows())));
        }
        // Rows of an objects table count from 0 in every chunk.
        let first = objects.len() as u32;
        of_triangle.extend(table.row.iter().map(|row| first + u32::from(*row)));
        objects.extend(table.objects());
    }
    Ok(MeshObjects::new(&objects, &of_triangle))
}

/// Returns the receivers of an archive in its order, with the part of the model that each belongs
/// to and, if the archive holds an overview, their patches.
pub fn held_receivers(archive: &Archive) -> Result<Vec<Receiver>> {
    let mut receivers = Vec::new();
    for tile in 0..archive.tiles() {
        let mut held = PartsTable::receivers(archive, tile)?;
        OverviewTable::join(archive, tile, &mut held)?;
        receivers.extend(held);
    }
    Ok(receivers)
}
