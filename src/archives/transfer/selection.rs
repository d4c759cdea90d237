//! Selection of receivers of an archive: by a list, a box, surfaces or objects. In: archives. Out:
//! for each receiver true if it is selected. Tiles without any are not read.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::receiver_ids::ReceiverIds;
use crate::transfer::rows::ArchiveReceivers;
use crate::transfer::union::{Side, union};
use heliotile_core::archive::tables::NameOf;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::opened::{NameIndex, OpenSite, tiles_within};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::{counted, listed, message};
use heliotile_files::spill::{Sorted, Sorter, damaged, number_of};

/// Largest number of names in a message.
const NAMED: usize = 10;

/// Box of positions, its faces included; metres, input coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lowest coordinates.
    pub low: DVec3,
    /// Highest coordinates.
    pub high: DVec3,
}

impl Bounds {
    /// Parses xmin, ymin, xmax, ymax, for all heights, or followed by zmin, zmax.
    pub fn new(numbers: &[f64]) -> std::result::Result<Self, String> {
        let (low, high) = match *numbers {
            [x0, y0, x1, y1] => (DVec3::new(x0, y0, f64::NEG_INFINITY), DVec3::new(x1, y1, f64::INFINITY)),
            [x0, y0, x1, y1, z0, z1] => (DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1)),
            _ => return Err(format!("{} numbers, not 4 or 6: give xmin,ymin,xmax,ymax[,zmin,zmax]", numbers.len())),
        };
        if !low.cmple(high).all() {
            return Err("a lower bound is above its upper bound: give xmin,ymin,xmax,ymax[,zmin,zmax]".into());
        }
        Ok(Bounds { low, high })
    }
}

/// Receivers of an archive to select.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Selection {
    /// Ids in a column `receiver` of a CSV file.
    Receivers(PathBuf),
    /// List of ids.
    Ids(Vec<String>),
    /// Positions in a box, its faces included.
    Bounds(Bounds),
    /// Names of surfaces.
    Surfaces(Vec<String>),
    /// Names of objects, or of buildings with all of their parts.
    Objects(Vec<String>),
}

impl Selection {
    /// Returns for each receiver of some archives true if it is selected, in their order, one byte
    /// each. Fails if no receiver is selected, or if no archive holds one of the names.
    pub fn resolve(&self, sites: &[OpenSite], folder: &Path, budget_bytes: usize) -> Result<Vec<bool>> {
        let kept = match self {
            Selection::Receivers(file) => listed_in(file, sites, folder, budget_bytes)?,
            Selection::Ids(ids) => {
                let (kept, missing) = by_id(ids.iter().map(|id| Ok((id.clone(), 0))), sites, folder, budget_bytes)?;
                if missing.count > 0 {
                    let what = format!("{} {}", none(sites, NOT_HELD), missing.listed(|id, _| id.to_owned()));
                    return Err(Error::input(first(sites), None, what, "use the names in `receivers.csv`"));
                }
                kept
            }
            Selection::Bounds(Bounds { low, high }) => {
                let inside = |p: DVec3| p.cmpge(*low).all() && p.cmple(*high).all();
                let tiles = |site: &OpenSite| tiles_within(site, [*low, *high]);
                marked(sites, tiles, |receiver| inside(receiver.position))?
            }
            Selection::Surfaces(names) => named(names, "surface", &[NameOf::Surface], sites)?,
            Selection::Objects(names) => named(names, "object", &[NameOf::Object, NameOf::Building], sites)?,
        };
        if kept.contains(&true) {
            return Ok(kept);
        }
        let hint = "choose a larger part; positions are in the coordinates of the scene file";
        Err(Error::input(first(sites), None, "the selection holds none of the receivers", hint).because(Problem::Empty))
    }
}

/// Returns the receivers of some tiles of each archive, with their places among all receivers.
fn receivers_of<'a>(
    sites: &'a [OpenSite],
    tiles: Vec<Vec<u32>>,
) -> impl Iterator<Item = Result<(usize, Receiver)>> + 'a {
    let mut first = 0;
    sites.iter().zip(tiles).flat_map(move |(site, tiles)| {
        let mut places: Vec<Range<usize>> = Vec::new();
        for tile in 0..site.tiles() {
            places.push(first..first + site.tile_rows(tile));
            first += site.tile_rows(tile);
        }
        let of_tiles: Vec<Range<usize>> = tiles.iter().filter_map(|&tile| places.get(tile as usize).cloned()).collect();
        let mut rows = of_tiles.into_iter().flatten();
        ArchiveReceivers::<()>::of_tiles(site, tiles).map(move |receiver| {
            let receiver = receiver?.receiver;
            let row = rows.next().ok_or_else(|| unexpected(site.path(), &receiver))?;
            Ok((row, receiver))
        })
    })
}

