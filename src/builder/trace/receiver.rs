//! Sky and surroundings of one receiver. In: a viewpoint. Out: sky bits where they are asked for,
//! and the cell that each texel of its own hemisphere hits.

use std::cell::RefCell;

use glam::DVec3;

use crate::trace::change::{ChangeInView, KnownSky};
use crate::trace::hidden::meets_inside;
use crate::trace::kernel::ray::Ray;
use crate::trace::kernel::rays::Tracer;
use crate::trace::kernel::scan::{Question, ScanSpace};
use crate::trace::mirror::{MirrorRay, Reflections};
use crate::trace::sky_fans::{Part, SkyFans};
use crate::trace::surface::cell_of;
use crate::trace::viewpoint::Viewpoint;
use heliotile_core::hemisphere::{Frame, ray_direction, texels_in_blocks};
use heliotile_core::layers::bits::BitSquare;
use heliotile_core::layers::sky::SkyTexture;
use heliotile_core::layers::texel_block::TexelBlock;
use heliotile_core::site::cells::{CellKey, level_of};
use heliotile_scene::mesh::Mesh;

/// Sizes of the cells that hits are gathered into.
#[derive(Clone, Copy, Debug)]
pub struct CellSettings {
    /// Edge of a cell in units of the hit texel's footprint; 0 gives every hit a cell of its own
    /// (about 1 mm).
    pub factor: f64,
    /// Smallest edge of a cell, metres.
    pub floor_m: f64,
}

impl CellSettings {
    /// Returns the level of the cell of a hit at this distance, for texels of the hit texture that
    /// are `texel_angle` wide.
    pub fn level(&self, distance_m: f64, texel_angle: f64) -> i8 {
        let size = (self.factor * distance_m * texel_angle).max(self.floor_m);
        if self.factor > 0.0 { level_of(size) } else { PRIVATE_LEVEL }
    }
}

/// Level of a cell that holds only its own hit: 2^-10 m.
const PRIVATE_LEVEL: i8 = -10;

/// Traced sky of one receiver.
#[derive(Clone, Debug)]
pub struct SkyTrace {
    /// Sky texture, world frame.
    pub texture: SkyTexture,
    /// Bits that the texture encodes, as fine as it is refined.
    pub bits: BitSquare,
    /// Number of rays cast.
    pub rays: u64,
}

/// Traced hits of one receiver.
#[derive(Clone, Debug)]
pub struct HitTrace {
    /// Cells of the hits, n x n, row-major, surface frame; `None` if the ray hit nothing.
    pub cells: Vec<Option<CellKey>>,
    /// Distance of the nearest surface, metres.
    pub nearest_m: f64,
    /// Texels whose ray hits a mirror.
    pub mirrors: Vec<(usize, MirrorRay)>,
    /// `[texel]`: distance of the hit, metres; infinite if there is none.
    pub distances_m: Vec<f32>,
}

thread_local! {
    /// Memory of a thread, reused for its receivers.
    static SPACE: RefCell<Box<ScanSpace>> = RefCell::default();
}

impl Viewpoint {
    /// Traces the sky. Texels whose centre lies behind the surface are traced along the surface.
    pub fn sky(&self, fans: &SkyFans, tracer: &Tracer) -> SkyTrace {
        self.sky_after(fans, tracer, None)
    }

