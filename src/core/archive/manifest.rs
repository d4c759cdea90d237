//! The manifest: an archive's content, its making and its accuracy, as JSON for people and
//! programs. In: JSON, or numbers of a build. Out: a checked manifest, or canonical JSON.
//!
//! It names no time, host or path, so equal sites have equal bytes. Keys of later releases are kept
//! unchanged.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::archive::accuracy::Accuracy;
use crate::archive::format;
use crate::archive::format::{BlockKind, Entry, MAX_MANIFEST, MAX_TILE_RECEIVERS, RECEIVERS, TileNumber};
use crate::archive::negligible::Negligible;
pub use crate::archive::settings::Settings;
use crate::error::{Error, Result};
use crate::site::ground::MonthlyGround;
use crate::site::place::Place;

/// Keys that this release does not know.
pub type Unknown = BTreeMap<String, Value>;

/// The whole manifest; `schema/manifest.schema.json` describes the same keys.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Name of the format: `heliotile`.
    pub format: String,
    /// Program and version that wrote it.
    pub creator: Creator,
    /// Summary of the traced scene.
    pub scene: SceneSummary,
    /// Number of receivers and of their tiles.
    pub receivers: ReceiverSummary,
    /// Sizes of textures and cells, and effects that were left out. With scene and receivers they
    /// decide the content.
    pub settings: Settings,
    /// Numbers of cells in the archive.
    pub counts: CellCounts,
    /// One row a kind, by rising kind; [`summarize`] makes them.
    pub layers: Vec<LayerSummary>,
    /// Error that the build estimated, if it did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Accuracy>,
    /// Reasons why effects were left out, if they rest on some weather.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub negligible: Option<Negligible>,
    /// True if hits and cells were left out: the archive answers what needs sky and response only.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub replay_only: bool,
    /// Place of the scene on Earth, if its files state it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<Place>,
    /// Ground reflectance by month, if the model states it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ground: Option<MonthlyGround>,
    /// Keys of later releases at the top of the manifest.
    #[serde(flatten)]
    pub other: Unknown,
}

/// The program that wrote the archive.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Creator {
    /// Name of the program: `heliotile`.
    pub name: String,
    /// Version of the program, such as `0.1.0`.
    pub version: String,
}

/// The traced geometry.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneSummary {
    /// BLAKE3 of the checked geometry and materials, hexadecimal.
    pub content_hash: String,
    /// Number of triangles without those that were left out.
    pub triangles: u64,
    /// Number of distinct corners.
    pub vertices: u64,
    /// Number of materials that triangles bear.
    pub materials: u64,
    /// Triangles without area that were left out.
    pub degenerate_dropped: u64,
    /// Origin that vertices and rays are relative to, input coordinates, metres.
    pub origin_m: [f64; 3],
    /// Step of the grid that vertices lie on, metres.
    pub grid_step_m: f64,
    /// Lowest and highest corner, input coordinates, metres.
    pub bounds_m: [[f64; 3]; 2],
    /// Keys of later releases about the scene.
    #[serde(flatten)]
    pub other: Unknown,
}

/// The receivers and how they are cut into tiles.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReceiverSummary {
    /// Number of receivers.
    pub count: u64,
    /// Largest number of receivers of a tile, 1 to 4096.
    pub tile_size: u32,
    /// Number of tiles, which are numbered from 0.
    pub tiles: u32,
    /// Keys of later releases about the receivers.
    #[serde(flatten)]
    pub other: Unknown,
}

/// Numbers of traced cells.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CellCounts {
    /// Cells that receivers see.
    pub probes: u64,
    /// Coarser cells that probes and bounce cells see.
    pub bounce_cells: u64,
}

/// Number and size of the blocks of one kind.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LayerSummary {
    /// Name of the kind, as in names of blocks.
    pub name: String,
    /// Number of the kind, as in [`format::KINDS`].
    pub kind: BlockKind,
    /// Number of blocks.
    pub blocks: u64,
    /// Sum of the lengths after decoding, bytes.
    pub raw_bytes: u64,
    /// Sum of the lengths in the file, bytes.
    pub stored_bytes: u64,
}

