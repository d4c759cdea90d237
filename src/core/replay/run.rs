//! A replay: an archive under a series of conditions, tile by tile. In: an open archive,
//! conditions, settings. Out: irradiances of receivers. A replay reads and multiplies; it cannot
//! cast a ray.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::archive::format;
use crate::archive::format::BlockKind;
use crate::error::{Error, Problem, Result};
use crate::layers::response::Response;
use crate::light::canopies;
use crate::light::canopies::TransmittanceStates;
use crate::light::mirrors::MirrorTable;
use crate::light::paths::LightPaths;
use crate::light::radiosity::MaxBounces;
use crate::light::reflector::Reflector;
use crate::light::response_solver::ResponseSolver;
use crate::light::scratch::{InMemory, ScratchSpace};
use crate::light::states::{Schedule, States};
use crate::light::tables::Tables;
use crate::light::tile_view::TileView;
use crate::memory::MemoryBudget;
use crate::opened::OpenSite;
use crate::replay::bands::BandPass;
use crate::replay::components::{Component, ComponentSet};
use crate::replay::longwave::Longwave;
use crate::replay::tile::Forcing;
use crate::replay::tile_layers::{Reads, TileLayers};
use crate::replay::values::TileValues;
use crate::sky::model::SkyModel;
use crate::sky::own_skies;
use crate::sky::patches::Patches;
use crate::weather::conditions::{Condition, in_axes};
use crate::weather::time::bins::Bins;

/// Bytes of results and responses that are computed at a time, beyond one tile a core.
const RESULT_BYTES: usize = 48 << 20;

/// Settings of a replay that do not depend on the weather.
#[derive(Clone, Copy, Debug)]
pub struct ReplaySettings<'s> {
    /// Model of the sky's distribution of radiance.
    pub sky: SkyModel,
    /// Number of sky patches: 145, 577 or 2305.
    pub patches: usize,
    /// Light paths that count.
    pub paths: LightPaths,
    /// Components that results hold. Components that none of them needs may stay zero.
    pub components: ComponentSet,
    /// Bytes that tables and radiosities may take, besides the results of the requested tiles.
    pub memory: MemoryBudget,
    /// Storage for radiosities that do not fit into memory.
    pub storage: &'s dyn ScratchSpace,
}

impl Default for ReplaySettings<'_> {
    /// Returns Perez skies of 577 patches, all light, all components, and 4 GiB. Radiosities that
    /// do not fit stay in memory all the same. The program takes the number of patches that the
    /// archive states: `manifest().settings.patches()`.
    fn default() -> Self {
        ReplaySettings {
            sky: SkyModel::Perez,
            patches: 577,
            paths: LightPaths::ALL,
            components: ComponentSet::ALL,
            memory: MemoryBudget::DEFAULT,
            storage: &InMemory,
        }
    }
}

/// Archive with its weather, prepared for one tile after another.
///
/// The directions of the suns of conditions refer to true north. If the archive states its
/// location, the directions are turned into its axes.
///
/// Results are irradiances on the receivers, f32: means over a condition in W/m2 ([`Replay::new`]),
/// or sums with the weights of [`Bins`], such as kWh/m2 ([`ReplayBuilder::summed`]). Diffuse
/// reflectances and transmittances may change from condition to condition
/// ([`ReplayBuilder::scheduled`]). Longwave irradiance needs conditions with an emission, as
/// `heliotile_weather::temperatures::emissions` gives them. Tiles are independent of each other. A
/// tile has 64 receivers, in the archive's order.
///
/// ```no_run
/// use std::path::Path;
/// use heliotile_core::opened::OpenSite;
/// use heliotile_core::replay::components::Component;
/// use heliotile_core::weather::clear::clear_year;
/// use heliotile_core::archive::Archive;
/// use heliotile_core::replay::run::{Replay, ReplaySettings};
///
/// # fn main() -> heliotile_core::error::Result<()> {
/// let archive = Archive::open(Path::new("site.helio"))?;
/// let site = OpenSite::open(&archive)?;
/// let place = archive.manifest().place.expect("a place");
/// let (conditions, _) = clear_year(&place);
/// let replay = Replay::new(&site, &conditions, ReplaySettings::default())?;
/// for tile in replay.results(0..replay.tiles()) {
///     let (ids, values) = tile?;
///     for (receiver, id) in ids.iter().enumerate() {
///         // [condition], W/m2.
///         let total = values.row(Component::Total, receiver);
///         println!("{id}: {:.0} W/m2 at most", total.iter().copied().fold(0.0, f32::max));
///     }
/// }
/// # Ok(())
/// # }
/// ```
pub struct Replay<'a> {
    pub(super) site: OpenSite<'a>,
    pub(super) forcing: Forcing,
    memory: MemoryBudget,
    /// Mirrors of the site; `None` if there are none or the components need none.
    pub(super) mirrors: Option<MirrorTable>,
    /// Tables and solver of responses; `None` if the archive's own responses apply.
    pub(super) responder: Option<(Tables<'a>, ResponseSolver)>,
    bands: Vec<BandReplay<'a>>,
}

