//! Rays: the bounding volume hierarchy and the walk over it. In: a mesh, then rays. Out: what they meet first, or whether
//! they meet anything.
//!
//! obvhs builds the tree; its public nodes are walked by our own code with boxes padded for rounding and the watertight
//! test of [`super::triangle`]. Rays are f32 in coordinates relative to the scene origin.

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::triangle::Triangle;

use super::triangle::{EdgeTriangle, intersect};
use crate::error::{Error, Result};
use crate::scene::mesh::Mesh;

/// Boxes grow by this share of the largest coordinate: measured to close all leaks at vertices.
const BOX_PAD: f32 = 1e-6;

/// Deepest tree that the walk's stack can hold.
const MAX_DEPTH: usize = 192;

/// What a ray met first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in units of the direction's length.
    pub t: f32,
    /// Index of the triangle in the mesh.
    pub triangle: u32,
}

/// One node, with the boxes of both children beside each other.
#[derive(Clone, Copy)]
struct Node {
    low: [f32; 3],
    /// First child (inner) or first triangle (leaf).
    first: u32,
    high: [f32; 3],
    /// Number of triangles; 0 marks an inner node.
    count: u32,
}

/// A scene ready for rays.
pub struct Tracer {
    nodes: Vec<Node>,
    /// In the tree's order.
    triangles: Vec<EdgeTriangle>,
    /// Tree order to mesh order.
    triangle: Vec<u32>,
    reach: f64,
}

impl Tracer {
    /// Builds the tree of a mesh (obvhs, preset "slow": spatial splits, built once for an archive).
    pub fn new(mesh: &Mesh) -> Result<Self> {
        let corners_of = |i: usize| mesh.triangle_points(i).map(|p| p.as_vec3().to_array());
        let boxed: Vec<Triangle> = (0..mesh.triangles.len())
            .map(|i| {
                let [v0, v1, v2] = corners_of(i).map(Vec3A::from_array);
                Triangle { v0, v1, v2 }
            })
            .collect();
        let mut build_time = std::time::Duration::default();
        let bvh = build_bvh2_from_tris(&boxed, BvhBuildParams::slow_build(), &mut build_time);
        if bvh.max_depth > MAX_DEPTH {
            return Err(Error::Limit {
                what: "depth of the bounding volume hierarchy".into(),
                value: bvh.max_depth as u64,
                max: MAX_DEPTH as u64,
            });
        }
        let (low, high) = mesh.bounds();
        let reach = low.abs().max(high.abs()).max_element();
        let pad = Vec3A::splat(reach as f32 * BOX_PAD);
        let nodes = bvh
            .nodes
            .iter()
            .map(|n| Node {
                low: (n.aabb.min - pad).to_array(),
                first: n.first_index,
                high: (n.aabb.max + pad).to_array(),
                count: n.prim_count,
            })
            .collect();
        let triangles = bvh.primitive_indices.iter().map(|&i| EdgeTriangle::new(corners_of(i as usize))).collect();
        Ok(Tracer { nodes, triangles, triangle: bvh.primitive_indices, reach })
    }

    /// Distance by which a ray's origin leaves its surface, metres: far above the rounding of f32 coordinates at that
    /// place, far below the details of a building.
    pub fn offset_m(&self, point: DVec3) -> f64 {
        (point.abs().max_element() * 2e-6).max(2e-4)
    }

    /// Largest coordinate of the scene, metres.
    pub fn reach_m(&self) -> f64 {
        self.reach
    }

