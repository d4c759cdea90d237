//! The scene crate: turns input files into checked geometry, materials and receivers.
//!
//! # Map
//!
//! Folder `formats` has one folder or file per format (CityJSON, CityGML, features, GeoTIFF, glTF,
//! OBJ, PLY, STL, EnergyPlus, Honeybee); `formats` and `terrain` give polygons, and `surface_city`
//! makes polygons of a city's rasters. `load` merges the polygons and [`mesh`] brings them to one
//! canonical form. [`materials`] gives every surface its optics, and [`covering`] puts receivers on
//! surfaces. [`pv`] describes where solar modules are to stand.
//!
//! # What never happens
//!
//! - Readers never give a coordinate that is not finite, a direction that is not of length 1 or a
//!   value out of its range.
//! - This crate casts no ray, knows nothing of archives and prints nothing: what was odd stands in
//!   [`LoadReport`].
//! - Equal scenes never give different meshes, whatever the order of faces, vertices and files.
//!
//! # Eleven words
//!
//! - **site**: scene files with their materials, places and scales, as `site.toml` or a command
//!   line lists them.
//! - **scene**: one mesh with a material for every triangle.
//! - **soup**: polygons as they were read, with the objects that they belong to, before they become
//!   a mesh.
//! - **object**: a building, a tree, an `o` of OBJ; **surface**: neighbouring faces of an object in
//!   one plane.
//! - **palette**: the materials of several files, told apart where one name means two things.
//! - **class**: ground or obstruction; **group**: materials that follow one schedule at replay.
//! - **focus**: the point near which positions keep their millimetres when far terrain makes the
//!   scene wide.
//! - **thinning**: leaving out samples of terrain that change no horizon by more than a limit.
//! - **region part**: a rectangle of a region that is built by itself; its **halo** is the distance
//!   up to which neighbours around it count.
//! - **buried**: inside a neighbour or below the terrain.
//! - **endless ground**: a horizontal plane that reaches far beyond the scene. Where files have no
//!   ground, such a plane is assumed if the site asks for it.

#![deny(missing_docs)]
#![cfg_attr(not(test), warn(clippy::expect_used, clippy::indexing_slicing, clippy::panic, clippy::unreachable))]

mod attributes;
pub mod change;
mod coordinate;
pub mod covering;
pub mod edit;
mod facing;
mod footprint;
pub mod footprint_options;
mod footprints;
mod formats;
mod geocentric;
mod geometry;
mod ground;
mod large_polygon;
pub mod load;
pub mod materials;
pub mod mesh;
pub mod mesh_objects;
pub mod mirrors;
mod model_version;
pub mod objects;
mod outlined;
#[cfg(test)]
mod packed_tests;
mod palette;
pub mod placing;
mod plan;
pub mod points;
mod polygon;
pub mod pv;
pub mod region_part;
pub mod request;
pub mod site;
mod surface_city;
mod surface_rasters;
pub mod survey;
mod terrain;
#[cfg(test)]
mod test_files;
#[cfg(test)]
mod tests;
mod text;
mod tree_point;
mod trees;

use std::path::Path;

use glam::DVec3;

pub use formats::energyplus::ground::GROUND_MONTHS;
pub use formats::energyplus::idf::{IdfField, idf_fields};
pub use formats::format_of_name;
pub use ground::model::USUAL as USUAL_GROUND;
pub use model_version::ModelVersion;
pub use surface_rasters::SurfaceRasters;
pub use text::read_toml;

use coordinate::MAX_COORDINATE_M;
use heliotile_core::error::{Error, Result};
use heliotile_core::observer::Observer;
use heliotile_core::site::content::ContentHasher;
use heliotile_core::site::ground::MonthlyGround;
use heliotile_core::site::material::Material;
use heliotile_core::site::north::North;
use heliotile_core::site::place::Place;
use heliotile_core::site::scene_object::SceneObject;
use heliotile_core::text::Message;
use materials::MaterialUse;
use mesh::{Canonical, Mesh, RawTriangle, canonical};
use mesh_objects::{MeshObjects, ranked};

/// Geometry in canonical form, with a checked material for every index of `mesh.triangle_material`.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Triangles of the scene.
    pub mesh: Mesh,
    /// Materials in use, sorted by name.
    pub materials: Vec<Material>,
    /// Objects that the triangles are parts of; not hashed by [`Scene::content_hash`].
    pub objects: MeshObjects,
    /// Place on Earth, if a file states it; not hashed by [`Scene::content_hash`].
    pub place: Option<Place>,
    /// True if azimuths in tables of points count from the y axis, in place of true north; not
    /// hashed by [`Scene::content_hash`].
    pub grid_north: bool,
    /// Monthly ground reflectances, if an EnergyPlus model states them; the ground's material has
    /// their mean. Not hashed by [`Scene::content_hash`].
    pub ground: Option<MonthlyGround>,
    /// Counts, warnings and notes of loading.
    pub report: LoadReport,
}

