//! Sky and surfaces that receivers and cells see in mirrors. In: parts of the sky, each by a chain
//! of mirrors, and surfaces. Out: the bytes of one row of a block, and back. As in the sky texture,
//! texels are those of the sky that the light comes from.

use crate::site::cells::CellKey;
use crate::site::chain::{Chain, MAX_MIRRORS, MirrorStep};

/// Sky and surfaces that a receiver sees in mirrors.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReceiverMirrors {
    /// Parts of the sky, each seen by one chain of mirrors.
    pub windows: Vec<Window>,
    /// Surfaces, by texels of the hit texture.
    pub paths: Vec<MirrorPath>,
}

/// Sky that a receiver sees by one chain of mirrors.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// Mirrors on the way, from the receiver on.
    pub chain: Chain,
    /// First column of the base square that is covered.
    pub column: u16,
    /// First row of the base square that is covered.
    pub row: u16,
    /// Number of texels of the base square to a side of the window.
    pub side: u16,
    /// A [`SkyTexture`](crate::layers::sky::SkyTexture) of that side, packed.
    pub texture: Vec<u8>,
}

/// A surface that a texel of the hit texture shows in mirrors.
#[derive(Clone, Debug, PartialEq)]
pub struct MirrorPath {
    /// Texel of the hit texture, row-major.
    pub texel: u32,
    /// Cell that is met behind the mirrors.
    pub cell: CellKey,
    /// Mirrors on the way, from the receiver on: 1 to 3.
    pub steps: Vec<MirrorStep>,
}

/// Sky and surfaces that a cell sees in mirrors.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellMirrors {
    /// Parts of the sky, each seen by one chain of mirrors.
    pub windows: Vec<CellWindow>,
    /// Surfaces, by rays of the cell.
    pub paths: Vec<CellPath>,
}

/// Sky that a cell sees by one chain of mirrors.
#[derive(Clone, Debug, PartialEq)]
pub struct CellWindow {
    /// Mirrors on the way, from the cell on.
    pub chain: Chain,
    /// Texels of the sky that the light comes from, row-major, ascending.
    pub texels: Vec<u16>,
}

/// A surface that one of the cell's rays meets behind mirrors.
#[derive(Clone, Debug, PartialEq)]
pub struct CellPath {
    /// True if the ray starts above the horizon.
    pub up: bool,
    /// Bounce cell that is met behind the mirrors.
    pub cell: CellKey,
    /// Mirrors on the way, from the cell on: 1 to 3.
    pub steps: Vec<MirrorStep>,
}

impl ReceiverMirrors {
    /// Returns true if nothing is seen in mirrors.
    pub fn is_empty(&self) -> bool {
        self.windows.is_empty() && self.paths.is_empty()
    }

    /// Returns the cells that are seen in mirrors.
    pub fn cells(&self) -> impl Iterator<Item = CellKey> + '_ {
        self.paths.iter().map(|path| path.cell)
    }

    /// Returns the bytes of one row of a block; none if nothing is seen.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Vec::new();
        if self.is_empty() {
            return out;
        }
        out.extend((self.windows.len() as u32).to_le_bytes());
        for window in &self.windows {
            put_chain(window.chain, &mut out);
            for number in [window.column, window.row, window.side] {
                out.extend(number.to_le_bytes());
            }
            out.extend((window.texture.len() as u32).to_le_bytes());
            out.extend(&window.texture);
        }
        for path in &self.paths {
            out.extend(path.texel.to_le_bytes());
            out.extend(path.cell.to_bytes());
            put_steps(&path.steps, &mut out);
        }
        out
    }

    /// Reads the bytes of [`ReceiverMirrors::to_bytes`] for a sky of `base` and hits of `hit`
    /// texels a side. Returns `None` for any other bytes.
    pub fn from_bytes(bytes: &[u8], base: usize, hit: usize) -> Option<Self> {
        let mut found = ReceiverMirrors::default();
        if bytes.is_empty() {
            return Some(found);
        }
        let mut rest = Reader(bytes);
        for _ in 0..rest.number()? {
            let chain = rest.chain()?;
            let [column, row, side] = [rest.short()?, rest.short()?, rest.short()?];
            let fits = |first: u16| usize::from(first) + usize::from(side) <= base;
            if side == 0 || !fits(column) || !fits(row) {
                return None;
            }
            let length = rest.number()? as usize;
            found.windows.push(Window { chain, column, row, side, texture: rest.bytes(length)?.to_vec() });
        }
        while !rest.0.is_empty() {
            let (texel, cell, steps) = (rest.number()?, rest.key()?, rest.steps()?);
            if texel as usize >= hit * hit {
                return None;
            }
            found.paths.push(MirrorPath { texel, cell, steps });
        }
        Some(found)
    }
}

