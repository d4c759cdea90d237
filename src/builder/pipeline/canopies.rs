//! The canopy layers of a build: what rays of receivers and cells cross on their way. Nothing where a scene has no canopies.

use super::site_tracer::SiteTracer;
use crate::trace::canopy::{CellCrossings, Path};
use crate::trace::receiver::{HitTrace, Viewpoint};
use heliotile_core::hemisphere::texels_in_blocks;
use heliotile_core::layers::bits::BitSquare;
use heliotile_core::layers::canopy::{Canopy, sky_side};

impl SiteTracer<'_> {
    /// What the rays of a receiver with these sky bits and hits cross, and the rays cast.
    pub(super) fn canopy_of_receiver(&self, view: &Viewpoint, sky: &BitSquare, hits: &HitTrace) -> (Canopy, u64) {
        let Some(canopies) = self.canopies else { return (Canopy::default(), 0) };
        let side = sky_side(self.settings.sky_base, self.settings.sky_fine);
        let block = sky.side() / side;
        // Where no sky is seen no leaf can dim it.
        let open = |&(column, row): &(usize, usize)| block > 64 || sky.count_block(block, column, row) > 0;
        let texels = texels_in_blocks(side).filter(open).map(|(column, row)| row * side + column);
        let sky = view.sky_paths(side, texels, self.tracer);
        let seen: Vec<Path> = view.hit_paths(self.settings.hit, &hits.distances_m, self.tracer);
        let rays = [side * side, self.settings.hit * self.settings.hit];
        let canopy = Canopy::new([&canopies.crossings(&sky), &canopies.crossings(&seen)], rays);
        (canopy, (sky.len() + seen.len()) as u64)
    }
}

/// What the rays of a cell cross, with so many texels a side and rays to what it sees.
pub(super) fn canopy_of_cell(crossings: &CellCrossings, side: usize, rays: usize) -> Canopy {
    Canopy::new([&crossings.sky, &crossings.seen], [side * side, rays])
}
