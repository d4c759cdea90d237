//! Surface of a model. In: its object, corners and plane. Out: the same, with what lies behind it.

use glam::DVec3;

use crate::formats::building::frame::Frame;
use crate::formats::energyplus::model::Object;
use heliotile_core::site::semantics::SurfaceKind;

/// Space behind a surface, seen from its zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AdjacentSpace {
    Outdoors,
    Ground,
    /// Not stated: a wall to a neighbour, or one between zones.
    Adiabatic,
    Inside,
}

pub(super) struct Surface<'m> {
    pub object: &'m Object,
    pub vertices: Vec<DVec3>,
    pub frame: Frame,
    /// Index of the wall that an opening belongs to; a wall's own index for a wall.
    pub base: usize,
    pub behind: AdjacentSpace,
    pub kind: SurfaceKind,
    /// True if the sun may reach the surface: it lies outdoors and is not stated as `NoSun`.
    pub exposed: bool,
}
