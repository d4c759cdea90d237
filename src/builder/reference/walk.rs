//! Light paths from a receiver. In: a receiver, suns and skies. Out: its irradiance by each.

use std::f64::consts::PI;

use glam::DVec3;

use super::carried::Carried;
use super::estimate::{BATCHES, Batch, ReferenceLight};
use super::random::{EVEN, Random, even};
use super::sky::{ReferenceSky, SkyPlace, cosine};
use super::sun::SunLook;
use crate::pipeline::PreparedScene;
use crate::settings::{Effect, Effects};
use crate::trace::canopy::{Canopies, Passage, Path};
use crate::trace::kernel::rays::Hit;
use crate::trace::{Ray, Tracer};
use heliotile_core::hemisphere::{Frame, mix, texels_in_blocks};
use heliotile_core::light::fresnel::specular;
use heliotile_core::light::reflector::Reflector;
use heliotile_core::site::chain::MirrorPlane;
use heliotile_core::site::material::Material;
use heliotile_scene::mesh::Mesh;
use heliotile_scene::mirrors::Mirrors;

/// Number of surfaces that a path hits before Russian roulette may end it.
const SURE: u32 = 2;

/// Largest probability of going on, so that a path between white walls ends, too.
const LIKELIEST: f64 = 0.95;

/// Number of rays for directly seen sky, per path.
const SKY_RAYS: usize = 16;

/// Paths per point of the sun's disc if only the sun is evaluated, under many skies;
/// [`MIN_POINTS`] is the smallest number of points.
const PATHS_OF_POINT: usize = 16;
const MIN_POINTS: usize = 256;

/// Reference path tracer of a scene.
pub struct PathTracer<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) tracer: &'a Tracer,
    canopies: Option<&'a Canopies<'a>>,
    /// Mirrors; `None` if there are none.
    pub(super) mirrors: Option<&'a Mirrors>,
    pub(super) reflectors: Vec<Reflector>,
    /// True if light is reflected by at most one matt surface.
    once: bool,
    /// True if leaves scatter light.
    leaves: bool,
}

/// Place on a surface, where rays start.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Position relative to the scene origin, off the surface.
    pub from: DVec3,
    /// Normal on the side that is lit.
    pub normal: DVec3,
}

/// End of a path so far.
struct Walker {
    batch: usize,
    from: DVec3,
    direction: DVec3,
    carried: Carried,
    met: u32,
    random: Random,
}

/// Sums by sky and batch, W/m2.
pub(super) type Sums = Vec<[Batch; BATCHES]>;

impl<'a> PathTracer<'a> {
    /// Creates the path tracer of a scene. Effects in `left_out` are left out as a build leaves
    /// them out.
    pub fn new(prepared: &'a PreparedScene<'a>, left_out: Effects) -> Self {
        let reflector = |material: &Material| match left_out.contains(Effect::Diffuse) {
            true => Reflector { diffuse: 0.0, ..Reflector::new(material) },
            false => Reflector::new(material),
        };
        PathTracer {
            mesh: &prepared.scene.mesh,
            tracer: &prepared.tracer,
            canopies: prepared.canopies.as_ref().filter(|_| !left_out.contains(Effect::Canopies)),
            mirrors: Some(&prepared.mirrors).filter(|all| !all.is_empty() && !left_out.contains(Effect::Mirrors)),
            reflectors: prepared.scene.materials.iter().map(reflector).collect(),
            once: left_out.contains(Effect::Bounces),
            leaves: ![Effect::Leaves, Effect::Diffuse].iter().any(|effect| left_out.contains(*effect)),
        }
    }

