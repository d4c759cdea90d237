//! Reading an archive. In: a path, or bytes from anywhere. Out: checked blocks by (kind, tile), each copied out before it is decoded.

use std::path::Path;

use crate::archive::codec::block;
use crate::archive::codec::block::{Block, EncodedBlock};
use crate::archive::format;
use crate::archive::format::{
    ALIGNMENT, BlockKind, CODEC_RAW, ENTRY_SIZE, Entry, FIRST_BLOCK, MAX_RAW, Slot, TileNumber,
};
use crate::archive::header;
use crate::archive::header::Header;
use crate::archive::manifest::Manifest;
use crate::archive::read_at::ReadAt;
#[cfg(any(unix, windows))]
use crate::archive::source::Access;
use crate::archive::source::Source;
use crate::error::{Error, Result};

/// An open archive whose header, directory and manifest were checked. Many threads may read from it.
#[derive(Debug)]
pub struct Archive {
    source: Source,
    header: Header,
    entries: Vec<Entry>,
    manifest: Manifest,
}

impl Archive {
    /// Opens a finished archive of a file system through a mapping. An error: no archive, one that was not finished, one of a later format,
    /// or a header, directory or manifest that is damaged.
    #[cfg(any(unix, windows))]
    pub fn open(path: &Path) -> Result<Self> {
        Archive::open_with(path, Access::default())
    }

    /// The same, read as `access` says.
    #[cfg(any(unix, windows))]
    pub fn open_with(path: &Path, access: Access) -> Result<Self> {
        Archive::read(Source::open(path, access)?)
    }

    /// Opens a finished archive whose bytes are held anywhere, without a file system; `name` is what messages call it. The errors
    /// are those of `Archive::open`.
    pub fn of(name: impl AsRef<Path>, bytes: impl ReadAt + 'static) -> Result<Self> {
        Archive::read(Source::new(name.as_ref(), Box::new(bytes)))
    }

    /// Checks everything but the blocks, which are checked when they are read.
    pub(super) fn read(source: Source) -> Result<Self> {
        let path = source.path();
        let header = header::read(&source)?;
        let slot = &header.slot;
        let directory = source.read(slot.directory_offset, slot.directory_length)?;
        let json = source.read(slot.manifest_offset, slot.manifest_length)?;
        let corrupt =
            |part: &str, offset: u64, got: String, expected: String| Error::corrupt(path, part, offset, got, expected);
        let root = format::root_hash(&directory, &json);
        if root != slot.root {
            let (got, expected) = (format::hex(&root), format::hex(&slot.root));
            let part = "directory or manifest";
            return Err(corrupt(part, slot.directory_offset, format!("root {got}"), format!("root {expected}")));
        }
        let entries: Vec<Entry> = directory.chunks_exact(ENTRY_SIZE).filter_map(Entry::decode).collect();
        check_entries(path, &entries, slot)?;
        let manifest = Manifest::from_json(&json)
            .and_then(|manifest| manifest.check(&entries).map(|()| manifest))
            .map_err(|wrong| corrupt("manifest", slot.manifest_offset, wrong.got, wrong.expected))?;
        Ok(Archive { source, header, entries, manifest })
    }

    /// The file's path, or the name that the bytes were given.
    pub fn path(&self) -> &Path {
        self.source.path()
    }

    /// Number of bytes of all of it, as they are stored.
    pub fn length(&self) -> u64 {
        self.source.length()
    }

    /// The manifest, read when the archive was opened.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Hash of directory and manifest: names the content of the whole archive.
    pub fn root(&self) -> [u8; 32] {
        self.header.slot.root
    }

    /// The directory, sorted by (kind, tile), with blocks of unknown kinds.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// The directory entries of one kind, by tile.
    pub fn entries_of(&self, kind: BlockKind) -> &[Entry] {
        let start = self.entries.partition_point(|entry| entry.kind < kind);
        let end = self.entries.partition_point(|entry| entry.kind <= kind);
        self.entries.get(start..end).unwrap_or(&[])
    }

    /// Number of receiver tiles; they are numbered from 0.
    pub fn tiles(&self) -> u32 {
        self.manifest.receivers.tiles
    }

    /// The directory entry of a block.
    pub fn entry(&self, kind: BlockKind, tile: TileNumber) -> Option<&Entry> {
        let row = self.entries.binary_search_by_key(&(kind, tile), Entry::key).ok()?;
        self.entries.get(row)
    }

    /// Whether the archive holds a block.
    pub fn has(&self, kind: BlockKind, tile: TileNumber) -> bool {
        self.entry(kind, tile).is_some()
    }

