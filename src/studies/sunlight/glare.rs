//! Glare: the sun in mirrors, spell by spell. In: the spells that receivers see on days, the panes
//! of the scene. Out: a table of spells, panes with the minutes of glare that they cause, a
//! calendar.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

use super::days::DayPlan;
use super::panes::{Pane, PaneList, ScenePanes};
use heliotile_builder::siting::MirrorObserver;
use heliotile_core::error::{Error, Result, check_ranges};
use heliotile_core::memory::Use;
use heliotile_core::observer::Observer;
use heliotile_core::site::north::North;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::{counted, message};
use heliotile_core::units::tilt_and_azimuth;
use heliotile_core::weather::time::calendar::Date;
use heliotile_files::writing::guards::guard_output;
use heliotile_requests::{DefaultRequest, Request};
use heliotile_results::files::{MapStart, crs_of, name_of, say_large};
use heliotile_results::outputs::groups::GroupGeometry;
use heliotile_results::outputs::pictures::calendar::{Calendar, CalendarDay, CalendarSpell};
use heliotile_results::outputs::provenance::Provenance;
use heliotile_results::outputs::quantities::{Measure, PlaceValues, Quantity, ValueSource};
use heliotile_results::outputs::result_file::{ResultFile, ResultFormat};
use heliotile_results::outputs::row_maker::RowMaker;
use heliotile_results::outputs::shapes::writer::PlaceShapes;
use heliotile_results::outputs::sink::Sink;
use heliotile_results::outputs::tables::bin_labels::BinLabels;
use heliotile_results::outputs::tables::column::Column;
use heliotile_results::outputs::tables::format::Format;
use heliotile_results::outputs::tables::layout::{BinKind, By, Fact, Layout};
use heliotile_results::outputs::tables::table::{Cell, Table};
use heliotile_results::outputs::tables::writer::Places;
use heliotile_results::receivers::ReceiverSet;
use heliotile_results::resources::Resources;
use heliotile_sunlight::{GlareAngles, MirrorSpells, Spell, Spells, Strongest, SunDay};

/// Angles of glare that counts, and files of glare besides the rows of places.
#[derive(Clone, Debug, PartialEq, Request, DefaultRequest)]
pub struct GlareChoice {
    /// Least angle between the sun and its image in a mirror that counts, degrees; if a rule states
    /// one too, the larger one applies.
    #[field(metavar = "DEGREES", default = 0.0, range = 0.0..=180.0)]
    pub least_deflection_deg: f64,
    /// Largest angle between the direction of view of a receiver, its normal, and an image of the
    /// sun in a mirror that counts, degrees: 30 for a driver; if a rule states one too, the smaller
    /// one applies.
    #[field(metavar = "DEGREES", default = 90.0, range = 0.0..=90.0)]
    pub view_angle_deg: f64,
    /// Table to write with a row for each spell, a time of unbroken reflected sun: receiver, day,
    /// start, end, pane, irradiance, angles.
    #[field(metavar = "FILE", output = Table)]
    pub spells: Option<PathBuf>,
    /// Table or map to write of the panes, with the minutes in which each reflects the sun to
    /// receivers.
    #[field(metavar = "FILE", output = Results)]
    pub panes: Option<PathBuf>,
}

impl GlareChoice {
    /// Refuses angles out of range, and files that cannot hold such results.
    pub fn check(&self, inputs: &[&Path]) -> Result<()> {
        check_ranges(self)?;
        if let Some(path) = &self.spells {
            Format::by_ending(path)?;
        }
        if let Some(path) = &self.panes {
            ResultFormat::by_ending(path, false)?;
        }
        self.files().try_for_each(|path| guard_output(path, inputs))
    }

    /// Returns the files that are written.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.spells.as_deref().into_iter().chain(self.panes.as_deref())
    }

    /// Returns the angles of glare that counts.
    pub fn angles(&self) -> GlareAngles {
        GlareAngles { least_deflection_deg: self.least_deflection_deg, view_angle_deg: self.view_angle_deg }
    }
}

/// Spell of glare from one pane.
#[derive(Clone, Debug)]
pub struct GlareSpell {
    date: Date,
    /// Beginning and end of the spell.
    pub spell: Spell,
    /// Uncertainty of the spell's length, minutes.
    uncertain_min: f64,
    /// Pane that is seen first in the direction of the image; `None` if rays meet no mirror there.
    pane: Option<Arc<Pane>>,
    /// Number of mirrors on the path of the light.
    mirrors: usize,
    strongest: Strongest,
    /// Direction of the sun in the middle of the spell, by true north.
    sun: DVec3,
}