/// Returns one row a kind for a sorted directory. The sums cannot overflow: 2^26 entries of 32-bit
/// lengths at most.
pub fn summarize<'a>(entries: impl IntoIterator<Item = &'a Entry>) -> Vec<LayerSummary> {
    let mut rows: BTreeMap<BlockKind, LayerSummary> = BTreeMap::new();
    for entry in entries {
        let row = rows.entry(entry.kind).or_insert_with(|| LayerSummary {
            name: format::kind_name(entry.kind),
            kind: entry.kind,
            ..LayerSummary::default()
        });
        row.blocks = row.blocks.saturating_add(1);
        row.raw_bytes = row.raw_bytes.saturating_add(u64::from(entry.raw));
        row.stored_bytes = row.stored_bytes.saturating_add(u64::from(entry.stored));
    }
    rows.into_values().collect()
}

/// Error in a manifest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mismatch {
    /// Statement of the manifest.
    pub got: String,
    /// Statement that would be right.
    pub expected: String,
}

impl Manifest {
    /// Returns a manifest of this release; the caller fills in the rest.
    pub fn new() -> Self {
        Manifest {
            format: "heliotile".to_string(),
            creator: Creator { name: "heliotile".to_string(), version: env!("CARGO_PKG_VERSION").to_string() },
            ..Manifest::default()
        }
    }

    /// Returns canonical JSON: keys sorted, two spaces. Refuses numbers that JSON cannot hold (NaN,
    /// infinite) and more than 1 MiB.
    pub fn to_json(&self) -> Result<Vec<u8>> {
        let refuse = |found: String| Error::Unsupported {
            what: "writing the manifest".into(),
            found,
            supported: "finite numbers, and no unknown key with the name of a known one".into(),
        };
        let mut value = serde_json::to_value(self).map_err(|e| refuse(e.to_string()))?;
        value.sort_all_objects();
        let mut bytes = serde_json::to_vec_pretty(&value).map_err(|e| refuse(e.to_string()))?;
        bytes.push(b'\n');
        if bytes.len() as u64 > MAX_MANIFEST {
            let (what, value) = ("length of the manifest in bytes".to_string(), bytes.len() as u64);
            return Err(Error::Limit { what: what.into(), value, max: MAX_MANIFEST });
        }
        match Manifest::from_json(&bytes) {
            Ok(same) if same == *self => Ok(bytes),
            Ok(_) => Err(refuse("a value that is read back differently".to_string())),
            Err(wrong) => Err(refuse(wrong.got)),
        }
    }

    /// Reads JSON, whose length the caller has checked.
    pub fn from_json(bytes: &[u8]) -> std::result::Result<Self, Mismatch> {
        let manifest: Manifest = serde_json::from_slice(bytes)
            .map_err(|e| Mismatch { got: e.to_string(), expected: "a manifest".to_string() })?;
        if manifest.format != "heliotile" {
            let got = format!("format \"{}\"", manifest.format);
            return Err(Mismatch { got, expected: "format \"heliotile\"".to_string() });
        }
        Ok(manifest)
    }