    /// Returns the irradiance of a receiver (input coordinates, unit normal) by each sky, by
    /// `paths` paths that are the same for all skies.
    pub fn irradiance(
        &self,
        position: DVec3,
        normal: DVec3,
        skies: &[&ReferenceSky],
        paths: usize,
        seed: u64,
    ) -> Vec<ReferenceLight> {
        let each = paths.div_ceil(BATCHES).max(1);
        let mut sums: Sums = vec![[Batch::default(); BATCHES]; skies.len()];
        let here = self.receiver_place(position, normal);
        let frame = Frame::new(normal);
        let (mut walkers, mut looks) = (Vec::with_capacity(each * BATCHES), Vec::new());
        for batch in 0..BATCHES {
            for (mut random, [a, b, which, across, along]) in starts(seed, batch, each) {
                looks.extend(SunLook::at_all(here, batch, Carried::START, skies, [which, across, along], &mut random));
                let direction = cosine(&frame, [a, b]);
                walkers.push(Walker { batch, from: here.from, direction, carried: Carried::START, met: 0, random });
            }
        }
        self.add_suns(&looks, &mut sums);
        self.add_open_sky(here, skies, each, mix(seed, 1 << 32), &mut sums);
        while !walkers.is_empty() {
            let rays: Vec<Ray> = walkers.iter().map(|walker| ray(walker.from, walker.direction)).collect();
            let hits = self.tracer.closest_many(&rays);
            let reaches = hits.iter().map(|hit| hit.map_or(f32::INFINITY, |hit| hit.t));
            let ways = numbered(rays.into_iter().zip(reaches));
            let passages = self.canopies.map_or_else(Vec::new, |canopies| canopies.passages(&ways));
            let through = self.left_behind(&passages, ways.len());
            looks.clear();
            let mut next = Vec::with_capacity(walkers.len());
            // Before `through` applies: only the leaves in front of a leaf dim its light.
            for passage in passages.iter().filter(|_| self.leaves) {
                next.extend(self.scatter(&mut walkers[passage.place as usize], passage, skies, &mut looks));
            }
            for ((mut walker, hit), through) in walkers.into_iter().zip(hits).zip(through) {
                walker.carried = walker.carried.through(through);
                match hit {
                    Some(hit) => next.extend(self.meet(walker, hit, skies, &mut looks)),
                    None => see(&walker, skies, &mut sums),
                }
            }
            self.add_suns(&looks, &mut sums);
            walkers = next;
        }
        lights(&sums, each)
    }

    /// Returns the irradiance of a receiver (input coordinates, unit normal) by the sun of each
    /// sky, direct and by mirrors; other components are 0. The number of points of the disc is a
    /// sixteenth of `paths`, but at least 256, and they are the same for all skies.
    pub fn sun(
        &self,
        position: DVec3,
        normal: DVec3,
        skies: &[&ReferenceSky],
        paths: usize,
        seed: u64,
    ) -> Vec<ReferenceLight> {
        let each = paths.div_ceil(PATHS_OF_POINT).max(MIN_POINTS).div_ceil(BATCHES);
        let mut sums: Sums = vec![[Batch::default(); BATCHES]; skies.len()];
        let here = self.receiver_place(position, normal);
        for batch in 0..BATCHES {
            let mut looks = Vec::with_capacity(each * skies.len());
            for (mut random, [_, _, which, across, along]) in starts(seed, batch, each) {
                looks.extend(SunLook::at_all(here, batch, Carried::START, skies, [which, across, along], &mut random));
            }
            self.add_suns(&looks, &mut sums);
        }
        lights(&sums, each)
    }

    fn receiver_place(&self, position: DVec3, normal: DVec3) -> Place {
        Place { from: vector(self.mesh.grid().lifted(position, normal)), normal }
    }

    /// Adds the directly seen sky. Its rays cost little, and go through one cell each of the square
    /// that cosine-weighted directions come from. Sums are scaled to `each` paths.
    fn add_open_sky(&self, here: Place, skies: &[&ReferenceSky], each: usize, seed: u64, sums: &mut Sums) {
        let frame = Frame::new(here.normal);
        let side = (SKY_RAYS * each).isqrt().max(1);
        let mut random = Random::new(seed);
        for batch in 0..BATCHES {
            let mut direction = |(column, row): (usize, usize)| {
                let [a, b]: [f64; 2] = random.many();
                cosine(&frame, [(column as f64 + a) / side as f64, (row as f64 + b) / side as f64])
            };
            let directions: Vec<DVec3> = texels_in_blocks(side).map(&mut direction).filter(|d| d.z > 0.0).collect();
            let rays: Vec<Ray> = directions.iter().map(|d| ray(here.from, *d)).collect();
            let straight = Carried::START.times(PI * each as f64 / (side * side) as f64);
            for (number, through) in self.open(&rays) {
                let Some(place) = SkyPlace::new(directions[number]) else { continue };
                for (sky, sums) in skies.iter().zip(sums.iter_mut()) {
                    straight.through(through).add(false, sky.radiance(place), &mut sums[batch]);
                }
            }
        }
    }

