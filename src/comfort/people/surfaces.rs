//! Materials that planes see. In: the materials of a site, the hits of a tile. Out: emissivity and
//! absorptance of ground and of obstructions, as means over the part of them that each plane sees.

use glam::DVec2;

use crate::surroundings::{SeenSurfaces, SurfaceMean, USUAL_GROUND_EMISSIVITY, USUAL_OBSTRUCTION_EMISSIVITY};
use heliotile_core::error::Result;
use heliotile_core::hemisphere::texel_direction;
use heliotile_core::opened::OpenSite;
use heliotile_core::site::material::{Class, Material};

impl SurfaceMean {
    /// Returns the values of a material: the emissivity that it states, else the usual one of its
    /// class. It absorbs the light that it does not reflect.
    pub fn of_material(material: &Material) -> Self {
        let emissivity = material.bands.emissivity.unwrap_or_else(|| usual_emissivity(material.class));
        let absorptance = (1.0 - material.diffuse - material.specular).clamp(0.0, 1.0);
        SurfaceMean { emissivity, absorptance }
    }

    /// Returns the mean over the materials of a class, each counted once. A class without materials
    /// is not seen.
    pub fn of_class(class: Class, materials: &[Material]) -> Self {
        let unseen = SurfaceMean { emissivity: usual_emissivity(class), absorptance: 1.0 };
        SurfaceMean::new(SurfaceMean::of_solids(class, materials).map(|mean| (1.0, Some(mean)))).unwrap_or(unseen)
    }

    /// Iterates over the values of the materials of a class that are surfaces. Leaves and screens
    /// are left out, because they are as warm as the air.
    pub fn of_solids(class: Class, materials: &[Material]) -> impl Iterator<Item = SurfaceMean> {
        let of_class = move |material: &&Material| material.class == class && material.transmittance.is_none();
        materials.iter().filter(of_class).map(SurfaceMean::of_material)
    }
}

/// Returns the surfaces that the receivers of a tile see; `None` for a class whose materials are
/// equal. Hits are read only if some differ.
pub fn seen_surfaces(site: &OpenSite, tile: u32, receivers: usize) -> Result<Vec<SeenSurfaces>> {
    let materials = site.materials();
    let differ = Class::ALL.map(|class| {
        let mut means = SurfaceMean::of_solids(class, materials);
        let first = means.next();
        means.any(|mean| Some(mean) != first)
    });
    if differ == [false; Class::ALL.len()] {
        return Ok(vec![SeenSurfaces::default(); receivers]);
    }
    let hits = site.tile_hits(tile, receivers)?;
    let side = site.settings().hit;
    let centre = DVec2::splat(0.5);
    let cosines: Vec<f64> = (0..side * side).map(|t| texel_direction(t % side, t / side, side, centre).z).collect();
    // `[number of a cell]`: its class and material; texels whose rays met nothing have number 0.
    let met = hits.palette.iter().map(|key| {
        let material = materials.get(usize::from(key.material))?;
        Some((material.class, SurfaceMean::of_material(material)))
    });
    let met: Vec<Option<(Class, SurfaceMean)>> = std::iter::once(None).chain(met).collect();
    let of_texel = |texel: &u32| met.get(*texel as usize).copied().flatten();
    let of_receiver = |texels: &[u32]| {
        let of_class = |class: Class| {
            let of = |(texel, cosine): (&u32, &f64)| {
                (*cosine, of_texel(texel).filter(|met| met.0 == class).map(|met| met.1))
            };
            differ[class.index()].then(|| SurfaceMean::new(texels.iter().zip(&cosines).map(of))).flatten()
        };
        SeenSurfaces { ground: of_class(Class::Ground), obstruction: of_class(Class::Obstruction) }
    };
    Ok(hits.texels.chunks_exact(side * side).map(of_receiver).collect())
}

fn usual_emissivity(class: Class) -> f64 {
    match class {
        Class::Ground => USUAL_GROUND_EMISSIVITY,
        Class::Obstruction => USUAL_OBSTRUCTION_EMISSIVITY,
    }
}
