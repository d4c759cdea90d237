//! Morton order. In: receivers in file order. Out: the order along a Morton curve, in which
//! neighbours share tiles.

use std::cmp::Ordering;

use glam::DVec3;

use crate::site::ordered::{from_ordered_f64, ordered_f64};
use crate::site::receiver::Receiver;

/// Edge of the curve's cells; with 21 bits an axis it repeats after 524 km.
const CELL_M: f64 = 0.25;
/// Bits an axis of a 63-bit code.
pub const BITS: u32 = 21;

/// Returns the indices of the receivers sorted by 63-bit Morton code of the position (input
/// coordinates), then by exact position, normal and id. So neither the order of the file nor the
/// scene around them matters. Codes repeat after 524 km, the order stays total.
pub fn morton_order(receivers: &[Receiver]) -> Vec<usize> {
    let mut keyed: Vec<(u64, &Receiver, usize)> =
        receivers.iter().enumerate().map(|(i, receiver)| (morton_code(receiver.position), receiver, i)).collect();
    keyed.sort_by(|(code_a, a, _), (code_b, b, _)| code_a.cmp(code_b).then_with(|| exact_order(a, b)));
    keyed.into_iter().map(|(_, _, i)| i).collect()
}

/// Returns bytes that sort receivers as [`morton_order`] does: the code, the exact position and
/// normal, the id.
pub fn morton_key(receiver: &Receiver) -> Vec<u8> {
    let mut key = morton_code(receiver.position).to_be_bytes().to_vec();
    for part in [receiver.position, receiver.normal] {
        key.extend(part.to_array().into_iter().flat_map(ordered_f64));
    }
    key.extend_from_slice(receiver.id.as_bytes());
    key
}

/// Returns the receiver of a [`morton_key`], without its area, surface and part, which the key does
/// not hold; `None` for other bytes.
pub fn receiver_of_key(key: &[u8]) -> Option<Receiver> {
    let (_code, rest) = key.split_first_chunk::<8>()?;
    let (numbers, id) = rest.split_first_chunk::<48>()?;
    let mut numbers = numbers.as_chunks::<8>().0.iter().map(|bytes| from_ordered_f64(*bytes));
    let mut vector = || Some(DVec3::new(numbers.next()?, numbers.next()?, numbers.next()?));
    let (position, normal) = (vector()?, vector()?);
    let id = String::from_utf8(id.to_vec()).ok()?;
    Some(Receiver::new(id, position, normal))
}

fn exact_order(a: &Receiver, b: &Receiver) -> Ordering {
    lexicographic(a.position, b.position).then_with(|| lexicographic(a.normal, b.normal)).then_with(|| a.id.cmp(&b.id))
}

/// Returns the Morton code of a position: the cell numbers of the axes interleaved, x in the lowest
/// bit (G. M. Morton, 1966).
fn morton_code(position: DVec3) -> u64 {
    let [x, y, z] = position.to_array().map(|metres| {
        let middle = f64::from(1_u32 << (BITS - 1));
        // `as` maps NaN to 0; `spread` takes the lowest 21 bits.
        spread(((metres / CELL_M + middle).floor() as i64).cast_unsigned())
    });
    x | y << 1 | z << 2
}

/// Compares the codes of two voxels, x in the lowest bit, without making them: the axis whose
/// highest differing bit is the highest decides (Chan 2002).
pub fn morton_cmp(a: [u32; 3], b: [u32; 3]) -> Ordering {
    let ([ax, ay, az], [bx, by, bz]) = (a, b);
    let mut decides = (az, bz);
    for (p, q) in [(ay, by), (ax, bx)] {
        let (highest, differing) = (decides.0 ^ decides.1, p ^ q);
        // The highest bit of `differing` is above that of `highest`.
        if highest < differing && highest < highest ^ differing {
            decides = (p, q);
        }
    }
    decides.0.cmp(&decides.1)
}

/// Compares positions by x, then y, then z; a total order.
pub fn lexicographic(a: DVec3, b: DVec3) -> Ordering {
    a.x.total_cmp(&b.x).then_with(|| a.y.total_cmp(&b.y)).then_with(|| a.z.total_cmp(&b.z))
}

