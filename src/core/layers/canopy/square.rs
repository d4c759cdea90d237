//! Coding of what rays cross along the square of a receiver's sky rays: crossings of screens, or
//! codes of lengths in volumes of leaves. In: codes by ray. Out: bytes, and back.
//!
//! Each code is predicted from codes that are known before it. On a coarse grid these are the
//! neighbours to the left and in the row before. Then the grid is halved until it is the square.
//! Each time, a texel between known ones is predicted by the two or four around it; builders cast
//! no ray there and store the prediction where these differ little. What is left is coded by rANS
//! in contexts: by how much the neighbours differ, and by how many are 0.

use super::{COUNTS, LARGEST};
use crate::layers::rans::{self, Encoder, Histogram, Reader, STATES, SymbolTables};

/// Most texels of the coarse grid a side; texels are then 1.4 degrees apart or less.
const COARSE: usize = 128;

/// Number of texels of the coarse grid a side of a patch. Only patches with a code above 0 are
/// coded.
const PATCH: usize = 8;

/// Fewest bytes for each coded patch. A patch of a square of 1024 texels a side has 4096 texels, so
/// a reader allocates at most 1024 bytes for each byte that it reads.
pub const MIN_OF_PATCH: usize = 8;

/// Differences of neighbours at which the next context begins: for texels of the coarse grid, for
/// what lies between known texels, and for texels between them that are not as predicted.
const OF_COARSE: [u32; 3] = [4, 12, 40];
const OF_BETWEEN: [u32; 4] = [10, 18, 32, 64];
const OF_OTHERS: [u32; 3] = [8, 24, 80];

/// First contexts of texels of the coarse grid, of what lies between known texels, and of texels
/// between them that are not as predicted. Each begins with two contexts: all neighbours are 0, and
/// some are.
const ON_COARSE: usize = 0;
const BETWEEN: usize = ON_COARSE + 3 + OF_COARSE.len();
const OTHERS: usize = BETWEEN + 3 + OF_BETWEEN.len();
const CONTEXTS: usize = OTHERS + 3 + OF_OTHERS.len();

/// Returns the number of texels of a square between two texels of its coarse grid: the smallest
/// power of two above 1 at which the grid has at most 128 texels a side. The side of a square that
/// is coded is a multiple of it.
pub fn coarse_step(side: usize) -> usize {
    side.div_ceil(COARSE).next_power_of_two().max(2)
}

/// Returns the side of a square of `rays` rays whose codes can be predicted.
pub fn side_of(rays: usize) -> Option<usize> {
    let side = rays.isqrt();
    (side * side == rays && (1..=LARGEST).contains(&side) && side.is_multiple_of(coarse_step(side))).then_some(side)
}

/// Returns the bytes of a square of codes, below [`COUNTS`], row-major; `None` if the codes cannot
/// be predicted or the bytes would be fewer than the coded patches need.
pub fn encode(codes: &[u16]) -> Option<Vec<u8>> {
    let mut square = Square::new(codes.to_vec(), side_of(codes.len())?);
    let patches = Patches::of(codes, square.side);
    let mut coder = EncodedValues(Encoder::new(CONTEXTS));
    square.visit(&patches, &mut coder)?;
    let bytes = [patches.to_bytes(), coder.0.finish()].concat();
    (bytes.len() >= MIN_OF_PATCH * patches.count()).then_some(bytes)
}

/// Reads the bytes of [`encode`] for a square of `rays` codes. Returns `None` if the bytes are
/// anything else.
pub fn decode(bytes: &[u8], rays: usize) -> Option<Vec<u16>> {
    let side = side_of(rays)?;
    let (mask, stream) = bytes.split_at_checked(Patches::bytes(side))?;
    let patches = Patches::from_bytes(mask, side)?;
    if bytes.len() < MIN_OF_PATCH * patches.count() {
        return None;
    }
    let (tables, reader) = rans::open(CONTEXTS, stream)?;
    let mut coder = DecodedValues { tables, reader, seen: Histogram::new(CONTEXTS) };
    let mut square = Square::new(vec![0; rays], side);
    square.visit(&patches, &mut coder)?;
    // Equal codes have equal bytes: patches have codes above 0, and frequencies are those of the
    // values.
    let whole = coder.reader.is_done() && stream.starts_with(&coder.seen.to_bytes());
    (whole && Patches::of(&square.codes, side) == patches).then_some(square.codes)
}

