//! Cells: the patches that surfaces are cut into, one probe each. In: a hit (point, normal,
//! material, distance). Out: its key.
//!
//! A key depends on the surface point and a cell size only, never on the ray or receiver that hit
//! it. Sizes are powers of two and their grids nest, so the cell of a coarser level holds whole
//! cells of every finer one.

use std::cmp::Ordering;
use std::collections::{HashMap, HashSet};
use std::hash::{BuildHasherDefault, Hash, Hasher};

use glam::DVec3;

use crate::hemisphere::mix;
use crate::site::morton::{BITS as MORTON_BITS, morton_cmp, spread};

/// Shift of the voxel grid, metres. It keeps walls and floors on round coordinates off the boundary
/// between two voxels at any level. The values are odd multiples of 2^-15, half a step of the grid
/// that vertices lie on, near the multiples of the golden ratio's powers 0.1382, 0.2090 and 0.0729.
pub const GRID_SHIFT_M: DVec3 = DVec3::new(4529.0 / 32_768.0, 6849.0 / 32_768.0, 2391.0 / 32_768.0);

/// Finest and coarsest level of cells: 1 mm to 2^20 m.
const LEVELS: (i8, i8) = (-10, 20);

/// Level of the window, 2^22 m, in which voxels are counted: the input's coordinates modulo the
/// window, from -2^21 to 2^21 m, take 32 bits at the finest level. A scene reaches at most 2^20 m
/// from its origin ([`grid::MAX_M`](crate::site::grid::MAX_M)), so no two of its places have one
/// voxel.
const WINDOW_LEVEL: i8 = 22;

/// Number of facing bins of fine cells: six cube faces of 3 x 3. Codes from here on name whole
/// faces, for coarse cells.
const FACINGS: u8 = 54;

/// Number added to the facing of cells on the back of their triangles. Light on the outside of a
/// wall is not seen from inside the solid, though the two sides may share a voxel and a facing with
/// their neighbours.
const BACK: u8 = 64;

/// Number added to the facing of cells of leaves, which hold both sides of their triangles: a leaf
/// sends the same light to either side.
const LEAF: u8 = 128;

/// Facing of cells of a volume of leaves, which face all ways.
const VOLUME: u8 = LEAF + FACINGS + 6;

/// Key of a cell: the surfaces of one material that face one way inside one voxel of edge 2^level
/// metres. Voxels are those of the input's coordinates, in every scene that holds the cell.
/// `facing` is one of 54 bins, or 54 + cube face for the coarse cells of the bounce system, plus 64
/// for the triangles' back, or 128 for both sides of leaves. It is 188 for a volume of leaves.
///
/// Keys are ordered by place first: by the Morton code of a region, then by the fields in the order
/// below. So neighbours lie near each other in an archive, and a part of a site needs a part of its
/// cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellKey {
    /// Edge of the voxel: 2^level metres.
    pub level: i8,
    /// Part of a cube's face that the normal points to; 64 is added for the back of triangles, 128
    /// for leaves; 188 for a volume of leaves.
    pub facing: u8,
    /// Row of the materials table.
    pub material: u16,
    /// Place in the grid of its level: x, y, z in edges of a voxel.
    pub voxel: [i32; 3],
}

/// Level of the regions that order cells: 64 m.
const REGION_LEVEL: i8 = 6;

impl Ord for CellKey {
    fn cmp(&self, other: &Self) -> Ordering {
        morton_cmp(self.region_voxel(), other.region_voxel()).then_with(|| self.number().cmp(&other.number()))
    }
}

/// Sorts cells. Their bytes sort as they do, and are made once: comparing keys costs more.
pub fn sort_cells(keys: &mut [CellKey]) {
    keys.sort_by_cached_key(|key| key.to_bytes());
}

impl Hash for CellKey {
    fn hash<H: Hasher>(&self, state: &mut H) {
        let [high, low] = [(self.number() >> 64) as u64, self.number() as u64];
        state.write_u64(high);
        state.write_u64(low);
    }
}