    /// A block, checked and decoded; an error if it is damaged or not there.
    pub fn block(&self, kind: BlockKind, tile: TileNumber) -> Result<Block> {
        match self.entry(kind, tile) {
            Some(entry) => self.fetch(entry),
            None => {
                let what = format!("holds no block {}", format::block_name(kind, tile));
                Err(Error::input(self.path(), None, what, "build the archive with the layer that is asked for"))
            }
        }
    }

    /// All blocks of one kind, by tile; a bad one is an error in its place and the rest follow.
    pub fn scan(&self, kind: BlockKind) -> impl Iterator<Item = Result<Block>> + '_ {
        self.entries_of(kind).iter().map(|entry| self.fetch(entry))
    }

    /// Tells where the bytes are held that blocks will be read soon, in any order: from afar they come together. A hint, which costs nothing
    /// where bytes are at hand; blocks that do not exist are passed over.
    pub fn expect(&self, blocks: impl IntoIterator<Item = (BlockKind, TileNumber)>) {
        let found = blocks.into_iter().filter_map(|(kind, tile)| self.entry(kind, tile).copied());
        self.source.expect(&found.collect::<Vec<_>>());
    }

    /// The same for all blocks of a kind.
    pub fn expect_all(&self, kind: BlockKind) {
        self.source.expect(self.entries_of(kind));
    }

    /// A block as it is stored, for another archive: of any kind, packed in any way.
    pub fn copy(&self, entry: &Entry) -> Result<EncodedBlock> {
        let stored = self.source.read_block(entry)?;
        block::check_stored(self.path(), entry, &stored)?;
        Ok(EncodedBlock { entry: *entry, stored })
    }

    /// Reads, checks and decodes the block of a directory entry; one whose layout this release does not know is an error.
    pub fn fetch(&self, entry: &Entry) -> Result<Block> {
        let stored = self.source.read_block(entry)?;
        let block = block::decode(self.source.path(), entry, &stored)?;
        // A layout that this release does not know must not be read as the one it knows.
        if format::schema_of(entry.kind).is_some() { block.require(&[entry.kind]).map(|()| block) } else { Ok(block) }
    }

    /// The bytes that it is read from.
    pub(crate) fn source(&self) -> &Source {
        &self.source
    }

    /// Both header slots as they were when it was opened.
    pub fn header(&self) -> &Header {
        &self.header
    }
}

/// Whether the directory is in order and no entry points where it must not: section 4 step 7 of the format.
pub fn check_entries(path: &Path, entries: &[Entry], slot: &Slot) -> Result<()> {
    let wrong = |entry: &Entry, got: String, expected: String| Err(block::corrupt(path, entry, got, expected));
    for (entry, next) in entries.iter().zip(entries.iter().skip(1)) {
        if entry.key() >= next.key() {
            return wrong(next, format!("an entry after {}", entry.name()), "entries sorted by kind, tile".to_string());
        }
    }
    for entry in entries {
        let raw = usize::try_from(entry.raw).unwrap_or(usize::MAX);
        if raw == 0 || raw > MAX_RAW {
            return wrong(entry, format!("raw length {raw}"), format!("1 to {MAX_RAW}"));
        }
        if entry.stored == 0 || entry.stored > entry.raw || (entry.codec == CODEC_RAW && entry.stored != entry.raw) {
            return wrong(entry, format!("stored length {}", entry.stored), format!("1 to {raw}, {raw} if not packed"));
        }
        let inside = entry.offset >= FIRST_BLOCK && entry.end().is_some_and(|end| end <= slot.directory_offset);
        if !inside || entry.offset % ALIGNMENT != 0 {
            let expected = format!("a multiple of {ALIGNMENT} between {FIRST_BLOCK} and {}", slot.directory_offset);
            return wrong(entry, format!("{} bytes at {}", entry.stored, entry.offset), expected);
        }
    }
    let places = by_place(entries);
    for (entry, next) in places.iter().zip(places.iter().skip(1)) {
        let shared = (entry.offset, entry.stored, entry.content) == (next.offset, next.stored, next.content);
        if !shared && entry.end().is_none_or(|end| end > next.offset) {
            return wrong(next, format!("bytes shared with {}", entry.name()), "bytes of its own".to_string());
        }
    }
    Ok(())
}

/// Entries in the order of their places in the file.
pub fn by_place(entries: &[Entry]) -> Vec<&Entry> {
    let mut all: Vec<&Entry> = entries.iter().collect();
    all.sort_unstable_by_key(|entry| (entry.offset, entry.stored, entry.key()));
    all
}
