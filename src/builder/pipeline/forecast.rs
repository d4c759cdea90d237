//! Forecast of a build. In: a sample of the receivers. Out: for every effect the reason why it is
//! traced or not, its cost, and an upper bound of the light that is lost without it.
//!
//! Bounds hold under 1,000 W/m2 of sun from any direction and 100 W/m2 of a uniform sky, so the
//! first irradiance of a surface is at most E = 1,100 W/m2. A receiver that sees the share v_m of
//! its hemisphere filled with material m gets at most sum v_m rho_m E / (1 - rho) from all
//! reflections, where rho is the largest reflectance of the scene. At most the share g rho' of that
//! comes by two or more reflections, where g is the cosine-weighted share of a seen cell's
//! hemisphere that other surfaces fill, weighted by their reflectance. Both bounds follow from the
//! rendering equation, whose operator has a norm of at most rho.

use super::sample::Sample;
use super::site_tracer::SiteTracer;
use crate::receiver_tiles::ReceiverTiles;
use crate::settings::{Effect, EffectChoice, Effects};
use heliotile_core::archive::negligible::Negligible;
use heliotile_core::error::Result;
use heliotile_core::light::fresnel::specular;
use heliotile_core::light::reflector::Reflector;
use heliotile_core::site::chain::MAX_MIRRORS;

/// Irradiance of the sun at normal incidence for which bounds are stated, W/m2.
pub const SUN_W_M2: f64 = 1000.0;
/// Irradiance of a uniform sky on open ground for which bounds are stated, W/m2.
pub const SKY_W_M2: f64 = 100.0;

/// Largest bound with which an effect is left out, W/m2.
pub const NEGLIGIBLE_W_M2: f64 = 1.0;

/// Safety factor for the error of a view's share by its hit texture and of lookups in the response.
const COARSE: f64 = 1.1;

/// Safety factor for the error of the few rays of a cell.
const FEW_RAYS: f64 = 1.25;

/// Number of bounce cells per probe. [`SOLVING`] is the seconds to solve for bounce cells per
/// second of tracing them. Both as in The Hague (55 k probes).
const CELLS_PER_PROBE: f64 = 1.9;
const SOLVING: f64 = 0.3;

/// Forecast of what a build traces, effect by effect, and of its cost.
#[derive(Clone, Debug)]
pub struct Forecast {
    /// Number of receivers that the forecast is for.
    pub receivers: u64,
    /// Lines for the light that is always traced, and for each effect.
    pub lines: Vec<Line>,
    /// Effects that are left out although the scene has them.
    pub left_out: Effects,
}

/// Line of a forecast: one effect, or light that is always traced.
#[derive(Clone, Debug)]
pub struct Line {
    /// Name of the light path, for people.
    pub name: &'static str,
    /// Effect of the line; `None` for light that is always traced.
    pub effect: Option<Effect>,
    /// True if it will be traced.
    pub on: bool,
    /// Rays that it takes, or would take; scaled up from a sample.
    pub rays: f64,
    /// Seconds that it takes, or would take, on this machine.
    pub seconds: f64,
    /// Upper bound of the light that any receiver loses without it, W/m2; `None` for light that is
    /// always traced.
    pub bound_w_m2: Option<f64>,
    /// Reason why it is traced or not.
    pub why: String,
}

impl Forecast {
    /// Returns the upper bound of the light that any receiver loses by all left-out effects, W/m2.
    pub fn loss_w_m2(&self) -> f64 {
        let off = |effect: Effect| self.lines.iter().any(|line| line.effect == Some(effect) && !line.on);
        // Without diffuse reflection there are no bounces to lose in addition.
        let counts = |line: &&Line| !(line.on || line.effect == Some(Effect::Bounces) && off(Effect::Diffuse));
        self.lines.iter().filter(counts).filter_map(|line| line.bound_w_m2).sum()
    }

    /// Returns the lines of light that is traced.
    pub fn on(&self) -> impl Iterator<Item = &Line> {
        self.lines.iter().filter(|line| line.on)
    }

    /// Returns the seconds of the whole build: the sum of the lines that are traced.
    pub fn seconds(&self) -> f64 {
        self.on().map(|line| line.seconds).sum()
    }
}

impl SiteTracer<'_> {
    /// Traces a sample and decides which effects are traced. `mirrors` is the number of
    /// orientations of mirrors in the scene, traced or not.
    pub(super) fn forecast(
        &self,
        receivers: &mut ReceiverTiles,
        mirrors: usize,
        wanted: EffectChoice,
        negligible: Option<&Negligible>,
    ) -> Result<Forecast> {
        let sample = self.sample(receivers)?;
        Ok(Decision { sample: &sample, reflectors: &self.reflectors, mirrors, wanted, negligible }.forecast())
    }
}

