//! Points on the surface of a cell. In: a cell key and the scene. Out: up to 16 points spread
//! evenly over the surfaces that the key names, with their normals; the key of a hit.
//!
//! The points depend on the surface only, not on how it is cut into triangles. Lines parallel to
//! the axis that the cell faces go through the bounding box of the clipped surface, and the first
//! surface along each line is taken; for leaves any one.
//!
//! All of it is computed relative to the voxel's corner, where corners of triangles are exact, so
//! that scenes with different origins get equal points to the bit.

use glam::{DVec2, DVec3};

use crate::trace::kernel::ray::Hit;
use crate::trace::kernel::rays::Tracer;
use crate::trace::volume::Volumes;
use heliotile_core::hemisphere::{mix, r2, unit};
use heliotile_core::site::cells::{CellKey, GRID_SHIFT_M, size_of};
use heliotile_scene::mesh::Mesh;

/// Largest number of points that a cell's rays start from.
pub const POINTS: usize = 16;

/// Number of lines tried before fewer points than wanted are accepted.
const TRIES: u32 = 160;

/// Surfaces of a scene that cells lie on.
#[derive(Clone, Copy)]
pub struct CellSurfaces<'a> {
    pub mesh: &'a Mesh,
    /// Tracer of the opaque triangles.
    pub tracer: &'a Tracer,
    /// Tracer of leaves and screens, and the volumes of leaves, if there are any.
    pub canopies: Option<(&'a Tracer, &'a Volumes)>,
}

impl<'a> CellSurfaces<'a> {
    /// Returns the tracer that holds the triangles of a cell.
    fn holding(&self, key: CellKey) -> &'a Tracer {
        self.canopies.filter(|_| key.is_leaf()).map_or(self.tracer, |canopies| canopies.0)
    }
}

/// Point of a cell (input coordinates, metres) and the normal on the side that the cell faces.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    pub position: DVec3,
    pub normal: DVec3,
}

/// Triangle of the cell. A coarse cell of a large map has very many of them.
struct Candidate {
    triangle: u32,
    /// Box of its part in the voxel, along the cell's axis.
    low: DVec2,
    high: DVec2,
}

/// Line along the cell's axis, and the surface of the cell on it with the highest rank: the first
/// one of a surface that stops light, any one of leaves, which lie behind each other.
struct Line {
    number: u32,
    at: DVec2,
    first: Option<(f64, SurfacePoint)>,
}

