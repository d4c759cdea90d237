//! The manifest of a build: where the archive comes from and what is in it.

use std::collections::BTreeMap;

use super::{COMPRESSION, Job, Rays, Share};
use crate::archive::manifest::{self, Creator, Manifest, ReceiverSummary, SceneSummary, Settings};
use crate::archive::{EncodedBlock, format, tables};
use crate::error::Result;
use crate::scene::materials::Class;
use crate::scene::receivers::TILE;

/// What a build counted.
#[derive(Clone, Copy, Debug)]
pub struct Counts {
    pub receivers: usize,
    pub tiles: usize,
    pub probes: usize,
    pub bounce_cells: usize,
    pub rays: Rays,
}

impl Job<'_> {
    pub(super) fn materials_block(&self) -> Result<EncodedBlock> {
        let materials = &self.scene.materials;
        let table = tables::Materials {
            name: materials.iter().map(|m| m.name.clone()).collect(),
            diffuse: materials.iter().map(|m| m.diffuse).collect(),
            specular: materials.iter().map(|m| m.specular).collect(),
            class: materials.iter().map(|m| u8::from(m.class == Class::Ground)).collect(),
            group: materials.iter().map(|m| m.group.clone().unwrap_or_default()).collect(),
        };
        table.encode(0, COMPRESSION)
    }

    pub(super) fn manifest(&self, counts: &Counts, layers: Vec<manifest::LayerSummary>) -> Manifest {
        let (mesh, s) = (&self.scene.mesh, self.settings);
        let (low, high) = mesh.bounds();
        let rays = [("sky", counts.rays.sky), ("hit", counts.rays.hit)]
            .into_iter()
            .chain([("probe", counts.rays.probe), ("bounce", counts.rays.bounce)])
            .map(|(name, count)| (name.to_string(), count))
            .collect::<BTreeMap<String, u64>>();
        Manifest {
            format: "heliotile".into(),
            creator: Creator { name: "heliotile".into(), version: env!("CARGO_PKG_VERSION").into() },
            experimental: true,
            scene: SceneSummary {
                content_hash: format::hex(&self.scene.content_hash()),
                triangles: mesh.triangles.len() as u64,
                vertices: mesh.vertices.len() as u64,
                materials: self.scene.materials.len() as u64,
                degenerate_dropped: self.scene.report.degenerate_dropped as u64,
                origin_m: mesh.origin.to_array(),
                bounds_m: [(mesh.origin + low).to_array(), (mesh.origin + high).to_array()],
                ..SceneSummary::default()
            },
            receivers: ReceiverSummary {
                count: counts.receivers as u64,
                tile_size: TILE as u32,
                tiles: counts.tiles as u32,
                ..ReceiverSummary::default()
            },
            settings: Settings {
                quality: String::new(),
                sky_base: s.sky_base as u32,
                sky_fine: s.sky_fine as u32,
                hit: s.hit as u32,
                cell_factor: s.cell_factor,
                cell_floor_m: s.cell_floor_m,
                probe: s.probe as u32,
                probe_hits: s.probe_hits as u32,
                closed_m: s.closed_m,
                bounce_sky: s.bounce_sky as u32,
                bounce_hits: s.bounce_hits as u32,
                share: if s.share == Share::None { "none" } else { "cells" }.into(),
                bounces: "all".into(),
                ..Settings::default()
            },
            counts: manifest::Counts { probes: counts.probes as u64, bounce_cells: counts.bounce_cells as u64, rays },
            layers,
            ..Manifest::default()
        }
    }
}
