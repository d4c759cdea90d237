//! Geometry shared by objects. In: geometry with ids, as it is read. Out: the geometry for the
//! objects that refer to it: templates of trees, walls of neighbours.

use std::collections::{HashMap, HashSet};

use crate::formats::citygml::members::follow;
use crate::formats::citygml::scan::Draft;
use crate::formats::citygml::store::{Lifted, Store};

/// Most corners that are kept, and most corners of objects that wait for referenced geometry: some
/// 200 MB.
const MAX_CORNERS: u64 = 1 << 22;
/// Most ids that are waited for.
const MAX_IDS: usize = 1 << 18;

/// Geometry that several objects refer to.
#[derive(Default)]
pub(super) struct Library {
    kept: HashMap<String, Lifted>,
    corners: u64,
    /// Ids that objects refer to and that were not found yet.
    wanted: HashSet<String>,
    /// Objects that refer to geometry that comes later, or came before and was not kept.
    waiting: Vec<Draft>,
    waiting_corners: u64,
}

impl Library {
    /// Keeps the templates of an object. A template that several objects share stands in the first
    /// of them.
    pub(super) fn keep_templates(&mut self, draft: &Draft) {
        let pieces = draft.features.iter().flat_map(|feature| &feature.pieces);
        let templates: Vec<_> = pieces.filter(|piece| piece.instance.is_some()).map(|piece| &piece.members).collect();
        if templates.is_empty() {
            return;
        }
        for (id, place) in &draft.store.ids {
            if templates.iter().any(|members| **members == place.members) {
                self.keep(id, &draft.store);
            }
        }
    }

    /// Keeps the geometry of the object that other objects wait for.
    pub(super) fn keep_wanted(&mut self, draft: &Draft) {
        let met: Vec<String> = draft.store.ids.keys().filter(|id| self.wanted.contains(*id)).cloned().collect();
        for id in met {
            self.keep(&id, &draft.store);
        }
    }

    fn keep(&mut self, id: &str, store: &Store) {
        let Some(place) = store.ids.get(id).filter(|_| !self.kept.contains_key(id)) else { return };
        let mut sides = follow(store, place.members.clone()).sides;
        sides.iter_mut().for_each(|side| side.is_reversed ^= place.is_reversed);
        let lifted = store.lift(&sides);
        let corners = self.corners + lifted.corners();
        if !sides.is_empty() && corners <= MAX_CORNERS {
            self.corners = corners;
            self.kept.insert(id.to_owned(), lifted);
        }
    }

    /// Copies into an object the geometry that it refers to, where known; returns the ids that are
    /// not known.
    pub(super) fn supply(&self, draft: &mut Draft) -> Vec<String> {
        let mut missing = Vec::new();
        let referred: HashSet<&str> = draft.store.references.iter().filter_map(|href| href.strip_prefix('#')).collect();
        let unknown: Vec<String> =
            referred.into_iter().filter(|id| !draft.store.ids.contains_key(*id)).map(str::to_owned).collect();
        for id in unknown {
            match self.kept.get(&id) {
                Some(lifted) => {
                    let start = draft.store.put(lifted, |vertex| vertex).start;
                    draft.store.set_place(&id, start, false);
                }
                None => missing.push(id),
            }
        }
        missing
    }

    /// Puts an object aside until the geometry that it refers to is read; returns it if too many
    /// objects wait already.
    pub(super) fn wait(&mut self, draft: Draft, missing: Vec<String>) -> Option<Draft> {
        let corners = self.waiting_corners + u64::from(draft.store.corner_count());
        if corners > MAX_CORNERS || self.wanted.len() + missing.len() > MAX_IDS {
            return Some(draft);
        }
        self.waiting_corners = corners;
        self.wanted.extend(missing);
        self.waiting.push(draft);
        None
    }

    pub(super) fn has_waiting(&self) -> bool {
        !self.waiting.is_empty()
    }

    pub(super) fn take_waiting(&mut self) -> Vec<Draft> {
        std::mem::take(&mut self.waiting)
    }
}
