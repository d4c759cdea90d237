//! Light by way of mirrors. In: rays whose first hit is a mirror, or an observer. Out: the surfaces
//! behind up to three mirrors, and the parts of the sky whose light comes by each chain of mirrors.
//!
//! A chain maps directions of the sky to directions of the observer ([`Chain::seen_from`]). Its
//! texture is one of the sky's texels, like the sky texture: a texel is 1 if the ray in the
//! direction that it maps to hits the chain's mirrors, one after the other, and leaves in the
//! texel's own direction.

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};

use crate::trace::kernel::ray::{Hit, Ray};
use crate::trace::kernel::rays::Tracer;
use crate::trace::probe::lifted;
use crate::trace::surface::cell_of;
use crate::trace::viewpoint::Viewpoint;
use heliotile_core::hemisphere::{Frame, HEMISPHERE_SR, jitter, mix, texel_direction, texel_of, texels_in_blocks};
use heliotile_core::layers::bits::BitSquare;
use heliotile_core::site::cells::CellKey;
use heliotile_core::site::chain::{Chain, MAX_MIRRORS, MirrorPlane, MirrorStep};
use heliotile_scene::mesh::Mesh;
use heliotile_scene::mirrors::Mirrors;

/// Scene with mirrors, ready for rays.
pub struct Reflections<'a> {
    mesh: &'a Mesh,
    tracer: &'a Tracer,
    mirrors: &'a Mirrors,
    /// Triangles that are mirrors.
    triangles: Vec<u32>,
    /// Tracer of the mirrors alone. Most rays miss them, and it finds that out fast.
    alone: Tracer,
}

/// Surface behind mirrors.
#[derive(Clone, Debug)]
pub struct ReflectedHit {
    /// Start of the last segment of the path; `direction` and `hit` are its direction and end.
    pub from: DVec3,
    pub direction: DVec3,
    pub hit: Hit,
    /// Length of the whole path, metres.
    pub length_m: f64,
    /// Mirrors on the path before the surface.
    pub steps: Vec<MirrorStep>,
}

/// End of a path by way of mirrors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// The path reaches the sky in this direction, above the horizon.
    Sky(Chain, DVec3),
    /// The path ends at a surface that is no mirror, or below the horizon.
    Dark,
    /// The path ends at one more mirror than is followed.
    Cut,
}

/// Ray and the mirror that it hits.
#[derive(Clone, Copy, Debug)]
pub struct MirrorRay {
    pub from: DVec3,
    pub direction: DVec3,
    pub hit: Hit,
}

/// Query for one direction of the sky from a point, by one of some chains.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    pub chain: usize,
    pub sky: DVec3,
    pub origin: [f32; 3],
    pub normal: DVec3,
}

/// Ray on its path by way of mirrors.
struct Way {
    at: MirrorRay,
    chain: Chain,
    steps: Vec<MirrorStep>,
    length_m: f64,
}

impl<'a> Reflections<'a> {
    pub fn new(mesh: &'a Mesh, tracer: &'a Tracer, mirrors: &'a Mirrors) -> Self {
        let triangles: Vec<u32> = mirrors.triangles().collect();
        let alone = Tracer::of_triangles(mesh, &triangles);
        Reflections { mesh, tracer, mirrors, triangles, alone }
    }

    pub fn orientations(&self) -> &[MirrorPlane] {
        &self.mirrors.orientations
    }

    /// Returns the number of the orientation of the mirror that was hit, or `None` if it is no
    /// mirror.
    pub fn orientation(&self, hit: Hit) -> Option<u16> {
        self.mirrors.of_triangle(hit.triangle)
    }

    /// Returns the cell of this level that holds a surface behind mirrors.
    pub fn cell(&self, met: &ReflectedHit, level: i8) -> CellKey {
        cell_of(met.hit, met.direction, level, self.mesh, met.from)
    }

    /// Returns the origin of rays from a surface point (input coordinates).
    pub fn origin(&self, position: DVec3, normal: DVec3) -> [f32; 3] {
        lifted(position, normal, self.tracer)
    }

    /// Returns for each ray true if it would hit a mirror if there were nothing else.
    pub fn towards_mirrors(&self, rays: &[Ray]) -> Vec<bool> {
        self.alone.occluded_many(rays)
    }

