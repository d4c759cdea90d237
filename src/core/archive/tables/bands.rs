//! Values of materials in bands of the light, and their longwave emissivity; only in archives of
//! scenes whose materials state some. In: optics by band. Out: a table, and back.

use rkyv::{Archive, Deserialize, Serialize};

use crate::archive::format::{BANDS, MAX_MATERIALS};
use crate::archive::tables::{Flaw, column, is_share, table};
use crate::site::bands::{Band, BandOptics, BandProperty};

/// Largest number of values of all materials.
const MAX_VALUES: usize = MAX_MATERIALS * (BandProperty::ALL.len() * Band::ALL.len() + 1);

/// Property code of an emissivity: the code after those of [`BandProperty`].
const EMISSIVITY: u8 = 3;

/// Band code of an emissivity: the code after those of [`Band`].
const LONGWAVE: u8 = 4;

/// Table with a row for each value that a material states for a band, schema 2, strictly ascending
/// by material, property and band.
#[derive(Clone, Debug, Default, PartialEq, Archive, Serialize, Deserialize)]
pub struct BandsTable {
    /// Row of the materials table.
    pub material: Vec<u16>,
    /// Property: [`BandProperty::code`], or 3 for an emissivity.
    pub property: Vec<u8>,
    /// Band: [`Band::code`], or 4 for longwave radiation, which only emissivities have.
    pub band: Vec<u8>,
    /// Reflectance, transmittance or emissivity, 0 to 1.
    pub value: Vec<f64>,
}

table!(BandsTable, [BANDS]);

impl BandsTable {
    /// Returns the table of stated values by band, for materials in the order of their rows; `None`
    /// where none states any.
    pub fn new<'a>(materials: impl IntoIterator<Item = &'a BandOptics>) -> Option<Self> {
        let mut table = BandsTable::default();
        for (material, optics) in (0..=u16::MAX).zip(materials) {
            let light = optics.all().map(|(property, band, value)| (property.code(), band.code(), value));
            for (property, band, value) in light.chain(optics.emissivity.map(|value| (EMISSIVITY, LONGWAVE, value))) {
                table.material.push(material);
                table.property.push(property);
                table.band.push(band);
                table.value.push(value);
            }
        }
        (table.rows() > 0).then_some(table)
    }

    /// Returns the stated values of each of `materials` materials; `None` if a row refers to
    /// another one.
    pub fn optics(&self, materials: usize) -> Option<Vec<BandOptics>> {
        let mut found = vec![BandOptics::default(); materials];
        let columns = self.material.iter().zip(&self.property).zip(self.band.iter().zip(&self.value));
        for ((material, property), (band, value)) in columns {
            let optics = found.get_mut(usize::from(*material))?;
            if *property == EMISSIVITY {
                optics.emissivity = Some(*value);
                continue;
            }
            let values = optics.of_mut(BandProperty::of_code(*property)?);
            *values = values.with(Band::of_code(*band)?, *value);
        }
        Some(found)
    }

    /// Returns the number of values.
    pub fn rows(&self) -> usize {
        self.material.len()
    }

    fn check(&self) -> Result<(), Flaw> {
        let (rows, most) = (self.rows(), MAX_VALUES);
        if rows == 0 || rows > most {
            return Err(Flaw::new(format!("{rows} values"), format!("1 to {most}")));
        }
        column("property", &self.property, rows, "0 to 3", |code| *code <= EMISSIVITY)?;
        column("band", &self.band, rows, "0 to 4", |code| *code <= LONGWAVE)?;
        column("value", &self.value, rows, "0 to 1", |value| is_share(*value))?;
        let mut pairs = self.property.iter().zip(&self.band);
        if !pairs.all(|(property, band)| (*property == EMISSIVITY) == (*band == LONGWAVE)) {
            return Err(Flaw::new("a property and a band that do not belong together", "property 3 with band 4 alone"));
        }
        let keys = self.material.iter().zip(&self.property).zip(&self.band);
        match keys.is_sorted_by(|a, b| a < b) {
            true => Ok(()),
            false => Err(Flaw::new("values out of order", "material, property and band that ascend strictly")),
        }
    }
}

#[cfg(all(test, feature = "zstd"))]
mod tests {
    use super::*;
    use crate::archive::format;
    use crate::archive::format::TileNumber;
    use crate::archive::tables::tests::{block, hostile};
    use crate::site::bands::BandValues;

    fn known() -> BandsTable {
        let leaf = BandValues::new(Band::Visible, 0.08).with(Band::Nir, 0.45);
        let leaf = BandOptics { transmittance: leaf, ..BandOptics::default() };
        let diffuse = BandValues::new(Band::Par, 0.5);
        let wall = BandOptics { diffuse, emissivity: Some(0.875), ..BandOptics::default() };
        BandsTable::new([&wall, &BandOptics::default(), &leaf]).expect("some are stated")
    }

    /// Four values of three materials have the known 80 bytes and come back, each with its own
    /// material. With two materials a row refers to none.
    #[test]
    fn layout_is_frozen() {
        let table = known();
        let raw = table.to_bytes().unwrap();
        assert_eq!((raw.len(), format::hex(&format::checksum(&raw))), (80, "dd8a5e30955f8bad".to_string()));
        assert_eq!(BandsTable::from_block(&block(&table.encode(BANDS, TileNumber::FIRST, 9).unwrap())).unwrap(), table);
        let optics = table.optics(3).expect("three materials");
        assert_eq!(optics[2].transmittance.all().collect::<Vec<_>>(), [(Band::Visible, 0.08), (Band::Nir, 0.45)]);
        assert_eq!((optics[0].diffuse.stated(Band::Par), optics[0].emissivity), (Some(0.5), Some(0.875)));
        assert_eq!(optics[1], BandOptics::default());
        assert!(table.optics(2).is_none() && BandsTable::new([&BandOptics::default()]).is_none());
    }

    /// Each of 8 values out of range is refused. Only an emissivity may have the longwave band.
    #[test]
    fn ranges_are_checked() {
        let flaws: [fn(&mut BandsTable); 8] = [
            |t| t.property[1] = 4,
            |t| t.property[1] = 2,
            |t| t.band[1] = 5,
            |t| t.band[0] = 4,
            |t| t.value[0] = 1.1,
            |t| t.value[0] = f64::NAN,
            |t| t.material[3] = 0,
            |t| t.value.truncate(2),
        ];
        let refused = flaws.iter().filter(|flaw| {
            let mut wrong = known();
            flaw(&mut wrong);
            wrong.to_bytes().is_err()
        });
        assert_eq!(refused.count(), 8);
    }

    /// No change of a bit and no cut ends the program, though checksums are right. All cuts are
    /// refused.
    #[test]
    fn hostile_bytes_are_survived() {
        let raw = known().to_bytes().unwrap();
        let (refused, accepted) = hostile(BANDS, 3, &raw, BandsTable::from_block);
        assert_eq!(refused + accepted, raw.len() * 9 - 1);
        assert!(refused >= raw.len() - 1, "{refused}");
    }
}
