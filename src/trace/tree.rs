//! The bounding volume hierarchy. In: a mesh. Out: pairs of boxes to walk and triangles in the tree's order.
//!
//! obvhs builds the tree (preset "slow": spatial splits; a scene is traced often and built once; leaves are collapsed less
//! than it would, 5 % faster for packets). Its nodes are laid out again so that both children of a node lie in one cache
//! line, with boxes padded for rounding.

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::triangle::Triangle;

use super::triangle::EdgeTriangle;
use crate::error::{Error, Result};
use crate::scene::mesh::Mesh;

/// Boxes grow by this share of the largest coordinate: measured to close all leaks at vertices.
const BOX_PAD: f32 = 1e-6;

/// Deepest tree that a walk's stack can hold.
pub const MAX_DEPTH: usize = 192;

/// A child: triangles `first .. first + count` of a leaf, or pair `first` where `count` is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Child {
    pub first: u32,
    pub count: u32,
}

/// The two children of a node: 64 bytes, one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Pair {
    pub low: [[f32; 3]; 2],
    pub high: [[f32; 3]; 2],
    pub child: [Child; 2],
}

/// A scene's tree.
pub struct Tree {
    pub pairs: Vec<Pair>,
    pub root: Child,
    /// In the tree's order.
    pub triangles: Vec<EdgeTriangle>,
    /// Tree order to mesh order.
    pub mesh_triangle: Vec<u32>,
    /// Largest coordinate, metres.
    pub reach: f64,
}

impl Tree {
    pub fn new(mesh: &Mesh) -> Result<Self> {
        let corners_of = |i: usize| mesh.triangle_points(i).map(|p| p.as_vec3().to_array());
        let boxed: Vec<Triangle> = (0..mesh.triangles.len())
            .map(|i| {
                let [v0, v1, v2] = corners_of(i).map(Vec3A::from_array);
                Triangle { v0, v1, v2 }
            })
            .collect();
        let mut build_time = std::time::Duration::default();
        let params = BvhBuildParams { collapse_traversal_cost: 1.0, ..BvhBuildParams::slow_build() };
        let bvh = build_bvh2_from_tris(&boxed, params, &mut build_time);
        if bvh.max_depth > MAX_DEPTH {
            return Err(Error::Limit {
                what: "depth of the bounding volume hierarchy".into(),
                value: bvh.max_depth as u64,
                max: MAX_DEPTH as u64,
            });
        }
        let (low, high) = mesh.bounds();
        let reach = low.abs().max(high.abs()).max_element();
        let triangles = bvh.primitive_indices.iter().map(|&i| EdgeTriangle::new(corners_of(i as usize))).collect();
        let (pairs, root) = paired(&bvh, reach as f32 * BOX_PAD);
        Ok(Tree { pairs, root, triangles, mesh_triangle: bvh.primitive_indices, reach })
    }

    /// Mesh indices of all triangles whose leaf touches the given box, ascending.
    pub fn triangles_near(&self, low: DVec3, high: DVec3) -> Vec<u32> {
        let (low, high) = (low.as_vec3().to_array(), high.as_vec3().to_array());
        let mut found = Vec::new();
        let mut stack = vec![self.root];
        while let Some(child) = stack.pop() {
            if child.count > 0 {
                let range = child.first as usize..(child.first + child.count) as usize;
                found.extend_from_slice(&self.mesh_triangle[range]);
            } else if let Some(pair) = self.pairs.get(child.first as usize) {
                for side in 0..2 {
                    if (0..3).all(|i| pair.low[side][i] <= high[i] && pair.high[side][i] >= low[i]) {
                        stack.push(pair.child[side]);
                    }
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

/// Pairs in depth-first order, and the root: the one child without a box.
fn paired(bvh: &Bvh2, pad: f32) -> (Vec<Pair>, Child) {
    let pad = Vec3A::splat(pad);
    let mut pairs: Vec<Pair> = Vec::with_capacity(bvh.nodes.len() / 2);
    // Nodes still to be placed: index, and where their place is to be noted.
    let mut waiting: Vec<(usize, Option<(usize, usize)>)> = vec![(0, None)];
    let mut root = Child::default();
    while let Some((index, parent)) = waiting.pop() {
        let Some(node) = bvh.nodes.get(index) else { continue };
        let child = if node.prim_count > 0 {
            Child { first: node.first_index, count: node.prim_count }
        } else {
            let left = node.first_index as usize;
            let boxes = [&bvh.nodes[left].aabb, &bvh.nodes[left + 1].aabb];
            pairs.push(Pair {
                low: boxes.map(|b| (b.min - pad).to_array()),
                high: boxes.map(|b| (b.max + pad).to_array()),
                child: [Child::default(); 2],
            });
            let place = pairs.len() - 1;
            waiting.push((left + 1, Some((place, 1))));
            waiting.push((left, Some((place, 0))));
            Child { first: place as u32, count: 0 }
        };
        match parent {
            Some((pair, side)) => pairs[pair].child[side] = child,
            None => root = child,
        }
    }
    (pairs, root)
}
