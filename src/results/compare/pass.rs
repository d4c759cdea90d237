//! One pass over the receivers before, joined with the stored values of the archives after. In: a
//! stream before, paths of archives after. Out: files and a summary.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::CompareRequest;
use super::summary::{CompareSummary, unmatched_table};
use super::variant::{BeforePlaces, Variant, VariantReplay};
use crate::archives::{Archives, Sources};
use crate::doubts::check_one_site;
use crate::files::{OutputRequest, Question, RowsAbout, name_of, write_rows};
use crate::outputs::periods::Every;
use crate::outputs::provenance::Provenance;
use crate::outputs::tables::layout::{BinKind, By, Layout};
use crate::receivers::{ReceiverChoice, ReceiverSet};
use crate::request::LightRequest;
use crate::series::{Coarsening, Series};
use crate::stream::{Tile, TileSink, TileStream};
use heliotile_archives::transfer::differences;
use heliotile_core::error::Result;
use heliotile_core::memory::Use;
use heliotile_core::observer::Observer;
use heliotile_core::replay::components::{ComponentList, ComponentSet};
use heliotile_core::replay::values::TileValues;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::listed;

/// Site before a change, ready to be replayed.
pub struct BeforeSide<'a> {
    /// Chosen receivers before, under suns and skies.
    pub stream: &'a TileStream<'a>,
    /// Archives before.
    pub archives: Archives<'a>,
    /// Path of the archive or of the atlas.
    pub place: &'a Path,
    /// Choice of the receivers before.
    pub choice: &'a ReceiverChoice,
    /// Folder for temporary files that do not fit into memory.
    pub folder: &'a Path,
}

impl CompareRequest {
    /// Writes the files and returns the summary; `open` opens the archives at a path.
    pub fn write(
        &self,
        files: &OutputRequest,
        before: &BeforeSide,
        open: &dyn Fn(&Path) -> Result<Sources>,
    ) -> Result<CompareSummary> {
        let (has_details, asked) = (self.has_details(files), self.columns());
        let columns = if has_details { asked.clone() } else { ComponentList::new(asked.main()) };
        let patches = Some(before.stream.light.patches_of(before.archives.first()));
        let light = LightRequest { patches, ..before.stream.light.only(columns.clone()) };
        let totals = before.stream.series.by(Every::Total);
        let series = if has_details { before.stream.series } else { &totals };
        let stream = TileStream { light: &light, series, ..*before.stream };

        let mut places = BeforePlaces::new(stream.receivers, stream.resources.memory)?;
        let replay = VariantReplay {
            before: stream,
            components: &columns,
            choice: before.choice,
            folder: before.folder,
            memory_bytes: stream.resources.memory.length(Use::ComparedValues) / self.after.len().max(1),
        };
        let (mut variants, mut opened) = (Vec::new(), Vec::new());
        // Archives after are replayed first: receivers before without a match need no replay then.
        let names = self.names(before.place);
        for (place, name) in self.after.iter().zip(&names[1..]) {
            let sources = open(place)?;
            tell(before.archives, sources.borrowed(), [&names[0], name], stream.resources.observer)?;
            variants.push(replay.run(name.clone(), place, sources.borrowed(), &mut places)?);
            opened.push(sources);
        }
        let is_matched = places.is_matched;
        let receivers = stream.receivers.some(&is_matched);
        let stream = TileStream { receivers: &receivers, ..stream };
        let about = self.about(&stream, before, &names[1..], &variants);
        let mut pass = Pass {
            receivers: Box::new(receivers.receivers()),
            rows: Box::new((0..).zip(&is_matched).filter_map(|(row, is_matched)| is_matched.then_some(row))),
            components: &columns,
            coarsening: series.coarsening(&totals),
            folder: before.folder,
            variants: &mut variants,
        };
        if has_details {
            // Maps show the scene after the change.
            let scene = opened.first().map(|sources| ReceiverSet::all_of(sources.borrowed().first())).transpose()?;
            let called = format!("{} to {} under {}", names[0], names[1..].join(", "), series.called);
            let told = RowsAbout { called, about: about.clone(), place: before.place, scene: scene.as_ref() };
            write_rows(files, Question::Change, &stream, &told, |details| {
                stream.feed(&mut PassSink { pass: &mut pass, details: Some(details) })
            })?;
        } else {
            stream.feed(&mut PassSink { pass: &mut pass, details: None })?;
        }
        drop(pass);
        let layout = Layout::of_changes(sums_of(series), By::Receiver, &ComponentList::new(asked.main()));
        let summary = CompareSummary::new(names[0].clone(), &series.called, &layout, asked.main(), &variants);
        if let Some(path) = &self.unmatched {
            unmatched_table(&variants).write(path, &about)?;
        }
        if let Some(path) = &self.summary {
            summary.table().write(path, &about)?;
        }
        Ok(summary)
    }

