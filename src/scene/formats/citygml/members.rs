//! Resolution of references. In: members of a store. Out: polygons, each once, however many
//! references lead to it.

use std::collections::HashSet;
use std::ops::Range;

use crate::formats::citygml::store::{Place, Side, Store, Target};

/// Deepest chain of references; real ones take two steps, from a solid to a composite surface to a
/// polygon.
const DEEPEST: usize = 16;

/// Result of following members.
#[derive(Default)]
pub(super) struct Followed {
    pub sides: Vec<Side>,
    /// Indices of references to ids that are not in the store.
    pub missing: Vec<u32>,
    /// Number of references that go in circles or are too many.
    pub endless: usize,
}

/// Follows the references of members.
pub(super) fn follow(store: &Store, members: Range<u32>) -> Followed {
    let (mut found, mut seen) = (Followed::default(), HashSet::new());
    let mut steps = 1024 + 16 * store.members.len();
    // Ranges of members still to be visited, and whether they are reversed.
    let mut open = vec![(members, false)];
    while let Some((range, is_reversed)) = open.last_mut() {
        let Some(number) = range.next() else {
            open.pop();
            continue;
        };
        let Some(member) = store.members.get(number as usize) else { continue };
        let is_reversed = *is_reversed != member.is_reversed;
        match member.target {
            Target::Polygon(polygon) => {
                if seen.insert(polygon) {
                    found.sides.push(Side { polygon, is_reversed });
                }
            }
            Target::Reference(reference) => match local(store, reference) {
                None => found.missing.push(reference),
                Some(_) if open.len() >= DEEPEST || steps == 0 => found.endless += 1,
                Some(place) => open.push((place.members, is_reversed != place.is_reversed)),
            },
        }
        steps = steps.saturating_sub(1);
        if steps == 0 {
            found.endless += 1;
            break;
        }
    }
    found
}

/// Returns the members that a reference leads to.
fn local(store: &Store, reference: u32) -> Option<Place> {
    let id = store.references.get(reference as usize)?.strip_prefix('#')?;
    store.ids.get(id).cloned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a store of one polygon, `a`, and of composites: each is an id and the ids that it
    /// refers to.
    fn store(composites: &[(&str, &[&str])]) -> Store {
        let mut store = Store::default();
        let polygon = store.end_polygon(0, None, 1);
        store.push_polygon(polygon, false);
        store.ids.insert("a".into(), Place { members: 0..1, is_reversed: false });
        for (id, references) in composites {
            let start = store.member_count();
            references.iter().for_each(|href| store.refer(&format!("#{href}"), true));
            let members = start..store.member_count();
            store.ids.insert((*id).to_owned(), Place { members, is_reversed: false });
        }
        store
    }

    /// Two reversals cancel, a polygon counts once, and one reference of two leads nowhere.
    #[test]
    fn references_lead_to_polygons() {
        let store = store(&[("b", &["a", "nowhere"]), ("c", &["b", "b"])]);
        let found = follow(&store, store.ids["c"].members.clone());
        assert_eq!(found.sides, [Side { polygon: 0, is_reversed: false }]);
        assert_eq!((found.missing.len(), found.endless), (2, 0));
    }

    /// A circle of two ends after 16 steps. Composites that each refer ten times to the next end
    /// after a number of steps that grows with the file.
    #[test]
    fn endless_references_end() {
        let circle = store(&[("b", &["c"]), ("c", &["b"])]);
        assert_eq!(follow(&circle, circle.ids["b"].members.clone()).endless, 1);
        let names: Vec<String> = (0..12).map(|i| format!("n{i}")).collect();
        let mut composites = vec![];
        let references: Vec<Vec<&str>> = (1..12).map(|i| vec![names[i].as_str(); 10]).collect();
        for (name, references) in names.iter().zip(&references) {
            composites.push((name.as_str(), references.as_slice()));
        }
        composites.push(("n11", &["a"]));
        let bomb = store(&composites);
        assert!(follow(&bomb, bomb.ids["n0"].members.clone()).endless > 0);
    }
}
