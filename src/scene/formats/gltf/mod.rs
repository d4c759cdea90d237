//! In: a glTF 2.0 file (.gltf with its buffers, or .glb). Out: the triangles of its scene, z up, in
//! metres.
//!
//! The crate `gltf` is not used; serde reads the properties that are needed. The crate keeps
//! positions of nodes as f32 (0.5 m off at the northings of Europe). It panics on numbers out of
//! range unless it validates, and its validation refuses files whose textures need an extension.
//! Source: Khronos, glTF 2.0 Specification, 2021.

mod buffers;
mod instances;
mod json;
mod materials;
#[cfg(test)]
mod tests;

use std::path::Path;

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};

use crate::coordinate::is_position;
use crate::formats::ReadOptions;
use crate::formats::gltf::buffers::{Buffers, Values};
use crate::formats::gltf::instances::placements;
use crate::formats::gltf::json::{Mesh, Node, Primitive, Root, may_hold_geometry, unreadable};
use crate::formats::gltf::materials::Materials;
use crate::geometry::Geometry;
use crate::text::excerpt;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::Message;
use heliotile_files::input::budget::WorkBudget;

/// Most triangles of all instances together, about 10 GB of memory: a small file may place a large
/// mesh any number of times.
const MAX_TRIANGLES: u64 = if cfg!(test) { 100_000 } else { 100_000_000 };

/// Memory that a triangle takes, and that a use of a primitive takes, bytes.
const TRIANGLE_BYTES: u64 = 100;
const PRIMITIVE_BYTES: u64 = 64;

const HINT: &str = "export it again, or check it with a glTF validator";

pub(super) fn parse(bytes: &[u8], file: &Path, asked: &ReadOptions) -> Result<Geometry> {
    let (json, chunk) = buffers::split(bytes, file)?;
    let root = Root::parse(json, file, json.len() == bytes.len())?;
    let ignored = root.check_extensions(file)?;
    let buffers = Buffers::read(&root, chunk, file)?;
    let mut reader = Reader {
        root: &root,
        file,
        buffers: &buffers,
        materials: Materials::new(&root, asked, file),
        geometry: Geometry::default(),
        slots: Vec::new(),
        round: 0,
        triangles: 0,
        budget: WorkBudget::new(bytes.len() as u64 + buffers.length()),
        unmoved: (0, 0),
    };
    reader.geometry.warnings.extend(ignored.into_iter().map(Message::from));
    reader.walk()?;
    reader.finish()
}

struct Reader<'r> {
    root: &'r Root,
    file: &'r Path,
    buffers: &'r Buffers<'r>,
    materials: Materials<'r>,
    geometry: Geometry,
    /// For each vertex of a primitive, the round in which it was last used and its vertex in the
    /// geometry. Primitives may share a list of vertices and use a few of them each.
    slots: Vec<(u32, u32)>,
    round: u32,
    triangles: u64,
    budget: WorkBudget,
    /// Numbers of nodes with skins and of primitives with morph targets, which are read in their
    /// stored pose.
    unmoved: (usize, usize),
}

impl<'r> Reader<'r> {
    fn error(&self, what: String) -> Error {
        Error::input(self.file, None, what, HINT)
    }

