//! Entropy coding of small whole numbers by asymmetric numeral systems (rANS: Duda 2013,
//! arXiv:1311.2540). A table of frequencies for each context goes with the bytes. Several states
//! beside each other share the words (Giesen 2014, arXiv:1402.3392). In: values, their contexts and
//! states. Out: bytes, and back. All arithmetic is in integers; any bytes decode to values or to
//! `None`.

/// Binary logarithm of the sum of a context's frequencies, 2^9: the tables of two dozen contexts
/// fit into the first-level cache.
const SCALE: u32 = 9;
const WHOLE: u32 = 1 << SCALE;

/// Number of states. Values of different states do not wait for each other. Each column of a block
/// of coefficients has one.
pub const STATES: usize = 8;

/// Smallest value of a state, and its value before the first symbol. A state below it is refilled
/// by 16 bits.
const LOWEST: u32 = 1 << 16;

/// Values below this are symbols themselves. The symbol of a larger value is its number of bits.
const DIRECT: u32 = 16;

/// Number of symbols: [`DIRECT`] values, and 4 to 23 bits behind the highest one.
const SYMBOLS: usize = 36;

/// Limit that all values stay below.
pub const LIMIT: u32 = 1 << 24;

/// Largest number of bits behind a symbol that are coded at once. A state is refilled by one word
/// of 16 bits, so a piece must not be longer than that.
const PIECE: u32 = 12;

/// Returns the symbol of a value, and the number of the value's lowest bits that follow it.
#[inline(always)]
fn split(value: u32) -> (usize, u32) {
    if value < DIRECT {
        return (value as usize, 0);
    }
    let bits = value.ilog2();
    // 16 is the first value with 4 bits behind its highest, so symbols go on at 16.
    ((bits + DIRECT - 4) as usize, bits)
}

/// Numbers of the symbols of values in each context.
pub struct Histogram {
    counts: Vec<[u32; SYMBOLS]>,
}

impl Histogram {
    /// Makes a histogram without values in `contexts` contexts.
    pub fn new(contexts: usize) -> Self {
        Histogram { counts: vec![[0; SYMBOLS]; contexts] }
    }

    /// Counts a value below [`LIMIT`] in an existing context.
    #[inline(always)]
    pub fn add(&mut self, context: usize, value: u32) {
        self.counts[context][split(value).0] += 1;
    }

    /// Returns the frequencies of each context.
    fn frequencies(&self) -> Vec<[u32; SYMBOLS]> {
        self.counts.iter().map(scaled).collect()
    }

    /// Returns the bytes of the frequencies, which a stream of these values begins with.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Vec::new();
        for of_context in &self.frequencies() {
            let last = of_context.iter().rposition(|frequency| *frequency > 0).unwrap_or(0);
            // No length is stored: the reader stops where the sum is whole. At most 512, a
            // frequency takes one or two bytes of 7 bits.
            for &frequency in &of_context[..=last] {
                if frequency < 128 {
                    out.push(frequency as u8);
                } else {
                    out.extend([frequency as u8 | 128, (frequency >> 7) as u8]);
                }
            }
        }
        out
    }
}

/// Encoder that gathers values and writes them as bytes.
pub struct Encoder {
    contexts: usize,
    /// Context, state and value of each value.
    values: Vec<(u8, u8, u32)>,
}

impl Encoder {
    /// Makes an encoder with `contexts` contexts, at most 256.
    pub fn new(contexts: usize) -> Self {
        Encoder { contexts, values: Vec::new() }
    }

    /// Appends a value below [`LIMIT`] in an existing context and state.
    pub fn put(&mut self, context: usize, state: usize, value: u32) {
        self.values.push((context as u8, state as u8, value.min(LIMIT - 1)));
    }

    /// Returns the bytes: frequencies of each context, the states, then the words that refill them.
    pub fn finish(self) -> Vec<u8> {
        let mut histogram = Histogram::new(self.contexts);
        self.values.iter().for_each(|&(context, _, value)| histogram.add(usize::from(context), value));
        let (frequencies, mut out) = (histogram.frequencies(), histogram.to_bytes());
        let (mut states, mut words) = ([LOWEST; STATES], Vec::new());
        // The decoder reads in reverse order: the value that is encoded last comes out first.
        for &(context, state, value) in self.values.iter().rev() {
            let (symbol, bits) = split(value);
            let low = bits.min(PIECE);
            let state = &mut states[usize::from(state)];
            push(state, &mut words, (value & ((1 << bits) - 1)) >> low, 1, bits - low);
            push(state, &mut words, value & ((1 << low) - 1), 1, low);
            let of_context = &frequencies[usize::from(context)];
            push(state, &mut words, of_context[..symbol].iter().sum(), of_context[symbol], SCALE);
        }
        out.extend(states.iter().flat_map(|state| state.to_le_bytes()));
        out.extend(words.iter().rev().flat_map(|word| word.to_le_bytes()));
        out
    }
}

