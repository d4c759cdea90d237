//! Digests of receivers and cells for comparison. In: a receiver with its layers, or a cell. Out:
//! hashes, names of parts that differ.

use crate::transfer::rows::{LayeredReceiver, Shown, TracedLayers};
use heliotile_core::layers::cells::Cell;
use heliotile_core::layers::response::Response;
use heliotile_core::layers::sky::SkyTexture;
use heliotile_core::site::cells::CellKey;

/// Parts of a receiver, in the order of the hashes.
const PARTS: [&str; 8] = ["place", "receivers", "sky", "hit", "response", "mirror", "canopy", "overview"];

/// Placeholder for the hash of an overview that the archive does not hold.
const NOT_SHOWN: [u8; 32] = [0; 32];

/// All layers of a receiver.
pub type AllLayers = ((TracedLayers, Response), Shown);

/// Hashes of a receiver's position and normal, of its other columns, and of its layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digests([[u8; 32]; PARTS.len()]);

impl Digests {
    pub fn new(row: &LayeredReceiver<AllLayers>) -> Self {
        let (receiver, ((traced, response), overview)) = (&row.receiver, &row.layers);
        let floats =
            |part: [glam::DVec3; 2]| part.iter().flat_map(|v| v.to_array()).flat_map(f64::to_le_bytes).collect();
        let place: Vec<u8> = floats([receiver.position, receiver.normal]);
        let mut columns: Vec<u8> = receiver.area.unwrap_or_default().to_le_bytes().to_vec();
        columns.extend(row.views.iter().flat_map(|view| view.to_le_bytes()));
        columns.extend(receiver.surface.as_deref().unwrap_or_default().as_bytes());
        columns.extend(receiver.part.texts().join("\0").as_bytes());
        // No key is all ones: the first bit of its bytes is 0.
        let key = |key: &Option<CellKey>| key.map_or([u8::MAX; CellKey::BYTES], CellKey::to_bytes);
        let hits: Vec<u8> = traced.hits.iter().flat_map(key).collect();
        let sky = SkyTexture::pack(std::slice::from_ref(&traced.sky));
        let response: Vec<u8> = response.values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let (mirror, canopy) = (traced.extras.mirrors.to_bytes(), traced.extras.canopy.to_bytes());
        let shown = *overview != Shown::default();
        let overview = format!("{:?} {}", overview.clear_year, overview.patch).into_bytes();
        let parts = [place, columns, sky, hits, response, mirror, canopy, overview];
        let mut digests = parts.map(|bytes| *blake3::hash(&bytes).as_bytes());
        if !shown {
            digests[PARTS.len() - 1] = NOT_SHOWN;
        }
        Digests(digests)
    }

    /// Returns the names of the parts that differ. An overview that only one of them has does not
    /// count.
    pub fn differences(&self, other: &Digests) -> Vec<&'static str> {
        let parts = PARTS.into_iter().zip(self.0.iter().zip(&other.0));
        parts.filter(|(_, (a, b))| a != b && **a != NOT_SHOWN && **b != NOT_SHOWN).map(|(name, _)| name).collect()
    }

    /// Returns the hashes as bytes, for sorting in temporary files.
    pub fn to_bytes(self) -> Vec<u8> {
        self.0.concat()
    }

    /// Inverse of [`Digests::to_bytes`]; zeros stand for missing bytes.
    pub fn from_bytes(bytes: &[u8]) -> Self {
        let mut digests = [[0; 32]; PARTS.len()];
        for (digest, bytes) in digests.iter_mut().zip(bytes.as_chunks().0) {
            *digest = *bytes;
        }
        Digests(digests)
    }
}

/// Returns true if two cells of one key have the same content. The order of rays does not matter.
pub fn same_cell(a: &Cell, b: &Cell) -> bool {
    let rays = |cell: &Cell| {
        let mut seen = cell.seen.clone();
        seen.sort_unstable();
        seen
    };
    let bits = |cell: &Cell| cell.normal.map(f32::to_bits);
    bits(a) == bits(b) && a.bits == b.bits && a.mirrors == b.mirrors && a.canopy == b.canopy && rays(a) == rays(b)
}

/// Formats a cell's key for people: level/facing/material/voxel.
pub fn cell_name(key: &CellKey) -> String {
    let [x, y, z] = key.voxel;
    format!("{}/{}/{}/{x},{y},{z}", key.level, key.facing, key.material)
}
