//! A site that was opened. In: blocks and a manifest. Out: the facts that all of its layers depend
//! on, checked once.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use crate::archive::format::{BlockKind, TileNumber};
use crate::archive::manifest::{Manifest, ReceiverSummary, Settings};
use crate::archive::{Archive, Block, Blocks, format};
use crate::error::{Error, Result};
use crate::opened::materials;
use crate::opened::settings::SiteSettings;
use crate::site::bands::Band;
use crate::site::chain::MirrorPlane;
use crate::site::material::{Class, Material};
use crate::site::north::North;

/// Facts about a site besides its blocks, with every number in range and every reference followed.
#[derive(Clone, Debug, PartialEq)]
pub struct SiteFacts {
    settings: SiteSettings,
    materials: Vec<Material>,
    /// True if the materials are those that the responses of the blocks were derived for.
    as_stored: bool,
    replay_only: bool,
    orientations: Vec<MirrorPlane>,
    north: North,
    receivers: u64,
    tiles: u32,
}

impl SiteFacts {
    /// Returns the facts of a scene with its own materials and mirrors: for an archive that is
    /// being written, or whose tables may be damaged. Errors name `path` where a number is out of
    /// range.
    pub fn given(
        path: &Path,
        stated: &Settings,
        origin: DVec3,
        receivers: &ReceiverSummary,
        materials: Vec<Material>,
        orientations: Vec<MirrorPlane>,
    ) -> Result<Self> {
        if !origin.is_finite() {
            let what = format!("{}: origin of the scene in the manifest", path.display());
            return Err(Error::Unsupported {
                what: what.into(),
                found: origin.to_string(),
                supported: "finite metres".into(),
            });
        }
        let settings = SiteSettings::new(stated, path)?;
        let (receivers, tiles) = (receivers.count, receivers.tiles);
        let north = North::default();
        Ok(SiteFacts {
            settings,
            materials,
            as_stored: true,
            replay_only: false,
            orientations,
            north,
            receivers,
            tiles,
        })
    }

    /// Returns the materials; the numbers in cell keys are their indices.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// Returns the orientations of mirrors; the numbers in chains are their indices.
    pub fn orientations(&self) -> &[MirrorPlane] {
        &self.orientations
    }
}

/// Blocks whose common facts were checked. It is cheap to copy, and many threads may read from it.
#[derive(Clone)]
pub struct OpenSite<'a> {
    blocks: &'a dyn Blocks,
    facts: Arc<SiteFacts>,
}

impl<'a> OpenSite<'a> {
    /// Opens the site of an archive. It is an error if settings are out of range, or if tables of
    /// materials or mirrors are damaged or refer to missing rows.
    pub fn open(archive: &'a Archive) -> Result<Self> {
        OpenSite::new(archive, archive.manifest())
    }

    /// Opens the site of blocks that a manifest describes; errors as in [`OpenSite::open`].
    pub fn new(blocks: &'a dyn Blocks, manifest: &Manifest) -> Result<Self> {
        let (origin, path) = (DVec3::from(manifest.scene.origin_m), blocks.path());
        // Settings come first: an error in the manifest concerns all blocks.
        SiteSettings::new(&manifest.settings, path)?;
        let materials = materials::materials(blocks)?;
        let orientations = materials::orientations(blocks, materials.len())?;
        let kinds: BTreeSet<BlockKind> = manifest.layers.iter().map(|layer| layer.kind).collect();
        let in_mirrors = [format::MIRROR, format::PROBE_MIRROR, format::BOUNCE_MIRROR];
        if let Some(kind) = in_mirrors.into_iter().find(|kind| orientations.is_empty() && kinds.contains(kind)) {
            let (block, what) =
                (format::kind_name(kind), "the chains name mirrors, but the archive has no table of mirrors");
            return Err(Error::defect(path, block, "chains", what));
        }
        let mut facts =
            SiteFacts::given(path, &manifest.settings, origin, &manifest.receivers, materials, orientations)?;
        (facts.north, facts.replay_only) = (North::new(manifest.place.as_ref()), manifest.replay_only);
        Ok(OpenSite { blocks, facts: Arc::new(facts) })
    }

    /// Returns a site whose facts are known, for blocks that have grown since or whose tables may
    /// be damaged.
    pub fn over(blocks: &'a dyn Blocks, facts: Arc<SiteFacts>) -> Self {
        OpenSite { blocks, facts }
    }

