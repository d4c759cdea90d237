//! Small complete archive for tests: 3 receivers in 2 tiles, 10 blocks of 7 known kinds and one of
//! an unknown kind.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::writing::disk::Disk;
use crate::writing::writer::Interrupted;
use crate::writing::{Job, Summary, Writer};
use heliotile_core::archive::format::{BlockKind, CellKind, TileNumber};
use heliotile_core::archive::tables::{CellsTable, IndexTable, MaterialsTable, ReceiversTable};
use heliotile_core::archive::{EncodedBlock, Manifest, encode, format, manifest};
use heliotile_core::error::Result;
use heliotile_core::layers::cells;
use heliotile_core::site::cells::CellKey;

/// Job of the test site.
pub const JOB: Job = Job { scene: [1; 32], receivers: [2; 32], settings: [3; 32] };

/// Archive in its own folder.
pub struct Site {
    pub folder: tempfile::TempDir,
    pub path: PathBuf,
    pub summary: Summary,
}

pub fn receivers(tile: u32, rows: usize) -> ReceiversTable {
    ReceiversTable {
        ids: (0..rows).map(|row| format!("receiver-{tile}-{row}")).collect(),
        position: vec![[1.0, 2.0, 3.0]; rows],
        normal: vec![[0.0, 0.6, 0.8]; rows],
        area: vec![1.5; rows],
        surface: vec!["roof".to_string(); rows],
        sky_view: vec![0.75; rows],
        ground_view: vec![0.25; rows],
        obstruction_view: vec![0.0; rows],
    }
}

pub fn materials() -> MaterialsTable {
    MaterialsTable {
        name: vec!["soil".to_string()],
        diffuse: vec![0.25],
        specular: vec![0.0],
        class: vec![0],
        group: vec![String::new()],
    }
}

/// Returns a table of one cell of this level and facing, which sees one bounce cell.
pub fn cells(level: i8, facing: u8) -> cells::Cells {
    let key = |level, facing| CellKey { level, facing, material: 0, voxel: [1, -2, 3] };
    cells::Cells {
        keys: vec![key(level, facing)],
        normals: vec![[0.0, 0.0, 1.0]],
        bits: vec![0xf0; 8],
        seen: vec![key(2, 58)],
        hits: vec![0, cells::MISS],
        mirrors: Vec::new(),
        canopies: Vec::new(),
        doubtful: vec![false],
    }
}

pub fn encoded() -> Vec<EncodedBlock> {
    let layer = |kind, tile, items, byte| {
        let raw: Vec<u8> = (0..300_u32).map(|i| if i % 7 == 0 { (i / 7) as u8 } else { byte }).collect();
        encode(kind, tile, format::schema_of(kind).unwrap(), items, &raw, 9).unwrap()
    };
    vec![
        receivers(0, 2).encode(format::RECEIVERS, TileNumber::FIRST, 9).unwrap(),
        layer(format::SKY, TileNumber::FIRST, 2, 1),
        layer(format::HIT, TileNumber::FIRST, 2, 2),
        receivers(1, 1).encode(format::RECEIVERS, TileNumber(1), 9).unwrap(),
        layer(format::SKY, TileNumber(1), 1, 3),
        CellsTable::new(&cells(-1, 40)).encode(format::PROBES, TileNumber::FIRST, 9).unwrap(),
        IndexTable::new(&cells(-1, 40).keys).encode(format::INDEX, CellKind::Probes.index(), 9).unwrap(),
        CellsTable::new(&cells(2, 58)).encode(format::BOUNCE, TileNumber::FIRST, 9).unwrap(),
        IndexTable::new(&cells(2, 58).keys).encode(format::INDEX, CellKind::Bounces.index(), 9).unwrap(),
        materials().encode(format::MATERIALS, TileNumber::FIRST, 9).unwrap(),
        encode(BlockKind(77), TileNumber::FIRST, 9, 5, b"of a later release", 9).unwrap(),
    ]
}

/// Returns kind, tile and raw bytes of every block, in the order of writing.
pub fn blocks() -> Vec<(BlockKind, TileNumber, Vec<u8>)> {
    let path: Arc<Path> = PathBuf::from("site.helio").into();
    let raw = |block: EncodedBlock| {
        let bytes = heliotile_core::archive::codec::block::decode(&path, block.entry(), &block.stored)
            .unwrap()
            .bytes()
            .to_vec();
        (block.entry().kind, block.entry().tile, bytes)
    };
    encoded().into_iter().map(raw).collect()
}

pub fn manifest() -> Manifest {
    let mut manifest = Manifest::new();
    manifest.scene.content_hash = "00".repeat(32);
    manifest.scene.bounds_m = [[0.0; 3], [10.0, 20.0, 30.5]];
    manifest.receivers.count = 3;
    manifest.receivers.tile_size = 2;
    manifest.receivers.tiles = 2;
    manifest.settings.closed_m = 8.0;
    manifest.layers = manifest::summarize(encoded().iter().map(EncodedBlock::entry));
    manifest
}

/// Writes all blocks and finishes.
pub fn fill(mut writer: Writer) -> Summary {
    encoded().into_iter().for_each(|block| writer.append(block).unwrap());
    writer.finish(&manifest()).unwrap()
}

/// Writes the complete archive to the disk.
pub fn written() -> Site {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("site.helio");
    let summary = fill(Writer::create(&path, &JOB).unwrap());
    Site { folder, path, summary }
}

/// Returns the bytes of the archive.
pub fn bytes() -> (Vec<u8>, Summary) {
    let site = written();
    (std::fs::read(&site.path).unwrap(), site.summary)
}

/// Build of the site that is run many times, so everything is encoded once.
pub struct Build {
    pub blocks: Vec<EncodedBlock>,
    pub manifest: Manifest,
    /// File that every run must end with.
    pub bytes: Vec<u8>,
}

impl Build {
    pub fn new() -> Self {
        Build { blocks: encoded(), manifest: manifest(), bytes: bytes().0 }
    }

    /// Starts or resumes, appends the missing blocks with a checkpoint after each whose bit is set,
    /// reads a block back, and finishes. `acknowledged` becomes the number of blocks of the last
    /// checkpoint; a resume must find them.
    pub fn run(
        &self,
        disk: &Arc<dyn Disk>,
        path: &Path,
        interrupted: Interrupted,
        checkpoints: u64,
        acknowledged: &mut u64,
    ) -> Result<Summary> {
        let mut writer = Writer::start(Arc::clone(disk), path, &JOB, interrupted)?;
        let found = writer.resumed().map_or(0, |progress| progress.blocks);
        assert!(found >= *acknowledged, "{found} blocks of {acknowledged}");
        for (row, block) in self.blocks.iter().enumerate() {
            if !writer.has(block.entry().kind, block.entry().tile) {
                writer.append(block.clone())?;
            }
            if checkpoints >> row & 1 == 1 {
                writer.checkpoint()?;
                *acknowledged = writer.committed().map_or(0, |progress| progress.blocks);
            }
        }
        writer.read_back(format::SKY, TileNumber::FIRST)?;
        writer.finish(&self.manifest)
    }
}