impl CellMirrors {
    /// Returns true if nothing is seen in mirrors.
    pub fn is_empty(&self) -> bool {
        self.windows.is_empty() && self.paths.is_empty()
    }

    /// Returns the bytes of one row of a block, for a sky of `bits` bytes; none if nothing is seen.
    pub fn to_bytes(&self, bits: usize) -> Vec<u8> {
        let mut out = Vec::new();
        if self.is_empty() {
            return out;
        }
        out.extend((self.windows.len() as u32).to_le_bytes());
        for window in &self.windows {
            put_chain(window.chain, &mut out);
            put_texels(&window.texels, bits, &mut out);
        }
        for path in &self.paths {
            out.push(u8::from(path.up));
            out.extend(path.cell.to_bytes());
            put_steps(&path.steps, &mut out);
        }
        out
    }

    /// Reads the bytes of [`CellMirrors::to_bytes`] for a sky of `bits` bytes. Returns `None` for
    /// any other bytes.
    pub fn from_bytes(bytes: &[u8], bits: usize) -> Option<Self> {
        let mut found = CellMirrors::default();
        if bytes.is_empty() {
            return Some(found);
        }
        let mut rest = Reader(bytes);
        for _ in 0..rest.number()? {
            let chain = rest.chain()?;
            found.windows.push(CellWindow { chain, texels: rest.texels(bits)? });
        }
        while !rest.0.is_empty() {
            let [up] = rest.take()?;
            let (cell, steps) = (rest.key()?, rest.steps()?);
            if up > 1 {
                return None;
            }
            found.paths.push(CellPath { up: up == 1, cell, steps });
        }
        Some(found)
    }

    /// Returns the cells that are seen in mirrors.
    pub fn cells(&self) -> impl Iterator<Item = CellKey> + '_ {
        self.paths.iter().map(|path| path.cell)
    }
}

fn put_chain(chain: Chain, out: &mut Vec<u8>) {
    out.push(chain.len() as u8);
    out.extend(chain.numbers().flat_map(u16::to_le_bytes));
}

/// Count that announces a bit for each texel of the sky instead of a list of texels. No list is
/// that long: texels are numbered by u16, so a sky has at most 8192 bytes and a list at most half
/// as many texels.
const ALL: u16 = u16::MAX;

/// Appends texels of the sky as a list or as a bit for each texel, whichever is shorter.
fn put_texels(texels: &[u16], bits: usize, out: &mut Vec<u8>) {
    if texels.len() * 2 <= bits {
        out.extend((texels.len() as u16).to_le_bytes());
        out.extend(texels.iter().flat_map(|texel| texel.to_le_bytes()));
        return;
    }
    out.extend(ALL.to_le_bytes());
    let mut square = vec![0_u8; bits];
    for &texel in texels {
        square[usize::from(texel / 8)] |= 1 << (texel % 8);
    }
    out.extend(square);
}

fn put_steps(steps: &[MirrorStep], out: &mut Vec<u8>) {
    out.push(steps.len() as u8);
    for (material, cosine) in steps {
        out.extend(material.to_le_bytes());
        out.push(*cosine);
    }
}

/// Reader of the bytes that are left.
struct Reader<'b>(&'b [u8]);

impl<'b> Reader<'b> {
    fn bytes(&mut self, count: usize) -> Option<&'b [u8]> {
        let (head, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(head)
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.bytes(N)?.try_into().ok()
    }

