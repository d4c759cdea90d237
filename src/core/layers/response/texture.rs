//! Unpacked response of a receiver. In: values by class, axis and texel. Out: vectors by texel.

use crate::site::material::Class;

/// First-hit classes, in the order of the arrays: ground, obstruction.
pub const CLASSES: usize = 2;

/// Response of one receiver: the diffuse irradiance from a source of direction s in texel t is
/// (normal irradiance of the source) x `s . G[t]`, W/m2 per W/m2, summed over classes.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// `[class][axis x, y, z][texel]`, texels row-major, world frame.
    pub values: Vec<f32>,
}

impl Response {
    /// Returns the number of values of one receiver with n x n texels.
    pub fn len(n: usize) -> usize {
        CLASSES * 3 * n * n
    }

    /// Returns the vectors of one first-hit class: `[texel][axis]`.
    pub fn vectors_of(&self, class: Class) -> Vec<[f32; 3]> {
        let texels = self.values.len() / (CLASSES * 3);
        let at = |axis: usize, texel: usize| self.values[(class.index() * 3 + axis) * texels + texel];
        (0..texels).map(|texel| [at(0, texel), at(1, texel), at(2, texel)]).collect()
    }

    /// Returns the sum of both classes: `[texel][axis]`.
    pub fn vectors(&self) -> Vec<[f32; 3]> {
        let (ground, obstruction) = self.values.split_at(self.values.len() / CLASSES);
        let texels = ground.len() / 3;
        let at = |axis: usize| {
            let range = axis * texels..(axis + 1) * texels;
            ground[range.clone()].iter().zip(&obstruction[range]).map(|(a, b)| a + b)
        };
        at(0).zip(at(1)).zip(at(2)).map(|((x, y), z)| [x, y, z]).collect()
    }
}