/// Size of a table of spells from which it is large, bytes.
const LARGE_SPELLS: u64 = 100_000_000;

/// Minutes between rays that identify the pane.
const PANE_STEP_MIN: f64 = 1.0;

/// Number of bisections of these steps: changes from pane to pane are found to two seconds.
const BISECTIONS: usize = 5;

/// Number of directions around the image in which a pane is looked for.
const AROUND: usize = 8;

/// Finder of the panes of spells, by rays of the scene.
pub struct SpellTeller<'a> {
    pub panes: &'a ScenePanes,
    pub observer: MirrorObserver<'a>,
    pub north: North,
    /// Width of a texel of the sky texture, radians.
    pub texel_rad: f64,
}

impl SpellTeller<'_> {
    /// Returns the spells of a chain of mirrors on a day, cut at changes from one pane to another.
    pub fn spells(&self, mirror: &MirrorSpells, day: &SunDay) -> Vec<GlareSpell> {
        let mut found = Vec::new();
        for spell in mirror.seen.seen.iter() {
            let uncertain_min = uncertain_min(mirror, *spell);
            for (spell, pane) in self.cut(mirror, day, *spell) {
                let own = Spells::one(spell.start_min, spell.end_min);
                let Some(strongest) = Strongest::new(mirror, day, &own) else { continue };
                let sun = self.north.to_true(day.sun(0.5 * (spell.start_min + spell.end_min)));
                let (date, mirrors) = (day.date, mirror.chain.len());
                found.push(GlareSpell { date, spell, uncertain_min, pane, mirrors, strongest, sun });
            }
        }
        found
    }

    /// Returns the parts of a spell, each with its pane.
    fn cut(&self, mirror: &MirrorSpells, day: &SunDay, spell: Spell) -> Vec<(Spell, Option<Arc<Pane>>)> {
        let steps = (spell.minutes() / PANE_STEP_MIN).ceil().max(1.0) as usize;
        let middle = |step: usize| spell.start_min + spell.minutes() * (step as f64 + 0.5) / steps as f64;
        let pane_at = |moments: &[f64]| {
            let images: Vec<DVec3> = moments.iter().map(|at| mirror.image(day.sun(*at))).collect();
            let triangles = self.observer.mirrors(&images).into_iter();
            triangles.map(|triangle| self.panes.of_triangle(triangle?)).collect::<Vec<Option<&Arc<Pane>>>>()
        };
        let moments: Vec<f64> = (0..steps).map(middle).collect();
        // A ray within a texel of an edge may miss the pane.
        let known: Vec<(f64, &Arc<Pane>)> =
            moments.iter().zip(pane_at(&moments)).filter_map(|(at, pane)| Some((*at, pane?))).collect();
        let (mut parts, mut start_min) = (Vec::new(), spell.start_min);
        for two in known.windows(2) {
            let [(mut low, pane), (mut high, next)] = [two[0], two[1]];
            if pane.name == next.name {
                continue;
            }
            for _ in 0..BISECTIONS {
                let at = 0.5 * (low + high);
                let is_next =
                    pane_at(&[at]).first().is_some_and(|found| found.is_some_and(|one| one.name == next.name));
                if is_next { high = at } else { low = at }
            }
            let end_min = 0.5 * (low + high);
            parts.push((Spell { start_min, end_min }, Some(Arc::clone(pane))));
            start_min = end_min;
        }
        let last = match known.last() {
            Some((_, pane)) => Some(Arc::clone(pane)),
            None => self.near(mirror.image(day.sun(0.5 * (spell.start_min + spell.end_min)))),
        };
        parts.push((Spell { start_min, end_min: spell.end_min }, last));
        parts
    }

    /// Returns a pane that is seen within two texels of a direction.
    fn near(&self, image: DVec3) -> Option<Arc<Pane>> {
        let (u, v) = image.any_orthonormal_pair();
        let around = |i: usize| {
            let (sin, cos) = (TAU * (i % AROUND) as f64 / AROUND as f64).sin_cos();
            (image + self.texel_rad * (1 + i / AROUND) as f64 * (cos * u + sin * v)).normalize()
        };
        let images: Vec<DVec3> = (0..2 * AROUND).map(around).collect();
        let triangle = self.observer.mirrors(&images).into_iter().flatten().next();
        triangle.and_then(|triangle| self.panes.of_triangle(triangle)).cloned()
    }
}

