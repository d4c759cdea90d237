//! Which points of a surface lie hidden in solids or below the terrain, where no light comes to. In: rays from points that see no
//! sky. Out: a verdict for each point.
//!
//! In the air rays meet the outside of things, inside of a solid the other side. A sheet, such as an overhang, has no inside: its other side
//! is lit, and does not count. Where the walls of two neighbours lie in one plane either may be met first, so much less than all of it has to
//! be the other side.
//!
//! Receivers that see no sky are told by paths instead: a cell that they see may lie half in the light, on the other side of a wall.

use glam::{DVec3, Vec3};

use super::change::Change;
use super::kernel::rays::{FaceSide, Hit, Ray, Tracer};
use heliotile_core::hemisphere::{Frame, cosine_direction_of, jitter, mix};
use heliotile_scene::mesh::Mesh;

/// Rays of a point at most; those behind its surface are not cast.
pub const LOOKS: usize = 8;

/// A point that sees more than this share of other sides is hidden. From one house of a row the party wall to the next may fill most of the
/// view.
const OTHER_SIDES: f64 = 0.25;

/// Which of some points are hidden.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// `[point]`.
    pub hidden: Vec<bool>,
    /// Whether some seemed to be, so that paths through the whole scene were followed.
    pub doubtful: bool,
}

/// Looks around from some of `count` points: pairs of a point and a ray. `inside`: the points are on the back of their triangles, so that it
/// is fronts that should not be met.
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
    // Only points that seem hidden are worth the paths that tell a sheet from a solid, until enough of what they see is known to be dark.
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

/// The side of a triangle that a ray meets.
pub fn side_met(ray: &Ray, hit: &Hit, mesh: &Mesh) -> FaceSide {
    let along = mesh.normal(hit.triangle as usize).as_vec3().dot(Vec3::from(ray.direction));
    if along > 0.0 { FaceSide::Back } else { FaceSide::Front }
}

/// Whether a ray meets the inner side of a solid or the underside of terrain: the back of a triangle to which no light comes.
pub fn meets_inside(ray: &Ray, hit: &Hit, mesh: &Mesh, tracer: &Tracer) -> bool {
    side_met(ray, hit, mesh) == FaceSide::Back && !is_lit(hit.triangle, FaceSide::Back, mesh, tracer)
}

/// Paths that are followed from each of the points of a triangle, first and in all, and surfaces that the first ones meet at most: most sides
/// that are asked for are dark, and that is to be found out cheaply.
const FIRST_PATHS: usize = 4;
const LIT_PATHS: usize = 16;
const FIRST_MET: usize = 3;
/// A side of which at least this share of paths gets to the sky is lit. Below a canopy on a square it is more than half; in a house whose
/// walls stand a little above rough terrain, or below the rim of terrain, it is a few hundredths.
const LIT: f64 = 0.25;

/// Whether light comes to a side of a triangle. Remembered by the tracer: it depends on the scene alone.
fn is_lit(triangle: u32, side: FaceSide, mesh: &Mesh, tracer: &Tracer) -> bool {
    tracer.lit_sides().known_or(triangle, side, || find_lit(triangle, side, mesh, tracer, &mut |_, _| {}))
}

/// Whether a change of the scene may be why light comes to the back of a triangle, or does not: some of the paths that tell meet what came or
/// went.
pub fn may_be_lit_since(change: &Change, triangle: u32, mesh: &Mesh, tracer: &Tracer) -> bool {
    let mut altered = false;
    find_lit(triangle, FaceSide::Back, mesh, tracer, &mut |rays, hits| altered |= change.altered_of(rays, hits) > 0);
    altered
}

/// What a set of rays met.
type Watch<'a> = &'a mut dyn FnMut(&[Ray], &[Option<Hit>]);

fn find_lit(triangle: u32, side: FaceSide, mesh: &Mesh, tracer: &Tracer, watch: Watch) -> bool {
    let outward = mesh.normal(triangle as usize);
    let normal = if side == FaceSide::Front { outward } else { -outward };
    let [a, b, c] = mesh.triangle_points(triangle as usize).map(|corner| mesh.grid().absolute(corner));
    let middle = (a + b + c) / 3.0;
    // The middle, and half way from there to each corner.
    let points = [middle, 0.5 * (middle + a), 0.5 * (middle + b), 0.5 * (middle + c)];
    let origins = points.map(|point| tracer.grid().lifted(point, normal));
    let starts = |paths: usize| origins.iter().flat_map(move |origin| (0..paths).map(move |path| (*origin, path)));
    let mut from = Start { normal, seed: 0x6c69_7473, most_met: FIRST_MET, until: Until::Sky };
    if follow(starts(FIRST_PATHS).collect(), &from, mesh, tracer, watch) == 0 {
        return false;
    }
    (from.most_met, from.until) = (MOST_MET, Until::End);
    let reached = follow(starts(LIT_PATHS).collect(), &from, mesh, tracer, watch);
    reached as f64 >= LIT * (origins.len() * LIT_PATHS) as f64
}

/// Paths from a receiver, and surfaces that each meets at most.
const PATHS: usize = 128;
const MOST_MET: usize = 8;

/// Whether light can come to a place: of some paths that turn at random at every surface, one gets to the sky. Through a gap of a hundredth of what
/// a place sees, one does in more than 99 of 100 cases.
pub fn is_reached(origin: [f32; 3], normal: DVec3, seed: u64, mesh: &Mesh, tracer: &Tracer) -> bool {
    let from = Start { normal, seed, most_met: MOST_MET, until: Until::Sky };
    follow((0..PATHS).map(|path| (origin, path)).collect(), &from, mesh, tracer, &mut |_, _| {}) > 0
}

/// When paths are followed no further.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Until {
    /// All of them have ended.
    End,
    /// One has got to the sky.
    Sky,
}

/// How paths begin, and how far they are followed.
struct Start {
    normal: DVec3,
    seed: u64,
    /// Surfaces that a path meets at most.
    most_met: usize,
    until: Until,
}

/// Follows paths, each by its origin and number, and counts those that get to the sky.
fn follow(starts: Vec<([f32; 3], usize)>, from: &Start, mesh: &Mesh, tracer: &Tracer, watch: Watch) -> usize {
    let Start { normal, seed, most_met, until } = *from;
    let turned = |normal: DVec3, path: usize, met: usize| {
        let direction = cosine_direction_of(jitter(mix(seed, path as u64), met as u64));
        Frame::of(normal).to_world(direction).as_vec3().to_array()
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
                    // The first sum is exact, and the second one that of input coordinates: equal in all scenes.
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

    /// Three houses in a row, 5 m wide, 10 m deep and 8 m high, on a plane 1 m above their feet, and opposite of them a wall 20 m high.
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

    /// Of 6 places on walls those 3 in party walls and below the ground are hidden, and those 3 in a street without sky are not, by 8 rays
    /// each; seen from within a house 1 of its walls is not hidden either.
    #[test]
    fn what_is_hidden() {
        let scene = row();
        let tracer = Tracer::new(&scene.mesh).expect("a tree");
        let is_hidden = |at: DVec3, normal: DVec3, inside: bool| {
            let (frame, origin) = (Frame::of(normal), tracer.grid().lifted(at, normal));
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

    /// Of 5 places in and around three houses light comes to the 2 in the street and not to the 3 within houses and below the ground.
    #[test]
    fn what_light_reaches() {
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
