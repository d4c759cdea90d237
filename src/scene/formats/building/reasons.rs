//! Reasons why readers of buildings leave faces or openings out, as
//! [`Geometry`](crate::geometry::Geometry) and [`Notes`](crate::formats::building::notes::Notes)
//! count them.

/// Reason for faces that have fewer than three corners.
pub(in crate::formats) const TOO_FEW: &str = "with fewer than three corners";
/// Reason for faces that lie beyond all positions on Earth.
pub(in crate::formats) const TOO_FAR: &str = "because they lie more than 1e9 m away";
/// Reason for faces inside the building.
pub(in crate::formats) const INSIDE: &str = "because they lie inside the building";
/// Reason for walls that are windows altogether.
pub(in crate::formats) const ALL_WINDOW: &str = "because a window fills them completely";
/// Note on openings that look the other way than their wall.
pub(in crate::formats) const TURNED_OPENINGS: &str = "windows or doors face against their wall and are turned round";
/// Note on openings that do not fit into their wall.
pub(in crate::formats) const BEYOND: &str = "windows or doors are left out, and their wall stays whole there: they reach over its edge, \
                                             overlap each other or lie off its plane";