/// Returns the uncertainty of a spell's length, minutes: its doubtful part, or the possible but
/// unseen time around it, whichever is longer.
fn uncertain_min(mirror: &MirrorSpells, spell: Spell) -> f64 {
    let own = Spells::one(spell.start_min, spell.end_min);
    let in_doubt = spell.minutes() - mirror.seen.sure.within(&own).minutes();
    let is_around = |one: &&Spell| one.start_min <= spell.start_min && one.end_min >= spell.end_min;
    let unseen = mirror.seen.possible.iter().find(is_around).map_or(0.0, |around| {
        let within = Spells::one(around.start_min, around.end_min);
        around.minutes() - mirror.seen.seen.within(&within).minutes()
    });
    in_doubt.max(unseen).max(0.0)
}

/// All spells that were found.
pub struct SpellRecord {
    /// Names of receivers.
    names: Vec<String>,
    /// Spells as `(index of the receiver, spell)`, in the order of receivers and days.
    spells: Vec<(u32, GlareSpell)>,
    most: u64,
}

impl SpellRecord {
    /// Returns an empty record.
    pub fn new(resources: &Resources) -> Self {
        let most = resources.memory.share(Use::ReceiverList) / size_of::<(u32, GlareSpell)>() as u64;
        SpellRecord { names: Vec::new(), spells: Vec::new(), most }
    }

    /// Adds the spells of the next receiver. Fails if memory has no room for them.
    pub fn add(&mut self, name: &str, spells: Vec<GlareSpell>) -> Result<()> {
        if spells.is_empty() {
            return Ok(());
        }
        let number = self.names.len() as u32;
        self.names.push(name.to_owned());
        self.spells.extend(spells.into_iter().map(|spell| (number, spell)));
        let value = self.spells.len() as u64;
        if value > self.most {
            let what = "the number of spells of sun in mirrors (raise {memory}, or choose fewer {dates} or receivers)";
            return Err(Error::Limit { what: what.into(), value, max: self.most });
        }
        Ok(())
    }

    /// Says how many spells a table of some bytes holds, and how to get a smaller one if it is
    /// large.
    pub fn tell_size(&self, path: &Path, bytes: u64, observer: &dyn Observer) {
        let (path, spells) = (path.display(), counted(self.spells.len() as u64, "spell"));
        let text = format!("{path}: {spells}, {:.1} MB", bytes as f64 / 1e6);
        if bytes > LARGE_SPELLS {
            observer.warn(message!("{text}; .parquet is smaller, as are fewer {{dates}} or receivers"));
        } else {
            observer.note(&text);
        }
    }

    /// Writes the spells as a table, and returns its size in bytes.
    pub fn write(&self, path: &Path, plan: &DayPlan, about: &Provenance) -> Result<u64> {
        let texts = ["receiver", "date", "start", "end"].map(Column::text);
        let minutes = ["minutes", "uncertain_minutes"].map(|name| Column::number(name, 2).with_unit("min"));
        let panes = ["pane", "material"].map(Column::text);
        let facts = [
            Column::number("irradiance_w_m2", 1).with_unit("W/m2"),
            Column::number("deflection_deg", 1).with_unit("deg"),
            Column::number("sun_azimuth_deg", 2).with_unit("deg"),
            Column::number("sun_altitude_deg", 2).with_unit("deg"),
        ];
        let columns = texts.into_iter().chain(minutes).chain(panes).chain([Column::count("mirrors")]).chain(facts);
        let mut table = Table::of_rows(path, columns.collect(), self.spells.len() as u64, Some(about))?;
        for (number, spell) in &self.spells {
            let ahead_min = plan.zone.ahead_min(spell.date);
            let clock = |at: f64| Cell::Text(seconds_clock(at + ahead_min));
            let (zenith_deg, azimuth_deg) = tilt_and_azimuth(spell.sun);
            let pane = spell.pane.as_deref();
            let facts =
                [spell.strongest.irradiance_w_m2, spell.strongest.deflection_deg, azimuth_deg, 90.0 - zenith_deg];
            let texts = [self.names.get(*number as usize).map_or("", String::as_str), &plan.label(spell.date)];
            let names = [pane.map_or("", |pane| pane.name.as_str()), pane.map_or("", |pane| pane.material.as_str())];
            let cells = texts
                .into_iter()
                .map(Cell::from)
                .chain([clock(spell.spell.start_min), clock(spell.spell.end_min)])
                .chain([spell.spell.minutes(), spell.uncertain_min].map(Cell::from))
                .chain(names.map(Cell::from))
                .chain([Cell::Count(spell.mirrors as u64)])
                .chain(facts.map(Cell::from));
            table.row(cells)?;
        }
        Ok(table.finish()?.bytes)
    }

