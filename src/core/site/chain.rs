//! Planar mirrors: orientations, and chains of them with their effect on directions. In: normals
//! and materials, directions. Out: mirrored directions and linear maps.
//!
//! The effect of a mirror on a direction depends on its normal only. So all parallel mirrors of one
//! material are one orientation, a hundred recessed windows as well as a single pane. A curved
//! mirror is many orientations.

use glam::{DMat3, DVec3};

/// Largest number of mirrors that light meets one after the other.
pub const MAX_MIRRORS: usize = 3;

/// Orientation of the parallel mirrors of one material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorPlane {
    /// Unit normal of either sign.
    pub normal: DVec3,
    /// Row of the materials table.
    pub material: u16,
}

impl MirrorPlane {
    /// Returns a direction mirrored: after reflection, or before it.
    pub fn reflect(&self, direction: DVec3) -> DVec3 {
        direction - self.normal * (2.0 * self.normal.dot(direction))
    }

    /// Returns the reflection as a linear map.
    pub fn map(&self) -> DMat3 {
        let n = self.normal;
        DMat3::IDENTITY - DMat3::from_cols(n * n.x, n * n.y, n * n.z) * 2.0
    }
}

/// Mirror on the way to a surface: the number of its material, and the cosine of the angle of
/// incidence in 255ths.
pub type MirrorStep = (u16, u8);

/// Chain of mirror orientations in the order from the observer on; at most [`MAX_MIRRORS`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Chain {
    /// Numbers of the orientations + 1; 0 is none.
    links: [u32; MAX_MIRRORS],
}

impl Chain {
    /// Returns the chain of these orientations, from the observer on; those beyond [`MAX_MIRRORS`]
    /// are left out.
    pub fn new(numbers: &[u16]) -> Self {
        let mut chain = Chain::default();
        chain.links.iter_mut().zip(numbers).for_each(|(link, &number)| *link = u32::from(number) + 1);
        chain
    }

    /// Returns the chain with one more mirror, or `None` if it is full.
    pub fn then(mut self, number: u16) -> Option<Self> {
        let link = self.links.iter_mut().find(|link| **link == 0)?;
        *link = u32::from(number) + 1;
        Some(self)
    }

    /// Iterates over the numbers of the orientations, from the observer on.
    pub fn numbers(&self) -> impl Iterator<Item = u16> + Clone + '_ {
        self.links.iter().take_while(|link| **link > 0).map(|link| (link - 1) as u16)
    }

    /// Returns the number of mirrors, 0 to [`MAX_MIRRORS`].
    pub fn len(&self) -> usize {
        self.numbers().count()
    }

    /// Returns true if the chain has no mirror.
    pub fn is_empty(&self) -> bool {
        self.links == [0; MAX_MIRRORS]
    }

    /// Returns the linear map from the direction in which light comes from behind the last mirror
    /// to the direction in which the observer sees it; `None` if an orientation does not exist.
    pub fn seen_from(&self, orientations: &[MirrorPlane]) -> Option<DMat3> {
        self.numbers().try_fold(DMat3::IDENTITY, |map, number| Some(map * orientations.get(usize::from(number))?.map()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The chain's map takes the direction in which a ray leaves two mirrors to the direction in
    /// which it started, to 1e-15. Chains hold 3 mirrors and no fourth.
    #[test]
    fn a_chain_maps_the_last_direction_to_the_first() {
        let orientation = |normal: DVec3| MirrorPlane { normal: normal.normalize(), material: 0 };
        let both = [orientation(DVec3::new(1.0, 2.0, 0.0)), orientation(DVec3::new(0.0, 1.0, -3.0))];
        let chain = Chain::new(&[0, 1]);
        let start = DVec3::new(0.6, 0.0, 0.8);
        let end = both[1].reflect(both[0].reflect(start));
        let map = chain.seen_from(&both).expect("both exist");
        assert!((map * end - start).length() < 1e-15);
        assert_eq!(chain.seen_from(&both[..1]), None);
        assert_eq!((chain.len(), chain.then(0).and_then(|c| c.then(1))), (2, None));
        assert_eq!(chain.then(0).map(|c| c.numbers().collect()), Some(vec![0, 1, 0]));
    }
}
