//! The suns of a series of conditions, looked up once for all receivers. In: suns and their
//! results. Out: direct irradiance of a receiver with a known sky.

use glam::DVec3;

use crate::layers::sides::TextureSides;
use crate::layers::sky_bitmap::SkyBitmap;
use crate::replay::direct::canopy_transmittance::CanopyTransmittance;
use crate::replay::direct::sky_masks::SkyMasks;
use crate::replay::direct::specular::MirrorView;
use crate::replay::direct::sun_map::SunMap;
use crate::replay::direct::sun_samples::SunSamples;
use crate::replay::sun_sample::SunSample;

/// Suns looked up on the textures of receivers: one by one where each has a result of its own,
/// added up where many share a result.
pub enum SunLookups {
    /// Suns one by one.
    Each(SunSamples),
    /// Suns added up.
    Summed(SunMap),
}

/// Number of suns per result from which on suns are added up.
const SUMMED_FROM: usize = 100;

impl SunLookups {
    /// Looks up suns, which are in the order of their results, for `results` results.
    pub fn new(suns: Vec<SunSample>, results: usize, sides: TextureSides) -> Self {
        if suns.len() >= SUMMED_FROM * results.max(1) {
            return SunLookups::Summed(SunMap::new(suns, sides));
        }
        SunLookups::Each(SunSamples::new(suns, sides))
    }

    /// Returns true if there is no sun.
    pub fn is_empty(&self) -> bool {
        matches!(self, SunLookups::Each(each) if each.is_empty())
    }

    /// Calls `each(receiver, result, irradiance)` for direct irradiances. The caller adds them up:
    /// the irradiance of one result may come in several parts.
    pub fn direct(&self, skies: &SkyMasks, each: impl FnMut(usize, usize, f64)) {
        match self {
            SunLookups::Each(suns) => suns.direct(skies, each),
            SunLookups::Summed(map) => map.direct(skies, each),
        }
    }

    /// Adds the irradiance that a receiver with this normal gets by one chain of mirrors to
    /// `out[result]`.
    pub fn by_mirrors(&self, normal: DVec3, view: &MirrorView, out: &mut [f64]) {
        match self {
            SunLookups::Each(each) => each.by_mirrors(normal, view, out),
            SunLookups::Summed(map) => map.by_mirrors(normal, view, out),
        }
    }

    /// Adds the direct irradiance of a receiver with this normal and sky, behind canopies, to
    /// `out[result]`.
    pub fn direct_behind(&self, normal: DVec3, sky: &SkyBitmap, veil: &CanopyTransmittance, out: &mut [f64]) {
        match self {
            SunLookups::Each(each) => each.direct_behind(normal, &mut &*sky, veil, out),
            SunLookups::Summed(map) => map.direct_behind(normal, sky, veil, out),
        }
    }
}
