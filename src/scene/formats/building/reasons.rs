//! Why readers of buildings leave things out, as [`Geometry`](crate::geometry::Geometry) and
//! [`Notes`](crate::formats::building::notes::Notes) count them.

/// Faces.
pub(in crate::formats) const TOO_FEW: &str = "with fewer than three corners";
/// Faces.
pub(in crate::formats) const TOO_FAR: &str = "because they lie more than 1e9 m away";
/// Faces.
pub(in crate::formats) const INSIDE: &str = "because they lie inside the building";
/// Faces.
pub(in crate::formats) const ALL_WINDOW: &str = "because a window takes up the whole of them";
/// A note of openings.
pub(in crate::formats) const TURNED_OPENINGS: &str =
    "windows or doors look the other way than their wall and are turned";
/// A note of windows and doors.
pub(in crate::formats) const BEYOND: &str = "windows or doors are left out of walls that stay whole there: they reach over an edge or \
                                             each other, or lie off the plane";
