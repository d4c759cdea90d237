//! Choice of the level of detail of an object. In: its surfaces by level. Out: the surfaces of one
//! level. A building whose finest level is not closed gets its finest closed level instead, with a
//! note.

use crate::formats::citygml::closed::is_closed;
use crate::formats::citygml::store::{Side, Store};
use crate::formats::cityjson::document::Lod;
use crate::formats::cityjson::objects::{LEVELS_NAMED, NO_LEVEL, OTHER_LEVEL, Reader, level_of};
use crate::formats::cityjson::surfaces::is_hull;
use heliotile_core::text::{Message, counted, with_list};

/// Finest level that shows a building from outside; level 4 also shows its rooms.
const OUTSIDE: &str = "3";

/// Surfaces of an object in one level of detail.
pub(super) struct Offer {
    pub lod: Option<Lod>,
    pub sides: Vec<Side>,
    /// True if the surfaces are known to be closed; `None` if that must be checked.
    pub is_closed: Option<bool>,
}

impl Offer {
    fn is_closed(&self, store: &Store) -> bool {
        self.is_closed
            .unwrap_or_else(|| is_closed(store, &self.sides) || is_closed(store, &without_openings(store, &self.sides)))
    }
}

/// Choices that the user may want to know about.
#[derive(Default)]
pub(super) struct Levels {
    /// Names of buildings whose finest level is not closed while a coarser one is.
    coarser: Vec<String>,
}

impl Levels {
    /// Returns the level of an object to read; `None` if the object has no surfaces, or none in the
    /// level asked for or a coarser one.
    pub(super) fn choose(
        &mut self,
        id: &str,
        kind: &str,
        store: &Store,
        mut offers: Vec<Offer>,
        reader: &mut Reader,
    ) -> Option<Offer> {
        if offers.is_empty() {
            return None;
        }
        if reader.levels.len() < LEVELS_NAMED {
            reader.levels.extend(offers.iter().filter_map(|offer| offer.lod));
        }
        let asked = reader.asked;
        // Level 4 is read only if it is asked for or is the only one.
        let bounds = if asked.is_some() { [asked, None] } else { [Lod::parse(OUTSIDE), None] };
        let tries = if asked.is_some() { bounds.get(..1) } else { bounds.get(..) };
        let level =
            tries.unwrap_or_default().iter().find_map(|most| level_of(offers.iter().map(|offer| offer.lod), *most));
        let Some(mut level) = level else {
            offers.iter().for_each(|_| reader.geometry.leave_out(NO_LEVEL));
            return None;
        };
        if asked.is_none() && is_hull(kind) {
            let closed = closed_below(store, &offers, level);
            if closed != level {
                self.coarser.push(id.to_owned());
                level = closed;
            }
        }
        (1..offers.len()).for_each(|_| reader.geometry.leave_out(OTHER_LEVEL));
        let at = offers.iter().position(|offer| offer.lod == level)?;
        Some(offers.swap_remove(at))
    }

    /// Returns a sentence on the buildings that are read in a coarser level than their finest.
    pub(super) fn doubt(&self) -> Option<Message> {
        let first = self.coarser.first()?;
        let count = counted(self.coarser.len() as u64, "building");
        let sentence = format!(
            "{count} (`{first}`) read in a coarser level of detail: the finest one is not closed; state `lod` to choose a level"
        );
        Some(with_list(sentence, self.coarser.iter().skip(1).cloned()))
    }
}

/// Returns `level` if it is closed or no coarser level is, otherwise the finest closed level below
/// it. Flat outlines do not count.
fn closed_below(store: &Store, offers: &[Offer], level: Option<Lod>) -> Option<Lod> {
    let is_solid = |offer: &&Offer| offer.lod < level && offer.lod.is_some_and(|lod| !lod.is_flat());
    let mut coarser: Vec<&Offer> = offers.iter().filter(is_solid).collect();
    let Some(finest) = offers.iter().find(|offer| offer.lod == level) else { return level };
    if coarser.is_empty() || finest.is_closed(store) {
        return level;
    }
    coarser.sort_by_key(|offer| offer.lod);
    coarser.into_iter().rev().find(|offer| offer.is_closed(store)).map_or(level, |offer| offer.lod)
}

/// Returns the sides without windows and doors, because walls behind windows drawn upon them may be
/// closed.
fn without_openings(store: &Store, sides: &[Side]) -> Vec<Side> {
    let is_opening = |name: &str| ["Window", "Door"].contains(&name);
    let name = |side: &Side| {
        let number = store.polygon(side.polygon)?.name?;
        store.names.get(usize::from(number))
    };
    sides.iter().filter(|side| !name(side).is_some_and(|name| is_opening(name))).copied().collect()
}
