//! Tiles of results. In: archives, a series of conditions, choices of light. Out: a replay of them, or its tiles one after the other.

use super::chosen::{Chosen, ChosenPart};
use super::series::Series;
use heliotile_builder::observer::{Observer, Stage};
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Result};
use heliotile_core::light::paths::LightPaths;
use heliotile_core::light::scratch::ScratchSpace;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::ComponentSet;
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::replay::values::TileValues;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::formats::schedule_csv::ReadFile;

/// Tiles of the next part that come while one is computed.
const AHEAD: usize = 64;

/// Choices that neither the archive nor the weather makes.
#[derive(Clone, Copy)]
pub struct Recombination<'a> {
    /// How the sky's radiance is spread.
    pub sky: SkyModel,
    /// Number of sky patches; none: what the archive was built for.
    pub patches: Option<usize>,
    /// Which light counts.
    pub paths: LightPaths,
    /// Bytes to work in.
    pub memory: MemoryBudget,
    /// Where goes what does not fit.
    pub storage: &'a dyn ScratchSpace,
    /// How the bytes of schedules are got.
    pub files: ReadFile<'a>,
}

impl Recombination<'_> {
    /// The number of sky patches on an archive.
    pub fn patches_of(&self, archive: &Archive) -> usize {
        self.patches.unwrap_or_else(|| archive.manifest().settings.patches())
    }
}

/// The replay of a series, ready to give tiles; `observer` is told what is doubtful about reflectances.
pub fn replay_of<'a>(
    place: (&'a Archive, &OpenSite<'a>),
    asked: &Recombination,
    series: &Series,
    components: ComponentSet,
    observer: &dyn Observer,
) -> Result<Replay<'a>> {
    replay_beside(place, &|_| false, asked, series, components, observer)
}

/// The same of one of several archives; `elsewhere` tells whether one of them knows a name.
fn replay_beside<'a>(
    (archive, site): (&'a Archive, &OpenSite<'a>),
    elsewhere: &dyn Fn(&str) -> bool,
    asked: &Recombination,
    series: &Series,
    components: ComponentSet,
    observer: &dyn Observer,
) -> Result<Replay<'a>> {
    let settings = ReplaySettings {
        sky: asked.sky,
        patches: asked.patches_of(archive),
        paths: asked.paths,
        components,
        memory: asked.memory,
        storage: asked.storage,
    };
    let schedules = series.schedules((archive, site), elsewhere, asked.files, observer)?;
    Replay::scheduled(site, &series.conditions, settings, &series.bins, &schedules)
}

/// Which receivers and components are recombined.
pub struct Streamed<'a> {
    /// Receivers of an archive or of several,
    pub chosen: &'a Chosen<'a>,
    /// and the columns that are asked for.
    pub components: ComponentSet,
}

impl Streamed<'_> {
    /// Hands on the results tile by tile until `each` gives false. What takes them starts once the replay is known to work, that of the first
    /// archive if there are several. An error, too: an observer who wants the work to stop.
    pub fn each_tile<T>(
        &self,
        asked: &Recombination,
        series: &Series,
        observer: &dyn Observer,
        start: impl FnOnce() -> Result<T>,
        mut each: impl FnMut(&mut T, &[String], &TileValues) -> Result<bool>,
    ) -> Result<T> {
        let parts = self.chosen.parts();
        let elsewhere = |name: &str| parts.len() > 1 && parts.iter().any(|part| part.changeable().knows(name));
        let mut start = Some(start);
        let (mut taker, mut progress) = (None, None);
        for (number, part) in parts.iter().enumerate() {
            // Of an atlas many parts may hold nothing of what is asked for; `start` needs one replay.
            if part.tiles().is_empty() && (number + 1 < parts.len() || start.is_none()) {
                continue;
            }
            let place = (part.archive, &part.site);
            let replay = replay_beside(place, &elsewhere, asked, series, self.components, observer)?;
            if let Some(start) = start.take() {
                taker = Some(start()?);
            }
            let next = parts.get(number + 1..).and_then(|rest| rest.iter().find(|part| !part.tiles().is_empty()));
            if let Some(next) = next {
                replay.expect_of(
                    &next.site,
                    &next.tiles().iter().take(AHEAD).map(|tile| tile.number).collect::<Vec<_>>(),
                );
            }
            let progress = progress.get_or_insert_with(|| self.chosen.progress(observer));
            let Some(taker) = &mut taker else { break };
            if !part.each_tile(&replay, (observer, progress), |receivers, values| each(taker, receivers, values))? {
                break;
            }
        }
        match (taker, start) {
            (Some(taker), _) => Ok(taker),
            (None, Some(start)) => start(),
            (None, None) => Err(Error::Stopped { what: "before a receiver was replayed".into() }),
        }
    }
}

impl Chosen<'_> {
    /// Tells an observer of receivers.
    pub fn progress<'o>(&self, observer: &'o dyn Observer) -> Stage<'o> {
        Stage::begin(observer, "receivers", Some(self.count()))
    }
}

impl ChosenPart<'_> {
    /// Hands on the chosen results of a replay tile by tile until `each` gives false: whether it never did. An observer who wants the work to
    /// stop is an error.
    pub fn each_tile(
        &self,
        replay: &Replay,
        (observer, progress): (&dyn Observer, &Stage),
        mut each: impl FnMut(&[String], &TileValues) -> Result<bool>,
    ) -> Result<bool> {
        let results = replay.results(self.tiles().iter().map(|tile| tile.number));
        for (tile, result) in self.tiles().iter().zip(results) {
            let (receivers, values) = self.results(*tile, result?);
            let goes_on = each(&receivers, &values)?;
            progress.advance(receivers.len() as u64);
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
