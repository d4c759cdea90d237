//! Light of a weather file on an archive. In: an archive, weather. Out: sums by month and hours of
//! its receivers, replayed by the engine.

use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use super::request::PvRequest;
use heliotile_core::archive::Archive;
use heliotile_core::error::Result;
use heliotile_core::observer::{Observer, Silent};
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::site::bands::Band;
use heliotile_core::text::Message;
use heliotile_core::weather::options::StampedAt;
use heliotile_core::weather::time::years::Years;
use heliotile_results::bands::BandList;
use heliotile_results::outputs::pv::ground::{DayCounts, PAR, PlantLight};
use heliotile_results::outputs::pv::hourly::SideHours;
use heliotile_results::outputs::pv::sums::{MonthlySums, PARTS};
use heliotile_results::own_skies::SkyChoice;
use heliotile_results::{
    Archives, Every, LightRequest, Provenance, ReceiverSet, ReplayRequest, Resources, Series, Tile, TileStream,
};
use heliotile_weather::dated::DatedRows;
use heliotile_weather::series::Weather;

/// Weather, the rows that count, and their replay.
pub struct Light<'a> {
    weather: &'a Weather,
    request: ReplayRequest,
    dated: &'a DatedRows,
    resources: Resources<'a>,
    /// Hours for the last number of sun positions in each. They are kept, as computing the sun
    /// costs more than computing the light.
    kept: RefCell<Option<(usize, Rc<Series>)>>,
}

/// Returns the replay of a study.
fn replay_of(request: &PvRequest) -> ReplayRequest {
    let light = LightRequest { sky: SkyChoice::Model(request.sky), ..LightRequest::default() };
    let PvRequest { weather, year, stamp, snow, snow_reflectance, .. } = request;
    let (year, stamp, snow, snow_reflectance) = (*year, *stamp, *snow, *snow_reflectance);
    ReplayRequest { light, year, stamp, snow, snow_reflectance, ..ReplayRequest::new(weather) }
}

/// Returns the rows of weather that count; warns of days that a year does not have.
pub fn rows_of(request: &PvRequest, weather: &Weather, observer: &dyn Observer) -> Result<DatedRows> {
    // With `Every::Total` there is no note about years; `notes` gives it at the end.
    ReplayRequest { every: Every::Total, ..replay_of(request) }.dated(weather, observer)
}

impl<'a> Light<'a> {
    /// Prepares the replay of the rows of weather that count.
    pub fn new(request: &PvRequest, weather: &'a Weather, dated: &'a DatedRows, resources: Resources<'a>) -> Self {
        Light { weather, request: replay_of(request), dated, resources, kept: RefCell::default() }
    }

    /// Returns the observer of long work.
    pub fn observer(&self) -> &dyn Observer {
        self.resources.observer
    }

