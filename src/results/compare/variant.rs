//! One archive after a change. In: its receivers, those before. Out: the matched receivers, and
//! their values in the order of the receivers before.

use std::iter::Peekable;
use std::path::Path;

use super::tally::Tally;
use crate::archives::Archives;
use crate::receivers::{ReceiverChoice, ReceiverSet};
use crate::stream::TileStream;
use heliotile_archives::transfer::{Bounds, Selection};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::memory::{MemoryBudget, Use};
use heliotile_core::opened::{ReceiverMatching, ReceiverPlace};
use heliotile_core::replay::components::ComponentList;
use heliotile_core::replay::values::TileValues;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::message;
use heliotile_files::spill::{Sorted, Sorter, damaged};

/// Memory of a receiver during matching, bytes, without its name.
const BYTES_OF_RECEIVER: u64 = 200;

/// Largest number of unmatched receivers that a summary names.
pub const NAMED: usize = 3;

/// Side of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SideName {
    Before,
    After,
}

/// Receiver that exists on one side only.
#[derive(Clone, Debug)]
pub struct UnmatchedReceiver {
    pub side: SideName,
    pub place: ReceiverPlace,
}

/// Archive after, matched and replayed.
pub struct Variant {
    /// Name of the archive in a summary.
    pub name: String,
    pub root: String,
    pub moved: u64,
    pub unmatched: Vec<UnmatchedReceiver>,
    pub tally: Tally,
    /// Values after, sorted by the row of the receiver before.
    values: Peekable<Sorted>,
}

/// Places of the receivers before, for matching.
pub struct BeforePlaces {
    pub places: Vec<ReceiverPlace>,
    /// True for each receiver that also exists in an archive after.
    pub is_matched: Vec<bool>,
}

impl BeforePlaces {
    /// Reads the places of the chosen receivers.
    pub fn new(receivers: &ReceiverSet, memory: MemoryBudget) -> Result<Self> {
        check_memory(receivers.count(), memory)?;
        let places: Vec<ReceiverPlace> = receivers.receivers().map(|one| Ok((&one?).into())).collect::<Result<_>>()?;
        Ok(BeforePlaces { is_matched: vec![false; places.len()], places })
    }
}

/// Replay of archives after, with the settings of the one before.
pub struct VariantReplay<'a> {
    pub before: TileStream<'a>,
    pub components: &'a ComponentList,
    /// Choice of the receivers before.
    pub choice: &'a ReceiverChoice,
    /// Folder and memory, bytes, for values that wait.
    pub folder: &'a Path,
    pub memory_bytes: usize,
}

impl VariantReplay<'_> {
    /// Matches the receivers of an archive with those before, and replays those that exist on both
    /// sides.
    pub fn run(&self, name: String, place: &Path, archives: Archives, before: &mut BeforePlaces) -> Result<Variant> {
        let memory = self.before.resources.memory;
        let all = ReceiverChoice { selection: None, ..*self.choice }.of(archives, self.folder, memory)?;
        check_memory(all.count().saturating_add(before.places.len() as u64), memory)?;
        // All receivers after are matched: a receiver that moved may lie outside the choice.
        let (mut places, mut is_asked) = (Vec::new(), Vec::new());
        for receiver in all.receivers() {
            let receiver = receiver?;
            places.push(ReceiverPlace::from(&receiver));
            is_asked.push(self.choice.selection.as_ref().is_none_or(|selection| is_meant(selection, &receiver)));
        }
        let matching = ReceiverMatching::new(&before.places, &places);
        if matching.pairs.is_empty() {
            let what = format!("has none of the {} receivers of the archive before", before.places.len());
            let hint = "compare archives of one site: receivers are matched by place and normal, or by name";
            return Err(Error::input(place, None, what, hint).because(Problem::OtherSite));
        }
        let mut partner = vec![None; places.len()];
        for pair in &matching.pairs {
            before.is_matched[pair.before] = true;
            partner[pair.after] = Some(pair.before as u32);
        }
        let of = |side, place: &ReceiverPlace| UnmatchedReceiver { side, place: place.clone() };
        let gone = matching.only_before.iter().map(|number| of(SideName::Before, &before.places[*number]));
        let new = matching.only_after.iter().filter(|number| is_asked[**number]);
        let new = new.map(|number| of(SideName::After, &places[*number]));
        let unmatched = gone.chain(new).collect();
        drop(places);
        let is_partner: Vec<bool> = partner.iter().map(Option::is_some).collect();
        let rows: Vec<u32> = partner.into_iter().flatten().collect();
        let values = self.replay(&all.some(&is_partner), &rows)?;
        let (moved, tally) = (matching.moved() as u64, Tally::default());
        Ok(Variant { name, root: archives.root(), moved, unmatched, tally, values: values.peekable() })
    }

    /// Replays receivers and sorts their values, `[component][bin]`, by their rows before.
    fn replay(&self, receivers: &ReceiverSet, rows: &[u32]) -> Result<Sorted> {
        let mut sorter = Sorter::new(self.folder, self.memory_bytes);
        let mut rows = rows.iter();
        let stream = TileStream { receivers, ..self.before };
        stream.each(self.components.set(), |tile| {
            for (place, row) in (0..tile.ids.len()).zip(rows.by_ref()) {
                let values = self.components.as_slice().iter().flat_map(|one| tile.values.row(*one, place));
                let bytes: Vec<u8> = values.flat_map(|value| value.to_le_bytes()).collect();
                sorter.push(&row.to_be_bytes(), &bytes)?;
            }
            Ok(true)
        })?;
        sorter.finish()
    }
}

