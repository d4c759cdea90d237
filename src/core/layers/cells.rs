//! Cells as plain tables, sorted by key, for fine probes and for the coarse cells of the bounce
//! system. In: traced cells, or tables of an archive. Out: columns that a replay reads.

use crate::layers::canopy::{Canopy, RayLists};
use crate::layers::mirror::CellMirrors;
use crate::site::cells::{CellKey, CellMap, sort_cells};

/// Table of cells: the sky and the coarse cells that each cell sees.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cells {
    /// Keys of the cells, sorted, no two equal.
    pub keys: Vec<CellKey>,
    /// `[cell]`: mean of the unit normals of the cell's points, at most 1 long.
    pub normals: Vec<[f32; 3]>,
    /// `[cell][texel / 8]`: sky bits, world frame, row-major, lowest bit first.
    pub bits: Vec<u8>,
    /// Coarse cells that rays of these cells met, sorted, no two equal.
    pub seen: Vec<CellKey>,
    /// `[cell][ray]`, equal weights, ascending: index into `seen`, plus [`DOWN`] for rays below the
    /// horizon; [`MISS`] for a ray that met nothing.
    pub hits: Vec<u32>,
    /// `[cell]`: sky and surfaces seen in mirrors; empty if no cell sees any.
    pub mirrors: Vec<CellMirrors>,
    /// `[cell]`: crossings of leaves along the cell's rays; empty if no cell has any.
    pub canopies: Vec<Canopy>,
    /// `[cell]`: [`Cell::doubtful`].
    pub doubtful: Vec<bool>,
}

/// Flag of a ray that goes below the horizon.
pub const DOWN: u32 = 1 << 31;
/// Index of a ray that met nothing.
pub const MISS: u32 = DOWN - 1;

/// Largest number of cells in a chunk.
const CHUNK: usize = 4096;
/// Largest number of indices that 15 bits of a block can tell apart, beside the one for nothing.
pub const CHUNK_SEEN: usize = (1 << 15) - 1;

/// Largest number of bytes of a chunk's sky bits: half of what a block may hold.
const CHUNK_SKY: usize = 1 << 22;

/// Returns the number of cells in a chunk of an archive, for cells with `rays` rays and a sky of
/// `texels` texels each. With that number, 15 bits number all cells that the chunk can see, and a
/// block can hold the chunk.
pub fn cells_per_chunk(rays: usize, texels: usize) -> usize {
    (CHUNK_SEEN / rays.max(1)).min(CHUNK_SKY / texels.div_ceil(8).max(1)).clamp(1, CHUNK)
}

/// One traced cell: its key, mean normal, sky bits, and for each ray whether it goes up and the
/// cell it met.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Key of the cell.
    pub key: CellKey,
    /// Mean of the unit normals of the cell's points, at most 1 long.
    pub normal: [f32; 3],
    /// Sky bits, world frame, row-major, lowest bit of a byte first.
    pub bits: Vec<u8>,
    /// `[ray]`: true if the ray goes above the horizon, and the bounce cell that it meets; `None`
    /// for nothing.
    pub seen: Vec<(bool, Option<CellKey>)>,
    /// Sky and surfaces that the cell sees in mirrors.
    pub mirrors: CellMirrors,
    /// Crossings of leaves along the cell's rays to the texels of its sky and to surfaces.
    pub canopy: Canopy,
    /// True if some of the cell's points seemed hidden, so that paths of light through the whole
    /// scene decided on them. Everything else in a cell depends only on its own surface and on what
    /// its own rays meet.
    pub doubtful: bool,
}

/// Number of bytes of a ray in [`Cell::to_bytes`].
const RAY_BYTES: usize = 1 + size_of::<u128>();

