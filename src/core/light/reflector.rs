//! What materials do with light. In: the materials of a scene or of an archive. Out: the numbers that light is computed with.

use crate::site::material::{Class, Glass, Material};

/// Diffuse reflectance by material.
pub type Reflectance = Vec<f64>;

/// Optical properties of a material that recombination needs.
#[derive(Clone, Copy, Debug)]
pub struct Reflector {
    /// Diffuse reflectance, 0 to 1; of a canopy the share that its leaves scatter, half of it to each side.
    pub diffuse: f64,
    /// First-hit class that its light counts for.
    pub class: Class,
    /// Specular reflectance at any angle; 0 for glass.
    pub specular: f64,
    /// Panes of clear glass.
    pub panes: u8,
    /// Of a canopy; `None` is opaque.
    pub transmittance: Option<f64>,
}

impl Reflector {
    /// What a replay may change: of a canopy its transmittance, else the diffuse reflectance.
    pub fn variable(&self) -> f64 {
        self.transmittance.unwrap_or(self.diffuse)
    }

    /// What is scattered of the light in a state of [`Reflector::variable`]. A canopy of another transmittance has more or fewer leaves, which
    /// scatter the same share of the light that they stop.
    pub fn scattered(&self, variable: f64) -> f64 {
        match self.transmittance {
            None => variable,
            Some(stored) if self.diffuse > 0.0 => self.diffuse * (1.0 - variable) / (1.0 - stored),
            Some(_) => 0.0,
        }
    }

    /// The properties of a material of the scene.
    pub fn of(material: &Material) -> Self {
        Reflector {
            diffuse: material.diffuse,
            class: material.class,
            specular: material.specular,
            panes: material.glass.map_or(0, Glass::panes),
            transmittance: material.transmittance,
        }
    }

    /// Whether it reflects like a mirror.
    pub fn mirrors(&self) -> bool {
        self.specular > 0.0 || self.panes > 0
    }
}
