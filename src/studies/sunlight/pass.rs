//! From answers to files. In: a request, the receivers of open archives. Out: tables, maps and
//! pictures, and the counts of the results.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::columns::DayColumns;
use super::former::{FormerValues, NamesAfter};
use super::glare::{GlareChoice, PaneFile, SpellRecord, write_calendar};
use super::groups::{GroupAnswers, check_middles};
use super::panes::PaneList;
use super::places::{KeptSpells, PlaceAnswer, PlaceQuestions, RowSubject};
use super::request::{RuleCount, SunlightDone, SunlightRequest, SunlightSite};
use super::trees::TreeShade;
use heliotile_core::archive::format;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::hemisphere::HEMISPHERE_SR;
use heliotile_core::memory::Use;
use heliotile_core::opened::OpenSite;
use heliotile_core::text::{counted, message};
use heliotile_core::weather::time::sun::Location;
use heliotile_results::archives::Archives;
use heliotile_results::doubts::check_one_site;
use heliotile_results::files::{OutputRequest, RowFiles, RowsAbout, groups_of, name_of};
use heliotile_results::outputs::groups::{GroupGeometry, Groups};
use heliotile_results::outputs::periods::Every;
use heliotile_results::outputs::provenance::Provenance;
use heliotile_results::outputs::quantities::{PlaceValues, Verdict};
use heliotile_results::outputs::row_maker::RowMaker;
use heliotile_results::outputs::tables::layout::By;
use heliotile_results::receivers::ReceiverSet;
use heliotile_results::resources::Resources;

/// Number of places whose rows are written together.
const PLACES_AT_ONCE: usize = 256;

/// Largest movement of the sun in a minute, degrees.
const DEGREES_A_MINUTE: f64 = 0.25;

/// Kind of the surfaces of windows.
const WINDOW: &str = "window";

/// Returns the place for which the sun is computed if the archive has none.
fn place_of_weather(site: &Location) -> String {
    format!("latitude {}, longitude {}, of the weather file", site.latitude_deg, site.longitude_deg)
}

