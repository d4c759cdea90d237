//! Parts that the readers of building models share. In: walls, openings and layers, from any
//! format. Out: holes for windows, faces that lie inside or look inwards, the ground, glass by its
//! panes, materials under unique names, and one warning for each kind of oddity.

pub(super) mod back_to_back;
pub(super) mod frame;
pub(super) mod holes;
pub(super) mod notes;
pub(super) mod optics;
pub(super) mod outwards;
pub(super) mod standing;
