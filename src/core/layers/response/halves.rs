//! Responses as formats up to 1.2 hold them. In: the raw bytes of a tile. Out: its responses. They are no longer written.

use half::f16;

use crate::layers::response::Response;

/// The low bytes, then the high bytes of all values of all receivers as IEEE 754 binary16; `None` if the bytes are not `count` responses
/// of n x n texels with finite values.
pub fn unpack(raw: &[u8], count: usize, n: usize) -> Option<Vec<Response>> {
    let len = Response::len(n);
    let total = count.checked_mul(len)?;
    if raw.len() != total.checked_mul(2)? {
        return None;
    }
    let (low, high) = raw.split_at(total);
    let values: Vec<f32> = low.iter().zip(high).map(|(&l, &h)| f16::from_le_bytes([l, h]).to_f32()).collect();
    let finite = values.iter().all(|v| v.is_finite());
    finite.then(|| values.chunks(len.max(1)).map(|v| Response { values: v.to_vec() }).collect())
}
