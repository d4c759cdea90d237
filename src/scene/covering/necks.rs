//! Necks: places at which a surface is so narrow that the parts on both sides are surfaces of their
//! own. In: the surface's triangles along an axis. Out: the place to cut.
//!
//! A window as wide as its wall leaves a strip above and one below, connected by a sliver at each
//! side or by nothing. One receiver for both strips would stand on one of them.

/// Greatest width of a neck, as a share of the narrower of the two sides' greatest widths.
const NECK: f64 = 0.1;
/// Least share of the area on each side of a cut: less is not worth a receiver.
const MIN_SHARE: f64 = 0.02;
/// Distance below which two places are one, metres.
const SAME_M: f64 = 1e-6;
/// Most triangles of a surface that is searched for necks: surfaces of more triangles are hills.
const MAX_TRIANGLES: usize = 128;

/// Extent of a triangle along an axis: the places of its corners in order, and its area.
pub(super) struct Span {
    pub places: [f64; 3],
    pub area: f64,
}

impl Span {
    /// Returns the area before a place.
    pub(super) fn before(&self, at: f64) -> f64 {
        let [a, b, c] = self.places;
        match () {
            () if at <= a => 0.0,
            () if at >= c => self.area,
            () if at < b => self.area * (at - a) * (at - a) / ((b - a) * (c - a)),
            () => self.area * (1.0 - (c - at) * (c - at) / ((c - b) * (c - a)).max(f64::MIN_POSITIVE)),
        }
    }
}

/// A neck of a surface along an axis.
#[derive(Debug, PartialEq)]
pub(super) struct Neck {
    pub at: f64,
    /// Share of the area that lies before the cut.
    pub share: f64,
    /// Width of the surface at the cut, as a share of the narrower of the two sides' greatest
    /// widths.
    pub width: f64,
}

/// Returns the narrowest neck of a surface along an axis; the cut lies in the middle of the neck.
pub(super) fn narrowest(spans: &[Span]) -> Option<Neck> {
    if spans.len() > MAX_TRIANGLES {
        return None;
    }
    let mut places: Vec<f64> = spans.iter().flat_map(|span| span.places).collect();
    places.sort_unstable_by(f64::total_cmp);
    places.dedup_by(|later, kept| *later - *kept < SAME_M);
    let before: Vec<f64> = places.iter().map(|at| spans.iter().map(|span| span.before(*at)).sum()).collect();
    let total: f64 = spans.iter().map(|span| span.area).sum();
    let slabs: Vec<([f64; 2], [f64; 2])> = places
        .iter()
        .zip(places.iter().skip(1))
        .zip(before.iter().zip(before.iter().skip(1)))
        .map(|((from, to), (less, more))| ([*from, *to], [*less, *more]))
        .collect();
    let width = |([from, to], [less, more]): &([f64; 2], [f64; 2])| (more - less).max(0.0) / (to - from);
    let widest = |some: &[([f64; 2], [f64; 2])]| some.iter().map(width).fold(0.0, f64::max);
    let mut found: Option<Neck> = None;
    for (i, slab) in slabs.iter().enumerate() {
        let sides = slabs.get(..i).map_or(0.0, widest).min(slabs.get(i + 1..).map_or(0.0, widest));
        let neck = Neck {
            at: 0.5 * (slab.0[0] + slab.0[1]),
            share: 0.5 * (slab.1[0] + slab.1[1]) / total,
            width: width(slab) / sides.max(f64::MIN_POSITIVE),
        };
        let divides = (MIN_SHARE..=1.0 - MIN_SHARE).contains(&neck.share) && neck.width <= NECK;
        // Narrower by more than rounding, so that the choice between equal necks is stable.
        if divides && found.as_ref().is_none_or(|other| neck.width < other.width - 1e-9) {
            found = Some(neck);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns both triangles of a rectangle of width `wide` from `from` to `to`.
    fn rectangle(from: f64, to: f64, wide: f64) -> [Span; 2] {
        let area = 0.5 * (to - from) * wide;
        [Span { places: [from, from, to], area }, Span { places: [from, to, to], area }]
    }

    /// Strips of 10 m from 0 to 1 and from 3 to 3.5 that a strip of 1 m, 1 mm or 0 m connects are
    /// cut at 2, with the share (10 + w) / (15 + 2 w) of the area before; a strip of 1.2 m is no
    /// neck.
    #[test]
    fn strips_on_a_narrow_neck_are_cut_apart() {
        for (wide, is_neck) in [(0.0, true), (0.001, true), (1.0, true), (1.2, false)] {
            let spans: Vec<Span> = [rectangle(0.0, 1.0, 10.0), rectangle(1.0, 3.0, wide), rectangle(3.0, 3.5, 10.0)]
                .into_iter()
                .flatten()
                .collect();
            let found = narrowest(&spans);
            assert_eq!(found.is_some(), is_neck, "{wide}");
            let Some(neck) = found else { continue };
            let share = (10.0 + wide) / (15.0 + 2.0 * wide);
            assert!((neck.at - 2.0).abs() < 1e-12 && (neck.share - share).abs() < 1e-12, "{neck:?}");
        }
    }
}
