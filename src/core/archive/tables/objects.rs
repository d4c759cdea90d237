//! Objects of the scene, triangle by triangle. In: objects, and the object of each triangle. Out: a
//! table, and back.

use std::collections::BTreeMap;

use rkyv::{Archive, Deserialize, Serialize};

use crate::archive::format::{MAX_STRING, OBJECTS};
use crate::archive::tables::{Flaw, MAX_TRIANGLES, column, table};
use crate::site::scene_object::{ObjectNote, SceneObject};

/// Table of the objects of a chunk of triangles, a row each, and of the object of each triangle,
/// schema 2. It has as many triangles as its block of the scene.
#[derive(Clone, Debug, Default, PartialEq, Archive, Serialize, Deserialize)]
pub struct ObjectsTable {
    /// Names, strictly ascending by their bytes.
    pub name: Vec<String>,
    /// Names of the objects in tables, row by row as `name`.
    pub object: Vec<String>,
    /// Names of the wholes that they are parts of, row by row as `name`.
    pub building: Vec<String>,
    /// Types of the objects in the file, row by row as `name`.
    pub object_type: Vec<String>,
    /// Mark of an object beside the buildings, 1 or 0, row by row as `name`.
    pub beside: Vec<u8>,
    /// `[triangle]`: row of `name`.
    pub row: Vec<u16>,
    /// Attributes: a JSON object or nothing, row by row as `name`.
    pub attributes: Vec<String>,
}

/// Largest length of the attributes of an object, bytes.
pub const MAX_ATTRIBUTES: usize = 16_384;

table!(ObjectsTable, [OBJECTS]);

impl ObjectsTable {
    /// Returns the table of objects with ascending names; `of_triangle` holds the index of each
    /// triangle's object. If an index has no object, the table cannot be written.
    pub fn new(objects: &[SceneObject], of_triangle: &[u32]) -> Self {
        let mut used = of_triangle.to_vec();
        used.sort_unstable();
        used.dedup();
        let mut table = ObjectsTable::default();
        let mut rows: BTreeMap<u32, u16> = BTreeMap::new();
        for number in used {
            let Some(SceneObject { name, note }) = objects.get(number as usize) else { break };
            // Names that were cut may be equal.
            if table.name.last().is_none_or(|last| *last != within(name)) {
                let texts = [name, &note.object, &note.building, &note.object_type].map(|text| within(text).to_owned());
                let columns = [&mut table.name, &mut table.object, &mut table.building, &mut table.object_type];
                columns.into_iter().zip(texts).for_each(|(column, text)| column.push(text));
                table.beside.push(u8::from(note.beside));
                table.attributes.push(kept(&note.attributes).to_owned());
            }
            rows.insert(number, u16::try_from(table.name.len().saturating_sub(1)).unwrap_or(NO_ROW));
        }
        table.row = of_triangle.iter().map(|number| rows.get(number).copied().unwrap_or(NO_ROW)).collect();
        table
    }

    /// Returns the objects.
    pub fn objects(self) -> Vec<SceneObject> {
        let ObjectsTable { name, object, building, object_type, beside, attributes, .. } = self;
        let notes = object.into_iter().zip(building).zip(object_type.into_iter().zip(beside)).zip(attributes);
        let notes = notes.map(|(((object, building), (object_type, beside)), attributes)| ObjectNote {
            object,
            building,
            object_type,
            beside: beside == 1,
            attributes,
        });
        name.into_iter().zip(notes).map(|(name, note)| SceneObject { name, note }).collect()
    }

    /// Returns the number of triangles.
    pub fn rows(&self) -> usize {
        self.row.len()
    }

    fn check(&self) -> Result<(), Flaw> {
        let (rows, names) = (self.rows(), self.name.len());
        if rows == 0 || rows > MAX_TRIANGLES {
            return Err(Flaw::new(format!("{rows} triangles"), format!("1 to {MAX_TRIANGLES}")));
        }
        let texts = [&self.name, &self.object, &self.building, &self.object_type];
        for (name, values) in ["name", "object", "building", "object_type"].into_iter().zip(texts) {
            column(name, values, names, "0 to 1024 bytes", |text| text.len() <= MAX_STRING)?;
        }
        if !self.name.array_windows().all(|[a, b]| a < b) {
            return Err(Flaw::new("a name out of order", "names in order"));
        }
        column("attributes", &self.attributes, names, "0 to 16384 bytes", |text| text.len() <= MAX_ATTRIBUTES)?;
        column("beside", &self.beside, names, "0 or 1", |beside| *beside <= 1)?;
        column("row", &self.row, rows, "a row of the names", |row| usize::from(*row) < names)
    }
}

