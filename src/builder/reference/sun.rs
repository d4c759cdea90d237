//! Sun at places on surfaces, seen directly or by chains of mirrors. In: places, points of suns.
//! Out: additions to a receiver's components.

use glam::DVec3;

use super::carried::Carried;
use super::random::Random;
use super::sky::ReferenceSky;
use super::tracer::{PathTracer, PathVertex, Sums, ray};
use crate::trace::Ray;
use crate::trace::kernel::ray::Hit;
use heliotile_core::hemisphere::mix;
use heliotile_core::light::fresnel::specular;
use heliotile_core::site::chain::{MAX_MIRRORS, MirrorPlane};

/// Query of a place for a point of the sun.
#[derive(Clone, Copy, Debug)]
pub(super) struct SunLook {
    place: PathVertex,
    /// Direction to the point.
    sun: DVec3,
    /// Throughput for a cosine of 1, as irradiance of the receiver, W/m2.
    carried: Carried,
    sky: usize,
    batch: usize,
    /// Seed that draws chains of mirrors if not all are followed.
    seed: u64,
}

/// Largest number of chains for which a place follows all. If there are more, [`DRAWN`] of each
/// length are drawn.
const ALL_CHAINS: usize = 96;
const DRAWN: usize = 16;

/// Query along a chain of mirrors.
struct Way<'l> {
    look: &'l SunLook,
    chain: Vec<u16>,
    from: DVec3,
    direction: DVec3,
    carried: Carried,
}

impl SunLook {
    /// Returns queries for a point of the sun of each sky, at the same place of its disc. `carried`
    /// is for a DNI of 1 W/m2.
    pub fn at_all(
        place: PathVertex,
        batch: usize,
        carried: Carried,
        skies: &[&ReferenceSky],
        which: [f64; 3],
        random: &mut Random,
    ) -> Vec<SunLook> {
        let look = |(sky, of): (usize, &&ReferenceSky)| {
            let sun = of.sun(which, random)?;
            let seed = (random.next() * 2.0_f64.powi(53)) as u64;
            Some(SunLook { place, sun, carried: carried.times(of.dni_w_m2), sky, batch, seed })
        };
        skies.iter().enumerate().filter_map(look).collect()
    }

    fn add(&self, carried: Carried, sums: &mut Sums) {
        carried.add(true, 1.0, &mut sums[self.sky][self.batch]);
    }
}

impl PathTracer<'_> {
    /// Adds the light of the sun, direct and by mirrors.
    pub(super) fn add_suns(&self, looks: &[SunLook], sums: &mut Sums) {
        let straight: Vec<(&SunLook, f64)> =
            looks.iter().map(|look| (look, look.place.normal.dot(look.sun))).filter(|(_, cos)| *cos > 0.0).collect();
        let rays: Vec<Ray> = straight.iter().map(|(look, _)| ray(look.place.from, look.sun)).collect();
        for (place, through) in self.open(&rays) {
            let (look, cos) = straight[place];
            look.add(look.carried.times(cos).through(through), sums);
        }
        if let Some(mirrors) = self.mirrors {
            self.add_mirrored(looks, &mirrors.orientations, sums);
        }
    }

    fn add_mirrored(&self, looks: &[SunLook], orientations: &[MirrorPlane], sums: &mut Sums) {
        let mut ways: Vec<Way> = looks.iter().flat_map(|look| ways(look, orientations)).collect();
        for passed in 0..=MAX_MIRRORS {
            let (on, out): (Vec<Way>, Vec<Way>) = ways.into_iter().partition(|way| way.chain.len() > passed);
            let rays = |ways: &[Way]| -> Vec<Ray> { ways.iter().map(|way| ray(way.from, way.direction)).collect() };
            for (place, through) in
                self.open(&rays(&out)).into_iter().filter(|(place, _)| out[*place].direction.z > 0.0)
            {
                out[place].look.add(out[place].carried.through(through), sums);
            }
            let cast = rays(&on);
            let hits = self.tracer.closest_many(&cast);
            let reaches = hits.iter().map(|hit| hit.map_or(0.0, |hit| hit.t));
            let through = self.through(cast.into_iter().zip(reaches));
            let next = on.into_iter().zip(hits).zip(through);
            ways = next.filter_map(|((way, hit), through)| self.follow(way, hit?, passed, through)).collect();
        }
    }

    /// Follows a ray past its next mirror; `None` if the ray does not hit that mirror.
    fn follow<'l>(&self, mut way: Way<'l>, hit: Hit, passed: usize, through: f64) -> Option<Way<'l>> {
        let (_, orientation) = self.orientation(hit).filter(|(number, _)| way.chain.get(passed) == Some(number))?;
        let (place, _) = self.vertex(way.from, way.direction, hit);
        let cos = orientation.normal.dot(way.direction).abs();
        let reflected = specular(&self.reflectors[usize::from(orientation.material)], cos);
        way.carried = way.carried.through(through).times(reflected).mirrored();
        (way.from, way.direction) = (place.from, orientation.reflect(way.direction).normalize());
        Some(way)
    }
}

/// Returns queries along chains of mirrors, in the directions in which the sun would appear in
/// them.
fn ways<'l>(look: &'l SunLook, orientations: &[MirrorPlane]) -> Vec<Way<'l>> {
    let count = orientations.len();
    let of_length = |length: usize| count.saturating_pow(length as u32);
    let all = (1..=MAX_MIRRORS).map(of_length).fold(0, usize::saturating_add) <= ALL_CHAINS;
    let way = move |(chain, weight): (Vec<u16>, f64)| {
        let reflect = |d: DVec3, number: &u16| orientations[usize::from(*number)].reflect(d);
        let direction = chain.iter().rev().fold(look.sun, reflect);
        let cos = look.place.normal.dot(direction);
        let carried = look.carried.times(cos * weight);
        (cos > 0.0).then_some(Way { look, chain, from: look.place.from, direction, carried })
    };
    let chains = (1..=MAX_MIRRORS).flat_map(move |length| {
        let there = of_length(length);
        let drawn = if all { there } else { there.min(DRAWN) };
        let chain = move |i: usize| {
            let number = if drawn == there { i as u64 } else { mix(look.seed, (length * DRAWN + i) as u64) };
            // A chain is a number in base `count`, with a digit for each mirror.
            let digit = |place: usize| (number / (count as u64).pow(place as u32) % count as u64) as u16;
            ((0..length).map(digit).collect(), there as f64 / drawn as f64)
        };
        (0..drawn).map(chain)
    });
    chains.filter_map(way).collect()
}
