//! Files of footprints and trees. In: their outlines and points, the ground below, and what else
//! stands on it. Out: buildings and crowns in their geometry.

use glam::DVec3;

use crate::footprints::ground_below::GroundBelow;
use crate::footprints::raised::{FootprintFile, raise};
use crate::geometry::Geometry;
use crate::polygon;
use crate::site::Part;
use crate::trees::plant;
use heliotile_core::error::Result;
use heliotile_core::text::{Message, counted, message};
use heliotile_place::reference::Reference;

/// Least height of a roof above the ground: trees below one stand in a house, metres.
const MIN_ROOF_M: f64 = 1.0;

/// A file of footprints or trees, in scene coordinates.
pub(crate) struct Outlined {
    pub part: Part,
    pub geometry: Geometry,
}

impl Outlined {
    pub(crate) fn new(part: Part, mut geometry: Geometry) -> Self {
        geometry.vertices.iter_mut().for_each(|vertex| *vertex = part.place(*vertex));
        for corner in geometry.footprints.iter_mut().flat_map(|footprint| &mut footprint.polygons).flatten().flatten() {
            *corner = part.place(corner.extend(0.0)).truncate();
        }
        for tree in &mut geometry.trees {
            tree.at = part.place(tree.at.extend(0.0)).truncate();
        }
        Outlined { part, geometry }
    }

    /// Returns the EPSG number of its plane system.
    pub(crate) fn epsg(&self) -> Option<u32> {
        match self.part.reference.or(self.geometry.reference) {
            Some(Reference::Epsg(epsg)) => Some(epsg),
            _ => None,
        }
    }

    fn file(&mut self) -> FootprintFile<'_> {
        FootprintFile {
            file: &self.part.file,
            elevation_m: self.part.shift().z,
            footprints: std::mem::take(&mut self.geometry.footprints),
            geometry: &mut self.geometry,
        }
    }
}

/// Adds the buildings and the trees of some files to their geometry; returns notes. `houses` are
/// the triangles of the scene that are neither ground nor leaves.
pub(crate) fn raise_all(
    outlines: &mut [Outlined],
    ground: &GroundBelow,
    houses: Vec<[DVec3; 3]>,
) -> Result<Vec<Message>> {
    let mut files: Vec<FootprintFile> =
        outlines.iter_mut().filter(|of| !of.geometry.footprints.is_empty()).map(Outlined::file).collect();
    let notes = if files.is_empty() { Vec::new() } else { raise(&mut files, ground)? };
    if outlines.iter().any(|of| !of.geometry.trees.is_empty()) {
        plant_all(outlines, ground, houses)?;
    }
    Ok(notes)
}

/// Adds the hulls of trees to the geometry of their files. Trees in houses are left out.
fn plant_all(outlines: &mut [Outlined], ground: &GroundBelow, mut houses: Vec<[DVec3; 3]>) -> Result<()> {
    for Outlined { geometry, .. } in outlines.iter() {
        let corner = |corner: u32| geometry.vertices.get(corner as usize).copied().unwrap_or_default();
        houses.extend(polygon::triangulate(geometry)?.triangles.iter().map(|triangle| triangle.corners.map(corner)));
    }
    let lowest = houses.iter().flatten().map(|corner| corner.z).reduce(f64::min);
    let roofs = GroundBelow::new(Vec::new(), houses);
    for Outlined { part, geometry } in outlines {
        let mut without_ground = 0;
        for tree in std::mem::take(&mut geometry.trees) {
            let known = ground.height(tree.at);
            let ground_m = known.or(lowest).unwrap_or(part.shift().z);
            if roofs.height(tree.at).is_some_and(|roof_m| roof_m > ground_m + MIN_ROOF_M) {
                geometry.leave_out("as trees that stand in a house, or below a roof");
                continue;
            }
            without_ground += u64::from(known.is_none() && !ground.is_empty());
            plant(&part.file, geometry, &tree, ground_m)?;
        }
        if without_ground > 0 {
            geometry.doubts.push(message!(
                "the ground ends before {}: the lowest height of the houses is their ground",
                counted(without_ground, "tree")
            ));
        }
    }
    Ok(())
}