impl SunlightRequest {
    /// Writes the files; `before` is the site before a change, if one is requested.
    pub fn write(
        &self,
        files: &OutputRequest,
        site: &SunlightSite,
        before: Option<&SunlightSite>,
        about: Provenance,
        resources: &Resources,
    ) -> Result<SunlightDone> {
        if let Some(before) = before {
            check_one_site(before.archives.first(), site.archives.first())?;
        }
        let (plan, asked) = self.plan(site.archives, resources)?;
        check_middles(&asked, files.by)?;
        self.check_mirrors(&asked, site.archives, before, resources)?;
        self.tell(site.archives, resources);
        let windows = windows_of(site, files.by)?;
        let receivers = windows.as_ref().unwrap_or(site.receivers);
        let groups = groups_of(receivers, files.by, site.place)?;
        let columns = DayColumns::new(&asked, &plan, groups.is_some(), before.is_some(), self.glare.is_some());
        let mut layout = columns.layout(files.by);
        if let Some(groups) = &groups {
            layout.facts = groups.facts(files.by, false);
        }
        let rows = RowMaker::new(layout, columns.bin_labels(), None);
        let about = site.archives.told_in(about, site.place);
        let about = match before {
            Some(before) => about.with("root_before", before.archives.root()),
            None => about,
        };
        let about = about.with("utc_offset", plan.zone.standard(self.year)).with("clock", plan.zone);
        // An archive that has a place states it.
        let about = match site.archives.manifest().place {
            Some(_) => about,
            None => about.with("place", place_of_weather(&plan.site)),
        };
        let about = match &asked {
            RowSubject::Rules(rules) => {
                about.with("rules", Value::from_iter(rules.iter().map(|one| one.rule.stated())))
            }
            RowSubject::Dates(_) => about,
        };
        let told = RowsAbout { called: self.called(&columns, site.place), about, place: site.place, scene: None };
        let calendars: Vec<&Path> = self.calendars(files).collect();
        let drawn = files.plots.iter().map(PathBuf::as_path).filter(|plot| !calendars.contains(plot));
        let maps = files.maps(drawn)?;
        let mut row_files = RowFiles::new(&rows, groups.clone());
        if files.wants_table()? {
            row_files = row_files.with_table(&files.output, receivers, &told.about);
        }
        let mut row_files = row_files.with_maps(&maps, receivers, &told, resources)?;
        let glare = self.glare.as_ref();
        let panes = PaneList::default();
        let wants_spells = !calendars.is_empty() || glare.is_some_and(|glare| glare.files().next().is_some());
        let mut record = wants_spells.then(|| SpellRecord::new(resources));
        let pane_file = glare.and_then(|glare| glare.panes.as_deref()).map(|path| PaneFile {
            path,
            receivers,
            place: site.place,
            about: &told.about,
        });
        pane_file.iter().try_for_each(PaneFile::check)?;
        let questions = PlaceQuestions {
            receivers,
            plan: &plan,
            glare: glare.map(GlareChoice::angles),
            panes: wants_spells.then_some(&panes),
            asked: &asked,
            least_altitude_deg: self.least_altitude_deg,
            trees: self.trees,
            exact: self.exact,
            kept: if groups.is_some() { KeptSpells::OfParts } else { KeptSpells::None },
        };
        let former = match before {
            Some(before) => self.former(files.by, before, &questions, resources)?,
            None => FormerValues::default(),
        };
        row_files.start()?;
        let mut rows = RowBatch::new(&columns, &asked, groups.as_ref(), before.is_some());
        let mut keep = |answer: &mut PlaceAnswer| match &mut record {
            Some(record) => record.add(&answer.name, std::mem::take(&mut answer.spells)),
            None => Ok(()),
        };
        self.each(&questions, groups.as_ref(), site.folder, resources, &mut keep, |mut answer| {
            former.join(&mut answer);
            rows.add(answer, &mut row_files)
        })?;
        rows.flush(&mut row_files)?;
        let RowBatch { counts: rules, places, .. } = rows;
        row_files.finish(resources.observer)?;
        if let Some((glare, record)) = glare.zip(record.as_ref()) {
            if let Some(path) = &glare.spells {
                let bytes = record.write(path, &plan, &told.about)?;
                record.tell_size(path, bytes, resources.observer);
            }
            if let Some(file) = &pane_file {
                file.write(record, &panes, &plan, resources)?;
            }
            let called = format!("{}, {}", name_of(site.place), counted(receivers.count(), "receiver"));
            let calendar = (!calendars.is_empty()).then(|| record.calendar(&plan, called));
            for (path, calendar) in calendars.iter().flat_map(|path| calendar.iter().map(move |one| (path, one))) {
                write_calendar(calendar, path, &told.about)?;
            }
        }
        Ok(SunlightDone { places, days: plan.dates.len() as u64, rules })
    }

    /// Hands the answers of receivers, or of their groups, to `take`; `keep` gets those of
    /// receivers first.
    fn each(
        &self,
        questions: &PlaceQuestions,
        groups: Option<&Groups>,
        folder: &Path,
        resources: &Resources,
        keep: &mut dyn FnMut(&mut PlaceAnswer) -> Result<()>,
        mut take: impl FnMut(PlaceAnswer) -> Result<bool>,
    ) -> Result<()> {
        let Some(groups) = groups else {
            return questions.each(resources, |mut answer| {
                keep(&mut answer)?;
                take(answer)
            });
        };
        let mut answers = GroupAnswers::new(groups, folder, resources.memory.length(Use::ComparedValues));
        questions.each(resources, |mut answer| {
            keep(&mut answer)?;
            answers.push(&answer).map(|()| true)
        })?;
        answers.each(questions.asked, self.lit_share, take)
    }