/// Hasher of cell keys: few instructions, equal in every run.
#[derive(Clone, Copy, Debug, Default)]
pub struct KeyHasher(u64);

impl Hasher for KeyHasher {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_u64(u64::from(byte)));
    }
    fn write_u64(&mut self, value: u64) {
        self.0 = mix(self.0, value);
    }
}

/// Map from cells to values, without an order.
pub type CellMap<T> = HashMap<CellKey, T, BuildHasherDefault<KeyHasher>>;

/// Set of cells, without an order.
pub type CellSet = HashSet<CellKey, BuildHasherDefault<KeyHasher>>;

impl PartialOrd for CellKey {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl CellKey {
    /// Length of [`CellKey::to_bytes`].
    pub const BYTES: usize = 24;

    /// Returns the Morton code of the region that holds the cell's lowest corner.
    fn region(self) -> u64 {
        let [x, y, z] = self.region_voxel().map(|v| spread(u64::from(v)));
        x | y << 1 | z << 2
    }

    /// Returns all fields as one number that sorts as they do.
    pub fn number(self) -> u128 {
        // Flipping the sign bit makes signed numbers sort as unsigned ones.
        let [level] = self.level.to_be_bytes();
        let head = u128::from(level ^ 0x80) << 24 | u128::from(self.facing) << 16 | u128::from(self.material);
        self.voxel.iter().fold(head, |number, &v| number << 32 | u128::from((v ^ i32::MIN) as u32))
    }

    /// Inverse of [`CellKey::number`].
    pub fn from_number(number: u128) -> Self {
        // `as` cuts each part out.
        let part = |shift: u32| (number >> shift) as u32;
        CellKey {
            level: (part(120) as u8 ^ 0x80).cast_signed(),
            facing: part(112) as u8,
            material: part(96) as u16,
            voxel: [64, 32, 0].map(|shift| part(shift).cast_signed() ^ i32::MIN),
        }
    }

    /// Returns the voxel of the region, 21 bits an axis.
    fn region_voxel(self) -> [u32; 3] {
        let finer = u32::from(REGION_LEVEL.saturating_sub(self.level).max(0).unsigned_abs()).min(31);
        let coarser = u32::from(self.level.saturating_sub(REGION_LEVEL).max(0).unsigned_abs()).min(31);
        let middle = 1_i64 << (MORTON_BITS - 1);
        self.voxel.map(|v| {
            let region = ((i64::from(v) << coarser) >> finer) + middle;
            region.clamp(0, 2 * middle - 1) as u32
        })
    }

    /// Returns bytes that sort as keys do, for sorting outside memory.
    pub fn to_bytes(self) -> [u8; CellKey::BYTES] {
        let mut bytes = [0; CellKey::BYTES];
        let (region, number) = bytes.split_at_mut(8);
        region.copy_from_slice(&self.region().to_be_bytes());
        number.copy_from_slice(&self.number().to_be_bytes());
        bytes
    }

    /// Inverse of [`CellKey::to_bytes`].
    pub fn from_bytes(bytes: &[u8; CellKey::BYTES]) -> Self {
        let number = bytes.last_chunk().copied().unwrap_or_default();
        CellKey::from_number(u128::from_be_bytes(number))
    }

    /// Returns the cell of edge 2^level metres that holds a surface point (input coordinates).
    /// `outward` is the triangle's normal; `back` says that its other side is seen.
    pub fn new(point: DVec3, outward: DVec3, back: bool, material: u16, level: i8) -> Self {
        let p = (point + GRID_SHIFT_M) / size_of(level);
        let voxel = p.to_array().map(|x| wrapped(floor(x), level));
        CellKey { level, facing: facing_code(outward, back), material, voxel }
    }

    /// Returns the cell of edge 2^level metres that holds a point of a leaf (input coordinates),
    /// the same for its two sides.
    pub fn leaf(point: DVec3, outward: DVec3, material: u16, level: i8) -> Self {
        let key = CellKey::new(point, upper(outward), false, material, level);
        CellKey { facing: key.facing + LEAF, ..key }
    }