/// Returns at most `wanted` points of a cell. The list is empty only if the voxel holds no such
/// surface.
pub fn sample(key: CellKey, wanted: usize, surfaces: CellSurfaces) -> Vec<SurfacePoint> {
    let (mesh, tracer) = (surfaces.mesh, surfaces.holding(key));
    if let Some((hulls, volumes)) = surfaces.canopies.filter(|_| key.is_volume()) {
        return volumes.sample(key, wanted, mesh, hulls);
    }
    let (axis, sign) = key.axis();
    let grid = tracer.grid();
    let (corner, size) = (key.corner(grid.origin), size_of(key.level));
    // A surface in the voxel's boundary counts as inside.
    let slack = size / 8192.0 + grid.slack_m(corner, size);
    let low = -GRID_SHIFT_M - slack;
    let high = low + (size + 2.0 * slack);
    let to_scene = corner - grid.origin;
    let flat = |p: DVec3| match axis {
        0 => DVec2::new(p.y, p.z),
        1 => DVec2::new(p.x, p.z),
        _ => DVec2::new(p.x, p.y),
    };

    let mut candidates = Vec::new();
    let mut clipper = Clipper::default();
    let (mut box_low, mut box_high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    let corners_of = |triangle: u32| mesh.triangle_points(triangle as usize).map(|p| p - to_scene);
    for triangle in tracer.triangles_near(to_scene + low, to_scene + high, |tag| key.holds(tag)) {
        let corners = corners_of(triangle);
        // Nearly all triangles of a coarse cell are wholly inside.
        let is_inside = corners.iter().all(|p| p.cmpge(low).all() && p.cmple(high).all());
        let polygon = if is_inside { &corners[..] } else { clipper.clip(&corners, low, high) };
        if !is_inside && area_and_centre(polygon).is_none() {
            continue;
        }
        let (mut low2, mut high2) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for p in polygon {
            low2 = low2.min(flat(*p));
            high2 = high2.max(flat(*p));
        }
        box_low = box_low.min(low2);
        box_high = box_high.max(high2);
        candidates.push(Candidate { triangle, low: low2, high: high2 });
    }

    let seed = key.seed();
    let start = DVec2::new(unit(mix(seed, 101)), unit(mix(seed, 102)));
    let mut points = Vec::with_capacity(wanted);
    let (mut tried, mut count) = (0, wanted as u32);
    while points.len() < wanted && tried < TRIES && !candidates.is_empty() {
        let last = TRIES.min(tried + count);
        let line = |i: u32| {
            let at = box_low + (box_high - box_low) * r2(f64::from(i), start);
            Line { number: i, at, first: None }
        };
        let mut lines: Vec<Line> = (tried..last).map(line).collect();
        // Candidates may be very many, each crossed by few lines.
        lines.sort_by(|a, b| a.at.x.total_cmp(&b.at.x));
        for c in &candidates {
            let from = lines.partition_point(|line| line.at.x < c.low.x);
            for line in lines[from..].iter_mut().take_while(|line| line.at.x <= c.high.x) {
                let at = line.at;
                if at.y < c.low.y || at.y > c.high.y {
                    continue;
                }
                let corners = corners_of(c.triangle);
                let Some(normal) = key.side_of(mesh.normal(c.triangle as usize)) else { continue };
                let Some(weights) = barycentric(corners.map(flat), at) else { continue };
                let position = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
                let height = position[axis] * sign;
                // The random rank depends on the place alone, so every leaf on the line is as
                // likely, in whatever order the triangles come.
                let rank = match key.is_leaf() {
                    true => unit(mix(seed ^ height.to_bits(), u64::from(line.number))),
                    false => height,
                };
                let inside = position[axis] >= low[axis] && position[axis] <= high[axis];
                if inside && line.first.as_ref().is_none_or(|(r, _)| rank > *r) {
                    line.first = Some((rank, SurfacePoint { position, normal }));
                }
            }
        }
        lines.sort_by_key(|line| line.number);
        points.extend(lines.into_iter().filter_map(|line| line.first).map(|(_, p)| p).take(wanted - points.len()));
        // Each round passes over all candidates, so rounds grow where most lines miss.
        (tried, count) = (last, count * 2);
    }
    if points.is_empty() {
        let mut largest: Option<(f64, SurfacePoint)> = None;
        for c in &candidates {
            let part = area_and_centre(clipper.clip(&corners_of(c.triangle), low, high));
            let Some((area, position)) = part else { continue };
            let Some(normal) = key.side_of(mesh.normal(c.triangle as usize)) else { continue };
            if largest.as_ref().is_none_or(|(a, _)| area > *a) {
                largest = Some((area, SurfacePoint { position, normal }));
            }
        }
        points.extend(largest.map(|(_, p)| p));
    }
    points.iter_mut().for_each(|point| point.position += corner);
    points
}

/// Clipper of triangles to a box (Sutherland and Hodgman 1974). Its lists are reused for one
/// triangle after the other.
#[derive(Default)]
struct Clipper {
    polygon: Vec<DVec3>,
    kept: Vec<DVec3>,
}

impl Clipper {
    /// Returns the part of a triangle inside a box, with at most nine corners apart from rounding.
    fn clip(&mut self, corners: &[DVec3; 3], low: DVec3, high: DVec3) -> &[DVec3] {
        let Clipper { polygon, kept } = self;
        polygon.clear();
        polygon.extend(corners);
        for axis in 0..3 {
            for (bound, sign) in [(low[axis], 1.0), (high[axis], -1.0)] {
                let depth = |p: &DVec3| (p[axis] - bound) * sign;
                if polygon.iter().all(|p| depth(p) >= 0.0) {
                    continue;
                }
                kept.clear();
                for (i, p) in polygon.iter().enumerate() {
                    let q = polygon.get(i + 1).unwrap_or(&polygon[0]);
                    let (dp, dq) = (depth(p), depth(q));
                    if dp >= 0.0 {
                        kept.push(*p);
                    }
                    // The two depths have opposite signs, so their difference is not zero.
                    if (dp >= 0.0) != (dq >= 0.0) {
                        kept.push(*p + (*q - *p) * (dp / (dp - dq)));
                    }
                }
                std::mem::swap(polygon, kept);
            }
        }
        polygon
    }
}

/// Returns the area and the centroid of a plane convex polygon; `None` if it has no area.
fn area_and_centre(polygon: &[DVec3]) -> Option<(f64, DVec3)> {
    let first = *polygon.first()?;
    let (mut area, mut moment) = (0.0, DVec3::ZERO);
    for pair in polygon[1..].windows(2) {
        let part = 0.5 * (pair[0] - first).cross(pair[1] - first).length();
        area += part;
        moment += (first + pair[0] + pair[1]) / 3.0 * part;
    }
    (area > 0.0).then(|| (area, moment / area))
}

/// Returns the barycentric coordinates of a point in a flat triangle; `None` outside or if the
/// triangle is seen edge-on.
pub(super) fn barycentric(corners: [DVec2; 3], p: DVec2) -> Option<[f64; 3]> {
    let [a, b, c] = corners.map(|q| q - p);
    let w = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
    let sum = w[0] + w[1] + w[2];
    let inside = w.iter().all(|&x| x >= 0.0) || w.iter().all(|&x| x <= 0.0);
    (inside && sum != 0.0).then(|| w.map(|x| x / sum))
}

/// Returns the cell of a hit of a ray from `origin`, on the side that the ray comes from.
pub fn cell_of(hit: Hit, direction: DVec3, level: i8, mesh: &Mesh, origin: DVec3) -> CellKey {
    let triangle = hit.triangle as usize;
    let outward = mesh.normal(triangle);
    let back = outward.dot(direction) > 0.0;
    // The first sum is exact, and the second is in input coordinates, so it is equal in all scenes.
    let point = mesh.grid().absolute(origin) + direction * f64::from(hit.t);
    CellKey::new(point, outward, back, mesh.triangle_material[triangle], level)
}
