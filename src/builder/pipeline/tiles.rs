//! Tiles of a build. In: 64 receivers. Out: their layers, traced, packed and compressed.

use std::sync::Arc;

use glam::DVec3;

use rayon::prelude::*;

use super::previous_build::PreviousBuild;
use super::report::{Clock, RayCounts};
use super::site_tracer::SiteTracer;
use crate::pipeline::layer_cache::KnownReceiver;
use crate::receiver_tiles::ReceiverTiles;
use crate::settings::Effect;
use crate::trace::hidden::is_reached;
use crate::trace::placement::is_enclosed;
use crate::trace::receiver::{CellSettings, HitTrace, SkyTrace};
use crate::trace::sky_fans::SkyFans;
use crate::trace::viewpoint::Viewpoint;
use heliotile_archives::pack;
use heliotile_archives::writing::Writer;
use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::{EncodedBlock, format, tables};
use heliotile_core::error::Result;
use heliotile_core::layers::bits::BitSquare;
use heliotile_core::layers::canopy::Canopy;
use heliotile_core::layers::extras::ReceiverExtras;
use heliotile_core::layers::hit::HitTile;
use heliotile_core::layers::mirror::ReceiverMirrors;
use heliotile_core::layers::response::Response;
use heliotile_core::layers::sky::SkyTexture;
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::light::response::{Viewer, view_factors};
use heliotile_core::light::response_solver::ResponseSolver;
use heliotile_core::light::tables::Tables;
use heliotile_core::light::tile_view::TileView;
use heliotile_core::memory::Use;
use heliotile_core::observer::Stage;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::tile::sky_view_factor;
use heliotile_core::site::cells::CellKey;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::{Message, counted, with_list};
use heliotile_files::spill::{Sorter, TempFiles};

/// Sky view below which an enclosed receiver counts as inside a solid.
pub(super) const BLIND: f64 = 1e-4;

/// Number of tiles whose responses are derived together, because they see many of the same cells.
const GROUP: usize = 16;

/// Traced tile: its blocks in the order of writing, and facts for the rest of the build.
#[derive(Default)]
pub(super) struct TracedTile {
    pub blocks: Vec<EncodedBlock>,
    pub cells: Vec<CellKey>,
    pub rays: RayCounts,
    pub misplaced: Vec<Misplaced>,
}

/// Receiver at a place where it can hardly be intended.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Misplaced {
    /// Receiver in a solid or below the terrain: it sees no sky, and steep rays cross an odd number
    /// of surfaces.
    Inside(String),
    /// Receiver with a surface this close in front of it, metres.
    Touching(String, f64),
}

/// Number of receivers that the first line of a warning names.
const MAX_NAMES: usize = 3;