/// Patches of a square that are coded.
#[derive(PartialEq)]
struct Patches {
    /// Number of patches a side.
    side: usize,
    /// Number of texels a side of the coarse grid.
    coarse: usize,
    /// `[patch]`, row-major: true if some code is above 0.
    coded: Vec<bool>,
}

impl Patches {
    /// Returns the patches with a code above 0.
    fn of(codes: &[u16], square: usize) -> Self {
        let (coarse, wide) = (square / coarse_step(square), PATCH * coarse_step(square));
        let side = coarse.div_ceil(PATCH);
        let mut coded = vec![false; side * side];
        for (row, line) in codes.chunks_exact(square).enumerate() {
            for (patch, texels) in line.chunks(wide).enumerate() {
                coded[row / wide * side + patch] |= texels.iter().fold(0, |any, code| any | code) > 0;
            }
        }
        Patches { side, coarse, coded }
    }

    /// Returns the number of bytes of the patches of a square.
    fn bytes(square: usize) -> usize {
        (square / coarse_step(square)).div_ceil(PATCH).pow(2).div_ceil(8)
    }

    fn to_bytes(&self) -> Vec<u8> {
        let byte = |eight: &[bool]| eight.iter().rev().fold(0, |byte, &coded| byte << 1 | u8::from(coded));
        self.coded.chunks(8).map(byte).collect()
    }

    fn from_bytes(bytes: &[u8], square: usize) -> Option<Self> {
        let coarse = square / coarse_step(square);
        let side = coarse.div_ceil(PATCH);
        let coded = (0..side * side).map(|patch| bytes[patch / 8] >> (patch % 8) & 1 == 1).collect();
        let patches = Patches { side, coarse, coded };
        (patches.to_bytes() == bytes).then_some(patches)
    }

    fn count(&self) -> usize {
        self.coded.iter().filter(|coded| **coded).count()
    }

    /// Returns the columns of the known texels of a row that lie in coded patches, on a grid with
    /// `fine` texels a side for each of the coarse grid.
    fn columns(&self, row: usize, fine: usize) -> impl Iterator<Item = usize> + '_ {
        let (wide, grid) = (PATCH * fine, self.coarse * fine);
        let of_row = &self.coded[row / wide * self.side..][..self.side];
        let coded = of_row.iter().enumerate().filter(|(_, coded)| **coded);
        coded.flat_map(move |(patch, _)| wide * patch..(wide * (patch + 1)).min(grid))
    }
}

/// Place where values are put or taken from.
trait Values {
    /// Codes `known`, and returns it; or returns what is read in its place.
    fn value(&mut self, context: usize, state: usize, known: u32) -> u32;
}

struct EncodedValues(Encoder);

impl Values for EncodedValues {
    fn value(&mut self, context: usize, state: usize, known: u32) -> u32 {
        self.0.put(context, state, known);
        known
    }
}

struct DecodedValues<'a> {
    tables: SymbolTables,
    reader: Reader<'a>,
    seen: Histogram,
}

impl Values for DecodedValues<'_> {
    #[inline(always)]
    fn value(&mut self, context: usize, state: usize, _: u32) -> u32 {
        let value = self.reader.take(&self.tables, context, state);
        self.seen.add(context, value);
        value
    }
}

/// Codes of a square while it is coded.
struct Square {
    /// Number of texels a side.
    side: usize,
    /// Number of texels from a known texel to the next.
    step: usize,
    /// `[row + 1][column + 1]`: known texels with a border of 0.
    known: Vec<u16>,
    /// `[row][column]`: all texels.
    codes: Vec<u16>,
}

impl Square {
    /// Takes a square whose coarse grid is to be coded first.
    fn new(codes: Vec<u16>, side: usize) -> Self {
        let mut square = Square { side, step: coarse_step(side), known: Vec::new(), codes };
        square.know();
        square
    }