/// Counts, warnings and notes of loading a scene; not part of the scene's content.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LoadReport {
    /// Number of faces in the files, before they are cut into triangles.
    pub faces_read: usize,
    /// Number of triangles kept.
    pub triangles: usize,
    /// Number of faces with fewer than three distinct corners and of triangles without area.
    pub degenerate_dropped: usize,
    /// Number of triangles that repeated another one of the same material.
    pub duplicates_dropped: usize,
    /// Number of faces with a concave corner or a hole.
    pub concave_faces: usize,
    /// Triangle count of each material, in the order of `Scene::materials`.
    pub materials: Vec<MaterialUse>,
    /// Names of materials that no file describes, so that their optics are assumed.
    pub assumed: Vec<String>,
    /// Warnings for the user, one sentence each.
    pub warnings: Vec<Message>,
    /// Decisions that the user did not ask for, such as how terrain was thinned; one sentence each.
    pub notes: Vec<Message>,
}

impl LoadReport {
    /// Passes the warnings and the notes to an observer.
    pub fn tell(&self, observer: &dyn Observer) {
        self.warnings.iter().for_each(|warning| observer.warn(warning));
        self.notes.iter().for_each(|note| observer.note(note));
    }
}

impl Scene {
    /// Returns the north that azimuths in tables of points count from.
    pub fn table_north(&self) -> North {
        if self.grid_north { North::default() } else { North::new(self.place.as_ref()) }
    }

    /// Builds a scene from triangles in input coordinates, each with its index into `materials`, as
    /// if they were read from a file.
    pub fn from_triangles(triangles: &[([DVec3; 3], u16)], materials: Vec<Material>) -> Result<Scene> {
        Scene::from_objects(triangles, materials, &MeshObjects::default(), None)
    }

    /// Builds a scene from triangles in input coordinates with their objects: one object for each
    /// triangle, or none at all. `focus` is a point near which positions keep their millimetres;
    /// `None` takes the middle of the scene.
    pub fn from_objects(
        triangles: &[([DVec3; 3], u16)],
        materials: Vec<Material>,
        objects: &MeshObjects,
        focus: Option<DVec3>,
    ) -> Result<Scene> {
        let refuse =
            |what: String, hint: &'static str| Err(Error::input(Path::new("triangles in memory"), None, what, hint));
        let names: Vec<String> = materials.iter().map(|material| material.name.clone()).collect();
        for material in &materials {
            if let Err(what) = material.check() {
                return refuse(format!("material `{}`: {what}", material.name), "give shares of the light from 0 to 1");
            }
        }
        if 3 * triangles.len() as u64 > u64::from(u32::MAX) {
            return Err(Error::Limit {
                what: "the number of corners of triangles in memory".into(),
                value: 3 * triangles.len() as u64,
                max: u64::from(u32::MAX),
            });
        }
        let mut positions = Vec::with_capacity(3 * triangles.len());
        let mut raw = Vec::with_capacity(triangles.len());
        let (ranks, known_objects) = ranked(&objects.list);
        if !objects.list.is_empty() && objects.of_triangle.len() != triangles.len() {
            let what =
                format!("{} triangles come with {} numbers of objects", triangles.len(), objects.of_triangle.len());
            return refuse(what, "give one object number for each triangle, or none at all");
        }
        for (i, &(corners, material)) in triangles.iter().enumerate() {
            let object = objects.of_triangle.get(i).and_then(|object| ranks.get(*object as usize)).copied();
            if usize::from(material) >= materials.len() {
                let what = format!(
                    "triangle {i} has material number {material}, but the number of materials is {}",
                    materials.len()
                );
                return refuse(what, "add the material");
            }
            if let Some(bad) = corners.iter().find(|p| !p.is_finite() || p.abs().max_element() > MAX_COORDINATE_M) {
                return refuse(format!("triangle {i} has a corner at {bad}"), "give metres, at most 1e9 in size");
            }
            let first = positions.len() as u32;
            positions.extend(corners);
            raw.push(RawTriangle {
                corners: [first, first + 1, first + 2],
                material: u32::from(material),
                object: object.unwrap_or_default(),
            });
        }
        let sorted = rank_by_name(&names, &mut raw);
        if let Some([name, _]) = sorted.array_windows().find(|[a, b]| a == b) {
            return refuse(format!("two materials are called `{name}`"), "give every material a name of its own");
        }
        let Canonical { mesh, used, objects, dropped } = canonical(&positions, raw, focus)?;
        if mesh.triangles.is_empty() {
            return refuse(
                format!("none of the {} triangles has an area", triangles.len()),
                "give positions in metres",
            );
        }
        let mut table: materials::select::MaterialTable =
            materials.into_iter().map(|material| (material.name.clone(), material)).collect();
        let uses = count_uses(&mesh, &used, &sorted);
        let materials = uses.iter().filter_map(|entry| table.remove(&entry.name)).collect();
        let report = LoadReport {
            faces_read: triangles.len(),
            triangles: mesh.triangles.len(),
            degenerate_dropped: dropped.degenerate,
            duplicates_dropped: dropped.duplicates,
            concave_faces: 0,
            materials: uses,
            assumed: Vec::new(),
            warnings: contested_warning(dropped.contested).into_iter().map(Message::from).collect(),
            notes: Vec::new(),
        };
        let objects = if known_objects.is_empty() {
            MeshObjects::default()
        } else {
            MeshObjects::of_sorted(&known_objects, objects)
        };
        Ok(Scene { mesh, materials, objects, place: None, grid_north: false, ground: None, report })
    }

