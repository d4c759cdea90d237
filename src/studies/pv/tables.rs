//! Results of `pv`. In: an archive of its receivers, weather. Out: the tables, lists and pictures
//! of the folder.

use std::collections::{HashMap, HashSet};
use std::fs;
use std::rc::Rc;

use super::energy::{ModuleLight, Plant, SideLight};
use super::folder::PvFolder;
use super::ground::GroundSpot;
use super::light::Light;
use super::open_plain::OpenPlain;
use super::request::PvRequest;
use super::shade::map_of;
use super::spots::{Spot, SpotSide, Spots};
use super::tracked::{TrackedLight, TrackedSide, Tracking};
use heliotile_archives::transfer::ArchiveReceivers;
use heliotile_builder::siting::Siting;
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Result};
use heliotile_core::opened::OpenSite;
use heliotile_core::orientation::fan::Orientation;
use heliotile_core::site::north::North;
use heliotile_results::Every;
use heliotile_results::outputs::provenance::Provenance;
use heliotile_results::outputs::pv::energy::EnergySums;
use heliotile_results::outputs::pv::ground::{GroundSums, PlantLight, SumsOnGround, write_ground, write_ground_months};
use heliotile_results::outputs::pv::horizon::{self, PointHorizon};
use heliotile_results::outputs::pv::hourly::{ANGLE, HourlyTable, ONE_SIDE, SideHours, TWO_SIDES};
use heliotile_results::outputs::pv::polar;
use heliotile_results::outputs::pv::search::{PointSearch, write_all, write_best};
use heliotile_results::outputs::pv::sums::{MonthlySums, SideSums, write_months, write_points};
use heliotile_results::outputs::sink::write_texts;
use heliotile_results::outputs::tables::bin_labels::BinLabels;
use heliotile_scene::Scene;

/// Number of directions of a horizon.
const HORIZON_DIRECTIONS: usize = 360;

/// Results of a replay, and the sky view of a receiver.
struct OfReceiver {
    months: MonthlySums,
    /// Cosine-weighted share of its hemisphere that is sky.
    sky_view: f64,
}

/// Module of which some receivers are still to come.
struct OpenModule {
    /// Number of receivers that have come.
    seen: usize,
    sides: Vec<SideHours>,
    /// Light on the cells of its front: the direct sun and the rest, `[hour]`, W/m2.
    cells: Vec<Vec<[f32; 2]>>,
}

impl OpenModule {
    fn new(spot: &Spot) -> Self {
        let cells = spot.cells.map_or(0, |(grid, _)| grid.count());
        OpenModule { seen: 0, sides: vec![SideHours::default(); spot.sides.len()], cells: vec![Vec::new(); cells] }
    }
}

/// Inputs of the results.
pub struct Results<'a, 'l> {
    pub request: &'a PvRequest,
    pub files: &'a PvFolder,
    pub light: &'a Light<'l>,
    pub archive: &'a Archive,
    pub spots: &'a Spots,
    pub ground: &'a [GroundSpot],
    /// Light on trackers; `None` where modules are fixed.
    pub tracked: Option<&'a TrackedLight>,
    pub about: &'a Provenance,
}