/// Replay in a band. Its totals are the values of the listed columns, one column after another.
struct BandReplay<'a> {
    replay: Replay<'a>,
    components: Vec<Component>,
}

/// Receiver ids, in the order of the tile, and irradiance: `[component][receiver][result]`, in W/m2
/// or the unit of the sums.
pub type TileResult = (Vec<String>, TileValues);

impl<'a> Replay<'a> {
    /// Prepares one result for every condition: means in W/m2. Returns an error for a number of
    /// patches other than 145, 577 and 2305, for longwave irradiance without emissions, and for
    /// cells that do not fit together.
    pub fn new(site: &OpenSite<'a>, conditions: &[Condition], settings: ReplaySettings) -> Result<Self> {
        Replay::builder(site, conditions, settings).build()
    }

    /// Starts a replay with further choices: sums in place of means, and reflectances that change.
    pub fn builder<'r>(
        site: &'r OpenSite<'a>,
        conditions: &'r [Condition],
        settings: ReplaySettings<'r>,
    ) -> ReplayBuilder<'r, 'a> {
        ReplayBuilder {
            site,
            conditions,
            settings,
            bins: None,
            schedules: &[],
            bands: &[],
            are_sums: false,
            by_object: false,
        }
    }
}

/// Builder of a replay of an archive under conditions.
pub struct ReplayBuilder<'r, 'a> {
    site: &'r OpenSite<'a>,
    pub(super) conditions: &'r [Condition],
    settings: ReplaySettings<'r>,
    bins: Option<&'r Bins>,
    schedules: &'r [Schedule],
    bands: &'r [BandPass<'a>],
    are_sums: bool,
    /// True if the light of single cells is asked for: responses are derived.
    pub(super) by_object: bool,
}

impl<'r, 'a> ReplayBuilder<'r, 'a> {
    /// Makes results sums over conditions, in the unit of the weights: kWh/m2 for hours / 1000.
    pub fn summed(self, bins: &'r Bins) -> Self {
        ReplayBuilder { bins: Some(bins), ..self }
    }

    /// Makes reflectances and transmittances follow schedules.
    pub fn scheduled(self, schedules: &'r [Schedule]) -> Self {
        ReplayBuilder { schedules, ..self }
    }

