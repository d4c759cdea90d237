//! Materials.

/// Which of the two first-hit classes a surface counts for (the five EnergyPlus factors need them apart).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    Ground,
    Obstruction,
}

/// Checked reflectances of one material; `diffuse + specular <= 1`, both in 0..=1.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    pub name: String,
    pub diffuse: f64,
    pub specular: f64,
    pub class: Class,
}
