//! Openings in a face. In: the rings of a face and of its openings. Out: the pieces of the face
//! that are left, and the openings that fit.

use glam::DVec3;

use crate::formats::building::frame::{Frame, area_vector};
use crate::formats::building::holes;
use crate::formats::building::holes::Fit;
use crate::formats::honeybee::surface::Rings;

/// Rest of a face after its openings are cut out.
pub(super) struct Leftover {
    /// The face with its holes, unless an opening takes up all of it, followed by the parts of the
    /// face within holes of openings.
    pub pieces: Vec<Rings>,
    /// True if an opening takes up the whole face.
    pub is_whole: bool,
    /// True for each opening that fits.
    pub fits: Vec<bool>,
}

/// Cuts openings out of a face. The part of the face within the hole of a window is a piece of its
/// own, and may have openings too.
pub(super) fn cut(face: Rings, frame: Frame, openings: &[Rings], rounded_m: f64) -> Leftover {
    let mut waiting: Vec<usize> = (0..openings.len()).collect();
    let area = |i: usize| openings.get(i).map_or(0.0, |rings| area_vector(&rings.outline).length());
    // Openings with holes come first, the largest first, because other openings may lie in their
    // holes.
    let is_plain = |i: usize| openings.get(i).is_none_or(|rings| rings.holes.is_empty());
    waiting.sort_by(|&a, &b| match (is_plain(a), is_plain(b)) {
        (false, false) => area(b).total_cmp(&area(a)),
        (a, b) => a.cmp(&b),
    });
    let mut left = Leftover { pieces: Vec::new(), is_whole: false, fits: vec![false; openings.len()] };
    let mut next = vec![face];
    while let Some(mut piece) = next.pop() {
        let inside: Vec<usize> = waiting
            .iter()
            .copied()
            .filter(|&i| openings.get(i).is_some_and(|rings| lies_within(&rings.outline, &piece.outline, rounded_m)))
            .collect();
        let outlines: Vec<&[DVec3]> =
            inside.iter().filter_map(|&i| openings.get(i)).map(|rings| rings.outline.as_slice()).collect();
        let wall = holes::Wall { outline: &piece.outline, holes: &piece.holes, frame, rounded_m };
        let found = holes::fit(&wall, &outlines);
        let mut is_whole = false;
        for (i, fit) in inside.into_iter().zip(found) {
            match fit {
                Fit::Hole(ring) => piece.holes.push(ring),
                Fit::Whole => is_whole = true,
                Fit::Beyond => continue,
            }
            waiting.retain(|other| *other != i);
            if let Some(fits) = left.fits.get_mut(i) {
                *fits = true;
            }
            let islands = openings.get(i).map_or(&[][..], |rings| rings.holes.as_slice());
            next.extend(islands.iter().map(|island| Rings { outline: island.clone(), holes: Vec::new() }.along(frame)));
        }
        if is_whole {
            left.is_whole = true;
        } else {
            left.pieces.push(piece);
        }
    }
    left
}

/// Returns true if the bounding box of one outline lies within that of another.
fn lies_within(inner: &[DVec3], outer: &[DVec3], rounded_m: f64) -> bool {
    let bounds = |ring: &[DVec3]| {
        let low = ring.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = ring.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        (low, high)
    };
    let ((low, high), (least, most)) = (bounds(inner), bounds(outer));
    low.cmpge(least - rounded_m).all() && high.cmple(most + rounded_m).all()
}
