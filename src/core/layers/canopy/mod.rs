//! The canopy layer: how often rays cross leaves and screens, how long they are in volumes of
//! leaves, and which light-scattering leaves they see. In: crossings along the rays of one receiver
//! or cell. Out: its bytes, and back; and, for given transmittances, the share of the light that
//! passes along each ray.
//!
//! Counts are bit planes of blocks of 64 rays. A block without crossings takes one bit. The count
//! of a volume is the code of a length. Along a receiver's square of sky rays counts are predicted
//! from each other. Leaves are kept by cell and by the materials crossed before them, with the
//! share of the hemisphere whose rays cross them there.

mod counts;
mod square;

use std::collections::BTreeMap;
use std::sync::LazyLock;

use crate::site::cells::CellKey;
use crate::site::crossing::Crossing;
use counts::Counts;
pub use square::{coarse_step, mean_code};

/// Index of the list of rays towards the texels of the sky. A receiver or a cell has two lists of
/// rays.
pub const SKY: usize = 0;
/// Index of the list of rays to surfaces: to the texels of a receiver's hits, or the rays of a
/// cell.
pub const SEEN: usize = 1;

/// Shares of the light that pass 0, 1, ... 1023 crossings, or the lengths of these codes, by
/// material.
pub type Powers = BTreeMap<u16, [f32; COUNTS]>;

/// Number of counts of crossings, and of codes of lengths: 0 to 1023.
pub const COUNTS: usize = 1024;

/// Ratio of the steps between neighbouring codes of lengths, and length of code 1, metres. Steps
/// are 2.5 mm in gaps and 0.5 % of long ways, up to 82 m: the light that is left is off by at most
/// 0.1 % of the light without leaves.
const LENGTH_RATIO: f64 = 1.005;
const LENGTH_1_M: f64 = 0.0025;

/// `[code]`: lengths, metres: 0, 0.0025, 0.0050125, ... 81.7.
static LENGTHS_M: LazyLock<[f64; COUNTS]> = LazyLock::new(|| {
    std::array::from_fn(|code| LENGTH_1_M * (LENGTH_RATIO.powi(code as i32) - 1.0) / (LENGTH_RATIO - 1.0))
});

/// Returns the length of a code, metres.
pub fn length_of(code: u16) -> f64 {
    LENGTHS_M[usize::from(code).min(COUNTS - 1)]
}

/// Returns the code next to a length in metres, at least 1.
pub fn code_of(length_m: f64) -> u16 {
    let longer = LENGTHS_M.partition_point(|length| *length < length_m).clamp(1, COUNTS - 1);
    let is_high = longer == 1 || length_m - LENGTHS_M[longer - 1] >= LENGTHS_M[longer] - length_m;
    if is_high { longer as u16 } else { longer as u16 - 1 }
}

/// Side above which a receiver's square of sky rays is halved. There texels are a fifth of a degree
/// apart, and edges of crowns cause less error than reflected light does.
const LARGEST: usize = 1024;

/// Returns the side of a receiver's square of sky rays for the `base` and `fine` sides of its sky
/// texture. Each texel of the square covers a whole number of fine texels a side.
pub fn sky_side(base: usize, fine: usize) -> usize {
    let mut side = base.max(fine / 2);
    while side > LARGEST && side.is_multiple_of(2) {
        side /= 2;
    }
    side
}

/// Numbers of the rays of a receiver or cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayLists {
    /// Number of rays of each list.
    lists: [usize; 2],
    /// True if the rays to the sky are those of a receiver's square.
    square: bool,
}

impl RayLists {
    /// Returns the rays of a receiver with a square of `side` sky rays a side and `seen` rays to
    /// surfaces.
    pub fn of_receiver(side: usize, seen: usize) -> Self {
        RayLists { lists: [side.saturating_mul(side), seen], square: true }
    }

    /// Returns the rays of a cell with `texels` texels of the sky and `seen` rays to surfaces.
    pub fn of_cell(texels: usize, seen: usize) -> Self {
        RayLists { lists: [texels, seen], square: false }
    }
}

