//! Packed layers of a receiver as 32-bit words. In: the layers of a receiver. Out: the words and
//! their layout; irradiances computed from the words. The core and the graphics card read the same
//! words.
//!
//! The words of a receiver fill whole texels of [`WORDS`] words each, one part after another:
//! - f32: the normal and the step of the response along the texel's direction; then the step of the
//!   response across it, the step of the coefficients, the coefficient of the band at the horizon,
//!   0;
//! - `[patch]`: coefficients of the sky seen directly, one byte each, counted in steps, the first
//!   in the lowest byte, see [`Shape::patches`];
//! - `[texel]`: response along the texel's direction and twice across it, signed, with 14, 9 and 9
//!   bits in units of 4, 8 and 8 steps, see [`Shape::response`]; then one byte each for the
//!   remainders, with 2, 3 and 3 bits in steps, see [`Shape::rest`];
//! - the sky, see [`packed_sky`](crate::replay::interactive::packed_sky).
//!
//! A source in direction s meets texels whose directions are close to s. The parts across count by
//! the angle between the two directions, so fewer bits suffice for them.

use glam::DVec3;
use pulp::Arch;

use crate::hemisphere::{Frame, texel_centres};
use crate::layers::sky_bitmap::SkyBitmap;
use crate::replay::interactive::packed_sky;
use crate::replay::interactive::shape::{Shape, WORDS, padded};

/// Number of texels of the head: normal, steps and the band at the horizon.
const HEAD: usize = 2;
/// Largest value of a byte.
const BYTE: f32 = 255.0;
/// Bits of the three parts of a response in its word, and of their remainders in its byte.
const WORD_BITS: [u32; 3] = [14, 9, 9];
const BYTE_BITS: [u32; 3] = [2, 3, 3];
/// Number of partial sums that are added side by side, in a fixed order.
const SIDE_BY_SIDE: usize = 16;

/// Layers of a receiver before they are packed.
pub(super) struct Unpacked<'r> {
    pub normal: DVec3,
    /// `[patch]`: irradiance per radiance, none below 0; then the coefficient of the band at the
    /// horizon.
    pub coefficients: &'r [f32],
    /// `[texel][axis]`: response; empty where nothing reflects.
    pub response: &'r [[f32; 3]],
    pub sky: &'r SkyBitmap,
}

impl Unpacked<'_> {
    /// Appends the words of the receiver. `frames` are the frames of the response texels.
    pub fn pack(&self, shape: Shape, frames: &[Frame], words: &mut Vec<u32>) {
        let (band, patches) = self.coefficients.split_last().map_or((0.0, &[][..]), |(band, patches)| (*band, patches));
        let parts: Vec<[f32; 3]> =
            self.response.iter().zip(frames).map(|(g, frame)| in_frame(frame, g.map(f64::from))).collect();
        let along = step(parts.iter().map(|part| part[0]), most(0));
        let across = step(parts.iter().flat_map(|part| [part[1], part[2]]), most(1));
        let coefficient = step(patches.iter().copied(), BYTE);
        let first = words.len();
        words.reserve((HEAD + shape.patches + shape.response) * WORDS + shape.rest());
        let [x, y, z] = self.normal.as_vec3().to_array();
        words.extend([x, y, z, along, across, coefficient, band, 0.0].map(f32::to_bits));
        padded(words, shape.patches, rounded_in_turn(patches, coefficient));
        words.resize(first + (HEAD + shape.patches + shape.response) * WORDS + shape.rest(), 0);
        let (response, rest) = words[first + (HEAD + shape.patches) * WORDS..].split_at_mut(shape.response * WORDS);
        let split = |[a, u, v]: &[f32; 3]| in_two([whole(*a, along), whole(*u, across), whole(*v, across)]);
        put_in_two(parts.iter().map(split), response, rest);
        packed_sky::pack(self.sky, shape, words);
    }
}

