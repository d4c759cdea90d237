//! Canopies at replay. In: canopy layers of an archive, transmittances by material. Out: the share of light that comes through along
//! each ray. What does not come through is absorbed: leaves reflect and scatter nothing.

use crate::archive::manifest::Settings;
use crate::archive::{Block, Blocks, format};
use crate::error::Result;
use crate::layers::canopy::{Canopy, Powers, SEEN, SKY, sky_side};
use crate::layers::cells::Cells;
use crate::layers::extras;
use crate::layers::extras::CANOPY;
use crate::light::load::optics;
use crate::light::reflector::{Reflectance, Reflector};
use crate::weather::bins::Bins;

/// The transmittances that some states have, each set of them once.
#[derive(Clone, Debug, Default)]
pub struct Leafages {
    /// `[leafage]`
    pub powers: Vec<Powers>,
    /// `[state]`: its leafage.
    of_state: Vec<usize>,
}

impl Leafages {
    /// Takes the transmittances out of states that hold a value by material ([`Reflector::variable`]), and leaves reflectances: 0 of
    /// canopies. Without canopies all states have one leafage.
    pub fn split(reflectors: &[Reflector], states: &mut [Vec<f64>]) -> Self {
        let canopies: Vec<usize> = (0..reflectors.len()).filter(|&m| reflectors[m].transmittance.is_some()).collect();
        let mut known: Vec<Vec<f64>> = Vec::new();
        let mut leafages = Leafages::default();
        for state in states {
            let state: &mut Reflectance = state;
            let values: Vec<f64> = canopies.iter().map(|&m| std::mem::take(&mut state[m])).collect();
            let leafage = known.iter().position(|other| *other == values).unwrap_or(known.len());
            if leafage == known.len() {
                let of_material = |(&m, &tau): (&usize, &f64)| (m as u16, powers(tau));
                leafages.powers.push(canopies.iter().zip(&values).map(of_material).collect());
                known.push(values);
            }
            leafages.of_state.push(leafage);
        }
        leafages
    }

    /// How conditions add to the results with each leafage, of how they do in each state.
    pub fn ways(&self, states: &[Bins]) -> Vec<(Powers, Bins)> {
        let way = |(leafage, powers): (usize, &Powers)| {
            let mut of_leafage = self.states(leafage).filter_map(|state| states.get(state));
            let mut sum = of_leafage.next()?.clone();
            for bins in of_leafage {
                let weights = sum.of_condition.iter_mut().zip(&bins.of_condition);
                weights.for_each(|(sum, (_, weight))| sum.1 += weight);
            }
            Some((powers.clone(), sum))
        };
        self.powers.iter().enumerate().filter_map(way).collect()
    }

    /// States of a leafage.
    pub fn states(&self, leafage: usize) -> impl Iterator<Item = usize> + '_ {
        (0..self.of_state.len()).filter(move |&state| self.of_state[state] == leafage)
    }
}

/// Beer and Lambert: what k crossings of a transmittance leave.
fn powers(tau: f64) -> [f32; 256] {
    std::array::from_fn(|k| tau.powi(k as i32) as f32)
}

/// Shares of the light that come through to a cell.
#[derive(Clone, Debug, Default)]
pub struct Shade {
    /// `[texel of its sky]`; `None` where nothing is crossed.
    pub sky: Option<Vec<f32>>,
    /// `[ray]` to what it sees, likewise.
    pub seen: Option<Vec<f32>>,
}

impl Shade {
    /// Of cell `i` of a table with so many texels a side.
    pub fn of(cells: &Cells, i: usize, side: usize, powers: &Powers) -> Self {
        let (bytes, rays) = (cells.extra(CANOPY, i), [side * side, cells.hits_of(i).len()]);
        if bytes.is_empty() {
            return Shade::default();
        }
        // They were checked when they were read.
        let canopy = Canopy::from_bytes(bytes, rays, |_| true).unwrap_or_default();
        Shade { sky: canopy.through(SKY, rays[SKY], powers), seen: canopy.through(SEEN, rays[SEEN], powers) }
    }
}

/// Refuses bytes of a chunk that are no crossings of cells with so many texels and rays, or are of unknown materials.
pub fn check_cells(block: &Block, cells: &Cells, rays: [usize; 2], materials: usize) -> Result<()> {
    let known = |material| usize::from(material) < materials;
    match cells.extras[CANOPY].iter().all(|row| Canopy::from_bytes(row, rays, known).is_some()) {
        true => Ok(()),
        false => Err(block.corrupt("crossings of another shape", "those of the settings' textures and rays")),
    }
}

/// What the rays of a tile's receivers cross; empty where none crosses anything.
pub fn tile_canopies(blocks: &dyn Blocks, settings: &Settings, tile: u32, rows: usize) -> Result<Vec<Canopy>> {
    if !blocks.has(format::CANOPY, tile) {
        return Ok(Vec::new());
    }
    let block = blocks.block(format::CANOPY, tile)?;
    let materials = blocks.block(format::MATERIALS, 0)?.items() as usize;
    let canopies = optics(blocks, materials)?.map(|optics| optics.canopy).unwrap_or_default();
    let is_canopy = |material: u16| canopies.get(usize::from(material)) == Some(&1);
    let rays = receiver_rays(settings);
    let row = |bytes: &Vec<u8>| Canopy::from_bytes(bytes, rays, is_canopy);
    let found: Option<Vec<Canopy>> =
        extras::unpack(block.bytes(), rows).and_then(|bytes| bytes.iter().map(row).collect());
    found.ok_or_else(|| block.corrupt("crossings of another shape", "those of the settings' textures, of canopies"))
}

/// Shares that come through by the transmittances that an archive states; none if it has no canopies.
pub fn stored(blocks: &dyn Blocks) -> Result<Powers> {
    if !blocks.has(format::OPTICS, 0) {
        return Ok(Powers::new());
    }
    let materials = blocks.block(format::MATERIALS, 0)?.items() as usize;
    let Some(optics) = optics(blocks, materials)? else { return Ok(Powers::new()) };
    let rows = (0..=u16::MAX).zip(optics.canopy.iter().zip(&optics.transmittance));
    Ok(rows.filter(|(_, (canopy, _))| **canopy == 1).map(|(m, (_, tau))| (m, powers(*tau))).collect())
}

/// Rays of both lists of a receiver.
pub fn receiver_rays(settings: &Settings) -> [usize; 2] {
    let side = sky_side(settings.sky_base as usize, settings.sky_fine as usize);
    [side * side, (settings.hit * settings.hit) as usize]
}
