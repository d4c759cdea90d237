//! Points of a surface that are hidden in solids or below the terrain, where no light arrives. In:
//! rays from points that see no sky. Out: a verdict for each point.
//!
//! Rays in the air hit the outside of things; rays inside a solid hit the other side. A sheet, such
//! as an overhang, has no inside: its other side is lit and does not count. Where the walls of two
//! neighbours lie in one plane, either may be hit first, so a point counts as hidden if much less
//! than all of its hits are other sides.
//!
//! Light paths decide on receivers that see no sky ([`is_reached`]), because a cell that they see
//! may be half lit, on the other side of a wall.

use glam::{DVec3, Vec3};

use super::change::Change;
use super::kernel::rays::{FaceSide, Tracer};
use crate::trace::kernel::ray::{Hit, Ray};
use heliotile_core::hemisphere::{Frame, cosine_direction_of, jitter, mix};
use heliotile_scene::mesh::Mesh;

/// Largest number of rays of a point; rays that go behind its surface are not cast.
pub const LOOKS: usize = 8;

/// Share of other sides among the hits of a point above which it is hidden. The party wall of the
/// next house in a row may fill most of the view.
const OTHER_SIDES: f64 = 0.25;

/// Verdict about some points.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// `[point]`: true if it is hidden.
    pub hidden: Vec<bool>,
    /// True if some points seemed hidden, so that paths through the whole scene decided.
    pub doubtful: bool,
}

/// Decides on `count` points by `looks`, pairs of a point and a ray. With `inside` the points are
/// on the back of their triangles, so that front sides count as other sides.
pub fn hidden(count: usize, looks: &[(usize, Ray)], inside: bool, mesh: &Mesh, tracer: &Tracer) -> Verdict {
    let rays: Vec<Ray> = looks.iter().map(|look| look.1).collect();
    let hits = tracer.closest_many(&rays);
    let (mut met, mut others) = (vec![0.0; count], vec![0.0; count]);
    let is_other = |ray: &Ray, hit: &Hit| (side_met(ray, hit, mesh) == FaceSide::Back) != inside;
    for (&(point, ray), hit) in looks.iter().zip(&hits) {
        let Some(hit) = hit else { continue };
        met[point] += 1.0;
        others[point] += f64::from(u8::from(is_other(&ray, hit)));
    }
    let is_hidden =
        |others: &[f64]| -> Vec<bool> { met.iter().zip(others).map(|(met, o)| *o > OTHER_SIDES * met).collect() };
    // Paths that tell a sheet from a solid cost much. They are followed only for points that seem
    // hidden, until enough of the surfaces hit are known to be dark.
    let suspected = is_hidden(&others);
    let mut dark = vec![0.0; count];
    for (&(point, ray), hit) in looks.iter().zip(&hits) {
        let Some(hit) = hit else { continue };
        let is_open = suspected[point] && dark[point] <= OTHER_SIDES * met[point];
        if is_open && is_other(&ray, hit) && !is_lit(hit.triangle, side_met(&ray, hit, mesh), mesh, tracer) {
            dark[point] += 1.0;
        }
    }
    Verdict { hidden: is_hidden(&dark), doubtful: suspected.contains(&true) }
}

/// Returns the side of a triangle that a ray hits.
pub fn side_met(ray: &Ray, hit: &Hit, mesh: &Mesh) -> FaceSide {
    let along = mesh.normal(hit.triangle as usize).as_vec3().dot(Vec3::from(ray.direction));
    if along > 0.0 { FaceSide::Back } else { FaceSide::Front }
}

/// Returns true if a ray hits the inner side of a solid or the underside of terrain: the back of a
/// triangle that no light reaches.
pub fn meets_inside(ray: &Ray, hit: &Hit, mesh: &Mesh, tracer: &Tracer) -> bool {
    side_met(ray, hit, mesh) == FaceSide::Back && !is_lit(hit.triangle, FaceSide::Back, mesh, tracer)
}

/// Numbers of paths from each start point of a triangle, in the first round and in all, and largest
/// number of surfaces that a path of the first round hits. Most sides in question are dark, and the
/// first round finds that out cheaply.
const FIRST_PATHS: usize = 4;
const LIT_PATHS: usize = 16;
const FIRST_MET: usize = 3;
/// Share of paths that reach the sky from which on a side counts as lit. Below a canopy on a square
/// it is more than half; in a house whose walls stand a little above rough terrain, or below the
/// rim of terrain, it is a few hundredths.
const LIT: f64 = 0.25;