    /// Returns the site with y for true north, without the direction that its place gives.
    pub fn with_y_for_north(mut self) -> Self {
        Arc::make_mut(&mut self.facts).north = North::default();
        self
    }

    /// Returns the site with the values that its materials have in `band`.
    #[must_use]
    pub fn in_band(&self, band: Band) -> Self {
        let materials: Vec<Material> = self.materials().iter().map(|material| material.in_band(band)).collect();
        let alike = |(new, old): (&Material, &Material)| Material { bands: old.bands, ..new.clone() } == *old;
        if materials.iter().zip(self.materials()).all(alike) {
            return self.clone();
        }
        let mut site = self.clone();
        let facts = Arc::make_mut(&mut site.facts);
        (facts.materials, facts.as_stored) = (materials, false);
        site
    }

    /// Returns true if the materials are those that the stored responses were derived for.
    pub fn is_as_stored(&self) -> bool {
        self.facts.as_stored
    }

    /// Returns the site as an archive for replay only has it: its hits and cells are not read.
    #[must_use]
    pub fn for_replay_only(mut self) -> Self {
        Arc::make_mut(&mut self.facts).replay_only = true;
        self
    }

    /// Returns true if the blocks hold no hits and cells: reflected light cannot be derived.
    pub fn is_replay_only(&self) -> bool {
        self.facts.replay_only
    }

    /// Returns the direction of true north, by which replay turns suns.
    pub fn north(&self) -> North {
        self.facts.north
    }

    /// Returns the file, for messages.
    pub fn path(&self) -> &'a Path {
        self.blocks.path()
    }

    /// Returns the settings, all in range: sides of textures, rays of cells, the closed level.
    pub fn settings(&self) -> &SiteSettings {
        &self.facts.settings
    }

    /// Returns the materials; the numbers in cell keys are their indices.
    pub fn materials(&self) -> &[Material] {
        &self.facts.materials
    }

    /// Returns the orientations of mirrors; the numbers in chains are their indices.
    pub fn orientations(&self) -> &[MirrorPlane] {
        &self.facts.orientations
    }

    /// Returns the number of receivers in all tiles.
    pub fn receivers(&self) -> u64 {
        self.facts.receivers
    }

    /// Returns the number of tiles; they have the numbers from 0 up to it.
    pub fn tiles(&self) -> u32 {
        self.facts.tiles
    }

    /// Returns true if a material has this number.
    pub(super) fn has_material(&self, number: u16) -> bool {
        usize::from(number) < self.facts.materials.len()
    }

    /// Returns the numbers of the opaque materials of class ground, which a ground reflectance
    /// applies to.
    pub fn grounds(&self) -> Vec<usize> {
        let reflects = |material: &Material| material.class == Class::Ground && material.transmittance.is_none();
        let numbered = self.materials().iter().enumerate();
        numbered.filter(|(_, material)| reflects(material)).map(|(number, _)| number).collect()
    }

    /// Returns true if a material has this number and lets light through.
    pub(crate) fn is_canopy(&self, number: u16) -> bool {
        self.facts.materials.get(usize::from(number)).is_some_and(|material| material.transmittance.is_some())
    }

    pub(super) fn blocks(&self) -> &'a dyn Blocks {
        self.blocks
    }

    pub(super) fn has(&self, kind: BlockKind, tile: TileNumber) -> bool {
        self.blocks.has(kind, tile)
    }

    /// Returns the number of receivers of a tile, by the directory; 0 if there is no such tile.
    pub fn tile_rows(&self, tile: u32) -> usize {
        self.blocks.rows(format::RECEIVERS, TileNumber(tile)).unwrap_or(0) as usize
    }

    /// Announces layers of some tiles that will be read soon: a remote then fetches them together.
    /// Kinds that a tile does not have are skipped.
    pub fn expect(&self, kinds: &[BlockKind], tiles: impl IntoIterator<Item = u32>) {
        let numbers = tiles.into_iter().map(TileNumber);
        let blocks: Vec<_> = numbers.flat_map(|tile| kinds.iter().map(move |&kind| (kind, tile))).collect();
        self.blocks.expect(&blocks);
    }

    /// Returns a block, checked and decoded; it is an error if the block is damaged or missing.
    pub fn block(&self, kind: BlockKind, tile: TileNumber) -> Result<Block> {
        self.blocks.block(kind, tile)
    }
}
