//! A site in one state of its reflectances. In: an archive, conditions, numbers of tiles. Out: the
//! light of conditions, prepared tiles.

use std::sync::Arc;

use crate::archive::format;
use crate::archive::format::BlockKind;
use crate::error::{Error, Problem, Result};
use crate::layers::canopy::Powers;
use crate::layers::response::Response;
use crate::light::canopies::{TransmittanceStates, stored};
use crate::light::mirrors::MirrorTable;
use crate::light::radiosity::MaxBounces;
use crate::light::reflector::Reflector;
use crate::light::response_solver::ResponseSolver;
use crate::light::scratch::InMemory;
use crate::light::states::{Schedule, States};
use crate::light::tables::Tables;
use crate::light::tile_view::TileView;
use crate::memory::MemoryBudget;
use crate::opened::OpenSite;
use crate::replay::interactive::light::{InteractiveLight, SkyGrids};
use crate::replay::interactive::tile::InteractiveTile;
use crate::replay::tile_layers::{Reads, TileLayers};
use crate::sky::model::SkyModel;
use crate::weather::conditions::Condition;

/// Site in one state of its reflectances, from which tiles are prepared.
pub struct InteractiveReplay<'a> {
    site: OpenSite<'a>,
    grids: Arc<SkyGrids>,
    /// Transmittance of canopies; empty if the site has no canopies.
    powers: Powers,
    mirrors: Option<MirrorTable>,
    /// Tables and solver of responses; `None` if the archive's own responses apply.
    responder: Option<(Tables<'a>, ResponseSolver)>,
}

impl<'a> InteractiveReplay<'a> {
    /// Prepares a site under skies of 145, 577 or 2305 `patches`. The schedules give reflectances
    /// and transmittances for one condition; without schedules those of the archive apply. Returns
    /// the errors of [`ReplayBuilder::build`](crate::replay::run::ReplayBuilder::build).
    pub fn new(site: &OpenSite<'a>, patches: usize, schedules: &[Schedule]) -> Result<Self> {
        InteractiveReplay::on(site, Arc::new(SkyGrids::new(patches, site.settings().sides())?), schedules)
    }

    /// Returns the replay of this site with other reflectances.
    pub fn reflecting(&self, schedules: &[Schedule]) -> Result<Self> {
        InteractiveReplay::on(&self.site, Arc::clone(&self.grids), schedules)
    }

    fn on(site: &OpenSite<'a>, grids: Arc<SkyGrids>, schedules: &[Schedule]) -> Result<Self> {
        let diffuse = site.settings().diffuse;
        let mut powers = stored(site.materials());
        if !schedules.is_empty() && !diffuse && powers.is_empty() {
            let what = "was built without diffuse reflections, so no reflectance can be changed";
            return Err(
                Error::input(site.path(), None, what, "build it with {effects} all").because(Problem::Lacks("diffuse"))
            );
        }
        let mirrors = (!site.orientations().is_empty()).then(|| MirrorTable::new(site));
        let mut responder = None;
        if !schedules.is_empty() {
            let tables = Tables::new(site)?;
            let reflectors = &tables.mirrors.reflectors;
            let lets_through: Vec<bool> = reflectors.iter().map(|r| r.transmittance.is_some()).collect();
            let kept = reflectors.iter().map(Reflector::variable).collect();
            let states = States::new(&kept, &lets_through, schedules, 1, false)?.reflectances;
            let leafage = TransmittanceStates::split(reflectors, &mut states.clone()).powers.pop();
            powers = leafage.unwrap_or(powers);
            if diffuse {
                let memory = MemoryBudget::DEFAULT;
                let solver = ResponseSolver::with_states(&tables, states, MaxBounces::All, memory, &InMemory)?;
                responder = Some((tables, solver));
            }
        }
        Ok(InteractiveReplay { site: site.clone(), grids, powers, mirrors, responder })
    }

    /// Looks up the light of a condition with its sky. The directions of its suns refer to true
    /// north.
    pub fn light(&self, condition: &Condition, sky: SkyModel) -> InteractiveLight {
        let condition = condition.clone().in_axes(self.site.north());
        InteractiveLight::new(condition, sky, &self.grids, self.site.settings().sides())
    }

