//! Chains of mirrors with their reflectances. In: orientations, materials and a chain, or the
//! mirrors on a path. Out: the mirrored direction of light from a direction of the sky, and the
//! share of it that is left.

use std::collections::HashMap;

use glam::{DMat3, DVec3};

use crate::error::Result;
use crate::layers::cells::Cells;
use crate::light::fresnel::specular;
use crate::light::reflector::Reflector;
use crate::opened::{CellSource, OpenSite};
use crate::site::chain::{Chain, MirrorPlane, MirrorStep};

/// The mirrors of an archive: their orientations, and the reflectances of materials.
#[derive(Clone, Debug)]
pub struct MirrorTable {
    /// `[number]`: the orientations that chains refer to.
    pub orientations: Vec<MirrorPlane>,
    /// `[material]`: reflectances.
    pub reflectors: Vec<Reflector>,
}

impl MirrorTable {
    /// Returns the mirrors of a site.
    pub fn new(site: &OpenSite) -> Self {
        MirrorTable {
            orientations: site.orientations().to_vec(),
            reflectors: site.materials().iter().map(Reflector::new).collect(),
        }
    }
}

/// One chain of mirrors with its reflectances.
#[derive(Clone, Debug)]
pub struct Reflection {
    /// Map from a direction of the sky to the direction in which it is seen.
    map: DMat3,
    /// Mirrors in the order from the observer on.
    mirrors: Vec<(MirrorPlane, Reflector)>,
}

impl Reflection {
    /// Returns the reflection of a chain, or `None` if it names an orientation or a material that
    /// does not exist.
    pub fn new(chain: Chain, table: &MirrorTable) -> Option<Self> {
        let mirror = |number: u16| {
            let orientation = *table.orientations.get(usize::from(number))?;
            Some((orientation, *table.reflectors.get(usize::from(orientation.material))?))
        };
        let mirrors = chain.numbers().map(mirror).collect::<Option<_>>()?;
        Some(Reflection { map: chain.seen_from(&table.orientations)?, mirrors })
    }

    /// Returns the normal of the surface's image: light from direction s falls on the surface as if
    /// it came straight to the image.
    pub fn image(&self, normal: DVec3) -> DVec3 {
        self.map.transpose() * normal
    }

    /// Returns the direction in which light from a direction of the sky is seen.
    pub fn mirrored(&self, sky: DVec3) -> DVec3 {
        self.map * sky
    }

    /// Returns the direction of the sky that light seen in a direction comes from.
    pub fn unmirrored(&self, seen: DVec3) -> DVec3 {
        // Reflections are orthogonal, so the transpose is the inverse.
        self.map.transpose() * seen
    }

    /// Returns the share of the light from a direction of the sky that is left after all mirrors.
    pub fn share(&self, sky: DVec3) -> f64 {
        let mut direction = sky;
        self.mirrors.iter().rev().fold(1.0, |share, (orientation, reflector)| {
            let cos = orientation.normal.dot(direction).abs();
            direction = orientation.reflect(direction);
            share * specular(reflector, cos)
        })
    }
}

/// Returns the share of the light that is left after some mirrors. Their materials must exist.
pub fn left(steps: &[MirrorStep], reflectors: &[Reflector]) -> f64 {
    let of = |&(material, cosine): &MirrorStep| specular(&reflectors[usize::from(material)], f64::from(cosine) / 255.0);
    steps.iter().map(of).product()
}

/// The chains of mirrors by which some cells see the sky.
#[derive(Clone, Debug, Default)]
pub struct Chains {
    /// Each distinct chain once.
    all: Vec<OnTexels>,
    /// `[cell][window]`: index of its chain; empty where a cell sees nothing in mirrors.
    of_cells: Vec<Vec<usize>>,
}

/// A chain with its reflectances on the texels of the cells' sky.
#[derive(Clone, Debug)]
struct OnTexels {
    reflection: Reflection,
    /// `[texel]`: share of the light that is left.
    shares: Vec<f32>,
}

/// Part of the sky that a cell sees by one chain.
pub struct Lookout<'c> {
    /// Normal of the cell's image.
    pub image: [f32; 3],
    /// `[texel]`: share that is left of light from that texel.
    pub shares: &'c [f32],
    /// The texels that are seen.
    pub texels: &'c [u16],
}

impl Chains {
    /// Returns the chains of some cells of a source, on texels with these centres. A chain that
    /// names a missing mirror is a defect.
    pub fn of_cells(cells: &Cells, source: &CellSource, table: &MirrorTable, centres: &[[f32; 3]]) -> Result<Self> {
        let mut numbers: HashMap<Chain, usize> = HashMap::new();
        let mut chains = Chains::default();
        for (mirrors, key) in cells.mirrors.iter().zip(&cells.keys) {
            let mut of_cell = Vec::with_capacity(mirrors.windows.len());
            for window in &mirrors.windows {
                let next = chains.all.len();
                let number = *numbers.entry(window.chain).or_insert(next);
                if number == next {
                    let no_mirror = || source.defect(key, "chains", "name a mirror that does not exist");
                    let reflection = Reflection::new(window.chain, table).ok_or_else(no_mirror)?;
                    let share = |c: &[f32; 3]| reflection.share(DVec3::from(c.map(f64::from))) as f32;
                    chains.all.push(OnTexels { shares: centres.iter().map(share).collect(), reflection });
                }
                of_cell.push(number);
            }
            chains.of_cells.push(of_cell);
        }
        Ok(chains)
    }

    /// Iterates over the parts of the sky that cell `i` of the cells given to [`Chains::of_cells`]
    /// sees, one by chain.
    pub fn lookouts<'c>(&'c self, cells: &'c Cells, i: usize) -> impl Iterator<Item = Lookout<'c>> {
        let numbers = self.of_cells.get(i).map_or(&[][..], Vec::as_slice);
        let windows = cells.mirrors_of(i).map_or(&[][..], |mirrors| &mirrors.windows);
        let normal = DVec3::from(cells.normals[i].map(f64::from));
        numbers.iter().zip(windows).map(move |(&number, window)| {
            let OnTexels { reflection, shares } = &self.all[number];
            let image = reflection.image(normal).as_vec3().to_array();
            Lookout { image, shares, texels: &window.texels }
        })
    }
}
