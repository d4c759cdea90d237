//! What a build would trace, before it does. In: a sample of the receivers. Out: for every effect whether the scene calls for it, what
//! it would cost, and what leaving it out could cost.
//!
//! Bounds hold under 1,000 W/m2 of sun from any direction and 100 W/m2 of a uniform sky, so no surface gets more than E = 1,100
//! W/m2 at first. A receiver that sees the share v_m of its hemisphere filled with material m gets at most sum v_m rho_m E / (1 - rho)
//! from all reflections, rho the largest reflectance of the scene, and of that at most the share g rho' by way of two or more: g is the
//! cosine-weighted share of a seen cell's hemisphere that other surfaces fill, weighted by their reflectance. Both follow from the rendering
//! equation, whose operator has a norm of at most rho.

use std::collections::BTreeSet;
use std::time::Instant;

use rayon::prelude::*;

use super::Job;
use super::cells::Cast;
use crate::cli::{Effect, Effects, Wanted};
use heliotile_builder::receiver_tiles::ReceiverTiles;
use heliotile_builder::trace::bounce::trace_bounce;
use heliotile_builder::trace::probe::Directions;
use heliotile_builder::trace::surroundings::SurroundingSettings;
use heliotile_core::error::Result;
use heliotile_core::hemisphere::{Centres, jitter, texel_direction};
use heliotile_core::layers::bits::BitSquare;
use heliotile_core::layers::cells::{Cell, Cells};
use heliotile_core::layers::mirror::CellPath;
use heliotile_core::light::bounces::{centres_f32, each_ray, surround};
use heliotile_core::light::fresnel::specular;
use heliotile_core::light::mirrors::left;
use heliotile_core::light::reflector::Reflector;
use heliotile_core::site::cells::{CellKey, level_of};
use heliotile_core::site::chain::MOST_MIRRORS;
use heliotile_core::site::receiver::Receiver;

/// Light that bounds are stated for, W/m2: of the sun at normal incidence and of a uniform sky on open ground.
pub const SUN_W_M2: f64 = 1000.0;
pub const SKY_W_M2: f64 = 100.0;

/// An effect is left out if that costs no more than this.
pub const NEGLIGIBLE_W_M2: f64 = 1.0;

/// Receivers whose hits are looked at; if there are more, bounds take the worst that any could see. One in so many is traced whole.
const SAMPLE: usize = 512;
const WHOLE: usize = 16;

/// What a view's share by its hit texture, and lookups in the response, may be wrong by.
const COARSE: f64 = 1.1;

/// Cells of the sample that are traced, and what their few rays may be wrong by.
const CELLS: usize = 512;
const FEW_RAYS: f64 = 1.25;

/// Bounce cells to a probe, and seconds to solve for them to seconds to trace them: as in The Hague (55 k probes).
const CELLS_PER_PROBE: f64 = 1.9;
const SOLVING: f64 = 0.3;

/// What is to be traced, effect by effect.
#[derive(Clone, Debug)]
pub struct Forecast {
    pub receivers: u64,
    pub lines: Vec<Line>,
    /// What is left out although the scene has it.
    pub left_out: Effects,
}

/// One effect, or what is always traced.
#[derive(Clone, Debug)]
pub struct Line {
    pub name: &'static str,
    /// `None` is always on.
    pub effect: Option<Effect>,
    pub on: bool,
    pub rays: f64,
    pub seconds: f64,
    /// The most that any receiver could lose without it, W/m2.
    pub bound_w_m2: Option<f64>,
    pub why: String,
}

impl Forecast {
    /// The most that any receiver loses by what is left out, W/m2.
    pub fn loss_w_m2(&self) -> f64 {
        let off = |effect: Effect| self.lines.iter().any(|line| line.effect == Some(effect) && !line.on);
        // Without diffuse reflection there are no bounces to lose besides.
        let counts = |line: &&Line| !(line.on || line.effect == Some(Effect::Bounces) && off(Effect::Diffuse));
        self.lines.iter().filter(counts).filter_map(|line| line.bound_w_m2).sum()
    }

    fn on(&self) -> impl Iterator<Item = &Line> {
        self.lines.iter().filter(|line| line.on)
    }

    /// Of the whole build.
    pub fn seconds(&self) -> f64 {
        self.on().map(|line| line.seconds).sum()
    }