    /// Returns the calendar, which has the spells of each pane on each day, of all receivers
    /// together.
    pub fn calendar(&self, plan: &DayPlan, called: String) -> Calendar {
        let mut minutes: BTreeMap<&str, f64> = BTreeMap::new();
        let mut by_day: BTreeMap<i32, BTreeMap<&str, Vec<Spell>>> = BTreeMap::new();
        for (_, spell) in &self.spells {
            let pane = spell.pane.as_ref().map_or("", |pane| &pane.name);
            *minutes.entry(pane).or_default() += spell.spell.minutes();
            by_day.entry(spell.date.day_number()).or_default().entry(pane).or_default().push(spell.spell);
        }
        let mut order: Vec<(&str, f64)> = minutes.into_iter().collect();
        // Panes with the most minutes come first, as only the first ones have colours of their own.
        order.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(b.0)));
        let series: Vec<String> = order.iter().map(|(pane, _)| (*pane).to_owned()).collect();
        let day = |date: &Date| {
            let ahead_min = plan.zone.ahead_min(*date);
            let sun = SunDay::new(&plan.site, *date, North::default());
            let later = |spells: &Spells| -> Vec<Spell> {
                let later =
                    |one: &Spell| Spell { start_min: one.start_min + ahead_min, end_min: one.end_min + ahead_min };
                spells.iter().map(later).collect()
            };
            let mut spells = Vec::new();
            for (number, (pane, _)) in order.iter().enumerate() {
                let own = by_day.get(&date.day_number()).and_then(|panes| panes.get(pane));
                let own = own.map_or(&[][..], Vec::as_slice).iter();
                let sets: Vec<Spells> = own.map(|spell| Spells::one(spell.start_min, spell.end_min)).collect();
                let joined = Spells::covered(sets.iter().map(|set| (set, 0.0)), 0.0);
                spells.extend(later(&joined).into_iter().map(|spell| CalendarSpell { series: number, spell }));
            }
            CalendarDay { date: *date, up: later(&sun.up), spells }
        };
        let title = "Sun in mirrors by day and clock, by pane".to_owned();
        Calendar { title, called, series, days: plan.dates.iter().map(day).collect() }
    }

    /// Returns for each pane the minutes it causes, summed over receivers, and the number of
    /// receivers. Minutes that a receiver gets by several chains from one pane count once.
    fn of_panes(&self) -> BTreeMap<&str, PaneSum> {
        let mut sums: BTreeMap<&str, PaneSum> = BTreeMap::new();
        for of_receiver in self.spells.chunk_by(|a, b| a.0 == b.0) {
            let mut by_day: BTreeMap<(&str, i32), Spells> = BTreeMap::new();
            for (_, spell) in of_receiver {
                let Some(pane) = &spell.pane else { continue };
                let day = by_day.entry((&pane.name, spell.date.day_number())).or_default();
                *day = day.and(&Spells::one(spell.spell.start_min, spell.spell.end_min));
            }
            let mut minutes: BTreeMap<&str, f64> = BTreeMap::new();
            for ((pane, _), spells) in by_day {
                *minutes.entry(pane).or_default() += spells.minutes();
            }
            for (pane, minutes) in minutes {
                let sum = sums.entry(pane).or_default();
                sum.minutes += minutes;
                sum.receivers += 1;
                sum.most = sum.most.max(minutes);
            }
        }
        sums
    }
}

/// Sums of the glare from a pane.
#[derive(Default)]
struct PaneSum {
    minutes: f64,
    receivers: u32,
    /// Minutes at the receiver with most of them.
    most: f64,
}

/// Returns one label for all days.
fn label_of(plan: &DayPlan) -> String {
    let (Some(first), Some(last)) = (plan.dates.first(), plan.dates.last()) else { return String::new() };
    let lasts = last.day_number() - first.day_number() + 1;
    match plan.dates.len() {
        1 => plan.label(*first),
        count if count as i32 == lasts => format!("{}..{}", plan.label(*first), plan.label(*last)),
        count => counted(count as u64, "day"),
    }
}