    /// Returns the values of the site before, by the names of places after.
    fn former(
        &self,
        by: By,
        before: &SunlightSite,
        of_after: &PlaceQuestions,
        resources: &Resources,
    ) -> Result<FormerValues> {
        self.tell(before.archives, resources);
        let windows = windows_of(before, by)?;
        let receivers = windows.as_ref().unwrap_or(before.receivers);
        let site = SunlightSite { receivers, ..*before };
        let groups = groups_of(receivers, by, before.place)?;
        let names = match &groups {
            Some(_) => NamesAfter::Same,
            None => NamesAfter::new(&site, of_after.receivers, resources)?,
        };
        let places = groups.as_ref().map_or(receivers.count(), |groups| groups.names().len() as u64);
        let mut former = FormerValues::with_room(places, of_after.items() as u64, resources)?;
        let questions = PlaceQuestions { receivers, panes: None, ..*of_after };
        self.each(&questions, groups.as_ref(), before.folder, resources, &mut |_| Ok(()), |answer| {
            former.add(&answer, &names);
            Ok(true)
        })?;
        Ok(former)
    }

    /// Returns a description of the results in words, for pictures.
    fn called(&self, columns: &DayColumns, place: &Path) -> String {
        let first = columns.bin_labels().text.into_iter().next().unwrap_or_default();
        match self.rules.is_empty() {
            true if self.every == Every::Day => format!("{} on {first}", name_of(place)),
            true => format!("{}, {first}", name_of(place)),
            false => format!("{}: {first}", name_of(place)),
        }
    }

    /// Refuses a request for glare if the scene has no mirrors, now or before. If only rules ask
    /// for it, they are met, and a note says so.
    fn check_mirrors(
        &self,
        asked: &RowSubject,
        archives: Archives,
        before: Option<&SunlightSite>,
        resources: &Resources,
    ) -> Result<()> {
        let is_asked = match asked {
            RowSubject::Dates(_) => false,
            RowSubject::Rules(rules) => rules.iter().any(|planned| planned.rule.measure.is_of_mirrors()),
        };
        if !is_asked && self.glare.is_none() {
            return Ok(());
        }
        for archive in archives.iter().chain(before.iter().flat_map(|before| before.archives.iter())) {
            if !OpenSite::open(archive)?.orientations().is_empty() {
                return Ok(());
            }
        }
        let path = archives.first().path();
        let what = "has no mirror and no glass, so no sun is reflected onto its receivers";
        if self.glare.is_none() {
            resources.observer.note(format!("{} {what}: rules about sun in mirrors are met", path.display()));
            return Ok(());
        }
        let hint =
            "give materials of facades `glass = true` or a `specular` share in {materials}, and build it with mirrors";
        Err(Error::input(path, None, what, hint).because(Problem::Lacks("mirrors")))
    }

    /// Warns of properties of archives that a user should know.
    pub(crate) fn tell(&self, archives: Archives, resources: &Resources) {
        let observer = resources.observer;
        let settings = &archives.manifest().settings;
        let texel_deg = HEMISPHERE_SR.sqrt().to_degrees() / f64::from(settings.sky_fine);
        let minutes = texel_deg / DEGREES_A_MINUTE;
        if minutes > 1.0 && !self.exact {
            observer.warn(message!(
                "{}: a texel of its sky is {texel_deg:.2} degrees wide, and the sun takes {minutes:.1} minutes to pass it: times are no \
                 more exact than that (build it with {{quality}} standard, or give {{exact}})",
                archives.first().path().display()
            ));
        }
        let has_leaves = archives.iter().any(|archive| !archive.entries_of(format::CANOPY).is_empty());
        if has_leaves && self.glare.is_none() && self.trees == TreeShade::Ignore {
            observer.note("leaves and screens do not hide the sun here; {trees} opaque and half do");
        }
        if !has_leaves && self.trees != TreeShade::Ignore {
            observer.warn("the archive has no leaves and no screens: {trees} changes nothing");
        }
    }
}