    /// Traces the sky as [`Viewpoint::sky`] does. If answers from before a change are known, only
    /// rays that they do not answer are cast.
    pub(crate) fn sky_after(&self, fans: &SkyFans, tracer: &Tracer, known: Option<KnownSky>) -> SkyTrace {
        let origin = self.origin(tracer);
        let (mut space, mut rays, parts) = (SPACE.take(), 0, fans.parts(self.normal));
        let mut scan = tracer.scan(origin, parts.len(), &mut space);
        let mut cast = |n: usize, blocks: &mut [TexelBlock]| {
            rays += blocks.iter().map(|block| u64::from(block.wanted.count_ones())).sum::<u64>();
            let bent = fans.bent(n, blocks, self.normal, &parts);
            let mut questions = fans.questions(n, blocks, self.normal, &parts, &bent);
            scan.answer(&mut questions);
            let (mut alone, mut places) = (Vec::new(), Vec::new());
            // Blocks without an answer from the scan are traced ray by ray.
            for (place, (block, question)) in blocks.iter_mut().zip(&questions).enumerate() {
                match question.met {
                    Some(met) => block.ones = block.wanted & !met,
                    None => {
                        let ray = |bit| Ray { origin, direction: question.fan.direction(bit as usize) };
                        alone.extend(block.bits().map(ray));
                        places.extend(block.bits().map(|bit| (place, bit)));
                    }
                }
            }
            for ((place, bit), met) in places.into_iter().zip(tracer.occluded_many(&alone)) {
                blocks[place].ones |= u16::from(!met) << bit;
            }
        };
        let (texture, bits) = SkyTexture::trace(fans.front(self.normal), fans.fine(), |n, blocks| {
            let Some(known) = &known else { return cast(n, blocks) };
            let mut left = self.unanswered(n, blocks, known, fans, &parts, origin);
            cast(n, &mut left);
            let mut left = left.into_iter().peekable();
            for block in blocks {
                if let Some(cast) = left.next_if(|cast| cast.lies_at(block)) {
                    block.ones = block.ones & !cast.wanted | cast.ones;
                }
            }
        });
        SPACE.set(space);
        SkyTrace { texture, bits, rays }
    }

    /// Fills in the known answers of some blocks, and returns the texels that remain: those never
    /// asked before, and those whose rays meet the change.
    fn unanswered(
        &self,
        n: usize,
        blocks: &mut [TexelBlock],
        known: &KnownSky,
        fans: &SkyFans,
        parts: &[Part],
        origin: [f32; 3],
    ) -> Vec<TexelBlock> {
        let part = fans.part(n);
        // Sides double from level to level, so the logarithm numbers the levels.
        let Some(answers) = known.answers.get((n / fans.base()).ilog2() as usize) else { return blocks.to_vec() };
        let asked = |block: &TexelBlock| TexelBlock { wanted: block.wanted & answers.of(block).0, ones: 0, ..*block };
        // Only parts of the sky towards the change can hold answers that it alters.
        let touched = blocks.iter().filter(|block| known.touched[part(block)]);
        let mut doubted: Vec<TexelBlock> = touched.map(asked).filter(|block| block.wanted != 0).collect();
        let bent = fans.bent(n, &doubted, self.normal, parts);
        let questions = fans.questions(n, &doubted, self.normal, parts, &bent);
        let ray = |question: &Question, bit: u32| Ray { origin, direction: question.fan.direction(bit as usize) };
        let rays: Vec<Ray> = doubted
            .iter()
            .zip(&questions)
            .flat_map(|(block, question)| block.bits().map(move |bit| ray(question, bit)))
            .collect();
        let mut met = known.change.met(&rays).into_iter();
        for block in &mut doubted {
            block.ones = block.bits().zip(&mut met).fold(0, |ones, (bit, met)| ones | u16::from(met) << bit);
        }
        let mut doubted = doubted.into_iter().peekable();
        let left = |block: &mut TexelBlock| {
            let (asked, ones) = answers.of(block);
            let altered = doubted.next_if(|doubted| doubted.lies_at(block)).map_or(0, |doubted| doubted.ones);
            block.ones = ones & block.wanted;
            let wanted = block.wanted & (!asked | altered);
            (wanted != 0).then_some(TexelBlock { wanted, ones: 0, ..*block })
        };
        blocks.iter_mut().filter_map(left).collect()
    }

