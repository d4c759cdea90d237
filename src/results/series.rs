//! Conditions of results, in order. In: conditions, or chosen rows of a weather file. Out:
//! conditions with their labels, the bins that they add up in, the changes over them, and the same
//! conditions in longer periods.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::archives::Archives;
use super::doubts::{left_out, mean_ground};
use super::own_skies::ConditionRows;
use super::request::{ConditionSource, QueryRequest, ReplayRequest};
use super::resources::Resources;
use crate::outputs::periods::{ClockReading, Every, Periods};
use crate::outputs::provenance::Provenance;
use crate::outputs::tables::bin_labels::BinLabels;
use crate::outputs::tables::layout::BinKind;
use heliotile_core::archive::Archive;
use heliotile_core::error::Result;
use heliotile_core::light::states::Schedule;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::ComponentSet;
use heliotile_core::replay::reflectances::{Changeable, Changes};
use heliotile_core::replay::values::TileValues;
use heliotile_core::text::Message;
use heliotile_core::weather::conditions::{Condition, Stamp, parse_conditions};
use heliotile_core::weather::options::StampedAt;
use heliotile_core::weather::row::WeatherRow;
use heliotile_core::weather::time::bins::Bins;
use heliotile_core::weather::time::utc_offset::UtcOffset;
use heliotile_core::weather::time::years::Years;
use heliotile_weather::dated::DatedRows;
use heliotile_weather::series::Weather;
use heliotile_weather::temperatures::emissions;

/// Conditions with their labels, bins and changes.
#[derive(Clone)]
pub struct Series {
    /// Suns and skies.
    pub conditions: Arc<Vec<Condition>>,
    /// Kind of the labels, which also decides the unit.
    pub kind: BinKind,
    /// Period of a row; `None` in a query.
    pub every: Option<Every>,
    /// Labels of the rows of a receiver.
    pub labels: BinLabels,
    /// Label that each condition adds to.
    pub bins: Bins,
    /// Description of the conditions in words, for pictures.
    pub called: String,
    /// File that the conditions come from, for messages.
    pub source: PathBuf,
    reflectances: Reflectances,
    clock: Option<Clock>,
    /// Provenance of the inputs, without the labelling of rows.
    provenance: Provenance,
}

/// Reflectances and transmittances over the conditions.
#[derive(Clone)]
enum Reflectances {
    /// Changes over conditions without dates.
    Undated(Changes),
    /// Changes over the chosen rows of weather.
    Dated(Changes, Arc<[WeatherRow]>, Arc<[bool]>),
    /// Reflectance of all ground, one value a condition.
    Ground(Arc<[f64]>),
}

/// Clock that turns dates of conditions into labels.
#[derive(Clone)]
struct Clock {
    stamps: Vec<Stamp>,
    years: Years,
    reading: ClockReading,
    interval_hours: f64,
}

impl Clock {
    fn periods(&self, every: Every) -> Periods {
        Periods::new(every, self.years, &self.stamps, self.reading)
    }
}

impl Series {
    /// Returns a series of the conditions of a table.
    pub fn of_conditions(conditions: Vec<Condition>, changes: Changes, provenance: Provenance) -> Self {
        let labels = BinLabels::words(conditions.iter().map(|condition| condition.label.clone()).collect());
        Series {
            bins: Bins::each(labels.len()),
            conditions: Arc::new(conditions),
            kind: BinKind::Conditions,
            every: None,
            labels,
            called: String::new(),
            source: PathBuf::new(),
            reflectances: Reflectances::Undated(changes),
            clock: None,
            provenance,
        }
    }

    /// Returns a series in which all ground has the reflectance `ground[condition]`; `None`: the
    /// reflectances that the archive states.
    pub fn over_ground(conditions: Vec<Condition>, ground: Option<&[f64]>) -> Self {
        let series = Series::of_conditions(conditions, Changes::default(), Provenance::default());
        match ground {
            Some(ground) => Series { reflectances: Reflectances::Ground(ground.into()), ..series },
            None => series,
        }
    }

