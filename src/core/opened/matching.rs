//! Matching of the receivers of two archives. In: names, places and normals of the two sides. Out:
//! pairs, and the unmatched receivers of each side. Never: files, archives, light.

use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};

use glam::DVec3;

use crate::site::receiver::Receiver;

/// Largest distance between receivers at one place, metres.
pub const SAME_PLACE_M: f64 = 0.01;

/// Largest angle between normals that count as equal, degrees.
pub const SAME_NORMAL_DEG: f64 = 0.5;

/// Bound on the rounding of coordinates of 1e7 m, metres.
const ROUNDING_M: f64 = 1e-8;

/// Edge of the cells that receivers are looked up in, metres: some [`SAME_PLACE_M`], so that most
/// searches read one cell.
const CELL_M: f64 = 0.1;

/// Name, place and normal by which a receiver is matched.
#[derive(Clone, Debug, PartialEq)]
pub struct ReceiverPlace {
    /// Name of the receiver.
    pub id: String,
    /// Position, metres; the two sides have one coordinate system.
    pub position: DVec3,
    /// Normal of unit length.
    pub normal: DVec3,
}

/// A receiver that exists on the two sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReceiverPair {
    /// Index among the receivers before.
    pub before: usize,
    /// Index among the receivers after.
    pub after: usize,
    /// True if only the name matches: the receiver stands at another place, or faces another way.
    pub is_moved: bool,
}

/// Receivers of two sides in pairs, and those without a partner.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReceiverMatching {
    /// Receivers that exist on the two sides, in the order before. No receiver stands in two pairs.
    pub pairs: Vec<ReceiverPair>,
    /// Indices of the receivers that exist before only, ascending.
    pub only_before: Vec<usize>,
    /// Indices of the receivers that exist after only, ascending.
    pub only_after: Vec<usize>,
}

impl ReceiverMatching {
    /// Matches the receivers of two sides, one to one:
    /// 1. receivers of equal name, place ([`SAME_PLACE_M`]) and normal ([`SAME_NORMAL_DEG`]);
    /// 2. receivers of equal place and normal, whatever their names (an edit may number them anew),
    ///    the nearest first;
    /// 3. receivers of equal name at another place, which count as moved.
    ///
    /// The pairs depend on the order of the receivers only where distances are equal: the earlier
    /// ones are then matched first.
    pub fn new(before: &[ReceiverPlace], after: &[ReceiverPlace]) -> Self {
        let mut search = Search {
            before,
            after,
            partner: vec![None; before.len()],
            is_taken: vec![false; after.len()],
            by_name: HashMap::with_capacity(after.len()),
        };
        for (number, place) in after.iter().enumerate() {
            search.by_name.entry(place.id.as_str()).or_insert(number);
        }
        search.by_name(false);
        search.by_equal_place();
        search.by_near_place();
        search.by_name(true);
        search.matching()
    }

    /// Returns the number of pairs that only the name makes.
    pub fn moved(&self) -> usize {
        self.pairs.iter().filter(|pair| pair.is_moved).count()
    }
}

impl From<&Receiver> for ReceiverPlace {
    fn from(receiver: &Receiver) -> Self {
        ReceiverPlace { id: receiver.id.clone(), position: receiver.position, normal: receiver.normal }
    }
}

impl ReceiverPlace {
    /// Returns the distance to another receiver, metres, if the two have one place and one normal.
    fn distance_m(&self, other: &ReceiverPlace) -> Option<f64> {
        let distance_m = self.position.distance(other.position);
        let is_near = distance_m <= SAME_PLACE_M + ROUNDING_M;
        (is_near && self.normal.dot(other.normal) >= SAME_NORMAL_DEG.to_radians().cos()).then_some(distance_m)
    }

    /// Returns all bits of place and normal; -0 counts as 0.
    fn bits(&self) -> [u64; 6] {
        let [x, y, z] = self.position.to_array();
        let [nx, ny, nz] = self.normal.to_array();
        [x, y, z, nx, ny, nz].map(|number| (number + 0.0).to_bits())
    }

    fn cell(&self) -> [i64; 3] {
        cell_of(self.position)
    }
}

fn cell_of(position: DVec3) -> [i64; 3] {
    // `as` saturates: numbers beyond 64 bits share a cell, and distances tell them apart.
    position.to_array().map(|along| (along / CELL_M).floor() as i64)
}

/// A matching under way.
struct Search<'p> {
    before: &'p [ReceiverPlace],
    after: &'p [ReceiverPlace],
    /// `[before]`: its partner, if it has one.
    partner: Vec<Option<Partner>>,
    /// `[after]`: true if it has a partner.
    is_taken: Vec<bool>,
    by_name: HashMap<&'p str, usize>,
}

#[derive(Clone, Copy)]
struct Partner {
    after: usize,
    is_moved: bool,
}

/// A possible pair. The greatest is the nearest, of equal ones the earliest.
struct Candidate {
    distance_m: f64,
    before: usize,
    after: usize,
}

