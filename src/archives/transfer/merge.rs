//! Union of two archives. In: two archives of one scene. Out: one archive with the receivers and
//! cells of both.

use std::path::Path;

use crate::Workspace;
use crate::transfer::compare::{differences, objects};
use crate::transfer::digests::{AllLayers, Digests, cell_name, same_cell};
use crate::transfer::output::{ArchiveAssembly, Assembled, unknown};
use crate::transfer::rows::{ArchiveReceivers, LayeredReceiver, Layers, Shown, all_cells};
use crate::transfer::union::Conflicts;
use crate::transfer::union::{Side, union};
use heliotile_core::archive::accuracy::Accuracy;
use heliotile_core::archive::{Archive, Manifest, format};
use heliotile_core::error::{Error, Result};
use heliotile_core::layers::cells::Cell;
use heliotile_core::layers::response::Response;
use heliotile_core::memory::Use;
use heliotile_core::observer::Observer;
use heliotile_core::opened::{CellSource, OpenSite};
use heliotile_files::spill::Sorter;

/// Items that may differ between archives that fit: each build counts, estimates or leaves them out
/// for itself.
const MAY_DIFFER: [&str; 4] = ["scene.degenerate_dropped", "accuracy", "negligible", "shown"];

/// Report of a merge.
#[derive(Clone, Debug)]
pub struct Merged {
    /// Content of the union.
    pub written: Assembled,
    /// Number of receivers of each archive.
    pub of_each: [u64; 2],
    /// Number of receivers that both archives hold.
    pub shared: u64,
}

/// Writes the union of two archives. Archives of parts of a site give the same bytes as the build
/// of the whole site.
pub fn merge([a, b]: [&Archive; 2], path: &Path, workspace: &Workspace, observer: &dyn Observer) -> Result<Merged> {
    let (of_a, of_b) = (OpenSite::open(a)?, OpenSite::open(b)?);
    check_fit(a, b)?;
    let mut conflicts = Conflicts::default();
    unknown_conflicts(a, b, &mut conflicts);
    let mut output = ArchiveAssembly::create(path, &[a, b], observer)?;
    let ids = Sorter::new(&workspace.folder, workspace.memory.length(Use::ReceiverIds));
    let shared = merge_receivers(&of_a, &of_b, ids, &mut output, &mut conflicts)?;

    let settings = &a.manifest().settings;
    let (from_a, from_b) = (CellSource::probes(&of_a)?, CellSource::probes(&of_b)?);
    output.probes(settings, merge_cells("probe", &from_a, &from_b, &mut conflicts))?;
    let (from_a, from_b) = (CellSource::bounces(&of_a)?, CellSource::bounces(&of_b)?);
    output.bounces(settings, merge_cells("bounce cell", &from_a, &from_b, &mut conflicts))?;
    // Refused only now, so that the message counts all conflicts.
    conflicts.check(a.path(), b.path())?;
    output.materials(a)?;
    output.scene(&[a, b])?;
    // Blocks are written kind by kind, as by a build, so receivers are read again for each kind.
    output.responses(both::<Response>(&of_a, &of_b).map(|side| side.map(Side::first)))?;
    output.overview(&[a, b], both::<Shown>(&of_a, &of_b).map(|side| side.map(Side::first)))?;
    output.name_index(workspace, both::<()>(&of_a, &of_b).map(|side| side.map(Side::first)))?;
    output.copy_unknown(&[a, b])?;
    let written = output.finish(stated(a.manifest(), b.manifest()))?;
    Ok(Merged { written, of_each: [a, b].map(|archive| archive.manifest().receivers.count), shared })
}

/// Refuses archives of different scenes or settings.
fn check_fit(a: &Archive, b: &Archive) -> Result<()> {
    let of_the_site = |item: &str| !MAY_DIFFER.iter().any(|may| item.starts_with(may));
    let found: Vec<String> = differences(a, b)?
        .into_iter()
        .filter(|difference| of_the_site(&difference.item))
        .map(|d| format!("{} is {} in that archive and {} in this one", d.item, d.values[0], d.values[1]))
        .chain(renamed(a, b).then(|| "objects have other names".to_owned()))
        .collect();
    if found.is_empty() {
        return Ok(());
    }
    let what = format!("cannot be merged with {}: {}", a.path().display(), found.join("; "));
    Err(Error::input(
        b.path(),
        None,
        what,
        "build both from one scene, with one materials file, one place and equal settings",
    ))
}