    /// Returns a series of the chosen rows of `weather`, which was read already, with its air if
    /// longwave is requested.
    pub(super) fn of_weather(
        archive: &Archive,
        weather: &Weather,
        dated: &DatedRows,
        request: &ReplayRequest,
        provenance: Provenance,
        resources: &Resources,
    ) -> Result<Self> {
        let chosen = &dated.chosen;
        let steps = request.steps.unwrap_or_else(|| weather.steps_of(archive.manifest().settings.steps()));
        let all = weather.conditions(steps).into_iter().zip(chosen);
        let conditions = all.filter_map(|(condition, chosen)| chosen.then_some(condition)).collect();
        let places = chosen.iter().enumerate().filter_map(|(place, chosen)| chosen.then_some(place)).collect();
        let rows = ConditionRows { places, count: chosen.len(), file: "a weather file" };
        let mut conditions = request.light.skies().over(conditions, &rows, resources)?;
        let air = weather.air.iter().zip(chosen).filter_map(|(air, chosen)| chosen.then_some(*air));
        conditions.iter_mut().zip(air).for_each(|(condition, air)| condition.air = Some(air));
        if let Some(temperatures) = request.longwave() {
            let emissions = emissions(weather, &request.weather, chosen, temperatures, resources.files)?;
            conditions.iter_mut().zip(emissions).for_each(|(condition, emission)| condition.emission = Some(emission));
        }
        let dates = dated.dates.iter().zip(chosen).filter_map(|(date, chosen)| chosen.then_some(*date));
        let stamps =
            conditions.iter().zip(dates).filter_map(|(condition, date)| Some(Stamp { date, ..condition.stamp? }));
        let clock = Clock {
            stamps: stamps.collect(),
            years: dated.years,
            reading: ClockReading { offset: UtcOffset::of_hours(weather.site.zone_hours), at: request.stamp },
            interval_hours: weather.interval_hours,
        };
        let series = Series {
            bins: Bins::each(conditions.len()),
            conditions: Arc::new(conditions),
            kind: BinKind::Times,
            every: Some(Every::Hour),
            labels: BinLabels::words(Vec::new()),
            called: String::new(),
            source: request.weather.clone(),
            reflectances: Reflectances::Dated(
                request.changes(),
                weather.rows.as_slice().into(),
                chosen.as_slice().into(),
            ),
            clock: Some(clock),
            provenance: provenance.with_weather(&request.weather, weather).with_option("steps", steps),
        };
        Ok(series.by(request.every))
    }

    /// Returns this series with `called` as its description in words.
    pub fn called(self, called: String) -> Self {
        Series { called, ..self }
    }

    /// Returns the same conditions in rows of the period `every`. A query has no periods and stays
    /// as it is.
    #[must_use]
    pub fn by(&self, every: Every) -> Self {
        let Some(clock) = &self.clock else { return self.clone() };
        let periods = clock.periods(every);
        let (kind, bins) = match every {
            Every::Hour => (BinKind::Times, Bins::each(self.conditions.len())),
            _ => (BinKind::Sums, periods.bins()),
        };
        Series { kind, bins, labels: periods.labels, every: Some(every), ..self.clone() }
    }

    /// Returns how rows of this series add up to those of the same conditions in `longer` periods;
    /// `None` if the periods are equal.
    pub(super) fn coarsening(&self, longer: &Series) -> Option<Coarsening> {
        if longer.every == self.every {
            return None;
        }
        let of_means = self.every == Some(Every::Hour);
        let mut of_label = vec![(0, 0.0); self.labels.len()];
        for (fine, coarse) in self.bins.of_condition.iter().zip(&longer.bins.of_condition) {
            // Means over an interval become energy; sums stay sums.
            let weight = if of_means { coarse.1 } else { 1.0 };
            if let Some(to) = of_label.get_mut(fine.0) {
                *to = (coarse.0, weight);
            }
        }
        Some(Coarsening { labels: longer.labels.len(), of_label, of_means })
    }

    /// Returns the provenance of the inputs, with the labelling of rows.
    pub fn provenance(&self) -> Provenance {
        let Some(clock) = &self.clock else { return self.provenance.clone() };
        match self.every {
            Some(Every::Hour) => {
                let about = self.provenance.clone().with("stamp", clock.reading.at.name());
                about.with("interval_minutes", 60.0 * clock.interval_hours)
            }
            _ => self.provenance.clone().with("stamp", StampedAt::Start.name()),
        }
    }