    /// Traces the closest hits over the n x n texture of the surface's own hemisphere, one jittered
    /// ray per texel.
    pub fn hits(
        &self,
        n: usize,
        cells: CellSettings,
        mesh: &Mesh,
        tracer: &Tracer,
        reflections: Option<&Reflections>,
    ) -> HitTrace {
        let origin = self.origin(tracer);
        let lifted_position = DVec3::from(origin.map(f64::from));
        let texel_angle = (heliotile_core::hemisphere::HEMISPHERE_SR / (n * n) as f64).sqrt();
        let direction = self.hit_directions(n);
        // Neighbouring texels go together, since their rays make coherent packets.
        let texels: Vec<usize> = texels_in_blocks(n).map(|(column, row)| row * n + column).collect();
        let directions: Vec<DVec3> = texels.iter().map(|&texel| direction(texel)).collect();
        let rays: Vec<Ray> = directions.iter().map(|d| Ray { origin, direction: d.as_vec3().to_array() }).collect();
        let mut nearest_m = f64::INFINITY;
        let mut keys = vec![None; n * n];
        let mut mirrors = Vec::new();
        let mut distances_m = vec![f32::INFINITY; n * n];
        for ((texel, direction), hit) in texels.into_iter().zip(directions).zip(tracer.closest_many(&rays)) {
            let Some(hit) = hit else { continue };
            nearest_m = nearest_m.min(f64::from(hit.t));
            distances_m[texel] = hit.t;
            let level = cells.level(f64::from(hit.t), texel_angle);
            keys[texel] = Some(cell_of(hit, direction, level, mesh, lifted_position));
            if reflections.is_some_and(|r| r.orientation(hit).is_some()) {
                mirrors.push((texel, MirrorRay { from: lifted_position, direction, hit }));
            }
        }
        HitTrace { cells: keys, nearest_m, mirrors, distances_m }
    }

    /// Returns `[part of the sky]`: true if a ray to it may meet the change.
    pub(crate) fn parts_towards(&self, seen: &ChangeInView, fans: &SkyFans) -> Vec<bool> {
        fans.parts(self.normal).iter().map(|part| seen.lies_in(part.whole())).collect()
    }

    /// Returns the rays of [`Viewpoint::hits`].
    pub(crate) fn hit_rays(&self, n: usize, tracer: &Tracer) -> Vec<Ray> {
        let (origin, direction) = (self.origin(tracer), self.hit_directions(n));
        let ray = |(column, row)| Ray { origin, direction: direction(row * n + column).as_vec3().to_array() };
        texels_in_blocks(n).map(ray).collect()
    }

    /// Returns the directions of the hit rays by texel, world frame.
    pub(crate) fn hit_directions(&self, n: usize) -> impl Fn(usize) -> DVec3 + use<> {
        let (frame, seed) = (Frame::new(self.normal), self.seed());
        move |texel| frame.to_world(ray_direction(texel, n, seed))
    }

