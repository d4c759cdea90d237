//! Objects of the scene, triangle by triangle.

use rkyv::{Archive, Deserialize, Serialize};

use crate::archive::format::{MAX_STRING, OBJECTS};
use crate::archive::tables::{Flaw, MAX_TRIANGLES, column, table};

/// What is known of an object of the scene; a text is empty where nobody says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ObjectRow {
    /// What its surfaces are called after.
    pub name: String,
    /// What tables of results call it, if not so.
    pub object: String,
    /// The whole that it is a part of.
    pub building: String,
    /// What the model calls objects of this sort.
    pub object_type: String,
    /// Whether it stands beside the buildings of a city model: a bridge, a tree, furniture.
    pub beside: bool,
}

/// Objects of a chunk of triangles, a row each, and the object of each triangle, schema 1; as many triangles as its block of the scene has.
#[derive(Clone, Debug, Default, PartialEq, Archive, Serialize, Deserialize)]
pub struct ObjectsTable {
    /// Each one greater than the one before by its bytes.
    pub name: Vec<String>,
    /// Row by row as `name`.
    pub object: Vec<String>,
    /// Row by row as `name`.
    pub building: Vec<String>,
    /// Row by row as `name`.
    pub object_type: Vec<String>,
    /// 1 for an object beside the buildings, row by row as `name`.
    pub beside: Vec<u8>,
    /// Row of `name`, one for each triangle.
    pub row: Vec<u16>,
}

table!(ObjectsTable, [OBJECTS]);

impl ObjectsTable {
    /// Of objects whose names ascend, and the object of each triangle.
    pub fn new(objects: &[ObjectRow], of_triangle: &[u32]) -> Self {
        let mut used = of_triangle.to_vec();
        used.sort_unstable();
        used.dedup();
        let mut table = ObjectsTable::default();
        let mut places: Vec<u16> = Vec::with_capacity(used.len());
        for known in used.iter().map(|object| objects.get(*object as usize).cloned().unwrap_or_default()) {
            let ObjectRow { name, object, building, object_type, beside } = known;
            // Names that were cut may be equal.
            if table.name.last().is_none_or(|last| *last != within(&name)) {
                let texts = [name, object, building, object_type].map(|text| within(&text).to_owned());
                let columns = [&mut table.name, &mut table.object, &mut table.building, &mut table.object_type];
                columns.into_iter().zip(texts).for_each(|(column, text)| column.push(text));
                table.beside.push(u8::from(beside));
            }
            // There are no more than triangles.
            places.push(u16::try_from(table.name.len().saturating_sub(1)).unwrap_or(u16::MAX));
        }
        let place = |object: &u32| places.get(used.partition_point(|held| held < object)).copied();
        table.row = of_triangle.iter().map(|object| place(object).unwrap_or_default()).collect();
        table
    }

    /// The objects.
    pub fn objects(self) -> Vec<ObjectRow> {
        let ObjectsTable { name, object, building, object_type, beside, .. } = self;
        let rest = building.into_iter().zip(object_type).zip(beside);
        let whole = |((name, object), ((building, object_type), beside))| ObjectRow {
            name,
            object,
            building,
            object_type,
            beside: beside == 1,
        };
        name.into_iter().zip(object).zip(rest).map(whole).collect()
    }

    /// Number of triangles.
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
            return Err(Flaw::new("a name after one that belongs behind it", "names in order"));
        }
        column("beside", &self.beside, names, "0 or 1", |beside| *beside <= 1)?;
        column("row", &self.row, rows, "a row of the names", |row| usize::from(*row) < names)
    }
}

/// As much of a name as an archive holds.
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
        let named = |name: &str, beside| ObjectRow { name: name.to_owned(), beside, ..ObjectRow::default() };
        let barn =
            ObjectRow { building: "farm".to_owned(), object_type: "BuildingPart".to_owned(), ..named("barn", false) };
        ObjectsTable::new(&[barn, named("house", false), named("tree", true)], &[2, 0, 2])
    }

    /// Of 3 objects a chunk of 3 triangles holds the 2 that it bears. They have the known 132 bytes and come back; of all changes of a bit and
    /// all cuts none is misread: 1100 or more.
    #[test]
    fn layout_is_frozen() {
        let (known, raw) = (three(), three().to_bytes().unwrap());
        assert_eq!((known.name.join(" "), &known.row[..]), ("barn tree".to_owned(), &[1, 0, 1][..]));
        assert_eq!((raw.len(), format::hex(&format::checksum(&raw))), (132, "f0c487eb1e165005".to_string()));
        assert_eq!(
            ObjectsTable::from_block(&block(&known.encode(OBJECTS, TileNumber::FIRST, 9).unwrap())).unwrap(),
            known
        );
        let (refused, accepted) = hostile(OBJECTS, 3, &raw, |block| ObjectsTable::from_block(block).map(|_| ()));
        assert!(refused > 100 && refused + accepted > 1100, "{refused} {accepted}");
    }

    /// Each of 6 values out of range is refused: names out of order, twice and too long, an object that has no name, a mark that is none, a
    /// column that is too short.
    #[test]
    fn ranges_are_checked() {
        let flaws: [fn(&mut ObjectsTable); 6] = [
            |t| t.name.reverse(),
            |t| t.name[1] = "barn".into(),
            |t| t.name[1] = "x".repeat(1025),
            |t| t.row[1] = 2,
            |t| t.beside[0] = 2,
            |t| t.building.truncate(1),
        ];
        let refused = flaws.iter().filter(|flaw| {
            let mut wrong = three();
            flaw(&mut wrong);
            wrong.to_bytes().is_err()
        });
        assert_eq!(refused.count(), 6);
    }

    /// Names of 1030 bytes are cut to 1024, or to 1023 where a letter ends there; two that are then equal are one object.
    #[test]
    fn long_names_are_cut() {
        let names = [format!("{}1", "a".repeat(1029)), format!("{}2", "a".repeat(1029)), "\u{e9}".repeat(515)];
        let objects = names.map(|name| ObjectRow { name: format!("x{name}"), ..ObjectRow::default() });
        let table = ObjectsTable::new(&objects, &[0, 1, 2]);
        assert_eq!(table.row, [0, 0, 1]);
        assert_eq!(table.clone().objects().len(), 2);
        assert_eq!(table.name.iter().map(String::len).collect::<Vec<_>>(), [1024, 1023]);
        assert!(table.to_bytes().is_ok());
    }
}