/// Crossings of one receiver or cell. All values without crossings are equal.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Canopy {
    /// Number of rays of both lists; 0 where nothing is crossed.
    rays: [usize; 2],
    /// Materials in ascending order, each with its counts along both lists of rays.
    materials: Vec<(u16, [Counts; 2])>,
    /// Leaves in ascending order; no two have the same cell and the same materials before it.
    leaves: Vec<SeenLeaf>,
}

/// Leaves of one cell, all seen through the same crossings.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenLeaf {
    /// The cell of leaves.
    pub cell: CellKey,
    /// Materials that are crossed before the leaves, ascending, and how often each is crossed.
    pub before: Vec<(u16, u16)>,
    /// Cosine-weighted share of the hemisphere whose rays cross the leaves, above 0. A ray that
    /// crosses several leaves counts for each. Where leaves are many, some stand for others. In a
    /// volume it is the share times the optical depth for which the leaves stand.
    pub share: f32,
}

/// Largest share of a [`SeenLeaf`]. It may exceed 1, since some leaves stand for others.
const MAX_SHARE: f32 = 256.0;

// Shares are no NaN.
impl Eq for SeenLeaf {}

impl Canopy {
    /// Makes the layer from the crossings along both lists, each sorted by ray, the numbers of rays
    /// of the lists, and the leaves that are seen.
    pub fn new(crossings: [&[Crossing]; 2], rays: [usize; 2], mut leaves: Vec<SeenLeaf>) -> Self {
        leaves.retain(|leaf| leaf.share > 0.0);
        leaves.sort_by(|a, b| a.cell.cmp(&b.cell).then_with(|| a.before.cmp(&b.before)));
        if crossings.iter().all(|list| list.is_empty()) && leaves.is_empty() {
            return Canopy::default();
        }
        let mut of_material: BTreeMap<u16, [Vec<&Crossing>; 2]> = BTreeMap::new();
        for (list, crossings) in crossings.into_iter().enumerate() {
            for crossing in crossings {
                of_material.entry(crossing.material).or_default()[list].push(crossing);
            }
        }
        let counted = |(material, lists): (u16, [Vec<&Crossing>; 2])| (material, lists.map(|list| Counts::new(&list)));
        Canopy { rays, materials: of_material.into_iter().map(counted).collect(), leaves }
    }

    /// Predicts the counts along the square of a receiver's sky rays from each other, where this
    /// takes fewer bytes.
    pub fn with_predicted(mut self) -> Self {
        let predicted = |(material, [sky, seen]): (u16, [Counts; 2])| (material, [sky.predicted(self.rays[SKY]), seen]);
        self.materials = self.materials.into_iter().map(predicted).collect();
        self
    }

    /// Returns true if nothing is crossed and no leaves are seen.
    pub fn is_empty(&self) -> bool {
        self.materials.is_empty() && self.leaves.is_empty()
    }