    /// Returns true if rays that go up from here leave terrain or solids: at least two of three
    /// steep ones cross an odd number of surfaces, the last of them from within. The other side of
    /// a sheet, such as an overhang, does not count as within.
    pub fn crosses_out(&self, mesh: &Mesh, tracer: &Tracer) -> bool {
        let origin = self.origin(tracer);
        let leaves = |direction: &[f32; 3]| {
            let ray = Ray { origin, direction: *direction };
            let crossed = tracer.crossed(ray);
            crossed.len() % 2 == 1 && crossed.last().is_some_and(|hit| meets_inside(&ray, hit, mesh, tracer))
        };
        let ups = [[0.031, 0.017, 1.0], [-0.023, 0.041, 1.0], [0.011, -0.037, 1.0]];
        ups.iter().filter(|direction| leaves(direction)).count() >= 2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::kernel::lanes::Level;
    use crate::trace::sky_fans::before;
    use heliotile_core::hemisphere::{mix, unit};
    use heliotile_core::site::material::{Class, Material};
    use heliotile_scene::Scene;

    /// Returns a scene with 40 towers on a plane, and a bush of more triangles than a candidate
    /// list holds.
    fn scene() -> Scene {
        let mut state = 1;
        let mut random = |low: f64, high: f64| {
            state = mix(state, 3);
            low + (high - low) * unit(state)
        };
        let mut triangles = Vec::new();
        let mut quad = |p: DVec3, a: DVec3, b: DVec3| {
            triangles.push(([p, p + a, p + a + b], 0));
            triangles.push(([p, p + a + b, p + b], 0));
        };
        quad(DVec3::new(-300.0, -300.0, 0.0), DVec3::X * 600.0, DVec3::Y * 600.0);
        for _ in 0..40 {
            let p = DVec3::new(random(-120.0, 120.0), random(-120.0, 120.0), 0.0);
            let (a, b) = (DVec3::new(random(5.0, 15.0), random(-3.0, 3.0), 0.0), DVec3::Y * random(5.0, 15.0));
            let up = DVec3::Z * random(4.0, 40.0);
            quad(p, a, up);
            quad(p + a, b, up);
            quad(p + b, a, up);
            quad(p, b, up);
            quad(p + up, a, b);
        }
        for _ in 0..2000 {
            let mut point = |size: f64| DVec3::new(random(-size, size), random(-size, size), random(-size, size));
            let (p, a, b) = (DVec3::new(6.0, 5.0, 4.0) + point(2.0), point(0.2), point(0.2));
            triangles.push(([p, p + a, p + b], 0));
        }
        Scene::from_triangles(&triangles, vec![Material::matt("all", 0.2, Class::Obstruction)]).expect("a scene")
    }

    /// Skies of 7 viewpoints, upright, tilted and overhanging, in 5 textures equal those of rays
    /// cast one by one, on every processor level of this machine. Of over 100,000 rays at least a
    /// fifth hit something and at least a fifth do not.
    #[test]
    fn skies_equal_those_of_single_rays() {
        let scene = scene();
        let views = [
            (DVec3::new(0.0, 0.0, 1.0), DVec3::Z),
            (DVec3::new(0.0, 0.0, 1.0), DVec3::X),
            (DVec3::new(3.0, 3.0, 2.0), DVec3::new(0.6, 0.0, 0.8)),
            (DVec3::new(-40.0, 30.0, 9.0), DVec3::new(0.8, -0.6, 0.0)),
            (DVec3::new(-40.0, 30.0, 9.0), DVec3::new(-0.36, 0.48, -0.8)),
            (DVec3::new(6.0, 5.0, 4.0), DVec3::new(0.0, 0.6, 0.8)),
            (DVec3::new(60.0, -80.0, 50.0), DVec3::NEG_Y),
        ];
        let (mut cast, mut open) = (0, 0);
        for (base, fine) in [(8, 128), (32, 128), (16, 16), (512, 512), (16, 2048)] {
            let fans = SkyFans::new(base, fine);
            for (position, normal) in views {
                let view = Viewpoint { position, normal };
                let tracer = Tracer::new(&scene.mesh).expect("a tree");
                let origin = view.origin(&tracer);
                let plain = SkyTexture::trace(
                    fans.front(normal),
                    fine,
                    TexelBlock::by_texels(|n, texels| {
                        let direction = fans.direction(n);
                        let ray = |d: DVec3| Ray { origin, direction: before(d, normal).as_vec3().to_array() };
                        let seen = texels.iter().map(|&(c, r)| !tracer.occluded(ray(direction(c, r))));
                        seen.inspect(|&sky| {
                            cast += 1;
                            open += u32::from(sky);
                        })
                        .collect()
                    }),
                );
                for level in Level::available() {
                    let tracer = Tracer::at_level(&scene.mesh, level).expect("a tree");
                    let SkyTrace { texture, bits, .. } = view.sky(&fans, &tracer);
                    assert!((texture, bits) == plain, "{position} {normal} {base} {fine} {level:?}");
                }
            }
        }
        assert!(cast > 100_000 && (cast / 5..cast - cast / 5).contains(&open), "{open} of {cast}");
    }
}
