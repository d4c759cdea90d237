//! Layers that only some scenes need: mirrors and canopies. In: rows of each receiver or cell,
//! empty where there is nothing. Out: one raw block for all rows of a tile or a chunk, and back; no
//! block if all rows are empty.

use crate::layers::canopy::Canopy;
use crate::layers::mirror::ReceiverMirrors;

/// Mirrors and canopies of one receiver.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReceiverExtras {
    /// Sky and surfaces that the receiver sees in mirrors.
    pub mirrors: ReceiverMirrors,
    /// Crossings of leaves along the receiver's rays to the texels of its sky and to the texels of
    /// its hits.
    pub canopy: Canopy,
}

/// Packs the rows of one layer into a raw block: the length of each row (u32), then the bytes of
/// all rows. Returns `None` if all rows are empty.
pub fn pack<'a>(rows: impl Iterator<Item = &'a [u8]> + Clone) -> Option<Vec<u8>> {
    if rows.clone().all(<[u8]>::is_empty) {
        return None;
    }
    let lengths = rows.clone().flat_map(|row| (row.len() as u32).to_le_bytes());
    Some(lengths.chain(rows.clone().flatten().copied()).collect())
}

/// Unpacks `rows` rows from the bytes of [`pack`]. Returns `None` if the bytes are anything else.
pub fn unpack(raw: &[u8], rows: usize) -> Option<Vec<Vec<u8>>> {
    let (lengths, mut rest) = raw.split_at_checked(rows.checked_mul(4)?)?;
    let row = |length: &[u8; 4]| {
        let (row, tail) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        rest = tail;
        Some(row.to_vec())
    };
    let found: Vec<Vec<u8>> = lengths.as_chunks().0.iter().map(row).collect::<Option<_>>()?;
    rest.is_empty().then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three rows, one of them empty, come back. Empty rows make no block. All 20 truncated blocks
    /// are refused.
    #[test]
    fn rows_come_back_and_cut_blocks_are_refused() {
        let rows = [vec![1, 2, 3], Vec::new(), vec![4; 5]];
        let raw = pack(rows.iter().map(Vec::as_slice)).unwrap_or_default();
        assert_eq!((raw.len(), unpack(&raw, 3)), (20, Some(rows.to_vec())));
        assert_eq!((0..raw.len()).filter(|&cut| unpack(&raw[..cut], 3).is_none()).count(), 20);
        assert_eq!(pack([&[][..]; 3].into_iter()), None);
        assert_eq!(unpack(&[0xff; 12], 3), None);
    }
}