    /// Returns the resources of a replay.
    pub fn resources(&self) -> &Resources<'a> {
        &self.resources
    }

    /// Returns the number of sun positions in an interval.
    pub fn steps(&self, archive: &Archive) -> usize {
        self.weather.steps_of(archive.manifest().settings.steps())
    }

    /// Returns the moment of its interval that labels a row.
    pub fn stamp(&self) -> StampedAt {
        self.request.stamp
    }

    pub fn interval_hours(&self) -> f64 {
        self.weather.interval_hours
    }

    /// Returns notes for readers of times.
    pub fn notes(&self, request: &PvRequest) -> Vec<Message> {
        let typical = self.dated.years == Years::Typical && request.hourly;
        let text = "months of the weather file come from different years, and hours show these years; {year} 2019 would date all of them in 2019";
        typical.then(|| text.into()).into_iter().collect()
    }

    /// Returns the labels of the months.
    pub fn month_labels(&self, archive: &Archive) -> Result<Vec<String>> {
        Ok(self.hours(archive)?.by(Every::Month).labels.text)
    }

    /// Returns the numbers of days that have rows, of all months and of each.
    pub fn days(&self, archive: &Archive) -> Result<DayCounts> {
        let hours = self.hours(archive)?;
        let (days, months) = (hours.by(Every::Day), hours.by(Every::Month));
        let mut seen: Vec<HashSet<usize>> = vec![HashSet::new(); months.labels.len()];
        for ((day, _), (month, _)) in days.bins.of_condition.iter().zip(&months.bins.of_condition) {
            seen.get_mut(*month).map(|of_month| of_month.insert(*day));
        }
        Ok(DayCounts { all: days.labels.len(), of_month: seen.iter().map(HashSet::len).collect() })
    }

    /// Notes doubts about an archive in the band of photosynthetically active radiation.
    pub fn tell_par(&self, archive: &Archive) -> Result<()> {
        let light = LightRequest { bands: Box::new(BandList::new(&[Band::Par])), ..LightRequest::default() };
        light.tell_bands(Archives::one(archive), self.resources.observer)
    }

    /// Returns the sums of every receiver by month and component, kWh/m2.
    pub fn monthly(&self, archive: &Archive) -> Result<HashMap<String, MonthlySums>> {
        let found = self.by_month(archive, ComponentSet::ALL, PARTS, |_| true)?;
        Ok(found.into_iter().map(|(id, months)| (id, MonthlySums(months))).collect())
    }

    /// Returns the photosynthetically active radiation by month of the receivers for which `wanted`
    /// is true.
    pub fn monthly_par(&self, archive: &Archive, wanted: impl Fn(&str) -> bool) -> Result<HashMap<String, PlantLight>> {
        let found = self.by_month(archive, ComponentSet::new(&PAR), PAR, wanted)?;
        Ok(found.into_iter().map(|(id, months)| (id, PlantLight(months))).collect())
    }

    /// Returns sums, `[month][column]`, of the receivers for which `wanted` is true; `columns` must
    /// be among `components`.
    fn by_month<const N: usize>(
        &self,
        archive: &Archive,
        components: ComponentSet,
        columns: [Component; N],
        wanted: impl Fn(&str) -> bool,
    ) -> Result<HashMap<String, Vec<[f64; N]>>> {
        let mut found = HashMap::new();
        self.replayed(archive, Every::Month, components, |tile| {
            for (row, id) in tile.ids.iter().enumerate().filter(|(_, id)| wanted(id)) {
                let value = |part, bin: usize| tile.values.row(part, row).get(bin).copied().map_or(0.0, f64::from);
                let month = |bin: usize| columns.map(|part| value(part, bin));
                found.insert(id.clone(), (0..tile.values.bins()).map(month).collect());
            }
            Ok(())
        })?;
        Ok(found)
    }

    /// Returns the totals of every receiver over all hours, kWh/m2.
    pub fn totals(&self, archive: &Archive) -> Result<HashMap<String, f64>> {
        let mut found = HashMap::new();
        self.replayed(archive, Every::Total, ComponentSet::new(&[Component::Total]), |tile| {
            for (row, id) in tile.ids.iter().enumerate() {
                let total = tile.values.row(Component::Total, row).first().copied().map_or(0.0, f64::from);
                found.insert(id.clone(), total);
            }
            Ok(())
        })?;
        Ok(found)
    }

    /// Calls `each` with the hours of every receiver, one after the other.
    pub fn hourly(&self, archive: &Archive, mut each: impl FnMut(&str, SideHours) -> Result<()>) -> Result<()> {
        self.replayed(archive, Every::Hour, ComponentSet::ALL, |tile| {
            let mut rows = tile.ids.iter().enumerate();
            rows.try_for_each(|(row, id)| each(id, SideHours::new(|component| tile.values.row(component, row))))
        })
    }

    /// Returns the suns and skies of the rows that count.
    pub fn hours(&self, archive: &Archive) -> Result<Rc<Series>> {
        let steps = self.steps(archive);
        let mut kept = self.kept.borrow_mut();
        if let Some((_, series)) = kept.as_ref().filter(|(of, _)| *of == steps) {
            return Ok(Rc::clone(series));
        }
        let (archives, about) = (Archives::one(archive), Provenance::default());
        let series = self.request.series(archives, self.weather, self.dated, about, &self.quietly())?;
        let series = Rc::new(series);
        *kept = Some((steps, Rc::clone(&series)));
        Ok(series)
    }

    /// Returns the resources of a replay, without an observer: there are many replays.
    fn quietly(&self) -> Resources<'a> {
        Resources { observer: &Silent, ..self.resources }
    }

    /// Replays an archive and hands over every tile.
    fn replayed(
        &self,
        archive: &Archive,
        every: Every,
        components: ComponentSet,
        mut each: impl FnMut(&Tile) -> Result<()>,
    ) -> Result<()> {
        let (series, receivers) = (self.hours(archive)?.by(every), ReceiverSet::all_of(archive)?);
        let (light, resources) = (&self.request.light, self.quietly());
        let stream = TileStream { receivers: &receivers, light, series: &series, resources };
        stream.each(components, |tile| each(tile).map(|()| true))
    }
}