    /// Visits the nodes of the scene, each once, children after their parents.
    fn walk(&mut self) -> Result<()> {
        let root = self.root;
        let mut stack: Vec<(usize, DAffine3)> = Vec::new();
        // The last node lies deepest in the stack, so that the first is visited first.
        let all = self.first_nodes()?.into_iter().rev();
        // In glTF x points east, y up and z south.
        let mut upright = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y));
        if let Some(relative) = &root.extensions.relative_to_center {
            upright = DAffine3::from_translation(DVec3::from(relative.center)) * upright;
        }
        stack.extend(all.map(|node| (node, upright)));
        let mut seen = vec![false; root.nodes.len()];
        while let Some((index, parent)) = stack.pop() {
            let (Some(node), Some(seen)) = (root.nodes.get(index), seen.get_mut(index)) else {
                let count = root.nodes.len();
                return Err(self.error(format!("node {index} does not exist, there are {count}")));
            };
            if std::mem::replace(seen, true) {
                return Err(self.error(format!("node {index} has two parents or is one of its own children")));
            }
            let placed = parent * self.place(index, node)?;
            if let Some(number) = node.mesh {
                let mesh = root
                    .meshes
                    .get(number)
                    .ok_or_else(|| self.error(format!("node {index} uses mesh {number}, which does not exist")))?;
                self.unmoved.0 += usize::from(node.skin.is_some());
                self.add_mesh(index, node, mesh, placed)?;
            }
            stack.extend(node.children.iter().rev().map(|child| (*child, placed)));
        }
        Ok(())
    }

    /// Returns the nodes of the default scene, or of the first scene; without scenes, all nodes
    /// that are no children.
    fn first_nodes(&self) -> Result<Vec<usize>> {
        let count = self.root.scenes.len();
        if let Some(scene) = self.root.scenes.get(self.root.scene.unwrap_or(0)) {
            return Ok(scene.nodes.clone());
        }
        if let Some(scene) = self.root.scene {
            return Err(
                self.error(format!("the default scene is number {scene}, but the file has {count}, counted from 0"))
            );
        }
        let mut is_child = vec![false; self.root.nodes.len()];
        for child in self.root.nodes.iter().flat_map(|node| &node.children) {
            if let Some(is_child) = is_child.get_mut(*child) {
                *is_child = true;
            }
        }
        let first: Vec<usize> = (0..).zip(is_child).filter(|(_, is_child)| !is_child).map(|(i, _)| i).collect();
        if first.is_empty() && !self.root.nodes.is_empty() {
            return Err(self.error("every node is a child of another one".into()));
        }
        Ok(first)
    }

    /// Returns the placement of a node in its parent (specification, section 3.5.2).
    fn place(&self, index: usize, node: &Node) -> Result<DAffine3> {
        let refuse = |what: &str| self.error(format!("node {index} {what}"));
        if let Some(matrix) = &node.matrix {
            let matrix = DMat4::from_cols_array(matrix);
            let last = matrix.row(3);
            if !(last - glam::DVec4::W).abs().cmple(glam::DVec4::splat(1e-6)).all() {
                return Err(refuse("has a matrix that is not a placement: its last row is not 0 0 0 1"));
            }
            return Ok(DAffine3::from_mat4(matrix));
        }
        let rotation = match node.rotation.map(DQuat::from_array) {
            None => DQuat::IDENTITY,
            Some(rotation) if (0.5..2.0).contains(&rotation.length()) => rotation.normalize(),
            Some(_) => return Err(refuse("has a rotation that is not a unit quaternion")),
        };
        let scale = node.scale.map_or(DVec3::ONE, DVec3::from);
        let translation = node.translation.map_or(DVec3::ZERO, DVec3::from);
        Ok(DAffine3::from_scale_rotation_translation(scale, rotation, translation))
    }

    /// Adds the mesh of a node, once or at each of its instances.
    fn add_mesh(&mut self, index: usize, node: &Node, mesh: &Mesh, placed: DAffine3) -> Result<()> {
        let named = |name: &Option<String>| name.clone().filter(|name| !name.is_empty());
        let name = named(&node.name).or_else(|| named(&mesh.name)).unwrap_or_else(|| format!("node_{index}"));
        let instances = match &node.extensions.instancing {
            Some(instancing) => Some(placements(&instancing.attributes, self.buffers, self.file, index)?),
            None => None,
        };
        let uses = mesh.primitives.len() as u64 * instances.as_ref().map_or(1, Vec::len) as u64;
        self.budget.spend(uses, PRIMITIVE_BYTES, "instances of meshes", self.file)?;
        for primitive in &mesh.primitives {
            if !(4..=6).contains(&primitive.mode.unwrap_or(4)) {
                self.geometry.leave_out("because they are points or lines");
            } else {
                self.unmoved.1 += usize::from(!primitive.targets.is_empty());
            }
        }
        let Some(instances) = instances else { return self.add_primitives(&name, mesh, placed) };
        let single = instances.len() == 1;
        for (i, instance) in (1..).zip(instances) {
            let name = if single { name.clone() } else { format!("{name}_{i}") };
            self.add_primitives(&name, mesh, placed * instance)?;
        }
        Ok(())
    }

    fn add_primitives(&mut self, name: &str, mesh: &Mesh, placed: DAffine3) -> Result<()> {
        let surfaces = mesh.primitives.iter().filter(|primitive| (4..=6).contains(&primitive.mode.unwrap_or(4)));
        surfaces.into_iter().try_for_each(|primitive| self.add_primitive(name, primitive, placed))
    }

    /// Returns the error for a primitive that cannot be read, which names the extension that holds
    /// its geometry, if there is one.
    fn unread(&self, name: &str, primitive: &Primitive, error: Error) -> Error {
        match primitive.extensions.keys().find(|name| may_hold_geometry(name)) {
            Some(extension) => {
                let [name, shown] = [name, extension].map(|text| excerpt(text.as_bytes()));
                unreadable(
                    self.file,
                    &format!("triangles of `{name}` that only the extension {shown} holds"),
                    extension,
                )
            }
            None => error,
        }
    }

    fn add_primitive(&mut self, name: &str, primitive: &Primitive, placed: DAffine3) -> Result<()> {
        let Some(positions) = primitive.attributes.position else {
            if primitive.extensions.keys().any(|name| may_hold_geometry(name)) {
                return Err(self.unread(name, primitive, self.error(String::new())));
            }
            self.geometry.leave_out("because they have no attribute POSITION");
            return Ok(());
        };
        let buffers = self.buffers;
        let positions = buffers.values(positions).map_err(|error| self.unread(name, primitive, error))?;
        let indices = primitive.indices.map(|indices| buffers.values(indices)).transpose();
        let indices = indices.map_err(|error| self.unread(name, primitive, error))?;
        if !positions.is_positions() || indices.as_ref().is_some_and(|indices| !indices.is_indices()) {
            let what = format!(
                "`{}` has positions or indices of a type that glTF 2.0 does not allow",
                excerpt(name.as_bytes())
            );
            return Err(self.error(what));
        }
        let count = indices.as_ref().map_or(positions.count, |indices| indices.count);
        let strip = primitive.mode == Some(5);
        let triangles = match primitive.mode {
            Some(5 | 6) => count.saturating_sub(2),
            _ => count / 3,
        };
        self.triangles += triangles as u64;
        if self.triangles > MAX_TRIANGLES {
            return Err(Error::Limit {
                what: format!("the number of triangles of all instances in {}", self.file.display()).into(),
                value: self.triangles,
                max: MAX_TRIANGLES,
            });
        }
        self.budget.spend(triangles as u64, TRIANGLE_BYTES, "instances of meshes", self.file)?;
        self.round += 1;
        let longest = self.slots.len().max(positions.count);
        self.slots.resize(longest, (0, 0));
        let material = self.materials.id(primitive.material, &mut self.geometry)?;
        let object = self.geometry.objects.id(name);
        // A mirrored placement reverses every outline (specification, section 3.7.4).
        let mirrored = placed.matrix3.determinant() < 0.0;
        for i in 0..triangles {
            let mut corners = match primitive.mode {
                Some(5) => [i, i + 1 + i % 2, i + 2 - i % 2],
                Some(6) => [i + 1, i + 2, 0],
                _ => [3 * i, 3 * i + 1, 3 * i + 2],
            };
            if mirrored {
                corners.swap(1, 2);
            }
            let mut triangle = [0; 3];
            for (to, corner) in triangle.iter_mut().zip(corners) {
                *to = match &indices {
                    Some(indices) => indices.index(corner).unwrap_or(u32::MAX),
                    None => corner as u32,
                };
            }
            let [a, b, c] = triangle;
            if strip && (a == b || b == c || c == a) {
                // Strips are joined by degenerate triangles, which are no surface.
                continue;
            }
            for corner in triangle {
                let corner = self.vertex(name, &positions, corner, placed)?;
                self.geometry.push_corner(corner);
            }
            self.geometry.end_face(material, object, 0);
        }
        Ok(())
    }

    /// Returns the geometry's vertex for a vertex of a primitive.
    #[inline]
    fn vertex(&mut self, name: &str, positions: &Values, index: u32, placed: DAffine3) -> Result<u32> {
        let slot = self.slots.get_mut(index as usize);
        let found = slot.zip(positions.vector(index as usize).filter(|_| (index as usize) < positions.count));
        let Some((slot, position)) = found else {
            let (shown, count) = (excerpt(name.as_bytes()), positions.count);
            return Err(self.error(format!(
                "`{shown}` has a triangle of vertex {index}, but vertices are numbered 0 to {}",
                count as i64 - 1
            )));
        };
        // Triangles of a primitive share the vertex.
        if slot.0 == self.round {
            return Ok(slot.1);
        }
        let at = placed.transform_point3(position);
        if !is_position(at) {
            let shown = excerpt(name.as_bytes());
            return Err(self.error(format!("vertex {index} of `{shown}` lies at {at}, beyond all positions on Earth")));
        }
        let vertex = self.geometry.push_vertex(self.file, at)?;
        *slot = (self.round, vertex);
        Ok(vertex)
    }

    fn finish(mut self) -> Result<Geometry> {
        if self.geometry.face_count() == 0 {
            let points = self.geometry.left_out.values().sum::<usize>();
            let what = format!(
                "its scene holds no triangles ({} nodes, {points} meshes of other kinds)",
                self.root.nodes.len()
            );
            return Err(Error::input(self.file, None, what, "export surfaces as parts of the default scene"));
        }
        self.materials.warn(&mut self.geometry);
        for (count, what) in [(self.unmoved.0, "nodes have skins"), (self.unmoved.1, "meshes have morph targets")] {
            if count > 0 {
                let text =
                    format!("{}: {count} {what}, which are ignored: the stored pose is used", self.file.display());
                self.geometry.warnings.push(text.into());
            }
        }
        Ok(self.geometry)
    }
}