    /// Returns the rays whose first hit is a mirror, with that hit.
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

    /// Follows rays that hit a mirror, past [`MAX_MIRRORS`] mirrors at most. Returns the surfaces
    /// that each hits and its end; `rays` counts the rays cast.
    pub fn follow(&self, starts: &[MirrorRay], rays: &mut u64) -> Vec<(Vec<ReflectedHit>, End)> {
        let mut done: Vec<(Vec<ReflectedHit>, End)> = starts.iter().map(|_| (Vec::new(), End::Dark)).collect();
        let start =
            |at: MirrorRay| Way { at, chain: Chain::default(), steps: Vec::new(), length_m: f64::from(at.hit.t) };
        let mut ways: Vec<(usize, Way)> = starts.iter().map(|&at| start(at)).enumerate().collect();
        for _ in 0..=MAX_MIRRORS {
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
            // Rays of all paths go together after each reflection, to fill packets.
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
                done[i].0.push(ReflectedHit { from, direction, hit, length_m: way.length_m, steps: way.steps.clone() });
                ways.push((i, way));
            }
        }
        done
    }

    /// Returns the start and the direction of a ray that a mirror reflects.
    fn reflected(&self, at: MirrorRay, orientation: MirrorPlane) -> (DVec3, DVec3) {
        let triangle = at.hit.triangle as usize;
        let outward = self.mesh.normal(triangle);
        let facing = if outward.dot(at.direction) > 0.0 { -outward } else { outward };
        // Distances have a relative error of some 1e-6, which may exceed the offset of a ray's
        // origin, so the point is moved onto the plane of the mirror.
        let way = at.direction * f64::from(at.hit.t);
        let [corner, ..] = self.mesh.triangle_points(triangle);
        let way = way - outward * (way - (corner - at.from)).dot(outward);
        let from = lifted(self.mesh.grid().absolute(at.from) + way, facing, self.tracer);
        let from = DVec3::from(from.map(f64::from));
        (from, orientation.reflect(at.direction).normalize())
    }

    /// Returns for each query true if light from its direction of the sky reaches its point by its
    /// chain. `chains` are given with their maps; `rays` counts the rays cast.
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
        for passed in 0..=MAX_MIRRORS {
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

    /// Returns [`Chain::seen_from`] of a chain that was followed, so its orientations exist.
    pub fn seen_from(&self, chain: &Chain) -> DMat3 {
        chain.numbers().fold(DMat3::IDENTITY, |map, number| map * self.mirrors.orientations[usize::from(number)].map())
    }

    /// Returns the chains by which some rays reach the sky, with the texels of an n x n sky that
    /// they reach and the texels around them.
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

    /// Returns rays from a viewpoint to those parts of its hemisphere where mirrors may be if
    /// nothing hides them. A texel of an n x n texture gets `finer` x `finer` rays if a corner or
    /// the centre of a mirror's triangle lies in it, or if a ray in it or beside it hits a mirror.
    /// `rays` counts the rays cast.
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
        let (from, frame) = (DVec3::from(origin.map(f64::from)), Frame::new(view.normal));
        // A quarter of the spacing of the rays. Much narrower mirrors are hit by chance only.
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

    /// Returns rays over an n x n texture of the hemisphere of a surface, one per texel.
    /// `point(texel)` gives position and normal.
    pub fn around(&self, n: usize, seed: u64, point: impl Fn(usize) -> (DVec3, DVec3)) -> Vec<(DVec3, Ray)> {
        let texel = |(column, row): (usize, usize)| {
            let t = row * n + column;
            let (position, normal) = point(t);
            let inside = jitter(mix(seed, 0x6d69_7272), t as u64);
            let direction = Frame::new(normal).to_world(texel_direction(column, row, n, inside));
            let origin = lifted(position, normal, self.tracer);
            (direction, Ray { origin, direction: direction.as_vec3().to_array() })
        };
        texels_in_blocks(n).map(texel).collect()
    }
}

fn ray(from: DVec3, direction: DVec3) -> Ray {
    Ray { origin: from.as_vec3().to_array(), direction: direction.as_vec3().to_array() }
}