    /// Returns the cells of the leaves that are seen.
    pub fn cells(&self) -> impl Iterator<Item = CellKey> + '_ {
        self.leaves.iter().map(|leaf| leaf.cell)
    }

    /// Returns the leaves that are seen.
    pub fn seen_leaves(&self) -> &[SeenLeaf] {
        &self.leaves
    }

    /// Returns the materials that rays of a list cross, ascending.
    pub fn crossed(&self, list: usize) -> impl Iterator<Item = u16> + '_ {
        self.materials.iter().filter(move |(_, lists)| !lists[list].is_empty()).map(|(material, _)| *material)
    }

    /// Returns the crossings of one material alone, without leaves.
    pub fn only(&self, material: u16) -> Canopy {
        let materials = self.materials.iter().filter(|(other, _)| *other == material).cloned().collect();
        Canopy { rays: self.rays, materials, leaves: Vec::new() }
    }

    /// Returns the materials that each ray of a list crosses, ascending, and how often, for the
    /// rays that cross any.
    pub fn crossings(&self, list: usize) -> BTreeMap<usize, Vec<(u16, u16)>> {
        let mut found: BTreeMap<usize, Vec<(u16, u16)>> = BTreeMap::new();
        for (material, lists) in &self.materials {
            lists[list].for_each(|ray, count| found.entry(ray).or_default().push((*material, count)));
        }
        found
    }

    /// Returns the cells of leaves, each once, with the share of the hemisphere whose light comes
    /// from them through the crossings before them.
    pub fn leaves(&self, powers: &Powers) -> Vec<(CellKey, f32)> {
        let left = |leaf: &SeenLeaf| {
            let through =
                |&(material, count): &(u16, u16)| powers.get(&material).map_or(1.0, |of| of[usize::from(count)]);
            leaf.share * leaf.before.iter().map(through).product::<f32>()
        };
        let of_cells = self.leaves.chunk_by(|a, b| a.cell == b.cell);
        of_cells.filter_map(|of_cell| Some((of_cell.first()?.cell, of_cell.iter().map(left).sum()))).collect()
    }

    /// Returns the bytes of one row of a block; none where nothing is crossed.
    pub fn to_bytes(&self) -> Vec<u8> {
        if self.is_empty() {
            return Vec::new();
        }
        let mut bytes = (self.materials.len() as u16).to_le_bytes().to_vec();
        bytes.extend(self.materials.iter().flat_map(|(material, _)| material.to_le_bytes()));
        for (counts, rays) in self.materials.iter().flat_map(|(_, lists)| lists.iter().zip(self.rays)) {
            counts.put(&mut bytes, rays);
        }
        for leaf in &self.leaves {
            bytes.extend(leaf.cell.to_bytes());
            bytes.extend(leaf.share.to_le_bytes());
            bytes.push(leaf.before.len() as u8);
            for (material, count) in &leaf.before {
                bytes.extend(material.to_le_bytes());
                bytes.extend(count.to_le_bytes());
            }
        }
        bytes
    }

    /// Reads the bytes of [`Canopy::to_bytes`]. Returns `None` if the bytes are anything else or
    /// name a material that is no canopy. It allocates at most 1024 times the bytes, and one
    /// square.
    pub fn from_bytes(bytes: &[u8], rays: RayLists, is_canopy: impl Fn(u16) -> bool) -> Option<Self> {
        let RayLists { lists: rays, square } = rays;
        if bytes.is_empty() {
            return Some(Canopy::default());
        }
        let (count, rest) = bytes.split_first_chunk()?;
        let (names, mut rest) = rest.split_at_checked(2 * usize::from(u16::from_le_bytes(*count)))?;
        let names: Vec<u16> = names.as_chunks().0.iter().map(|name| u16::from_le_bytes(*name)).collect();
        if !names.array_windows().all(|[a, b]| a < b) || !names.iter().all(|&name| is_canopy(name)) {
            return None;
        }
        let mut materials = Vec::with_capacity(names.len());
        for name in names {
            let lists = [Counts::take(&mut rest, rays[SKY], square)?, Counts::take(&mut rest, rays[SEEN], false)?];
            materials.push((name, lists));
        }
        let mut leaves: Vec<SeenLeaf> = Vec::new();
        while !rest.is_empty() {
            let leaf = SeenLeaf::take(&mut rest, &is_canopy)?;
            let rises = |last: &SeenLeaf| (last.cell, &last.before) < (leaf.cell, &leaf.before);
            if !leaves.last().is_none_or(rises) {
                return None;
            }
            leaves.push(leaf);
        }
        (!materials.is_empty() || !leaves.is_empty()).then_some(Canopy { rays, materials, leaves })
    }

    /// Gives the materials new numbers, which rise as the old ones do. Returns `None` if a material
    /// has no new number.
    pub fn renumbered(&self, number: impl Fn(u16) -> Option<u16>) -> Option<Self> {
        let material = |(material, lists): &(u16, [Counts; 2])| Some((number(*material)?, lists.clone()));
        let leaf = |leaf: &SeenLeaf| {
            let before = leaf.before.iter().map(|&(material, count)| Some((number(material)?, count)));
            let cell = CellKey { material: number(leaf.cell.material)?, ..leaf.cell };
            Some(SeenLeaf { cell, before: before.collect::<Option<_>>()?, share: leaf.share })
        };
        Some(Canopy {
            rays: self.rays,
            materials: self.materials.iter().map(material).collect::<Option<_>>()?,
            leaves: self.leaves.iter().map(leaf).collect::<Option<_>>()?,
        })
    }

    /// Returns the share of the light that passes along each ray of a list, or `None` where nothing
    /// is crossed.
    pub fn through(&self, list: usize, powers: &Powers) -> Option<Vec<f32>> {
        let mut shares: Option<Vec<f32>> = None;
        for (material, lists) in &self.materials {
            if let Some(powers) = powers.get(material).filter(|_| !lists[list].is_empty()) {
                let shares = shares.get_or_insert_with(|| vec![1.0; self.rays[list]]);
                lists[list].dim(shares, powers);
            }
        }
        shares
    }

    /// Returns the largest count of one material along one ray.
    pub fn most(&self) -> u16 {
        self.materials.iter().flat_map(|(_, lists)| lists).map(Counts::most).max().unwrap_or(0)
    }
}

