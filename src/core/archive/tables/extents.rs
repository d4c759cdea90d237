//! Boxes of receivers, tile by tile, by which a reader finds the receivers of a place. In: boxes.
//! Out: a table, and back.

use glam::DVec3;
use rkyv::{Archive, Deserialize, Serialize};

use crate::archive::format::EXTENTS;
use crate::archive::tables::{Flaw, column, table};

/// Table of the boxes of some tiles, schema 1, a row each: chunk 0 holds tiles 0 to 4095, chunk 1
/// the next ones. All corners are positions of the receivers themselves, input coordinates, metres.
#[derive(Clone, Debug, Default, PartialEq, Archive, Serialize, Deserialize)]
pub struct ExtentsTable {
    /// Lowest coordinates of the tile's receivers.
    pub low: Vec<[f64; 3]>,
    /// Highest coordinates of the tile's receivers, not below `low`.
    pub high: Vec<[f64; 3]>,
}

table!(ExtentsTable, [EXTENTS]);

/// Number of tiles of a chunk; the last chunk may have fewer.
pub const TILES_A_CHUNK: usize = 4096;

impl ExtentsTable {
    /// Returns the table of some tiles' boxes, each with its lowest and its highest corner.
    pub fn new(boxes: &[[DVec3; 2]]) -> Self {
        let corner = |number: usize| boxes.iter().map(|of| of.get(number).map_or([0.0; 3], DVec3::to_array)).collect();
        ExtentsTable { low: corner(0), high: corner(1) }
    }

    /// Iterates over the lowest and highest corner of each tile.
    pub fn boxes(&self) -> impl Iterator<Item = [DVec3; 2]> + '_ {
        self.low.iter().zip(&self.high).map(|(&low, &high)| [DVec3::from_array(low), DVec3::from_array(high)])
    }

    /// Returns the box of some positions; `None` without any.
    pub fn around(positions: impl IntoIterator<Item = DVec3>) -> Option<[DVec3; 2]> {
        positions.into_iter().map(|p| [p, p]).reduce(|[low, high], [p, _]| [low.min(p), high.max(p)])
    }

    /// Returns the number of tiles.
    pub fn rows(&self) -> usize {
        self.low.len()
    }

    fn check(&self) -> Result<(), Flaw> {
        let rows = self.rows();
        if rows == 0 || rows > TILES_A_CHUNK {
            return Err(Flaw::new(format!("{rows} tiles"), format!("1 to {TILES_A_CHUNK}")));
        }
        let finite = |corner: &[f64; 3]| corner.iter().all(|x| x.is_finite());
        column("low", &self.low, rows, "finite metres", finite)?;
        column("high", &self.high, rows, "finite metres", finite)?;
        match self.boxes().position(|[low, high]| !low.cmple(high).all()) {
            Some(row) => Err(Flaw::new(format!("high below low in row {row}"), "boxes")),
            None => Ok(()),
        }
    }
}

#[cfg(all(test, feature = "zstd"))]
mod tests {
    use super::*;
    use crate::archive::format;
    use crate::archive::format::TileNumber;
    use crate::archive::tables::tests::{block, hostile};

    fn two() -> ExtentsTable {
        let points = [DVec3::new(1.0, -2.5, 3.0), DVec3::new(0.5, 7.0, 3.0)];
        ExtentsTable::new(&[ExtentsTable::around(points).unwrap(), ExtentsTable::around([points[0]]).unwrap()])
    }

    /// Known values have the known 112 bytes and come back. None of the 1007 changes of a bit and
    /// cuts ends the program.
    #[test]
    fn layout_is_frozen() {
        let (known, raw) = (two(), two().to_bytes().unwrap());
        assert_eq!((raw.len(), format::hex(&format::checksum(&raw))), (112, "1b4be63ed2a5d9b9".to_string()));
        assert_eq!(
            ExtentsTable::from_block(&block(&known.encode(EXTENTS, TileNumber::FIRST, 9).unwrap())).unwrap(),
            known
        );
        assert_eq!(known.boxes().next(), Some([DVec3::new(0.5, -2.5, 3.0), DVec3::new(1.0, 7.0, 3.0)]));
        let (refused, accepted) = hostile(EXTENTS, 2, &raw, |block| ExtentsTable::from_block(block).map(|_| ()));
        assert!(refused > 100 && refused + accepted == 1007, "{refused} {accepted}");
    }

    /// Each of 5 invalid tables is refused.
    #[test]
    fn ranges_are_checked() {
        let flaws: [fn(&mut ExtentsTable); 5] = [
            |t| t.low[0][1] = f64::NAN,
            |t| t.high[1][2] = f64::INFINITY,
            |t| t.high[0][0] = 0.25,
            |t| t.high.truncate(1),
            |t| *t = ExtentsTable::default(),
        ];
        let refused = flaws.iter().filter(|flaw| {
            let mut wrong = two();
            flaw(&mut wrong);
            wrong.to_bytes().is_err()
        });
        assert_eq!(refused.count(), 5);
    }
}
