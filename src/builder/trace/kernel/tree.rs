//! The bounding volume hierarchy. In: a mesh. Out: pairs of boxes to walk and triangles in the tree's order.
//!
//! obvhs builds the tree (preset "slow": spatial splits; a scene is traced often and built once; leaves are collapsed less
//! than it would, 5 % faster for packets). Three levels of its binary nodes become one node of eight children, with boxes padded for
//! rounding, so that one instruction of sixteen lanes meets a plane of every box on either side.

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::triangle::Triangle;

use prefetch_index::prefetch_index;

use crate::trace::kernel::triangle::EdgeTriangle;
use heliotile_scene::mesh::Mesh;

/// Boxes grow by this share of the largest coordinate: measured to close all leaks at vertices. A triangle that a ray meets is so always
/// reached, and what a ray meets does not depend on how the scene around it is cut into boxes.
const BOX_PAD: f32 = 1e-6;

/// Children of a node.
pub const WIDTH: usize = 8;

/// A child: triangles `first .. first + count` of a leaf, or node `first` where `count` is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Child {
    pub first: u32,
    pub count: u32,
}

/// Up to eight children and their boxes: four cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Node {
    /// `[axis][side][child]`: lower ends (side 0) and upper ends with their sign turned (side 1), so that both sides read alike
    /// from where a ray enters. Boxes of children that are not there are inside out.
    pub planes: [[[f32; WIDTH]; 2]; 3],
    pub child: [Child; WIDTH],
}

/// A scene's tree.
pub struct Tree {
    /// The first one is the root.
    pub nodes: Vec<Node>,
    /// In the tree's order.
    pub triangles: Vec<EdgeTriangle>,
}

impl Tree {
    /// Of some triangles of a mesh, which keep their indices.
    pub fn new(mesh: &Mesh, ids: &[u32]) -> Self {
        let corners_of = |id: u32| mesh.triangle_points(id as usize).map(|p| p.as_vec3().to_array());
        let boxed: Vec<Triangle> = ids
            .iter()
            .map(|&id| {
                let [v0, v1, v2] = corners_of(id).map(Vec3A::from_array);
                Triangle { v0, v1, v2 }
            })
            .collect();
        let mut build_time = std::time::Duration::default();
        let params = BvhBuildParams { collapse_traversal_cost: 1.0, ..BvhBuildParams::slow_build() };
        let bvh = build_bvh2_from_tris(&boxed, params, &mut build_time);
        let (low, high) = mesh.bounds();
        let reach = low.abs().max(high.abs()).max_element();
        let placed = bvh.primitive_indices.iter().map(|&i| ids[i as usize]);
        let triangles = placed.map(|id| EdgeTriangle::new(corners_of(id), id)).collect();
        let nodes = widened(&bvh, reach as f32 * BOX_PAD);
        Tree { nodes, triangles }
    }

    /// Asks for the memory of a child that will be visited.
    #[inline(always)]
    pub fn fetch(&self, child: Child) {
        let first = child.first as usize;
        if child.count > 0 {
            if let Some(triangles) = self.triangles.get(first..first + child.count as usize) {
                prefetch_index(triangles, 0);
                prefetch_index(triangles, triangles.len() - 1);
            }
        } else if let Some(node) = self.nodes.get(first) {
            for axis in &node.planes {
                prefetch_index(axis, 0);
            }
            prefetch_index(node.child.as_slice(), 0);
        }
    }

    /// Mesh indices of all `wanted` triangles whose own box touches the given one, ascending.
    pub fn triangles_near(&self, low: DVec3, high: DVec3, wanted: impl Fn(u32) -> bool) -> Vec<u32> {
        let touches = |t: &EdgeTriangle| {
            let [a, b, c] = t.corners;
            (0..3).all(|i| {
                let (least, most) = (a[i].min(b[i]).min(c[i]), a[i].max(b[i]).max(c[i]));
                f64::from(most) >= low[i] && f64::from(least) <= high[i]
            })
        };
        let near = |t: &&EdgeTriangle| touches(t) && wanted(t.id);
        let (low, high) = (low.as_vec3().to_array(), high.as_vec3().to_array());
        let mut found = Vec::new();
        let mut stack = vec![Child::default()];
        while let Some(next) = stack.pop() {
            if next.count > 0 {
                let range = next.first as usize..(next.first + next.count) as usize;
                found.extend(self.triangles[range].iter().filter(near).map(|t| t.id));
                continue;
            }
            let node = &self.nodes[next.first as usize];
            let mut touches = [true; WIDTH];
            for (i, [lows, highs]) in node.planes.iter().enumerate() {
                for (k, touches) in touches.iter_mut().enumerate() {
                    *touches &= lows[k] <= high[i] && -highs[k] >= low[i];
                }
            }
            stack.extend((0..WIDTH).filter(|&k| touches[k]).map(|k| node.child[k]));
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

/// Nodes in depth-first order: of each binary node the descendants that a ray is likeliest to meet become its children.
fn widened(bvh: &Bvh2, pad: f32) -> Vec<Node> {
    let pad = Vec3A::splat(pad);
    let none = [[f32::INFINITY; WIDTH]; 2];
    let mut nodes = Vec::with_capacity(bvh.nodes.len() / 4 + 1);
    // Binary nodes still to be placed, and where their place is to be noted.
    let mut waiting: Vec<(usize, Option<(usize, usize)>)> = vec![(0, None)];
    while let Some((index, parent)) = waiting.pop() {
        let place = nodes.len();
        if let Some((above, side)) = parent {
            let above: &mut Node = &mut nodes[above];
            above.child[side] = Child { first: place as u32, count: 0 };
        }
        let mut node = Node { planes: [none; 3], child: [Child::default(); WIDTH] };
        let mut found: Vec<usize> = if bvh.nodes.is_empty() { Vec::new() } else { vec![index] };
        while found.len() < WIDTH {
            let inner = (0..found.len()).filter(|&k| bvh.nodes[found[k]].prim_count == 0);
            let area = |k: &usize| bvh.nodes[found[*k]].aabb.half_area();
            let Some(largest) = inner.max_by(|a, b| area(a).total_cmp(&area(b))) else { break };
            let left = bvh.nodes[found[largest]].first_index as usize;
            found[largest] = left;
            found.push(left + 1);
        }
        for (k, &child) in found.iter().enumerate() {
            let b = &bvh.nodes[child];
            let (low, high) = ((b.aabb.min - pad).to_array(), (b.aabb.max + pad).to_array());
            for axis in 0..3 {
                node.planes[axis][0][k] = low[axis];
                node.planes[axis][1][k] = -high[axis];
            }
            if b.prim_count > 0 {
                node.child[k] = Child { first: b.first_index, count: b.prim_count };
            }
        }
        nodes.push(node);
        for (k, &child) in found.iter().enumerate().rev() {
            if bvh.nodes[child].prim_count == 0 {
                waiting.push((child, Some((place, k))));
            }
        }
    }
    nodes
}
