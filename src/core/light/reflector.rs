//! Optical numbers of materials. In: the materials of a scene or of an archive. Out: the numbers
//! that light is computed with.

use crate::site::material::{Class, Glass, Material};

/// Diffuse reflectance by material.
pub type Reflectance = Vec<f64>;

/// Optical properties of a material that replay needs.
#[derive(Clone, Copy, Debug)]
pub struct Reflector {
    /// Diffuse reflectance, 0 to 1. For a canopy, the share that its leaves scatter, half of it to
    /// each side; for a volume, the share of the light that falls on a leaf.
    pub diffuse: f64,
    /// First-hit class that its light counts for.
    pub class: Class,
    /// Specular reflectance at any angle; 0 for glass.
    pub specular: f64,
    /// Number of panes of clear glass; 0 for other materials.
    pub panes: u8,
    /// Transmittance of a canopy, of a volume along a metre; `None` is opaque.
    pub transmittance: Option<f64>,
    /// True for a volume of leaves.
    pub volume: bool,
}

impl Reflector {
    /// Returns the value that a replay may change: the transmittance of a canopy, else the diffuse
    /// reflectance.
    pub fn variable(&self) -> f64 {
        self.transmittance.unwrap_or(self.diffuse)
    }

    /// Returns the share of the light that is scattered when [`Reflector::variable`] has this
    /// value. A canopy of another transmittance has more or fewer leaves, which scatter the same
    /// share of the light that they stop; a volume of another density has more or fewer leaves.
    pub fn scattered(&self, variable: f64) -> f64 {
        match self.transmittance {
            None => variable,
            Some(stored) if stored < 1.0 && self.volume => self.diffuse * variable.ln() / stored.ln(),
            // Where all light comes through there is nothing that could scatter it.
            Some(stored) if stored < 1.0 => self.diffuse * (1.0 - variable) / (1.0 - stored),
            Some(_) => 0.0,
        }
    }

    /// Returns the properties of a material of the scene.
    pub fn new(material: &Material) -> Self {
        Reflector {
            diffuse: material.diffuse,
            class: material.class,
            specular: material.specular,
            panes: material.glass.map_or(0, Glass::panes),
            transmittance: material.transmittance,
            volume: material.volume,
        }
    }

    /// Returns true if it reflects like a mirror.
    pub fn mirrors(&self) -> bool {
        self.specular > 0.0 || self.panes > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Leaves that let 0.2 through and scatter 0.4 scatter 0.2 where 0.6 comes through, and nothing
    /// where all does. A canopy that lets all light through and scatters a rounding error scatters
    /// nothing, not NaN: 2 of 2 transmittances. An opaque surface has its own reflectance.
    #[test]
    fn fewer_leaves_scatter_less() {
        let of = |transmittance, diffuse| {
            Reflector::new(&Material { transmittance, ..Material::matt("m", diffuse, Class::Obstruction) })
        };
        let leaf = of(Some(0.2), 0.4);
        assert!((leaf.scattered(0.6) - 0.2).abs() < 1e-12 && leaf.scattered(1.0) == 0.0);
        assert_eq!([0.5, 1.0].map(|through| of(Some(1.0), 5e-13).scattered(through)), [0.0; 2]);
        assert_eq!((of(Some(0.2), 0.0).scattered(0.6), of(None, 0.3).scattered(0.7)), (0.0, 0.7));
    }
}