/// Words of a receiver, part by part.
#[derive(Clone, Copy)]
pub(super) struct Packed<'w> {
    normal: [f32; 3],
    /// Steps of the response along and across the texel's direction, and step of the coefficients.
    along: f32,
    across: f32,
    coefficient: f32,
    /// Coefficient of the band at the horizon.
    band: f32,
    patches: &'w [u32],
    response: &'w [u32],
    rest: &'w [u32],
    /// Words of the sky, and those of the receivers that follow.
    pub sky: &'w [u32],
}

impl<'w> Packed<'w> {
    /// Returns the parts of the receiver at the start of `words`. Panics (slice out of bounds) if
    /// [`Unpacked::pack`] did not write the words with the same shape.
    pub fn new(words: &'w [u32], shape: Shape) -> Self {
        let (head, words) = words.split_at(HEAD * WORDS);
        let (patches, words) = words.split_at(shape.patches * WORDS);
        let (response, words) = words.split_at(shape.response * WORDS);
        let (rest, sky) = words.split_at(shape.rest());
        let number = |place: usize| f32::from_bits(head[place]);
        Packed {
            normal: [0, 1, 2].map(number),
            along: number(3),
            across: number(4),
            coefficient: number(5),
            band: number(6),
            patches,
            response,
            rest,
            sky,
        }
    }

    /// Returns the receiver's normal.
    pub fn normal(&self) -> DVec3 {
        DVec3::from_array(self.normal.map(f64::from))
    }

    /// Returns the irradiance from the sky seen directly. `radiances` holds the patches and then
    /// the band at the horizon; it may lack the band, and is empty without a sky.
    pub fn of_sky(&self, radiances: &[f32], patches: usize) -> f32 {
        let (of_patches, band) = radiances.split_at(patches.min(radiances.len()));
        let sum = Arch::new().dispatch(|| byte_products(self.patches, of_patches));
        sum * self.coefficient + band.first().map_or(0.0, |band| band * self.band)
    }

    /// Returns the irradiance from sources by way of reflecting surfaces. A source is a response
    /// texel and irradiance x direction in its frame.
    pub fn of_sources(&self, sources: &[(u32, [f32; 3])]) -> f32 {
        let term = |&(texel, [a, u, v]): &(u32, [f32; 3])| {
            let (texel, words) = (texel as usize, self.rest.len());
            let rest = self.rest[texel % words] >> (8 * (texel / words)) & 255;
            let [along, first, second] = joined(self.response[texel], rest);
            f64::from(a * along * self.along + (u * first + v * second) * self.across)
        };
        // Where nothing reflects there is no texel.
        if self.response.is_empty() { 0.0 } else { sources.iter().map(term).sum::<f64>() as f32 }
    }

    /// Returns the irradiance from a field of sources, one in each response texel, by way of
    /// reflecting surfaces. The field is `[part][texel]`.
    pub fn of_field(&self, [a, u, v]: &[Vec<f32>; 3]) -> f32 {
        let (along, across) = Arch::new().dispatch(|| field_products(self.response, self.rest, [a, u, v]));
        along * self.along + across * self.across
    }
}

/// Returns the frames of the texels of an n x n response: axis n along the texel's direction, u and
/// v across it.
pub(super) fn frames(n: usize) -> Vec<Frame> {
    texel_centres(n).into_iter().map(Frame::new).collect()
}

/// Returns the parts of a vector along the direction of a texel and across it.
pub(super) fn in_frame(frame: &Frame, vector: [f64; 3]) -> [f32; 3] {
    let vector = DVec3::from(vector);
    [frame.n, frame.u, frame.v].map(|axis| axis.dot(vector) as f32)
}

/// Returns the step of which `largest` make up the largest absolute value; 0 where all values are
/// 0.
fn step(values: impl Iterator<Item = f32>, largest: f32) -> f32 {
    // Not `max`, which WebAssembly has no instruction for.
    let more = |most: f32, value: f32| if value.abs() > most { value.abs() } else { most };
    values.fold(0.0, more) / largest
}

