//! All offsets, sizes, limits and ids of the file: `schema/heliotile-1.md` in code. In: plain
//! bytes. Out: slots and directory entries, each decoded without trust in any of its numbers.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::archive::record::Plain;

/// Kind of a block's content, as the directory states it. A later release may have kinds that this
/// one does not know.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct BlockKind(pub u32);

/// Number of a block among those of its kind: the tile of its receivers or the chunk of its cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TileNumber(pub u32);

impl TileNumber {
    /// The first number. A table of the whole site, the only block of its kind, has it.
    pub const FIRST: TileNumber = TileNumber(0);
}

impl fmt::Display for TileNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

macro_rules! plain_wrappers {
    ($($name:ident)*) => {$(
        impl Plain for $name {
            fn put(&self, out: &mut Vec<u8>) {
                self.0.put(out);
            }
            fn take(bytes: &[u8]) -> Option<(Self, &[u8])> {
                u32::take(bytes).map(|(number, rest)| ($name(number), rest))
            }
        }
    )*};
}
plain_wrappers!(BlockKind TileNumber);

/// First bytes of a slot. As in PNG, 0x89 and the line ends reveal a transfer as text.
pub const MAGIC: [u8; 8] = [0x89, b'H', b'L', b'O', 0x0d, 0x0a, 0x1a, 0x0a];
/// Major number of the format that this release reads and writes.
pub const MAJOR: u16 = 1;
/// Minor number of the format that this release reads and writes; archives of any other number are
/// refused.
pub const MINOR: u16 = 7;
/// Offsets of slot A and slot B. A writer that commits more often can write the slot that does not
/// count, so that one whole slot always remains.
pub const SLOT_OFFSETS: [u64; 2] = [0, 4096];
/// Bytes of a slot, its checksum included.
pub const SLOT_SIZE: usize = 512;
/// Bytes of a slot before its checksum.
const SLOT_CHECKED: usize = 504;
/// Offset of the first block.
pub const FIRST_BLOCK: u64 = 8192;
/// Blocks, directory and manifest start at multiples of this.
pub const ALIGNMENT: u64 = 64;
/// Bytes of a directory entry.
pub const ENTRY_SIZE: usize = 80;

/// Largest block before compression.
pub const MAX_RAW: usize = 8 << 20;
/// Largest number of entries of a directory.
pub const MAX_ENTRIES: u64 = 1 << 26;
/// Longest manifest, bytes: 1 MiB.
pub const MAX_MANIFEST: u64 = 1 << 20;
/// Largest number of receivers of a tile that a manifest may state; this release writes
/// [`TILE`](crate::site::receiver::TILE).
pub const MAX_TILE_RECEIVERS: u32 = 4096;
/// Longest string of a table, bytes.
pub const MAX_STRING: usize = 1024;
/// Largest number of materials: cell keys hold their numbers in 16 bits.
pub const MAX_MATERIALS: usize = 1 << 16;

/// State of a slot that is being written.
pub const BUILDING: u32 = 0;
/// State of a slot whose generation is whole. Readers accept no other.
pub const COMPLETE: u32 = 1;

/// Names of the required feature bits that only versions before the first release set, lowest
/// first. This release sets no required bit and reads no archive that has one.
pub const RETIRED_BITS: [&str; 1] = ["experimental"];

/// Codec of blocks that are stored without compression.
pub const CODEC_RAW: u16 = 0;
/// Codec of blocks that are one zstd frame.
pub const CODEC_ZSTD: u16 = 1;

