//! Cells as plain tables, sorted by key: fine probes and the coarse cells of the bounce system alike. In: traced cells, or tables
//! of an archive. Out: columns that recombination reads.

use crate::layers::extras::{Extras, MIRROR};
use crate::layers::mirror::CellMirrors;
use crate::site::cells::{CellKey, CellMap};

/// Some cells: what each sees of the sky and which coarse cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cells {
    /// Sorted, no two equal.
    pub keys: Vec<CellKey>,
    /// Mean unit normal of the cell's points.
    pub normals: Vec<[f32; 3]>,
    /// [cell][texel / 8], world frame, row-major, lowest bit first.
    pub bits: Vec<u8>,
    /// The coarse cells that rays of these cells met: sorted, no two equal.
    pub seen: Vec<CellKey>,
    /// [cell][ray], equal weights, ascending: index into `seen`, plus [`DOWN`] for rays below the horizon; [`MISS`] for nothing.
    pub hits: Vec<u32>,
    /// `[layer][cell]`, see [`crate::layers::extras`]; no rows for a layer that no cell has.
    pub extras: [Vec<Vec<u8>>; 2],
}

/// Flag of a ray that goes below the horizon.
pub const DOWN: u32 = 1 << 31;
/// Index of a ray that met nothing.
pub const MISS: u32 = DOWN - 1;

/// Most cells of a chunk.
const CHUNK: usize = 4096;
/// Most indices that 15 bits of a block can tell apart, beside the one for nothing.
pub const CHUNK_SEEN: usize = (1 << 15) - 1;

/// Cells of a chunk of an archive: so many that 15 bits number all cells that they can see.
pub fn cells_per_chunk(rays: usize) -> usize {
    (CHUNK_SEEN / rays.max(1)).clamp(1, CHUNK)
}

/// One traced cell: its key, mean normal, sky bits, and for each ray whether it goes up and the cell it met.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    pub key: CellKey,
    pub normal: [f32; 3],
    pub bits: Vec<u8>,
    pub seen: Vec<(bool, Option<CellKey>)>,
    pub extras: Extras,
}

/// Bytes of a ray of [`Cell::to_bytes`].
const RAY_BYTES: usize = 1 + size_of::<u128>();

impl Cell {
    /// The cells that it sees, some of them in mirrors.
    pub fn reached(&self) -> impl Iterator<Item = CellKey> + '_ {
        let mirrors = CellMirrors::from_bytes(&self.extras[MIRROR], self.bits.len()).unwrap_or_default();
        self.seen.iter().filter_map(|seen| seen.1).chain(mirrors.paths.into_iter().map(|path| path.cell))
    }

    /// All but the key, for sorting outside memory.
    pub fn to_bytes(&self) -> Vec<u8> {
        let extras: usize = self.extras.iter().map(|layer| 4 + layer.len()).sum();
        let mut bytes = Vec::with_capacity(12 + self.bits.len() + extras + RAY_BYTES * self.seen.len());
        bytes.extend(self.normal.iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend(&self.bits);
        for layer in &self.extras {
            bytes.extend((layer.len() as u32).to_le_bytes());
            bytes.extend(layer);
        }
        for (up, key) in &self.seen {
            bytes.push(u8::from(*up) | u8::from(key.is_some()) << 1);
            bytes.extend(key.map_or(0, CellKey::number).to_le_bytes());
        }
        bytes
    }

    /// Inverse of [`CellKey::to_bytes`] and [`Cell::to_bytes`] for a number of bytes of sky bits.
    pub fn from_bytes(key: &[u8], cell: &[u8], bits: usize) -> Self {
        let (head, mut rest) = cell.split_at(12 + bits);
        let extras = std::array::from_fn(|_| {
            let (length, tail) = rest.split_at(4);
            let length = [0, 1, 2, 3].map(|i| length[i]);
            let (layer, tail) = tail.split_at(u32::from_le_bytes(length) as usize);
            rest = tail;
            layer.to_vec()
        });
        let float = |axis: usize| f32::from_le_bytes([0, 1, 2, 3].map(|i| head[4 * axis + i]));
        let number = |bytes: &[u8]| u128::from_le_bytes(bytes.last_chunk().copied().unwrap_or_default());
        let ray = |ray: &[u8]| (ray[0] & 1 == 1, (ray[0] & 2 == 2).then(|| CellKey::from_number(number(ray))));
        let mut key_bytes = [0; CellKey::BYTES];
        key_bytes.copy_from_slice(key);
        Cell {
            key: CellKey::from_bytes(&key_bytes),
            normal: [float(0), float(1), float(2)],
            bits: head[12..].to_vec(),
            seen: rest.chunks_exact(RAY_BYTES).map(ray).collect(),
            extras,
        }
    }
}

