//! Light by way of mirrors. In: rays whose first hit is a mirror, or a observer. Out: what lies behind up to three mirrors, and through
//! which parts of the sky light comes by which chain of them.
//!
//! A chain maps directions of the sky to directions of the observer ([`Chain::seen_from`]), so its texture is one of the sky's
//! texels, as the sky texture is: a texel is 1 if the ray in the direction that it maps to meets the chain's mirrors, one after
//! the other, and leaves in the texel's own direction.

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};

use crate::trace::kernel::rays::{Hit, Ray, Tracer};
use crate::trace::probe::lifted;
use crate::trace::receiver::Viewpoint;
use crate::trace::surroundings::cell_of;
use heliotile_core::hemisphere::{Frame, HEMISPHERE_SR, jitter, mix, texel_direction, texel_of, texels_in_blocks};
use heliotile_core::layers::bits::BitSquare;
use heliotile_core::site::cells::CellKey;
use heliotile_core::site::chain::{Chain, MOST_MIRRORS, MirrorPlane, MirrorStep};
use heliotile_scene::mesh::Mesh;
use heliotile_scene::mirrors::Mirrors;

/// A scene with mirrors, ready for rays.
pub struct Reflections<'a> {
    mesh: &'a Mesh,
    tracer: &'a Tracer,
    mirrors: &'a Mirrors,
    /// Triangles that are mirrors.
    triangles: Vec<u32>,
    /// The mirrors alone: most rays miss them, and are soon done with.
    alone: Tracer,
}

/// A surface behind mirrors.
#[derive(Clone, Debug)]
pub struct Met {
    /// The last part of the way: where it starts, its direction and what it meets.
    pub from: DVec3,
    pub direction: DVec3,
    pub hit: Hit,
    /// Length of the whole way, metres.
    pub length_m: f64,
    /// The mirrors before it.
    pub steps: Vec<MirrorStep>,
}

/// How a way by mirrors ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// In this direction, above the horizon.
    Sky(Chain, DVec3),
    /// At a surface that is no mirror, or nowhere.
    Dark,
    /// At one more mirror than is followed.
    Cut,
}

/// A ray and the mirror that it meets.
#[derive(Clone, Copy, Debug)]
pub struct MirrorRay {
    pub from: DVec3,
    pub direction: DVec3,
    pub hit: Hit,
}

/// A direction of the sky that is looked for from a point, by one of some chains.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    pub chain: usize,
    pub sky: DVec3,
    pub origin: [f32; 3],
    pub normal: DVec3,
}

/// One ray on its way.
struct Way {
    at: MirrorRay,
    chain: Chain,
    steps: Vec<MirrorStep>,
    length_m: f64,
}

impl<'a> Reflections<'a> {
    pub fn new(mesh: &'a Mesh, tracer: &'a Tracer, mirrors: &'a Mirrors) -> Self {
        let triangles: Vec<u32> = mirrors.triangles().collect();
        let alone = Tracer::of(mesh, &triangles);
        Reflections { mesh, tracer, mirrors, triangles, alone }
    }

    pub fn orientations(&self) -> &[MirrorPlane] {
        &self.mirrors.orientations
    }

    /// Number of the orientation that a hit lies on.
    pub fn orientation(&self, hit: Hit) -> Option<u16> {
        self.mirrors.of_triangle(hit.triangle)
    }

    /// The cell of this level that a surface behind mirrors lies in.
    pub fn cell(&self, met: &Met, level: i8) -> CellKey {
        cell_of(met.hit, met.direction, level, self.mesh, met.from)
    }

    /// Where rays of a surface point (input coordinates) start.
    pub fn origin(&self, position: DVec3, normal: DVec3) -> [f32; 3] {
        lifted(position, normal, self.tracer)
    }

    /// Which of some rays would meet a mirror, were there nothing else.
    pub fn towards_mirrors(&self, rays: &[Ray]) -> Vec<bool> {
        self.alone.occluded_many(rays)
    }

    /// Which of some rays meet a mirror first, and where.
    pub fn starts(&self, rays: &[(DVec3, Ray)]) -> Vec<(usize, MirrorRay)> {
        let cast: Vec<Ray> = rays.iter().map(|r| r.1).collect();
        let near: Vec<usize> =
            self.alone.occluded_many(&cast).into_iter().enumerate().filter(|m| m.1).map(|m| m.0).collect();
        let cast: Vec<Ray> = near.iter().map(|&i| cast[i]).collect();
        let hits = self.tracer.closest_many(&cast).into_iter().zip(near);
        hits.filter_map(|(hit, i)| {
            let hit = hit.filter(|&hit| self.orientation(hit).is_some())?;
            let (direction, from) = (rays[i].0, DVec3::from(rays[i].1.origin.map(f64::from)));
            Some((i, MirrorRay { from, direction, hit }))
        })
        .collect()
    }