    /// Returns the cell of edge 2^level metres that holds a point in a volume of leaves (input
    /// coordinates).
    pub fn volume(point: DVec3, material: u16, level: i8) -> Self {
        CellKey { facing: VOLUME, ..CellKey::new(point, DVec3::Z, false, material, level) }
    }

    /// Returns true if this is a cell of a volume of leaves.
    pub fn is_volume(self) -> bool {
        self.facing == VOLUME
    }

    /// Returns true if this is a cell of leaves, which holds both of their sides.
    pub fn is_leaf(self) -> bool {
        self.facing & LEAF != 0
    }

    /// Returns a cell without any surface, so without light. Its voxel lies half a window from the
    /// coordinates' origin on each axis, farther than a scene reaches. A receiver that no light
    /// reaches sees this cell only.
    pub fn dark(material: u16) -> Self {
        CellKey { level: LEVELS.0, facing: 0, material, voxel: [i32::MIN; 3] }
    }

    /// Returns the coarse cell, of level `level` or this cell's own if that is higher, that this
    /// cell lies in. It takes a whole cube face of directions.
    pub fn coarse(self, level: i8) -> Self {
        let shift = u32::from(level.saturating_sub(self.level).max(0).unsigned_abs()).min(31);
        CellKey {
            level: self.level.max(level),
            facing: if self.is_volume() { VOLUME } else { FACINGS + self.face() + (self.facing & (BACK | LEAF)) },
            voxel: self.voxel.map(|v| v >> shift),
            ..self
        }
    }

    /// Returns the normal of this cell's side of a triangle, if the triangle belongs to the cell.
    pub fn side_of(self, outward: DVec3) -> Option<DVec3> {
        let back = self.is_back();
        let outward = if self.is_leaf() { upper(outward) } else { outward };
        let belongs = self.holds(FaceTag::new(outward, self.material));
        belongs.then_some(if back { -outward } else { outward })
    }

    /// Returns true if a triangle of this tag belongs to the cell.
    pub fn holds(self, tag: FaceTag) -> bool {
        let [front, back] = tag.bins;
        let bin = match () {
            () if self.is_leaf() => {
                if is_upper(front) {
                    front
                } else {
                    back
                }
            }
            () if self.is_back() => back,
            () => front,
        };
        tag.material == self.material && if self.bin() < FACINGS { self.bin() == bin } else { self.face() == bin / 9 }
    }

    /// Returns true if this is the back of its triangles.
    pub fn is_back(self) -> bool {
        self.facing & BACK != 0
    }

    fn bin(self) -> u8 {
        self.facing & !(BACK | LEAF)
    }

    /// Returns the cube face 0..6: x+, x-, y+, y-, z+, z-.
    fn face(self) -> u8 {
        if self.bin() < FACINGS { self.bin() / 9 } else { (self.bin() - FACINGS) % 6 }
    }

    /// Returns the lowest corner of the voxel before the shift by [`GRID_SHIFT_M`], input
    /// coordinates. Of all voxels with that number it takes the one nearest to `near`, such as the
    /// scene's origin. The corner is a multiple of the cell's size.
    pub fn corner(self, near: DVec3) -> DVec3 {
        let (size, window) = (size_of(self.level), size_of(WINDOW_LEVEL));
        let corner = DVec3::from(self.voxel.map(f64::from)) * size;
        corner + ((near - corner - 0.5 * size) / window).round() * window
    }

    /// Returns the axis (0 x, 1 y, 2 z) and sign of the cube face that this cell's facing lies on.
    pub fn axis(self) -> (usize, f64) {
        let face = self.face();
        (usize::from(face / 2), if face.is_multiple_of(2) { 1.0 } else { -1.0 })
    }