/// Returns the receivers of windows, if rows are about windows.
fn windows_of<'a>(site: &SunlightSite<'a>, by: By) -> Result<Option<ReceiverSet<'a>>> {
    if by != By::Window {
        return Ok(None);
    }
    let is_window = site.receivers.receivers().map(|receiver| Ok(receiver?.part.kind == WINDOW));
    let is_window: Vec<bool> = is_window.collect::<Result<_>>()?;
    if !is_window.contains(&true) {
        let hint = "give {by} surface, or build the archive from a model with windows";
        return Err(Error::input(site.place, None, "has no receiver on a window", hint));
    }
    Ok(Some(site.receivers.some(&is_window)))
}

/// Rows of some places, until they are written.
struct RowBatch<'a> {
    columns: &'a DayColumns<'a>,
    extents: Option<&'a [GroupGeometry]>,
    names: Vec<String>,
    /// Values of the rows, `[number][place][label]`.
    arrays: Vec<Vec<f32>>,
    /// Number of places that were added.
    places: u64,
    counts: Vec<RuleCount>,
    /// True if the site before a change is known.
    has_before: bool,
}

impl<'a> RowBatch<'a> {
    fn new(columns: &'a DayColumns<'a>, asked: &RowSubject, groups: Option<&'a Groups>, has_before: bool) -> Self {
        let count = |name: &str| RuleCount { rule: name.to_owned(), ..RuleCount::default() };
        let counts = match asked {
            RowSubject::Dates(_) => Vec::new(),
            RowSubject::Rules(rules) => rules.iter().map(|planned| count(&planned.rule.name)).collect(),
        };
        let arrays = vec![Vec::new(); columns.count()];
        RowBatch {
            columns,
            extents: groups.map(Groups::extents),
            names: Vec::new(),
            arrays,
            places: 0,
            counts,
            has_before,
        }
    }

    /// Adds a place; returns false if the reader of the output has gone away.
    fn add(&mut self, answer: PlaceAnswer, files: &mut RowFiles) -> Result<bool> {
        for (array, values) in self.arrays.iter_mut().zip(self.columns.values(&answer.items)) {
            array.extend(values);
        }
        if let RowSubject::Rules(rules) = self.columns.asked {
            for ((count, planned), item) in self.counts.iter_mut().zip(rules).zip(&answer.items) {
                let before = item.as_ref().and_then(|item| item.before.as_ref());
                let verdict = item.as_ref().map(|item| item.value.judged(&planned.rule, before));
                let was_broken = before.is_none_or(|before| before.verdict(planned.rule.threshold) == Verdict::Broken);
                count.newly_broken += u64::from(verdict == Some(Verdict::Broken) && !was_broken);
                count.only_after += u64::from(self.has_before && verdict.is_some() && before.is_none());
                *match verdict {
                    Some(Verdict::Met) => &mut count.met,
                    Some(Verdict::Broken) => &mut count.broken,
                    Some(Verdict::Close) => &mut count.close,
                    None => &mut count.not_asked,
                } += 1;
            }
        }
        self.places += 1;
        self.names.push(answer.name);
        if self.names.len() == PLACES_AT_ONCE {
            self.flush(files)?;
        }
        Ok(!files.is_closed())
    }

    fn flush(&mut self, files: &mut RowFiles) -> Result<()> {
        let (names, arrays) = (std::mem::take(&mut self.names), self.arrays.clone());
        self.arrays.iter_mut().for_each(Vec::clear);
        if names.is_empty() {
            return Ok(());
        }
        let first = self.places as usize - names.len();
        let extents = self.extents.and_then(|all| all.get(first..first + names.len())).unwrap_or_default();
        let labels = self.columns.bin_labels().len();
        files.write(&names, &PlaceValues::of_arrays(names.len(), labels, &arrays), extents)
    }
}