    /// Returns the provenance of the files.
    fn about(&self, stream: &TileStream, before: &BeforeSide, after: &[String], variants: &[Variant]) -> Provenance {
        let of_each = |text: fn(&Variant) -> &str| variants.iter().map(text).collect::<Vec<_>>().join(", ");
        let about = stream.about(before.archives, before.place);
        about.with("after", after.join(", ")).with("after_root", of_each(|variant| &variant.root))
    }

    /// Returns names that tell the archives apart, that before first: file names, or paths if file
    /// names are not unique.
    fn names(&self, before: &Path) -> Vec<String> {
        let places = || [before].into_iter().chain(self.after.iter().map(PathBuf::as_path));
        let names: Vec<String> = places().map(name_of).collect();
        let unique = names.iter().collect::<BTreeSet<_>>().len();
        if unique == names.len() { names } else { places().map(|place| place.display().to_string()).collect() }
    }
}

/// Returns the kind of bins of the summary: sums over all of the time, or means under conditions.
fn sums_of(series: &Series) -> BinKind {
    if series.kind == BinKind::Conditions { BinKind::Conditions } else { BinKind::Sums }
}

/// Receivers before, in the order of their tiles, and the stored values after.
struct Pass<'p> {
    /// Receivers of the tiles; `rows` are their rows before.
    receivers: Box<dyn Iterator<Item = Result<Receiver>> + 'p>,
    rows: Box<dyn Iterator<Item = u32> + 'p>,
    components: &'p ComponentList,
    /// Map of all bins to one; `None` if there is only one, and under conditions.
    coarsening: Option<Coarsening>,
    folder: &'p Path,
    variants: &'p mut [Variant],
}

/// Sink of the tiles before, which adds the values after.
struct PassSink<'s, 'p> {
    pass: &'s mut Pass<'p>,
    /// Sink of the change by the only variant.
    details: Option<&'s mut dyn TileSink>,
}

impl Pass<'_> {
    /// Returns one number a receiver: the sum of the main component over the whole time, or its
    /// mean over conditions.
    fn sums(&self, values: &TileValues) -> Vec<f64> {
        let main = self.components.main();
        let coarse = self.coarsening.as_ref().map(|to| to.of(values, ComponentSet::new(&[main])));
        let values = coarse.as_ref().unwrap_or(values);
        let count = values.bins().max(1) as f64;
        let sum = |row: usize| values.row(main, row).iter().map(|value| f64::from(*value)).sum::<f64>() / count;
        (0..values.receivers()).map(sum).collect()
    }
}

impl TileSink for PassSink<'_, '_> {
    fn components(&self) -> ComponentSet {
        self.pass.components.set()
    }

    fn start(&mut self) -> Result<()> {
        self.details.as_mut().map_or(Ok(()), |details| details.start())
    }

    fn take(&mut self, tile: &Tile) -> Result<bool> {
        let (pass, count, bins) = (&mut *self.pass, tile.ids.len(), tile.values.bins());
        let receivers: Vec<Receiver> = pass.receivers.by_ref().take(count).collect::<Result<_>>()?;
        let rows: Vec<u32> = pass.rows.by_ref().take(count).collect();
        let before = pass.sums(tile.values);
        let mut wants_more = true;
        for number in 0..pass.variants.len() {
            let (is_there, values) = pass.variants[number].values(&rows, pass.components, bins, pass.folder)?;
            let after = pass.sums(&values);
            let tally = &mut pass.variants[number].tally;
            for (row, receiver) in receivers.iter().enumerate().filter(|(row, _)| is_there[*row]) {
                tally.add(receiver, [before[row], after[row]]);
            }
            if let Some(details) = &mut self.details {
                wants_more = details.take(&Tile { ids: tile.ids, values: tile.values, after: Some(&values) })?;
            }
        }
        Ok(wants_more)
    }
}

/// Largest number of differing settings that a warning names.
const NAMED: usize = 6;

/// Refuses archives of another place than those before. Warns of differences other than the scene
/// that may change the light.
fn tell(before: Archives, after: Archives, names: [&String; 2], observer: &dyn Observer) -> Result<()> {
    check_one_site(before.first(), after.first())?;
    if before.iter().count() == after.iter().count()
        && before.iter().zip(after.iter()).all(|(a, b)| a.root() == b.root())
    {
        observer.note(format!("{} and {}: the archives are equal", names[0], names[1]));
        return Ok(());
    }
    let found = differences(before.first(), after.first())?;
    let settings = found.iter().filter(|one| one.item.starts_with("settings."));
    let named: Vec<String> = settings
        .map(|one| {
            let item = one.item.trim_start_matches("settings.");
            format!("{item} {} and {}", one.values[0], one.values[1])
        })
        .collect();
    if !named.is_empty() {
        observer.warn(format!(
            "{} and {} were built with different settings ({}): changes include the effect of the settings",
            names[0],
            names[1],
            listed(named.iter().take(NAMED), named.len())
        ));
    }
    Ok(())
}