impl Cell {
    /// Returns the cells that this cell sees, directly, in mirrors and among leaves.
    pub fn reached(&self) -> impl Iterator<Item = CellKey> + '_ {
        self.seen.iter().filter_map(|seen| seen.1).chain(self.mirrors.cells()).chain(self.canopy.cells())
    }

    /// Returns the bytes of all fields but the key, for sorting outside memory.
    pub fn to_bytes(&self) -> Vec<u8> {
        let layers = [self.mirrors.to_bytes(self.bits.len()), self.canopy.to_bytes()];
        let lengths: usize = layers.iter().map(|layer| 4 + layer.len()).sum();
        let mut bytes = Vec::with_capacity(13 + self.bits.len() + lengths + RAY_BYTES * self.seen.len());
        bytes.push(u8::from(self.doubtful));
        bytes.extend(self.normal.iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend(&self.bits);
        for layer in &layers {
            bytes.extend((layer.len() as u32).to_le_bytes());
            bytes.extend(layer);
        }
        for (up, key) in &self.seen {
            bytes.push(u8::from(*up) | u8::from(key.is_some()) << 1);
            bytes.extend(key.map_or(0, CellKey::number).to_le_bytes());
        }
        bytes
    }

    /// Reads a cell with `texels` texels of sky from the bytes of [`CellKey::to_bytes`] and
    /// [`Cell::to_bytes`]. Returns `None` for any other bytes.
    pub fn from_bytes(key: &[u8], cell: &[u8], texels: usize) -> Option<Self> {
        let bits = texels.div_ceil(8);
        let (&doubtful, rest) = cell.split_first()?;
        let doubtful = doubtful != 0;
        let (normal, rest) = rest.split_first_chunk::<12>()?;
        let (bits, mut rest) = rest.split_at_checked(bits)?;
        let mut layer = || {
            let (length, tail) = rest.split_first_chunk()?;
            let (layer, tail) = tail.split_at_checked(u32::from_le_bytes(*length) as usize)?;
            rest = tail;
            Some(layer)
        };
        let (mirrors, canopy) = (layer()?, layer()?);
        let ray = |ray: &[u8; RAY_BYTES]| {
            let [flags, number @ ..] = *ray;
            let number = u128::from_le_bytes(number);
            (flags & 1 == 1, (flags & 2 == 2).then(|| CellKey::from_number(number)))
        };
        let (rays, []) = rest.as_chunks() else { return None };
        let (axes, _) = normal.as_chunks();
        let [x, y, z] = *axes else { return None };
        Some(Cell {
            key: CellKey::from_bytes(key.try_into().ok()?),
            normal: [x, y, z].map(f32::from_le_bytes),
            bits: bits.to_vec(),
            mirrors: CellMirrors::from_bytes(mirrors, bits.len())?,
            canopy: Canopy::from_bytes(canopy, RayLists::of_cell(texels, rays.len()), |_| true)?,
            seen: rays.iter().map(ray).collect(),
            doubtful,
        })
    }
}

impl Cells {
    /// Makes a table of traced cells, which are sorted by key and have equal numbers of texels and
    /// rays.
    pub fn new(cells: &[Cell]) -> Self {
        let (seen, numbers) = numbered(cells.iter().flat_map(|c| &c.seen).filter_map(|s| s.1));
        let number = |&(up, key): &(bool, Option<CellKey>)| {
            // `numbers` holds every cell that is seen.
            let index = key.and_then(|key| numbers.get(&key).copied()).unwrap_or(MISS);
            if up { index } else { index | DOWN }
        };
        let mut hits = Vec::with_capacity(cells.iter().map(|c| c.seen.len()).sum());
        for cell in cells {
            let start = hits.len();
            hits.extend(cell.seen.iter().map(number));
            // Rays count alike, so their order means nothing: sorted, they compress.
            hits[start..].sort_unstable();
        }
        Cells {
            keys: cells.iter().map(|c| c.key).collect(),
            normals: cells.iter().map(|c| c.normal).collect(),
            bits: cells.iter().flat_map(|c| c.bits.iter().copied()).collect(),
            seen,
            hits,
            mirrors: gathered(cells.iter().map(|c| &c.mirrors), CellMirrors::is_empty),
            canopies: gathered(cells.iter().map(|c| &c.canopy), Canopy::is_empty),
            doubtful: cells.iter().map(|c| c.doubtful).collect(),
        }
    }

    /// Returns the cells of `rows`, which ascend, with the cells that these see.
    pub fn select(&self, rows: &[usize]) -> Cells {
        let mut used = vec![false; self.seen.len()];
        let hits = || rows.iter().flat_map(|&row| self.hits_of(row).iter().copied());
        hits().filter(|hit| hit & !DOWN != MISS).for_each(|hit| used[(hit & !DOWN) as usize] = true);
        let mut seen = Vec::new();
        let numbers: Vec<u32> = used
            .iter()
            .zip(&self.seen)
            .map(|(&used, key)| {
                let number = seen.len() as u32;
                if used {
                    seen.push(*key);
                }
                number
            })
            .collect();
        Cells {
            keys: rows.iter().map(|&row| self.keys[row]).collect(),
            normals: rows.iter().map(|&row| self.normals[row]).collect(),
            bits: rows.iter().flat_map(|&row| self.bits_of(row).iter().copied()).collect(),
            seen,
            hits: hits().map(|hit| renumber(hit, &numbers)).collect(),
            mirrors: gathered(rows.iter().filter_map(|&row| self.mirrors.get(row)), CellMirrors::is_empty),
            canopies: gathered(rows.iter().filter_map(|&row| self.canopies.get(row)), Canopy::is_empty),
            doubtful: rows.iter().map(|&row| self.doubtful[row]).collect(),
        }
    }

