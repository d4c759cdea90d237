//! The light of a weather file on an archive. In: an archive, weather. Out: sums by month and hours of its receivers, as core replays them.

use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

use crate::cli::PvArgs;
use crate::commands::{temporary_files, warn};
use crate::files::read_file;
use crate::outputs::periods::{ClockReading, Every, Periods};
use crate::outputs::pv::hourly::SideHours;
use crate::outputs::pv::sums::{MonthlySums, PARTS};
use crate::outputs::tables::row_labels::RowLabels;
use heliotile_core::archive::Archive;
use heliotile_core::error::Result;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::replay::reflectances::{Changeable, Changes};
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::replay::values::TileValues;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::conditions::{Condition, Stamp};
use heliotile_core::weather::dated::DatedRows;
use heliotile_core::weather::options::StampedAt;
use heliotile_core::weather::series::Weather;
use heliotile_core::weather::span::Span;
use heliotile_core::weather::time::bins::Bins;
use heliotile_core::weather::time::utc_offset::UtcOffset;
use heliotile_core::weather::time::years::Years;

/// Weather, and how it is told.
pub struct Light<'a> {
    weather: &'a Weather,
    dated: DatedRows,
    sky: SkyModel,
    clock: ClockReading,
    memory: MemoryBudget,
    stamps: Vec<Stamp>,
    /// By the number of steps.
    kept: RefCell<Option<(usize, Rc<Vec<Condition>>)>>,
}

impl<'a> Light<'a> {
    /// Of a command line; warns of days that a year does not have.
    pub fn new(args: &PvArgs, weather: &'a Weather) -> Result<Self> {
        let intervals: Vec<_> = weather.rows.iter().map(|row| row.interval).collect();
        let whole = Span::new(None, None)?;
        let dated = match args.year {
            Some(year) => DatedRows::in_year(&intervals, &args.weather, &whole, year)?,
            None => DatedRows::of_file(&intervals, &args.weather, &whole)?,
        };
        dated.warnings.iter().for_each(|w| warn(w));
        let chosen = dated.dates.iter().zip(&intervals).zip(&dated.chosen).filter(|(_, chosen)| **chosen);
        let stamp = |((date, interval), _): ((&_, &heliotile_core::weather::time::sun::Interval), _)| Stamp {
            date: *date,
            start_min: interval.start_min,
            hours: weather.interval_hours,
        };
        let stamps = chosen.map(stamp).collect();
        let clock = ClockReading { offset: UtcOffset::of_hours(weather.site.zone_hours), at: args.stamp };
        Ok(Light {
            weather,
            sky: args.sky,
            clock,
            memory: MemoryBudget::new(args.memory.0),
            stamps,
            dated,
            kept: RefCell::default(),
        })
    }

    /// Positions of the sun in an interval.
    pub fn steps(&self, archive: &Archive) -> usize {
        self.weather.steps_of(archive.manifest().settings.steps())
    }

    /// Which moment of its interval a row is labelled with.
    pub fn stamp(&self) -> StampedAt {
        self.clock.at
    }

    pub fn interval_minutes(&self) -> f64 {
        60.0 * self.weather.interval_hours
    }

    /// What readers of times may want to know.
    pub fn notes(&self, args: &PvArgs) -> Vec<String> {
        let typical = self.dated.years == Years::Typical && !args.no_hourly;
        let text = "months of the weather file come from different years, and hours have these years; --year puts them into one";
        typical.then(|| text.to_owned()).into_iter().collect()
    }

    fn periods(&self, every: Every) -> Periods {
        Periods::new(every, self.dated.years, &self.stamps, self.clock)
    }

    pub fn month_labels(&self) -> Vec<String> {
        self.periods(Every::Month).labels.text
    }

    pub fn hour_labels(&self) -> RowLabels {
        self.periods(Every::Hour).labels
    }

    /// Sums of every receiver by month and component, kWh/m2.
    pub fn monthly(&self, archive: &Archive) -> Result<HashMap<String, MonthlySums>> {
        let bins = self.periods(Every::Month).bins();
        let mut found = HashMap::new();
        self.replayed(archive, &bins, ComponentSet::ALL, |id, values, row| {
            let month =
                |label: usize| PARTS.map(|part| values.row(part, row).get(label).copied().map_or(0.0, f64::from));
            found.insert(id.to_owned(), MonthlySums((0..bins.count).map(month).collect()));
            Ok(())
        })?;
        Ok(found)
    }

    /// Totals of every receiver over all hours, kWh/m2.
    pub fn totals(&self, archive: &Archive) -> Result<HashMap<String, f64>> {
        let bins = self.periods(Every::Total).bins();
        let mut found = HashMap::new();
        self.replayed(archive, &bins, ComponentSet::of(&[Component::Total]), |id, values, row| {
            let total = values.row(Component::Total, row).first().copied().map_or(0.0, f64::from);
            found.insert(id.to_owned(), total);
            Ok(())
        })?;
        Ok(found)
    }

    /// Hours of every receiver, one after the other.
    pub fn hourly(&self, archive: &Archive, mut each: impl FnMut(&str, SideHours) -> Result<()>) -> Result<()> {
        let bins = Bins::each(self.stamps.len());
        self.replayed(archive, &bins, ComponentSet::ALL, |id, values, row| {
            each(id, SideHours::of(|component| values.row(component, row)))
        })
    }

    /// Suns and skies of the rows that count; those of the last number of steps are kept, since the sun costs more than the light.
    fn conditions(&self, steps: usize) -> Rc<Vec<Condition>> {
        let mut kept = self.kept.borrow_mut();
        if let Some((_, conditions)) = kept.as_ref().filter(|(of, _)| *of == steps) {
            return Rc::clone(conditions);
        }
        let all = self.weather.conditions(steps).into_iter().zip(&self.dated.chosen);
        let conditions = Rc::new(all.filter_map(|(condition, chosen)| chosen.then_some(condition)).collect());
        *kept = Some((steps, Rc::clone(&conditions)));
        conditions
    }

    /// Replays an archive and hands over every receiver.
    fn replayed(
        &self,
        archive: &Archive,
        bins: &Bins,
        components: ComponentSet,
        mut each: impl FnMut(&str, &TileValues, usize) -> Result<()>,
    ) -> Result<()> {
        let site = OpenSite::of(archive)?;
        let chosen = &self.dated.chosen;
        let conditions = self.conditions(self.steps(archive));
        // What the model states of its ground, by month; nothing else is asked for.
        let changeable = Changeable::of(&site, archive.manifest());
        let (mut schedules, _) = Changes::default().over(&changeable, &self.weather.rows, &read_file)?;
        for schedule in &mut schedules {
            let mut chosen = chosen.iter();
            schedule.values.retain(|_| chosen.next() == Some(&true));
        }
        let storage = temporary_files();
        let settings = ReplaySettings {
            sky: self.sky,
            patches: archive.manifest().settings.patches(),
            components,
            memory: self.memory,
            storage: &storage,
            ..ReplaySettings::default()
        };
        let replay = Replay::scheduled(&site, &conditions, settings, bins, &schedules)?;
        for tile in replay.results(0..replay.tiles()) {
            let (ids, values) = tile?;
            for (row, id) in ids.iter().enumerate() {
                each(id, &values, row)?;
            }
        }
        Ok(())
    }
}