    /// Returns the BLAKE3 hash of [`Scene::content_hash`] and the objects. Two scenes that an
    /// archive holds alike have equal hashes.
    pub fn named_hash(&self) -> [u8; 32] {
        let mut content = ContentHasher::new("heliotile scene with objects 2");
        content.raw(&self.content_hash());
        content.length(self.objects.list.len());
        for SceneObject { name, note } in &self.objects.list {
            [name, &note.object, &note.building, &note.object_type, &note.attributes]
                .into_iter()
                .for_each(|text| content.bytes(text.as_bytes()));
            content.raw(&[u8::from(note.beside)]);
        }
        content.length(self.objects.of_triangle.len());
        for object in &self.objects.of_triangle {
            content.raw(&object.to_le_bytes());
        }
        content.finish()
    }

    /// Returns the BLAKE3 hash of geometry and materials in canonical little-endian form, each list
    /// after its length. Equal scenes have equal hashes, whatever the order of faces, vertices and
    /// materials in their files.
    pub fn content_hash(&self) -> [u8; 32] {
        let mut content = ContentHasher::new("heliotile scene 2");
        content.point(&self.mesh.origin);
        content.number(self.mesh.step_m);
        content.length(self.mesh.vertices.len());
        self.mesh.vertices.iter().for_each(|vertex| content.point(vertex));
        content.length(self.mesh.triangles.len());
        for corner in self.mesh.triangles.iter().flatten() {
            content.raw(&corner.to_le_bytes());
        }
        content.length(self.mesh.triangle_material.len());
        for material in &self.mesh.triangle_material {
            content.raw(&material.to_le_bytes());
        }
        content.length(self.materials.len());
        for material in &self.materials {
            content.bytes(material.name.as_bytes());
            content.number(material.diffuse);
            content.number(material.specular);
            content.raw(&[material.class.code()]);
            // Groups are never empty, so that an empty name means no group.
            content.bytes(material.group.as_deref().unwrap_or_default().as_bytes());
            if let Some(glass) = material.glass {
                content.bytes(b"glass");
                content.raw(&[glass.panes()]);
            }
            if let Some(transmittance) = material.transmittance {
                let name = if material.volume { "leaf_area_density" } else { "transmittance" };
                content.bytes(name.as_bytes());
                content.number(transmittance);
            }
            for (property, band, value) in material.bands.all() {
                content.bytes(property.name().as_bytes());
                content.bytes(band.name().as_bytes());
                content.number(value);
            }
            if let Some(emissivity) = material.bands.emissivity {
                content.bytes(b"emissivity");
                content.number(emissivity);
            }
        }
        content.finish()
    }
}

/// Renumbers the materials of triangles from rows of `names` to ranks in the sorted names, and
/// returns the sorted names.
#[allow(clippy::indexing_slicing)] // every material number of a triangle is a row of `names`
fn rank_by_name(names: &[String], triangles: &mut [RawTriangle]) -> Vec<String> {
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by_key(|&row| &names[row]);
    let mut rank_of = vec![0_u32; names.len()];
    for (rank, &row) in (0_u32..).zip(&order) {
        rank_of[row] = rank;
    }
    for triangle in triangles {
        triangle.material = rank_of[triangle.material as usize];
    }
    order.into_iter().map(|row| names[row].clone()).collect()
}

/// Counts the triangles of each material of a mesh; `used` holds ranks in the sorted `names`.
#[allow(clippy::indexing_slicing)] // both come from the triangles of the mesh
fn count_uses(mesh: &Mesh, used: &[u32], names: &[String]) -> Vec<MaterialUse> {
    let mut uses: Vec<MaterialUse> =
        used.iter().map(|&rank| MaterialUse { name: names[rank as usize].clone(), triangles: 0 }).collect();
    for &material in &mesh.triangle_material {
        uses[usize::from(material)].triangles += 1;
    }
    uses
}

fn contested_warning(count: usize) -> Option<String> {
    (count > 0).then(|| {
        format!(
            "{count} triangles coincide with a triangle of another material; it is undefined which of the two is hit"
        )
    })
}