    /// Joins tables one after the other; keys rise from table to table.
    pub fn join(parts: &[Cells]) -> Cells {
        let (seen, numbers) = numbered(parts.iter().flat_map(|p| p.seen.iter().copied()));
        let hits = parts.iter().flat_map(|part| {
            // `numbers` holds every cell that is seen.
            let numbers: Vec<u32> = part.seen.iter().map(|key| numbers.get(key).copied().unwrap_or(MISS)).collect();
            part.hits.iter().map(move |&hit| renumber(hit, &numbers))
        });
        Cells {
            keys: parts.iter().flat_map(|p| p.keys.iter().copied()).collect(),
            normals: parts.iter().flat_map(|p| p.normals.iter().copied()).collect(),
            bits: parts.iter().flat_map(|p| p.bits.iter().copied()).collect(),
            hits: hits.collect(),
            seen,
            mirrors: joined(parts.iter().map(|p| (p.rows(), p.mirrors.as_slice()))),
            canopies: joined(parts.iter().map(|p| (p.rows(), p.canopies.as_slice()))),
            doubtful: parts.iter().flat_map(|p| p.doubtful.iter().copied()).collect(),
        }
    }

    /// Returns the number of cells.
    pub fn rows(&self) -> usize {
        self.keys.len()
    }

    /// Returns what a cell sees in mirrors, or `None` if no cell of the table sees any.
    pub fn mirrors_of(&self, cell: usize) -> Option<&CellMirrors> {
        self.mirrors.get(cell)
    }

    /// Returns the crossings of leaves along a cell's rays, or `None` if no cell of the table has
    /// any.
    pub fn canopy_of(&self, cell: usize) -> Option<&Canopy> {
        self.canopies.get(cell)
    }

    /// Returns all cells that are seen, directly, in mirrors and among leaves; not sorted.
    pub fn reached(&self) -> impl Iterator<Item = CellKey> + '_ {
        let leaves = self.canopies.iter().flat_map(Canopy::cells);
        self.seen.iter().copied().chain(self.mirrors.iter().flat_map(CellMirrors::cells)).chain(leaves)
    }

    /// Returns the first cell that sees the cell `seen`, or `None` if no cell does.
    pub fn observer_of(&self, seen: &CellKey) -> Option<CellKey> {
        let sees = |&cell: &usize| {
            let mut hits = self.hits_of(cell).iter().filter(|hit| **hit & !DOWN != MISS);
            hits.any(|hit| self.seen[(hit & !DOWN) as usize] == *seen)
                || self.mirrors_of(cell).is_some_and(|mirrors| mirrors.cells().any(|key| key == *seen))
                || self.canopy_of(cell).is_some_and(|canopy| canopy.cells().any(|key| key == *seen))
        };
        (0..self.rows()).find(sees).map(|cell| self.keys[cell])
    }

    /// Returns the sky bits of a cell.
    pub fn bits_of(&self, cell: usize) -> &[u8] {
        let row = self.bits.len().checked_div(self.keys.len()).unwrap_or(0);
        &self.bits[cell * row..(cell + 1) * row]
    }

    /// Returns the hits of a cell's rays.
    pub fn hits_of(&self, cell: usize) -> &[u32] {
        let rays = self.hits.len().checked_div(self.keys.len()).unwrap_or(0);
        &self.hits[cell * rays..(cell + 1) * rays]
    }

    /// Returns one cell as it was given to [`Cells::new`], but for the order of its rays.
    pub fn cell(&self, cell: usize) -> Cell {
        let seen = |&hit: &u32| (hit & DOWN == 0, (hit & !DOWN != MISS).then(|| self.seen[(hit & !DOWN) as usize]));
        Cell {
            key: self.keys[cell],
            normal: self.normals[cell],
            bits: self.bits_of(cell).to_vec(),
            seen: self.hits_of(cell).iter().map(seen).collect(),
            mirrors: self.mirrors_of(cell).cloned().unwrap_or_default(),
            canopy: self.canopy_of(cell).cloned().unwrap_or_default(),
            doubtful: self.doubtful[cell],
        }
    }
}

