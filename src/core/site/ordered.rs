//! Bytes that sort as numbers do. In: numbers. Out: bytes, and back.

const SIGN: u64 = 1 << 63;

/// Returns big-endian bytes in the order of `f64::total_cmp`.
pub fn ordered_f64(value: f64) -> [u8; 8] {
    let bits = value.to_bits();
    (if bits & SIGN == 0 { bits | SIGN } else { !bits }).to_be_bytes()
}

/// Inverse of [`ordered_f64`], exact to the bit.
pub fn from_ordered_f64(bytes: [u8; 8]) -> f64 {
    let bits = u64::from_be_bytes(bytes);
    f64::from_bits(if bits & SIGN == 0 { !bits } else { bits ^ SIGN })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten numbers from -infinity to infinity, both zeros among them, keep their order and their
    /// bits.
    #[test]
    fn numbers_keep_their_order_and_bits() {
        let numbers = [f64::NEG_INFINITY, -1e9, -1.5, -1e-310, -0.0, 0.0, 1e-310, 1.5, 1e9, f64::INFINITY];
        assert!(numbers.map(ordered_f64).is_sorted_by(|a, b| a < b));
        assert_eq!(numbers.map(|x| from_ordered_f64(ordered_f64(x)).to_bits()), numbers.map(f64::to_bits));
    }
}
