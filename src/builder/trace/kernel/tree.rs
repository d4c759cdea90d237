//! Bounding volume hierarchy. In: a mesh. Out: nodes of boxes to traverse, and triangles in the
//! tree's order.
//!
//! obvhs builds the tree (preset "slow", with spatial splits, because a scene is built once and
//! traced often; leaves are collapsed less than the preset does, 5 % faster for packets). Three
//! levels of its binary nodes become one node of eight children, with boxes padded for rounding, so
//! that one instruction of sixteen lanes tests a plane of every box on either side.
//!
//! The time to improve a tree grows faster than the tree, so a large scene is cut into blocks with
//! trees of their own, below a small tree of blocks.

use std::time::Duration;

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::{build_bvh2, build_bvh2_from_tris};
use obvhs::triangle::Triangle;
use rayon::prelude::*;

use prefetch_index::prefetch_index;

use crate::trace::kernel::triangle::EdgeTriangle;
use heliotile_core::site::cells::FaceTag;
use heliotile_scene::mesh::Mesh;

/// Padding of boxes, as a share of the largest coordinate: measured to close all leaks at vertices.
/// So every triangle that a ray hits is reached, and hits do not depend on how the scene is cut
/// into boxes.
const BOX_PAD: f32 = 1e-6;

/// Largest number of triangles of a block. The time of a tree grows faster than its triangles: 3
/// million of a city took 33 s as one tree and 11 s in blocks.
const BLOCK: usize = 1 << 16;

/// Number of children of a node. Their entering and leaving sides together fill the lanes of a
/// packet.
pub const WIDTH: usize = 8;

/// Child of a node: triangles `first .. first + count` of a leaf, or node `first` if `count` is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Child {
    pub first: u32,
    pub count: u32,
}

/// Node of up to eight children and their boxes: four cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Node {
    /// `[axis][side][child]`: lower ends (side 0) and upper ends with their sign reversed (side 1),
    /// so that the sides at which rays enter and leave are treated alike. Boxes of absent children
    /// are inverted.
    pub planes: [[[f32; WIDTH]; 2]; 3],
    pub child: [Child; WIDTH],
}

/// Tree of a scene.
pub struct Tree {
    /// Nodes; the first one is the root.
    pub nodes: Vec<Node>,
    /// Triangles in the tree's order.
    pub triangles: Vec<EdgeTriangle>,
    /// Tags of these triangles, by which cells select them.
    tags: Vec<FaceTag>,
}

impl Tree {
    /// Builds the tree of some triangles of a mesh, which keep their indices.
    pub fn new(mesh: &Mesh, ids: &[u32]) -> Self {
        let (low, high) = mesh.bounds();
        let pad = low.abs().max(high.abs()).max_element() as f32 * BOX_PAD;
        let blocks: Vec<(Tree, Aabb)> =
            blocks(mesh, ids).into_par_iter().map(|ids| Tree::of_block(mesh, &ids, pad)).collect();
        let mut tree = Tree { nodes: Vec::new(), triangles: Vec::new(), tags: Vec::new() };
        let mut order = Vec::new();
        if blocks.len() > 1 {
            let boxes: Vec<Aabb> = blocks.iter().map(|(_, bounds)| *bounds).collect();
            let bvh = build_bvh2(&boxes, BvhBuildParams::fastest_build(), &mut Duration::default());
            (tree.nodes, order) = (widened(&bvh, pad), bvh.primitive_indices);
        }
        let above = tree.nodes.len();
        tree.nodes.reserve_exact(blocks.iter().map(|(block, _)| block.nodes.len()).sum());
        tree.triangles.reserve_exact(blocks.iter().map(|(block, _)| block.triangles.len()).sum());
        tree.tags.reserve_exact(tree.triangles.capacity());
        let mut roots = Vec::with_capacity(blocks.len());
        for (block, _) in blocks {
            let (node, triangle) = (tree.nodes.len() as u32, tree.triangles.len() as u32);
            roots.push(node);
            tree.triangles.extend(block.triangles);
            tree.tags.extend(block.tags);
            tree.nodes.extend(block.nodes.into_iter().map(|mut moved| {
                for child in &mut moved.child {
                    child.first += if child.count > 0 { triangle } else { node };
                }
                moved
            }));
        }
        // Leaves of the upper tree hold one block each.
        for child in tree.nodes.iter_mut().take(above).flat_map(|node| &mut node.child).filter(|child| child.count > 0)
        {
            *child = Child { first: roots[order[child.first as usize] as usize], count: 0 };
        }
        tree
    }