    /// A table for people.
    pub fn table(&self) -> String {
        let mut out =
            format!("{:<22}{:<7}{:>11}{:>10}{:>16}  why\n", "effect", "state", "rays", "seconds", "without: W/m2");
        for line in &self.lines {
            let state = if line.on { "on" } else { "off" };
            let (rays, seconds) = match line.on {
                true => (counted(line.rays), format!("{:.1}", line.seconds)),
                false => (format!("({})", counted(line.rays)), format!("({:.1})", line.seconds)),
            };
            let bound = line.bound_w_m2.map_or("-".into(), at_most);
            out += &format!("{:<22}{state:<7}{rays:>11}{seconds:>10}{bound:>16}  {}\n", line.name, line.why);
        }
        let (rays, seconds) = (self.on().map(|line| line.rays).sum(), self.seconds());
        out += &format!(
            "{:<22}{:<7}{:>11}{seconds:>10.1}{:>16}  under {SUN_W_M2:.0} W/m2 of sun and {SKY_W_M2:.0} of uniform sky\n",
            "all",
            "",
            counted(rays),
            at_most(self.loss_w_m2()),
        );
        out
    }
}

/// A bound, W/m2; a large one says nothing.
fn at_most(bound: f64) -> String {
    match bound {
        b if b <= 0.0 => "0".into(),
        b if b > 2.0 * SUN_W_M2 => "unbounded".into(),
        b => format!("<= {b:.3}"),
    }
}

/// 12.3 M.
fn counted(rays: f64) -> String {
    match rays {
        r if r >= 1e9 => format!("{:.1} G", r / 1e9),
        r if r >= 1e6 => format!("{:.1} M", r / 1e6),
        r if r >= 1e3 => format!("{:.1} k", r / 1e3),
        r => format!("{r:.0}"),
    }
}

/// What the sample said.
struct Sample {
    /// Receivers of the sample, and of all.
    receivers: usize,
    all: usize,
    /// Rays of a receiver: sky, hits, mirrors, canopies.
    rays: [f64; 4],
    /// Seconds for the sky and hits of a receiver, for its mirrors and its canopies.
    seconds: [f64; 3],
    /// Largest share of a hemisphere that surfaces fill, weighted by their reflectance.
    reflecting: f64,
    sees_mirrors: bool,
    /// Cells that a quarter of the sample and all of it see.
    cells: [usize; 2],
    traced: TracedCells,
}

/// Some of the cells that are seen.
#[derive(Default)]
struct TracedCells {
    /// Rays and seconds of a probe and of a bounce cell, and rays by mirrors.
    rays: [f64; 2],
    mirror_rays: f64,
    seconds: [f64; 2],
    /// Largest share of a hemisphere that other surfaces fill, weighted by their reflectance.
    reflecting: f64,
    see_mirrors: bool,
}