impl SeenLeaf {
    /// Reads one leaf from the front of `bytes` and moves past it.
    fn take(bytes: &mut &[u8], is_canopy: impl Fn(u16) -> bool) -> Option<Self> {
        let (cell, rest) = bytes.split_first_chunk()?;
        let (share, rest) = rest.split_first_chunk()?;
        let (&count, rest) = rest.split_first()?;
        let (before, rest) = rest.split_at_checked(4 * usize::from(count))?;
        *bytes = rest;
        let crossed = |[a, b, c, d]: &[u8; 4]| (u16::from_le_bytes([*a, *b]), u16::from_le_bytes([*c, *d]));
        let before: Vec<(u16, u16)> = before.as_chunks().0.iter().map(crossed).collect();
        let leaf = SeenLeaf { cell: CellKey::from_bytes(cell), before, share: f32::from_le_bytes(*share) };
        let rising = leaf.before.array_windows().all(|[a, b]| a.0 < b.0);
        let is_crossed =
            |&(material, count): &(u16, u16)| count > 0 && usize::from(count) < COUNTS && is_canopy(material);
        let crossed = leaf.before.iter().all(is_crossed);
        let good = leaf.cell.is_leaf() && is_canopy(leaf.cell.material) && leaf.share > 0.0 && leaf.share <= MAX_SHARE;
        (rising && crossed && good).then_some(leaf)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemisphere::mix;

    /// Counts of 1 to 1023 of two materials along 1000 and 9 rays come back with the product of the
    /// powers along each ray (1009 values, 1e-6). Two cells of leaves come back with the share seen
    /// through their crossings. All truncated rows but 3 are refused, and so are a longer row, a
    /// material that is no canopy, an eleventh plane, a ray behind the last one and 5 impossible
    /// leaves.
    #[test]
    fn crossings_come_back_and_bad_rows_are_refused() {
        let rays = [1000, 9];
        let count = |material: u16, ray: u32| match mix(u64::from(material), u64::from(ray)) {
            seed if seed % 3 == 0 => ((seed >> 8) as u16 % 1024) >> (ray / 200),
            _ => 0,
        };
        let crossings = |list: usize| -> Vec<Crossing> {
            let of = |ray| [3, 700].map(|material| Crossing { ray, material, count: count(material, ray) });
            (0..rays[list] as u32).flat_map(of).filter(|crossing| crossing.count > 0).collect()
        };
        let leaf = |x: i32, before: &[(u16, u16)]| SeenLeaf {
            cell: CellKey { level: 1, facing: 130, material: 3, voxel: [x, 0, 7] },
            before: before.to_vec(),
            share: 0.25,
        };
        let leaves = vec![leaf(4, &[(3, 2), (700, 1)]), leaf(4, &[]), leaf(-9, &[(700, 1023)])];
        let canopy = Canopy::new([&crossings(0), &crossings(1)], rays, leaves);
        let bytes = canopy.to_bytes();
        let read = |bytes: &[u8]| {
            Canopy::from_bytes(bytes, RayLists::of_cell(1000, 9), |material| material == 3 || material == 700)
        };
        assert_eq!(read(&bytes).as_ref(), Some(&canopy));
        let table = |tau: f64| std::array::from_fn(|k| tau.powi(k as i32) as f32);
        let powers = Powers::from([(3, table(0.9)), (700, table(0.99))]);
        for list in [SKY, SEEN] {
            let through = canopy.through(list, &powers).unwrap_or_default();
            for (ray, share) in (0..rays[list] as u32).zip(through) {
                let expected = 0.9_f64.powi(count(3, ray).into()) * 0.99_f64.powi(count(700, ray).into());
                assert!((f64::from(share) - expected).abs() < 1e-6);
            }
        }
        let most = [SKY, SEEN].iter().flat_map(|list| crossings(*list)).map(|crossing| crossing.count).max();
        assert!(Some(canopy.most()) == most && most > Some(1000) && Canopy::default().to_bytes().is_empty());
        let seen = canopy.leaves(&powers);
        assert_eq!((canopy.cells().count(), seen.len(), seen[0].0.voxel), (3, 2, [-9, 0, 7]));
        let both = 0.25 * (1.0 + 0.9 * 0.9 * 0.99);
        assert!((seen[1].1 - both).abs() < 1e-6 && seen[0].1 < 0.25 * 0.08, "{seen:?}");
        // A row cut between leaves, or before them, is a valid row; no other cut is.
        assert_eq!((1..bytes.len()).filter(|&cut| read(&bytes[..cut]).is_some()).count(), 3);
        let shade = Canopy::new([&[], &[]], rays, vec![leaf(4, &[])]);
        assert_eq!(read(&shade.to_bytes()).as_ref(), Some(&shade));
        let wrong: [fn(&mut SeenLeaf); 5] = [
            |leaf| leaf.cell.facing = 2,
            |leaf| leaf.cell.material = 4,
            |leaf| leaf.share = f32::NAN,
            |leaf| leaf.share = 257.0,
            |leaf| leaf.before = vec![(3, 0)],
        ];
        for spoil in wrong {
            let mut leaf = leaf(4, &[]);
            spoil(&mut leaf);
            assert_eq!(read(&Canopy { rays, materials: Vec::new(), leaves: vec![leaf] }.to_bytes()), None);
        }
        let longer = [&bytes[..], &[0]].concat();
        assert!(
            read(&longer).is_none()
                && Canopy::from_bytes(&bytes, RayLists::of_cell(1000, 9), |material| material == 3).is_none()
        );
        let few = Crossing { ray: 8, material: 3, count: 1 };
        let few = Canopy::new([&[few], &[]], [9, 9], Vec::new()).to_bytes();
        assert_eq!((few.len(), Canopy::from_bytes(&few, RayLists::of_cell(8, 9), |_| true)), (15, None));
        let mut eleventh = few.clone();
        eleventh[4] = 11;
        eleventh.extend([0; 80]);
        assert_eq!(Canopy::from_bytes(&eleventh, RayLists::of_cell(9, 9), |_| true), None);
    }

    /// Lengths in a volume along a receiver's square of 32 x 32 rays are predicted, and counts of a
    /// screen that differ from ray to ray are not. Both come back, and so do the crossings along
    /// the other rays. A cell has no predicted row, and neither has an odd square or one of few
    /// lengths. Rows with a changed byte are refused or written as they were read, 2,000 cases.
    #[test]
    fn lengths_along_a_square_are_predicted() {
        let crossed = |rays: u32, most: u32| -> Vec<Crossing> {
            let of = |ray| [(1, 400 + ray % 32), (2, ray % 2)].map(|(material, count)| (ray, material, count as u16));
            let all = (0..rays).filter(|ray| ray % 32 < most).flat_map(of).filter(|(_, _, count)| *count > 0);
            all.map(|(ray, material, count)| Crossing { ray, material, count }).collect()
        };
        let canopy = |side: u32, most: u32, square: bool| {
            let lists = [&crossed(side * side, most)[..], &crossed(9, 9)];
            let plain = Canopy::new(lists, [(side * side) as usize, 9], Vec::new());
            if square { plain.with_predicted() } else { plain }
        };
        let read = |bytes: &[u8], rays: RayLists| Canopy::from_bytes(bytes, rays, |material| material < 3);
        let (plain, predicted) = (canopy(32, 20, false), canopy(32, 20, true));
        let [before, bytes] = [&plain, &predicted].map(Canopy::to_bytes);
        assert!(3 * bytes.len() < 2 * before.len(), "{} {}", before.len(), bytes.len());
        assert_eq!(read(&bytes, RayLists::of_receiver(32, 9)).as_ref(), Some(&predicted));
        assert_eq!(read(&before, RayLists::of_receiver(32, 9)).as_ref(), Some(&plain));
        assert!([SKY, SEEN].iter().all(|list| plain.crossings(*list) == predicted.crossings(*list)));
        assert_eq!(read(&bytes, RayLists::of_cell(32 * 32, 9)), None);
        assert_eq!(read(&bytes, RayLists::of_receiver(30, 9)), None);
        assert!(canopy(31, 20, true) == canopy(31, 20, false));
        let few = Canopy::new([&[Crossing { ray: 40, material: 1, count: 9 }], &[]], [1024, 9], Vec::new());
        assert!(few.clone().with_predicted() == few);
        let mut other = 0;
        for case in 0..2_000 {
            let mut bad = bytes.clone();
            let at = mix(case, 1) as usize % bad.len();
            bad[at] = mix(case, 2) as u8;
            let Some(found) = read(&bad, RayLists::of_receiver(32, 9)) else { continue };
            assert!(found.to_bytes() == bad);
            other += usize::from(found != predicted);
        }
        assert!(other > 20, "{other}");
    }

    /// Lengths from 1 mm to 80 m come back from their codes within 1.3 mm and 0.25 %; longer ones
    /// are 81.7 m, and no length is code 0.
    #[test]
    fn lengths_come_back_from_their_codes() {
        for i in 0..3950 {
            let length = 0.001 * 1.002_853_f64.powi(i);
            let off = (length_of(code_of(length)) - length).abs();
            assert!(off < 0.001_51 + 0.002_51 * length, "{length} {off}");
        }
        assert_eq!([0.0, 1e-9, 1e9].map(code_of), [1, 1, 1023]);
        assert!((length_of(1023) - 81.7).abs() < 0.1 && length_of(0) == 0.0);
    }

    /// Among 40,000 rows of random bytes after a plausible start, at least 80 are read. Each of
    /// these has shares from 0 to 1 along all of its 130 and 40 rays, and is written as it was.
    #[test]
    fn random_rows_that_are_read_hold_shares() {
        let powers = Powers::from([(1, std::array::from_fn(|k| 0.5_f32.powi(k as i32)))]);
        let mut taken = 0;
        for case in 0..40_000_u64 {
            let bits = (mix(case, 1) % 12) as u8;
            let planes = 8 * usize::from(bits) * (mix(case, 2) % 4) as usize;
            let random = (0..1 + planes).map(|i| (mix(case, i as u64 + 9) >> (mix(case, 3) % 9)) as u8);
            let tail = if case % 3 == 0 { vec![0, 0] } else { vec![0] };
            let row: Vec<u8> = [1, 0, 1, 0, bits].into_iter().chain(random).chain(tail).collect();
            let read = Canopy::from_bytes(&row, RayLists::of_cell(130, 40), |material| material == 1);
            let Some(canopy) = read else { continue };
            assert!(canopy.to_bytes() == row);
            taken += 1;
            for list in [SKY, SEEN] {
                let shares = canopy.through(list, &powers).unwrap_or_default();
                assert!(shares.iter().all(|share| (0.0..=1.0).contains(share)));
            }
        }
        assert!(taken >= 80, "{taken}");
    }
}