/// Returns the error for a receiver that the directory of its archive does not count.
fn unexpected(path: &Path, receiver: &Receiver) -> Error {
    Error::defect(path, "directory", "rows of receivers", format!("does not count receiver {}", receiver.id))
}

/// Selects the receivers for which `meant` is true, from the tiles that may hold some.
fn marked(
    sites: &[OpenSite],
    tiles: impl Fn(&OpenSite) -> Result<Vec<u32>>,
    mut meant: impl FnMut(&Receiver) -> bool,
) -> Result<Vec<bool>> {
    let tiles: Vec<_> = sites.iter().map(tiles).collect::<Result<_>>()?;
    let mut kept = none_kept(sites);
    for receiver in receivers_of(sites, tiles) {
        let (row, receiver) = receiver?;
        *kept.get_mut(row).ok_or_else(|| unexpected(first(sites), &receiver))? = meant(&receiver);
    }
    Ok(kept)
}

/// Returns false for each receiver of some archives.
fn none_kept(sites: &[OpenSite]) -> Vec<bool> {
    vec![false; sites.iter().map(|site| site.receivers() as usize).sum()]
}

/// Returns the path that messages name.
fn first<'a>(sites: &[OpenSite<'a>]) -> &'a Path {
    sites.first().map_or(Path::new(""), OpenSite::path)
}

/// Predicate of a message for one archive and for several.
const NOT_HELD: [&str; 2] = ["does not hold", "do not hold"];

/// Returns the predicate of a message that begins with the name of the first of some archives.
fn none(sites: &[OpenSite], [one, several]: [&str; 2]) -> String {
    match sites.len() {
        0 | 1 => one.to_owned(),
        count => format!("and {} {several}", counted(count as u64 - 1, "other archive")),
    }
}

/// Selects the receivers with one of some names. Fails for names without receivers.
fn named(names: &[String], thing: &str, of: &[NameOf], sites: &[OpenSite]) -> Result<Vec<bool>> {
    let tiles = |site: &OpenSite| {
        let mut name_index = NameIndex::new(site)?;
        let asked = || of.iter().flat_map(|&of| names.iter().map(move |name| (of, name.as_str())));
        name_index.expect(asked());
        let mut tiles = BTreeSet::new();
        for (of, name) in asked() {
            tiles.extend(name_index.tiles(of, name)?);
        }
        Ok(tiles.into_iter().collect())
    };
    let mut missing: BTreeSet<&str> = names.iter().map(String::as_str).collect();
    let kept = marked(sites, tiles, |receiver| {
        let own = NameOf::names(receiver).into_iter().filter(|(what, name)| of.contains(what) && !name.is_empty());
        own.fold(false, |found, (_, name)| {
            missing.remove(name);
            found || names.iter().any(|asked| asked == name)
        })
    })?;
    if missing.is_empty() {
        return Ok(kept);
    }
    let found = format!(
        "{} receivers of {}: {}",
        none(sites, ["holds no", "hold no"]),
        counted(missing.len() as u64, thing),
        listed(missing.iter().take(NAMED), missing.len())
    );
    let unknown: Vec<&str> = missing.into_iter().collect();
    let hint = message!(
        "use the {thing} names in `receivers.csv`; {{surface}} is for surfaces, {{object}} for objects and buildings"
    );
    Err(Error::input(first(sites), None, found, hint).because(Problem::unknown(&unknown.join(", "), [])))
}