/// Returns the nearest number of steps.
fn whole(value: f32, step: f32) -> i32 {
    // Halves to even numbers: that is an instruction everywhere.
    if step > 0.0 { (value / step).round_ties_even() as i32 } else { 0 }
}

/// Returns numbers of steps as bytes, four to a word, the first lowest. Each number makes up for
/// the rounding errors before it. Radiances of neighbouring patches are alike, so errors of sums
/// stay within one step.
fn rounded_in_turn(values: &[f32], step: f32) -> impl Iterator<Item = u32> {
    let mut owed = 0.0_f32;
    let mut next = move |value: &f32| {
        let due = if step > 0.0 { value / step + owed } else { 0.0 };
        let found = due.round_ties_even().clamp(0.0, BYTE);
        owed = due - found;
        found as u32
    };
    values.chunks(4).map(move |four| four.iter().zip([0, 8, 16, 24]).fold(0, |word, (v, at)| word | next(v) << at))
}

/// Returns the unit, in steps, in which the word of a response counts a part.
fn unit(part: usize) -> f32 {
    (1 << BYTE_BITS[part]) as f32
}

/// Returns the largest number of steps of a part that fits into its bits in the word and in the
/// byte.
fn most(part: usize) -> f32 {
    let [word, byte] = [WORD_BITS[part], BYTE_BITS[part]];
    (((1 << (word - 1)) - 1) * (1 << byte) + (1 << (byte - 1)) - 1) as f32
}

/// Packs the steps of a texel into a word, and the remainders into a byte.
fn in_two(steps: [i32; 3]) -> (u32, u8) {
    let (mut word, mut byte, mut word_at, mut byte_at) = (0, 0, 0, 0);
    for (part, steps) in steps.into_iter().enumerate() {
        let [of_word, of_byte] = [WORD_BITS[part], BYTE_BITS[part]];
        // Rounded to the nearest unit, so that the remainder fits into its signed bits.
        let nearest = (steps + (1 << (of_byte - 1))) >> of_byte;
        let rest = steps - (nearest << of_byte);
        word |= (nearest as u32 & ((1 << of_word) - 1)) << word_at;
        byte |= (rest as u32 & ((1 << of_byte) - 1)) << byte_at;
        (word_at, byte_at) = (word_at + of_word, byte_at + of_byte);
    }
    (word, byte as u8)
}

/// Writes texels to their places: a word each, and a byte each for the remainders. The lowest bytes
/// of all words of `rest` are filled before the next ones.
fn put_in_two(mut texels: impl Iterator<Item = (u32, u8)>, words: &mut [u32], rest: &mut [u32]) {
    for (words, at) in words.chunks_mut(rest.len().max(1)).zip([0, 8, 16, 24]) {
        for ((word, rest), (of_word, of_rest)) in words.iter_mut().zip(rest.iter_mut()).zip(&mut texels) {
            *word = of_word;
            *rest |= u32::from(of_rest) << at;
        }
    }
}

/// Returns the signed parts of a word of a response, in units.
#[inline(always)]
fn parts(word: u32) -> [f32; 3] {
    let word = word as i32;
    // Right shifts of signed numbers extend the sign of the 14, 9 and 9 bits.
    [(word << 18 >> 18) as f32, (word << 9 >> 23) as f32, (word >> 23) as f32]
}

/// Returns the parts of a word of a response together with their remainders, in steps.
fn joined(word: u32, rest: u32) -> [f32; 3] {
    let [a, u, v] = parts(word);
    let signed = |at: u32, bits: u32| ((rest << (32 - at - bits)) as i32 >> (32 - bits)) as f32;
    [a * unit(0) + signed(0, 2), u * unit(1) + signed(2, 3), v * unit(2) + signed(5, 3)]
}

