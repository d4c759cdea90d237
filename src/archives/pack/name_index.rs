//! Name index and boxes of tiles, to find receivers by name or place. In: receivers, tile by tile.
//! Out: blocks of tiles' boxes and of names.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::pack::COMPRESSION;
use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::tables::{ExtentsTable, NAMES_A_CHUNK, NameOf, NameRow, NamesTable, TILES_A_CHUNK};
use heliotile_core::archive::{EncodedBlock, format};
use heliotile_core::error::Result;
use heliotile_core::site::receiver::Receiver;
use heliotile_files::spill::{Sorter, damaged};

/// Names and boxes of tiles, collected until all tiles are added.
pub struct NameIndexWriter {
    boxes: Vec<[DVec3; 2]>,
    /// Numbers of tiles by kind of name ([`NameOf`]) and name; tiles ascend.
    names: Sorter,
    /// Folder of the temporary files for names that do not fit in memory.
    folder: PathBuf,
}

impl NameIndexWriter {
    /// Creates an index without tiles. Names that exceed `budget_bytes` go to temporary files in
    /// `folder`.
    pub fn new(folder: &Path, budget_bytes: usize) -> Self {
        NameIndexWriter { boxes: Vec::new(), names: Sorter::new(folder, budget_bytes), folder: folder.to_path_buf() }
    }

    /// Adds the names and the box of the receivers of the next tile.
    pub fn add<'r>(&mut self, receivers: impl Iterator<Item = &'r Receiver> + Clone) -> Result<()> {
        let tile = (self.boxes.len() as u32).to_le_bytes();
        self.boxes.extend(ExtentsTable::around(receivers.clone().map(|receiver| receiver.position)));
        let names: BTreeSet<(NameOf, &str)> =
            receivers.flat_map(NameOf::names).filter(|(_, name)| !name.is_empty()).collect();
        for (of, name) in names {
            self.names.push(&[&[of as u8], name.as_bytes()].concat(), &tile)?;
        }
        Ok(())
    }

    /// Passes the blocks of all tiles to `append`, in the order in which they are written.
    pub fn finish(self, mut append: impl FnMut(EncodedBlock) -> Result<()>) -> Result<()> {
        for (chunk, boxes) in (0..).zip(self.boxes.chunks(TILES_A_CHUNK)) {
            append(ExtentsTable::new(boxes).encode(format::EXTENTS, TileNumber(chunk), COMPRESSION)?)?;
        }
        let pulled = |(key, tile): (Vec<u8>, Vec<u8>)| row(&key, &tile).ok_or_else(|| damaged(&self.folder));
        let mut names = self.names.finish()?.map(|record| record.and_then(pulled));
        // The first chunk lists the first name of every other one, so a reader finds a name with
        // two blocks.
        let mut firsts: Vec<NameRow> = Vec::new();
        for chunk in 1.. {
            let rows: Vec<NameRow> = names.by_ref().take(NAMES_A_CHUNK).collect::<Result<_>>()?;
            let Some(first) = rows.first() else { break };
            firsts.push(NameRow { tile: chunk, ..first.clone() });
            append(NamesTable::new(&rows).encode(format::NAMES, TileNumber(chunk), COMPRESSION)?)?;
        }
        match firsts.is_empty() {
            true => Ok(()),
            false => append(NamesTable::new(&firsts).encode(format::NAMES, TileNumber::FIRST, COMPRESSION)?),
        }
    }
}