/// Copies the rows of a layer; returns none if all are empty.
fn gathered<'a, T: Clone + 'a>(rows: impl Iterator<Item = &'a T> + Clone, is_empty: impl Fn(&T) -> bool) -> Vec<T> {
    if rows.clone().all(is_empty) { Vec::new() } else { rows.cloned().collect() }
}

/// Joins the rows of a layer of several tables, given with their numbers of cells. Returns none if
/// all tables have none.
fn joined<'a, T: Clone + Default + 'a>(parts: impl Iterator<Item = (usize, &'a [T])> + Clone) -> Vec<T> {
    let mut all = Vec::new();
    if parts.clone().any(|(_, rows)| !rows.is_empty()) {
        for (cells, rows) in parts {
            let end = all.len() + cells;
            all.extend_from_slice(rows);
            all.resize(end, T::default());
        }
    }
    all
}

/// Returns the keys sorted, each once, and the index of each key.
pub(super) fn numbered(keys: impl Iterator<Item = CellKey>) -> (Vec<CellKey>, CellMap<u32>) {
    // Most keys come many times, so duplicates go before the sort.
    let mut numbers: CellMap<u32> = keys.map(|key| (key, 0)).collect();
    let mut sorted: Vec<CellKey> = numbers.keys().copied().collect();
    sort_cells(&mut sorted);
    for (key, number) in sorted.iter().zip(0..) {
        numbers.insert(*key, number);
    }
    (sorted, numbers)
}

/// Returns a hit with the new number of the cell that it meets.
fn renumber(hit: u32, numbers: &[u32]) -> u32 {
    if hit & !DOWN == MISS { hit } else { hit & DOWN | numbers[(hit & !DOWN) as usize] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layers::mirror::CellPath;

    /// Three cells with four rays come back as they were. 15 bits suffice for a chunk of any number
    /// of rays, and a chunk with the finest skies fits into a block.
    #[test]
    fn cells_round_trip() {
        let key = |x: i32| CellKey { level: 1, facing: 5, material: 2, voxel: [x, 0, -x] };
        let cells: Vec<Cell> = (0..3)
            .map(|i| Cell {
                key: key(i),
                normal: [0.0, 0.6, 0.8],
                bits: vec![i as u8; 8],
                seen: vec![(true, Some(key(7))), (true, Some(key(9 + i))), (true, None), (false, Some(key(7)))],
                mirrors: CellMirrors {
                    windows: Vec::new(),
                    paths: vec![CellPath { up: true, cell: key(i), steps: vec![(2, 99)] }; i as usize],
                },
                canopy: Canopy::default(),
                doubtful: i == 1,
            })
            .collect();
        let table = Cells::new(&cells);
        assert_eq!(table.seen.len(), 4);
        for (i, cell) in cells.iter().enumerate() {
            assert_eq!(Cell::from_bytes(&cell.key.to_bytes(), &cell.to_bytes(), 64).as_ref(), Some(cell));
            let (mut back, mut cell) = (table.cell(i), cell.clone());
            back.seen.sort_unstable();
            cell.seen.sort_unstable();
            assert_eq!(back, cell);
        }
        let parts = [table.select(&[0]), table.select(&[1, 2])];
        let layers = |part: &Cells| [part.mirrors.len(), part.canopies.len()];
        assert_eq!((layers(&parts[0]), layers(&parts[1])), ([0, 0], [2, 0]));
        assert_eq!((table.observer_of(&key(2)), table.observer_of(&key(3))), (Some(key(2)), None));
        let bytes = cells[2].to_bytes();
        assert!((0..bytes.len()).all(|cut| cut == bytes.len() - 17 * ((bytes.len() - cut) / 17)
            || Cell::from_bytes(&key(2).to_bytes(), &bytes[..cut], 64).is_none()));
        assert_eq!((parts[0].seen.len(), Cells::join(&parts)), (2, table));
        for rays in 0..40_000 {
            let cells = cells_per_chunk(rays, 256);
            assert!((1..=4096).contains(&cells) && cells * rays.min(32_767) <= 32_767);
        }
        // Skies of 128 x 128 texels, with 64 bytes of each cell and 2 of each ray besides, fit a
        // block of 8 MiB.
        for rays in 1..=64 {
            assert!(cells_per_chunk(rays, 128 * 128) * (128 * 128 / 8 + 64 + 2 * rays) <= 8 << 20, "{rays}");
        }
    }
}