    /// Follows rays that met a mirror, [`MOST_MIRRORS`] of them at most: the surfaces that each meets and how it ends. `rays` counts.
    pub fn follow(&self, starts: &[MirrorRay], rays: &mut u64) -> Vec<(Vec<Met>, End)> {
        let mut done: Vec<(Vec<Met>, End)> = starts.iter().map(|_| (Vec::new(), End::Dark)).collect();
        let start =
            |at: MirrorRay| Way { at, chain: Chain::default(), steps: Vec::new(), length_m: f64::from(at.hit.t) };
        let mut ways: Vec<(usize, Way)> = starts.iter().map(|&at| start(at)).enumerate().collect();
        for _ in 0..=MOST_MIRRORS {
            let mut next: Vec<(usize, Way)> = Vec::with_capacity(ways.len());
            for (i, mut way) in ways {
                let Some(number) = self.orientation(way.at.hit) else { continue };
                let Some(chain) = way.chain.then(number) else {
                    done[i].1 = End::Cut;
                    continue;
                };
                let (at, orientation) = (way.at, self.mirrors.orientations[usize::from(number)]);
                let cos = orientation.normal.dot(at.direction).abs().min(1.0);
                way.steps.push((orientation.material, (cos * 255.0).round() as u8));
                let (from, direction) = self.reflected(at, orientation);
                way.at = MirrorRay { from, direction, hit: at.hit };
                way.chain = chain;
                next.push((i, way));
            }
            let cast: Vec<Ray> = next.iter().map(|(_, way)| ray(way.at.from, way.at.direction)).collect();
            *rays += cast.len() as u64;
            let hits = self.tracer.closest_many(&cast);
            ways = Vec::with_capacity(next.len());
            for ((i, mut way), hit) in next.into_iter().zip(hits) {
                let Some(hit) = hit else {
                    let up = way.at.direction.z > 0.0;
                    done[i].1 = if up { End::Sky(way.chain, way.at.direction) } else { End::Dark };
                    continue;
                };
                way.length_m += f64::from(hit.t);
                way.at.hit = hit;
                let MirrorRay { from, direction, .. } = way.at;
                done[i].0.push(Met { from, direction, hit, length_m: way.length_m, steps: way.steps.clone() });
                ways.push((i, way));
            }
        }
        done
    }

    /// Where a ray goes from a mirror, and in which direction.
    fn reflected(&self, at: MirrorRay, orientation: MirrorPlane) -> (DVec3, DVec3) {
        let triangle = at.hit.triangle as usize;
        let outward = self.mesh.normal(triangle);
        let facing = if outward.dot(at.direction) > 0.0 { -outward } else { outward };
        // Distances are known to some 1e-6 of themselves, which may be more than a ray's origin is lifted by: the point is put on the
        // plane of the mirror.
        let way = at.direction * f64::from(at.hit.t);
        let [corner, ..] = self.mesh.triangle_points(triangle);
        let way = way - outward * (way - (corner - at.from)).dot(outward);
        let from = lifted(self.mesh.grid().absolute(at.from) + way, facing, self.tracer);
        let from = DVec3::from(from.map(f64::from));
        (from, orientation.reflect(at.direction).normalize())
    }

    /// Whether light from directions of the sky reaches points by chains, each with its map. `rays` counts.
    pub fn lit(&self, chains: &[(Chain, DMat3)], looks: &[Look], rays: &mut u64) -> Vec<bool> {
        let mut lit = vec![false; looks.len()];
        let mut ways: Vec<(usize, MirrorRay)> = Vec::with_capacity(looks.len());
        for (i, look) in looks.iter().enumerate() {
            let direction = (chains[look.chain].1 * look.sky).normalize();
            if look.normal.dot(direction) > 0.0 {
                let from = DVec3::from(look.origin.map(f64::from));
                ways.push((i, MirrorRay { from, direction, hit: Hit { t: 0.0, triangle: 0 } }));
            }
        }
        let cast = |ways: &[(usize, MirrorRay)], rays: &mut u64| -> Vec<Ray> {
            *rays += ways.len() as u64;
            ways.iter().map(|(_, at)| ray(at.from, at.direction)).collect()
        };
        for passed in 0..=MOST_MIRRORS {
            // Rays of many short chains go together, or packets would be nearly empty.
            let next = |i: usize| chains[looks[i].chain].0.numbers().nth(passed);
            let (on, out): (Vec<_>, Vec<_>) = ways.into_iter().partition(|(i, _)| next(*i).is_some());
            let met = self.tracer.occluded_many(&cast(&out, rays));
            for ((i, at), met) in out.into_iter().zip(met) {
                lit[i] = !met && at.direction.z > 0.0;
            }
            let hits = self.tracer.closest_many(&cast(&on, rays)).into_iter().zip(on);
            ways = hits
                .filter_map(|(hit, (i, at))| {
                    let hit = hit.filter(|&hit| self.orientation(hit) == next(i))?;
                    let orientation = self.mirrors.orientations[usize::from(next(i)?)];
                    let (from, direction) = self.reflected(MirrorRay { hit, ..at }, orientation);
                    Some((i, MirrorRay { from, direction, hit }))
                })
                .collect();
        }
        lit
    }

