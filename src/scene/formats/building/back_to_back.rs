//! In: outlines of surfaces that do not state what lies behind them. Out: the surfaces that
//! separate two rooms, each of which has its other side in the list.

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use crate::formats::building::frame::area_vector;

/// Most surfaces that are compared in one half-metre cell.
const MAX_ALIKE: usize = 64;

/// Returns the indices of the outlines that lie back to back.
pub(in crate::formats) fn back_to_back<'o>(outlines: impl Iterator<Item = (usize, &'o [DVec3])>) -> HashSet<usize> {
    // Centres are rounded to half metres: the two outlines of a pair come from one drawing.
    let mut at: HashMap<_, Vec<(usize, DVec3)>> = HashMap::new();
    for (i, outline) in outlines {
        let centre = outline.iter().sum::<DVec3>() / outline.len().max(1) as f64;
        let group = at.entry((centre * 2.0).round().as_i64vec3()).or_default();
        if group.len() < MAX_ALIKE {
            group.push((i, area_vector(outline)));
        }
    }
    let mut found = HashSet::new();
    for group in at.into_values() {
        for (n, (i, a)) in group.iter().enumerate() {
            for (j, b) in group.iter().skip(n + 1) {
                // The area vectors of two equal faces that look in opposite directions cancel.
                if (*a + *b).length() < 0.02 * a.length() {
                    found.extend([*i, *j]);
                }
            }
        }
    }
    found
}
