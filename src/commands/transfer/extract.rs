//! `heliotile extract`: the archive of some receivers of another one, with the cells that they need and no others.

use super::output::{Output, Written};
use super::reach::{Keys, Marks};
use super::rows::{Rows, Traced, cells};
use super::selection::Selection;
use crate::cli::ExtractArgs;
use crate::commands::{Outcome, counted, guard_archive, guard_output, say, temporary_folder};
use heliotile_core::archive::accuracy::Accuracy;
use heliotile_core::archive::{Archive, Manifest, format};
use heliotile_core::error::Result;
use heliotile_core::layers::response::Response;
use heliotile_core::opened::{CellSource, OpenSite};

/// `heliotile extract`.
pub fn run(args: &ExtractArgs) -> Result<Outcome> {
    let extracted = extract(args)?;
    let Written { receivers, tiles, cells, summary } = &extracted.written;
    say(&format!(
        "{}: {receivers} of {} receivers in {}, {} of {} probes, {} of {} bounce cells, {:.2} MB\n  root {}\n",
        args.output.display(),
        extracted.of.receivers,
        counted(u64::from(*tiles), "tile"),
        cells.probes,
        extracted.of.probes,
        cells.bounce_cells,
        extracted.of.bounce_cells,
        summary.bytes as f64 / 1e6,
        format::hex(&summary.root),
    ))?;
    Ok(Outcome::Fine)
}

/// What an extract did.
#[derive(Clone, Debug)]
pub struct Extracted {
    pub written: Written,
    pub of: Whole,
}

/// How much the archive holds that was extracted from.
#[derive(Clone, Copy, Debug)]
pub struct Whole {
    pub receivers: u64,
    pub probes: u64,
    pub bounce_cells: u64,
}

/// Writes the archive of some receivers: the bytes of a build of them alone.
pub fn extract(args: &ExtractArgs) -> Result<Extracted> {
    let selection = Selection::of(args);
    let mut inputs = vec![args.archive.as_path()];
    inputs.extend(args.receivers.as_deref());
    guard_output(&args.output, &inputs)?;
    guard_archive(&args.output)?;
    let archive = Archive::open_with(&args.archive, args.io)?;
    let (folder, budget) = (temporary_folder(&args.output), args.memory.0 as usize / 4);
    let site = OpenSite::of(&archive)?;
    let kept = selection.resolve(&site, folder, budget)?;
    let keys = || Keys::new(folder, budget);

    let mut output = Output::create(&args.output, &[&archive])?;
    let mut hits = keys();
    output.tiles(Rows::<Traced>::chosen(&site, &archive, &kept).map(|row| {
        let row = row?;
        let mut seen: Vec<_> = row.layers.reached().collect();
        seen.sort_unstable();
        seen.dedup();
        seen.into_iter().try_for_each(|key| hits.push(key))?;
        Ok(row)
    }))?;
    let (of_probes, of_bounces) = (CellSource::probes(&site)?, CellSource::bounces(&site)?);
    let manifest = archive.manifest();
    let (mut probes, mut bounces, mut seen) = (Marks::default(), Marks::default(), keys());
    probes.add(&of_probes, ("hit", hits), |key| seen.push(key))?;
    bounces.add_reachable(&of_bounces, ("probes", seen), keys)?;
    let settings = &manifest.settings;
    output.probes(settings.probe_hits, cells(&of_probes, |chunk, row| probes.contains(chunk, row)))?;
    output.bounces(settings.bounce_hits, cells(&of_bounces, |chunk, row| bounces.contains(chunk, row)))?;
    output.materials(&archive)?;
    output.responses(Rows::<Response>::chosen(&site, &archive, &kept))?;
    output.copy_unknown(&[&archive])?;
    let accuracy = manifest.accuracy.clone().map(Accuracy::without_tiles);
    let written = output.finish(Manifest { accuracy, ..manifest.clone() })?;
    let of = Whole {
        receivers: manifest.receivers.count,
        probes: manifest.counts.probes,
        bounce_cells: manifest.counts.bounce_cells,
    };
    Ok(Extracted { written, of })
}
