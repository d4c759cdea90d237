//! Differences of two archives. In: two archives. Out: statements, receivers, cells and blocks that
//! differ.

use std::fmt::Write as _;
use std::path::Path;

use crate::Workspace;
use crate::transfer::compare::{Difference, differences};
use crate::transfer::digests::{AllLayers, Digests, cell_name, same_cell};
use crate::transfer::output::unknown;
use crate::transfer::rows::{ArchiveReceivers, all_cells};
use crate::transfer::union::{Side, union};
use heliotile_core::archive::{Archive, format};
use heliotile_core::error::Result;
use heliotile_core::layers::cells::Cell;
use heliotile_core::memory::Use;
use heliotile_core::opened::{CellSource, OpenSite};
use heliotile_core::text::{FirstNames, counted};
use heliotile_files::spill::{Sorted, Sorter};

/// Differences of two archives.
#[derive(Clone, Debug, Default)]
pub struct Differences {
    /// Scene, settings, materials, and all else that the manifest states.
    pub statements: Vec<Difference>,
    /// Receivers, matched by id.
    pub receivers: Parted,
    /// Cells that receivers see, matched by key.
    pub probes: Parted,
    /// Coarser cells, matched by key.
    pub bounces: Parted,
    /// Blocks of kinds that this release does not know.
    pub unknown: Parted,
    /// True if both archives have the same root hash.
    pub same_root: bool,
}

impl Differences {
    /// Returns the differences between the archives at these paths as a short text. Lists name the
    /// first of many.
    pub fn table(&self, [a, b]: [&Path; 2]) -> String {
        let found = self;
        let mut out = String::new();
        if found.is_equal() {
            let roots = match found.same_root {
                true => "and so are the roots",
                false => "but the roots differ: tiled or compressed in another way, or written by another release",
            };
            return format!("equal, {roots}\n");
        }
        // Writing to a string cannot fail.
        let _ = writeln!(out, "A {}\nB {}", a.display(), b.display());
        for Difference { item, values: [a, b] } in &found.statements {
            let _ = writeln!(out, "{item}: {a} in A, {b} in B");
        }
        const CELLS: &str = " (level/facing/material/voxel)";
        for (thing, note, parted) in [
            ("receiver", "", &found.receivers),
            ("probe", CELLS, &found.probes),
            ("bounce cell", CELLS, &found.bounces),
            ("unknown block", "", &found.unknown),
        ] {
            for (side, names) in
                [("only in A", &parted.only_a), ("only in B", &parted.only_b), ("different", &parted.different)]
            {
                if names.count > 0 {
                    let _ = writeln!(out, "{side:<9}  {}: {}{note}", counted(names.count, thing), names.listed());
                }
            }
        }
        out
    }

    /// Returns true if both archives have the same content, however it is packed.
    pub fn is_equal(&self) -> bool {
        let parts = [&self.receivers, &self.probes, &self.bounces, &self.unknown];
        self.statements.is_empty() && parts.iter().all(|part| part.is_empty())
    }
}

/// Items of one kind, by the archives that hold them.
#[derive(Clone, Debug, Default)]
pub struct Parted {
    /// Items in the first archive only.
    pub only_a: Names,
    /// Items in the second archive only.
    pub only_b: Names,
    /// Items in both archives with different content.
    pub different: Names,
}

impl Parted {
    fn is_empty(&self) -> bool {
        [&self.only_a, &self.only_b, &self.different].iter().all(|names| names.count == 0)
    }

    /// Adds one side of a union. For two items `compare` returns the difference, if any.
    fn add<T>(&mut self, side: &Side<T>, name: impl Fn(&T) -> String, compare: impl Fn(&T, &T) -> Option<String>) {
        match side {
            Side::Left(item) => self.only_a.add(|| name(item)),
            Side::Right(item) => self.only_b.add(|| name(item)),
            Side::Both(a, b) => {
                if let Some(what) = compare(a, b) {
                    self.different.add(|| name(a) + &what);
                }
            }
        }
    }
}

/// Number of items, the first few by name.
pub type Names = FirstNames<20>;

/// Compares the whole content of two archives. Receivers are matched by id, cells by key.
pub fn diff(a: &Archive, b: &Archive, workspace: &Workspace) -> Result<Differences> {
    let mut found =
        Differences { statements: differences(a, b)?, same_root: a.root() == b.root(), ..Differences::default() };
    let (of_a, of_b) = (OpenSite::open(a)?, OpenSite::open(b)?);
    for side in union(by_id(&of_a, workspace)?, by_id(&of_b, workspace)?, |a, b| a.0.cmp(&b.0)) {
        let name = |record: &(Vec<u8>, Vec<u8>)| String::from_utf8_lossy(&record.0).into_owned();
        found.receivers.add(&side?, name, |a, b| {
            let parts = Digests::from_bytes(&a.1).differences(&Digests::from_bytes(&b.1));
            (!parts.is_empty()).then(|| format!(" ({})", parts.join(", ")))
        });
    }
    diff_cells(&CellSource::probes(&of_a)?, &CellSource::probes(&of_b)?, &mut found.probes)?;
    diff_cells(&CellSource::bounces(&of_a)?, &CellSource::bounces(&of_b)?, &mut found.bounces)?;
    let order = |a: &&format::Entry, b: &&format::Entry| a.key().cmp(&b.key());
    for side in union(unknown(a).map(Ok), unknown(b).map(Ok), order) {
        let content = |entry: &format::Entry| (entry.schema, entry.items, entry.content);
        found.unknown.add(&side?, |entry| entry.name(), |a, b| (content(a) != content(b)).then(String::new));
    }
    Ok(found)
}

/// Returns the receivers' hashes by id.
fn by_id(site: &OpenSite, workspace: &Workspace) -> Result<Sorted> {
    let mut sorter = Sorter::new(&workspace.folder, workspace.memory.length(Use::ReceiverIds));
    for row in ArchiveReceivers::<AllLayers>::new(site) {
        let row = row?;
        sorter.push(row.receiver.id.as_bytes(), &Digests::new(&row).to_bytes())?;
    }
    sorter.finish()
}

fn diff_cells(a: &CellSource, b: &CellSource, found: &mut Parted) -> Result<()> {
    for side in union(all_cells(a), all_cells(b), |a: &Cell, b: &Cell| a.key.cmp(&b.key)) {
        found.add(&side?, |cell| cell_name(&cell.key), |a, b| (!same_cell(a, b)).then(String::new));
    }
    Ok(())
}