/// File of panes.
pub struct PaneFile<'a> {
    pub path: &'a Path,
    pub receivers: &'a ReceiverSet<'a>,
    pub place: &'a Path,
    pub about: &'a Provenance,
}

impl PaneFile<'_> {
    /// Refuses a map that cannot be drawn, before anything is computed.
    pub fn check(&self) -> Result<()> {
        match (ResultFormat::by_ending(self.path, false)?, self.receivers.parts().first()) {
            (ResultFormat::Map(format), Some(part)) => format.check(&crs_of(part.archive), "panes"),
            _ => Ok(()),
        }
    }

    /// Writes the file.
    pub fn write(&self, record: &SpellRecord, panes: &PaneList, plan: &DayPlan, resources: &Resources) -> Result<()> {
        let columns = [
            ("glare_minutes", "sun that it throws at receivers, sum over these", Measure::Minutes),
            ("most_minutes", "sun that it throws at one receiver at most", Measure::Minutes),
            ("receivers", "receivers that it throws the sun at", Measure::Number),
        ];
        let quantity = |(array, (name, words, measure)): (usize, (&str, &str, Measure))| Quantity {
            name: name.into(),
            words: words.into(),
            source: ValueSource::Array(array),
            measure,
        };
        let quantities = columns.into_iter().enumerate().map(quantity).collect();
        let mut layout = Layout::of_quantities(BinKind::Dates, By::Pane, quantities);
        layout.facts = vec![Fact::Area, Fact::Tilt, Fact::Azimuth];
        let days = label_of(plan);
        let rows = RowMaker::new(layout, BinLabels::words(vec![days.clone()]), None);
        let drawn: Vec<Receiver> = panes.all().iter().map(|pane| pane.drawn()).collect();
        let names: Vec<String> = drawn.iter().map(|pane| pane.id.clone()).collect();
        let north = self.receivers.north();
        let extent = |pane: &Receiver| GroupGeometry::new(pane, north);
        let extents: Vec<GroupGeometry> = drawn.iter().map(extent).collect();
        let sums = record.of_panes();
        let of = |number: fn(&PaneSum) -> f64| -> Vec<f32> {
            names.iter().map(|name| sums.get(name.as_str()).map_or(0.0, |sum| number(sum) as f32)).collect()
        };
        let arrays = [of(|sum| sum.minutes), of(|sum| sum.most), of(|sum| sum.receivers.into())];
        let called = format!("{}, {days}", name_of(self.place));
        let mut writer = match ResultFormat::by_ending(self.path, false)? {
            ResultFormat::Table(_) => {
                let all = || Ok(names.clone());
                let places = Places { count: names.len() as u64, names: &all };
                ResultFile::Table(&rows, rows.table(self.path, &places, self.about)?)
            }
            ResultFormat::Map(format) => {
                let (scene, receivers) = (self.receivers, self.receivers);
                let start = MapStart {
                    path: self.path,
                    format,
                    share: 1,
                    rows: &rows,
                    called: &called,
                    about: self.about,
                    scene,
                    receivers,
                };
                let shapes = PlaceShapes::Receivers(Box::new(drawn.into_iter().map(Ok)));
                ResultFile::Map(Box::new(start.with_shapes(shapes, resources)?))
            }
        };
        writer.write_tile(&names, &PlaceValues::of_arrays(names.len(), 1, &arrays), &extents)?;
        if let Some(stats) = writer.finish()? {
            say_large(self.path, &stats, resources.observer);
        }
        Ok(())
    }
}

/// Writes a calendar.
pub fn write_calendar(calendar: &Calendar, path: &Path, about: &Provenance) -> Result<()> {
    use std::io::Write;
    let mut sink = Sink::file(path)?;
    sink.write_all(calendar.drawing().svg_file(about).as_bytes()).map_err(Error::io(path, "write to"))?;
    sink.finish().map(drop)
}

/// Formats a reading of the clock to the second.
fn seconds_clock(minutes: f64) -> String {
    let seconds = (60.0 * minutes).round() as i64;
    format!(
        "{:02}:{:02}:{:02}",
        seconds.div_euclid(3600),
        seconds.div_euclid(60).rem_euclid(60),
        seconds.rem_euclid(60)
    )
}
