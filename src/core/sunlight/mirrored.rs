//! The sun in mirrors and glass. In: what receivers see of the sky by chains of mirrors, the sun's path. Out: when each chain throws the sun at a
//! receiver, how strong that is, and how far from the sun itself it is seen.

use glam::DVec3;

use crate::error::Result;
use crate::layers::sky_bitmap::SkyBitmap;
use crate::light::mirrors::{MirrorTable, Reflection};
use crate::opened::OpenSite;
use crate::replay::direct::specular::MirrorView;
use crate::replay::tile_layers::mirror_views;
use crate::site::chain::Chain;
use crate::sunlight::path::{SunDay, SunPasses};
use crate::sunlight::seen::{SeenSky, SunSeen};
use crate::sunlight::spells::Spells;
use crate::weather::clear::clear_sky;

/// What a receiver sees of the sun in mirrors.
pub struct MirrorSuns<'m> {
    views: Vec<(&'m MirrorView, SeenSky<'m>)>,
    normal: DVec3,
}

/// What the receivers of a tile see in mirrors.
pub struct TileMirrors(Vec<Vec<MirrorView>>);

/// The sun as a chain of mirrors shows it on a day.
#[derive(Clone)]
pub struct MirrorSpells<'m> {
    /// When.
    pub seen: SunSeen,
    /// The chain, from the receiver on.
    pub chain: Chain,
    reflection: &'m Reflection,
    normal: DVec3,
}

/// Which suns in mirrors count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlareAngles {
    /// Those that are seen at least so far from the sun itself, degrees.
    pub least_deflection_deg: f64,
    /// Those that are seen within so much of the direction in which the receiver looks, degrees; 90: all before its surface.
    pub view_angle_deg: f64,
}

impl GlareAngles {
    /// All before the surface.
    pub const ALL: GlareAngles = GlareAngles { least_deflection_deg: 0.0, view_angle_deg: 90.0 };

    /// What both count.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        GlareAngles {
            least_deflection_deg: self.least_deflection_deg.max(other.least_deflection_deg),
            view_angle_deg: self.view_angle_deg.min(other.view_angle_deg),
        }
    }
}

impl TileMirrors {
    /// Reads the windows of a tile with so many receivers.
    pub fn read(site: &OpenSite, tile: u32, receivers: usize, table: &MirrorTable) -> Result<Self> {
        mirror_views(site, tile, &site.tile_mirrors(tile, receivers)?, table).map(TileMirrors)
    }

    /// The mirrors that a receiver sees, by its row and normal.
    pub fn of_receiver(&self, row: usize, normal: DVec3) -> MirrorSuns<'_> {
        let views = self.0.get(row).map_or(&[][..], Vec::as_slice);
        MirrorSuns { views: views.iter().map(|view| (view, view.seen_sky())).collect(), normal }
    }
}

impl<'m> MirrorSuns<'m> {
    /// When each chain throws the sun before the surface on a day; those that do not are left out. `for_rays`: the sun is possible wherever
    /// the chain's window reaches, since the window may lack what is narrower than the rays that found it.
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
    /// What of it counts.
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

    /// The direction in which a sun is seen.
    pub fn image(&self, sun: DVec3) -> DVec3 {
        self.reflection.mirrored(sun)
    }

    /// Share of the sun's light that is left.
    pub fn share(&self, sun: DVec3) -> f64 {
        self.reflection.share(sun)
    }

    /// Angle between a sun and the direction in which it is seen, degrees.
    pub fn deflection_deg(&self, sun: DVec3) -> f64 {
        self.image(sun).angle_between(sun).to_degrees()
    }

    /// The chain with other spells.
    #[must_use]
    pub fn with_seen(&self, seen: SunSeen) -> Self {
        MirrorSpells { seen, ..*self }
    }
}

impl MirrorView {
    /// As the sun's path is looked up in it.
    fn seen_sky(&self) -> SeenSky<'_> {
        let sky: &SkyBitmap = self.sky();
        SeenSky::of_part(sky, self.first(), self.whole_base())
    }
}

/// The union of what several chains show.
pub fn in_any<'s>(all: impl Iterator<Item = &'s SunSeen>) -> SunSeen {
    all.fold(SunSeen::default(), |sum, one| if sum.possible.is_empty() { one.clone() } else { sum.and(one) })
}

/// Longest step between looks at how strong the sun in a mirror is, minutes.
const LOOK_MIN: f64 = 5.0;

/// How strong the sun in mirrors is at most, and how near to the sun itself it is seen at least.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strongest {
    /// Of a surface that looks at it, under a clear sky, W/m2.
    pub irradiance_w_m2: f64,
    /// Angle between the sun and the direction in which it is seen, degrees.
    pub deflection_deg: f64,
}

impl Strongest {
    /// During some spells.
    pub fn of(mirror: &MirrorSpells, day: &SunDay, spells: &Spells) -> Option<Self> {
        let moments = spells.iter().flat_map(|spell| {
            let steps = (spell.minutes() / LOOK_MIN).ceil().max(1.0) as usize;
            (0..=steps).map(move |step| spell.start_min + spell.minutes() * step as f64 / steps as f64)
        });
        let at = |minutes: f64| {
            let sun = day.sun(minutes);
            let dni_w_m2 = if sun.z > 0.0 { clear_sky(sun.z).0 } else { 0.0 };
            let irradiance_w_m2 = dni_w_m2 * mirror.share(sun);
            Strongest { irradiance_w_m2, deflection_deg: mirror.deflection_deg(sun) }
        };
        moments.map(at).reduce(Strongest::and)
    }

    /// Of this and another.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Strongest {
            irradiance_w_m2: self.irradiance_w_m2.max(other.irradiance_w_m2),
            deflection_deg: self.deflection_deg.min(other.deflection_deg),
        }
    }
}