    /// Returns the seed of everything random about this cell. It leaves out the material, because a
    /// variant of the site with one more material numbers them otherwise.
    pub fn seed(self) -> u64 {
        let head = (u64::from(self.level as u8) << 32) | (u64::from(self.facing) << 16);
        self.voxel.iter().fold(mix(0x6365_6c6c, head), |state, &v| mix(state, u64::from(v as u32)))
    }
}

/// Facts about a triangle that decide to which cells it belongs, in four bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaceTag {
    material: u16,
    /// Facing bins of its normal and of the opposite one.
    bins: [u8; 2],
}

impl FaceTag {
    /// Returns true if the triangle is of a material.
    pub fn is_of(self, material: u16) -> bool {
        self.material == material
    }

    /// Returns the tag of a triangle with this unit normal.
    pub fn new(outward: DVec3, material: u16) -> Self {
        FaceTag { material, bins: [facing_bin(outward), facing_bin(-outward)] }
    }

    /// Returns the material of the triangle.
    pub fn material(self) -> u16 {
        self.material
    }
}

/// Returns the edge of a cell of this level, metres.
pub fn size_of(level: i8) -> f64 {
    // The exponent bits of a power of two.
    f64::from_bits((1023 + i64::from(level)).cast_unsigned() << 52)
}

/// Returns the largest integer not above `x`, saturated to i64, without a call of the C library.
fn floor(x: f64) -> i64 {
    // `as` saturates: no input can overflow. Integers that f64 does not hold come from numbers
    // without a fraction.
    let towards_zero = x as i64;
    if towards_zero as f64 > x { towards_zero.saturating_sub(1) } else { towards_zero }
}

/// Returns the number of a voxel in the window: its lowest bits, with a sign. So the number of a
/// coarser voxel is that of a finer one, shifted.
fn wrapped(number: i64, level: i8) -> i32 {
    let bits = u32::from(WINDOW_LEVEL.saturating_sub(level).max(1).unsigned_abs()).min(32);
    ((number << (64 - bits)) >> (64 - bits)) as i32
}

/// Returns the level from -10 to 20 whose size is nearest (as a ratio) to `size_m`, by exact
/// exponent arithmetic, equal on every processor.
pub fn level_of(size_m: f64) -> i8 {
    // The exponent rounds down. The factor sqrt(2) moves the border to the geometric middle of two
    // powers.
    let exponent = ((size_m * std::f64::consts::SQRT_2).to_bits() >> 52) as i64 - 1023;
    exponent.clamp(i64::from(LEVELS.0), i64::from(LEVELS.1)) as i8
}

/// Returns the facing of one side of a triangle with this unit normal.
fn facing_code(outward: DVec3, back: bool) -> u8 {
    if back { facing_bin(-outward) + BACK } else { facing_bin(outward) }
}

/// Returns the one of the two normals of a leaf whose largest component is positive.
fn upper(normal: DVec3) -> DVec3 {
    if is_upper(facing_bin(normal)) { normal } else { -normal }
}

/// Returns true if the largest component of the normals of a bin is positive.
fn is_upper(bin: u8) -> bool {
    (bin / 9).is_multiple_of(2)
}

/// Returns the bin of a unit vector: cube face (x+, x-, y+, y-, z+, z-), then its 3 x 3 part.
fn facing_bin(n: DVec3) -> u8 {
    let a = n.abs();
    let (axis, p, q, major) = if a.z >= a.x && a.z >= a.y {
        (2, n.x, n.y, n.z)
    } else if a.x >= a.y {
        (0, n.y, n.z, n.x)
    } else {
        (1, n.x, n.z, n.y)
    };
    let third = |t: f64| -> u8 {
        // major is the largest of three components of a unit vector: at least 0.57.
        let t = t / major.abs();
        u8::from(t > -1.0 / 3.0) + u8::from(t > 1.0 / 3.0)
    };
    (axis * 2 + u8::from(major < 0.0)) * 9 + third(p) * 3 + third(q)
}

/// Shift of a receiver's place, metres, so that round coordinates do not lie between two
/// millimetres.
const PLACE_SHIFT_M: DVec3 = DVec3::new(0.138_196_6, 0.209_017_0, 0.072_949_0);