    fn number(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    fn short(&mut self) -> Option<u16> {
        self.take().map(u16::from_le_bytes)
    }

    fn key(&mut self) -> Option<CellKey> {
        self.take().map(|bytes| CellKey::from_bytes(&bytes))
    }

    /// Reads texels below 8 times a number of bytes, ascending.
    fn texels(&mut self, bits: usize) -> Option<Vec<u16>> {
        let count = self.short()?;
        if count == ALL {
            let square = self.bytes(bits)?;
            let set = |texel: &u16| square[usize::from(texel / 8)] >> (texel % 8) & 1 == 1;
            return Some((0..=u16::MAX).take(bits * 8).filter(set).collect());
        }
        let texels: Vec<u16> = (0..count).map(|_| self.short()).collect::<Option<_>>()?;
        let good = usize::from(count) * 2 <= bits
            && texels.is_sorted_by(|a, b| a < b)
            && texels.last().is_none_or(|&last| usize::from(last) < bits * 8);
        good.then_some(texels)
    }

    /// Reads the length of a chain, 1 to 3.
    fn length(&mut self) -> Option<usize> {
        let [length] = self.take()?;
        (1..=MAX_MIRRORS).contains(&usize::from(length)).then_some(usize::from(length))
    }

    fn chain(&mut self) -> Option<Chain> {
        let numbers: Vec<u16> = (0..self.length()?).map(|_| self.short()).collect::<Option<_>>()?;
        Some(Chain::new(&numbers))
    }

    fn steps(&mut self) -> Option<Vec<MirrorStep>> {
        let step = |reader: &mut Self| Some((reader.short()?, u8::from_le_bytes(reader.take()?)));
        (0..self.length()?).map(|_| step(self)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(x: i32) -> CellKey {
        CellKey { level: 1, facing: 60, material: 3, voxel: [x, -7, 2] }
    }

    /// Two windows and three paths of a receiver come back, and nothing seen gives no bytes. Of all
    /// truncated rows only the 3 that end between paths are read. A window beyond the sky and a
    /// texel beyond the hits are refused.
    #[test]
    fn mirrors_of_receivers_come_back() {
        let window = |numbers: &[u16], column| Window {
            chain: Chain::new(numbers),
            column,
            row: 9,
            side: 7,
            texture: vec![0xa5; 14],
        };
        let path = |texel| MirrorPath { texel, cell: key(4), steps: vec![(2, 255), (0, 12)] };
        let mirrors = ReceiverMirrors {
            windows: vec![window(&[0], 3), window(&[65_535, 0, 2], 121)],
            paths: vec![path(0), path(5), path(1023)],
        };
        let raw = mirrors.to_bytes();
        assert_eq!(ReceiverMirrors::from_bytes(&raw, 128, 32), Some(mirrors));
        assert_eq!(
            (ReceiverMirrors::from_bytes(&raw, 127, 32), ReceiverMirrors::from_bytes(&raw, 128, 31)),
            (None, None)
        );
        assert!(ReceiverMirrors::default().to_bytes().is_empty());
        let taken = (1..raw.len()).filter(|&cut| ReceiverMirrors::from_bytes(&raw[..cut], 128, 32).is_some());
        assert_eq!(taken.count(), 3);
    }

    /// A window of 3 texels, one of 86 and two paths of a cell come back. Of all truncated rows
    /// only the 2 that end between paths are read.
    #[test]
    fn mirrors_of_cells_come_back() {
        let window = |texels| CellWindow { chain: Chain::new(&[4, 4]), texels };
        let path = |up| CellPath { up, cell: key(9), steps: vec![(7, 0)] };
        let mirrors = CellMirrors {
            windows: vec![window(vec![0, 7, 255]), window((0..256).step_by(3).collect())],
            paths: vec![path(true), path(false)],
        };
        let raw = mirrors.to_bytes(32);
        assert_eq!(CellMirrors::from_bytes(&raw, 32), Some(mirrors.clone()));
        assert_eq!(mirrors.cells().collect::<Vec<_>>(), [key(9); 2]);
        let taken = (1..raw.len()).filter(|&cut| CellMirrors::from_bytes(&raw[..cut], 32).is_some());
        assert_eq!(taken.count(), 2);
    }
}
