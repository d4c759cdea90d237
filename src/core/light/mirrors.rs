//! Chains of mirrors with what they reflect. In: orientations, materials and a chain, or the mirrors on a way. Out: where light from a
//! direction of the sky seems to come from, and how much of it is left.

use std::collections::HashMap;

use glam::{DMat3, DVec3};

use crate::layers::cells::Cells;
use crate::layers::extras::MIRROR;
use crate::light::fresnel::specular;
use crate::light::load::Tables;
use crate::light::reflector::Reflector;
use crate::site::chain::{Chain, Orientation, Step};

/// The mirrors of an archive: their orientations, and what materials reflect.
#[derive(Clone, Debug)]
pub struct MirrorTable {
    pub orientations: Vec<Orientation>,
    pub reflectors: Vec<Reflector>,
}

/// One chain.
#[derive(Clone, Debug)]
pub struct Reflection {
    /// From a direction of the sky to the one in which it is seen.
    map: DMat3,
    /// From the looker on.
    mirrors: Vec<(Orientation, Reflector)>,
}

impl Reflection {
    /// `None` if the chain names an orientation or a material that does not exist.
    pub fn new(chain: Chain, orientations: &[Orientation], reflectors: &[Reflector]) -> Option<Self> {
        let mirror = |number: u16| {
            let orientation = *orientations.get(usize::from(number))?;
            Some((orientation, *reflectors.get(usize::from(orientation.material))?))
        };
        let mirrors = chain.numbers().map(mirror).collect::<Option<_>>()?;
        Some(Reflection { map: chain.seen_from(orientations)?, mirrors })
    }

    /// The normal of the surface's image: light from direction s falls on the surface as if it came straight to the image.
    pub fn image(&self, normal: DVec3) -> DVec3 {
        self.map.transpose() * normal
    }

    /// Share of the light from a direction of the sky that is left.
    pub fn share(&self, sky: DVec3) -> f64 {
        let mut direction = sky;
        self.mirrors.iter().rev().fold(1.0, |share, (orientation, reflector)| {
            let cos = orientation.normal.dot(direction).abs();
            direction = orientation.reflect(direction);
            share * specular(reflector, cos)
        })
    }
}

/// Share of the light that is left after some mirrors.
pub fn left(steps: &[Step], reflectors: &[Reflector]) -> f64 {
    let of = |&(material, cosine): &Step| {
        reflectors.get(usize::from(material)).map_or(0.0, |r| specular(r, f64::from(cosine) / 255.0))
    };
    steps.iter().map(of).product()
}

/// Chains on the texels of the cells' sky.
#[derive(Clone, Debug, Default)]
pub struct Chains(HashMap<Chain, OnTexels>);

#[derive(Clone, Debug)]
struct OnTexels {
    reflection: Reflection,
    /// `[texel]`: share of the light that is left.
    shares: Vec<f32>,
}

impl Chains {
    /// The chains by which some cells see the sky, on texels with these centres; chains that do not exist are left out.
    pub fn of_cells(cells: &Cells, tables: &Tables, centres: &[[f32; 3]]) -> Self {
        let mut found = HashMap::new();
        for window in (0..cells.extras[MIRROR].len()).flat_map(|cell| cells.mirrors(cell).windows) {
            found.entry(window.chain).or_insert_with(|| {
                let reflection = Reflection::new(window.chain, &tables.orientations, &tables.reflectors)?;
                let share = |c: &[f32; 3]| reflection.share(DVec3::from(c.map(f64::from))) as f32;
                Some(OnTexels { shares: centres.iter().map(share).collect(), reflection })
            });
        }
        Chains(found.into_iter().filter_map(|(chain, on)| Some((chain, on?))).collect())
    }

    /// Normal of a surface's image by a chain, and the share that is left of light from each texel.
    pub fn image(&self, chain: &Chain, normal: [f32; 3]) -> Option<([f32; 3], &[f32])> {
        let on = self.0.get(chain)?;
        let image = on.reflection.image(DVec3::from(normal.map(f64::from)));
        Some((image.as_vec3().to_array(), &on.shares))
    }
}