/// Decodes a row that [`NameIndexWriter::add`] pushed; `None` for bytes that it never pushes.
fn row(key: &[u8], tile: &[u8]) -> Option<NameRow> {
    let (of, name) = key.split_first()?;
    Some(NameRow {
        of: *NameOf::ALL.get(usize::from(*of))?,
        name: String::from_utf8(name.to_vec()).ok()?,
        tile: u32::from_le_bytes(tile.try_into().ok()?),
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use heliotile_core::archive::codec::block;
    use heliotile_core::archive::format::BlockKind;
    use heliotile_core::archive::manifest::ReceiverSummary;
    use heliotile_core::archive::settings::Settings;
    use heliotile_core::archive::{Block, Blocks};
    use heliotile_core::opened::{NameIndex, OpenSite, SiteFacts, tiles_within};
    use heliotile_core::site::model_part::ModelPart;
    use heliotile_core::site::patch::Patch;

    struct Held(BTreeMap<(BlockKind, TileNumber), EncodedBlock>);

    impl Blocks for Held {
        fn path(&self) -> &Path {
            Path::new("site.helio")
        }

        fn has(&self, kind: BlockKind, tile: TileNumber) -> bool {
            self.0.contains_key(&(kind, tile))
        }

        fn rows(&self, kind: BlockKind, tile: TileNumber) -> Option<u32> {
            self.0.get(&(kind, tile)).map(|block| block.entry().items)
        }

        fn block(&self, kind: BlockKind, tile: TileNumber) -> Result<Block> {
            let found = &self.0[&(kind, tile)];
            block::decode(&self.path().into(), found.entry(), found.stored())
        }
    }

    fn receiver(tile: usize, number: usize) -> Receiver {
        Receiver {
            id: format!("t{tile}/r{number}"),
            position: DVec3::new(tile as f64, number as f64, 0.0),
            normal: DVec3::Z,
            area: None,
            surface: Some(if number == 0 { "terrain".to_owned() } else { format!("wall {}", tile / 3) }),
            part: ModelPart { object: format!("o{}", tile / 100), ..ModelPart::default() },
            patch: Patch::default(),
        }
    }

    /// 5,000 tiles of two receivers each are indexed with 20 kB of memory. The terrain's rows fill
    /// three chunks and lie in all tiles, an id lies in one tile, a wall in three, an object in a
    /// hundred; names before, between and behind all others lie in none. A box across a seam of
    /// chunks meets the 7 tiles that it covers. The index takes 13 chunks of names and one that
    /// lists them, and 2 chunks of boxes.
    #[test]
    fn names_and_boxes_lead_to_tiles() {
        let mut writer = NameIndexWriter::new(&std::env::temp_dir(), 20_000);
        for tile in 0..5000 {
            writer.add([receiver(tile, 0), receiver(tile, 1)].iter()).expect("names");
        }
        let mut blocks = BTreeMap::new();
        let keep = |block: EncodedBlock| {
            blocks.insert(block.entry().key(), block);
            Ok(())
        };
        writer.finish(keep).expect("blocks");
        let held = Held(blocks);
        let of_kind = |kind| held.0.keys().filter(|key| key.0 == kind).count();
        assert_eq!([of_kind(format::NAMES), of_kind(format::EXTENTS)], [14, 2]);

        let receivers = ReceiverSummary { count: 10_000, tiles: 5000, ..ReceiverSummary::default() };
        let (sky_base, sky_fine, hit, probe, probe_hits) = (32, 64, 16, 16, 16);
        let (bounce_sky, bounce_hits, closed_m, patches, steps) = (8, 16, 32.0, 145, 6);
        let sides = Settings { sky_base, sky_fine, hit, probe, probe_hits, ..Settings::default() };
        let settings = Settings { bounce_sky, bounce_hits, closed_m, patches, steps, ..sides };
        let facts = SiteFacts::given(held.path(), &settings, DVec3::ZERO, &receivers, Vec::new(), Vec::new());
        let facts = facts.expect("facts");
        let site = OpenSite::over(&held, facts.into());
        let mut name_index = NameIndex::new(&site).expect("names");
        let mut tiles = |of, name: &str| name_index.tiles(of, name).expect("tiles");
        assert_eq!(tiles(NameOf::Surface, "terrain"), Vec::from_iter(0..5000));
        assert_eq!(tiles(NameOf::Receiver, "t4321/r1"), [4321]);
        assert_eq!(tiles(NameOf::Surface, "wall 1000"), [3000, 3001, 3002]);
        assert_eq!(tiles(NameOf::Object, "o49"), Vec::from_iter(4900..5000));
        for (of, name) in [
            (NameOf::Receiver, "!"),
            (NameOf::Receiver, "t4321"),
            (NameOf::Receiver, "t4321/r11"),
            (NameOf::Surface, "t4321/r1"),
            (NameOf::Object, "o490"),
            (NameOf::Building, "zzz"),
        ] {
            assert!(tiles(of, name).is_empty(), "{of:?} {name}");
        }
        let within = |low: f64, high: f64| {
            let corners = [DVec3::new(low, 0.5, -1.0), DVec3::new(high, 2.0, 1.0)];
            tiles_within(&site, corners).expect("boxes")
        };
        assert_eq!(within(4092.5, 4099.0), Vec::from_iter(4093..4100));
        assert!(within(-3.0, -1.0).is_empty());
    }
}
