//! The sun in mirrors and glass. In: the parts of the sky that receivers see by chains of mirrors,
//! and the sun's path. Out: when each chain reflects the sun to a receiver, how strong that is, and
//! at which angle from the sun itself.

use glam::DVec3;

use crate::path::{SunDay, SunPasses};
use crate::seen::{SeenSky, SunSeen};
use crate::spells::{Spell, Spells};
use heliotile_core::error::Result;
use heliotile_core::light::mirrors::{MirrorTable, Reflection};
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::{MirrorView, mirror_views};
use heliotile_core::site::chain::Chain;
use heliotile_core::weather::time::calendar::Date;

/// Views of the sky that a receiver has in mirrors.
pub struct MirrorSuns<'m> {
    views: Vec<(&'m MirrorView, SeenSky<'m>)>,
    normal: DVec3,
}

/// Mirror views of the receivers of a tile.
pub struct TileMirrors(Vec<Vec<MirrorView>>);

/// The sun as a chain of mirrors shows it on a day.
#[derive(Clone)]
pub struct MirrorSpells<'m> {
    /// Time in which the sun is seen.
    pub seen: SunSeen,
    /// The chain, starting at the receiver.
    pub chain: Chain,
    reflection: &'m Reflection,
    normal: DVec3,
}

/// Angles of the reflected suns that count as glare.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlareAngles {
    /// Smallest angle between the reflected sun and the sun itself, degrees.
    pub least_deflection_deg: f64,
    /// Largest angle between the reflected sun and the direction in which the receiver looks,
    /// degrees; 90 for all in front of its surface.
    pub view_angle_deg: f64,
}

impl GlareAngles {
    /// Angles of all suns in front of the surface.
    pub const ALL: GlareAngles = GlareAngles { least_deflection_deg: 0.0, view_angle_deg: 90.0 };

    /// Returns the angles of suns that count for both.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        GlareAngles {
            least_deflection_deg: self.least_deflection_deg.max(other.least_deflection_deg),
            view_angle_deg: self.view_angle_deg.min(other.view_angle_deg),
        }
    }
}

impl TileMirrors {
    /// Reads the mirror views of a tile with `receivers` receivers.
    pub fn read(site: &OpenSite, tile: u32, receivers: usize, table: &MirrorTable) -> Result<Self> {
        mirror_views(site, tile, &site.tile_mirrors(tile, receivers)?, table).map(TileMirrors)
    }

    /// Returns the mirror views of a receiver, by its row and normal.
    pub fn of_receiver(&self, row: usize, normal: DVec3) -> MirrorSuns<'_> {
        let views = self.0.get(row).map_or(&[][..], Vec::as_slice);
        MirrorSuns { views: views.iter().map(|view| (view, seen_sky(view))).collect(), normal }
    }
}

impl<'m> MirrorSuns<'m> {
    /// Returns when each chain reflects the sun to the front of the surface on a day; chains that
    /// never do are left out. With `for_rays`, the sun is possible wherever the chain's window
    /// reaches: the window may lack what is narrower than the rays that found it.
    pub fn on(&mut self, day: &SunDay, passes: &SunPasses, for_rays: bool) -> Vec<MirrorSpells<'m>> {
        let normal = self.normal;
        let mut of_view = |(view, sky): &mut (&'m MirrorView, SeenSky<'m>)| {
            let (view, mut seen) = (*view, sky.sun(passes, &day.up));
            if for_rays {
                seen.possible = seen.possible.and(&sky.reach(passes)).within(&day.up);
            }
            if seen.possible.is_empty() {
                return None;
            }
            let reflection = &view.reflection;
            let seen = seen.within(&day.before(reflection.image(normal), 0.0));
            (!seen.possible.is_empty()).then_some(MirrorSpells { seen, chain: view.chain, reflection, normal })
        };
        self.views.iter_mut().filter_map(&mut of_view).collect()
    }
}

impl MirrorSpells<'_> {
    /// Returns the time in which the reflected sun counts by its angles.
    pub fn within(&self, day: &SunDay, angles: GlareAngles) -> SunSeen {
        let seen = self.seen.clone();
        let seen = match angles.view_angle_deg {
            view if view < 90.0 => seen.within(&day.before(self.reflection.image(self.normal), 90.0 - view)),
            _ => seen,
        };
        match angles.least_deflection_deg {
            least if least > 0.0 => {
                let most = least.to_radians().cos();
                seen.within(&day.when(|sun| most - sun.dot(self.reflection.mirrored(sun))))
            }
            _ => seen,
        }
    }

    /// Returns the direction in which a sun is seen.
    pub fn image(&self, sun: DVec3) -> DVec3 {
        self.reflection.mirrored(sun)
    }

    /// Returns the share of the sun's light that the chain reflects.
    pub fn share(&self, sun: DVec3) -> f64 {
        self.reflection.share(sun)
    }

    /// Returns the cosine of the angle at which the reflected sun falls on the receiver's surface;
    /// 0 from behind.
    fn cosine(&self, sun: DVec3) -> f64 {
        self.normal.dot(self.image(sun)).max(0.0)
    }

    /// Returns the angle between a sun and the direction in which it is seen, degrees.
    pub fn deflection_deg(&self, sun: DVec3) -> f64 {
        self.image(sun).angle_between(sun).to_degrees()
    }

    /// Returns the chain with other spells.
    #[must_use]
    pub fn with_seen(&self, seen: SunSeen) -> Self {
        MirrorSpells { seen, ..*self }
    }
}