impl Results<'_, '_> {
    /// Writes sums, hours, horizons and energy, and returns the sums of sides, of the ground and of
    /// the energy. `scene` is the one without modules.
    pub fn write(
        &self,
        scene: &Scene,
        siting: &Siting,
        north: North,
        plant: Option<Plant>,
    ) -> Result<(Vec<SideSums>, SumsOnGround, Option<EnergySums>)> {
        let (files, about) = (self.files, self.about);
        let has_horizons = self.request.points.is_some();
        let (mut sides, ground) = match self.tracked {
            Some(tracked) => (self.tracked_sums(tracked)?, SumsOnGround::default()),
            None => {
                let of_receiver = self.of_receivers()?;
                (self.sums(scene, &of_receiver, has_horizons)?, self.sums_on_ground(scene, &of_receiver)?)
            }
        };
        let plant = self.write_hours(plant)?;
        let mut fronts: Vec<&mut SideSums> = sides.iter_mut().filter(|side| side.side != "rear").collect();
        if let Some(partial) = plant.as_ref().and_then(Plant::partial_shade) {
            fronts.iter_mut().zip(partial).for_each(|(front, partial)| front.partial = Some(*partial));
        }
        let fronts: Vec<&SideSums> = fronts.into_iter().map(|front| &*front).collect();
        let energy = plant.map(|plant| self.energy(&plant, &fronts)).transpose()?;
        if files.ground.is_some() {
            self.light.tell_par(self.archive)?;
        }
        if has_horizons {
            let horizons = self.horizons(siting, north);
            fs::create_dir_all(&files.horizons).map_err(Error::io(&files.horizons, "create"))?;
            horizon::write_lists(&files.horizons, &horizons)?;
            horizon::write_table(&files.horizon_table, &horizons, about)?;
        }
        write_points(&files.points, &sides, about)?;
        let months = self.light.month_labels(self.archive)?;
        write_months(&files.months, &sides, &months, about)?;
        if let Some([places, by_month]) = &files.ground {
            write_ground(places, &ground, about)?;
            write_ground_months(by_month, &ground, &months, about)?;
        }
        if self.request.shade {
            let map = map_of(&self.spots.list, self.archive, self.light.resources())?;
            fs::create_dir_all(&files.shade).map_err(Error::io(&files.shade, "create"))?;
            map.write(&files.shade, about)?;
        }
        if let (Some(energy), Some([strings, by_month])) = (&energy, &files.energy) {
            energy.write(strings, about)?;
            energy.write_months(by_month, about)?;
            if let (Some(years), Some(table)) = (&energy.years, &files.energy_years) {
                energy.write_years(years, table, about)?;
            }
        }
        Ok((sides, ground, energy))
    }

    /// Writes the results of a search.
    pub fn write_search(&self, searched: &[PointSearch]) -> Result<()> {
        let (files, about) = (self.files, self.about);
        write_all(&files.search, searched, about)?;
        write_best(&files.best, searched, about)?;
        fs::create_dir_all(&files.turns).map_err(Error::io(&files.turns, "create"))?;
        searched.iter().try_for_each(|search| {
            write_texts(&files.folder, &[(&PvFolder::picture_of(&search.point), polar::svg(search, about))])
        })
    }

    /// Returns the horizon of every point, from true north.
    fn horizons(&self, siting: &Siting, north: North) -> Vec<PointHorizon> {
        let of = |spot: &Spot| PointHorizon {
            point: spot.name.clone(),
            altitudes_deg: siting.horizon(spot.position, HORIZON_DIRECTIONS, -north.y_deg()).altitudes_deg,
        };
        self.spots.list.iter().map(of).collect()
    }

    /// Returns sums and sky views of all receivers, by name.
    fn of_receivers(&self) -> Result<HashMap<String, OfReceiver>> {
        let months = self.light.monthly(self.archive)?;
        let mut all: HashMap<String, OfReceiver> =
            months.into_iter().map(|(id, months)| (id, OfReceiver { months, sky_view: 0.0 })).collect();
        for row in ArchiveReceivers::<()>::new(&OpenSite::open(self.archive)?) {
            let row = row?;
            if let Some(found) = all.get_mut(&row.receiver.id) {
                found.sky_view = f64::from(row.views[0]);
            }
        }
        Ok(all)
    }

    /// Returns the sums of every side, with those on an open plain.
    fn sums(
        &self,
        scene: &Scene,
        of_receiver: &HashMap<String, OfReceiver>,
        has_horizons: bool,
    ) -> Result<Vec<SideSums>> {
        let mut plain = OpenPlain::new(scene, self.archive, &self.files.folder);
        let turns = |spot: &Spot| spot.sides.iter().map(|side| (spot.ground, spot.turn_of(side))).collect::<Vec<_>>();
        let wanted = self.spots.list.iter().flat_map(turns);
        plain.learn(wanted, |archive| self.light.monthly(archive), self.light.observer())?;
        let of_side = |spot: &Spot, side: &SpotSide| {
            let (mut months, mut sky_view) = (MonthlySums::default(), 0.0);
            let share = 1.0 / side.receivers.len() as f64;
            for (id, _) in &side.receivers {
                let Some(found) = of_receiver.get(id) else { continue };
                months.add(&found.months, share);
                sky_view += share * found.sky_view;
            }
            let turn = spot.turn_of(side);
            SideSums {
                point: spot.name.clone(),
                side: side.name,
                position: spot.position,
                turn: Some(turn),
                open: plain.sums(spot.ground, turn),
                sky_view,
                horizon: if has_horizons { PvFolder::list_of(&spot.name) } else { String::new() },
                bifacial_gain_percent: None,
                partial: None,
                months,
            }
        };
        let of_spot = |spot: &Spot| self.with_gain(spot.sides.iter().map(|side| of_side(spot, side)).collect());
        Ok(self.spots.list.iter().flat_map(of_spot).collect())
    }