/// Puts two zero bits after each of the lowest 21 bits.
pub fn spread(bits: u64) -> u64 {
    let mut bits = bits & 0x1f_ffff;
    for (shift, mask) in [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        bits = (bits | bits << shift) & mask;
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::*;

    fn receiver(id: &str, position: [f64; 3]) -> Receiver {
        Receiver::new(id.to_owned(), position.into(), DVec3::Z)
    }

    /// The code's bits are x, y, z of the cell in turn; its middle is 0, and it repeats after 2^19
    /// m.
    #[test]
    fn the_code_interleaves_bits_of_the_cell() {
        assert_eq!(spread(0x1f_ffff), 0x1249_2492_4924_9249);
        let middle = 7 << 60;
        assert_eq!(morton_code(DVec3::ZERO), middle);
        assert_eq!(morton_code(DVec3::new(0.25, 0.5, 0.3)), middle | 0b001 | 0b010 << 3 | 0b100);
        assert_eq!(morton_code(DVec3::splat(262_143.9)), (1 << 63) - 1);
        assert_eq!(morton_code(DVec3::splat(-262_144.0)), 0);
        let place = DVec3::new(-7.3, 4e5, 12.0);
        assert_eq!(morton_code(place + 524_288.0), morton_code(place));
        assert_eq!(morton_code(place), morton_code(place - 3.0 * 524_288.0));
    }

    /// Receivers have one order whatever that of the file, equal cells and equal places included.
    #[test]
    fn the_order_of_receivers_ignores_the_file() {
        let mut receivers: Vec<Receiver> = (0..300_u32)
            .map(|i| {
                let scatter = |k: u32| f64::from(i / 2 * k % 37) * 0.11;
                receiver(&format!("r{i}"), [78_000.0 + scatter(7), 457_000.0 + scatter(11), scatter(13)])
            })
            .collect();
        let ids = |receivers: &[Receiver]| -> Vec<String> {
            morton_order(receivers).into_iter().map(|i| receivers[i].id.clone()).collect()
        };
        let expected = ids(&receivers);
        assert_eq!(expected.len(), 300);
        receivers.reverse();
        assert_eq!(ids(&receivers), expected);
        receivers.rotate_left(101);
        receivers.swap(3, 250);
        assert_eq!(ids(&receivers), expected);
    }

    /// Keys of 400 receivers, many at equal places and with negative coordinates or either zero,
    /// sort as the receivers do, and give them back to the bit.
    #[test]
    fn keys_sort_as_receivers() {
        let receivers: Vec<Receiver> = (0..400_u32)
            .map(|i| {
                let coordinate = |k: u32| f64::from(i / 3 * k % 13) * 0.11 - 0.55;
                let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
                let place = [coordinate(5) * 0.0 * sign, coordinate(7), coordinate(11)];
                Receiver { normal: DVec3::new(0.6, 0.8 * sign, -0.0), ..receiver(&format!("r{}", i % 100), place) }
            })
            .collect();
        for shift in [DVec3::ZERO, DVec3::new(3e5, -0.1, 0.2)] {
            let moved = |r: &Receiver| Receiver { position: r.position + shift, ..r.clone() };
            let receivers: Vec<Receiver> = receivers.iter().map(moved).collect();
            let keys: Vec<Vec<u8>> = receivers.iter().map(morton_key).collect();
            let order = morton_order(&receivers);
            assert!(order.is_sorted_by_key(|&i| &keys[i]));
            for (receiver, key) in receivers.iter().zip(&keys) {
                let found = receiver_of_key(key).expect("a key");
                assert_eq!(found, *receiver);
                assert_eq!(found.position.x.to_bits(), receiver.position.x.to_bits());
            }
        }
        assert_eq!(receiver_of_key(&[0; 55]), None);
    }

    /// Eight clusters of 64 receivers come out as eight tiles of one cluster each.
    #[test]
    fn neighbours_share_tiles() {
        let receivers: Vec<Receiver> = (0..512_u32)
            .map(|i| {
                let (cluster, j) = (i % 8, i / 8);
                let corner = [cluster & 1, cluster >> 1 & 1, cluster >> 2].map(|side| f64::from(side) * 64.0 - 64.0);
                receiver(&format!("{cluster}"), [corner[0] + f64::from(j), corner[1], corner[2]])
            })
            .collect();
        let order = morton_order(&receivers);
        for tile in order.chunks(crate::site::receiver::TILE) {
            assert!(tile.iter().all(|&i| receivers[i].id == receivers[tile[0]].id));
        }
    }
}