/// Scales counts to a sum of [`WHOLE`]. A symbol that occurs keeps at least 1; if none occurs,
/// symbol 0 takes all.
fn scaled(counts: &[u32; SYMBOLS]) -> [u32; SYMBOLS] {
    let total: u64 = counts.iter().map(|&count| u64::from(count)).sum();
    let mut out = counts.map(|count| match u64::from(count) * u64::from(WHOLE) / total.max(1) {
        0 => u32::from(count > 0),
        share => share as u32,
    });
    // The most frequent symbol takes the rounding remainder; among equal ones, the first.
    let largest = (0..SYMBOLS).rev().max_by_key(|&symbol| out[symbol]).unwrap_or(0);
    let others: u32 = out.iter().sum::<u32>() - out[largest];
    // Never below 1: with k symbols raised to 1, the largest of 36 has at least (512 - k) / (36 -
    // k), which is more than k.
    out[largest] = WHOLE - others;
    out
}

/// Puts an interval into a state: it starts at `start` and is `frequency` wide, of 2^`scale`.
fn push(state: &mut u32, words: &mut Vec<u16>, start: u32, frequency: u32, scale: u32) {
    // A word goes out first where the new state would not fit into 32 bits. The product is a u64
    // because 512 << 23 is 2^32.
    if u64::from(*state) >= u64::from(frequency) << (32 - scale) {
        words.push(*state as u16);
        *state >>= 16;
    }
    *state = ((*state / frequency) << scale) + start + *state % frequency;
}

/// Decoding tables of the contexts of a stream.
pub struct SymbolTables {
    /// `[context][slot]`: symbol, frequency, and distance from the start of the symbol's interval,
    /// in 6, 10 and 9 bits from the lowest on.
    slots: Vec<[u32; WHOLE as usize]>,
}

/// Decoder that reads one value after the other.
pub struct Reader<'a> {
    states: [u32; STATES],
    words: &'a [[u8; 2]],
    /// Number of words that were taken. Words behind the last one count as 0.
    taken: usize,
}

/// Reads the frequencies of `contexts` contexts and the first states. Returns `None` if they are
/// wrong or missing.
pub fn open(contexts: usize, bytes: &[u8]) -> Option<(SymbolTables, Reader<'_>)> {
    let mut rest = bytes.iter();
    let mut slots = vec![[0; WHOLE as usize]; contexts];
    for table in &mut slots {
        let (mut start, mut symbol) = (0_u32, 0);
        while start < WHOLE {
            let mut frequency = u32::from(*rest.next()?);
            if frequency >= 128 {
                frequency = frequency - 128 + (u32::from(*rest.next()?) << 7);
            }
            let of_symbol = table.get_mut(start as usize..(start + frequency) as usize)?;
            for (distance, slot) in (0_u32..).zip(of_symbol) {
                *slot = symbol | frequency << 6 | distance << 16;
            }
            start += frequency;
            symbol += 1;
            // Frequencies of 0 do not move `start`, so only this ends the loop on a stream of
            // zeros.
            if symbol > SYMBOLS as u32 {
                return None;
            }
        }
    }
    let (first, words) = rest.as_slice().split_first_chunk::<{ 4 * STATES }>()?;
    let (first, (words, odd)) = (first.as_chunks().0, words.as_chunks());
    let states: [u32; STATES] = std::array::from_fn(|i| u32::from_le_bytes(first[i]));
    // No state is below this between two values.
    let whole = odd.is_empty() && states.iter().all(|state| *state >= LOWEST);
    whole.then_some((SymbolTables { slots }, Reader { states, words, taken: 0 }))
}