    /// Returns the sums of both sides of every tracker, with those of a single one on an open
    /// plain.
    fn tracked_sums(&self, tracked: &TrackedLight) -> Result<Vec<SideSums>> {
        let months = self.light.hours(self.archive)?.by(Every::Month);
        let of_side = |spot: &Spot, ((side, found), open): ((&SpotSide, &TrackedSide), &MonthlySums)| SideSums {
            point: spot.name.clone(),
            side: side.name,
            position: spot.position,
            turn: None,
            open: open.clone(),
            sky_view: found.sky_view,
            horizon: String::new(),
            bifacial_gain_percent: None,
            partial: None,
            months: MonthlySums::new(&found.hours, &months.bins),
        };
        let of_spot = |(place, spot): (usize, &Spot)| {
            let sides = spot.sides.iter().zip(tracked.sides(place)).zip(tracked.open(spot.ground));
            self.with_gain(sides.map(|side| of_side(spot, side)).collect())
        };
        Ok(self.spots.list.iter().enumerate().flat_map(of_spot).collect())
    }

    /// Returns the sides of a module with the gain by its rear.
    fn with_gain(&self, mut sides: Vec<SideSums>) -> Vec<SideSums> {
        if let [front, rear] = sides.as_mut_slice() {
            let share = rear.months.total() / front.months.total().max(f64::MIN_POSITIVE);
            front.bifacial_gain_percent = Some(100.0 * self.request.bifaciality * share);
        }
        sides
    }

    /// Returns the sums of every place on the ground, with the photosynthetically active radiation
    /// on an open plain.
    fn sums_on_ground(&self, scene: &Scene, of_receiver: &HashMap<String, OfReceiver>) -> Result<SumsOnGround> {
        if self.ground.is_empty() {
            return Ok(SumsOnGround::default());
        }
        let names: HashSet<&str> = self.ground.iter().map(|spot| spot.place.name.as_str()).collect();
        let mut par = self.light.monthly_par(self.archive, |id| names.contains(id))?;
        let mut plain: OpenPlain<PlantLight> = OpenPlain::new(scene, self.archive, &self.files.folder);
        // A horizontal receiver that faces up sees nothing of the plain, so its material does not
        // matter.
        let wanted = std::iter::once((None, Orientation::FLAT));
        plain.learn(wanted, |archive| self.light.monthly_par(archive, |_| true), self.light.observer())?;
        let of_spot = |spot: &GroundSpot| {
            let name = &spot.place.name;
            let (Some(found), Some(par)) = (of_receiver.get(name), par.remove(name)) else {
                let what = format!("the archive has no light of `{name}`, which it was built with");
                return Err(Error::defect(self.archive.path(), "receivers", "id", what));
            };
            Ok(GroundSums {
                receiver: name.clone(),
                rows: spot.rows.clone(),
                position: spot.place.position,
                behind_m: spot.place.behind_m,
                months: found.months.clone(),
                par,
                open: plain.sums(None, Orientation::FLAT),
                sky_view: found.sky_view,
            })
        };
        let places = self.ground.iter().map(of_spot).collect::<Result<_>>()?;
        Ok(SumsOnGround { places, days: self.light.days(self.archive)? })
    }

