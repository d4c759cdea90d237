//! Scene around a map: the triangles in an archive, in greys by the reflectance of their materials.
//! In: its chunks, one at a time. Out: a mesh.

use std::collections::BTreeMap;

use glam::DVec3;
use serde_json::{Value, json};

use super::binary::{ARRAY, Binary, INDICES};
use super::{F32, Scene, U32};
use heliotile_core::archive::format;
use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::tables::GeometryTable;
use heliotile_core::error::Result;
use heliotile_core::opened::OpenSite;

/// Triangles of an archive.
pub struct Surroundings<'a> {
    pub site: OpenSite<'a>,
    /// Number of chunks of triangles.
    pub chunks: u32,
    /// Origin of their vertices, scene coordinates.
    pub origin: DVec3,
}

/// Adds a mesh relative to the origin of the map.
pub fn add(around: &Surroundings, origin: DVec3, binary: &mut Binary, scene: &mut Scene) -> Result<()> {
    let first_material = scene.materials.len();
    for material in around.site.materials() {
        let grey = material.diffuse;
        scene.materials.push(json!({
            "name": material.name, "doubleSided": true,
            "pbrMetallicRoughness": {"baseColorFactor": [grey, grey, grey, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0},
        }));
    }
    let mut primitives: Vec<Value> = Vec::new();
    around.site.expect(&[format::SCENE], 0..around.chunks);
    for chunk in 0..around.chunks {
        let table = GeometryTable::from_block(&around.site.block(format::SCENE, TileNumber(chunk))?)?;
        let view = binary.begin(Some(ARRAY))?;
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for vertex in &table.vertex {
            let corner = DVec3::from_array(vertex.map(f64::from)) + around.origin - origin;
            let corner = corner.as_vec3().to_array();
            low = std::array::from_fn(|i| low[i].min(corner[i]));
            high = std::array::from_fn(|i| high[i].max(corner[i]));
            corner.iter().try_for_each(|metres| binary.put(&metres.to_le_bytes()))?;
        }
        let bounds = json!({"min": low, "max": high});
        let position = scene.accessor(view, "VEC3", F32, table.vertex.len() as u64, bounds);
        let mut by_material: BTreeMap<u16, Vec<[u32; 3]>> = BTreeMap::new();
        for (corners, material) in table.corner.iter().zip(&table.material) {
            by_material.entry(*material).or_default().push(*corners);
        }
        for (material, triangles) in by_material {
            let view = binary.begin(Some(INDICES))?;
            triangles.iter().flatten().try_for_each(|corner| binary.put(&corner.to_le_bytes()))?;
            let indices = scene.accessor(view, "SCALAR", U32, 3 * triangles.len() as u64, json!({}));
            primitives.push(json!({
                "attributes": {"POSITION": position}, "indices": indices, "material": first_material + usize::from(material),
            }));
        }
    }
    if !primitives.is_empty() {
        scene.node("surroundings", primitives);
    }
    Ok(())
}