/// Returns the sum of the products of bytes and numbers.
#[inline(always)]
fn byte_products(words: &[u32], numbers: &[f32]) -> f32 {
    let mut sums = [0.0_f32; SIDE_BY_SIDE];
    let term = |word: u32, place: usize| (word >> (8 * place) & 255) as f32;
    let (whole, rest) = numbers.as_chunks::<SIDE_BY_SIDE>();
    let (of_whole, of_rest) = words.as_chunks::<{ SIDE_BY_SIDE / 4 }>();
    for (words, numbers) in of_whole.iter().zip(whole) {
        for (place, (sum, number)) in sums.iter_mut().zip(numbers).enumerate() {
            *sum += term(words[place / 4], place % 4) * number;
        }
    }
    let after = of_whole.get(whole.len()).map_or(of_rest, |words| &words[..]);
    let of_place = |(place, number): (usize, &f32)| term(after[place / 4], place % 4) * number;
    sums.iter().sum::<f32>() + rest.iter().enumerate().map(of_place).sum::<f32>()
}

/// Returns the sums of the products of a response (words and remainders) and a field: along the
/// texels' directions, and across them.
#[inline(always)]
fn field_products(words: &[u32], rest: &[u32], [a, u, v]: [&[f32]; 3]) -> (f32, f32) {
    let (mut along, mut across) = ([0.0_f32; SIDE_BY_SIDE], [0.0_f32; SIDE_BY_SIDE]);
    for (number, words) in words.chunks(rest.len().max(1)).enumerate() {
        let first = number * rest.len();
        // A field without a sky is empty.
        let [a, u, v] = [a, u, v].map(|part| part.get(first..).unwrap_or_default());
        let parts = a.iter().zip(u).zip(v);
        for (place, ((word, rest), ((a, u), v))) in words.iter().zip(rest).zip(parts).enumerate() {
            let [of_a, of_u, of_v] = joined(*word, rest >> (8 * number as u32) & 255);
            along[place % SIDE_BY_SIDE] += of_a * a;
            across[place % SIDE_BY_SIDE] += of_u * u + of_v * v;
        }
    }
    (along.iter().sum(), across.iter().sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All numbers of steps along and across, 65,531 and 4,087 of them, come back from a word and a
    /// byte. Sums over bytes and over fields equal those of plain loops, for 0 to 40 numbers.
    #[test]
    fn packed_numbers_come_back_and_sum_alike() {
        let [along, across] = [0, 1].map(|part| most(part) as i32);
        assert_eq!((along, across), (32_765, 2_043));
        let back = |steps: [i32; 3]| {
            let (word, rest) = in_two(steps);
            joined(word, rest.into()).map(|part| part as i32)
        };
        assert!((-along..=along).all(|a| back([a, 7, -9]) == [a, 7, -9]));
        assert!((-across..=across).all(|u| back([-3, u, -u]) == [-3, u, -u]));
        for count in 0..40_u32 {
            let numbers: Vec<f32> = (0..count).map(|i| (i * i % 17) as f32).collect();
            let bytes: Vec<u8> = (0..count).map(|i| (i * 37 % 256) as u8).collect();
            let words: Vec<u32> =
                rounded_in_turn(&bytes.iter().map(|b| f32::from(*b)).collect::<Vec<_>>(), 1.0).collect();
            let plain: f32 = bytes.iter().zip(&numbers).map(|(b, n)| f32::from(*b) * n).sum();
            assert_eq!(byte_products(&words, &numbers), plain);
            let steps = |i: u32| [i as i32 * 7, 16 - i as i32 * 5, 24];
            let (mut fields, mut rest) = (vec![0; count as usize], vec![0; count.div_ceil(4) as usize]);
            put_in_two((0..count).map(|i| in_two(steps(i))), &mut fields, &mut rest);
            let plain = (0..count).zip(&numbers).fold((0.0, 0.0), |(along, across), (i, n)| {
                let [a, u, v] = steps(i).map(|part| part as f32);
                (along + a * n, across + u * n + v * n)
            });
            assert_eq!(field_products(&fields, &rest, [&numbers; 3].map(Vec::as_slice)), plain);
        }
    }
}