/// Returns true if light reaches a side of a triangle. The tracer caches the answer, which depends
/// on the scene alone.
fn is_lit(triangle: u32, side: FaceSide, mesh: &Mesh, tracer: &Tracer) -> bool {
    tracer.lit_sides().known_or(triangle, side, || find_lit(triangle, side, mesh, tracer, &mut |_, _| {}))
}

/// Returns true if a change of the scene may have altered whether light reaches the back of a
/// triangle: some of the paths that decide it meet an added or removed triangle.
pub fn may_be_lit_since(change: &Change, triangle: u32, mesh: &Mesh, tracer: &Tracer) -> bool {
    let mut altered = false;
    find_lit(triangle, FaceSide::Back, mesh, tracer, &mut |rays, hits| altered |= change.altered_of(rays, hits) > 0);
    altered
}

/// Callback that gets a set of rays and their hits.
type Watch<'a> = &'a mut dyn FnMut(&[Ray], &[Option<Hit>]);

fn find_lit(triangle: u32, side: FaceSide, mesh: &Mesh, tracer: &Tracer, watch: Watch) -> bool {
    let outward = mesh.normal(triangle as usize);
    let normal = if side == FaceSide::Front { outward } else { -outward };
    let [a, b, c] = mesh.triangle_points(triangle as usize).map(|corner| mesh.grid().absolute(corner));
    let middle = (a + b + c) / 3.0;
    // Start from the centre and from half way between it and each corner.
    let points = [middle, 0.5 * (middle + a), 0.5 * (middle + b), 0.5 * (middle + c)];
    let origins = points.map(|point| tracer.grid().lifted(point, normal));
    let starts = |paths: usize| origins.iter().flat_map(move |origin| (0..paths).map(move |path| (*origin, path)));
    // The seed is fixed, since the answer may depend on the scene alone.
    let mut from = Start { normal, seed: 0x6c69_7473, most_met: FIRST_MET, until: Until::Sky };
    if follow(starts(FIRST_PATHS).collect(), &from, mesh, tracer, watch) == 0 {
        return false;
    }
    (from.most_met, from.until) = (MAX_MET, Until::End);
    let reached = follow(starts(LIT_PATHS).collect(), &from, mesh, tracer, watch);
    reached as f64 >= LIT * (origins.len() * LIT_PATHS) as f64
}

/// Number of paths from a receiver; [`MAX_MET`] is the largest number of surfaces that each hits.
const PATHS: usize = 128;
const MAX_MET: usize = 8;

/// Returns true if light can reach a place: one of [`PATHS`] paths that turn at random at every
/// surface reaches the sky. Through a gap of a hundredth of the view, one does in more than 99 of
/// 100 cases.
pub fn is_reached(origin: [f32; 3], normal: DVec3, seed: u64, mesh: &Mesh, tracer: &Tracer) -> bool {
    let from = Start { normal, seed, most_met: MAX_MET, until: Until::Sky };
    follow((0..PATHS).map(|path| (origin, path)).collect(), &from, mesh, tracer, &mut |_, _| {}) > 0
}

/// Condition that ends the following of paths.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Until {
    /// All paths have ended.
    End,
    /// One path has reached the sky.
    Sky,
}

/// Start of paths, and how far they are followed.
struct Start {
    normal: DVec3,
    seed: u64,
    /// Largest number of surfaces that a path hits.
    most_met: usize,
    until: Until,
}