impl Variant {
    /// Returns the values of receivers by their rows before, which must come in order, and a flag
    /// for each row that says if it has values.
    pub fn values(
        &mut self,
        rows: &[u32],
        components: &ComponentList,
        bins: usize,
        folder: &Path,
    ) -> Result<(Vec<bool>, TileValues)> {
        let mut found = TileValues::new(rows.len(), bins);
        let mut is_there = vec![false; rows.len()];
        for (number, row) in rows.iter().enumerate() {
            let key = row.to_be_bytes();
            let is_next = |record: &Result<(Vec<u8>, Vec<u8>)>| record.as_ref().map_or(true, |(at, _)| **at == key);
            let Some(record) = self.values.next_if(is_next) else { continue };
            let bytes = record?.1;
            let (numbers, rest) = bytes.as_chunks();
            if !rest.is_empty() || numbers.len() != bins * components.as_slice().len() {
                return Err(damaged(folder));
            }
            is_there[number] = true;
            for (component, from) in components.as_slice().iter().zip(numbers.chunks(bins.max(1))) {
                let to = found.row_mut(*component, number);
                to.iter_mut().zip(from).for_each(|(to, from)| *to = f32::from_le_bytes(*from));
            }
        }
        Ok((is_there, found))
    }

    /// Returns the number of receivers that exist only on `side`, and the names of the first ones.
    pub fn only(&self, side: SideName) -> (u64, Vec<String>) {
        let mut of_side = self.unmatched.iter().filter(|one| one.side == side);
        let first: Vec<String> = of_side.by_ref().take(NAMED).map(|one| one.place.id.clone()).collect();
        (first.len() as u64 + of_side.count() as u64, first)
    }
}

/// Fails if `receivers` receivers cannot be matched within the memory.
pub fn check_memory(receivers: u64, memory: MemoryBudget) -> Result<()> {
    let (bytes, most) = (receivers.saturating_mul(BYTES_OF_RECEIVER), memory.share(Use::ReceiverList));
    if bytes <= most {
        return Ok(());
    }
    let what = message!(
        "the memory to match {receivers} receivers, in bytes (raise {{memory}}, or compare a part with {{bbox}})"
    );
    Err(Error::Limit { what, value: bytes, max: most })
}

/// Returns true if a choice of receivers before also selects `receiver` of an archive after. A list
/// of names applies to the archive before only.
fn is_meant(selection: &Selection, receiver: &Receiver) -> bool {
    let part = &receiver.part;
    match selection {
        Selection::Bounds(Bounds { low, high }) => {
            receiver.position.cmpge(*low).all() && receiver.position.cmple(*high).all()
        }
        Selection::Surfaces(names) => receiver.surface.as_ref().is_some_and(|surface| names.contains(surface)),
        Selection::Objects(names) => names.contains(&part.object) || names.contains(&part.building),
        _ => false,
    }
}