/// Returns one warning for each kind of misplacement with the names of the receivers. More than a
/// few names follow as a list.
pub(super) fn warnings(misplaced: &[Misplaced]) -> Vec<Message> {
    let mut inside = Vec::new();
    let mut touching = Vec::new();
    for m in misplaced {
        match m {
            Misplaced::Inside(id) => inside.push(id.clone()),
            Misplaced::Touching(id, metres) => touching.push(format!("{id} ({:.2} mm)", metres * 1e3)),
        }
    }
    let say = |list: Vec<String>, one: &str, many: &str| {
        let shown = list.len().min(MAX_NAMES);
        let (count, what) = (counted(list.len() as u64, "receiver"), if list.len() == 1 { one } else { many });
        let sentence = format!("{count} {what}: {}", list[..shown].join(", "));
        (shown > 0).then(|| match list.len() - shown {
            0 => sentence.into(),
            more => with_list(format!("{sentence} and {more} more"), list),
        })
    };
    [
        say(
            inside,
            "lies inside a solid or below the terrain and sees no sky",
            "lie inside a solid or below the terrain and see no sky",
        ),
        say(
            touching,
            "has a surface right in front of it: check that it is on the right side",
            "have a surface right in front of them: check that they are on the right side",
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Traced receiver.
struct Traced {
    sky: SkyTexture,
    hits: HitTrace,
    viewer: Viewer,
    extras: ReceiverExtras,
    rays: RayCounts,
}

impl SiteTracer<'_> {
    /// Traces and writes the receivers' tiles, and adds misplaced receivers to `misplaced`. Returns
    /// the keys of all cells that they see, sorted, each once.
    pub fn write_receivers(
        &self,
        receivers: &mut ReceiverTiles,
        writer: &mut Writer,
        rays: &mut RayCounts,
        misplaced: &mut Vec<Misplaced>,
    ) -> Result<impl Iterator<Item = Result<CellKey>> + use<>> {
        let progress = Stage::begin(self.observer, "receivers", Some(receivers.count() as u64));
        let fans = SkyFans::new(self.settings.sky_base, self.settings.sky_fine);
        let mut keys = Sorter::new(&self.folder, self.memory.length(Use::CellKeys)).unique();
        let mut tiles = receivers.tiles()?.peekable();
        let mut first = 0;
        while tiles.peek().is_some() {
            let batch: Vec<Vec<Receiver>> =
                tiles.by_ref().take(rayon::current_num_threads() * 2).collect::<Result<_>>()?;
            let traced: Vec<Result<TracedTile>> = batch
                .par_iter()
                .enumerate()
                .map(|(i, tile)| self.tile(first + i as u32, tile, &fans, writer))
                .collect();
            // Tiles are appended in order, so that the bytes do not depend on threads.
            for tile in traced {
                let tile = tile?;
                tile.blocks.into_iter().try_for_each(|block| writer.append(block))?;
                tile.cells.iter().try_for_each(|key| keys.push(&key.to_bytes(), &[]))?;
                rays.sky += tile.rays.sky;
                rays.hit += tile.rays.hit;
                rays.mirror += tile.rays.mirror;
                rays.canopy += tile.rays.canopy;
                misplaced.extend(tile.misplaced);
            }
            first += batch.len() as u32;
            progress.advance(batch.iter().map(|t| t.len() as u64).sum());
            self.checkpoint(writer)?;
        }
        drop(progress);
        let key = |record: Result<(Vec<u8>, Vec<u8>)>| {
            let mut bytes = [0; CellKey::BYTES];
            bytes.copy_from_slice(&record?.0);
            Ok(CellKey::from_bytes(&bytes))
        };
        Ok(keys.finish()?.map(key))
    }

    /// Returns a tile that the file already holds, or traces it.
    fn tile(&self, number: u32, receivers: &[Receiver], fans: &SkyFans, writer: &Writer) -> Result<TracedTile> {
        if [format::RECEIVERS, format::SKY, format::HIT].iter().all(|&kind| writer.has(kind, TileNumber(number))) {
            let site = OpenSite::over(writer, Arc::clone(&self.facts));
            let (hits, table) = (site.tile_hits(number, receivers.len())?, site.tile_receivers(number)?);
            let inside = receivers.iter().zip(&table.sky_view).filter(|(r, view)| self.inside(r, f64::from(**view)));
            let misplaced = inside.map(|(receiver, _)| Misplaced::Inside(receiver.id.clone())).collect();
            let mirrors = site.tile_mirrors(number, receivers.len())?;
            let leaves = site.tile_canopies(number, receivers.len())?;
            let besides = mirrors.iter().flat_map(ReceiverMirrors::cells).chain(leaves.iter().flat_map(Canopy::cells));
            let cells = hits.palette.into_iter().chain(besides).collect();
            return Ok(TracedTile { cells, misplaced, ..TracedTile::default() });
        }
        match self.unaltered_tile(TileNumber(number), receivers, fans)? {
            Some(tile) => Ok(tile),
            None => self.trace_tile(number, receivers, fans),
        }
    }

    /// Derives and writes the responses of all tiles.
    pub fn write_responses(&self, tiles: u32, writer: &mut Writer, clock: &mut Clock) -> Result<()> {
        let missing: Vec<u32> = (0..tiles).filter(|&tile| !writer.has(format::RESPONSE, TileNumber(tile))).collect();
        if missing.is_empty() {
            return Ok(());
        }
        let tables = Tables::new(&OpenSite::over(&*writer, Arc::clone(&self.facts)))?;
        let storage = TempFiles::new(&self.folder);
        let responder = ResponseSolver::new(&tables, MaxBounces::All, self.memory, &storage)?;
        clock.lap("solve");
        let progress = Stage::begin(self.observer, "responses", Some(u64::from(tiles)));
        for group in missing.chunks(GROUP) {
            let site = OpenSite::over(&*writer, Arc::clone(&self.facts));
            let view = |&tile: &u32| TileView::read(&site, tile);
            let views: Vec<TileView> = group.par_iter().map(view).collect::<Result<_>>()?;
            let responses = responder.derive(&Tables::new(&site)?, &views)?;
            // There is one state only, that of the stored reflectances.
            let encode = |(&tile, states): (&u32, &Vec<Vec<Response>>)| pack::responses(TileNumber(tile), &states[0]);
            let blocks: Vec<EncodedBlock> = group.par_iter().zip(&responses).map(encode).collect::<Result<_>>()?;
            blocks.into_iter().try_for_each(|block| writer.append(block))?;
            progress.advance(group.len() as u64);
            self.checkpoint(writer)?;
        }
        drop(progress);
        clock.lap("response");
        Ok(())
    }

    /// Traces and packs one tile.
    fn trace_tile(&self, number: u32, receivers: &[Receiver], fans: &SkyFans) -> Result<TracedTile> {
        let known = self.known.receivers(receivers);
        let before = match &self.before {
            Some(before) => before.receivers(receivers).into_iter().map(|known| known.zip(Some(before))).collect(),
            None => receivers.iter().map(|_| None).collect::<Vec<_>>(),
        };
        let traced: Vec<Traced> = receivers
            .par_iter()
            .zip(known.into_par_iter().zip(before))
            .map(|(receiver, known)| match known {
                (Some(known), _) => self.known_receiver(receiver, known, fans),
                (None, Some((known, before))) => self.changed_receiver(receiver, &known, before, fans),
                (None, None) => self.trace_receiver(receiver, fans),
            })
            .collect();
        let misplaced = receivers.iter().zip(&traced).filter_map(|(r, t)| self.misplaced(r, t)).collect();
        let mut rays = RayCounts::default();
        let (mut sky, mut cells, mut viewers, mut extras) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for t in traced {
            rays.sky += t.rays.sky;
            rays.hit += t.rays.hit;
            rays.mirror += t.rays.mirror;
            rays.canopy += t.rays.canopy;
            sky.push(t.sky);
            cells.push(t.hits.cells);
            viewers.push(t.viewer);
            extras.push(t.extras);
        }
        let mut hits = HitTile::new(&cells);
        let table = self.receivers_table(receivers, &hits, &viewers);
        if !self.traces(Effect::Diffuse) {
            // Hits were only needed for the view factors.
            hits = HitTile { palette: Vec::new(), texels: vec![0; hits.texels.len()] };
        }
        let parts = tables::PartsTable::new(receivers);
        let blocks = pack::tile(TileNumber(number), &table, parts.as_ref(), &sky, Some(&hits), &extras)?;
        let besides = extras.iter().flat_map(|of| of.mirrors.cells().chain(of.canopy.cells()));
        let cells = hits.palette.into_iter().chain(besides).collect();
        Ok(TracedTile { blocks, cells, rays, misplaced })
    }

    /// Returns a receiver that an earlier build traced, as if it had been traced now.
    fn known_receiver(&self, receiver: &Receiver, known: KnownReceiver, fans: &SkyFans) -> Traced {
        let view = self.viewpoint(receiver);
        // An archive without reflections holds no hits, but view factors need them.
        let hits = match self.traces(Effect::Diffuse) {
            true => {
                HitTrace { cells: known.hits, nearest_m: f64::INFINITY, mirrors: Vec::new(), distances_m: Vec::new() }
            }
            false => self.trace_hits(&view),
        };
        let viewer = viewer(&view, &known.dense, fans);
        Traced { sky: known.sky, hits, viewer, extras: known.extras, rays: RayCounts::default() }
    }

    pub(super) fn viewpoint(&self, receiver: &Receiver) -> Viewpoint {
        Viewpoint { position: receiver.position, normal: receiver.normal }
    }

    fn trace_receiver(&self, receiver: &Receiver, fans: &SkyFans) -> Traced {
        let view = self.viewpoint(receiver);
        self.trace_rest(&view, view.sky(fans, self.tracer), None, fans)
    }

    /// Traces a receiver that was traced before the scene was changed, with rays only where the
    /// change may show.
    fn changed_receiver(
        &self,
        receiver: &Receiver,
        known: &KnownReceiver,
        before: &PreviousBuild,
        fans: &SkyFans,
    ) -> Traced {
        let view = self.viewpoint(receiver);
        let seen = before.seen(&view, self);
        let sky = before.sky(&view, known, &seen, fans, self);
        let hits = before.hits(&view, known, &seen, self);
        self.trace_rest(&view, sky, hits, fans)
    }

    /// Traces all layers of a receiver but its sky, and but its hits if they are known.
    fn trace_rest(&self, view: &Viewpoint, sky: SkyTrace, hits: Option<HitTrace>, fans: &SkyFans) -> Traced {
        let SkyTrace { texture, bits, rays } = sky;
        let mut rays = RayCounts { sky: rays, ..RayCounts::default() };
        let viewer = viewer(view, &bits, fans);
        let blind = viewer.sky_view < BLIND;
        let mut hits = hits.filter(|_| !blind).unwrap_or_else(|| {
            rays.hit = (self.settings.hit * self.settings.hit) as u64;
            self.trace_hits(view)
        });
        let lit = !blind || self.is_reached(view);
        if !lit {
            // The cells that it sees may also hold surfaces in the light.
            hits.cells.iter_mut().flatten().for_each(|cell| *cell = CellKey::dark(cell.material));
            hits.mirrors.clear();
        }
        let paths = self.mirror_paths(view, &hits, &mut rays.mirror);
        let windows = self.mirror_windows(view, &mut rays.mirror);
        let mirrors = ReceiverMirrors { windows, paths };
        let (canopy, cast) = self.canopy_of_receiver(view, &bits, &hits, lit);
        rays.canopy = cast;
        Traced { sky: texture, hits, viewer, extras: ReceiverExtras { mirrors, canopy }, rays }
    }

    /// Returns true if light reaches a place that sees no sky.
    pub(super) fn is_reached(&self, view: &Viewpoint) -> bool {
        let origin = self.tracer.grid().lifted(view.position, view.normal);
        is_reached(origin, view.normal, view.seed(), &self.scene.mesh, self.tracer)
    }

    /// Traces the first hits of a receiver.
    pub(super) fn trace_hits(&self, view: &Viewpoint) -> HitTrace {
        let (n, mesh) = (self.settings.hit, &self.scene.mesh);
        view.hits(n, self.cell_settings(), mesh, self.tracer, self.reflections.as_ref())
    }

    /// Returns the sizes of the cells that hits are gathered into.
    pub(super) fn cell_settings(&self) -> CellSettings {
        CellSettings { factor: self.settings.cell_factor(), floor_m: self.settings.cell_floor_m }
    }

    /// Returns how a receiver is misplaced, or `None` if it is not.
    fn misplaced(&self, receiver: &Receiver, traced: &Traced) -> Option<Misplaced> {
        if self.inside(receiver, traced.viewer.sky_view) {
            return Some(Misplaced::Inside(receiver.id.clone()));
        }
        let (grid, nearest_m) = (self.tracer.grid(), traced.hits.nearest_m);
        (nearest_m < 2.0 * grid.offset_m(receiver.position)).then(|| {
            // Rays start on the grid, so their offset is a little more or less.
            let start = DVec3::from(grid.lifted(receiver.position, receiver.normal).map(f64::from));
            let lifted_m = (grid.absolute(start) - receiver.position).dot(receiver.normal);
            Misplaced::Touching(receiver.id.clone(), nearest_m + lifted_m)
        })
    }

    /// Returns true if a receiver with this sky view is inside a solid. Few receivers are blind, so
    /// the costly test is rare.
    fn inside(&self, receiver: &Receiver, sky_view: f64) -> bool {
        sky_view < BLIND && is_enclosed(&self.viewpoint(receiver), &self.scene.mesh, self.tracer)
    }

    fn receivers_table(&self, receivers: &[Receiver], hits: &HitTile, viewers: &[Viewer]) -> tables::ReceiversTable {
        let reflectors = &self.reflectors;
        let texels = self.settings.hit * self.settings.hit;
        let views = viewers.iter().zip(hits.texels.chunks(texels)).map(|(viewer, texels)| {
            let [ground, obstruction] = view_factors(texels, hits, reflectors, viewer);
            [viewer.sky_view, ground, obstruction].map(|share| share as f32)
        });
        tables::ReceiversTable::new(receivers.iter().zip(views))
    }
}

/// Returns the facts of a receiver with these sky bits that its responses need besides its hits.
fn viewer(view: &Viewpoint, sky: &BitSquare, fans: &SkyFans) -> Viewer {
    let sky_view = sky_view_factor(view.normal, sky, fans.centres()).min((1.0 + view.normal.z) / 2.0);
    Viewer { normal: view.normal, seed: view.seed(), sky_view }
}
