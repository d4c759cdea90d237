//! The light of a weather file on an archive. In: an archive, weather. Out: sums by month and hours of its receivers, as core replays them.

use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use super::PvRequest;
use crate::bands::BandList;
use crate::outputs::pv::ground::{DayCounts, PAR, PlantLight};
use crate::outputs::pv::hourly::SideHours;
use crate::outputs::pv::sums::{MonthlySums, PARTS};
use crate::outputs::tables::row_labels::RowLabels;
use crate::{
    Archives, Every, LightChoice, Provenance, ReceiverSet, ReplayRequest, Resources, Series, Tile, TileStream,
};
use heliotile_core::archive::Archive;
use heliotile_core::error::Result;
use heliotile_core::observer::{Observer, Silent};
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::site::bands::Band;
use heliotile_core::weather::dated::DatedRows;
use heliotile_core::weather::options::StampedAt;
use heliotile_core::weather::series::Weather;
use heliotile_core::weather::time::years::Years;

/// Weather, and the rows that results have.
pub struct Light<'a> {
    weather: &'a Weather,
    request: ReplayRequest,
    dated: &'a DatedRows,
    resources: Resources<'a>,
    /// Hours by the number of positions of the sun in each: those of the last number, since the sun costs more than the light.
    kept: RefCell<Option<(usize, Rc<Series<'a>>)>>,
}

/// The replay of a study.
fn replay_of(request: &PvRequest) -> ReplayRequest {
    let light = LightChoice { sky: request.sky, ..LightChoice::default() };
    ReplayRequest { light, year: request.year, stamp: request.stamp, ..ReplayRequest::of(&request.weather) }
}

/// The rows of weather that count; warns of days that a year does not have.
pub fn rows_of(request: &PvRequest, weather: &Weather, observer: &dyn Observer) -> Result<DatedRows> {
    // What is to be said of years is a note in the end.
    ReplayRequest { every: Every::Total, ..replay_of(request) }.dated(weather, observer)
}

impl<'a> Light<'a> {
    /// Of the rows of weather that count.
    pub fn new(request: &PvRequest, weather: &'a Weather, dated: &'a DatedRows, resources: Resources<'a>) -> Self {
        Light { weather, request: replay_of(request), dated, resources, kept: RefCell::default() }
    }

    /// Whom long work tells.
    pub fn observer(&self) -> &dyn Observer {
        self.resources.observer
    }

    /// Positions of the sun in an interval.
    pub fn steps(&self, archive: &Archive) -> usize {
        self.weather.steps_of(archive.manifest().settings.steps())
    }

    /// Which moment of its interval a row is labelled with.
    pub fn stamp(&self) -> StampedAt {
        self.request.stamp
    }

    pub fn interval_minutes(&self) -> f64 {
        60.0 * self.weather.interval_hours
    }

    /// What readers of times may want to know.
    pub fn notes(&self, request: &PvRequest) -> Vec<String> {
        let typical = self.dated.years == Years::Typical && request.hourly;
        let text = "months of the weather file come from different years, and hours have these years; {year} puts them into one";
        typical.then(|| text.to_owned()).into_iter().collect()
    }

    /// Labels of the months.
    pub fn month_labels(&self, archive: &Archive) -> Result<Vec<String>> {
        Ok(self.hours(archive)?.by(Every::Month).labels.text)
    }

    /// Labels of the hours.
    pub fn hour_labels(&self, archive: &Archive) -> Result<RowLabels> {
        Ok(self.hours(archive)?.labels.clone())
    }

    /// Days that have rows, of all months and of each.
    pub fn days(&self, archive: &Archive) -> Result<DayCounts> {
        let hours = self.hours(archive)?;
        let (days, months) = (hours.by(Every::Day), hours.by(Every::Month));
        let mut seen: Vec<HashSet<usize>> = vec![HashSet::new(); months.labels.len()];
        for ((day, _), (month, _)) in days.bins.of_condition.iter().zip(&months.bins.of_condition) {
            seen.get_mut(*month).map(|of_month| of_month.insert(*day));
        }
        Ok(DayCounts { all: days.labels.len(), of_month: seen.iter().map(HashSet::len).collect() })
    }

    /// Tells what is doubtful about an archive in the light that plants live on.
    pub fn tell_par(&self, archive: &Archive) -> Result<()> {
        let light = LightChoice { bands: Box::new(BandList::of(&[Band::Par])), ..LightChoice::default() };
        light.tell_bands(Archives::one(archive), self.resources.observer)
    }

    /// Sums of every receiver by month and component, kWh/m2.
    pub fn monthly(&self, archive: &Archive) -> Result<HashMap<String, MonthlySums>> {
        let found = self.by_month(archive, ComponentSet::ALL, PARTS, |_| true)?;
        Ok(found.into_iter().map(|(id, months)| (id, MonthlySums(months))).collect())
    }

    /// What plants live on by month, of some receivers.
    pub fn monthly_par(&self, archive: &Archive, wanted: impl Fn(&str) -> bool) -> Result<HashMap<String, PlantLight>> {
        let found = self.by_month(archive, ComponentSet::of(&PAR), PAR, wanted)?;
        Ok(found.into_iter().map(|(id, months)| (id, PlantLight(months))).collect())
    }

    /// Sums of some receivers, `[month][column]`, of columns that are among some components.
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
                let value = |part, label: usize| tile.values.row(part, row).get(label).copied().map_or(0.0, f64::from);
                let month = |label: usize| columns.map(|part| value(part, label));
                found.insert(id.clone(), (0..tile.values.labels()).map(month).collect());
            }
            Ok(())
        })?;
        Ok(found)
    }

    /// Totals of every receiver over all hours, kWh/m2.
    pub fn totals(&self, archive: &Archive) -> Result<HashMap<String, f64>> {
        let mut found = HashMap::new();
        self.replayed(archive, Every::Total, ComponentSet::of(&[Component::Total]), |tile| {
            for (row, id) in tile.ids.iter().enumerate() {
                let total = tile.values.row(Component::Total, row).first().copied().map_or(0.0, f64::from);
                found.insert(id.clone(), total);
            }
            Ok(())
        })?;
        Ok(found)
    }

    /// Hours of every receiver, one after the other.
    pub fn hourly(&self, archive: &Archive, mut each: impl FnMut(&str, SideHours) -> Result<()>) -> Result<()> {
        self.replayed(archive, Every::Hour, ComponentSet::ALL, |tile| {
            let mut rows = tile.ids.iter().enumerate();
            rows.try_for_each(|(row, id)| each(id, SideHours::of(|component| tile.values.row(component, row))))
        })
    }

    /// Suns and skies of the rows that count.
    fn hours(&self, archive: &Archive) -> Result<Rc<Series<'a>>> {
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

    /// What a replay may use; it tells nobody, as there are many.
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