    /// Returns the number of known texels a side.
    fn grid(&self) -> usize {
        self.side / self.step
    }

    /// Takes the texels of the current step for known.
    fn know(&mut self) {
        let grid = self.grid();
        self.known.clear();
        self.known.resize((grid + 1) * (grid + 2), 0);
        for (row, line) in self.known.chunks_exact_mut(grid + 2).skip(1).enumerate() {
            let of_row = self.codes[row * self.step * self.side..].iter().step_by(self.step);
            line[1..=grid].iter_mut().zip(of_row).for_each(|(known, code)| *known = *code);
        }
    }

    /// Puts all codes into an encoder, or takes them from a decoder. Returns `None` if a value is
    /// no code.
    #[inline(always)]
    fn visit(&mut self, patches: &Patches, coder: &mut impl Values) -> Option<()> {
        for row in 0..self.grid() {
            for column in patches.columns(row, 1) {
                self.visit_coarse(row, column, coder)?;
            }
        }
        loop {
            let (grid, fine) = (self.grid(), self.grid() / patches.coarse);
            for row in 0..grid {
                for column in patches.columns(row, fine) {
                    self.visit_between(row, column, coder)?;
                }
            }
            self.step /= 2;
            if self.step == 1 {
                return Some(());
            }
            self.know();
        }
    }

    /// Codes a texel of the coarse grid: 0 as 0, others by their distance from the prediction. The
    /// prediction is the median edge detector of LOCO-I (Weinberger, Seroussi and Sapiro 2000,
    /// equation 1).
    #[inline(always)]
    fn visit_coarse(&mut self, row: usize, column: usize, coder: &mut impl Values) -> Option<()> {
        let wide = self.grid() + 2;
        let at = (row + 1) * wide + column + 1;
        let [west, north_west, north, north_east] =
            [at - 1, at - wide - 1, at - wide, at - wide + 1].map(|at| u32::from(self.known[at]));
        let (low, high) = (west.min(north), west.max(north));
        let predicted = (west + north).saturating_sub(north_west).clamp(low, high).max(1);
        let apart = west.abs_diff(north_west) + north.abs_diff(north_west) + north_east.abs_diff(north);
        let context = ON_COARSE + kind_of([west, north_west, north, north_east], || apart, &OF_COARSE);
        let own = u32::from(self.known[at]);
        let known = if own == 0 { 0 } else { 1 + fold(own, predicted) };
        let code = match coder.value(context, column % STATES, known) {
            0 => 0,
            folded => unfold(folded - 1, predicted)?,
        };
        self.known[at] = code;
        self.codes[self.step * (row * self.side + column)] = code;
        Some(())
    }

    /// Codes the three texels halfway to the known ones to the right, below, and below on the
    /// right: first which of them are not as predicted, then these. Known texels beyond the border
    /// count as those at it.
    #[inline(always)]
    fn visit_between(&mut self, row: usize, column: usize, coder: &mut impl Values) -> Option<()> {
        let (grid, half) = (self.grid(), self.step / 2);
        let wide = grid + 2;
        let right = (column + 1).min(grid - 1);
        let below = (row + 1).min(grid - 1);
        let [a, b, c, d] = [(row, column), (row, right), (below, column), (below, right)]
            .map(|(row, column)| u32::from(self.known[(row + 1) * wide + column + 1]));
        let first = self.step * (row * self.side + column);
        let places = [first + half, first + half * self.side, first + half * (self.side + 1)];
        let predicted = [mean([a, b]), mean([a, c]), mean([a, b, c, d])];
        let differ = (0..3).filter(|&i| u32::from(self.codes[places[i]]) != predicted[i]);
        let known = differ.fold(0, |others, i| others | 1 << i);
        let context = BETWEEN + kind_of([a, b, c, d], || range([a, b, c, d]), &OF_BETWEEN);
        let others = coder.value(context, column % STATES, known);
        if others == 0 {
            for (place, predicted) in places.into_iter().zip(predicted) {
                self.codes[place] = predicted as u16;
            }
            return Some(());
        }
        if others > 7 {
            return None;
        }
        let kinds = [
            kind_of([a, b], || range([a, b]), &OF_OTHERS),
            kind_of([a, c], || range([a, c]), &OF_OTHERS),
            kind_of([a, b, c, d], || range([a, b, c, d]), &OF_OTHERS),
        ];
        for (i, kind) in kinds.into_iter().enumerate() {
            let (place, predicted) = (places[i], predicted[i]);
            let mut code = predicted as u16;
            if others >> i & 1 == 1 {
                let own = u32::from(self.codes[place]);
                let known = if own == 0 { 0 } else { fold(own, predicted) };
                code = match coder.value(OTHERS + kind, column % STATES, known) {
                    0 if predicted == 0 => return None,
                    0 => 0,
                    folded => unfold(folded, predicted)?,
                };
            }
            self.codes[place] = code;
        }
        Some(())
    }
}

