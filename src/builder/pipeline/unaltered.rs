//! Tiles that a change of the scene leaves as they were. In: an archive of the scene before, a tile
//! of receivers. Out: the blocks of that archive, copied, if it holds these receivers and none of
//! their rays meets the change.

use std::sync::atomic::Ordering;

use super::previous_build::PreviousBuild;
use super::site_tracer::SiteTracer;
use super::tiles::{BLIND, TracedTile};
use crate::settings::Effect;
use crate::trace::sky_fans::SkyFans;
use heliotile_archives::pack::{self, COMPRESSION};
use heliotile_core::archive::format::{BlockKind, TileNumber};
use heliotile_core::archive::{EncodedBlock, format, tables};
use heliotile_core::error::Result;
use heliotile_core::layers::hit::HitTile;
use heliotile_core::site::receiver::Receiver;

impl PreviousBuild<'_> {
    /// Copies a block of the archive, under another number.
    fn copy(&self, kind: BlockKind, tile: TileNumber, to: TileNumber) -> Result<Option<EncodedBlock>> {
        let Some(entry) = self.file.entry(kind, tile) else { return Ok(None) };
        let mut block = self.file.copy(entry)?;
        block.entry.tile = to;
        Ok(Some(block))
    }

    /// Returns the hits of `receivers` receivers of a tile, with the present numbers of materials.
    /// `None` if they are damaged or one of their materials is gone.
    fn tile_hits(&self, tile: u32, receivers: usize) -> Option<HitTile> {
        let mut hits = self.archive.hits(tile, receivers)?;
        for key in &mut hits.palette {
            *key = self.now(*key)?;
        }
        Some(hits)
    }

    /// Returns the block of these hits under another number.
    fn hits_block(&self, tile: TileNumber, to: TileNumber, receivers: usize) -> Result<Option<EncodedBlock>> {
        if self.same_numbers {
            return Ok(self.copy(format::HIT, tile, to).ok().flatten());
        }
        self.tile_hits(tile.0, receivers).map(|hits| pack::hits(to, receivers, &hits)).transpose()
    }
}

impl SiteTracer<'_> {
    /// Returns the blocks of a tile that the change does not alter; `None` for any other tile.
    pub(super) fn unaltered_tile(
        &self,
        number: TileNumber,
        receivers: &[Receiver],
        fans: &SkyFans,
    ) -> Result<Option<TracedTile>> {
        let Some(before) = &self.before else { return Ok(None) };
        // Mirrors and canopies show more of the scene than rays to the sky and to first hits do,
        // and an archive without reflections holds no hits.
        let canopies = self.canopies.is_some() && before.of_canopies;
        let mirrors = self.reflections.is_some() || before.file.has(format::MIRRORS, TileNumber::FIRST);
        if !before.same_classes || mirrors || canopies || self.leaves_scatter() || !self.traces(Effect::Diffuse) {
            return Ok(None);
        }
        let Some((from, table)) = before.archive.tile_of(receivers) else { return Ok(None) };
        // A receiver's own rays do not tell if light reaches it when it sees no sky. The factor 2
        // allows for the f32 values of the table.
        let blind = || table.sky_view.iter().any(|view| f64::from(*view) < 2.0 * BLIND);
        if blind() || self.alters(before, from, receivers, fans) {
            return Ok(None);
        }
        let table = tables::ReceiversTable::new(receivers.iter().zip(table.views()));
        // A damaged block is traced again.
        let Ok(Some(sky)) = before.copy(format::SKY, TileNumber(from), number) else { return Ok(None) };
        let Some(hits) = before.hits_block(TileNumber(from), number, receivers.len())? else { return Ok(None) };
        let mut blocks = vec![table.encode(format::RECEIVERS, number, COMPRESSION)?, sky, hits];
        let parts = tables::PartsTable::new(receivers);
        blocks.extend(parts.map(|parts| parts.encode(format::PARTS, number, COMPRESSION)).transpose()?);
        match before.copy(format::CANOPY, TileNumber(from), number) {
            Ok(None) => {}
            Ok(Some(canopy)) if before.same_numbers => blocks.push(canopy),
            _ => return Ok(None),
        }
        let Some(HitTile { palette: cells, .. }) = before.tile_hits(from, receivers.len()) else { return Ok(None) };
        before.receivers.fetch_add(receivers.len() as u64, Ordering::Relaxed);
        Ok(Some(TracedTile { blocks, cells, ..TracedTile::default() }))
    }

    /// Returns true if the change alters what some receivers of a tile see, or if that cannot be
    /// read.
    fn alters(&self, before: &PreviousBuild, from: u32, receivers: &[Receiver], fans: &SkyFans) -> bool {
        let views = receivers.iter().map(|receiver| self.viewpoint(receiver));
        let views: Vec<_> = views.map(|view| (view, before.seen(&view, self))).collect();
        let towards = || views.iter().enumerate().filter(|(_, (_, seen))| !seen.is_nothing());
        if towards().any(|(_, (view, seen))| before.alters_hits(view, seen, self)) {
            return true;
        }
        let touched: Vec<usize> = towards()
            .filter(|(_, (view, seen))| view.parts_towards(seen, fans).contains(&true))
            .map(|(row, _)| row)
            .collect();
        if touched.is_empty() {
            return false;
        }
        // The tile is decoded only if the change may show in some sky.
        let Some(layers) = before.archive.tile(from) else { return true };
        touched.into_iter().any(|row| {
            let Some(Some(known)) = layers.get(row) else { return true };
            let (view, seen) = &views[row];
            before.sky(view, known, seen, fans, self).texture != known.sky
        })
    }
}