    /// Returns the schedules of reflectances and transmittances over the conditions. A name that
    /// this archive does not know is skipped if `elsewhere` says that another archive of the same
    /// results knows it.
    pub(super) fn schedules(
        &self,
        archive: &Archive,
        site: &OpenSite,
        elsewhere: &dyn Fn(&str) -> bool,
        resources: &Resources,
    ) -> Result<Vec<Schedule>> {
        let changeable = Changeable::new(site, archive.manifest());
        let files = resources.files;
        let known = |changes: &Changes| changes.only(|name| changeable.knows(name) || !elsewhere(name));
        match &self.reflectances {
            Reflectances::Ground(values) => {
                let materials = site.grounds();
                let counts = site.settings().diffuse && !materials.is_empty();
                Ok(counts.then(|| Schedule { materials, values: values.to_vec() }).into_iter().collect())
            }
            Reflectances::Undated(changes) | Reflectances::Dated(changes, ..)
                if changes.is_empty() && changeable.ground.is_none() =>
            {
                Ok(Vec::new())
            }
            Reflectances::Undated(changes) => known(changes).undated(&changeable, self.conditions.len(), files),
            Reflectances::Dated(changes, rows, chosen) => {
                let (mut schedules, warnings) = known(changes).over(&changeable, rows, files)?;
                warnings.iter().for_each(|text| resources.observer.warn(text));
                for schedule in &mut schedules {
                    let mut chosen = chosen.iter();
                    schedule.values.retain(|_| chosen.next() == Some(&true));
                }
                Ok(schedules)
            }
        }
    }
}

impl QueryRequest {
    /// Returns the conditions of the table as a series. Warns of what is odd about them and the
    /// archives.
    pub fn series(&self, archives: Archives, about: Provenance, resources: &Resources) -> Result<Series> {
        let tell = |text: &Message| resources.observer.warn(text);
        let (found, name) = match &self.conditions {
            ConditionSource::File(path) => {
                let file = parse_conditions(path, &(resources.files)(path)?)?;
                file.warnings.iter().for_each(tell);
                (file.conditions, path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned())
            }
            ConditionSource::Rows(rows) => (rows.clone(), "conditions".to_owned()),
        };
        mean_ground(archives.first(), &self.light.changes)?.iter().for_each(tell);
        left_out(archives.first(), None).iter().for_each(|text| resources.observer.warn(text));
        self.light.tell_bands(archives, resources.observer)?;
        let called = match found.as_slice() {
            [only] => format!("{name}: {}", only.label),
            _ => name.clone(),
        };
        let changes = self.light.changes.clone();
        let count = found.len();
        let rows = ConditionRows { places: (0..count).collect(), count, file: "a table of conditions" };
        let conditions = self.light.skies().over(found, &rows, resources)?;
        Ok(Series::of_conditions(conditions, changes, about.with("conditions", name)).called(called))
    }
}

impl ReplayRequest {
    /// Returns the rows of weather that count as a series of conditions, with labels and changes.
    pub fn series(
        &self,
        archives: Archives,
        weather: &Weather,
        dated: &DatedRows,
        about: Provenance,
        resources: &Resources,
    ) -> Result<Series> {
        let series = Series::of_weather(archives.first(), weather, dated, self, about, resources)?;
        Ok(series.called(called(&self.weather, dated)))
    }
}

/// Returns the name of a weather file and the first and last of its chosen days, in words.
fn called(weather: &Path, dated: &DatedRows) -> String {
    let mut days = dated.dates.iter().zip(&dated.chosen).filter_map(|(date, chosen)| chosen.then_some(date));
    let day = |date: &heliotile_core::weather::time::calendar::Date| date.day_label(dated.years.matter());
    let name = weather.file_name().unwrap_or(weather.as_os_str()).to_string_lossy().into_owned();
    let (first, last) = (days.next(), days.next_back());
    match (first.map(day), last.or(first).map(day)) {
        (Some(first), Some(last)) if first != last => format!("{name}, {first} to {last}"),
        (Some(only), _) => format!("{name}, {only}"),
        _ => name,
    }
}

/// Map from rows of short periods to rows of longer periods.
#[derive(Clone, Debug, PartialEq)]
pub struct Coarsening {
    labels: usize,
    /// `[short]`: index of the long period that contains it, and the weight of its value there.
    of_label: Vec<(usize, f64)>,
    /// True if the short rows are means.
    of_means: bool,
}

impl Coarsening {
    /// Returns values over the longer periods; sums are kept in f64.
    pub fn of(&self, values: &TileValues, components: ComponentSet) -> TileValues {
        let mut coarse = TileValues::new(values.receivers(), self.labels);
        let mut sums = vec![0.0_f64; self.labels];
        for component in components.iter() {
            let unit = if self.of_means { component.measure().sum_factor() } else { 1.0 };
            let rows = coarse.component_mut(component).chunks_mut(self.labels.max(1));
            for (receiver, to) in rows.enumerate() {
                sums.fill(0.0);
                for ((label, weight), value) in self.of_label.iter().zip(values.row(component, receiver)) {
                    if let Some(sum) = sums.get_mut(*label) {
                        *sum += weight * unit * f64::from(*value);
                    }
                }
                to.iter_mut().zip(&sums).for_each(|(to, sum)| *to = *sum as f32);
            }
        }
        coarse
    }
}