/// Returns the context of a texel among those of its sort: 0 if all neighbours are 0, 1 if some
/// are, else 2 and the number of thresholds that `apart` reaches.
#[inline(always)]
fn kind_of<const N: usize>(neighbours: [u32; N], apart: impl Fn() -> u32, thresholds: &[u32]) -> usize {
    if neighbours.iter().all(|code| *code > 0) {
        let apart = apart();
        return 2 + thresholds.iter().filter(|threshold| apart >= **threshold).count();
    }
    usize::from(neighbours.iter().any(|code| *code > 0))
}

/// Returns the difference between the largest and the smallest of some codes.
#[inline(always)]
fn range<const N: usize>(codes: [u32; N]) -> u32 {
    codes.iter().fold(0, |most, code| most.max(*code)) - codes.iter().fold(u32::MAX, |least, code| least.min(*code))
}

/// Returns the mean of the codes above 0, rounded to the nearest whole number, halves up; 0 if
/// there are none.
#[inline(always)]
fn mean<const N: usize>(codes: [u32; N]) -> u32 {
    mean_code(codes.iter().sum(), codes.iter().filter(|code| **code > 0).count() as u32)
}

/// Returns the mean of 1 to 4 codes of a sum, rounded to the nearest whole number, halves up; 0 for
/// no codes.
#[inline(always)]
pub fn mean_code(sum: u32, count: u32) -> u32 {
    match count {
        0 => 0,
        1 => sum,
        2 => sum.div_ceil(2),
        3 => (2 * sum + 3) / 6,
        _ => (sum + 2) / 4,
    }
}

/// Folds the distance of a code from 1 to 1023 from its prediction: 0, 1, -1, 2, ... to 0, 1, 2, 3,
/// ... as far as both signs are possible; then distances of the one sign that is left.
fn fold(code: u32, predicted: u32) -> u32 {
    let (room, distance) = (room(predicted), code.abs_diff(predicted));
    if distance > room {
        return distance + room;
    }
    if code > predicted { 2 * distance - 1 } else { 2 * distance }
}

/// Returns the code that [`fold`] folds to `folded`; `None` if it is none.
#[inline(always)]
fn unfold(folded: u32, predicted: u32) -> Option<u16> {
    let room = room(predicted);
    let code = if folded > 2 * room {
        let distance = folded.wrapping_sub(room);
        let up = predicted.saturating_sub(1) == room;
        if up { predicted.wrapping_add(distance) } else { predicted.wrapping_sub(distance) }
    } else if folded % 2 == 1 {
        predicted + folded / 2 + 1
    } else {
        predicted - folded / 2
    };
    (code > 0 && code < COUNTS as u32).then_some(code as u16)
}