/// Kind: ids, places, normals, areas, surfaces and view factors of a tile's receivers.
pub const RECEIVERS: BlockKind = BlockKind(1);
/// Kind: bits of the sky that a tile's receivers see, refined at edges.
pub const SKY: BlockKind = BlockKind(2);
/// Kind: the cells that the rays through each texel of a tile's receivers hit.
pub const HIT: BlockKind = BlockKind(3);
/// Kind: a tile's responses, derived from the other blocks for the stored reflectances.
pub const RESPONSE: BlockKind = BlockKind(4);
/// Kind: a chunk of the cells that receivers see.
pub const PROBES: BlockKind = BlockKind(5);
/// Kind: a chunk of the coarser cells that probes and bounce cells see.
pub const BOUNCE: BlockKind = BlockKind(6);
/// Kind: first keys of all chunks of one kind of cells.
pub const INDEX: BlockKind = BlockKind(7);
/// Kind: sky and cells that a tile's receivers see in mirrors.
pub const MIRROR: BlockKind = BlockKind(8);
/// Kind: how often rays of a tile's receivers cross leaves and screens.
pub const CANOPY: BlockKind = BlockKind(9);
/// Kind: the materials, one block; cell keys hold their rows.
pub const MATERIALS: BlockKind = BlockKind(10);
/// Kind: optics of the materials beside diffuse reflection, one block, row by row as the materials.
pub const OPTICS: BlockKind = BlockKind(11);
/// Kind: sky and cells that a chunk of probes sees in mirrors.
pub const PROBE_MIRROR: BlockKind = BlockKind(12);
/// Kind: sky and cells that a chunk of bounce cells sees in mirrors.
pub const BOUNCE_MIRROR: BlockKind = BlockKind(13);
/// Kind: how often rays of a chunk of probes cross leaves and screens.
pub const PROBE_CANOPY: BlockKind = BlockKind(14);
/// Kind: how often rays of a chunk of bounce cells cross leaves and screens.
pub const BOUNCE_CANOPY: BlockKind = BlockKind(15);
/// Kind: orientations of the mirrors, one block; chains hold their rows.
pub const MIRRORS: BlockKind = BlockKind(16);
/// Kind: the part of the model that each of a tile's receivers stands for, where any is known.
pub const PARTS: BlockKind = BlockKind(17);
/// Kind: a chunk of the scene's triangles, where the archive may show them.
pub const SCENE: BlockKind = BlockKind(18);
/// Kind: shapes of a tile's receivers that a viewer draws before it reads anything else; in
/// archives that may show their scene.
pub const OVERVIEW: BlockKind = BlockKind(19);
/// Kind: boxes around the receivers of some tiles; the blocks together cover all tiles.
pub const EXTENTS: BlockKind = BlockKind(20);
/// Kind: names in order, each with the tiles that hold it; chunk 0 holds the first name of each
/// other chunk.
pub const NAMES: BlockKind = BlockKind(21);
/// Kind: the objects that a chunk of the scene's triangles is made of; in archives that may show
/// their scene.
pub const OBJECTS: BlockKind = BlockKind(22);
/// Kind: values of materials in bands of the light, one block; in archives whose materials state
/// some.
pub const BANDS: BlockKind = BlockKind(23);

/// Kinds from which reflected light is derived; an archive for replay only holds none of them.
pub const REFLECTING: [BlockKind; 8] =
    [HIT, PROBES, BOUNCE, INDEX, PROBE_MIRROR, BOUNCE_MIRROR, PROBE_CANOPY, BOUNCE_CANOPY];

/// The two kinds of cells; each has chunks, layers of them, and an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellKind {
    /// Cells that receivers see.
    Probes,
    /// Coarser cells that probes and bounce cells see.
    Bounces,
}

impl CellKind {
    /// Returns the kind of the blocks that hold chunks of these cells.
    pub fn chunks(self) -> BlockKind {
        match self {
            CellKind::Probes => PROBES,
            CellKind::Bounces => BOUNCE,
        }
    }

    /// Returns the kinds of the layers that only some scenes have: mirrors, canopies. Their number
    /// is that of the chunk.
    pub fn extras(self) -> [BlockKind; 2] {
        match self {
            CellKind::Probes => [PROBE_MIRROR, PROBE_CANOPY],
            CellKind::Bounces => [BOUNCE_MIRROR, BOUNCE_CANOPY],
        }
    }

    /// Returns the number of the index of their chunks among blocks of [`INDEX`].
    pub fn index(self) -> TileNumber {
        match self {
            CellKind::Probes => TileNumber(0),
            CellKind::Bounces => TileNumber(1),
        }
    }
}