impl Cells {
    /// A table of traced cells, which are sorted by key and have equal numbers of texels and rays.
    pub fn new(cells: &[Cell]) -> Self {
        let (seen, numbers) = numbered(cells.iter().flat_map(|c| &c.seen).filter_map(|s| s.1));
        let number = |&(up, key): &(bool, Option<CellKey>)| {
            // Every cell that is seen was listed above.
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
            extras: std::array::from_fn(|layer| gathered(cells.iter().map(|c| c.extras[layer].as_slice()))),
        }
    }

    /// Some of the cells, by ascending rows, with the cells that these see.
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
            extras: std::array::from_fn(|layer| gathered(rows.iter().map(|&row| self.extra(layer, row)))),
        }
    }

    /// Tables one after the other; keys rise from table to table.
    pub fn join(parts: &[Cells]) -> Cells {
        let (seen, numbers) = numbered(parts.iter().flat_map(|p| p.seen.iter().copied()));
        let hits = parts.iter().flat_map(|part| {
            // Every cell that is seen was listed above.
            let numbers: Vec<u32> = part.seen.iter().map(|key| numbers.get(key).copied().unwrap_or(MISS)).collect();
            part.hits.iter().map(move |&hit| renumber(hit, &numbers))
        });
        Cells {
            keys: parts.iter().flat_map(|p| p.keys.iter().copied()).collect(),
            normals: parts.iter().flat_map(|p| p.normals.iter().copied()).collect(),
            bits: parts.iter().flat_map(|p| p.bits.iter().copied()).collect(),
            hits: hits.collect(),
            seen,
            extras: std::array::from_fn(|layer| {
                let rows = |part| (0..Cells::rows(part)).map(move |row| part.extra(layer, row));
                gathered(parts.iter().flat_map(rows))
            }),
        }
    }

    /// Number of cells.
    pub fn rows(&self) -> usize {
        self.keys.len()
    }

    /// What a cell has of a layer of [`crate::layers::extras`].
    pub fn extra(&self, layer: usize, cell: usize) -> &[u8] {
        self.extras[layer].get(cell).map_or(&[], Vec::as_slice)
    }

    /// What a cell sees in mirrors; nothing if its bytes are damaged.
    pub fn mirrors(&self, cell: usize) -> CellMirrors {
        CellMirrors::from_bytes(self.extra(MIRROR, cell), self.bits_of(cell).len()).unwrap_or_default()
    }

    /// Whether what cells see in mirrors can be read.
    pub fn mirrors_are_whole(&self) -> bool {
        let whole =
            |(cell, bytes): (usize, &Vec<u8>)| CellMirrors::from_bytes(bytes, self.bits_of(cell).len()).is_some();
        self.extras[MIRROR].iter().enumerate().all(whole)
    }

    /// All cells that are seen, some of them in mirrors; not sorted.
    pub fn reached(&self) -> impl Iterator<Item = CellKey> + '_ {
        let in_mirrors = (0..self.extras[MIRROR].len()).flat_map(|cell| self.mirrors(cell).paths);
        self.seen.iter().copied().chain(in_mirrors.map(|path| path.cell))
    }

    /// Sky bits of a cell.
    pub fn bits_of(&self, cell: usize) -> &[u8] {
        let row = self.bits.len().checked_div(self.keys.len()).unwrap_or(0);
        &self.bits[cell * row..(cell + 1) * row]
    }

    /// Hits of a cell.
    pub fn hits_of(&self, cell: usize) -> &[u32] {
        let rays = self.hits.len().checked_div(self.keys.len()).unwrap_or(0);
        &self.hits[cell * rays..(cell + 1) * rays]
    }

    /// One cell, as it was given to [`Cells::new`] but for the order of its rays.
    pub fn cell(&self, cell: usize) -> Cell {
        let seen = |&hit: &u32| (hit & DOWN == 0, (hit & !DOWN != MISS).then(|| self.seen[(hit & !DOWN) as usize]));
        Cell {
            key: self.keys[cell],
            normal: self.normals[cell],
            bits: self.bits_of(cell).to_vec(),
            seen: self.hits_of(cell).iter().map(seen).collect(),
            extras: std::array::from_fn(|layer| self.extra(layer, cell).to_vec()),
        }
    }
}

