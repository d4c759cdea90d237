//! Rays: the queries to a scene. In: rays, f32, relative to the scene origin, directions of about
//! unit length. Out: their first hits, or only if they hit anything. Many rays go in packets of
//! sixteen (`packet`); rays one by one are the reference for packets.

use std::sync::atomic::{AtomicU8, Ordering};

use glam::DVec3;

use crate::trace::kernel::lanes::Level;
use crate::trace::kernel::packet;
use crate::trace::kernel::ray::{FAR_PAD, Hit, Ray, inverse};
use crate::trace::kernel::scan::{Scan, ScanSpace};
use crate::trace::kernel::tree::{Child, Node, Tree, WIDTH};
use crate::trace::kernel::triangle::intersect;
use heliotile_core::error::Result;
use heliotile_core::site::cells::FaceTag;
use heliotile_core::site::grid::Grid;
use heliotile_scene::mesh::Mesh;

/// Side of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceSide {
    /// Side from which the corners turn counter-clockwise.
    Front,
    /// Other side.
    Back,
}

/// Cache of which sides of triangles light reaches.
pub struct LitSides {
    /// `[triangle]`: for each side a bit that is set if the answer is known, and one that is set if
    /// the side is lit.
    known: Vec<AtomicU8>,
}

impl LitSides {
    fn new(triangles: usize) -> Self {
        LitSides { known: (0..triangles).map(|_| AtomicU8::new(0)).collect() }
    }

    /// Returns the answer for a side, and calls `find` if it is not known. `find` must depend on
    /// the scene alone, because several threads may call it at the same time.
    pub fn known_or(&self, triangle: u32, side: FaceSide, find: impl FnOnce() -> bool) -> bool {
        let (slot, first) = (&self.known[triangle as usize], if side == FaceSide::Front { 0 } else { 2 });
        // Relaxed is enough: the byte is the whole message, and threads that find the answer twice
        // set the same bits.
        let state = slot.load(Ordering::Relaxed) >> first;
        if state & 1 == 1 {
            return state & 2 == 2;
        }
        let lit = find();
        slot.fetch_or((1 | u8::from(lit) << 1) << first, Ordering::Relaxed);
        lit
    }
}

/// Scene ready for rays.
pub struct Tracer {
    tree: Tree,
    level: Level,
    grid: Grid,
    lit_sides: LitSides,
}

impl Tracer {
    /// Builds the tree. Packets run on the best level of this machine.
    pub fn new(mesh: &Mesh) -> Result<Self> {
        Tracer::at_level(mesh, Level::best())
    }

    /// Builds the tree as [`Tracer::new`] does, with packets compiled for a given level. Results
    /// are the same.
    pub fn at_level(mesh: &Mesh, level: Level) -> Result<Self> {
        let all: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        Ok(Tracer { tree: Tree::new(mesh, &all), level, grid: mesh.grid(), lit_sides: LitSides::new(all.len()) })
    }

    /// Builds the tree of some triangles of the mesh.
    pub fn of_triangles(mesh: &Mesh, triangles: &[u32]) -> Self {
        let lit_sides = LitSides::new(mesh.triangles.len());
        Tracer { tree: Tree::new(mesh, triangles), level: Level::best(), grid: mesh.grid(), lit_sides }
    }

    /// Returns the grid of the scene.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// Returns the cache of lit sides of triangles.
    pub(crate) fn lit_sides(&self) -> &LitSides {
        &self.lit_sides
    }

    /// Returns the distance by which a ray's origin leaves its surface at a place relative to the
    /// scene origin, metres: [`Grid::offset_m`].
    pub fn offset_m(&self, point: DVec3) -> f64 {
        self.grid.offset_m(self.grid.absolute(point))
    }

    /// Returns the mesh indices of all `wanted` triangles whose own box touches the given one,
    /// ascending.
    pub fn triangles_near(&self, low: DVec3, high: DVec3, wanted: impl Fn(FaceTag) -> bool) -> Vec<u32> {
        self.tree.triangles_near(low, high, wanted)
    }

    /// Returns for each ray true if it hits anything. Fast if neighbours in the list are alike,
    /// faster if they share an origin.
    pub fn occluded_many(&self, rays: &[Ray]) -> Vec<bool> {
        packet::occluded(&self.tree, self.level, rays)
    }