impl Reader<'_> {
    /// Returns the next value of an existing context and state. Behind the last word, any value may
    /// come.
    #[inline(always)]
    pub fn take(&mut self, tables: &SymbolTables, context: usize, state: usize) -> u32 {
        let before = self.states[state];
        let entry = tables.slots[context][(before % WHOLE) as usize];
        // At most 512 (2^23 - 1) + 511: no overflow.
        let after = (entry >> 6 & 0x3ff) * (before >> SCALE) + (entry >> 16);
        self.states[state] = self.refilled(after);
        let symbol = entry & 0x3f;
        if symbol < DIRECT { symbol } else { self.bits(state, symbol + 4 - DIRECT) }
    }

    /// Reads a value that has `bits` bits behind its highest one.
    #[cold]
    fn bits(&mut self, state: usize, bits: u32) -> u32 {
        let low = bits.min(PIECE);
        let mut value = 1 << bits;
        for (at, piece) in [(0, low), (low, bits - low)] {
            let before = self.states[state];
            value |= (before & ((1 << piece) - 1)) << at;
            self.states[state] = self.refilled(before >> piece);
        }
        value
    }

    /// Refills a state below [`LOWEST`] by one word. It does so without a branch, since a processor
    /// cannot predict whether a word is taken.
    #[inline(always)]
    fn refilled(&mut self, state: u32) -> u32 {
        let word = self.words.get(self.taken).map_or(0, |word| u16::from_le_bytes(*word));
        let low = state < LOWEST;
        self.taken += usize::from(low);
        if low { state << 16 | u32::from(word) } else { state }
    }

    /// Returns true if more words were taken than there are.
    pub fn is_beyond(&self) -> bool {
        self.taken > self.words.len()
    }

    /// Returns true if the values end where the bytes do.
    pub fn is_done(&self) -> bool {
        // The encoder starts from these states, so a decoder that ends in others has read damaged
        // bytes.
        self.states == [LOWEST; STATES] && self.taken == self.words.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemisphere::mix;

    /// Values of two contexts in eight states come back: small ones, and two of each number of bits
    /// up to 23. The bytes stay within 2 % and 140 bytes of the entropy of the small ones.
    #[test]
    fn coded_values_come_back_near_their_entropy() {
        let small = |i: u64| (mix(7, i) % 10) as u32 % 7 % 4;
        let mut values: Vec<(usize, u32)> = (0..20_000).map(|i| (0, small(i))).collect();
        values.extend((0..24).flat_map(|bits| [(1, 1 << bits), (1, (2 << bits) - 1)]));
        let mut encoder = Encoder::new(3);
        values.iter().enumerate().for_each(|(i, &(context, value))| encoder.put(context, i % STATES, value));
        let bytes = encoder.finish();
        let (tables, mut reader) = open(3, &bytes).expect("a stream");
        let read = |(i, v): (usize, &(usize, u32))| (v.0, reader.take(&tables, v.0, i % STATES));
        let back: Vec<(usize, u32)> = values.iter().enumerate().map(read).collect();
        assert!(back == values);
        assert!(reader.is_done());
        let count = |value| values.iter().filter(|v| **v == (0, value)).count() as f64;
        let entropy: f64 = (0..4).map(|value| -count(value) * (count(value) / 20_000.0).log2() / 8.0).sum();
        assert!((bytes.len() as f64) < entropy * 1.02 + 140.0 + 24.0 * 4.0, "{} {entropy}", bytes.len());
    }

    /// None of 4,000 streams with changed or missing bytes makes the reader panic, and all values
    /// that are read lie below the limit. The reader reports a truncated stream.
    #[test]
    fn damaged_streams_end_no_reader() {
        let mut encoder = Encoder::new(2);
        (0..2_000_u64).for_each(|i| encoder.put((i % 2) as usize, (i % 8) as usize, (mix(3, i) % 40) as u32));
        let bytes = encoder.finish();
        let mut refused = 0;
        for i in 0..4_000_u64 {
            let mut bad = bytes.clone();
            for j in 0..3 {
                let at = mix(i, j) as usize % bad.len();
                bad[at] = mix(i, 100 + j) as u8;
            }
            bad.truncate(bytes.len() - (mix(i, 200) % 40) as usize);
            let Some((tables, mut reader)) = open(2, &bad) else {
                refused += 1;
                continue;
            };
            (0..2_000).for_each(|i| assert!(reader.take(&tables, i % 2, i % STATES) < LIMIT));
        }
        assert!(refused > 100, "{refused}");
        let (tables, mut reader) = open(2, &bytes[..bytes.len() - 2]).expect("a stream");
        (0..2_000).for_each(|i| assert!(reader.take(&tables, i % 2, i % STATES) < LIMIT));
        assert!(reader.is_beyond() && !reader.is_done());
    }
}
