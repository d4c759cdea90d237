//! Part of the model that each receiver of a tile stands for. In: receivers. Out: a table, and
//! back.

use rkyv::{Archive, Deserialize, Serialize};

use crate::archive::format::{MAX_STRING, MAX_TILE_RECEIVERS, PARTS, TileNumber};
use crate::archive::tables::{Flaw, column, table};
use crate::archive::{Blocks, tables};
use crate::error;
use crate::site::model_part::ModelPart;
use crate::site::receiver::Receiver;

/// Table of one tile, schema 1, row by row as its receivers; a text is empty where the input gives
/// none.
#[derive(Clone, Debug, Default, PartialEq, Archive, Serialize, Deserialize)]
pub struct PartsTable {
    /// Names of city objects, zones, rooms.
    pub object: Vec<String>,
    /// Names of the wholes that the objects are parts of.
    pub building: Vec<String>,
    /// Kind: `roof`, `wall`, `window`, `ground`, `floor`, `shade` or a word of the input.
    pub kind: Vec<String>,
    /// Types of the objects in the input.
    pub object_type: Vec<String>,
    /// Names of faces of the input.
    pub face: Vec<String>,
}

table!(PartsTable, [PARTS]);

impl PartsTable {
    /// Returns the parts of receivers; `None` where nothing is known of any.
    pub fn new<'a>(receivers: impl IntoIterator<Item = &'a Receiver>) -> Option<Self> {
        let mut table = PartsTable::default();
        let mut known = false;
        for Receiver { part, .. } in receivers {
            known |= !part.is_empty();
            for (column, text) in table.columns_mut().into_iter().zip(part.texts()) {
                column.push(text.to_owned());
            }
        }
        known.then_some(table)
    }

    /// Gives the receivers of a tile their parts; a tile without a block has none.
    pub fn join(blocks: &dyn Blocks, tile: u32, receivers: &mut [Receiver]) -> error::Result<()> {
        if !blocks.has(PARTS, TileNumber(tile)) {
            return Ok(());
        }
        let block = blocks.block(PARTS, TileNumber(tile))?;
        let parts = PartsTable::from_block(&block)?.parts();
        if parts.len() != receivers.len() {
            return Err(block.corrupt(format!("{} rows", parts.len()), format!("{} receivers", receivers.len())));
        }
        for (receiver, part) in receivers.iter_mut().zip(parts) {
            receiver.part = part;
        }
        Ok(())
    }

    /// Returns the receivers of a tile with their parts.
    pub fn receivers(blocks: &dyn Blocks, tile: u32) -> error::Result<Vec<Receiver>> {
        let table =
            tables::ReceiversTable::from_block(&blocks.block(crate::archive::format::RECEIVERS, TileNumber(tile))?)?;
        let mut receivers = table.receivers();
        PartsTable::join(blocks, tile, &mut receivers)?;
        Ok(receivers)
    }

    /// Returns the number of receivers.
    pub fn rows(&self) -> usize {
        self.object.len()
    }

    fn parts(self) -> Vec<ModelPart> {
        let PartsTable { object, building, kind, object_type, face } = self;
        let rest = building.into_iter().zip(kind).zip(object_type.into_iter().zip(face));
        let part = |(object, ((building, kind), (object_type, face)))| {
            ModelPart::of_texts([object, building, kind, object_type, face])
        };
        object.into_iter().zip(rest).map(part).collect()
    }

    fn columns(&self) -> [&Vec<String>; 5] {
        [&self.object, &self.building, &self.kind, &self.object_type, &self.face]
    }

    fn columns_mut(&mut self) -> [&mut Vec<String>; 5] {
        [&mut self.object, &mut self.building, &mut self.kind, &mut self.object_type, &mut self.face]
    }

    fn check(&self) -> Result<(), Flaw> {
        let rows = self.rows();
        if rows == 0 || rows as u64 > u64::from(MAX_TILE_RECEIVERS) {
            return Err(Flaw::new(format!("{rows} receivers"), format!("1 to {MAX_TILE_RECEIVERS} a tile")));
        }
        for (name, values) in ModelPart::COLUMNS.into_iter().zip(self.columns()) {
            column(name, values, rows, "0 to 1024 bytes", |text| text.len() <= MAX_STRING)?;
        }
        Ok(())
    }
}

#[cfg(all(test, feature = "zstd"))]
mod tests {
    use super::*;
    use crate::archive::tables::tests::{block, hostile};
    use crate::archive::{encode, format};
    use crate::site::patch::Patch;
    use glam::DVec3;

    fn receiver(part: [&str; 5]) -> Receiver {
        Receiver {
            id: "r".to_owned(),
            position: DVec3::ZERO,
            normal: DVec3::Z,
            area: None,
            surface: None,
            part: ModelPart::of_texts(part.map(str::to_owned)),
            patch: Patch::default(),
        }
    }

    fn known() -> PartsTable {
        let receivers = [
            receiver(["Core_ZN", "Office", "window", "Building", "Perimeter_bot_ZN_1_Wall_South_Window"]),
            receiver(["", "", "", "", ""]),
        ];
        PartsTable::new(&receivers).expect("something is known")
    }

    /// The known value has the known 156 bytes, so the layout of schema 1 is unchanged. It reads
    /// back equal.
    #[test]
    fn layout_is_frozen() {
        let raw = known().to_bytes().unwrap();
        assert_eq!((raw.len(), format::hex(&format::checksum(&raw))), (156, "b00df4ea3c6eb67f".to_string()));
        let back = PartsTable::from_block(&block(&known().encode(PARTS, TileNumber::FIRST, 9).unwrap())).unwrap();
        assert_eq!(back, known());
    }

    /// One of 2 receivers has 5 texts, which come back. Two receivers of which nothing is known
    /// have no table.
    #[test]
    fn parts_come_back() {
        let parts = known().parts();
        assert_eq!(parts[0].texts()[..3], ["Core_ZN", "Office", "window"]);
        assert!(parts[1].is_empty());
        assert_eq!(PartsTable::new(&[receiver([""; 5]), receiver([""; 5])]), None);
    }

    /// A text of 1025 bytes and a column that is too short are refused on writing and, under right
    /// checksums, on reading: 2 of 2.
    #[test]
    fn ranges_are_checked() {
        let flaws: [fn(&mut PartsTable); 2] = [|t| t.face[1] = "x".repeat(1025), |t| t.kind.truncate(1)];
        for flaw in flaws {
            let mut wrong = known();
            flaw(&mut wrong);
            assert!(wrong.to_bytes().is_err());
            let raw = rkyv::to_bytes::<rkyv::rancor::Error>(&wrong).unwrap();
            let error =
                PartsTable::from_block(&block(&encode(PARTS, TileNumber::FIRST, 1, 2, &raw, 9).unwrap())).unwrap_err();
            assert!(error.to_string().contains("block parts/0"), "{error}");
        }
    }

    /// No change of one bit and no cut ends the program, though checksums are right: each is read
    /// or refused, and all cuts are refused.
    #[test]
    fn hostile_bytes_are_survived() {
        let raw = known().to_bytes().unwrap();
        let (refused, accepted) = hostile(PARTS, 2, &raw, PartsTable::from_block);
        assert_eq!(refused + accepted, raw.len() * 9 - 1);
        assert!(refused >= raw.len() - 1, "{refused}");
    }
}
