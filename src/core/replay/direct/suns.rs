//! The suns of a series of conditions, looked up once for all receivers. In: suns and their results. Out: direct
//! irradiance of a receiver whose sky is at hand.

use glam::DVec3;

use crate::layers::sides::TextureSides;
use crate::layers::sky_bitmap::SkyBitmap;
use crate::replay::direct::canopy_transmittance::CanopyTransmittance;
use crate::replay::direct::sky_masks::SkyMasks;
use crate::replay::direct::specular::MirrorView;
use crate::replay::direct::sun_map::SunMap;
use crate::replay::direct::sun_samples::SunSamples;
use crate::replay::sun_sample::SunSample;

/// Suns made ready for receivers' textures: one by one where each has a result, added up where many share one.
pub enum SunLookups {
    /// Suns of hours.
    Each(SunSamples),
    /// Suns of sums.
    Summed(SunMap),
}

/// From so many suns a result on they are added up.
const SUMMED_FROM: usize = 100;

impl SunLookups {
    /// Looks up suns, in the order of their results, of so many results.
    pub fn new(suns: Vec<SunSample>, results: usize, sides: TextureSides) -> Self {
        if suns.len() >= SUMMED_FROM * results.max(1) {
            return SunLookups::Summed(SunMap::new(suns, sides));
        }
        SunLookups::Each(SunSamples::new(suns, sides))
    }

    /// Whether there is no sun.
    pub fn is_empty(&self) -> bool {
        matches!(self, SunLookups::Each(each) if each.is_empty())
    }

    /// Calls `each(receiver, result, irradiance)` for direct irradiances, which may add up: those of one result may come in parts.
    pub fn direct(&self, skies: &SkyMasks, each: impl FnMut(usize, usize, f64)) {
        match self {
            SunLookups::Each(suns) => suns.direct(skies, each),
            SunLookups::Summed(map) => map.direct(skies, each),
        }
    }

    /// Adds the irradiance that a receiver with this normal gets by one chain of mirrors.
    pub fn by_mirrors(&self, normal: DVec3, view: &MirrorView, out: &mut [f64]) {
        match self {
            SunLookups::Each(each) => each.by_mirrors(normal, view, out),
            SunLookups::Summed(map) => map.by_mirrors(normal, view, out),
        }
    }

    /// The first of them behind a veil.
    pub fn direct_behind(&self, normal: DVec3, sky: &SkyBitmap, veil: &CanopyTransmittance, out: &mut [f64]) {
        match self {
            SunLookups::Each(each) => each.direct_behind(normal, &mut &*sky, veil, out),
            SunLookups::Summed(map) => map.direct_behind(normal, sky, veil, out),
        }
    }
}