    /// Adds the columns of bands. `are_sums` says that the bins add hours / 1000.
    pub fn with_bands(self, bands: &'r [BandPass<'a>], are_sums: bool) -> Self {
        ReplayBuilder { bands, are_sums, ..self }
    }

    /// Prepares the replay and those of its bands. Returns an error for a condition that is out of
    /// range, for a number of patches other than 145, 577 and 2305, for longwave irradiance without
    /// emissions, for cells that do not fit together, and for schedules of an archive that was
    /// built without diffuse reflections and has no canopies.
    pub fn build(self) -> Result<Replay<'a>> {
        let (conditions, bands, are_sums) = (self.conditions, self.bands, self.are_sums);
        conditions.iter().try_for_each(Condition::check)?;
        // All replays work at once, so they share the memory.
        let memory = MemoryBudget::new(self.settings.memory.total() / (1 + bands.len() as u64));
        let settings = ReplaySettings { memory, ..self.settings };
        let bins = self.bins.map_or_else(|| Cow::Owned(Bins::each(conditions.len())), Cow::Borrowed);
        let mut replay = ReplayBuilder { settings, ..self }.build_one()?;
        let settings = ReplaySettings { components: ComponentSet::new(&[Component::Total]), ..settings };
        for pass in bands {
            let (conditions, bins, schedules) =
                (pass.conditions(conditions), pass.bins(&bins, are_sums), pass.repeated());
            let builder = Replay::builder(&pass.site, &conditions, settings).summed(&bins).scheduled(&schedules);
            replay.bands.push(BandReplay { replay: builder.build_one()?, components: pass.components() });
        }
        Ok(replay)
    }

    /// Prepares the replay of all light.
    pub(super) fn build_one(self) -> Result<Replay<'a>> {
        let ReplayBuilder { site, conditions, settings, bins, schedules, by_object, .. } = self;
        let bins = &*bins.map_or_else(|| Cow::Owned(Bins::each(conditions.len())), Cow::Borrowed);
        let conditions = &*in_axes(conditions, site.north());
        if settings.sky.brightens() && conditions.iter().any(|c| c.own_sky.is_some() || c.clouds.is_some()) {
            return Err(own_skies::no_parts());
        }
        let patches = Patches::new(settings.patches)?;
        let forced = |ways: &[Bins]| -> Result<Forcing> {
            let (sky, components, sides) = (settings.sky, settings.components, site.settings().sides());
            let forcing = Forcing::new(conditions, bins, ways, sky, components, &patches, sides);
            let forcing = if settings.paths.mirror_sky { forcing } else { forcing.without_mirror_sky() };
            if !settings.components.contains(Component::Longwave) {
                return Ok(forcing);
            }
            Ok(forcing.with_longwave(Longwave::new(conditions, bins, site.path())?))
        };
        let reflects = site.settings().diffuse
            && [Component::SunReflected, Component::SkyReflected].iter().any(|&c| settings.components.needs(c));
        let leaves = canopies::stored(site.materials());
        if !schedules.is_empty() && !site.settings().diffuse && leaves.is_empty() {
            let what = "was built without diffuse reflections, so no reflectance can be changed";
            return Err(
                Error::input(site.path(), None, what, "build it with {effects} all").because(Problem::Lacks("diffuse"))
            );
        }
        let behind = |forcing: Forcing, ways| match leaves.is_empty() {
            true => forcing,
            false => forcing.behind(conditions, ways, settings.sky, &patches),
        };
        let paths = settings.paths;
        let matt = !paths.mirror_diffuse && !site.orientations().is_empty();
        let is_changed = !site.is_as_stored() || !schedules.is_empty();
        let derives = reflects && (by_object || paths.depth != MaxBounces::All || matt || is_changed);
        // Stored responses and transmittances apply: no tables have to be read.
        if !derives && (leaves.is_empty() || schedules.is_empty()) {
            let forcing = behind(forced(&[])?, vec![(leaves.clone(), bins.clone())]);
            return Replay::with(site, forcing, settings.memory, None);
        }
        let tables = Tables::new(site)?;
        let tables = if matt { tables.without_mirrors() } else { tables };
        let stored = tables.mirrors.reflectors.iter().map(Reflector::variable).collect();
        let lets_through: Vec<bool> = tables.mirrors.reflectors.iter().map(|r| r.transmittance.is_some()).collect();
        let (memory, storage) = (settings.memory, settings.storage);
        let states_of = |finer| States::new(&stored, &lets_through, schedules, conditions.len(), finer);
        let ways = |states: &States| {
            let leafages = TransmittanceStates::split(&tables.mirrors.reflectors, &mut states.reflectances.clone());
            leafages.ways(&states.ways(bins))
        };
        if !derives {
            let states = states_of(true)?;
            return Replay::with(site, behind(forced(&[])?, ways(&states)), memory, None);
        }
        let solved = |finer| -> Result<(States, ResponseSolver)> {
            let states = states_of(finer)?;
            let of_states = states.reflectances.clone();
            let responder = ResponseSolver::with_states(&tables, of_states, paths.depth, memory, storage)?;
            Ok((states, responder))
        };
        let (mut states, mut responder) = solved(false)?;
        // Few states usually suffice; a finer solution costs more, so it is made on demand.
        if !responder.interpolates(&states.checks)? {
            (states, responder) = solved(true)?;
        }
        let forcing = forced(&if states.reflectances.len() == 1 { Vec::new() } else { states.ways(bins) })?;
        let forcing = behind(forcing, ways(&states));
        Replay::with(site, forcing, memory, Some((tables, responder)))
    }
}

