//! Sensor grids of receivers. In: receivers. Out: grids with names that are valid for files, and a
//! grid for each receiver: 4 bytes each.

use std::collections::{BTreeMap, BTreeSet};

use crate::outputs::tables::layout::By;
use heliotile_core::error::Result;
use heliotile_core::site::receiver::Receiver;

/// Sensor grid.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SensorGrid {
    /// Name of the grid's files, unique even if case is ignored.
    pub identifier: String,
    /// Name of the grid in the archive.
    pub name: String,
    pub count: u32,
}

/// Sensor grids of a site.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Grids {
    /// Grids, sorted by name.
    pub list: Vec<SensorGrid>,
    /// `[receiver]`: index of its grid.
    pub of_receiver: Vec<u32>,
}

/// Largest number of characters of an identifier: file names are limited to 255 bytes.
const MAX: usize = 100;

impl Grids {
    /// Groups receivers, which must come in the same order as their values. A receiver without the
    /// name selected by `by` is in a grid `site`. With [`By::Receiver`] a grid is an object: a
    /// room, a part of a building.
    pub fn new(receivers: impl Iterator<Item = Result<Receiver>>, by: By) -> Result<Self> {
        let mut found: BTreeMap<String, (u32, u32)> = BTreeMap::new();
        let mut numbers = Vec::new();
        for receiver in receivers {
            let receiver = receiver?;
            let part = receiver.part;
            let name = match by {
                By::Receiver | By::Object => part.object,
                By::Building => part.building,
                By::Kind => part.kind,
                By::Surface | By::Window | By::Pane => receiver.surface.unwrap_or_default(),
            };
            let next = found.len() as u32;
            let name = if name.is_empty() { "site".to_owned() } else { name };
            let entry = found.entry(name).or_insert((next, 0));
            entry.1 += 1;
            numbers.push(entry.0);
        }
        let mut places = vec![0; found.len()];
        let mut taken = BTreeSet::new();
        let list = found.into_iter().zip(0_u32..).map(|((name, (number, count)), place)| {
            if let Some(slot) = places.get_mut(number as usize) {
                *slot = place;
            }
            SensorGrid { identifier: identifier(&name, &mut taken), name, count }
        });
        let list = list.collect();
        numbers.iter_mut().for_each(|number| *number = places.get(*number as usize).copied().unwrap_or_default());
        Ok(Grids { list, of_receiver: numbers })
    }
}

/// Returns a unique name of letters, digits, `_`, `-` and points.
fn identifier(name: &str, taken: &mut BTreeSet<String>) -> String {
    let letter = |c: char| if c.is_ascii_alphanumeric() || "_-.".contains(c) { c } else { '_' };
    let plain: String = name.chars().map(letter).take(MAX).collect();
    // A name of points alone would be a folder.
    let plain = if plain.chars().all(|c| c == '.') { format!("_{plain}") } else { plain };
    let mut tried = plain.clone();
    let mut number = 2;
    while !taken.insert(tried.to_lowercase()) {
        tried = format!("{plain}_{number}");
        number += 1;
    }
    tried
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Five receivers are in 4 grids in the order of names; characters that are invalid in file
    /// names become `_`, and two names that differ in case get different files.
    #[test]
    fn names_of_grids_are_valid_file_names() {
        let receivers = ["b/c", "Hall", "hall", "b/c", ""].map(|object| {
            let mut receiver = Receiver::new("r".into(), DVec3::ZERO, DVec3::Z);
            receiver.part.object = object.into();
            Ok(receiver)
        });
        let grids = Grids::new(receivers.into_iter(), By::Receiver).expect("grids");
        let told: Vec<_> =
            grids.list.iter().map(|grid| (grid.identifier.as_str(), grid.name.as_str(), grid.count)).collect();
        assert_eq!(told, [("Hall", "Hall", 1), ("b_c", "b/c", 2), ("hall_2", "hall", 1), ("site", "site", 1)]);
        assert_eq!(grids.of_receiver, [1, 0, 2, 1, 3]);
        assert_eq!(identifier("..", &mut BTreeSet::new()), "_..");
    }
}