/// Kinds that this release knows: id, name, schema id of the raw bytes.
pub const KINDS: [(BlockKind, &str, u16); 23] = [
    (RECEIVERS, "receivers", 1),
    (SKY, "sky", 1),
    (HIT, "hit", 4),
    (RESPONSE, "response", 2),
    (PROBES, "probes", 4),
    (BOUNCE, "bounce", 4),
    (INDEX, "index", 2),
    (MIRROR, "mirror", 2),
    (CANOPY, "canopy", 5),
    (MATERIALS, "materials", 2),
    (OPTICS, "optics", 1),
    (PROBE_MIRROR, "probe-mirror", 2),
    (BOUNCE_MIRROR, "bounce-mirror", 2),
    (PROBE_CANOPY, "probe-canopy", 3),
    (BOUNCE_CANOPY, "bounce-canopy", 3),
    (MIRRORS, "mirrors", 1),
    (PARTS, "parts", 1),
    (SCENE, "scene", 1),
    (OVERVIEW, "overview", 1),
    (EXTENTS, "extents", 1),
    (NAMES, "names", 1),
    (OBJECTS, "objects", 2),
    (BANDS, "bands", 2),
];

/// Returns the name of a kind; a kind of a later release gets its number.
pub fn kind_name(kind: BlockKind) -> String {
    match KINDS.iter().find(|known| known.0 == kind) {
        Some((_, name, _)) => (*name).to_string(),
        None => format!("kind-{}", kind.0),
    }
}

/// Returns the schema id of a kind; `None` for an unknown kind.
pub fn schema_of(kind: BlockKind) -> Option<u16> {
    KINDS.iter().find(|known| known.0 == kind).map(|known| known.2)
}

/// Returns the name of a block in messages: `sky/3`.
pub fn block_name(kind: BlockKind, tile: TileNumber) -> String {
    format!("{}/{tile}", kind_name(kind))
}

/// Returns `offset` rounded up to the next multiple of [`ALIGNMENT`]; `None` beyond 2^64.
pub fn align(offset: u64) -> Option<u64> {
    offset.checked_next_multiple_of(ALIGNMENT)
}

/// Returns the first 8 bytes of BLAKE3.
pub fn checksum(bytes: &[u8]) -> [u8; 8] {
    let [a, b, c, d, e, f, g, h, ..] = *blake3::hash(bytes).as_bytes();
    [a, b, c, d, e, f, g, h]
}

/// Returns the hash of a block's raw content, which does not depend on its compression.
pub fn content_id(kind: BlockKind, schema: u16, raw: &[u8]) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&kind.0.to_le_bytes()).update(&schema.to_le_bytes()).update(raw);
    *hasher.finalize().as_bytes()
}

/// Returns the root hash of a generation.
pub fn root_hash(directory: &[u8], manifest: &[u8]) -> [u8; 32] {
    *blake3::Hasher::new().update(directory).update(manifest).finalize().as_bytes()
}

/// Returns lower-case hexadecimal digits, as in messages and the manifest.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

crate::record! {
    /// A header slot without its reserved bytes and checksum.
    Slot {
        /// First bytes: [`MAGIC`].
        magic: [u8; 8],
        /// Major format version.
        major: u16,
        /// Minor format version.
        minor: u16,
        /// State: [`BUILDING`] or [`COMPLETE`].
        state: u32,
        /// Feature bits that a reader must know.
        required: u64,
        /// Feature bits that a reader may ignore.
        optional: u64,
        /// Number of the generation, 0 before the first commit; the slot with the highest one
        /// counts.
        generation: u64,
        /// Length of the file up to the end of the manifest.
        committed: u64,
        /// Offset of the directory in the file.
        directory_offset: u64,
        /// Length of the directory in bytes: [`ENTRY_SIZE`] an entry.
        directory_length: u64,
        /// Number of entries of the directory, at most [`MAX_ENTRIES`].
        directory_count: u64,
        /// Offset of the manifest in the file.
        manifest_offset: u64,
        /// Length of the manifest in bytes, at most [`MAX_MANIFEST`].
        manifest_length: u64,
        /// [`root_hash`] of directory and manifest.
        root: [u8; 32],
    }
}

crate::record! {
    /// A directory entry: the place of a block and the numbers to check it.
    Entry {
        /// Kind of the block, such as [`SKY`].
        kind: BlockKind,
        /// Number among the blocks of its kind: the tile of its receivers, the chunk of its cells;
        /// 0 for a table of the whole site.
        tile: TileNumber,
        /// Offset of the block in the file, a multiple of [`ALIGNMENT`].
        offset: u64,
        /// Length in the file, bytes.
        stored: u32,
        /// Length after decoding, bytes.
        raw: u32,
        /// Codec: [`CODEC_RAW`] or [`CODEC_ZSTD`].
        codec: u16,
        /// Schema id: the layout of the raw bytes.
        schema: u16,
        /// Number of rows of the block.
        items: u32,
        /// [`checksum`] of the stored bytes.
        checksum: [u8; 8],
        /// [`content_id`] of the raw bytes.
        content: [u8; 32],
        /// Zero; kept unchanged.
        reserved: [u8; 8],
    }
}