impl<'a> Replay<'a> {
    fn with(
        site: &OpenSite<'a>,
        forcing: Forcing,
        memory: MemoryBudget,
        responder: Option<(Tables<'a>, ResponseSolver)>,
    ) -> Result<Self> {
        let reflects = forcing.reads_mirrors() && !site.orientations().is_empty();
        let mirrors = reflects.then(|| MirrorTable::new(site));
        Ok(Replay { site: site.clone(), forcing, memory, mirrors, responder, bands: Vec::new() })
    }

    /// Returns the number of tiles, which are numbered from 0.
    pub fn tiles(&self) -> u32 {
        self.site.tiles()
    }

    /// Returns the results of tiles one after another, in the order of the request. At least one
    /// tile a core is computed at a time, if half of the memory holds that many. While results are
    /// small, more tiles are computed at a time, because neighbours share the cells that they see.
    /// A damaged block is one error in place of all tiles that are computed together; the tiles
    /// after them follow.
    pub fn results(&self, tiles: impl IntoIterator<Item = u32>) -> impl Iterator<Item = Result<TileResult>> {
        let tiles: Vec<u32> = tiles.into_iter().collect();
        let cores = rayon::current_num_threads().max(1);
        let half = usize::try_from(self.memory.total() / 2).unwrap_or(usize::MAX);
        let fit = (half / self.bytes(Forcing::working_bytes).max(1)).clamp(1, cores);
        let step = (RESULT_BYTES / self.bytes(Forcing::tile_bytes).max(1)).clamp(fit, 16 * cores);
        (0..tiles.len()).step_by(step).flat_map(move |first| {
            self.expect(tiles.get(first..tiles.len().min(first + 2 * step)).unwrap_or_default());
            match self.run(tiles.iter().copied().skip(first).take(step)) {
                Ok(results) => results.into_iter().map(Ok).collect(),
                Err(error) => vec![Err(error)],
            }
        })
    }

    /// Returns the sum of `of` over the replay of all light and those of the bands, bytes.
    fn bytes(&self, of: impl Fn(&Forcing) -> usize) -> usize {
        of(&self.forcing) + self.bands.iter().map(|band| of(&band.replay.forcing)).sum::<usize>()
    }

    /// Returns the results of tiles, all in memory at once. A damaged block in any of them is an
    /// error.
    pub fn run(&self, tiles: impl IntoIterator<Item = u32>) -> Result<Vec<TileResult>> {
        let tiles: Vec<u32> = tiles.into_iter().collect();
        let mut results = self.run_one(&tiles)?;
        for band in &self.bands {
            for ((_, values), (_, of_band)) in results.iter_mut().zip(band.replay.run_one(&tiles)?) {
                let bins = values.bins();
                for receiver in 0..values.receivers() {
                    let totals = of_band.row(Component::Total, receiver).chunks(bins.max(1));
                    for (component, totals) in band.components.iter().zip(totals) {
                        values.row_mut(*component, receiver).copy_from_slice(totals);
                    }
                }
            }
        }
        Ok(results)
    }

    /// Returns the results of all light.
    fn run_one(&self, tiles: &[u32]) -> Result<Vec<TileResult>> {
        self.expect(tiles);
        let reads = self.reads();
        let replayed = |(ids, layers): (Vec<String>, TileLayers)| (ids, self.forcing.replay(&layers));
        let reflects = self.reflects();
        let Some((tables, responder)) = self.responder.as_ref().filter(|_| reflects) else {
            let read = |tile: u32| {
                let responses = if reflects { vec![self.site.tile_responses(tile)?] } else { Vec::new() };
                Ok(replayed(TileLayers::read(&self.site, tile, reads, responses)?))
            };
            return tiles.par_iter().copied().map(read).collect();
        };
        let view = |tile: &u32| TileView::read(&self.site, *tile);
        let views = tiles.par_iter().map(view).collect::<Result<Vec<_>>>()?;
        let responses: Vec<Vec<Vec<Response>>> = responder.derive(tables, &views)?;
        let derived = |(view, responses)| Ok(replayed(TileLayers::of_view(&self.site, view, reads, responses)?));
        views.into_par_iter().zip(responses).map(derived).collect()
    }

    fn reads(&self) -> Reads<'_> {
        Reads { sky: self.forcing.reads_sky(), mirrors: self.mirrors.as_ref() }
    }

    fn reflects(&self) -> bool {
        self.forcing.reads_responses() && self.site.settings().diffuse
    }

    /// Announces tiles that will be requested soon, so that their blocks can be read ahead.
    fn expect(&self, tiles: &[u32]) {
        self.expect_of(&self.site, tiles);
    }

    /// Announces tiles of another site, which a replay of equal conditions reads next. The blocks
    /// of a remote archive then arrive while this replay is computed.
    pub fn expect_of(&self, site: &OpenSite, tiles: &[u32]) {
        let besides: &[BlockKind] = match (self.reflects(), &self.responder) {
            (true, None) => &[format::RESPONSE],
            (true, Some(_)) => &TileView::KINDS,
            (false, _) => &[],
        };
        self.reads().expect(site, tiles, besides);
    }
}