/// Returns the seed of a receiver's own jitter. It depends on the position in input coordinates to
/// the millimetre, modulo 2^22 m as voxels are, and on the normal, so that neither the receiver's
/// name nor its order counts.
pub fn receiver_seed(position: DVec3, normal: DVec3) -> u64 {
    // Components of normals along an axis are multiples of the unit. The offset keeps them off the
    // steps of `floor`, where a rounding error would give another seed.
    let q = |v: f64, unit: f64| ((v / unit + 0.381_966).floor() as i64) as u64;
    let window = size_of(WINDOW_LEVEL);
    let position = position - (position / window).round() * window;
    let p = (position + PLACE_SHIFT_M).to_array().map(|v| q(v, 1e-3));
    let n = normal.to_array().map(|v| q(v, 1e-4));
    p.iter().chain(&n).fold(0x7265_6376, |state, &v| mix(state, v))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemisphere::unit;

    /// Grids nest: the coarse cell of a point's fine cell is the point's own coarse cell, for 1,000
    /// points and 8 levels.
    #[test]
    fn grids_of_levels_nest() {
        let mut state = 1;
        for _ in 0..1000 {
            state = mix(state, 7);
            let p = DVec3::new((state % 2001) as f64, (state % 977) as f64, (state % 331) as f64) * 0.37 - 300.0;
            let fine = CellKey::new(p, DVec3::Z, false, 3, -1);
            for level in -1..7 {
                assert_eq!(fine.coarse(level), CellKey::new(p, DVec3::Z, false, 3, level).coarse(level));
                assert_eq!(fine.coarse(level).side_of(DVec3::Z), Some(DVec3::Z));
            }
            let low = fine.corner(DVec3::ZERO) - GRID_SHIFT_M;
            assert!(p.cmpge(low).all() && p.cmplt(low + 0.5).all());
        }
    }

    /// Keys come back from their bytes and numbers, and bytes sort as keys do. 4,000 keys of 8
    /// levels lie region by region: each of the 418 regions of 64 m is met once.
    #[test]
    fn order_is_by_place() {
        let mut keys = Vec::new();
        for i in 0..4000_u64 {
            let part = |k: u64| (mix(i, k) % 4001) as f64 * 0.1 - 200.0;
            let level = (mix(i, 9) % 8) as i8 - 2;
            keys.push(CellKey::new(DVec3::new(part(1), part(2), part(3)), DVec3::Z, i % 3 == 0, (i % 5) as u16, level));
        }
        let mut by_bytes = keys.clone();
        keys.sort();
        by_bytes.sort_by_key(|k| k.to_bytes());
        assert_eq!(keys, by_bytes);
        assert!(
            keys.iter().all(|k| CellKey::from_bytes(&k.to_bytes()) == *k && CellKey::from_number(k.number()) == *k)
        );
        let corner = |k: &CellKey| k.voxel.map(|v| v >> (6 - k.level));
        keys.dedup_by_key(|k| corner(k));
        let regions: std::collections::BTreeSet<[i32; 3]> = keys.iter().map(corner).collect();
        assert_eq!((keys.len(), regions.len()), (418, 418));
        let far = CellKey { level: 24, facing: 0, material: 0, voxel: [i32::MAX, i32::MIN, 0] };
        assert_eq!(CellKey::from_bytes(&far.to_bytes()), far);
    }

    /// All 54 facing bins are reached, and opposite normals never share one.
    #[test]
    fn all_54_facings_are_reached() {
        let mut seen = std::collections::BTreeSet::new();
        for i in 0..4000_u64 {
            let d = crate::hemisphere::direction_of(crate::hemisphere::jitter(5, i));
            let d = if i % 2 == 0 { d } else { -d };
            assert_ne!(facing_bin(d), facing_bin(-d));
            seen.insert(facing_bin(d));
        }
        assert_eq!(seen.len(), usize::from(FACINGS));
    }

    /// The back of a triangle that faces up is a cell that faces down, and no front belongs to it:
    /// 2 of 4 pairs match.
    #[test]
    fn the_two_sides_of_a_triangle_are_different_cells() {
        let cells = [false, true].map(|back| CellKey::new(DVec3::ONE, DVec3::Z, back, 0, 1));
        assert_eq!(cells.map(|c| c.side_of(DVec3::Z)), [Some(DVec3::Z), Some(DVec3::NEG_Z)]);
        assert_eq!(cells.map(|c| c.side_of(DVec3::NEG_Z)), [None, None]);
        assert_eq!(cells.map(CellKey::axis), [(2, 1.0), (2, -1.0)]);
    }

    /// Leaves of opposite normals lie in one cell, which has the normal of the larger component,
    /// also when the cell is coarser: 2 of 2. The facing is that of an opaque cell plus 128, and a
    /// triangle that faces elsewhere does not belong.
    #[test]
    fn leaves_of_opposite_normals_share_a_cell() {
        for (normal, side) in [(DVec3::new(0.6, 0.0, -0.8), -1.0), (DVec3::new(0.8, 0.0, -0.6), 1.0)] {
            let [one, other] = [normal, -normal].map(|n| CellKey::leaf(DVec3::ONE, n, 3, 0));
            assert_eq!((one, one.is_leaf(), one.is_back()), (other, true, false));
            for key in [one, one.coarse(2)] {
                assert_eq!([normal, -normal].map(|n| key.side_of(n)), [Some(normal * side); 2]);
                assert_eq!(key.side_of(DVec3::Y), None);
            }
            assert_eq!(one.facing, CellKey::new(DVec3::ONE, normal * side, false, 3, 0).facing + 128);
        }
    }

    /// Levels round to the nearest power of two: 0.5 m is -1, 1.4 m is 0, 1.5 m is 1, 30 m is 5;
    /// all 256 have the size 2^level.
    #[test]
    fn levels_round_to_the_nearest_power_of_two() {
        assert_eq!([0.5, 1.4, 1.5, 4.0, 30.0].map(level_of), [-1, 0, 1, 2, 5]);
        for level in i8::MIN..=i8::MAX {
            assert_eq!(size_of(level), f64::powi(2.0, i32::from(level)));
        }
    }

    /// At 12 places from -9,000 km to 9,000 km voxels of 31 levels hold the point that they were
    /// made of, to 4e-9 m, if their corner is looked for around a point up to 1,000 km away. Grids
    /// nest there, and seeds do not depend on the material.
    #[test]
    fn far_voxels_hold_the_point_they_were_made_of() {
        for i in 0..12_u64 {
            let part = |k: u64| (unit(mix(i, k)) - 0.5) * 18e6;
            let (p, near) = (DVec3::new(part(1), part(2), part(3)), DVec3::new(9e5, -1e6, 1e6));
            let finest = CellKey::new(p, DVec3::X, false, 0, LEVELS.0);
            for level in LEVELS.0..=LEVELS.1 {
                let key = CellKey::new(p, DVec3::X, false, 7, level);
                let low = key.corner(p + near) - GRID_SHIFT_M;
                assert!(p.cmpge(low - 4e-9).all() && p.cmple(low + size_of(level) + 4e-9).all(), "{p} {level}");
                assert_eq!(finest.coarse(level).voxel, key.voxel);
                assert_eq!(key.seed(), CellKey { material: 0, ..key }.seed());
            }
        }
    }

    /// Twelve numbers, also beyond i32 and i64 and NaN, have the floor that the standard library
    /// gives them.
    #[test]
    fn floors_equal_those_of_the_standard_library() {
        let far = 2147483648.0;
        for x in [0.0, -0.0, 0.5, -0.5, 7.0, -7.0, -7.1, far, -far, -far - 0.5, 1e300, f64::NAN] {
            assert_eq!(floor(x), x.floor() as i64, "{x}");
        }
    }
}
