//! The materials of the scene. In: names, reflectances, classes and groups. Out: a table, and back.

use std::collections::HashSet;

use rkyv::{Archive, Deserialize, Serialize};

use crate::archive::format::{MATERIALS, MAX_MATERIALS, MAX_STRING};
use crate::archive::tables::{Flaw, column, is_share, table};
use crate::site::material::Class;

/// Table of all materials, schema 2; the row is the material's number in cell keys.
#[derive(Clone, Debug, Default, PartialEq, Archive, Serialize, Deserialize)]
pub struct MaterialsTable {
    /// Names of the input, no two equal.
    pub name: Vec<String>,
    /// Diffuse reflectance of the solar band.
    pub diffuse: Vec<f64>,
    /// Specular reflectance; the sum with `diffuse` is at most 1.
    pub specular: Vec<f64>,
    /// Class: [`Class::code`].
    pub class: Vec<u8>,
    /// Group whose reflectance may follow a schedule; empty for none.
    pub group: Vec<String>,
}

table!(MaterialsTable, [MATERIALS]);

impl MaterialsTable {
    /// Returns the number of materials.
    pub fn rows(&self) -> usize {
        self.name.len()
    }

    /// Returns the class of a material. Panics beyond the last row, as a slice does.
    #[allow(clippy::indexing_slicing)]
    pub fn class_of(&self, row: usize) -> Class {
        // `check` lets no other code pass.
        Class::of_code(self.class[row]).unwrap_or(Class::Obstruction)
    }

    fn check(&self) -> Result<(), Flaw> {
        let rows = self.rows();
        if rows == 0 || rows > MAX_MATERIALS {
            return Err(Flaw::new(format!("{rows} materials"), format!("1 to {MAX_MATERIALS}")));
        }
        column("name", &self.name, rows, "1 to 1024 bytes", |name| !name.is_empty() && name.len() <= MAX_STRING)?;
        column("diffuse", &self.diffuse, rows, "0 to 1", |value| is_share(*value))?;
        column("specular", &self.specular, rows, "0 to 1", |value| is_share(*value))?;
        column("class", &self.class, rows, "0 or 1", |class| Class::of_code(*class).is_some())?;
        column("group", &self.group, rows, "0 to 1024 bytes", |group| group.len() <= MAX_STRING)?;
        let sums: Vec<f64> = self.diffuse.iter().zip(&self.specular).map(|(d, s)| d + s).collect();
        column("diffuse + specular", &sums, rows, "at most 1", |sum| *sum <= 1.0 + 1e-9)?;
        let mut seen = HashSet::new();
        match self.name.iter().find(|name| !seen.insert(name.as_str())) {
            Some(name) => Err(Flaw::new(format!("two materials called {name}"), "names of their own")),
            None => Ok(()),
        }
    }
}

#[cfg(all(test, feature = "zstd"))]
mod tests {
    use super::*;
    use crate::archive::format::TileNumber;
    use crate::archive::tables::tests::{block, hostile};
    use crate::archive::{encode, format};

    fn known() -> MaterialsTable {
        MaterialsTable {
            name: vec!["soil".to_string(), "curtain wall".to_string()],
            diffuse: vec![0.25, 0.1],
            specular: vec![0.0, 0.9],
            class: vec![0, 1],
            group: vec!["snow".to_string(), String::new()],
        }
    }

    /// The known value has the known 124 bytes, so the layout of schema 2 is unchanged. It reads
    /// back equal, ground as ground. The same bytes under schema id 1 are refused, with the name of
    /// the block.
    #[test]
    fn layout_is_frozen() {
        let raw = known().to_bytes().unwrap();
        assert_eq!((raw.len(), format::hex(&format::checksum(&raw))), (124, "b7c1d2b4e436872d".to_string()));
        assert_eq!(
            MaterialsTable::from_block(&block(&known().encode(MATERIALS, TileNumber::FIRST, 9).unwrap())).unwrap(),
            known()
        );
        assert_eq!([0, 1].map(|row| known().class_of(row)), [Class::Ground, Class::Obstruction]);
        let other = MaterialsTable::from_block(&block(&encode(MATERIALS, TileNumber::FIRST, 1, 2, &raw, 9).unwrap()))
            .unwrap_err();
        assert!(other.to_string().contains("block materials/0: found schema id 1"), "{other}");
    }

    /// A value out of range in any of 7 ways is refused on writing and, under right checksums, on
    /// reading.
    #[test]
    fn ranges_are_checked() {
        let flaws: [fn(&mut MaterialsTable); 7] = [
            |m| m.name[0].clear(),
            |m| m.name[0] = m.name[1].clone(),
            |m| m.diffuse[1] = 0.11,
            |m| m.diffuse[0] = f64::NAN,
            |m| m.specular[0] = -0.1,
            |m| m.class[0] = 2,
            |m| drop(m.group.pop()),
        ];
        for (number, flaw) in flaws.into_iter().enumerate() {
            let mut wrong = known();
            flaw(&mut wrong);
            assert!(wrong.to_bytes().is_err(), "{number}");
            let raw = rkyv::to_bytes::<rkyv::rancor::Error>(&wrong).unwrap();
            let error =
                MaterialsTable::from_block(&block(&encode(MATERIALS, TileNumber::FIRST, 2, 2, &raw, 9).unwrap()))
                    .unwrap_err();
            assert!(error.to_string().contains("block materials/0"), "{number}: {error}");
        }
    }

    /// None of 992 changes of a bit and none of 123 cuts ends the program, though checksums are
    /// right. All cuts are refused.
    #[test]
    fn hostile_bytes_are_survived() {
        let raw = known().to_bytes().unwrap();
        let (refused, accepted) = hostile(MATERIALS, 2, &raw, MaterialsTable::from_block);
        assert_eq!(refused + accepted, raw.len() * 9 - 1);
        assert!(refused >= raw.len() - 1, "{refused}");
    }
}