/// Returns the largest distance from a prediction that is possible with both signs.
#[inline(always)]
fn room(predicted: u32) -> u32 {
    predicted.saturating_sub(1).min(COUNTS as u32 - 1 - predicted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemisphere::mix;
    use crate::layers::canopy::code_of;

    /// Returns a square with two crowns before each other, texels without leaves in between, and
    /// rays every second texel.
    fn crowns(side: usize) -> Vec<u16> {
        let code = |texel: usize| {
            let at = [texel % side, texel / side].map(|place| (place as f64 + 0.5) / side as f64);
            let through = |x: f64, y: f64, radius: f64| {
                let apart = 1.0 - ((at[0] - x).powi(2) + (at[1] - y).powi(2)) / radius.powi(2);
                if apart > 0.0 { 8.0 * apart.sqrt() } else { 0.0 }
            };
            let length = through(0.4, 0.5, 0.3) + through(0.7, 0.3, 0.2);
            if length > 0.0 && mix(7, texel as u64) % 90 != 1 { code_of(length) } else { 0 }
        };
        let mut codes: Vec<u16> = (0..side * side).map(code).collect();
        for texel in (0..side * side).filter(|texel| texel % side % 2 == 1 && (texel / side).is_multiple_of(2)) {
            if texel % side + 1 < side {
                let beside = [codes[texel - 1], codes[texel + 1]].map(u32::from);
                if beside[0] > 0 && beside[0].abs_diff(beside[1]) < 10 {
                    codes[texel] = mean(beside) as u16;
                }
            }
        }
        codes
    }

    /// Every code from 1 to 1023 comes back from its distance from every prediction, 1,046,529
    /// pairs, and distances of a prediction are 0 to 1022 without gaps.
    #[test]
    fn distances_come_back() {
        for predicted in 1..COUNTS as u32 {
            let mut met = [false; COUNTS - 1];
            for code in 1..COUNTS as u32 {
                let folded = fold(code, predicted);
                assert_eq!(unfold(folded, predicted), Some(code as u16), "{code} {predicted}");
                met[folded as usize] = true;
            }
            assert!(met.iter().all(|met| *met) && unfold(COUNTS as u32 - 1, predicted).is_none());
        }
        assert!((1..COUNTS as u32).all(|code| unfold(fold(code, 0), 0) == Some(code as u16)));
        assert_eq!([[3, 0, 0, 0], [3, 4, 0, 0], [3, 4, 4, 0], [1, 2, 2, 1]].map(mean), [3, 4, 4, 2]);
    }

    /// Squares of 2, 30, 148, 256 and 512 texels a side come back; the largest two take less than a
    /// quarter of ten bits a texel. Squares of odd sides, larger ones and rays that are no square
    /// are not predicted, and neither is a square of equal codes, which would take too few bytes.
    #[test]
    fn squares_come_back_in_few_bytes() {
        for side in [2, 30, 148, 256, 512] {
            let codes = crowns(side);
            let bytes = encode(&codes).expect("a code");
            assert!(decode(&bytes, side * side).as_ref() == Some(&codes), "{side}");
            let crossed = codes.iter().filter(|code| **code > 0).count();
            assert!(side < 256 || bytes.len() < crossed * 10 / 8 / 4, "{} of {crossed}", bytes.len());
        }
        assert!(encode(&crowns(31)).is_none() && encode(&crowns(258)).is_none() && encode(&[1; 8]).is_none());
        assert!(encode(&[1023; 256 * 256]).is_none() && decode(&[], 0).is_none());
    }

    /// Changed and cut bytes of a square are refused, or are those of the codes that are read:
    /// 4,000 cases. The bytes of a square of another side are refused.
    #[test]
    fn damaged_squares_are_refused() {
        let bytes = encode(&crowns(64)).expect("a code");
        let mut refused = 0;
        for case in 0..4_000_u64 {
            let mut bad = bytes.clone();
            for change in 0..1 + case % 3 {
                let at = mix(case, change) as usize % bad.len();
                bad[at] = mix(case, 100 + change) as u8;
            }
            bad.truncate(bytes.len() - (mix(case, 200) % 3) as usize);
            match decode(&bad, 64 * 64) {
                Some(codes) => assert!(encode(&codes).as_ref() == Some(&bad)),
                None => refused += 1,
            }
        }
        assert!(refused > 3_900, "{refused}");
        assert!([62, 66, 32, 63].into_iter().all(|side| decode(&bytes, side * side).is_none()));
    }
}
