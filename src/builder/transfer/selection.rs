//! Which receivers of an archive are meant: those of a list, of a box, of some surfaces.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::spill::Sorter;
use crate::transfer::conflicts::listed;
use crate::transfer::rows::ArchiveReceivers;
use crate::transfer::union::{Side, union};
use heliotile_core::error::{Error, Result};
use heliotile_core::opened::OpenSite;
use heliotile_core::site::receiver::Receiver;
use heliotile_scene::covering::receiver_ids::ReceiverIds;

/// Names that a message holds.
const NAMED: usize = 10;

/// A box of positions, its faces included; metres, input coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lowest coordinates.
    pub low: DVec3,
    /// Highest coordinates.
    pub high: DVec3,
}

/// Which receivers of an archive are meant.
#[derive(Clone, Debug, PartialEq)]
pub enum Selection {
    /// Ids in a column `receiver` of a CSV file.
    Receivers(PathBuf),
    /// Positions in a box, its faces included.
    Bounds(Bounds),
    /// Names of surfaces.
    Surfaces(Vec<String>),
    /// Names of objects, or of buildings with all of their parts.
    Objects(Vec<String>),
}

impl Selection {
    /// For each receiver of some archives whether it is meant, in their order, one byte each. Nobody, and names that do not exist in
    /// any of them, are errors.
    pub fn resolve(&self, sites: &[OpenSite], folder: &Path, budget_bytes: usize) -> Result<Vec<bool>> {
        let rows = || receivers_of(sites);
        let kept = match self {
            Selection::Receivers(file) => listed_in(file, sites, folder, budget_bytes)?,
            Selection::Bounds(Bounds { low, high }) => {
                let inside = |p: DVec3| p.cmpge(*low).all() && p.cmple(*high).all();
                rows().map(|receiver| Ok(inside(receiver?.position))).collect::<Result<_>>()?
            }
            Selection::Surfaces(names) => {
                let of = |receiver: &Receiver| [receiver.surface.clone().unwrap_or_default(), String::new()];
                named(names, "surfaces", of, sites)?
            }
            Selection::Objects(names) => {
                let of = |receiver: &Receiver| [receiver.part.object.clone(), receiver.part.building.clone()];
                named(names, "objects", of, sites)?
            }
        };
        if kept.contains(&true) {
            return Ok(kept);
        }
        let hint = "choose a larger part; positions are in the coordinates of the scene file";
        Err(Error::input(first(sites), None, "the selection holds none of the receivers", hint))
    }
}

/// All receivers of some archives, in their order.
fn receivers_of<'a>(sites: &'a [OpenSite]) -> impl Iterator<Item = Result<Receiver>> + 'a {
    sites.iter().flat_map(ArchiveReceivers::<()>::new).map(|row| Ok(row?.receiver))
}

/// What messages name.
fn first<'a>(sites: &[OpenSite<'a>]) -> &'a Path {
    sites.first().map_or(Path::new(""), OpenSite::path)
}

/// The receivers that one of some names is a name of; a name of nobody is an error.
fn named(
    names: &[String],
    what: &'static str,
    of: impl Fn(&Receiver) -> [String; 2],
    sites: &[OpenSite],
) -> Result<Vec<bool>> {
    let mut missing: BTreeSet<&str> = names.iter().map(String::as_str).collect();
    let kept = receivers_of(sites).map(|receiver| {
        let own = of(&receiver?);
        for name in &own {
            missing.remove(name.as_str());
        }
        Ok(own.iter().any(|name| names.contains(name)))
    });
    let kept: Vec<bool> = kept.collect::<Result<_>>()?;
    if missing.is_empty() {
        return Ok(kept);
    }
    let names: Vec<String> = missing.iter().take(NAMED).map(|name| (*name).to_owned()).collect();
    let found = format!("holds no receivers of {}", listed(missing.len() as u64, what, &names));
    let hint =
        format!("name {what} as `receivers.csv` does; `--surface` takes surfaces, `--object` objects and buildings");
    Err(Error::input(first(sites), None, found, hint))
}

/// The receivers whose ids stand in a file.
fn listed_in(file: &Path, sites: &[OpenSite], folder: &Path, budget_bytes: usize) -> Result<Vec<bool>> {
    let mut wanted = Sorter::new(folder, budget_bytes / 2).unique();
    for id in ReceiverIds::open(file)? {
        let (id, line) = id?;
        wanted.push(id.as_bytes(), &(line as u64).to_le_bytes())?;
    }
    let mut held = Sorter::new(folder, budget_bytes / 2);
    let mut count = 0_u64;
    for receiver in receivers_of(sites) {
        held.push(receiver?.id.as_bytes(), &count.to_le_bytes())?;
        count += 1;
    }
    let number = |payload: &[u8]| payload.first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes));
    let mut kept = vec![false; count as usize];
    let (mut missing, mut missing_count) = (Vec::new(), 0);
    for side in union(wanted.finish()?, held.finish()?, |a, b| a.0.cmp(&b.0)) {
        match side? {
            Side::Both(_, (_, place)) => {
                if let Some(kept) = kept.get_mut(number(&place) as usize) {
                    *kept = true;
                }
            }
            Side::Left((id, line)) => {
                missing_count += 1;
                if missing.len() < NAMED {
                    missing.push(format!("{} (line {})", String::from_utf8_lossy(&id), number(&line)));
                }
            }
            Side::Right(_) => {}
        }
    }
    if missing_count == 0 {
        return Ok(kept);
    }
    let what = format!("{} does not hold {}", first(sites).display(), listed(missing_count, "receivers", &missing));
    Err(Error::input(file, None, what, "remove these rows, or name the archive that holds them"))
}
