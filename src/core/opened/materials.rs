//! Materials and mirrors of a site. In: the tables of an archive. Out: the nouns of the scene,
//! checked against each other.

use glam::DVec3;

use crate::archive::format::TileNumber;
use crate::archive::{Blocks, format, tables};
use crate::error::Result;
use crate::site::bands::BandOptics;
use crate::site::chain::MirrorPlane;
use crate::site::material::{Glass, Material};

/// Reads the materials in the order of their table. Without a table of optics all are opaque and no
/// glass. Without a table of bands they have one value for all light.
pub(super) fn materials(blocks: &dyn Blocks) -> Result<Vec<Material>> {
    let block = blocks.block(format::MATERIALS, TileNumber::FIRST)?;
    let table = tables::MaterialsTable::from_block(&block)?;
    let (optics, bands) = (optics(blocks, table.rows())?, bands(blocks, table.rows())?);
    let group = |row: usize| Some(table.group[row].clone()).filter(|group| !group.is_empty());
    let material =
        |row: usize| {
            let material = Material {
                name: table.name[row].clone(),
                diffuse: table.diffuse[row],
                specular: table.specular[row],
                glass: optics.as_ref().and_then(|optics| Glass::of_panes(optics.panes[row])),
                transmittance: optics.as_ref().and_then(|o| (o.canopy[row] > 0).then(|| o.transmittance[row])),
                volume: optics.as_ref().is_some_and(|optics| optics.canopy[row] == tables::VOLUME),
                class: table.class_of(row),
                group: group(row),
                bands: bands.get(row).copied().unwrap_or_default(),
            };
            match material.check() {
                Ok(()) => Ok(material),
                Err(what) => Err(block
                    .corrupt(format!("material `{}`: {what}", material.name), "properties that a material can have")),
            }
        };
    (0..table.rows()).map(material).collect()
}

/// Reads the optics of `materials` materials beside diffuse reflection, if the archive has the
/// table.
fn optics(blocks: &dyn Blocks, materials: usize) -> Result<Option<tables::OpticsTable>> {
    if !blocks.has(format::OPTICS, TileNumber::FIRST) {
        return Ok(None);
    }
    let block = blocks.block(format::OPTICS, TileNumber::FIRST)?;
    let optics = tables::OpticsTable::from_block(&block)?;
    if optics.rows() != materials {
        return Err(block.corrupt(format!("{} rows", optics.rows()), format!("{materials}, one per material")));
    }
    Ok(Some(optics))
}

/// Reads the values of `materials` materials in bands of the light; empty if the archive has no
/// table.
fn bands(blocks: &dyn Blocks, materials: usize) -> Result<Vec<BandOptics>> {
    if !blocks.has(format::BANDS, TileNumber::FIRST) {
        return Ok(Vec::new());
    }
    let block = blocks.block(format::BANDS, TileNumber::FIRST)?;
    let bands = tables::BandsTable::from_block(&block)?.optics(materials);
    bands.ok_or_else(|| block.corrupt("an unknown material", "a row of the materials table"))
}

/// Reads the orientations of the mirrors and checks that their materials are among `materials`;
/// empty where the archive has no mirrors.
pub(super) fn orientations(blocks: &dyn Blocks, materials: usize) -> Result<Vec<MirrorPlane>> {
    if !blocks.has(format::MIRRORS, TileNumber::FIRST) {
        return Ok(Vec::new());
    }
    let block = blocks.block(format::MIRRORS, TileNumber::FIRST)?;
    let table = tables::MirrorsTable::from_block(&block)?;
    if table.material.iter().any(|&material| usize::from(material) >= materials) {
        return Err(block.corrupt("an unknown material", "a row of the materials table"));
    }
    let rows = table.normal.into_iter().zip(table.material);
    Ok(rows.map(|(normal, material)| MirrorPlane { normal: DVec3::from(normal), material }).collect())
}