    /// Writes the hours of every point and module, if they are wanted, and returns the array with
    /// them.
    fn write_hours<'p>(&self, mut plant: Option<Plant<'p>>) -> Result<Option<Plant<'p>>> {
        let light = self.light;
        if plant.is_none() && !self.request.hourly {
            return Ok(None);
        }
        let series = light.hours(self.archive)?;
        let mut table = self.request.hourly.then(|| self.hourly_table(&series.labels)).transpose()?;
        let bifaciality = self.request.bifaciality;
        let tracking = self.tracked.map(|tracked| &tracked.tracking);
        let angles = tracking.map(Tracking::angles_deg);
        let covers = tracking.map(|tracking| [0, 1].map(|side| Rc::new(tracking.covers(side))));
        self.each_module(|place, spot, sides, cells| {
            if let Some(plant) = &mut plant {
                let mut lights = Vec::new();
                for ((number, share), (hours, side)) in (0..).zip([1.0, bifaciality]).zip(sides.iter().zip(&spot.sides))
                {
                    let cover = match covers.as_ref().and_then(|covers: &[Rc<Vec<f64>>; 2]| covers.get(number)) {
                        Some(cover) => Rc::clone(cover),
                        None => plant.cover_of(spot.turn_of(side), &series),
                    };
                    lights.push(SideLight { hours, cover, share });
                }
                plant.add(place, &ModuleLight { sides: lights, cells });
            }
            let Some(table) = &mut table else { return Ok(()) };
            let mut columns = match sides {
                [front, rear] => front.with_rear(rear, bifaciality as f32),
                [one] => one.one_side(),
                _ => return Ok(()),
            };
            columns.extend(angles.clone());
            table.write(&spot.name, &columns)
        })?;
        table.map_or(Ok(()), HourlyTable::finish)?;
        Ok(plant)
    }

    /// Returns the energy of an array that knows its hours.
    fn energy(&self, plant: &Plant, fronts: &[&SideSums]) -> Result<EnergySums> {
        let bifaciality = self.request.bifaciality;
        let has_rears = bifaciality > 0.0 && self.spots.list.iter().any(|spot| spot.sides.len() > 1);
        let sums = plant.sums(&*self.light.hours(self.archive)?, fronts, self.light.observer());
        Ok(EnergySums { bifaciality: has_rears.then_some(bifaciality), ..sums })
    }

    /// Hands over the hours of the sides and of the cells of every point and module. Of fixed ones,
    /// memory holds only those of which some receivers are still to come, which are few: their
    /// receivers lie in neighbouring tiles.
    fn each_module(
        &self,
        mut each: impl FnMut(usize, &Spot, &[&SideHours], &[Vec<[f32; 2]>]) -> Result<()>,
    ) -> Result<()> {
        let spots = &self.spots.list;
        if let Some(tracked) = self.tracked {
            let hours = |place| tracked.sides(place).iter().map(|side| &side.hours).collect::<Vec<_>>();
            return spots.iter().enumerate().try_for_each(|(place, spot)| each(place, spot, &hours(place), &[]));
        }
        let mut open: HashMap<usize, OpenModule> = HashMap::new();
        self.light.hourly(self.archive, |id, hours| {
            let Some([place, side, number]) = self.spots.of_receiver(id) else { return Ok(()) };
            let Some(spot) = spots.get(place) else { return Ok(()) };
            let OpenModule { seen, sides, cells } = open.entry(place).or_insert_with(|| OpenModule::new(spot));
            *seen += 1;
            if let Some(cell) = cells.get_mut(number).filter(|_| side == 0) {
                *cell = hours.suns_and_rests();
            }
            if let (Some(sum), Some(of)) = (sides.get_mut(side), spot.sides.get(side)) {
                sum.add(&hours, std::iter::repeat(1.0 / of.receivers.len() as f32));
            }
            if *seen < spot.sides.iter().map(|side| side.receivers.len()).sum() {
                return Ok(());
            }
            let Some(OpenModule { sides, cells, .. }) = open.remove(&place) else { return Ok(()) };
            each(place, spot, &sides.iter().collect::<Vec<_>>(), &cells)
        })
    }

    /// Starts the table of hours.
    fn hourly_table(&self, labels: &BinLabels) -> Result<HourlyTable> {
        let light = self.light;
        let about = self.about.clone().with("stamp", light.stamp().name());
        let about = about.with("interval_minutes", 60.0 * light.interval_hours());
        let mut columns: Vec<&str> = if self.request.points.is_some() { ONE_SIDE.into() } else { TWO_SIDES.into() };
        columns.extend(self.tracked.map(|_| ANGLE));
        HourlyTable::create(&self.files.hours, &columns, labels, self.spots.list.len() as u64, &about)
    }
}
