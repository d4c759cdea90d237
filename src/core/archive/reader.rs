//! Reading of an archive. In: a path, or bytes from any source. Out: checked blocks by (kind,
//! tile), each copied out before it is decoded.

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
use crate::error::{Error, Problem, Result};

/// An open archive whose header, directory and manifest were checked. Many threads may read from
/// it.
#[derive(Debug)]
pub struct Archive {
    source: Source,
    header: Header,
    entries: Vec<Entry>,
    manifest: Manifest,
}

impl Archive {
    /// Opens a finished archive of a file system through a mapping. It is an error if the file is
    /// no archive, was not finished or has another format, or if its header, directory or manifest
    /// is damaged.
    #[cfg(any(unix, windows))]
    pub fn open(path: &Path) -> Result<Self> {
        Archive::open_with(path, Access::default())
    }

    /// Opens a finished archive of a file system, read as `access` says; errors as in
    /// `Archive::open`.
    #[cfg(any(unix, windows))]
    pub fn open_with(path: &Path, access: Access) -> Result<Self> {
        Archive::read(Source::open(path, access)?)
    }

    /// Opens a finished archive whose bytes come from any source, without a file system. Messages
    /// call it `name`. Errors as in `Archive::open`.
    pub fn new(name: impl AsRef<Path>, bytes: impl ReadAt + 'static) -> Result<Self> {
        Archive::read(Source::new(name.as_ref(), Box::new(bytes)))
    }

    /// Checks header, directory and manifest. Blocks are checked when they are read.
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

    /// Returns the file's path, or the name that was given with the bytes.
    pub fn path(&self) -> &Path {
        self.source.path()
    }

    /// Returns the number of bytes of the whole archive, as stored.
    pub fn length(&self) -> u64 {
        self.source.length()
    }

    /// Returns the manifest, read when the archive was opened.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Returns the hash of directory and manifest, which identifies the content of the whole
    /// archive.
    pub fn root(&self) -> [u8; 32] {
        self.header.slot.root
    }

    /// Returns the directory, sorted by (kind, tile), with blocks of unknown kinds.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Returns the directory entries of one kind, by tile.
    pub fn entries_of(&self, kind: BlockKind) -> &[Entry] {
        let start = self.entries.partition_point(|entry| entry.kind < kind);
        let end = self.entries.partition_point(|entry| entry.kind <= kind);
        self.entries.get(start..end).unwrap_or(&[])
    }

    /// Returns the number of receiver tiles; they are numbered from 0.
    pub fn tiles(&self) -> u32 {
        self.manifest.receivers.tiles
    }

    /// Returns the directory entry of a block.
    pub fn entry(&self, kind: BlockKind, tile: TileNumber) -> Option<&Entry> {
        let row = self.entries.binary_search_by_key(&(kind, tile), Entry::key).ok()?;
        self.entries.get(row)
    }

    /// Returns true if the archive holds a block.
    pub fn has(&self, kind: BlockKind, tile: TileNumber) -> bool {
        self.entry(kind, tile).is_some()
    }

    /// Returns a block, checked and decoded; it is an error if the block is damaged or missing.
    pub fn block(&self, kind: BlockKind, tile: TileNumber) -> Result<Block> {
        match self.entry(kind, tile) {
            Some(entry) => self.fetch(entry),
            None if self.manifest.replay_only && format::REFLECTING.contains(&kind) => {
                let what = "is for replay only, without hits and cells: it cannot answer for changed reflectances, a \
                            number of bounces, bands, longwave, comfort, maps of what a receiver sees or EnergyPlus, \
                            and cannot be merged or compared block by block";
                let hint = "use the archive that it was taken from, or build it again";
                Err(Error::input(self.path(), None, what, hint).because(Problem::Lacks("hits and cells")))
            }
            None => {
                let what = format!("holds no block {}", format::block_name(kind, tile));
                Err(Error::input(self.path(), None, what, "build the archive again with this layer"))
            }
        }
    }

    /// Iterates over all blocks of one kind, by tile. A damaged block is an error in its place, and
    /// the rest follow.
    pub fn scan(&self, kind: BlockKind) -> impl Iterator<Item = Result<Block>> + '_ {
        self.entries_of(kind).iter().map(|entry| self.fetch(entry))
    }

    /// Announces blocks that will be read soon, in any order, so that a remote fetches them
    /// together. It is a hint and costs nothing where the bytes are local. Blocks that do not exist
    /// are ignored.
    pub fn expect(&self, blocks: impl IntoIterator<Item = (BlockKind, TileNumber)>) {
        let found = blocks.into_iter().filter_map(|(kind, tile)| self.entry(kind, tile).copied());
        self.source.expect(&found.collect::<Vec<_>>());
    }

    /// Announces that all blocks of a kind will be read soon.
    pub fn expect_all(&self, kind: BlockKind) {
        self.source.expect(self.entries_of(kind));
    }

    /// Returns a block as it is stored, for another archive: of any kind and codec.
    pub fn copy(&self, entry: &Entry) -> Result<EncodedBlock> {
        let stored = self.source.read_block(entry)?;
        block::check_stored(self.path(), entry, &stored)?;
        Ok(EncodedBlock { entry: *entry, stored })
    }

    /// Reads, checks and decodes the block of a directory entry. A layout of a known kind that this
    /// release does not know is an error.
    pub fn fetch(&self, entry: &Entry) -> Result<Block> {
        let stored = self.source.read_block(entry)?;
        let block = block::decode(self.source.path(), entry, &stored)?;
        // An unknown layout must not be read as the known one.
        if format::schema_of(entry.kind).is_some() { block.require(&[entry.kind]).map(|()| block) } else { Ok(block) }
    }

    /// Returns the source of the bytes.
    pub(crate) fn source(&self) -> &Source {
        &self.source
    }

    /// Returns the header as it was when the archive was opened.
    pub fn header(&self) -> &Header {
        &self.header
    }
}

/// Checks that the directory is in order and no entry points outside the blocks or into another
/// one: section 4 step 7 of the format.
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
    // Blocks of equal content may share their bytes; any other overlap is damage.
    let places = by_place(entries);
    for (entry, next) in places.iter().zip(places.iter().skip(1)) {
        let shared = (entry.offset, entry.stored, entry.content) == (next.offset, next.stored, next.content);
        if !shared && entry.end().is_none_or(|end| end > next.offset) {
            return wrong(next, format!("bytes shared with {}", entry.name()), "bytes of its own".to_string());
        }
    }
    Ok(())
}

/// Returns the entries sorted by their places in the file.
pub fn by_place(entries: &[Entry]) -> Vec<&Entry> {
    let mut all: Vec<&Entry> = entries.iter().collect();
    all.sort_unstable_by_key(|entry| (entry.offset, entry.stored, entry.key()));
    all
}