/// Rows of a layer, none if all are empty.
fn gathered<'a>(rows: impl Iterator<Item = &'a [u8]> + Clone) -> Vec<Vec<u8>> {
    if rows.clone().all(<[u8]>::is_empty) { Vec::new() } else { rows.map(<[u8]>::to_vec).collect() }
}

/// Keys sorted, each once, and the place of each.
pub(super) fn numbered(keys: impl Iterator<Item = CellKey>) -> (Vec<CellKey>, CellMap<u32>) {
    // Most keys come many times: sorting comes after.
    let mut numbers: CellMap<u32> = keys.map(|key| (key, 0)).collect();
    let mut sorted: Vec<CellKey> = numbers.keys().copied().collect();
    // Comparing keys costs more than making their bytes once.
    sorted.sort_by_cached_key(|key| key.to_bytes());
    for (key, number) in sorted.iter().zip(0..) {
        numbers.insert(*key, number);
    }
    (sorted, numbers)
}

/// A hit under the new numbers of what is seen.
fn renumber(hit: u32, numbers: &[u32]) -> u32 {
    if hit & !DOWN == MISS { hit } else { hit & DOWN | numbers[(hit & !DOWN) as usize] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three cells with four rays come back as they were, and 15 bits suffice for a chunk of any number of rays.
    #[test]
    fn cells_round_trip() {
        let key = |x: i32| CellKey { level: 1, facing: 5, material: 2, voxel: [x, 0, -x] };
        let cells: Vec<Cell> = (0..3)
            .map(|i| Cell {
                key: key(i),
                normal: [0.0, 0.6, 0.8],
                bits: vec![i as u8; 8],
                seen: vec![(true, Some(key(7))), (true, Some(key(9 + i))), (true, None), (false, Some(key(7)))],
                extras: [vec![i as u8; i as usize], Vec::new()],
            })
            .collect();
        let table = Cells::new(&cells);
        assert_eq!(table.seen.len(), 4);
        for (i, cell) in cells.iter().enumerate() {
            assert_eq!(Cell::from_bytes(&cell.key.to_bytes(), &cell.to_bytes(), 8), *cell);
            let (mut back, mut cell) = (table.cell(i), cell.clone());
            back.seen.sort_unstable();
            cell.seen.sort_unstable();
            assert_eq!(back, cell);
        }
        let parts = [table.select(&[0]), table.select(&[1, 2])];
        assert_eq!(
            (parts[0].extras.each_ref().map(Vec::len), parts[1].extras.each_ref().map(Vec::len)),
            ([0, 0], [2, 0])
        );
        assert_eq!((parts[0].seen.len(), Cells::join(&parts)), (2, table));
        for rays in 0..40_000 {
            assert!((1..=4096).contains(&cells_per_chunk(rays)) && cells_per_chunk(rays) * rays.min(32_767) <= 32_767);
        }
    }
}
