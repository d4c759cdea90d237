//! Optics of materials beside diffuse reflection, and the planes of the mirrors; only in archives
//! of scenes with such materials. In: columns. Out: tables, and back.

use rkyv::{Archive, Deserialize, Serialize};

use crate::archive::format::{MAX_MATERIALS, MIRRORS, OPTICS};
use crate::archive::tables::{Flaw, column, is_share, length_in, table};
use crate::site::material::Material;

/// Code of a volume of leaves in [`OpticsTable::canopy`].
pub const VOLUME: u8 = 2;

/// Returns the code of a material in [`OpticsTable::canopy`].
pub fn kind_of_canopy(material: &Material) -> u8 {
    match material.transmittance {
        Some(_) if material.volume => VOLUME,
        found => u8::from(found.is_some()),
    }
}

/// Table of the optics of all materials, in the rows of the materials table, schema 1.
#[derive(Clone, Debug, Default, PartialEq, Archive, Serialize, Deserialize)]
pub struct OpticsTable {
    /// Number of panes of clear glass, 0 to 2.
    pub panes: Vec<u8>,
    /// Kind of a canopy: 0 opaque, 1 dims light at each crossing of a face, [`VOLUME`] along each
    /// metre inside.
    pub canopy: Vec<u8>,
    /// Transmittance of a canopy at each crossing or along each metre; 0 for an opaque material.
    pub transmittance: Vec<f64>,
}

table!(OpticsTable, [OPTICS]);

impl OpticsTable {
    /// Returns the number of materials.
    pub fn rows(&self) -> usize {
        self.panes.len()
    }

    fn check(&self) -> Result<(), Flaw> {
        let rows = self.rows();
        if rows == 0 || rows > MAX_MATERIALS {
            return Err(Flaw::new(format!("{rows} materials"), format!("1 to {MAX_MATERIALS}")));
        }
        column("panes", &self.panes, rows, "0 to 2", |panes| *panes <= 2)?;
        column("canopy", &self.canopy, rows, "0 to 2", |canopy| *canopy <= VOLUME)?;
        column("transmittance", &self.transmittance, rows, "0 to 1", |value| is_share(*value))
    }
}

/// Table of the orientations of mirrors, schema 1: all parallel mirrors of one material make one
/// row.
#[derive(Clone, Debug, Default, PartialEq, Archive, Serialize, Deserialize)]
pub struct MirrorsTable {
    /// Unit normal of either sign.
    pub normal: Vec<[f64; 3]>,
    /// Row of the materials table.
    pub material: Vec<u16>,
}

table!(MirrorsTable, [MIRRORS]);

impl MirrorsTable {
    /// Returns the number of orientations.
    pub fn rows(&self) -> usize {
        self.normal.len()
    }

    fn check(&self) -> Result<(), Flaw> {
        let rows = self.rows();
        if rows == 0 || rows > MAX_MATERIALS {
            return Err(Flaw::new(format!("{rows} orientations of mirrors"), format!("1 to {MAX_MATERIALS}")));
        }
        column("normal", &self.normal, rows, "length 1", |n| length_in(*n, 1.0, 1.0))?;
        column("material", &self.material, rows, "a number", |_| true)
    }
}

#[cfg(all(test, feature = "zstd"))]
mod tests {
    use super::*;
    use crate::archive::format;
    use crate::archive::format::TileNumber;
    use crate::archive::tables::tests::block;

    /// Known values have the known bytes, 48 and 68, and come back.
    #[test]
    fn layout_is_frozen() {
        let optics = OpticsTable { panes: vec![0, 2], canopy: vec![1, 0], transmittance: vec![0.25, 0.0] };
        let raw = optics.to_bytes().unwrap();
        assert_eq!((raw.len(), format::hex(&format::checksum(&raw))), (48, "9fd6f63b7f5718aa".to_string()));
        assert_eq!(
            OpticsTable::from_block(&block(&optics.encode(OPTICS, TileNumber::FIRST, 9).unwrap())).unwrap(),
            optics
        );
        let mirrors = MirrorsTable { normal: vec![[0.0, 0.6, 0.8], [1.0, 0.0, 0.0]], material: vec![1, 0] };
        let raw = mirrors.to_bytes().unwrap();
        assert_eq!((raw.len(), format::hex(&format::checksum(&raw))), (68, "8743ece86e507613".to_string()));
        assert_eq!(
            MirrorsTable::from_block(&block(&mirrors.encode(MIRRORS, TileNumber::FIRST, 9).unwrap())).unwrap(),
            mirrors
        );
    }

    /// Each of 7 values out of range is refused.
    #[test]
    fn ranges_are_checked() {
        let good = OpticsTable { panes: vec![0, 2], canopy: vec![1, 0], transmittance: vec![0.25, 0.0] };
        let flaws: [fn(&mut OpticsTable); 4] =
            [|o| o.panes[0] = 3, |o| o.canopy[1] = 3, |o| o.transmittance[0] = f64::NAN, |o| o.transmittance.clear()];
        let refused = flaws.iter().filter(|flaw| {
            let mut wrong = good.clone();
            flaw(&mut wrong);
            wrong.to_bytes().is_err()
        });
        assert_eq!(refused.count(), 4);
        let good = MirrorsTable { normal: vec![[0.0, 0.6, 0.8]], material: vec![1] };
        let flaws: [fn(&mut MirrorsTable); 3] =
            [|m| m.normal[0][0] = 0.1, |m| m.normal[0][2] = f64::NAN, |m| m.normal.clear()];
        let refused = flaws.iter().filter(|flaw| {
            let mut wrong = good.clone();
            flaw(&mut wrong);
            wrong.to_bytes().is_err()
        });
        assert_eq!(refused.count(), 3);
    }
}