impl<'p> Search<'p> {
    /// Matches receivers of equal names: at one place, or at any place if `is_moved`.
    fn by_name(&mut self, is_moved: bool) {
        for (number, place) in self.before.iter().enumerate() {
            let Some(&after) = self.by_name.get(place.id.as_str()) else { continue };
            if self.is_free(number, after) && (is_moved || place.distance_m(&self.after[after]).is_some()) {
                self.pair(number, Partner { after, is_moved });
            }
        }
    }

    /// Matches receivers that agree in each bit of place and normal.
    fn by_equal_place(&mut self) {
        let mut places: HashMap<[u64; 6], Vec<usize>> = HashMap::new();
        for (number, place) in self.free_after().rev().filter(|(_, place)| place.position.is_finite()) {
            places.entry(place.bits()).or_default().push(number);
        }
        for (number, place) in self.before.iter().enumerate() {
            if self.partner[number].is_none()
                && let Some(after) = places.get_mut(&place.bits()).and_then(Vec::pop)
            {
                self.pair(number, Partner { after, is_moved: false });
            }
        }
    }

    /// Matches receivers that are near enough, the nearest first.
    fn by_near_place(&mut self) {
        let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
        for (number, place) in self.free_after() {
            cells.entry(place.cell()).or_default().push(number);
        }
        if cells.is_empty() {
            return;
        }
        let open = (0..self.before.len()).filter(|number| self.partner[*number].is_none());
        let mut nearest: BinaryHeap<Candidate> = open.filter_map(|number| self.nearest(number, &cells)).collect();
        while let Some(Candidate { before, after, .. }) = nearest.pop() {
            if self.is_free(before, after) {
                self.pair(before, Partner { after, is_moved: false });
            } else {
                // Another receiver took it: try the next of the free ones.
                nearest.extend(self.nearest(before, &cells));
            }
        }
    }

    /// Returns the nearest receiver without a partner at the place of `before`.
    fn nearest(&self, before: usize, cells: &HashMap<[i64; 3], Vec<usize>>) -> Option<Candidate> {
        let place = &self.before[before];
        let reach = DVec3::splat(SAME_PLACE_M + ROUNDING_M);
        let [low, high] = [place.position - reach, place.position + reach].map(cell_of);
        let along = |axis: usize| low[axis]..=high[axis].min(low[axis].saturating_add(1));
        let around = along(0).flat_map(|x| along(1).flat_map(move |y| along(2).map(move |z| [x, y, z])));
        let near = around.filter_map(|cell| cells.get(&cell)).flatten();
        let free = near.filter(|after| !self.is_taken[**after]);
        let candidate = |&after: &usize| {
            place.distance_m(&self.after[after]).map(|distance_m| Candidate { distance_m, before, after })
        };
        free.filter_map(candidate).max()
    }

    fn free_after(&self) -> impl DoubleEndedIterator<Item = (usize, &'p ReceiverPlace)> {
        self.after.iter().enumerate().filter(|(number, _)| !self.is_taken[*number])
    }

    fn is_free(&self, before: usize, after: usize) -> bool {
        self.partner[before].is_none() && !self.is_taken[after]
    }

    fn pair(&mut self, before: usize, partner: Partner) {
        self.partner[before] = Some(partner);
        self.is_taken[partner.after] = true;
    }

