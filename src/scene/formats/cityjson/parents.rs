//! Parents of city objects. In: parents and children as city objects name them. Out: the topmost
//! parent of each object.

use std::collections::HashMap;

use crate::formats::cityjson::document::{CityObject, Text};

/// Most steps upwards. Real models need three: a room of a storey of a part of a building. Hostile
/// ones go in circles.
const MAX_STEPS: usize = 16;

/// Parent of each object that has one, by name.
pub(super) struct Parents<'d>(HashMap<&'d str, &'d str>);

impl<'d> Parents<'d> {
    /// Collects the parents. An object's own statement overrides that of an object that names it as
    /// a child; the first of several parents counts.
    pub(super) fn new(objects: &'d [(Text, CityObject)]) -> Self {
        let mut parents = HashMap::new();
        for (id, object) in objects {
            for child in object.children.iter().flatten() {
                parents.insert(child.0.as_ref(), id.0.as_ref());
            }
        }
        for (id, object) in objects {
            if let Some(parent) = object.parents.iter().flatten().next() {
                parents.insert(id.0.as_ref(), parent.0.as_ref());
            }
        }
        Parents(parents)
    }

    /// Returns the topmost parent of an object, or the object itself if it has no parent.
    pub(super) fn top_of<'s>(&self, id: &'s str) -> &'s str
    where
        'd: 's,
    {
        let mut top = id;
        for _ in 0..MAX_STEPS {
            match self.0.get(top) {
                Some(&parent) if parent != top => top = parent,
                _ => break,
            }
        }
        top
    }
}