/// Facts behind a decision on effects.
struct Decision<'a> {
    sample: &'a Sample,
    reflectors: &'a [Reflector],
    /// Number of orientations of mirrors.
    mirrors: usize,
    wanted: EffectChoice,
    /// Effects that may be left out under some weather; used with [`EffectChoice::Auto`].
    negligible: Option<&'a Negligible>,
}

/// Facts about an effect, and the reasons why it is traced or not.
struct EffectFacts<'a> {
    name: &'static str,
    effect: Effect,
    on: bool,
    bound_w_m2: f64,
    rays: f64,
    seconds: f64,
    /// Reason to show if the scene has nothing of the effect.
    nothing: &'a str,
    /// Reason to show if the effect is traced.
    some: String,
}

/// Upper bounds of the light that each effect can add to a receiver, W/m2.
struct Bounds {
    diffuse: f64,
    bounces: f64,
    mirrors: f64,
    canopies: f64,
    leaves: f64,
    /// Largest share that a leaf scatters.
    brightest_leaf: f64,
    /// Largest diffuse reflectance.
    brightest: f64,
    /// Largest share of a cell's light that comes from other surfaces.
    others: f64,
}

impl Decision<'_> {
    fn bounds(&self) -> Bounds {
        let Decision { sample, reflectors, mirrors, .. } = *self;
        let largest = |value: fn(&Reflector) -> f64| reflectors.iter().map(value).fold(0.0, f64::max);
        let brightest = largest(|r| r.diffuse);
        let both = largest(|r| r.diffuse + if r.panes > 0 { 1.0 - r.diffuse } else { r.specular });
        // A mirror can send the sun where it shines already; several can do so at once.
        let mirrored = largest(|r| if r.panes > 0 { specular(r, 0.0) } else { r.specular });
        let once = mirrored * mirrors as f64;
        let suns = (1..=MAX_MIRRORS as i32).map(|mirrors| once.powi(mirrors)).sum::<f64>();
        let light = SUN_W_M2 * (1.0 + suns) + SKY_W_M2;
        // Receivers outside the sample may see nothing but the brightest material.
        let leaves = largest(|r| r.transmittance.map_or(0.0, |_| r.diffuse));
        // The sample does not tell how much of a view leaves fill.
        let worst =
            |share: f64| if sample.receivers < sample.all { brightest } else { (share + leaves).min(brightest) };
        let (share, others) = (worst(sample.reflecting), worst(sample.traced.reflecting * FEW_RAYS));
        let gain = if both < 1.0 { light / (1.0 - both) } else { f64::INFINITY };
        let bound = |share: f64, light: f64| if share > 0.0 { share * light } else { 0.0 };
        Bounds {
            diffuse: bound(share, gain * COARSE),
            bounces: bound(share * others, gain * COARSE),
            // Light of all paths with a mirror among them: 1 / (1 - both) less 1 / (1 - diffuse),
            // both being their sum.
            mirrors: bound(suns / (1.0 - brightest).max(0.0), (SUN_W_M2 + SKY_W_M2) / (1.0 - both).max(0.0)),
            canopies: if reflectors.iter().any(|r| r.transmittance.is_some()) { gain } else { 0.0 },
            leaves: bound(leaves, gain),
            brightest_leaf: leaves,
            brightest,
            others,
        }
    }

    /// Returns true if an effect with this bound is traced.
    fn is_on(&self, effect: Effect, bound: f64) -> bool {
        match self.wanted {
            EffectChoice::Auto => match self.negligible {
                Some(known) => bound > 0.0 && !known.bound_percent.contains_key(effect.name()),
                None => bound > NEGLIGIBLE_W_M2,
            },
            EffectChoice::These(effects) => effects.contains(effect),
        }
    }

    /// Returns the line of an effect.
    fn line(&self, facts: EffectFacts) -> Line {
        let EffectFacts { name, effect, on, bound_w_m2, rays, seconds, nothing, some } = facts;
        let why = match (self.wanted, on) {
            _ if bound_w_m2 <= 0.0 => nothing.to_string(),
            (EffectChoice::Auto, true) => some,
            (EffectChoice::Auto, false) => {
                match self.negligible.and_then(|known| Some((known, known.bound_percent.get(effect.name())?))) {
                    Some((known, percent)) => {
                        format!("at most {percent} % of any group's sum under {}: negligible", known.weather)
                    }
                    None => format!("at most {NEGLIGIBLE_W_M2} W/m2: negligible"),
                }
            }
            (EffectChoice::These(_), true) => "requested".into(),
            (EffectChoice::These(_), false) => "not requested".into(),
        };
        Line { name, effect: Some(effect), on, rays, seconds, bound_w_m2: Some(bound_w_m2), why }
    }

    /// Returns the line of light that is always traced.
    fn always(name: &'static str, rays: f64, seconds: f64, why: &str) -> Line {
        Line { name, effect: None, on: true, rays, seconds, bound_w_m2: None, why: why.into() }
    }

    fn forecast(&self) -> Forecast {
        let Decision { sample, mirrors, .. } = *self;
        let bounds = self.bounds();
        let count = sample.all as f64;
        let probes = predicted(sample.cells, count / sample.receivers.max(1) as f64);
        let bounces = probes * CELLS_PER_PROBE;
        let canopies_on = bounds.canopies > 0.0 && self.is_on(Effect::Canopies, bounds.canopies);
        let leaves_on = canopies_on && bounds.leaves > 0.0 && self.is_on(Effect::Leaves, bounds.leaves);
        let diffuse_on = leaves_on || self.is_on(Effect::Diffuse, bounds.diffuse);
        let bounces_on = diffuse_on && self.is_on(Effect::Bounces, bounds.bounces);
        let mirrors_on = mirrors > 0 && self.is_on(Effect::Mirrors, bounds.mirrors);
        let [probe_s, bounce_s] = sample.traced.seconds;
        let [probe_rays, bounce_rays] = sample.traced.rays;
        let (brightest, filled) = (bounds.brightest, filled(sample, bounds.brightest));
        let mirrors_seen = match sample.sees_mirrors || sample.traced.see_mirrors {
            true => format!("{mirrors} orientations, seen by the sample; seconds of cells are in the lines above"),
            false => {
                format!("{mirrors} orientations; the sample sees none, and a mirror that nothing sees is not stored")
            }
        };
        let mirror_rays = sample.rays[2] * count + probes * (1.0 + CELLS_PER_PROBE) * sample.traced.mirror_rays;
        let lines = vec![
            Self::always("sun and sky, direct", sample.rays[0] * count, sample.seconds[0] * count, "always"),
            Self::always(
                "first hits",
                sample.rays[1] * count,
                0.0,
                "always: view factors (seconds are in the line above)",
            ),
            self.line(EffectFacts {
                name: "diffuse reflection",
                effect: Effect::Diffuse,
                on: diffuse_on,
                bound_w_m2: bounds.diffuse,
                rays: probes * probe_rays,
                seconds: probes * probe_s,
                nothing: "no receiver sees a surface that reflects",
                some: format!("surfaces of reflectance up to {brightest:.2} fill up to {filled:.0} % of a view"),
            }),
            self.line(EffectFacts {
                name: "further bounces",
                effect: Effect::Bounces,
                on: bounces_on,
                bound_w_m2: bounds.bounces,
                rays: bounces * bounce_rays,
                seconds: bounces * bounce_s * (1.0 + SOLVING),
                nothing: "no surface in view sees one that reflects",
                some: format!(
                    "surfaces in view get up to {:.1} % of their light from other surfaces",
                    bounds.others * 100.0
                ),
            }),
            self.line(EffectFacts {
                name: "mirrors and glass",
                effect: Effect::Mirrors,
                on: mirrors_on,
                bound_w_m2: bounds.mirrors,
                rays: mirror_rays,
                seconds: sample.seconds[1] * count,
                nothing: "there are none",
                some: mirrors_seen,
            }),
            self.line(EffectFacts {
                name: "canopies",
                effect: Effect::Canopies,
                on: canopies_on,
                bound_w_m2: bounds.canopies,
                rays: sample.rays[3] * count,
                seconds: sample.seconds[2] * count,
                nothing: "there are none",
                some: "leaves or screens dim what shines through them".into(),
            }),
            self.line(EffectFacts {
                name: "light of leaves",
                effect: Effect::Leaves,
                on: leaves_on,
                bound_w_m2: bounds.leaves,
                // Rays of receivers to leaves are in the line of canopies, those of cells in the
                // lines of reflections and bounces.
                rays: 0.0,
                seconds: 0.0,
                nothing: "no canopy has a `diffuse`",
                some: format!("leaves scatter up to {:.2}; rays are in the lines above", bounds.brightest_leaf),
            }),
        ];
        let present = |line: &&Line| !line.on && line.bound_w_m2.is_some_and(|b| b > 0.0);
        let names: Vec<String> =
            lines.iter().filter(present).filter_map(|line| line.effect).map(|e| e.name().to_string()).collect();
        Forecast { receivers: sample.all as u64, left_out: Effects::of_names(&names), lines }
    }
}

/// Returns the percentage of a view that surfaces of the largest reflectance would fill.
fn filled(sample: &Sample, diffuse: f64) -> f64 {
    if diffuse > 0.0 { (sample.reflecting / diffuse * 100.0).min(100.0) } else { 0.0 }
}

/// Predicts the number of cells that `factor` times as many receivers see, by a power law through
/// the cells of a quarter of the sample and of the whole sample.
fn predicted([quarter, all]: [usize; 2], factor: f64) -> f64 {
    let power = if quarter > 0 { (all as f64 / quarter as f64).ln() / 4.0_f64.ln() } else { 1.0 };
    all as f64 * factor.max(1.0).powf(power.clamp(0.0, 1.0))
}