impl Job<'_> {
    /// Looks at a sample and decides. `mirrors`: number of orientations of mirrors in the scene, whether they are traced or not.
    pub(super) fn forecast(&self, receivers: &mut ReceiverTiles, mirrors: usize, wanted: Wanted) -> Result<Forecast> {
        let step = receivers.count().div_ceil(SAMPLE).max(1);
        let mut sample: Vec<Receiver> = Vec::new();
        for (i, receiver) in receivers.tiles()?.flat_map(|tile| tile.map_or_else(|e| vec![Err(e)], ok_each)).enumerate()
        {
            let receiver = receiver?;
            if i % step == 0 {
                sample.push(receiver);
            }
        }
        Ok(self.decide(&self.look(&sample, receivers.count()), mirrors, wanted))
    }

    fn decide(&self, sample: &Sample, mirrors: usize, wanted: Wanted) -> Forecast {
        let count = sample.all as f64;
        let reflectors = &self.reflectors;
        let largest = |value: fn(&Reflector) -> f64| reflectors.iter().map(value).fold(0.0, f64::max);
        let diffuse = largest(|r| r.diffuse);
        let both = largest(|r| r.diffuse + if r.panes > 0 { 1.0 - r.diffuse } else { r.specular });
        // A mirror can send the sun to where it shines already; several can do so at once.
        let mirrored = largest(|r| if r.panes > 0 { specular(r, 0.0) } else { r.specular });
        let once = mirrored * mirrors as f64;
        let suns = (1..=MOST_MIRRORS as i32).map(|mirrors| once.powi(mirrors)).sum::<f64>();
        let light = SUN_W_M2 * (1.0 + suns) + SKY_W_M2;
        // Receivers that were not looked at may see nothing but the brightest material.
        let worst = |share: f64| if sample.receivers < sample.all { diffuse } else { share.min(diffuse) };
        let (share, others) = (worst(sample.reflecting), worst(sample.traced.reflecting * FEW_RAYS));
        let gain = if both < 1.0 { light / (1.0 - both) } else { f64::INFINITY };
        let bound = |share: f64, light: f64| if share > 0.0 { share * light } else { 0.0 };
        let first = bound(share, gain * COARSE);
        let later = bound(share * others, gain * COARSE);
        let seen = sample.sees_mirrors || sample.traced.see_mirrors;
        // The light of all paths with a mirror among them: 1 / (1 - both) less 1 / (1 - diffuse), both being their sum.
        let by_mirrors = bound(suns / (1.0 - diffuse).max(0.0), (SUN_W_M2 + SKY_W_M2) / (1.0 - both).max(0.0));

        let probes = predicted(sample.cells, count / sample.receivers.max(1) as f64);
        let bounces = probes * CELLS_PER_PROBE;
        let on = |effect: Effect, bound: f64| match wanted {
            Wanted::Auto => bound > NEGLIGIBLE_W_M2,
            Wanted::These(effects) => effects.contains(effect),
        };
        let leaves = if reflectors.iter().any(|r| r.transmittance.is_some()) { gain } else { 0.0 };
        let leaves_on = leaves > 0.0 && on(Effect::Canopies, leaves);
        let diffuse_on = on(Effect::Diffuse, first);
        let bounces_on = diffuse_on && on(Effect::Bounces, later);
        let mirrors_on = mirrors > 0 && on(Effect::Mirrors, by_mirrors);
        let why = |on: bool, bound: f64, nothing: &str, some: String| match (wanted, on) {
            _ if bound <= 0.0 => nothing.to_string(),
            (Wanted::Auto, true) => some,
            (Wanted::Auto, false) => format!("at most {NEGLIGIBLE_W_M2} W/m2: negligible"),
            (Wanted::These(_), true) => "asked for".into(),
            (Wanted::These(_), false) => "not asked for".into(),
        };
        let [probe_s, bounce_s] = sample.traced.seconds;
        let [probe_rays, bounce_rays] = sample.traced.rays;
        let mut lines = vec![
            Line {
                name: "sun and sky, direct",
                effect: None,
                on: true,
                rays: sample.rays[0] * count,
                seconds: sample.seconds[0] * count,
                bound_w_m2: None,
                why: "always".into(),
            },
            Line {
                name: "first hits",
                effect: None,
                on: true,
                rays: sample.rays[1] * count,
                seconds: 0.0,
                bound_w_m2: None,
                why: "always: view factors (seconds are in the line above)".into(),
            },
            Line {
                name: "diffuse reflection",
                effect: Some(Effect::Diffuse),
                on: diffuse_on,
                rays: probes * probe_rays,
                seconds: probes * probe_s,
                bound_w_m2: Some(first),
                why: why(
                    diffuse_on,
                    first,
                    "no receiver sees a surface that reflects",
                    format!("surfaces of up to {diffuse:.2} fill up to {:.0} % of a view", filled(sample, diffuse)),
                ),
            },
            Line {
                name: "further bounces",
                effect: Some(Effect::Bounces),
                on: bounces_on,
                rays: bounces * bounce_rays,
                seconds: bounces * bounce_s * (1.0 + SOLVING),
                bound_w_m2: Some(later),
                why: why(
                    bounces_on,
                    later,
                    "no surface that is seen sees one that reflects",
                    format!("what is seen gets up to {:.1} % of its light from surfaces", others * 100.0),
                ),
            },
            Line {
                name: "mirrors and glass",
                effect: Some(Effect::Mirrors),
                on: mirrors_on,
                rays: sample.rays[2] * count + probes * (1.0 + CELLS_PER_PROBE) * sample.traced.mirror_rays,
                seconds: sample.seconds[1] * count,
                bound_w_m2: Some(by_mirrors),
                why: why(
                    mirrors_on,
                    by_mirrors,
                    "there are none",
                    match seen {
                        true => format!("{mirrors} orientations, seen; seconds of cells are in the lines above"),
                        false => {
                            format!("{mirrors} orientations; none was seen by the sample: what none sees is not stored")
                        }
                    },
                ),
            },
        ];
        lines.push(Line {
            name: "canopies",
            effect: Some(Effect::Canopies),
            on: leaves_on,
            rays: sample.rays[3] * count,
            seconds: sample.seconds[2] * count,
            bound_w_m2: Some(leaves),
            why: why(leaves_on, leaves, "there are none", "leaves or screens dim what shines through them".into()),
        });
        let present = |line: &&Line| !line.on && line.bound_w_m2.is_some_and(|b| b > 0.0);
        let left_out = lines.iter().filter(present).filter_map(|line| line.effect);
        let names: Vec<String> = left_out.map(|e| e.name().to_string()).collect();
        Forecast { receivers: sample.all as u64, left_out: Effects::of_names(&names), lines }
    }

    /// Traces the sample: hits of all of it, the rest of some.
    fn look(&self, receivers: &[Receiver], all: usize) -> Sample {
        let centres = Centres::new(self.settings.sky_base, self.settings.sky_fine);
        let reflectors = &self.reflectors;
        let rho = |key: &CellKey| reflectors.get(usize::from(key.material)).map_or(0.0, |r| r.diffuse);
        let whole: Vec<&Receiver> = receivers.iter().step_by(WHOLE).collect();
        let timed = Instant::now();
        let skies: Vec<(BitSquare, u64)> = whole
            .par_iter()
            .map(|receiver| {
                let (_, bits, rays) = self.trace_sky(&self.viewpoint(receiver), &centres);
                (bits, rays)
            })
            .collect();
        let sky = skies.iter().map(|sky| sky.1).sum::<u64>();
        let sky_s = timed.elapsed().as_secs_f64() / whole.len().max(1) as f64;
        let timed = Instant::now();
        let behind = whole.par_iter().zip(&skies).filter(|_| self.canopies.is_some());
        let leaves = behind.map(|(receiver, (bits, _))| {
            let view = self.viewpoint(receiver);
            self.canopy_of_receiver(&view, bits, &self.trace_hits(&view)).1
        });
        let leaves = leaves.sum::<u64>();
        let leaves_s = timed.elapsed().as_secs_f64() / whole.len().max(1) as f64;
        let timed = Instant::now();
        let windows = |receiver: &&Receiver| {
            let mut rays = 0;
            let seen = self.mirror_windows(&self.viewpoint(receiver), &centres, &mut rays);
            (!seen.is_empty(), rays)
        };
        let windows: Vec<(bool, u64)> = whole.par_iter().map(windows).collect();
        let windows_s = timed.elapsed().as_secs_f64() / whole.len().max(1) as f64;
        let timed = Instant::now();
        let hits = |receiver: &Receiver| {
            let (view, mut rays) = (self.viewpoint(receiver), 0);
            let hits = self.trace_hits(&view);
            let paths = self.mirror_paths(&view, &hits, &mut rays);
            (view, hits.cells, paths, rays)
        };
        let hits: Vec<_> = receivers.par_iter().map(hits).collect();
        let hits_s = timed.elapsed().as_secs_f64() / hits.len().max(1) as f64;

        let n = self.settings.hit;
        let mut reflecting = 0.0_f64;
        let mut cells = [BTreeSet::new(), BTreeSet::new()];
        for (i, (view, keys, paths, _)) in hits.iter().enumerate() {
            let weight = |texel: usize| {
                texel_direction(texel % n, texel / n, n, jitter(view.seed(), texel as u64)).z * 2.0 / (n * n) as f64
            };
            let direct = keys.iter().enumerate().filter_map(|(t, key)| Some((t, key.as_ref()?, 1.0)));
            let in_mirrors = paths.iter().map(|p| (p.texel as usize, &p.cell, left(&p.steps, reflectors)));
            let mut share = 0.0;
            for (texel, key, left) in direct.chain(in_mirrors).filter(|light| rho(light.1) > 0.0) {
                share += weight(texel) * left * rho(key);
                if i % 4 == 0 {
                    cells[0].insert(*key);
                }
                cells[1].insert(*key);
            }
            reflecting = reflecting.max(share);
        }
        let of_windows = windows.iter().map(|w| w.1 as f64).sum::<f64>() / windows.len().max(1) as f64;
        let of_paths = hits.iter().map(|h| h.3 as f64).sum::<f64>() / hits.len().max(1) as f64;
        let counts = [cells[0].len(), cells[1].len()];
        let [_, cells] = cells;
        Sample {
            receivers: receivers.len(),
            all,
            rays: [
                sky as f64 / whole.len().max(1) as f64,
                (n * n) as f64,
                of_windows + of_paths,
                leaves as f64 / whole.len().max(1) as f64,
            ],
            seconds: [sky_s + hits_s, windows_s, leaves_s],
            reflecting,
            sees_mirrors: windows.iter().any(|w| w.0) || hits.iter().any(|h| !h.2.is_empty()),
            cells: counts,
            traced: self.look_at_cells(&cells.into_iter().collect::<Vec<_>>()),
        }
    }

    /// Traces some of the cells that are seen, evenly chosen.
    fn look_at_cells(&self, keys: &[CellKey]) -> TracedCells {
        let (s, mesh, reflectors) = (self.settings, &self.scene.mesh, &self.reflectors);
        let some: Vec<CellKey> = keys.iter().copied().step_by(keys.len().div_ceil(CELLS).max(1)).collect();
        if some.is_empty() {
            return TracedCells::default();
        }
        let texture = Directions::new(s.probe);
        let centres = centres_f32(s.probe);
        let timed = Instant::now();
        let traced: Vec<(Cell, Cast)> = some.par_iter().map(|&key| self.trace_probe(key, &texture)).collect();
        let probe_s = timed.elapsed().as_secs_f64() / some.len() as f64;
        let share = |(cell, _): &(Cell, Cast)| {
            let cells = Cells::new(std::slice::from_ref(cell));
            let each = each_ray(cells.hits_of(0), surround(cell.normal, &cell.bits, &centres));
            let rho = |key: &CellKey| reflectors.get(usize::from(key.material)).map_or(0.0, |r| r.diffuse);
            let direct: f64 =
                cell.seen.iter().filter_map(|(up, key)| Some(each[usize::from(*up)] * rho(key.as_ref()?))).sum();
            let path = |p: &CellPath| each[usize::from(p.up)] * left(&p.steps, reflectors) * rho(&p.cell);
            direct + cell.mirrors.paths.iter().map(path).sum::<f64>()
        };
        let reflecting = traced.iter().map(share).fold(0.0, f64::max);
        let next: BTreeSet<CellKey> = traced.iter().flat_map(|(cell, _)| cell.reached()).collect();
        let next: Vec<CellKey> = next.iter().copied().step_by(next.len().div_ceil(CELLS / 4).max(1)).collect();
        let texture = Directions::new(s.bounce_sky);
        let settings = SurroundingSettings { closed_level: level_of(s.closed_m), rays: s.bounce_hits };
        let timed = Instant::now();
        let bounces: Vec<u64> = next
            .par_iter()
            .map(|&key| {
                let traced = trace_bounce(key, &texture, settings, mesh, self.tracer, self.reflections.as_ref());
                self.cell(key, traced.0, traced.1, &texture).1.plain
            })
            .collect();
        let bounce_s = timed.elapsed().as_secs_f64() / next.len().max(1) as f64;
        let count = some.len() as f64;
        TracedCells {
            rays: [
                traced.iter().map(|t| t.1.plain as f64).sum::<f64>() / count,
                bounces.iter().sum::<u64>() as f64 / bounces.len().max(1) as f64,
            ],
            mirror_rays: traced.iter().map(|t| t.1.mirror as f64).sum::<f64>() / count,
            seconds: [probe_s, bounce_s],
            reflecting,
            see_mirrors: traced.iter().any(|(cell, _)| !cell.mirrors.is_empty()),
        }
    }
}

fn ok_each(tile: Vec<Receiver>) -> Vec<Result<Receiver>> {
    tile.into_iter().map(Ok).collect()
}

/// Share of a view in percent that surfaces of the largest reflectance would fill.
fn filled(sample: &Sample, diffuse: f64) -> f64 {
    if diffuse > 0.0 { (sample.reflecting / diffuse * 100.0).min(100.0) } else { 0.0 }
}

/// Cells that so many times the receivers would see, from those of a quarter of the sample and of all of it: by a power law.
fn predicted([quarter, all]: [usize; 2], factor: f64) -> f64 {
    let power = if quarter > 0 { (all as f64 / quarter as f64).ln() / 4.0_f64.ln() } else { 1.0 };
    all as f64 * factor.max(1.0).powf(power.clamp(0.0, 1.0))
}