    /// Starts a scan of `parts` parts of the sky from a point.
    pub(crate) fn scan<'a>(&'a self, origin: [f32; 3], parts: usize, space: &'a mut ScanSpace) -> Scan<'a> {
        Scan::new(&self.tree, self.level, origin, parts, space)
    }

    /// Returns the first hit of each ray, with the same triangles and bits as [`Tracer::closest`].
    pub fn closest_many(&self, rays: &[Ray]) -> Vec<Option<Hit>> {
        packet::closest(&self.tree, self.level, rays, f32::INFINITY)
    }

    /// Returns for each ray true if it hits anything nearer than `reach_m`.
    pub fn blocked_within(&self, rays: &[Ray], reach_m: f32) -> Vec<bool> {
        packet::closest(&self.tree, self.level, rays, reach_m).iter().map(Option::is_some).collect()
    }

    /// Returns the first hit of a ray. Among equal distances the triangle with the lowest index
    /// counts.
    pub fn closest(&self, ray: Ray) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        self.walk(ray, |limit, first, count| {
            for k in first..first + count {
                let Some(t) = intersect(ray.origin, ray.direction, &self.tree.triangles[k]) else { continue };
                let triangle = self.tree.triangles[k].id;
                if best.is_none_or(|b| (t, triangle) < (b.t, b.triangle)) {
                    best = Some(Hit { t, triangle });
                    *limit = t;
                }
            }
            true
        });
        best
    }

    /// Returns true if the ray hits anything.
    pub fn occluded(&self, ray: Ray) -> bool {
        let mut met = false;
        self.walk(ray, |_, first, count| {
            let triangles = &self.tree.triangles[first..first + count];
            met = triangles.iter().any(|t| intersect(ray.origin, ray.direction, t).is_some());
            !met
        });
        met
    }

    /// Returns the number of triangles that the ray hits.
    pub fn crossings(&self, ray: Ray) -> usize {
        self.crossed(ray).len()
    }

    /// Returns all hits of the ray, nearest first.
    pub fn crossed(&self, ray: Ray) -> Vec<Hit> {
        let mut met: Vec<Hit> = Vec::new();
        self.walk(ray, |_, first, count| {
            let triangles = &self.tree.triangles[first..first + count];
            let hit = |t| intersect(ray.origin, ray.direction, t).map(|distance| Hit { t: distance, triangle: t.id });
            met.extend(triangles.iter().filter_map(hit));
            true
        });
        met.sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
        // A triangle may lie in several leaves.
        met.dedup_by_key(|hit| hit.triangle);
        met
    }

    /// Visits the leaves that a ray enters, nearest first. `leaf(limit, first, count)` may lower
    /// the limit, and ends the walk by returning false.
    fn walk(&self, ray: Ray, mut leaf: impl FnMut(&mut f32, usize, usize) -> bool) {
        let inverse = ray.direction.map(inverse);
        let mut limit = f32::INFINITY;
        let mut stack = vec![(Child::default(), 0.0_f32)];
        while let Some((next, entry)) = stack.pop() {
            // A box at the limit itself is visited, because a hit at an equal distance counts if
            // its triangle has the lower index.
            if entry > limit {
                continue;
            }
            if next.count > 0 {
                if !leaf(&mut limit, next.first as usize, next.count as usize) {
                    return;
                }
                continue;
            }
            let node = &self.tree.nodes[next.first as usize];
            let first = stack.len();
            for k in 0..WIDTH {
                stack.extend(slab(node, k, ray.origin, inverse, limit).map(|entry| (node.child[k], entry)));
            }
            stack[first..].sort_by(|a, b| b.1.total_cmp(&a.1));
        }
    }
}

/// Returns the distance at which a ray enters the box of a child, if it does so before `limit`. The
/// far distance is widened by [`FAR_PAD`].
fn slab(node: &Node, child: usize, origin: [f32; 3], inverse: [f32; 3], limit: f32) -> Option<f32> {
    let mut near = 0.0_f32;
    let mut far = limit;
    for i in 0..3 {
        let (low, high) = (node.planes[i][0][child], -node.planes[i][1][child]);
        // The sides go by the sign of the direction, not by the smaller distance: the inverted box
        // of an absent child must not be hit.
        let (enter, leave) = if inverse[i] < 0.0 { (high, low) } else { (low, high) };
        near = near.max((enter - origin[i]) * inverse[i]);
        far = far.min((leave - origin[i]) * inverse[i] * FAR_PAD);
    }
    (near <= far).then_some(near)
}