    /// Checks that the manifest agrees with a sorted directory.
    pub fn check(&self, entries: &[Entry]) -> std::result::Result<(), Mismatch> {
        let wrong = |got: String, expected: String| Err(Mismatch { got, expected });
        let size = self.receivers.tile_size;
        if size == 0 || size > MAX_TILE_RECEIVERS {
            return wrong(format!("tile_size {size}"), format!("1 to {MAX_TILE_RECEIVERS}"));
        }
        let (mut tiles, mut count) = (0_u32, 0_u64);
        // Tiles are numbered from 0 without a gap.
        for entry in entries.iter().filter(|entry| entry.kind == RECEIVERS) {
            if entry.tile != TileNumber(tiles) {
                return wrong(entry.name(), format::block_name(RECEIVERS, TileNumber(tiles)));
            }
            if entry.items == 0 || entry.items > size {
                return wrong(format!("{} rows in {}", entry.items, entry.name()), format!("1 to {size}"));
            }
            tiles = tiles.saturating_add(1);
            count = count.saturating_add(u64::from(entry.items));
        }
        if (tiles, count) != (self.receivers.tiles, self.receivers.count) {
            let stated = format!("{} receivers in {} tiles", self.receivers.count, self.receivers.tiles);
            return wrong(stated, format!("{count} in {tiles}, as in the directory"));
        }
        let found = summarize(entries);
        let numbers = |row: &LayerSummary| (row.kind, row.blocks, row.raw_bytes, row.stored_bytes);
        if !self.layers.iter().map(numbers).eq(found.iter().map(numbers)) {
            let list = |rows: &[LayerSummary]| {
                let words = rows.iter().map(|r| format!("{} x {} ({} B)", r.blocks, r.name, r.stored_bytes));
                words.collect::<Vec<_>>().join(", ")
            };
            return wrong(format!("layers [{}]", list(&self.layers)), format!("[{}]", list(&found)));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A manifest with unknown keys on 4 levels and a float of 17 digits comes back equal, and its
    /// JSON has the same bytes again.
    #[test]
    fn a_manifest_and_its_unknown_keys_come_back() {
        let mut manifest = Manifest::new();
        manifest.scene.origin_m = [85_000.123_456_789, -0.1 - 0.2, 5e-324];
        for other in [
            &mut manifest.other,
            &mut manifest.scene.other,
            &mut manifest.receivers.other,
            &mut manifest.settings.other,
        ] {
            other.insert("later".to_string(), serde_json::json!({ "b": [1, 2.5], "a": null }));
        }
        let json = manifest.to_json().unwrap();
        let back = Manifest::from_json(&json).unwrap();
        assert_eq!(back, manifest);
        assert_eq!(back.to_json().unwrap(), json);
        assert_eq!(String::from_utf8(json).unwrap().matches("\"later\"").count(), 4);
    }

    /// The hash of settings is the known one and stays through JSON. Each of 3 changes, one of them
    /// under a key of a later release, gives another hash.
    #[test]
    fn each_change_of_settings_gives_another_hash() {
        let mut manifest = Manifest::new();
        manifest.settings.closed_m = 0.1 + 0.2;
        let settings = manifest.settings.clone();
        let name = |settings: &Settings| format::hex(&settings.hash().unwrap());
        assert_eq!(name(&settings)[..16], *"03ece8ec2d4ef517");
        let back = Manifest::from_json(&manifest.to_json().unwrap()).unwrap();
        assert_eq!(name(&back.settings), name(&settings));
        let changes: [fn(&mut Settings); 3] =
            [|s| s.hit = 1, |s| s.closed_m = 0.3, |s| drop(s.other.insert("later".to_string(), Value::from(1)))];
        let changed = changes.map(|change| {
            let mut other = settings.clone();
            change(&mut other);
            name(&other)
        });
        assert_eq!(changed.iter().filter(|other| **other != name(&settings)).count(), 3);
    }

    /// NaN, a known key among the unknown ones, and more than 1 MiB of JSON are refused on writing:
    /// 3 of 3.
    #[test]
    fn what_json_cannot_hold_is_refused() {
        let mut nan = Manifest::new();
        nan.settings.closed_m = f64::NAN;
        let mut twice = Manifest::new();
        twice.other.insert("format".to_string(), Value::from("other"));
        let mut long = Manifest::new();
        long.settings.quality = "x".repeat(1 << 20);
        let refused = [nan, twice, long].iter().filter(|m| m.to_json().is_err()).count();
        assert_eq!(refused, 3);
    }

    /// 200 000 nested arrays, a truncated text and another format are errors and do not overflow
    /// the stack.
    #[test]
    fn hostile_json_is_refused() {
        let deep = format!("{{\"later\":{}", "[".repeat(200_000)).into_bytes();
        let json = Manifest::new().to_json().unwrap();
        let other = String::from_utf8(json.clone()).unwrap().replace("\"heliotile\"", "\"other\"").into_bytes();
        let cut = json[..json.len() - 3].to_vec();
        assert_eq!([deep, other, cut].iter().filter(|bytes| Manifest::from_json(bytes).is_err()).count(), 3);
    }
}