    /// [`Chain::seen_from`] of a chain that was followed, whose orientations exist.
    pub fn seen_from(&self, chain: &Chain) -> DMat3 {
        chain.numbers().fold(DMat3::IDENTITY, |map, number| map * self.mirrors.orientations[usize::from(number)].map())
    }

    /// The chains by which some rays reach the sky, and the texels of an n x n sky that they reach, with those around them.
    pub fn reached(&self, rays: &[(DVec3, Ray)], n: usize, count: &mut u64) -> BTreeMap<Chain, Vec<(u32, u32)>> {
        *count += rays.len() as u64;
        let starts: Vec<MirrorRay> = self.starts(rays).into_iter().map(|s| s.1).collect();
        let mut found: BTreeMap<Chain, Vec<(u32, u32)>> = BTreeMap::new();
        for (_, end) in self.follow(&starts, count) {
            let End::Sky(chain, direction) = end else { continue };
            let (column, row) = texel_of(direction, n);
            let around = |at: usize| (at.saturating_sub(1)..=(at + 1).min(n - 1)).map(|x| x as u32);
            let texels = around(row).flat_map(|r| around(column).map(move |c| (c, r)));
            found.entry(chain).or_default().extend(texels);
        }
        for texels in found.values_mut() {
            texels.sort_unstable_by_key(|t| (t.1, t.0));
            texels.dedup();
        }
        found
    }

    /// Rays from a point to those parts of its hemisphere where mirrors may be, were there nothing else: `finer` x `finer` rays in each of those texels of
    /// an n x n texture in which a corner or the middle of a mirror's triangle lies, or in or beside which a ray meets a mirror. `rays` counts.
    pub fn around_mirrors(&self, n: usize, finer: usize, view: &Viewpoint, rays: &mut u64) -> Vec<(DVec3, Ray)> {
        let mut near = BitSquare::new(n);
        let mut mark = |column: usize, row: usize, far: usize| {
            let around = |at: usize| at.saturating_sub(far)..(at + far + 1).min(n);
            around(row).for_each(|r| around(column).for_each(|c| near.set(c, r, true)));
        };
        let coarse = self.around(n, view.seed(), |_| (view.position, view.normal));
        *rays += coarse.len() as u64;
        let cast: Vec<Ray> = coarse.iter().map(|ray| ray.1).collect();
        let meets = self.towards_mirrors(&cast);
        for ((column, row), _) in texels_in_blocks(n).zip(meets).filter(|(_, meets)| *meets) {
            mark(column, row, 1);
        }
        let origin = view.origin(self.tracer);
        let (from, frame) = (DVec3::from(origin.map(f64::from)), Frame::of(view.normal));
        // Rays are this far from each other; what is much narrower is met by chance only.
        let narrow = HEMISPHERE_SR.sqrt() / (n * finer) as f64 / 4.0;
        for triangle in &self.triangles {
            let corners = self.mesh.triangle_points(*triangle as usize).map(|corner| corner - from);
            let [a, b, c] = corners;
            let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
            if longest < narrow * narrow * a.length_squared() {
                continue;
            }
            for point in [a, b, c, (a + b + c) / 3.0] {
                let local = frame.to_local(point.normalize_or_zero());
                if local.z > 0.0 {
                    let (column, row) = texel_of(local, n);
                    mark(column, row, 0);
                }
            }
        }
        let seed = mix(view.seed(), 0x6669_6e65);
        let part = |(column, row): (u32, u32), i: usize| {
            let (c, r) = (column as usize * finer + i % finer, row as usize * finer + i / finer);
            let inside = jitter(seed, (r * n * finer + c) as u64);
            let direction = frame.to_world(texel_direction(c, r, n * finer, inside));
            (direction, Ray { origin, direction: direction.as_vec3().to_array() })
        };
        near.ones().flat_map(|texel| (0..finer * finer).map(move |i| part(texel, i))).collect()
    }

    /// Rays from points over an n x n texture of their surface's hemisphere, one a texel; `point(texel)` gives place and normal.
    pub fn around(&self, n: usize, seed: u64, point: impl Fn(usize) -> (DVec3, DVec3)) -> Vec<(DVec3, Ray)> {
        let texel = |(column, row): (usize, usize)| {
            let t = row * n + column;
            let (position, normal) = point(t);
            let inside = jitter(mix(seed, 0x6d69_7272), t as u64);
            let direction = Frame::of(normal).to_world(texel_direction(column, row, n, inside));
            let origin = lifted(position, normal, self.tracer);
            (direction, Ray { origin, direction: direction.as_vec3().to_array() })
        };
        texels_in_blocks(n).map(texel).collect()
    }
}

fn ray(from: DVec3, direction: DVec3) -> Ray {
    Ray { origin: from.as_vec3().to_array(), direction: direction.as_vec3().to_array() }
}