    /// Returns the rays that hit nothing, with the share that canopies let through.
    pub(super) fn open(&self, rays: &[Ray]) -> Vec<(usize, f64)> {
        let met = self.tracer.occluded_many(rays);
        let open: Vec<usize> = met.into_iter().enumerate().filter(|(_, met)| !met).map(|(place, _)| place).collect();
        let through = self.through(open.iter().map(|&place| (rays[place], f32::INFINITY)));
        open.into_iter().zip(through).collect()
    }

    /// Handles a path at a surface: queries the sun, and goes on unless the path ends there.
    fn meet(&self, mut walker: Walker, hit: Hit, skies: &[&ReferenceSky], looks: &mut Vec<SunLook>) -> Option<Walker> {
        let (place, orientation) = self.place(walker.from, walker.direction, hit);
        let material = self.mesh.triangle_material[hit.triangle as usize];
        let reflector = &self.reflectors[usize::from(material)];
        let cos = place.normal.dot(walker.direction).abs();
        let mirrored = orientation.map_or(0.0, |_| specular(reflector, cos));
        let diffuse = if self.once && walker.carried.matt > 0 { 0.0 } else { reflector.diffuse };
        let reflected = mirrored + diffuse;
        if diffuse > 0.0 {
            let (which, carried) = (walker.random.many(), walker.carried.times(diffuse).reflected());
            looks.extend(SunLook::at_all(place, walker.batch, carried, skies, which, &mut walker.random));
        }
        let [on, kind, a, b] = walker.random.many();
        let likely = if walker.met < SURE { 1.0 } else { reflected.min(LIKELIEST) };
        if reflected <= 0.0 || on >= likely {
            return None;
        }
        walker.carried = walker.carried.times(reflected / likely);
        walker.met += 1;
        walker.from = place.from;
        match orientation.filter(|_| kind * reflected < mirrored) {
            Some(orientation) => {
                walker.direction = orientation.reflect(walker.direction).normalize();
                walker.carried = walker.carried.mirrored();
            }
            None => {
                walker.direction = cosine(&Frame::new(place.normal), [a, b]);
                walker.carried = walker.carried.reflected();
            }
        }
        Some(walker)
    }

    /// Returns a path that one of the leaves on the way scatters, drawn at random; the path itself
    /// goes on.
    fn scatter(
        &self,
        walker: &mut Walker,
        passage: &Passage,
        skies: &[&ReferenceSky],
        looks: &mut Vec<SunLook>,
    ) -> Option<Walker> {
        let leaves = self.canopies?.leaves(passage);
        if leaves.is_empty() || self.once && walker.carried.matt > 0 {
            return None;
        }
        let [which, on, side, a, b] = walker.random.many();
        let leaf = &leaves[(which * leaves.len() as f64) as usize];
        let through = leaf.before.iter().map(|&(material, count)| self.left(material, count)).product::<f64>();
        let scattered = self.reflectors[usize::from(leaf.material)].diffuse * through * leaves.len() as f64;
        let likely = if walker.met < SURE { 1.0 } else { scattered.min(LIKELIEST) };
        if scattered <= 0.0 || on >= likely {
            return None;
        }
        let carried = walker.carried.times(scattered / likely).scattered();
        let mut random = Random::new((walker.random.next() * 2.0_f64.powi(53)) as u64);
        let places = [leaf.normal, -leaf.normal]
            .map(|normal| Place { from: vector(self.mesh.grid().lifted(leaf.point, normal)), normal });
        let disc = random.many();
        for place in places {
            // Half of the scattered light leaves on each side.
            looks.extend(SunLook::at_all(place, walker.batch, carried.times(0.5), skies, disc, &mut random));
        }
        let Place { from, normal } = places[usize::from(side < 0.5)];
        let direction = cosine(&Frame::new(normal), [a, b]);
        Some(Walker { batch: walker.batch, from, direction, carried, met: walker.met + 1, random })
    }

