//! Tiles of results. In: receivers, a series of conditions, the light that counts. Out: the tiles
//! of a replay, one after the other, handed to a sink. No other module of the program sets up a
//! replay.

use std::path::Path;

use super::archives::Archives;
use super::receivers::{PartReceivers, ReceiverSet};
use super::request::LightRequest;
use super::resources::Resources;
use super::series::{Coarsening, Series};
use crate::outputs::provenance::Provenance;
use crate::outputs::tables::layout::BinKind;
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Result};
use heliotile_core::observer::{Observer, Silent, Stage};
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::bands::BandPass;
use heliotile_core::replay::by_object::{DIRECT, GIVEN, ObjectReplay};
use heliotile_core::replay::components::ComponentSet;
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::replay::values::TileValues;

/// Number of tiles of the next archive that are fetched while the current one is computed.
const AHEAD: usize = 64;

impl LightRequest {
    /// Returns the number of sky patches for an archive.
    pub fn patches_of(&self, archive: &Archive) -> usize {
        self.patches.unwrap_or_else(|| archive.manifest().settings.patches())
    }
}

/// Replay of some receivers under a series, ready to be computed tile by tile.
#[derive(Clone, Copy)]
pub struct TileStream<'a> {
    /// Receivers, and the archives that hold them.
    pub receivers: &'a ReceiverSet<'a>,
    /// Light that counts.
    pub light: &'a LightRequest,
    /// Suns and skies.
    pub series: &'a Series,
    /// Resources that the computation may use.
    pub resources: Resources<'a>,
}

/// Results of neighbouring receivers.
pub struct Tile<'t> {
    /// Names of the receivers.
    pub ids: &'t [String],
    /// Irradiance of the receivers, for each label of the series.
    pub values: &'t TileValues,
    /// Irradiance of the same receivers in the other archive; only in a comparison.
    pub after: Option<&'t TileValues>,
}

impl<'t> Tile<'t> {
    /// Returns the irradiance in each archive.
    pub fn sides(&self) -> impl Iterator<Item = &'t TileValues> + use<'t> {
        std::iter::once(self.values).chain(self.after)
    }
}

/// Consumer of tiles.
pub trait TileSink {
    /// Returns the components that the sink needs.
    fn components(&self) -> ComponentSet;

    /// Prepares the sink; called before the first tile, once the replay is known to work.
    fn start(&mut self) -> Result<()> {
        Ok(())
    }

    /// Takes the next tile; returns false if no further one is wanted.
    fn take(&mut self, tile: &Tile) -> Result<bool>;
}

/// Function as a sink.
pub struct TileFn<F> {
    /// Components that the function needs.
    pub components: ComponentSet,
    /// Function that takes a tile and returns false if no further one is wanted.
    pub take: F,
}

impl<F: FnMut(&Tile) -> Result<bool>> TileSink for TileFn<F> {
    fn components(&self) -> ComponentSet {
        self.components
    }

    fn take(&mut self, tile: &Tile) -> Result<bool> {
        (self.take)(tile)
    }
}

/// Several sinks of the same tiles.
pub struct Sinks<'s>(pub Vec<&'s mut dyn TileSink>);

impl TileSink for Sinks<'_> {
    fn components(&self) -> ComponentSet {
        self.0.iter().fold(ComponentSet::new(&[]), |all, sink| all.union(sink.components()))
    }

    fn start(&mut self) -> Result<()> {
        self.0.iter_mut().try_for_each(|sink| sink.start())
    }

    fn take(&mut self, tile: &Tile) -> Result<bool> {
        let mut wants_more = false;
        for sink in &mut self.0 {
            wants_more |= sink.take(tile)?;
        }
        Ok(wants_more)
    }
}

/// Sinks of longer periods than those of the series; each tile is summed once for all of them.
pub struct CoarseSinks<'s> {
    sinks: Sinks<'s>,
    /// Map to the longer periods; `None` if the periods are equal.
    coarsening: Option<Coarsening>,
}

impl<'s> CoarseSinks<'s> {
    /// Returns sinks of the periods of `longer`, which are longer than those of `series` or equal
    /// to them.
    pub fn new(sinks: Vec<&'s mut dyn TileSink>, series: &Series, longer: &Series) -> Self {
        CoarseSinks { sinks: Sinks(sinks), coarsening: series.coarsening(longer) }
    }
}

impl TileSink for CoarseSinks<'_> {
    fn components(&self) -> ComponentSet {
        self.sinks.components()
    }

    fn start(&mut self) -> Result<()> {
        self.sinks.start()
    }

    fn take(&mut self, tile: &Tile) -> Result<bool> {
        let Some(coarsening) = &self.coarsening else { return self.sinks.take(tile) };
        let coarse = |values| coarsening.of(values, self.sinks.components());
        let (values, after) = (coarse(tile.values), tile.after.map(coarse));
        self.sinks.take(&Tile { ids: tile.ids, values: &values, after: after.as_ref() })
    }
}