/// Returns the view's part of the sky, for the lookup of the sun's path.
fn seen_sky(view: &MirrorView) -> SeenSky<'_> {
    let sky = view.sky();
    SeenSky::of_part(sky, view.first(), view.whole_base())
}

/// Returns the union of the spells of several chains.
pub fn in_any<'s>(all: impl Iterator<Item = &'s SunSeen>) -> SunSeen {
    all.fold(SunSeen::default(), |sum, one| if sum.possible.is_empty() { one.clone() } else { sum.and(one) })
}

/// Longest step between two computations of a reflected sun's strength, minutes.
const LOOK_MIN: f64 = 5.0;

/// Largest strength of a reflected sun, and its smallest angle from the sun itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strongest {
    /// Irradiance of a surface that faces the reflected sun, W/m2.
    pub irradiance_w_m2: f64,
    /// Angle between the sun and the direction in which it is seen, degrees.
    pub deflection_deg: f64,
}

impl Strongest {
    /// Returns the strongest reflected sun during some spells, or `None` without spells.
    pub fn new(mirror: &MirrorSpells, day: &SunDay, spells: &Spells) -> Option<Self> {
        let moments = spells.iter().flat_map(|spell| {
            let steps = (spell.minutes() / LOOK_MIN).ceil().max(1.0) as usize;
            (0..=steps).map(move |step| spell.start_min + spell.minutes() * step as f64 / steps as f64)
        });
        let at = |minutes: f64| {
            let sun = day.sun(minutes);
            let irradiance_w_m2 = day.dni_w_m2(minutes) * mirror.share(sun);
            Strongest { irradiance_w_m2, deflection_deg: mirror.deflection_deg(sun) }
        };
        moments.map(at).reduce(Strongest::and)
    }

    /// Returns the larger irradiance and the smaller deflection of the two.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Strongest {
            irradiance_w_m2: self.irradiance_w_m2.max(other.irradiance_w_m2),
            deflection_deg: self.deflection_deg.min(other.deflection_deg),
        }
    }
}

/// Longest step between two sums of all reflected suns, minutes.
const SUM_STEP_MIN: f64 = 1.0;

/// Largest irradiance of a receiver's surface by all reflected suns of a moment, and this moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HotSpot {
    /// Irradiance of the receiver's own surface, above 0, W/m2; without the sun itself and the sky.
    pub irradiance_w_m2: f64,
    /// Date of the moment.
    pub date: Date,
    /// Minutes of the moment after midnight.
    pub at_min: f64,
}

impl HotSpot {
    /// Returns the hot spot of a day from chains and the spells in which each counts, or `None` if
    /// no sun is reflected. Between two changes of what is seen, or of the weather, the sum of
    /// DNI x share x cosine runs smoothly; it is computed in the middle of steps of up to a minute.
    pub fn new(shown: &[(&Spells, &MirrorSpells)], day: &SunDay) -> Option<Self> {
        let spells = shown.iter().flat_map(|(spells, _)| spells.iter());
        let mut changes: Vec<f64> =
            spells.chain(day.intervals()).flat_map(|one| [one.start_min, one.end_min]).collect();
        changes.sort_by(f64::total_cmp);
        changes.dedup();
        let of_part = |part: &[f64]| {
            let part = Spell { start_min: part[0], end_min: part[1] };
            let whole = Spells::one(part.start_min, part.end_min);
            let seen: Vec<&MirrorSpells> =
                shown.iter().filter(|(spells, _)| spells.hold(&whole)).map(|(_, mirror)| *mirror).collect();
            let steps = if seen.is_empty() { 0 } else { (part.minutes() / SUM_STEP_MIN).ceil() as usize };
            (0..steps).map(move |step| {
                let at_min = part.start_min + part.minutes() * (step as f64 + 0.5) / steps as f64;
                let sun = day.sun(at_min);
                let sum: f64 = seen.iter().map(|mirror| mirror.share(sun) * mirror.cosine(sun)).sum();
                HotSpot { irradiance_w_m2: day.dni_w_m2(at_min) * sum, date: day.date, at_min }
            })
        };
        let all = changes.windows(2).flat_map(of_part);
        all.filter(|one| one.irradiance_w_m2 > 0.0).reduce(HotSpot::higher)
    }

    /// Returns the hot spot with the larger irradiance; of equal ones, the first.
    #[must_use]
    pub fn higher(self, other: Self) -> Self {
        if other.irradiance_w_m2 > self.irradiance_w_m2 { other } else { self }
    }
}