/// Follows paths, each given by its origin and number, and counts those that reach the sky.
fn follow(starts: Vec<([f32; 3], usize)>, from: &Start, mesh: &Mesh, tracer: &Tracer, watch: Watch) -> usize {
    let Start { normal, seed, most_met, until } = *from;
    let turned = |normal: DVec3, path: usize, met: usize| {
        let direction = cosine_direction_of(jitter(mix(seed, path as u64), met as u64));
        Frame::new(normal).to_world(direction).as_vec3().to_array()
    };
    let start = |(origin, path)| (path, Ray { origin, direction: turned(normal, path, 0) });
    let mut paths: Vec<(usize, Ray)> = starts.into_iter().map(start).collect();
    let mut reached = 0;
    for met in 1..=most_met {
        let rays: Vec<Ray> = paths.iter().map(|path| path.1).collect();
        let mut next = Vec::with_capacity(paths.len());
        let hits = tracer.closest_many(&rays);
        watch(&rays, &hits);
        for ((path, ray), hit) in paths.into_iter().zip(hits) {
            let direction = DVec3::from(ray.direction.map(f64::from));
            match hit {
                None if direction.z > 0.0 => {
                    reached += 1;
                    if until == Until::Sky {
                        return reached;
                    }
                }
                None => {}
                Some(hit) => {
                    let outward = mesh.normal(hit.triangle as usize);
                    let normal = if outward.dot(direction) > 0.0 { -outward } else { outward };
                    // The first sum is exact, and the second is in input coordinates, so it is
                    // equal in all scenes.
                    let from = mesh.grid().absolute(DVec3::from(ray.origin.map(f64::from)));
                    let origin = tracer.grid().lifted(from + direction * f64::from(hit.t), normal);
                    next.push((path, Ray { origin, direction: turned(normal, path, met) }));
                }
            }
        }
        paths = next;
    }
    reached
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::test_scenes::matt;
    use heliotile_scene::Scene;

    /// Returns a scene of three houses in a row, 5 m wide, 10 m deep and 8 m high, on a plane 1 m
    /// above their feet, and a wall 20 m high opposite.
    fn row() -> Scene {
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        let mut faces = vec![[DVec3::new(-50.0, -50.0, 1.0), 100.0 * x, 100.0 * y]];
        let mut house = |p: DVec3, x: DVec3, y: DVec3, z: DVec3| {
            faces.extend([[p, x, z], [p + x, y, z], [p + x + y, -x, z], [p + y, -y, z], [p + z, x, y]]);
        };
        for i in 0..3 {
            house(DVec3::new(5.0 * f64::from(i), 0.0, 0.0), 5.0 * x, 10.0 * y, 8.0 * z);
        }
        house(DVec3::new(-40.0, -11.0, 0.0), 80.0 * x, 8.0 * y, 20.0 * z);
        matt(&faces)
    }

    /// With 8 rays each, 3 places in party walls and below the ground are hidden, and 3 places on
    /// walls in a street without sky are not. Seen from within a house, 1 of its walls is not
    /// hidden either.
    #[test]
    fn places_in_party_walls_are_hidden() {
        let scene = row();
        let tracer = Tracer::new(&scene.mesh).expect("a tree");
        let is_hidden = |at: DVec3, normal: DVec3, inside: bool| {
            let (frame, origin) = (Frame::new(normal), tracer.grid().lifted(at, normal));
            let even = |i: usize| glam::DVec2::new(i as f64 * 0.754_877_666, i as f64 * 0.569_840_291).fract();
            let up = (1..).map(|i| frame.to_world(cosine_direction_of(even(i)))).filter(|d| d.z > 0.0);
            let low = up.filter(|d| d.z < 0.5).take(LOOKS);
            let looks: Vec<(usize, Ray)> =
                low.map(|d| (0, Ray { origin, direction: d.as_vec3().to_array() })).collect();
            hidden(1, &looks, inside, &scene.mesh, &tracer).hidden[0]
        };
        let (x, y) = (DVec3::X, DVec3::Y);
        for (at, normal) in
            [(DVec3::new(5.0, 4.0, 3.0), x), (DVec3::new(5.0, 6.0, 5.0), -x), (DVec3::new(2.0, 0.0, 0.4), -y)]
        {
            assert!(is_hidden(at, normal, false), "{at}");
        }
        for at in [DVec3::new(2.0, 0.0, 3.0), DVec3::new(7.0, 0.0, 1.5), DVec3::new(12.0, 0.0, 2.0)] {
            assert!(!is_hidden(at, -y, false), "{at}");
        }
        assert!(!is_hidden(DVec3::new(2.0, 0.0, 3.0), y, true));
    }

    /// Light reaches the 2 places in the street in front of three houses, and not the 3 places
    /// inside houses and below the ground.
    #[test]
    fn light_reaches_the_street_and_not_the_houses() {
        let scene = row();
        let tracer = Tracer::new(&scene.mesh).expect("a tree");
        let reached =
            |at: DVec3, normal: DVec3| is_reached(tracer.grid().lifted(at, normal), normal, 7, &scene.mesh, &tracer);
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        assert!(reached(DVec3::new(2.0, 0.0, 3.0), -y) && reached(DVec3::new(7.0, -1.0, 1.0), z));
        for (at, normal) in [([5.0, 4.0, 3.0], x), ([7.0, 4.0, 1.0], z), ([2.0, 0.0, 0.4], -y)] {
            assert!(!reached(DVec3::from(at), normal), "{at:?}");
        }
    }
}