    /// Announces tiles that will be prepared soon, so that their blocks can be read ahead.
    pub fn expect(&self, tiles: &[u32]) {
        let besides: &[BlockKind] = if self.responder.is_some() { &TileView::KINDS } else { &[format::RESPONSE] };
        self.reads().expect(&self.site, tiles, besides);
    }

    fn reads(&self) -> Reads<'_> {
        Reads { sky: true, mirrors: self.mirrors.as_ref() }
    }

    /// Prepares tiles. Choose neighbouring tiles if the reflectances are not those of the archive.
    /// A damaged block is an error for all tiles of the call.
    pub fn tiles(&self, tiles: &[u32]) -> Result<Vec<InteractiveTile>> {
        let reads = self.reads();
        let ready = |(_, layers): (Vec<String>, TileLayers)| {
            InteractiveTile::new(layers, &self.powers, &self.grids, self.site.settings().sides())
        };
        self.expect(tiles);
        let Some((tables, responder)) = &self.responder else {
            let read = |tile: &u32| {
                let diffuse = self.site.settings().diffuse;
                let responses = if diffuse { vec![self.site.tile_responses(*tile)?] } else { Vec::new() };
                Ok(ready(TileLayers::read(&self.site, *tile, reads, responses)?))
            };
            return tiles.iter().map(read).collect();
        };
        let views = tiles.iter().map(|tile| TileView::read(&self.site, *tile)).collect::<Result<Vec<_>>>()?;
        let responses: Vec<Vec<Vec<Response>>> = responder.derive(tables, &views)?;
        let derived = |(view, responses)| Ok(ready(TileLayers::of_view(&self.site, view, reads, responses)?));
        views.into_iter().zip(responses).map(derived).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    use crate::archive::Archive;
    use crate::replay::components::Component;
    use crate::replay::run::{Replay, ReplaySettings};
    use crate::units::direction_from_degrees;

    /// Returns the number of compared values and the largest difference from a replay, as a share
    /// of the largest value, over 6 suns and 4 skies.
    fn off(name: &str, schedules: &[Schedule]) -> (usize, f64) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/archives").join(name);
        let archive = Archive::open(&path).expect("an archive");
        let site = OpenSite::open(&archive).expect("a site");
        let moments =
            InteractiveReplay::new(&site, 577, &[]).and_then(|kept| kept.reflecting(schedules)).expect("moments");
        let (mut compared, mut worst, mut largest) = (0, 0.0_f64, 0.0_f64);
        for (azimuth_deg, altitude_deg) in
            [(90.0, 5.0), (135.0, 30.0), (180.0, 60.0), (222.0, 41.0), (300.0, 12.0), (0.0, -3.0)]
        {
            for sky in ["perez", "perez1990", "uniform", "cie:12"].map(|name| name.parse::<SkyModel>().expect("a sky"))
            {
                let sun = direction_from_degrees(azimuth_deg, altitude_deg);
                let condition = Condition::new("c".into(), &[sun], sun, 800.0, 120.0);
                let settings = ReplaySettings { sky, ..ReplaySettings::default() };
                let conditions = [condition];
                let replay =
                    Replay::builder(&site, &conditions, settings).scheduled(schedules).build().expect("replay");
                let light = moments.light(&conditions[0], sky);
                for tile in 0..site.tiles() {
                    let ready = moments.tiles(&[tile]).expect("a tile").pop().expect("one");
                    let (found, expected) =
                        (ready.irradiance(&light), replay.run([tile]).expect("a tile").pop().expect("one").1);
                    for (found, expected) in
                        Component::ALL.iter().flat_map(|&c| found.component(c).iter().zip(expected.component(c)))
                    {
                        compared += 1;
                        worst = worst.max(f64::from((found - expected).abs()));
                        largest = largest.max(f64::from(*expected));
                    }
                }
            }
        }
        (compared, worst / largest)
    }

    /// Interactive replays of archives with mirrors and canopies equal replays within 5e-5 of the
    /// largest value, under 6 suns and 4 skies, with the stored reflectances and with others: 4
    /// comparisons of more than 500 values each.
    #[test]
    fn interactive_replays_equal_replays() {
        for name in ["v1.7-box.helio", "v1.7-mirrors.helio"] {
            for schedules in [Vec::new(), vec![Schedule { materials: vec![0], values: vec![0.55] }]] {
                let (compared, worst) = off(name, &schedules);
                assert!(compared > 500 && worst < 5e-5, "{name}: {compared} {worst:e}");
            }
        }
    }
}
