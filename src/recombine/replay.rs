//! A replay: an archive under a series of conditions, tile by tile. It reads and multiplies; it cannot cast a ray.

use super::bounces::Depth;
use super::conditions::Condition;
use super::load::{Tables, cached_responses, sides, tile_layers, tile_view};
use super::patches::Patches;
use super::response::Responder;
use super::sky::SkyModel;
use super::tile::Forcing;
use super::values::TileValues;
use crate::archive::Archive;
use crate::error::Result;
use crate::layers::response::Response;

/// Choices of a replay that the weather does not make.
#[derive(Clone, Copy, Debug)]
pub struct ReplaySettings {
    pub sky: SkyModel,
    /// Number of sky patches: 145, 577 or 2305.
    pub patches: usize,
    pub depth: Depth,
}

/// An archive with its weather, ready to give tile after tile.
pub struct Replay<'a> {
    archive: &'a Archive,
    forcing: Forcing,
    /// Only where the archive's own responses do not serve.
    responder: Option<Responder>,
}

impl<'a> Replay<'a> {
    pub fn new(archive: &'a Archive, conditions: &[Condition], settings: ReplaySettings) -> Result<Self> {
        let patches = Patches::new(settings.patches)?;
        let forcing = Forcing::new(conditions, settings.sky, &patches, sides(archive.manifest()));
        let responder = match settings.depth {
            Depth::All => None,
            depth @ Depth::Count(_) => {
                let t = Tables::load(archive)?;
                Some(Responder::new(t.probes, t.bounces, t.shape, t.reflectors, depth))
            }
        };
        Ok(Replay { archive, forcing, responder })
    }

    /// Number of tiles.
    pub fn tiles(&self) -> u32 {
        self.archive.tiles()
    }

    /// Receiver ids and irradiance of one tile: [component][receiver][condition], W/m2.
    pub fn tile(&self, tile: u32) -> Result<(Vec<String>, TileValues)> {
        let responses: Vec<Response> = match &self.responder {
            None => cached_responses(self.archive, tile)?,
            Some(responder) => {
                let view = tile_view(self.archive, tile)?;
                view.viewers.iter().enumerate().map(|(i, viewer)| responder.derive(&view.hits, i, viewer)).collect()
            }
        };
        let (ids, layers) = tile_layers(self.archive, tile, responses)?;
        Ok((ids, self.forcing.replay(&layers)))
    }
}