impl Slot {
    /// Returns the slot of an archive that is being written: without directory and manifest.
    pub fn building() -> Self {
        Slot {
            magic: MAGIC,
            major: MAJOR,
            minor: MINOR,
            state: BUILDING,
            required: 0,
            optional: 0,
            generation: 0,
            committed: FIRST_BLOCK,
            directory_offset: FIRST_BLOCK,
            directory_length: 0,
            directory_count: 0,
            manifest_offset: FIRST_BLOCK,
            manifest_length: 0,
            root: root_hash(&[], &[]),
        }
    }

    /// Returns the [`SLOT_SIZE`] bytes of the slot, checksum included.
    pub fn encode(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(SLOT_SIZE);
        self.put(&mut bytes);
        bytes.resize(SLOT_CHECKED, 0);
        let sum = checksum(&bytes);
        bytes.extend_from_slice(&sum);
        bytes
    }

    /// Returns the slot if its magic and checksum are right, else `None`.
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        let (checked, sum) = bytes.get(..SLOT_SIZE)?.split_at_checked(SLOT_CHECKED)?;
        let (slot, _) = Slot::take(checked)?;
        (slot.magic == MAGIC && checksum(checked) == sum).then_some(slot)
    }

    /// Returns the numbers of the required feature bits, lowest first: this release knows none.
    pub fn unknown_bits(&self) -> Vec<u32> {
        (0..u64::BITS).filter(|bit| self.required >> bit & 1 == 1).collect()
    }
}

impl Entry {
    /// Adds the [`ENTRY_SIZE`] bytes of the entry to `out`.
    pub fn encode(&self, out: &mut Vec<u8>) {
        self.put(out);
    }

    /// Decodes an entry. Any 80 bytes are one; the reader checks their numbers.
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        Entry::take(bytes).map(|(entry, _)| entry)
    }

    /// Returns the name of the block in messages.
    pub fn name(&self) -> String {
        block_name(self.kind, self.tile)
    }

    /// Returns the key by which the directory is sorted.
    pub fn key(&self) -> (BlockKind, TileNumber) {
        (self.kind, self.tile)
    }

    /// Returns the offset of the first byte after the stored bytes; `None` beyond 2^64.
    pub fn end(&self) -> Option<u64> {
        self.offset.checked_add(u64::from(self.stored))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slot and an entry come back unchanged from their 512 and 80 bytes.
    #[test]
    fn slots_and_entries_come_back_from_their_bytes() {
        let slot = Slot { generation: 7, root: [9; 32], ..Slot::building() };
        assert_eq!(slot.encode().len(), 512);
        assert_eq!(Slot::decode(&slot.encode()), Some(slot));
        let bytes: Vec<u8> = (0..80).collect();
        let entry = Entry::decode(&bytes).unwrap();
        assert_eq!((entry.kind, entry.reserved[7]), (BlockKind(0x0302_0100), 79));
        let mut again = Vec::new();
        entry.encode(&mut again);
        assert_eq!(again, bytes);
    }

    /// Each of the 4096 single-bit changes of a slot makes it invalid, and so does each shorter
    /// length.
    #[test]
    fn a_damaged_slot_does_not_count() {
        let bytes = Slot::building().encode();
        for bit in 0..4096 {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(Slot::decode(&damaged), None, "bit {bit}");
        }
        assert_eq!((0..512).filter(|&n| Slot::decode(&bytes[..n]).is_some()).count(), 0);
    }

    /// Known kinds have names, and an unknown one has its number. Aligning near 2^64 does not
    /// overflow.
    #[test]
    fn unknown_kinds_have_numbers_and_alignment_is_safe() {
        assert_eq!(block_name(SKY, TileNumber(3)), "sky/3");
        assert_eq!(block_name(BlockKind(77), TileNumber(0)), "kind-77/0");
        assert_eq!((align(8193), align(u64::MAX)), (Some(8256), None));
        assert_eq!(Slot { required: 0b101, ..Slot::building() }.unknown_bits(), [0, 2]);
    }
}
