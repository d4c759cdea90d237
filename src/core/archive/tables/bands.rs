//! What materials do in bands of the light. Only in archives of scenes whose materials state it.

use rkyv::{Archive, Deserialize, Serialize};

use crate::archive::format::{BANDS, MAX_MATERIALS};
use crate::archive::tables::{Flaw, column, is_share, table};
use crate::site::bands::{Band, BandOptics, BandProperty};

/// All values of all materials.
const MOST_VALUES: usize = MAX_MATERIALS * BandProperty::ALL.len() * Band::ALL.len();

/// A row for each value that a material states for a band, schema 1, strictly ascending by material, property and band.
#[derive(Clone, Debug, Default, PartialEq, Archive, Serialize, Deserialize)]
pub struct BandsTable {
    /// Row of the materials table.
    pub material: Vec<u16>,
    /// [`BandProperty::code`].
    pub property: Vec<u8>,
    /// [`Band::code`].
    pub band: Vec<u8>,
    /// Reflectance or transmittance.
    pub value: Vec<f64>,
}

table!(BandsTable, [BANDS]);

impl BandsTable {
    /// What materials state by band, in the order of their rows; `None` where none states anything.
    pub fn of<'a>(materials: impl IntoIterator<Item = &'a BandOptics>) -> Option<Self> {
        let mut table = BandsTable::default();
        for (material, optics) in (0..=u16::MAX).zip(materials) {
            for (property, band, value) in optics.all() {
                table.material.push(material);
                table.property.push(property.code());
                table.band.push(band.code());
                table.value.push(value);
            }
        }
        (table.rows() > 0).then_some(table)
    }

    /// What each of some materials states; `None` if a row is of another one.
    pub fn optics(&self, materials: usize) -> Option<Vec<BandOptics>> {
        let mut found = vec![BandOptics::default(); materials];
        let columns = self.material.iter().zip(&self.property).zip(self.band.iter().zip(&self.value));
        for ((material, property), (band, value)) in columns {
            let optics = found.get_mut(usize::from(*material))?;
            let values = optics.of_mut(BandProperty::of_code(*property)?);
            *values = values.with(Band::of_code(*band)?, *value);
        }
        Some(found)
    }

    /// Number of values.
    pub fn rows(&self) -> usize {
        self.material.len()
    }

    fn check(&self) -> Result<(), Flaw> {
        let (rows, most) = (self.rows(), MOST_VALUES);
        if rows == 0 || rows > most {
            return Err(Flaw::new(format!("{rows} values"), format!("1 to {most}")));
        }
        column("property", &self.property, rows, "0 to 2", |code| BandProperty::of_code(*code).is_some())?;
        column("band", &self.band, rows, "0 to 3", |code| Band::of_code(*code).is_some())?;
        column("value", &self.value, rows, "0 to 1", |value| is_share(*value))?;
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
        let leaf = BandValues::of(Band::Visible, 0.08).with(Band::Nir, 0.45);
        let leaf = BandOptics { transmittance: leaf, ..BandOptics::default() };
        let wall = BandOptics { diffuse: BandValues::of(Band::Par, 0.5), ..BandOptics::default() };
        BandsTable::of([&wall, &BandOptics::default(), &leaf]).expect("some are stated")
    }

    /// Three values of three materials have the known 72 bytes and come back, of each material its own; with two materials a row is of none.
    #[test]
    fn layout_is_frozen() {
        let table = known();
        let raw = table.to_bytes().unwrap();
        assert_eq!((raw.len(), format::hex(&format::checksum(&raw))), (72, "b11ecaf20c1f9517".to_string()));
        assert_eq!(BandsTable::from_block(&block(&table.encode(BANDS, TileNumber::FIRST, 9).unwrap())).unwrap(), table);
        let optics = table.optics(3).expect("three materials");
        assert_eq!(optics[2].transmittance.all().collect::<Vec<_>>(), [(Band::Visible, 0.08), (Band::Nir, 0.45)]);
        assert_eq!((optics[0].diffuse.stated(Band::Par), optics[1].is_empty()), (Some(0.5), true));
        assert!(table.optics(2).is_none() && BandsTable::of([&BandOptics::default()]).is_none());
    }

    /// Each of 6 values out of range is refused.
    #[test]
    fn ranges_are_checked() {
        let flaws: [fn(&mut BandsTable); 6] = [
            |t| t.property[0] = 3,
            |t| t.band[0] = 4,
            |t| t.value[0] = 1.1,
            |t| t.value[0] = f64::NAN,
            |t| t.material[2] = 0,
            |t| t.value.truncate(2),
        ];
        let refused = flaws.iter().filter(|flaw| {
            let mut wrong = known();
            flaw(&mut wrong);
            wrong.to_bytes().is_err()
        });
        assert_eq!(refused.count(), 6);
    }

    /// No change of a bit and no cut ends the program, though checksums fit; all cuts are refused.
    #[test]
    fn hostile_bytes_are_survived() {
        let raw = known().to_bytes().unwrap();
        let (refused, accepted) = hostile(BANDS, 3, &raw, BandsTable::from_block);
        assert_eq!(refused + accepted, raw.len() * 9 - 1);
        assert!(refused >= raw.len() - 1, "{refused}");
    }
}