/// Selects the receivers whose ids are in a file.
fn listed_in(file: &Path, sites: &[OpenSite], folder: &Path, budget_bytes: usize) -> Result<Vec<bool>> {
    let ids = ReceiverIds::open(file)?.map(|row| row.map(|(id, line)| (id, line as u64)));
    let (kept, missing) = by_id(ids, sites, folder, budget_bytes)?;
    if missing.count == 0 {
        return Ok(kept);
    }
    let names = missing.listed(|id, line| format!("{id} (line {line})"));
    let what = format!("{} {} {names}", first(sites).display(), none(sites, NOT_HELD));
    let ids: Vec<&str> = missing.some.iter().map(|(id, _)| id.as_str()).collect();
    Err(Error::input(file, None, what, "remove these rows, or give the archive that holds them")
        .because(Problem::unknown(&ids.join(", "), [])))
}

/// Ids that no archive holds.
#[derive(Default)]
struct MissingIds {
    count: u64,
    /// First ones, with their lines.
    some: Vec<(String, u64)>,
}

impl MissingIds {
    fn listed(&self, name: impl Fn(&str, u64) -> String) -> String {
        let names = listed(self.some.iter().map(|(id, line)| name(id, *line)), self.count as usize);
        format!("{}: {names}", counted(self.count, "receiver"))
    }
}

/// Selects the receivers with some ids, each given with its line. Returns the ids without
/// receivers, too.
fn by_id(
    ids: impl Iterator<Item = Result<(String, u64)>>,
    sites: &[OpenSite],
    folder: &Path,
    budget_bytes: usize,
) -> Result<(Vec<bool>, MissingIds)> {
    let mut wanted = Sorter::new(folder, budget_bytes / 2).unique();
    for id in ids {
        let (id, line) = id?;
        wanted.push(id.as_bytes(), &line.to_le_bytes())?;
    }
    let mut wanted = wanted.finish()?;
    let mut tiles = Vec::new();
    for site in sites {
        tiles.push(tiles_of_ids(site, &mut wanted)?);
    }
    let mut held = Sorter::new(folder, budget_bytes / 2);
    for receiver in receivers_of(sites, tiles) {
        let (row, receiver) = receiver?;
        held.push(receiver.id.as_bytes(), &(row as u64).to_le_bytes())?;
    }
    let (mut kept, mut missing) = (none_kept(sites), MissingIds::default());
    // Parts of an atlas may have receivers with the same id: all of them are selected.
    let mut last = None;
    for side in union(wanted, held.finish()?, |a, b| a.0.cmp(&b.0)) {
        match side? {
            Side::Both(_, (id, row)) => {
                *kept.get_mut(number_of(&row, folder)? as usize).ok_or_else(|| damaged(folder))? = true;
                last = Some(id);
            }
            Side::Right((id, row)) if last.as_ref() == Some(&id) => {
                *kept.get_mut(number_of(&row, folder)? as usize).ok_or_else(|| damaged(folder))? = true;
            }
            Side::Left((id, line)) => {
                missing.count += 1;
                if missing.some.len() < NAMED {
                    missing.some.push((String::from_utf8_lossy(&id).into_owned(), number_of(&line, folder)?));
                }
            }
            Side::Right(_) => {}
        }
    }
    Ok((kept, missing))
}

/// Number of ids that are looked up together.
const TOGETHER: usize = 4096;

/// Returns the tiles that hold receivers of some ids. `wanted` is rewound.
fn tiles_of_ids(site: &OpenSite, wanted: &mut Sorted) -> Result<Vec<u32>> {
    let mut name_index = NameIndex::new(site)?;
    let mut tiles = BTreeSet::new();
    loop {
        let ids: Vec<String> = wanted
            .by_ref()
            .take(TOGETHER)
            .map(|record| Ok(String::from_utf8_lossy(&record?.0).into_owned()))
            .collect::<Result<_>>()?;
        if ids.is_empty() {
            wanted.rewind()?;
            return Ok(tiles.into_iter().collect());
        }
        name_index.expect(ids.iter().map(|id| (NameOf::Receiver, id.as_str())));
        for id in &ids {
            tiles.extend(name_index.tiles(NameOf::Receiver, id)?);
        }
    }
}

/// A box as `xmin,ymin,xmax,ymax` of any height, or with `zmin,zmax` behind.
impl heliotile_requests::Parse for Bounds {
    fn parse(text: &str) -> std::result::Result<Self, heliotile_requests::Wrong> {
        let number = |part: &str| <f64 as heliotile_requests::Parse>::parse(part.trim());
        Ok(Bounds::new(&text.split(',').map(number).collect::<std::result::Result<Vec<f64>, _>>()?)?)
    }
}