/// Returns true if both archives hold their scene, with different names of objects.
fn renamed(a: &Archive, b: &Archive) -> bool {
    matches!((objects(a), objects(b)), (Some(a), Some(b)) if a != b)
}

fn both<'a, L: Layers + 'a>(
    a: &OpenSite<'a>,
    b: &OpenSite<'a>,
) -> impl Iterator<Item = Result<Side<LayeredReceiver<L>>>> + use<'a, L> {
    union(ArchiveReceivers::<L>::new(a), ArchiveReceivers::<L>::new(b), LayeredReceiver::order)
}

/// Writes the tiles of both archives' receivers. Returns the number of receivers that both hold.
fn merge_receivers(
    a: &OpenSite,
    b: &OpenSite,
    mut ids: Sorter,
    output: &mut ArchiveAssembly,
    conflicts: &mut Conflicts,
) -> Result<u64> {
    let mut shared = 0;
    output.tiles(both::<AllLayers>(a, b).map(|side| {
        let side = side?;
        for LayeredReceiver { receiver, .. } in side.items() {
            let place = [receiver.position.to_array(), receiver.normal.to_array()].concat();
            ids.push(receiver.id.as_bytes(), &place.into_iter().flat_map(f64::to_le_bytes).collect::<Vec<u8>>())?;
        }
        if let Some((a, b)) = side.both() {
            shared += 1;
            let parts = Digests::new(a).differences(&Digests::new(b));
            if !parts.is_empty() {
                conflicts.add(|| format!("receiver {} ({})", a.receiver.id, parts.join(", ")));
            }
        }
        Ok(side.first().map(|layers| layers.0.0))
    }))?;
    id_conflicts(ids, conflicts)?;
    Ok(shared)
}

/// Finds names of receivers that are at different places.
fn id_conflicts(ids: Sorter, conflicts: &mut Conflicts) -> Result<()> {
    let mut last: Option<(Vec<u8>, Vec<u8>)> = None;
    for record in ids.finish()? {
        let (id, place) = record?;
        match &last {
            Some((same, first)) if *same == id => {
                if *first != place {
                    let name = || format!("receiver {} (at {}", String::from_utf8_lossy(&id), place_name(first));
                    conflicts.add(|| format!("{} and at {})", name(), place_name(&place)));
                }
            }
            _ => last = Some((id, place)),
        }
    }
    Ok(())
}

/// Formats position and normal for people.
fn place_name(place: &[u8]) -> String {
    let numbers: Vec<String> = place.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b).to_string()).collect();
    let (position, normal) = numbers.split_at(numbers.len().min(3));
    format!("{} facing {}", position.join(" "), normal.join(" "))
}

fn merge_cells<'a>(
    what: &'static str,
    a: &'a CellSource,
    b: &'a CellSource,
    conflicts: &'a mut Conflicts,
) -> impl Iterator<Item = Result<Cell>> + 'a {
    union(all_cells(a), all_cells(b), |a: &Cell, b: &Cell| a.key.cmp(&b.key)).map(move |side| {
        let side = side?;
        if side.both().is_some_and(|(a, b)| !same_cell(a, b)) {
            side.items().take(1).for_each(|cell| conflicts.add(|| format!("{what} {}", cell_name(&cell.key))));
        }
        Ok(side.first())
    })
}

/// Finds blocks of unknown kinds that differ; only equal ones can be kept.
fn unknown_conflicts(a: &Archive, b: &Archive, conflicts: &mut Conflicts) {
    for entry in unknown(a) {
        let others = b.entries_of(entry.kind);
        let same = others.binary_search_by_key(&entry.tile, |other| other.tile).ok().and_then(|row| others.get(row));
        let content = |entry: &format::Entry| (entry.schema, entry.items, entry.content);
        if same.is_some_and(|other| content(other) != content(entry)) {
            conflicts.add(|| format!("block {}", entry.name()));
        }
    }
}

/// Returns the statements of the union's manifest. Items that may differ do not depend on which
/// archive comes first.
fn stated(a: &Manifest, b: &Manifest) -> Manifest {
    let mut stated = a.clone();
    stated.scene.degenerate_dropped = a.scene.degenerate_dropped.max(b.scene.degenerate_dropped);
    let accuracy = |of: &Manifest| of.accuracy.clone().map(Accuracy::without_tiles);
    stated.accuracy = accuracy(a).filter(|same| accuracy(b).as_ref() == Some(same));
    stated.negligible = a.negligible.clone().filter(|same| b.negligible.as_ref() == Some(same));
    stated
}
