//! Manifest of a build, with the tables of materials. In: counts, a plan, layers. Out: the
//! manifest, blocks of tables.

use super::plan::Plan;
use super::site_tracer::SiteTracer;
use heliotile_archives::pack::COMPRESSION;
use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::manifest;
use heliotile_core::archive::manifest::{Creator, Manifest, ReceiverSummary, SceneSummary};
use heliotile_core::archive::{EncodedBlock, format, tables};
use heliotile_core::error::Result;
use heliotile_core::site::material::Glass;
use heliotile_core::site::receiver::TILE;

/// Numbers of receivers and cells of a build.
#[derive(Clone, Copy, Debug)]
pub struct BuildCounts {
    /// Number of receivers.
    pub receivers: u64,
    /// Number of their tiles.
    pub tiles: u32,
    /// Number of cells that receivers see.
    pub probes: u64,
    /// Number of coarser cells that probes and other coarse cells see.
    pub bounce_cells: u64,
}

impl SiteTracer<'_> {
    pub(super) fn materials_block(&self) -> Result<EncodedBlock> {
        let materials = &self.scene.materials;
        let table = tables::MaterialsTable {
            name: materials.iter().map(|m| m.name.clone()).collect(),
            diffuse: materials.iter().map(|m| m.diffuse).collect(),
            specular: materials.iter().map(|m| m.specular).collect(),
            class: materials.iter().map(|m| m.class.code()).collect(),
            group: materials.iter().map(|m| m.group.clone().unwrap_or_default()).collect(),
        };
        table.encode(format::MATERIALS, TileNumber::FIRST, COMPRESSION)
    }

    /// Encodes the optics of materials other than diffuse reflection, the orientations of mirrors,
    /// and reflectances by band; no blocks if no material needs them.
    pub(super) fn optics_blocks(&self) -> Result<Vec<EncodedBlock>> {
        let materials = &self.scene.materials;
        let bands = tables::BandsTable::new(materials.iter().map(|m| &m.bands));
        let bands = bands.map(|table| table.encode(format::BANDS, TileNumber::FIRST, COMPRESSION)).transpose()?;
        if !materials.iter().any(|m| m.mirrors() || m.transmittance.is_some()) {
            return Ok(bands.into_iter().collect());
        }
        let table = tables::OpticsTable {
            panes: materials.iter().map(|m| m.glass.map_or(0, Glass::panes)).collect(),
            canopy: materials.iter().map(tables::kind_of_canopy).collect(),
            transmittance: materials.iter().map(|m| m.transmittance.unwrap_or(0.0)).collect(),
        };
        let mut blocks = vec![table.encode(format::OPTICS, TileNumber::FIRST, COMPRESSION)?];
        if let Some(reflections) = &self.reflections {
            let orientations = reflections.orientations();
            let table = tables::MirrorsTable {
                normal: orientations.iter().map(|o| o.normal.to_array()).collect(),
                material: orientations.iter().map(|o| o.material).collect(),
            };
            blocks.push(table.encode(format::MIRRORS, TileNumber::FIRST, COMPRESSION)?);
        }
        blocks.extend(bands);
        Ok(blocks)
    }

    pub(super) fn manifest(&self, counts: &BuildCounts, plan: &Plan, layers: Vec<manifest::LayerSummary>) -> Manifest {
        let mesh = &self.scene.mesh;
        let (low, high) = mesh.bounds();
        Manifest {
            format: "heliotile".into(),
            creator: Creator { name: "heliotile".into(), version: env!("CARGO_PKG_VERSION").into() },
            scene: SceneSummary {
                content_hash: format::hex(&self.scene.content_hash()),
                triangles: mesh.triangles.len() as u64,
                vertices: mesh.vertices.len() as u64,
                materials: self.scene.materials.len() as u64,
                degenerate_dropped: self.scene.report.degenerate_dropped as u64,
                origin_m: mesh.origin.to_array(),
                grid_step_m: mesh.step_m,
                bounds_m: [(mesh.origin + low).to_array(), (mesh.origin + high).to_array()],
                ..SceneSummary::default()
            },
            receivers: ReceiverSummary {
                count: counts.receivers,
                tile_size: TILE as u32,
                tiles: counts.tiles,
                ..ReceiverSummary::default()
            },
            settings: self.settings.stated(),
            accuracy: plan.accuracy.clone(),
            negligible: plan.negligible.clone(),
            place: self.scene.place,
            ground: self.scene.ground.clone(),
            counts: manifest::CellCounts { probes: counts.probes, bounce_cells: counts.bounce_cells },
            layers,
            ..Manifest::default()
        }
    }
}