    /// Builds the tree of one block's triangles, and returns the box around them.
    fn of_block(mesh: &Mesh, ids: &[u32], pad: f32) -> (Self, Aabb) {
        let corners_of = |id: u32| mesh.triangle_points(id as usize).map(|p| p.as_vec3().to_array());
        let boxed = ids.iter().map(|&id| {
            let [v0, v1, v2] = corners_of(id).map(Vec3A::from_array);
            Triangle { v0, v1, v2 }
        });
        let params = BvhBuildParams { collapse_traversal_cost: 1.0, ..BvhBuildParams::slow_build() };
        let bvh = build_bvh2_from_tris(&boxed.collect::<Vec<_>>(), params, &mut Duration::default());
        let placed = bvh.primitive_indices.iter().map(|&i| ids[i as usize]);
        let triangles: Vec<EdgeTriangle> = placed.map(|id| EdgeTriangle::new(corners_of(id), id)).collect();
        let tag = |t: &EdgeTriangle| FaceTag::new(mesh.normal(t.id as usize), mesh.triangle_material[t.id as usize]);
        let tags = triangles.iter().map(tag).collect();
        let bounds = bvh.nodes.first().map_or(Aabb::INVALID, |root| root.aabb);
        (Tree { nodes: widened(&bvh, pad), triangles, tags }, bounds)
    }

    /// Prefetches the memory of a child that will be visited.
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

    /// Returns the mesh indices of all `wanted` triangles whose own box touches the given one,
    /// ascending. Tags are tested first, because a coarse cell has most of a large scene in its
    /// box.
    pub fn triangles_near(&self, low: DVec3, high: DVec3, wanted: impl Fn(FaceTag) -> bool) -> Vec<u32> {
        let touches = |t: &EdgeTriangle| {
            let [a, b, c] = t.corners;
            (0..3).all(|i| {
                let (least, most) = (a[i].min(b[i]).min(c[i]), a[i].max(b[i]).max(c[i]));
                f64::from(most) >= low[i] && f64::from(least) <= high[i]
            })
        };
        let (low, high) = (low.as_vec3().to_array(), high.as_vec3().to_array());
        let mut found = Vec::new();
        let mut stack = vec![Child::default()];
        while let Some(next) = stack.pop() {
            if next.count > 0 {
                let range = next.first as usize..(next.first + next.count) as usize;
                let wanted = range.filter(|&k| wanted(self.tags[k])).map(|k| &self.triangles[k]);
                found.extend(wanted.filter(|t| touches(t)).map(|t| t.id));
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

/// Cuts triangles at the median along the longest axis of their centres until the parts are small.
/// Each part is in ascending order.
fn blocks(mesh: &Mesh, ids: &[u32]) -> Vec<Vec<u32>> {
    let centre = |id: u32| mesh.triangle_points(id as usize).into_iter().sum::<DVec3>();
    let mut done = Vec::new();
    let mut waiting = vec![ids.to_vec()];
    while let Some(mut part) = waiting.pop() {
        if part.len() <= BLOCK {
            part.sort_unstable();
            done.push(part);
            continue;
        }
        let ends = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = part.iter().map(|id| centre(*id)).fold(ends, |(low, high), c| (low.min(c), high.max(c)));
        let axis = (high - low).max_position();
        // Keys are made once, because there are many more comparisons than triangles.
        let mut keys: Vec<(f64, u32)> = part.iter().map(|id| (centre(*id)[axis], *id)).collect();
        let middle = keys.len() / 2;
        keys.select_nth_unstable_by(middle, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (low, high) = keys.split_at(middle);
        waiting.extend([low, high].map(|half| half.iter().map(|key| key.1).collect()));
    }
    done
}

/// Returns nodes of eight children in depth-first order. The descendants of a binary node that a
/// ray is likeliest to hit become its children.
fn widened(bvh: &Bvh2, pad: f32) -> Vec<Node> {
    let pad = Vec3A::splat(pad);
    let none = [[f32::INFINITY; WIDTH]; 2];
    let mut nodes = Vec::with_capacity(bvh.nodes.len() / 4 + 1);
    // Binary nodes still to be placed, and the parent slot that refers to each.
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
