//! Light paths from a receiver. In: a receiver, suns and skies. Out: its irradiance by each.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::carried::Carried;
use super::estimate::{BATCHES, Batch, ReferenceLight};
use super::random::{EVEN, Random, even};
use super::sky::{ReferenceSky, SkyPlace, cosine};
use super::sun::SunLook;
use super::tracer::{PathTracer, PathVertex, Sums, numbered, ray, vector};
use crate::trace::Ray;
use crate::trace::canopy::Passage;
use crate::trace::kernel::ray::Hit;
use heliotile_core::hemisphere::{Frame, direction_of, mix, texels_in_blocks};
use heliotile_core::light::fresnel::specular;

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

/// End of a path so far.
struct Walker {
    batch: usize,
    from: DVec3,
    direction: DVec3,
    carried: Carried,
    met: u32,
    random: Random,
}

impl PathTracer<'_> {
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
        let here = self.receiver_vertex(position, normal);
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
        let here = self.receiver_vertex(position, normal);
        for batch in 0..BATCHES {
            let mut looks = Vec::with_capacity(each * skies.len());
            for (mut random, [_, _, which, across, along]) in starts(seed, batch, each) {
                looks.extend(SunLook::at_all(here, batch, Carried::START, skies, [which, across, along], &mut random));
            }
            self.add_suns(&looks, &mut sums);
        }
        lights(&sums, each)
    }

    fn receiver_vertex(&self, position: DVec3, normal: DVec3) -> PathVertex {
        PathVertex { from: vector(self.mesh.grid().lifted(position, normal)), normal }
    }

    /// Adds the directly seen sky. Its rays cost little, and go through one cell each of the square
    /// that cosine-weighted directions come from. Sums are scaled to `each` paths.
    fn add_open_sky(&self, here: PathVertex, skies: &[&ReferenceSky], each: usize, seed: u64, sums: &mut Sums) {
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
            // Irradiance is pi times the mean radiance of cosine-weighted directions.
            let straight = Carried::START.times(PI * each as f64 / (side * side) as f64);
            for (number, through) in self.open(&rays) {
                let Some(place) = SkyPlace::new(directions[number]) else { continue };
                for (sky, sums) in skies.iter().zip(sums.iter_mut()) {
                    straight.through(through).add(false, sky.radiance(place), &mut sums[batch]);
                }
            }
        }
    }

    /// Handles a path at a surface: queries the sun, and goes on unless the path ends there.
    fn meet(&self, mut walker: Walker, hit: Hit, skies: &[&ReferenceSky], looks: &mut Vec<SunLook>) -> Option<Walker> {
        let (place, orientation) = self.vertex(walker.from, walker.direction, hit);
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
        // The path goes on as mirrored or as matt light in proportion to the two reflectances, so
        // its weight is their sum in either case.
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
        let leaves = self.canopies?.leaves(passage, |_| walker.random.next());
        if leaves.is_empty() || self.once && walker.carried.matt > 0 {
            return None;
        }
        let [which, on, side, a, b] = walker.random.many();
        let leaf = &leaves[(which * leaves.len() as f64) as usize];
        let through = leaf.before.iter().map(|&(material, amount)| self.left(material, amount)).product::<f64>();
        // Each leaf is drawn with a probability of one over their number.
        let of_one = self.reflectors[usize::from(leaf.material)].diffuse * leaf.weight;
        let scattered = of_one * through * leaves.len() as f64;
        let likely = if walker.met < SURE { 1.0 } else { scattered.min(LIKELIEST) };
        if scattered <= 0.0 || on >= likely {
            return None;
        }
        let carried = walker.carried.times(scattered / likely).scattered();
        // A number holds 53 random bits, and all of them become the seed.
        let mut random = Random::new((walker.random.next() * 2.0_f64.powi(53)) as u64);
        // Leaves of a volume face all ways alike.
        let normal = leaf.normal.unwrap_or_else(|| direction_of(DVec2::from(random.many::<2>())));
        let places = [normal, -normal]
            .map(|normal| PathVertex { from: vector(self.mesh.grid().lifted(leaf.point, normal)), normal });
        let disc = random.many();
        for place in places {
            // Half of the scattered light leaves on each side.
            looks.extend(SunLook::at_all(place, walker.batch, carried.times(0.5), skies, disc, &mut random));
        }
        let PathVertex { from, normal } = places[usize::from(side < 0.5)];
        let direction = cosine(&Frame::new(normal), [a, b]);
        Some(Walker { batch: walker.batch, from, direction, carried, met: walker.met + 1, random })
    }
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