/// Row of a triangle without an object. It is a valid row only if every triangle of a chunk has its
/// own object.
const NO_ROW: u16 = u16::MAX;

/// Returns the attributes if an archive can hold them, else nothing: a part of a JSON object is not
/// one.
fn kept(attributes: &str) -> &str {
    if attributes.len() <= MAX_ATTRIBUTES { attributes } else { "" }
}

/// Returns a name cut to the length that an archive holds.
fn within(name: &str) -> &str {
    name.get(..name.floor_char_boundary(MAX_STRING)).unwrap_or_default()
}

#[cfg(all(test, feature = "zstd"))]
mod tests {
    use super::*;
    use crate::archive::format;
    use crate::archive::format::TileNumber;
    use crate::archive::tables::tests::{block, hostile};

    fn three() -> ObjectsTable {
        let named = |name: &str, beside| SceneObject {
            name: name.to_owned(),
            note: ObjectNote { beside, ..ObjectNote::default() },
        };
        let mut barn = named("barn", false);
        (barn.note.building, barn.note.object_type) = ("farm".to_owned(), "BuildingPart".to_owned());
        barn.note.attributes = r#"{"year":1901}"#.to_owned();
        ObjectsTable::new(&[barn, named("house", false), named("tree", true)], &[2, 0, 2])
    }

    /// A chunk of 3 triangles holds the 2 of 3 objects that its triangles belong to. They have the
    /// known 172 bytes and come back. None of more than 1100 changes of a bit and cuts ends the
    /// program.
    #[test]
    fn layout_is_frozen() {
        let (known, raw) = (three(), three().to_bytes().unwrap());
        assert_eq!((known.name.join(" "), &known.row[..]), ("barn tree".to_owned(), &[1, 0, 1][..]));
        assert_eq!((raw.len(), format::hex(&format::checksum(&raw))), (172, "2f696f7e877447e7".to_string()));
        assert_eq!(
            ObjectsTable::from_block(&block(&known.encode(OBJECTS, TileNumber::FIRST, 9).unwrap())).unwrap(),
            known
        );
        let (refused, accepted) = hostile(OBJECTS, 3, &raw, |block| ObjectsTable::from_block(block).map(|_| ()));
        assert!(refused > 100 && refused + accepted > 1100, "{refused} {accepted}");
    }

    /// Each of 7 values out of range is refused: names out of order, twice and too long, an object
    /// without a name, a bad mark, a column that is too short, attributes that are too long.
    #[test]
    fn ranges_are_checked() {
        let flaws: [fn(&mut ObjectsTable); 7] = [
            |t| t.name.reverse(),
            |t| t.name[1] = "barn".into(),
            |t| t.name[1] = "x".repeat(1025),
            |t| t.row[1] = 2,
            |t| t.beside[0] = 2,
            |t| t.building.truncate(1),
            |t| t.attributes[0] = "x".repeat(16_385),
        ];
        // A triangle of a missing object.
        assert!(ObjectsTable::new(&[SceneObject::default()], &[0, 1]).to_bytes().is_err());
        let refused = flaws.iter().filter(|flaw| {
            let mut wrong = three();
            flaw(&mut wrong);
            wrong.to_bytes().is_err()
        });
        assert_eq!(refused.count(), 7);
    }

    /// Names of 1030 bytes are cut to 1024, or to 1023 where a letter ends there. Two names that
    /// are then equal are one object.
    #[test]
    fn long_names_are_cut() {
        let names = [format!("{}1", "a".repeat(1029)), format!("{}2", "a".repeat(1029)), "\u{e9}".repeat(515)];
        let objects = names.map(|name| SceneObject { name: format!("x{name}"), ..SceneObject::default() });
        let table = ObjectsTable::new(&objects, &[0, 1, 2]);
        assert_eq!(table.row, [0, 0, 1]);
        assert_eq!(table.clone().objects().len(), 2);
        assert_eq!(table.name.iter().map(String::len).collect::<Vec<_>>(), [1024, 1023]);
        assert!(table.to_bytes().is_ok());
    }
}
