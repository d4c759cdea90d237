//! Canopy layers of a build. In: rays of receivers and cells. Out: the leaves and screens that they
//! cross, and the cells of leaves that they see; nothing if the scene has no canopies.

use rayon::prelude::*;

use super::site_tracer::SiteTracer;
use crate::receiver_tiles::ReceiverTiles;
use crate::settings::Effect;
use crate::trace::canopy::{Canopies, CellCrossings, LeafView, Passage, Path, SeenLeaves};
use crate::trace::receiver::HitTrace;
use crate::trace::viewpoint::Viewpoint;
use heliotile_core::error::Result;
use heliotile_core::hemisphere::{HEMISPHERE_SR, texels_in_blocks};
use heliotile_core::layers::bits::BitSquare;
use heliotile_core::layers::canopy::{Canopy, SeenLeaf, coarse_step, sky_side};
use heliotile_core::site::cells::{CellKey, level_of};

impl SiteTracer<'_> {
    /// Returns true if leaves scatter light that is traced.
    pub(super) fn leaves_scatter(&self) -> bool {
        self.traces(Effect::Leaves)
            && self.traces(Effect::Diffuse)
            && self.canopies.is_some_and(|canopies| canopies.scatter())
    }

    /// Counts the receivers that stand in closed hulls of canopies.
    pub(super) fn count_in_hulls(&self, receivers: &mut ReceiverTiles) -> Result<u64> {
        let Some(canopies) = self.canopies else { return Ok(0) };
        let mut count = 0;
        for tile in receivers.tiles()? {
            count += tile?.par_iter().filter(|receiver| canopies.holds(receiver.position)).count() as u64;
        }
        Ok(count)
    }

    /// Returns the view of cells on leaves. Cells that see no surfaces see no scattering leaves,
    /// either.
    pub(super) fn leaf_view(&self, sees_surfaces: bool) -> Option<LeafView<'_>> {
        let closed_level = (sees_surfaces && self.leaves_scatter()).then(|| level_of(self.settings.closed_m));
        self.canopies.map(|canopies| LeafView { canopies, closed_level })
    }

    /// Returns the crossings of the rays of a receiver with these sky bits and hits, and the number
    /// of rays cast. `lit` is true if light reaches the receiver.
    pub(super) fn canopy_of_receiver(
        &self,
        view: &Viewpoint,
        sky: &BitSquare,
        hits: &HitTrace,
        lit: bool,
    ) -> (Canopy, u64) {
        let Some(canopies) = self.canopies else { return (Canopy::default(), 0) };
        let side = sky_side(self.settings.sky_base, self.settings.sky_fine);
        // A leaf cannot dim sky that is not seen; light at its edge is interpolated with the texels
        // beside it.
        let coarse = side / coarse_step(side);
        let block = sky.side() / coarse;
        let shown: Vec<bool> =
            (0..coarse * coarse).map(|i| block > 64 || sky.count_block(block, i % coarse, i / coarse) > 0).collect();
        let open = |&(column, row): &(usize, usize)| {
            let near = |at: usize| at.saturating_sub(1)..(at + 2).min(coarse);
            near(row).any(|row| near(column).any(|column| shown[row * coarse + column]))
        };
        let tiles: Vec<(usize, usize)> = texels_in_blocks(coarse).filter(open).collect();
        let (sky, to_sky) = canopies.towards_sky(view, side, &tiles, self.tracer);
        let (n, scatter) = (self.settings.hit, lit && self.leaves_scatter());
        let seen: Vec<Path> = view.hit_paths(n, &hits.distances_m, scatter, self.tracer);
        let (rays, cast) = ([side * side, n * n], to_sky + seen.len() as u64);
        let mut passages = canopies.passages(&seen);
        let leaves = if scatter { self.leaves_of_receiver(view, canopies, &passages) } else { Vec::new() };
        passages.retain(|passage| hits.distances_m[passage.place as usize].is_finite());
        let crossings = [&sky[..], &canopies.counted(&passages)];
        (Canopy::new(crossings, rays, leaves).with_predicted(), cast)
    }

    /// Returns the cells of leaves that a receiver with these hits sees; none if leaves scatter
    /// nothing.
    pub(super) fn leaf_cells(&self, view: &Viewpoint, hits: &HitTrace) -> Vec<CellKey> {
        let Some(canopies) = self.canopies.filter(|_| self.leaves_scatter()) else { return Vec::new() };
        let paths = view.hit_paths(self.settings.hit, &hits.distances_m, true, self.tracer);
        let leaves = self.leaves_of_receiver(view, canopies, &canopies.passages(&paths));
        leaves.into_iter().map(|leaf| leaf.cell).collect()
    }

    /// Returns the leaves on the way of a receiver's hit rays.
    fn leaves_of_receiver(&self, view: &Viewpoint, canopies: &Canopies, passages: &[Passage]) -> Vec<SeenLeaf> {
        let n = self.settings.hit;
        let (texel_sr, direction) = (HEMISPHERE_SR / (n * n) as f64, view.hit_directions(n));
        let mut leaves = SeenLeaves::new(canopies);
        for passage in passages {
            let share = view.normal.dot(direction(passage.place as usize)) * 2.0 / (n * n) as f64;
            leaves.add(passage, share, |leaf| leaf.cell(self.cell_settings().level(leaf.distance_m, texel_sr.sqrt())));
        }
        leaves.gathered(n * n / 2, view.seed())
    }
}

/// Packs the crossings of the rays of a cell, with `side` sky texels a side and `rays` rays to its
/// surroundings.
pub(super) fn canopy_of_cell(crossings: CellCrossings, side: usize, rays: usize) -> Canopy {
    Canopy::new([&crossings.sky, &crossings.seen], [side * side, rays], crossings.leaves)
}