    /// The first triangle met; among equal distances the one with the lowest index.
    pub fn closest(&self, origin: [f32; 3], direction: [f32; 3]) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        self.walk(origin, direction, |limit, first, count| {
            for k in first..first + count {
                let Some(t) = intersect(origin, direction, &self.triangles[k]) else { continue };
                let triangle = self.triangle[k];
                if best.is_none_or(|b| (t, triangle) < (b.t, b.triangle)) {
                    best = Some(Hit { t, triangle });
                    *limit = t;
                }
            }
            true
        });
        best
    }

    /// Whether the ray meets anything.
    pub fn occluded(&self, origin: [f32; 3], direction: [f32; 3]) -> bool {
        let mut met = false;
        self.walk(origin, direction, |_, first, count| {
            met = (first..first + count).any(|k| intersect(origin, direction, &self.triangles[k]).is_some());
            !met
        });
        met
    }

    /// Number of triangles that the ray meets.
    pub fn crossings(&self, origin: [f32; 3], direction: [f32; 3]) -> usize {
        let mut met: Vec<u32> = Vec::new();
        self.walk(origin, direction, |_, first, count| {
            let hit = |k: &usize| intersect(origin, direction, &self.triangles[*k]).is_some();
            met.extend((first..first + count).filter(hit).map(|k| self.triangle[k]));
            true
        });
        met.sort_unstable();
        met.dedup();
        met.len()
    }

    /// Mesh indices of all triangles whose box touches the given one, ascending.
    pub fn triangles_near(&self, low: DVec3, high: DVec3) -> Vec<u32> {
        let (low, high) = (low.as_vec3().to_array(), high.as_vec3().to_array());
        let touches = |n: &Node| (0..3).all(|i| n.low[i] <= high[i] && n.high[i] >= low[i]);
        let mut found = Vec::new();
        let mut stack = vec![0_u32];
        while let Some(index) = stack.pop() {
            let Some(node) = self.nodes.get(index as usize).filter(|n| touches(n)) else { continue };
            if node.count == 0 {
                stack.extend([node.first, node.first + 1]);
            } else {
                let range = node.first as usize..(node.first + node.count) as usize;
                found.extend_from_slice(&self.triangle[range]);
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Visits the leaves that a ray meets, nearest first; `leaf(limit, first, count)` may lower the limit, and ends the
    /// walk by returning false.
    fn walk(&self, origin: [f32; 3], direction: [f32; 3], mut leaf: impl FnMut(&mut f32, usize, usize) -> bool) {
        // A component of exactly zero would give 0 x infinity in the slab test.
        let inverse = direction.map(|d| 1.0 / if d.abs() < 1e-20 { 1e-20_f32.copysign(d) } else { d });
        let mut limit = f32::INFINITY;
        let mut stack = [(0_u32, 0.0_f32); MAX_DEPTH + 2];
        let mut top = 0;
        let mut index = 0_u32;
        if self.nodes.is_empty() {
            return;
        }
        loop {
            let node = self.nodes[index as usize];
            if node.count > 0 {
                if !leaf(&mut limit, node.first as usize, node.count as usize) {
                    return;
                }
            } else {
                let left = slab(&self.nodes[node.first as usize], origin, inverse, limit);
                let right = slab(&self.nodes[node.first as usize + 1], origin, inverse, limit);
                match (left, right) {
                    (Some(l), Some(r)) => {
                        let (near, far, t) =
                            if l <= r { (node.first, node.first + 1, r) } else { (node.first + 1, node.first, l) };
                        stack[top] = (far, t);
                        top += 1;
                        index = near;
                        continue;
                    }
                    (Some(_), None) => {
                        index = node.first;
                        continue;
                    }
                    (None, Some(_)) => {
                        index = node.first + 1;
                        continue;
                    }
                    (None, None) => {}
                }
            }
            loop {
                if top == 0 {
                    return;
                }
                top -= 1;
                let (next, t) = stack[top];
                if t <= limit {
                    index = next;
                    break;
                }
            }
        }
    }
}

/// Entry distance of a ray into a box, if it meets it before `limit`. The far distance is widened by two roundings
/// (Ize 2013, "Robust BVH ray traversal", JCGT 2(2)).
#[inline]
fn slab(node: &Node, origin: [f32; 3], inverse: [f32; 3], limit: f32) -> Option<f32> {
    let mut near = 0.0_f32;
    let mut far = limit;
    for i in 0..3 {
        let a = (node.low[i] - origin[i]) * inverse[i];
        let b = (node.high[i] - origin[i]) * inverse[i];
        near = near.max(a.min(b));
        far = far.min(a.max(b) * 1.000_000_4);
    }
    (near <= far).then_some(near)
}