impl<'a> TileStream<'a> {
    /// Returns the same receivers and light under another series, such as one of longer periods.
    #[must_use]
    pub fn with_series<'b>(&self, series: &'b Series) -> TileStream<'b>
    where
        'a: 'b,
    {
        TileStream { series, ..*self }
    }

    /// Returns the provenance of the results; `place` is the path of the archive or of the atlas.
    pub fn about(&self, archives: Archives, place: &Path) -> Provenance {
        let about = archives.told_in(self.series.provenance(), place);
        about.with_option("patches", self.light.patches_of(archives.first()))
    }

    /// Computes all tiles and hands each to `sink`, until it wants no more. Fails if the observer
    /// stops the work.
    pub fn feed(&self, sink: &mut dyn TileSink) -> Result<()> {
        let (parts, observer) = (self.receivers.parts(), self.resources.observer);
        let components = sink.components();
        let elsewhere = |name: &str| self.knows(name);
        let (mut started, mut progress) = (false, None);
        for (number, part) in parts.iter().enumerate() {
            // Many parts of an atlas may hold no requested receiver. A sink starts after one replay
            // is known to work.
            if part.tiles().is_empty() && (number + 1 < parts.len() || started) {
                continue;
            }
            let replay = self.replay_beside(part.archive, &part.site, components, &elsewhere)?;
            if !std::mem::replace(&mut started, true) {
                sink.start()?;
            }
            // Reading the next part overlaps with the computation of this one.
            let next = parts.get(number + 1..).and_then(|rest| rest.iter().find(|part| !part.tiles().is_empty()));
            if let Some(next) = next {
                let first: Vec<u32> = next.tiles().iter().take(AHEAD).map(|tile| tile.number).collect();
                replay.expect_of(&next.site, &first);
            }
            let progress = progress.get_or_insert_with(|| self.receivers.progress(observer));
            let goes_on = part.each_tile(&replay, observer, progress, |tile| sink.take(tile))?;
            if !goes_on {
                break;
            }
        }
        Ok(())
    }

    /// Computes all tiles of `components` and hands each to `take`, until it returns false.
    pub fn each(&self, components: ComponentSet, take: impl FnMut(&Tile) -> Result<bool>) -> Result<()> {
        self.feed(&mut TileFn { components, take })
    }

    /// Returns the replay of the series on an archive, for callers that ask for tiles by number.
    pub fn replay_of<'b>(
        &self,
        archive: &'b Archive,
        site: &OpenSite<'b>,
        components: ComponentSet,
    ) -> Result<Replay<'b>> {
        self.replay_beside(archive, site, components, &|_| false)
    }

    fn settings(&self, archive: &Archive, components: ComponentSet) -> Result<ReplaySettings<'_>> {
        let TileStream { light, ref resources, .. } = *self;
        Ok(ReplaySettings {
            sky: light.sky.model(),
            patches: light.patches_of(archive),
            paths: light.light_paths()?,
            components,
            memory: resources.memory,
            storage: resources.storage,
        })
    }

    /// Returns true if one of several archives knows a material or group of this name.
    fn knows(&self, name: &str) -> bool {
        let parts = self.receivers.parts();
        parts.len() > 1 && parts.iter().any(|part| part.changeable().knows(name))
    }

    /// Returns the replay of the series by object on one of the archives.
    pub fn by_object<'b>(&self, part: &PartReceivers<'b>) -> Result<ObjectReplay<'b>> {
        let TileStream { series, ref resources, .. } = *self;
        let components = ComponentSet::new(&[DIRECT.as_slice(), &GIVEN].concat());
        let settings = self.settings(part.archive, components)?;
        let schedules = series.schedules(part.archive, &part.site, &|name| self.knows(name), resources)?;
        let builder = Replay::builder(&part.site, &series.conditions, settings).summed(&series.bins);
        builder.scheduled(&schedules).build_by_object()
    }

    /// Returns the replay on one of several archives; `elsewhere` says whether another of them
    /// knows a name.
    fn replay_beside<'b>(
        &self,
        archive: &'b Archive,
        site: &OpenSite<'b>,
        components: ComponentSet,
        elsewhere: &dyn Fn(&str) -> bool,
    ) -> Result<Replay<'b>> {
        let TileStream { light, series, ref resources, .. } = *self;
        let settings = self.settings(archive, components)?;
        let schedules = series.schedules(archive, site, elsewhere, resources)?;
        let mut bands = BandPass::all(site, components, &light.bands.own);
        // The observer already got all messages about schedules with those of all light.
        let quietly = Resources { observer: &Silent, ..*resources };
        for pass in &mut bands {
            pass.schedules = series.schedules(archive, &pass.site, elsewhere, &quietly)?;
        }
        let builder = Replay::builder(site, &series.conditions, settings).summed(&series.bins).scheduled(&schedules);
        builder.with_bands(&bands, series.kind == BinKind::Sums).build()
    }
}

impl ReceiverSet<'_> {
    /// Begins a stage of progress that counts receivers.
    pub fn progress<'o>(&self, observer: &'o dyn Observer) -> Stage<'o> {
        Stage::begin(observer, "receivers", Some(self.count()))
    }
}

impl PartReceivers<'_> {
    /// Hands the chosen results of a replay to `each`, tile by tile, until it returns false.
    /// Returns true if it never did. Fails if the observer stops the work.
    pub fn each_tile(
        &self,
        replay: &Replay,
        observer: &dyn Observer,
        progress: &Stage,
        mut each: impl FnMut(&Tile) -> Result<bool>,
    ) -> Result<bool> {
        let results = replay.results(self.tiles().iter().map(|tile| tile.number));
        for (tile, result) in self.tiles().iter().zip(results) {
            let (ids, values) = result?;
            let (ids, values) = self.results(*tile, ids, values);
            let goes_on = each(&Tile { ids: &ids, values: &values, after: None })?;
            progress.advance(ids.len() as u64);
            if !goes_on {
                return Ok(false);
            }
            if observer.cancelled() {
                return Err(Error::Stopped { what: "before all receivers were replayed".into() });
            }
        }
        Ok(true)
    }
}
