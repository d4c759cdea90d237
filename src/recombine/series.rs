//! What results are made of, in order. In: conditions, or chosen rows of a weather file. Out: conditions with their labels, the bins that they
//! add up in, and what they change.

use std::path::Path;

use crate::outputs::periods::{ClockReading, Every, Periods};
use crate::outputs::provenance::Provenance;
use crate::outputs::tables::layout::Labels;
use crate::outputs::tables::row_labels::RowLabels;
use heliotile_builder::observer::Observer;
use heliotile_core::archive::Archive;
use heliotile_core::error::Result;
use heliotile_core::light::states::Schedule;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::reflectances::{Changeable, Changes};
use heliotile_core::weather::conditions::{Condition, Stamp};
use heliotile_core::weather::dated::DatedRows;
use heliotile_core::weather::formats::schedule_csv::ReadFile;
use heliotile_core::weather::options::StampedAt;
use heliotile_core::weather::row::WeatherRow;
use heliotile_core::weather::series::Weather;
use heliotile_core::weather::temperatures::{Temperature, emissions};
use heliotile_core::weather::time::bins::Bins;
use heliotile_core::weather::time::utc_offset::UtcOffset;

/// Conditions, and what they are called.
pub struct Series<'a> {
    /// Suns and skies.
    pub conditions: Vec<Condition>,
    /// What labels are, and with them the unit.
    pub kind: Labels,
    /// None in a query.
    pub every: Option<Every>,
    /// Of the rows of a receiver.
    pub labels: RowLabels,
    /// Which label a condition adds to.
    pub bins: Bins,
    /// Reflectances and transmittances.
    pub changes: Changes,
    /// Rows of the weather file, and which of them the conditions are; none in a query.
    rows: (&'a [WeatherRow], &'a [bool]),
    /// What is known of the inputs.
    pub provenance: Provenance,
    /// What these are, in words, for pictures.
    pub called: String,
}

/// How a weather file becomes rows of results.
#[derive(Clone, Copy)]
pub struct WeatherReading<'a> {
    /// The file, for messages and its name.
    pub file: &'a Path,
    /// What a row stands for.
    pub every: Every,
    /// Which moment of its interval a row of means is labelled with.
    pub stamp: StampedAt,
    /// Positions of the sun in an interval; none: those that the archive was built for.
    pub steps: Option<usize>,
    /// Temperatures of what longwave radiation comes from, if that is asked for.
    pub longwave: Option<&'a [Temperature]>,
    /// How the bytes of schedules are got.
    pub files: ReadFile<'a>,
}

impl<'a> Series<'a> {
    /// Conditions of a table.
    pub fn of_conditions(conditions: Vec<Condition>, changes: Changes, provenance: Provenance) -> Self {
        let labels = RowLabels::words(conditions.iter().map(|condition| condition.label.clone()).collect());
        let (kind, bins) = (Labels::Conditions, Bins::each(labels.len()));
        Series {
            conditions,
            kind,
            every: None,
            labels,
            bins,
            changes,
            rows: (&[], &[]),
            provenance,
            called: String::new(),
        }
    }

    /// The chosen rows of weather that was read already, with its air if longwave is asked for.
    pub fn of_weather(
        archive: &Archive,
        (weather, dated): (&'a Weather, &'a DatedRows),
        reading: &WeatherReading,
        changes: Changes,
        provenance: Provenance,
    ) -> Result<Self> {
        let chosen = &dated.chosen;
        let steps = reading.steps.unwrap_or_else(|| weather.steps_of(archive.manifest().settings.steps()));
        let mut conditions: Vec<Condition> = {
            let all = weather.conditions(steps).into_iter();
            all.zip(chosen).filter_map(|(condition, chosen)| chosen.then_some(condition)).collect()
        };
        if let Some(temperature) = reading.longwave {
            let emissions = emissions(weather, reading.file, chosen, temperature, reading.files)?;
            conditions.iter_mut().zip(emissions).for_each(|(condition, emission)| condition.emission = Some(emission));
        }
        let dates = dated.dates.iter().zip(chosen).filter_map(|(date, chosen)| chosen.then_some(*date));
        let stamps =
            conditions.iter().zip(dates).filter_map(|(condition, date)| Some(Stamp { date, ..condition.stamp? }));
        let clock = ClockReading { offset: UtcOffset::of_hours(weather.site.zone_hours), at: reading.stamp };
        let periods = Periods::new(reading.every, dated.years, &stamps.collect::<Vec<_>>(), clock);
        let (kind, bins) = match reading.every {
            Every::Hour => (Labels::Times, Bins::each(conditions.len())),
            _ => (Labels::Sums, periods.bins()),
        };
        let rows = (weather.rows.as_slice(), chosen.as_slice());
        let provenance = provenance.with_weather(reading.file, weather).with_option("steps", steps);
        let provenance = match reading.every {
            Every::Hour => {
                provenance.with("stamp", reading.stamp.name()).with("interval_minutes", 60.0 * weather.interval_hours)
            }
            _ => provenance.with("stamp", StampedAt::Start.name()),
        };
        Ok(Series {
            conditions,
            kind,
            every: Some(reading.every),
            labels: periods.labels,
            bins,
            changes,
            rows,
            provenance,
            called: String::new(),
        })
    }

    /// The same with what it is in words.
    pub fn called(self, called: String) -> Self {
        Series { called, ..self }
    }

    /// Schedules of reflectances and transmittances over the conditions. What an archive does not know is passed over where `elsewhere`
    /// says that another one of the same results knows it.
    pub(super) fn schedules(
        &self,
        (archive, site): (&Archive, &OpenSite),
        elsewhere: &dyn Fn(&str) -> bool,
        files: ReadFile,
        observer: &dyn Observer,
    ) -> Result<Vec<Schedule>> {
        let changeable = Changeable::of(site, archive.manifest());
        if self.changes.is_empty() && changeable.ground.is_none() {
            return Ok(Vec::new());
        }
        let changes = self.changes.only(|name| changeable.knows(name) || !elsewhere(name));
        let (rows, chosen) = self.rows;
        if rows.is_empty() {
            return changes.undated(&changeable, self.conditions.len(), files);
        }
        let (mut schedules, warnings) = changes.over(&changeable, rows, files)?;
        warnings.iter().for_each(|w| observer.warn(w));
        for schedule in &mut schedules {
            let mut chosen = chosen.iter();
            schedule.values.retain(|_| chosen.next() == Some(&true));
        }
        Ok(schedules)
    }
}