    /// Returns the place where a ray hits a surface, and the orientation of the mirror if it is
    /// one.
    pub(super) fn place(&self, from: DVec3, direction: DVec3, hit: Hit) -> (Place, Option<MirrorPlane>) {
        let triangle = hit.triangle as usize;
        let outward = self.mesh.normal(triangle);
        let normal = if outward.dot(direction) > 0.0 { -outward } else { outward };
        // Distances have single precision, so the place is moved onto the plane of the surface.
        let way = direction * f64::from(hit.t);
        let [corner, ..] = self.mesh.triangle_points(triangle);
        let way = way - outward * (way - (corner - from)).dot(outward);
        let grid = self.mesh.grid();
        let from = vector(grid.lifted(grid.absolute(from) + way, normal));
        (Place { from, normal }, self.orientation(hit).map(|(_, orientation)| orientation))
    }

    /// Returns the number and orientation of the mirror that was hit; `None` if it is no mirror.
    pub(super) fn orientation(&self, hit: Hit) -> Option<(u16, MirrorPlane)> {
        let mirrors = self.mirrors?;
        let number = mirrors.of_triangle(hit.triangle)?;
        Some((number, mirrors.orientations[usize::from(number)]))
    }

    /// Returns the shares that canopies let through of rays with their lengths, metres.
    pub(super) fn through(&self, rays: impl ExactSizeIterator<Item = (Ray, f32)>) -> Vec<f64> {
        let count = rays.len();
        match self.canopies {
            None => vec![1.0; count],
            Some(canopies) => self.left_behind(&canopies.passages(&numbered(rays)), count),
        }
    }

    /// Returns the remaining share of `rays` rays, some of which cross canopies.
    fn left_behind(&self, passages: &[Passage], rays: usize) -> Vec<f64> {
        let mut through = vec![1.0; rays];
        for crossing in self.canopies.iter().flat_map(|canopies| canopies.counted(passages)) {
            through[crossing.ray as usize] *= self.left(crossing.material, crossing.count);
        }
        through
    }

    /// Returns the share that `count` crossings of a canopy leave.
    fn left(&self, material: u16, count: u8) -> f64 {
        self.reflectors[usize::from(material)].transmittance.unwrap_or(1.0).powi(i32::from(count))
    }
}

/// Numbers rays and their lengths, metres.
fn numbered(rays: impl Iterator<Item = (Ray, f32)>) -> Vec<Path> {
    (0..).zip(rays).map(|(place, (ray, reach_m))| Path { place, ray, reach_m }).collect()
}

/// Returns the first numbers of each path of a batch, and the source of its other numbers.
fn starts(seed: u64, batch: usize, paths: usize) -> impl Iterator<Item = (Random, [f64; EVEN])> {
    // Mixed twice: seeds and batches are small numbers, and one mix would confuse their sums.
    let of_batch = mix(mix(seed, 0), batch as u64);
    let shift: [f64; EVEN] = Random::new(mix(of_batch, 0)).many();
    (0..paths).map(move |i| (Random::new(mix(of_batch, i as u64 + 1)), even(i, &shift)))
}

/// Returns the estimates by sky from sums over `each` paths of each batch.
fn lights(sums: &Sums, each: usize) -> Vec<ReferenceLight> {
    sums.iter().map(|batches| ReferenceLight::new(&batches.map(|sums| sums.map(|sum| sum / each as f64)))).collect()
}

/// Adds the sky at the end of a path. Directly seen sky has rays of its own.
fn see(walker: &Walker, skies: &[&ReferenceSky], sums: &mut Sums) {
    let Some(place) = SkyPlace::new(walker.direction).filter(|_| walker.met > 0) else { return };
    for (sky, sums) in skies.iter().zip(sums) {
        walker.carried.add(false, PI * sky.radiance(place), &mut sums[walker.batch]);
    }
}

pub(super) fn ray(from: DVec3, direction: DVec3) -> Ray {
    Ray { origin: from.as_vec3().to_array(), direction: direction.as_vec3().to_array() }
}

fn vector(point: [f32; 3]) -> DVec3 {
    DVec3::from(point.map(f64::from))
}