    fn matching(self) -> ReceiverMatching {
        let mut matching = ReceiverMatching::default();
        for (before, partner) in self.partner.iter().enumerate() {
            match partner {
                Some(Partner { after, is_moved }) => {
                    matching.pairs.push(ReceiverPair { before, after: *after, is_moved: *is_moved });
                }
                None => matching.only_before.push(before),
            }
        }
        let left = self.is_taken.iter().enumerate().filter(|(_, is_taken)| !**is_taken);
        matching.only_after = left.map(|(number, _)| number).collect();
        matching
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_distance = other.distance_m.total_cmp(&self.distance_m);
        by_distance.then_with(|| (other.before, other.after).cmp(&(self.before, self.after)))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Candidate {}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(id: &str, [x, y, z]: [f64; 3], normal: DVec3) -> ReceiverPlace {
        ReceiverPlace { id: id.into(), position: DVec3::new(x, y, z), normal: normal.normalize() }
    }

    fn flat(id: &str, x: f64) -> ReceiverPlace {
        place(id, [85_000.0 + x, 446_000.0, 3.0], DVec3::Z)
    }

    fn pairs(matching: &ReceiverMatching) -> Vec<[usize; 2]> {
        matching.pairs.iter().map(|pair| [pair.before, pair.after]).collect()
    }

    /// One of 4 receivers goes, one comes in front, and the names are numbered anew: 3 pairs by
    /// place, none moved, 1 left on either side.
    #[test]
    fn names_may_be_numbered_anew() {
        let before = ["r1", "r2", "r3", "r4"].into_iter().zip([1.0, 2.0, 3.0, 4.0]).map(|(id, x)| flat(id, x));
        let after = ["r1", "r2", "r3", "r4"].into_iter().zip([0.0, 1.0, 2.0, 4.0]).map(|(id, x)| flat(id, x));
        let found = ReceiverMatching::new(&before.collect::<Vec<_>>(), &after.collect::<Vec<_>>());
        assert_eq!(pairs(&found), [[0, 1], [1, 2], [3, 3]]);
        assert_eq!((found.moved(), found.only_before, found.only_after), (0, vec![2], vec![0]));
    }

    /// A receiver 9 mm and 0.4 degrees away counts as the same: 1 pair. A receiver 11 mm or 0.6
    /// degrees away is matched by its name only and counts as moved: 2 pairs.
    #[test]
    fn places_are_equal_within_a_centimetre_and_half_a_degree() {
        let tilted = |degrees: f64| DVec3::new(degrees.to_radians().tan(), 0.0, 1.0);
        let before = [flat("a", 0.0), flat("b", 10.0), flat("c", 20.0), flat("d", 30.0)];
        let after = [
            place("a", [85_000.009, 446_000.0, 3.0], tilted(0.4)),
            place("b", [85_010.011, 446_000.0, 3.0], DVec3::Z),
            place("c", [85_020.0, 446_000.0, 3.0], tilted(0.6)),
            place("e", [85_030.011, 446_000.0, 3.0], DVec3::Z),
        ];
        let found = ReceiverMatching::new(&before, &after);
        let is_moved: Vec<bool> = found.pairs.iter().map(|pair| pair.is_moved).collect();
        assert_eq!((pairs(&found), is_moved), (vec![[0, 0], [1, 1], [2, 2]], vec![false, true, true]));
        assert_eq!((found.moved(), found.only_before, found.only_after), (2, vec![3], vec![3]));
    }

    /// The nearest of several receivers is taken, each once, across the edges of cells, and of
    /// equal distances the earlier: 3 pairs, in either order of the receivers after.
    #[test]
    fn the_nearest_is_taken_first() {
        let before = [flat("a", 0.099), flat("b", 0.104), flat("c", 7.0)];
        let mut after = vec![flat("x", 0.1045), flat("y", 0.1), flat("z", 7.004), flat("w", 7.004)];
        let found = ReceiverMatching::new(&before, &after);
        assert_eq!((pairs(&found), &found.only_after), (vec![[0, 1], [1, 0], [2, 2]], &vec![3]));
        after.swap(0, 1);
        assert_eq!(pairs(&ReceiverMatching::new(&before, &after)), [[0, 0], [1, 1], [2, 2]]);
    }

    /// The two sides of a wall stand at one place and are told apart by their normals, though their
    /// names are exchanged: 2 pairs.
    #[test]
    fn sides_are_told_apart() {
        let before = [place("in", [0.0; 3], DVec3::X), place("out", [0.0; 3], DVec3::NEG_X)];
        let after = [place("in", [0.0; 3], DVec3::NEG_X), place("out", [0.0; 3], DVec3::X)];
        assert_eq!(pairs(&ReceiverMatching::new(&before, &after)), [[0, 1], [1, 0]]);
    }

    /// No receivers, repeated names, NaN and infinities do not panic. Of 3 places that are no
    /// numbers and have other names none is matched.
    #[test]
    fn odd_places_do_not_panic() {
        let odd = |id: &str| {
            [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].map(|x| place(&format!("{id}{x}"), [x, 1e300, 0.0], DVec3::Z))
        };
        let empty = ReceiverMatching::new(&[], &odd("a"));
        assert_eq!((empty.pairs.len(), empty.only_after), (0, vec![0, 1, 2]));
        let twice = [flat("a", 0.0), flat("a", 1.0), flat("a", 2.0)];
        assert_eq!(pairs(&ReceiverMatching::new(&twice, &twice)), [[0, 0], [1, 1], [2, 2]]);
        assert_eq!(ReceiverMatching::new(&odd("a"), &odd("b")).only_before.len(), 3);
    }

    /// 70,000 receivers that are renamed and moved by 3 mm are matched with themselves, and 70,000
    /// at one place with one other each, in under 5 s.
    #[test]
    fn many_receivers_are_matched_in_seconds() {
        let begun = std::time::Instant::now();
        let grid = |shift: f64, name: &str| -> Vec<ReceiverPlace> {
            let at = |i: usize| [(i % 264) as f64 * 0.5 + shift, (i / 264) as f64 * 0.5, 0.0];
            (0..70_000).map(|i| place(&format!("{name}{i}"), at(i), DVec3::Z)).collect()
        };
        let found = ReceiverMatching::new(&grid(0.0, "a"), &grid(0.003, "b"));
        assert!(found.pairs.len() == 70_000 && found.pairs.iter().all(|pair| pair.before == pair.after));
        let heap =
            |name: &str| -> Vec<ReceiverPlace> { (0..70_000).map(|i| flat(&format!("{name}{i}"), 0.0)).collect() };
        assert_eq!(ReceiverMatching::new(&heap("a"), &heap("b")).pairs.len(), 70_000);
        assert!(begun.elapsed().as_secs_f64() < 5.0, "{:?}", begun.elapsed());
    }
}
