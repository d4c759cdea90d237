//! Rays: what a scene answers. In: rays, f32, relative to the scene origin, directions of about unit length. Out: what they
//! meet first, or whether they meet anything. Many rays go in packets of sixteen ([`super::packet`]); rays one by one
//! are the reference that packets are judged against.

use glam::DVec3;

use super::lanes::Level;
use super::packet::{self, Packet};
use super::tree::{Child, MAX_DEPTH, Pair, Tree};
use super::triangle::intersect;
use crate::error::Result;
use crate::scene::mesh::Mesh;

/// A ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    pub origin: [f32; 3],
    pub direction: [f32; 3],
}

/// What a ray met first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in units of the direction's length.
    pub t: f32,
    /// Index of the triangle in the mesh.
    pub triangle: u32,
}

/// A scene ready for rays.
pub struct Tracer {
    tree: Tree,
    level: Level,
}

impl Tracer {
    /// Builds the tree; packets run on the best level of this machine.
    pub fn new(mesh: &Mesh) -> Result<Self> {
        Tracer::at_level(mesh, Level::best())
    }

    /// As [`Tracer::new`], with packets compiled for a given level; results are the same.
    pub fn at_level(mesh: &Mesh, level: Level) -> Result<Self> {
        Ok(Tracer { tree: Tree::new(mesh)?, level })
    }

    /// Distance by which a ray's origin leaves its surface, metres: far above the rounding of f32 coordinates at that
    /// place, far below the details of a building.
    pub fn offset_m(&self, point: DVec3) -> f64 {
        (point.abs().max_element() * 2e-6).max(2e-4)
    }

    /// Largest coordinate of the scene, metres.
    pub fn reach_m(&self) -> f64 {
        self.tree.reach
    }

    /// Mesh indices of all triangles whose leaf touches the given box, ascending.
    pub fn triangles_near(&self, low: DVec3, high: DVec3) -> Vec<u32> {
        self.tree.triangles_near(low, high)
    }

    /// Whether each ray meets anything. Fast where sixteen rays in a row are alike, faster where they share an origin.
    pub fn occluded_many(&self, rays: &[Ray]) -> Vec<bool> {
        let packets: Vec<Packet> = rays.chunks(16).map(Packet::new).collect();
        let met = packet::occluded(&self.tree, self.level, &packets);
        (0..rays.len()).map(|i| met[i / 16] >> (i % 16) & 1 == 1).collect()
    }

    /// What each ray meets first; the same triangles and bits as [`Tracer::closest`].
    pub fn closest_many(&self, rays: &[Ray]) -> Vec<Option<Hit>> {
        let packets: Vec<Packet> = rays.chunks(16).map(Packet::new).collect();
        let mut hits: Vec<Option<Hit>> = packet::closest(&self.tree, self.level, &packets);
        hits.truncate(rays.len());
        hits
    }

    /// The first triangle met; among equal distances the one with the lowest index.
    pub fn closest(&self, ray: Ray) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        self.walk(ray, |limit, first, count| {
            for k in first..first + count {
                let Some(t) = intersect(ray.origin, ray.direction, &self.tree.triangles[k]) else { continue };
                let triangle = self.tree.mesh_triangle[k];
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
    pub fn occluded(&self, ray: Ray) -> bool {
        let mut met = false;
        self.walk(ray, |_, first, count| {
            let triangles = &self.tree.triangles[first..first + count];
            met = triangles.iter().any(|t| intersect(ray.origin, ray.direction, t).is_some());
            !met
        });
        met
    }

    /// Number of triangles that the ray meets.
    pub fn crossings(&self, ray: Ray) -> usize {
        let mut met: Vec<u32> = Vec::new();
        self.walk(ray, |_, first, count| {
            let hit = |k: &usize| intersect(ray.origin, ray.direction, &self.tree.triangles[*k]).is_some();
            met.extend((first..first + count).filter(hit).map(|k| self.tree.mesh_triangle[k]));
            true
        });
        met.sort_unstable();
        met.dedup();
        met.len()
    }

    /// Visits the leaves that a ray meets, nearest first; `leaf(limit, first, count)` may lower the limit, and ends the
    /// walk by returning false.
    fn walk(&self, ray: Ray, mut leaf: impl FnMut(&mut f32, usize, usize) -> bool) {
        let inverse = ray.direction.map(packet::inverse);
        let mut limit = f32::INFINITY;
        let mut stack = [(Child::default(), 0.0_f32); MAX_DEPTH + 2];
        let mut top = 0;
        let mut child = self.tree.root;
        loop {
            if child.count > 0 {
                if !leaf(&mut limit, child.first as usize, child.count as usize) {
                    return;
                }
            } else if let Some(pair) = self.tree.pairs.get(child.first as usize) {
                let [left, right] = [0, 1].map(|side| slab(pair, side, ray.origin, inverse, limit));
                let ordered = match (left, right) {
                    (Some(l), Some(r)) if l <= r => Some((0, Some((1, r)))),
                    (Some(l), Some(_)) => Some((1, Some((0, l)))),
                    (Some(_), None) => Some((0, None)),
                    (None, Some(_)) => Some((1, None)),
                    (None, None) => None,
                };
                if let Some((near, far)) = ordered {
                    if let Some((side, t)) = far {
                        stack[top] = (pair.child[side], t);
                        top += 1;
                    }
                    child = pair.child[near];
                    continue;
                }
            }
            loop {
                if top == 0 {
                    return;
                }
                top -= 1;
                if stack[top].1 <= limit {
                    child = stack[top].0;
                    break;
                }
            }
        }
    }
}

/// Entry distance of a ray into one box of a pair, if it meets it before `limit`. The far distance is widened by two
/// roundings (Ize 2013, "Robust BVH ray traversal", JCGT 2(2)).
#[inline]
fn slab(pair: &Pair, side: usize, origin: [f32; 3], inverse: [f32; 3], limit: f32) -> Option<f32> {
    let mut near = 0.0_f32;
    let mut far = limit;
    for i in 0..3 {
        let a = (pair.low[side][i] - origin[i]) * inverse[i];
        let b = (pair.high[side][i] - origin[i]) * inverse[i];
        near = near.max(a.min(b));
        far = far.min(a.max(b) * packet::FAR_PAD);
    }
    (near <= far).then_some(near)
}
