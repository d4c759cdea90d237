//! Geometry that lies on its side. In: triangles of a mesh whose file does not state an up axis,
//! and the words of its header. Out: a sentence if y seems to point up.
//!
//! Sloping faces of what is built look up more than down: roofs, terrain, modules. Sloping walls
//! look to all sides. So the sloping faces of a model with y up look towards y together, and
//! towards z as much as against it.

use std::path::Path;

use heliotile_core::text::{Message, message};

use glam::DVec3;

use crate::mesh::bounds;

/// Least and greatest part of a unit normal along an axis for which a face slopes (6 and 85
/// degrees).
const TOWARDS: f64 = 0.1;
const SLOPING: f64 = 0.996;
/// Least part of the unit normal along z of a wall of a model with y up.
const WALL: f64 = 0.3;
/// Least share of the area that slopes, of a model with slopes.
const MIN_SLOPES: f64 = 0.01;
/// Least mean part of the sloping normals along y, and greatest along z, of a model with y up.
const MEAN_UP: f64 = 0.3;
const MEAN_ASIDE: f64 = 0.05;
/// Least share of the area of such walls.
const MIN_WALLS: f64 = 0.02;
/// Part of the height by which a model stands above its zero.
const AT_ZERO: f64 = 1e-3;

/// Statement of a file's header on its up axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum HeaderUp {
    /// Written by Blender, which writes y up unless it is told otherwise.
    Blender,
    /// A comment says that y points up.
    Y,
}

impl HeaderUp {
    /// Returns the statement of a comment, if it makes one.
    pub(crate) fn of_comment(text: &[u8]) -> Option<HeaderUp> {
        let text = String::from_utf8_lossy(text.get(..text.len().min(200)).unwrap_or_default()).to_lowercase();
        let says_y = ["y up", "y-up", "up: y", "up=y", "y_up"].iter().any(|words| text.contains(words));
        let is_blender = text.trim_start().starts_with("blender ");
        if says_y { Some(HeaderUp::Y) } else { is_blender.then_some(HeaderUp::Blender) }
    }
}

/// Returns a warning about a mesh in which y seems to point up.
pub(crate) fn y_up_warning(
    file: &Path,
    triangles: impl Iterator<Item = [DVec3; 3]> + Clone,
    header: Option<HeaderUp>,
) -> Option<Message> {
    let sign = sign_of_y_up(triangles, header)?;
    Some(message!(
        "{}: {sign}, but z is taken for up; if y points up, give {{up}} y; {{up}} z keeps it as it is",
        file.display()
    ))
}

/// Returns why y seems to point up in a mesh; `None` if z may.
fn sign_of_y_up(triangles: impl Iterator<Item = [DVec3; 3]> + Clone, header: Option<HeaderUp>) -> Option<&'static str> {
    if header == Some(HeaderUp::Y) {
        return Some("a comment of the file says that y points up");
    }
    let (mut all_m2, mut walls_m2, mut along_y, mut along_z) = (0.0, 0.0, Slopes::default(), Slopes::default());
    for [a, b, c] in triangles.clone() {
        let area = 0.5 * (b - a).cross(c - a);
        let Some(normal) = area.try_normalize() else { continue };
        all_m2 += area.length();
        walls_m2 += if normal.y.abs() < TOWARDS && normal.z.abs() > WALL { area.length() } else { 0.0 };
        along_y.add(normal.y, area.length());
        along_z.add(normal.z, area.length());
    }
    if along_y.all_m2.max(along_z.all_m2) > MIN_SLOPES * all_m2 {
        let is_on_side = along_y.sum_m2 > MEAN_UP * along_y.all_m2
            && along_z.sum_m2.abs() <= MEAN_ASIDE * along_z.all_m2
            && walls_m2 > MIN_WALLS * all_m2;
        return is_on_side.then_some("its sloping faces look towards y, as roofs do where y points up");
    }
    let (low, high) = bounds(triangles.flatten());
    let stands_on_y = low.y.abs() <= AT_ZERO * (high.y - low.y) && low.z < -AT_ZERO * (high.z - low.z);
    let is_blender = header == Some(HeaderUp::Blender) && stands_on_y;
    is_blender.then_some("its header says Blender, which writes y up by default, and it stands on y = 0")
}

/// Faces that slope along an axis.
#[derive(Default)]
struct Slopes {
    all_m2: f64,
    /// Sum of their areas times their normals along the axis.
    sum_m2: f64,
}

impl Slopes {
    fn add(&mut self, along: f64, area_m2: f64) {
        if (TOWARDS..SLOPING).contains(&along.abs()) {
            self.all_m2 += area_m2;
            self.sum_m2 += along * area_m2;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a house of 10 x 8 x 6 m with a gable of 3 m, or a box without it, turned about z.
    fn house(rise: f64, turned_deg: f64) -> Vec<[DVec3; 3]> {
        let turn = glam::DMat3::from_rotation_z(turned_deg.to_radians());
        let p = |x: f64, y: f64, z: f64| turn * DVec3::new(x, y, z);
        let [a, b, c, d] = [p(0., 0., 0.), p(10., 0., 0.), p(10., 8., 0.), p(0., 8., 0.)];
        let [e, f, g, h] = [p(0., 0., 6.), p(10., 0., 6.), p(10., 8., 6.), p(0., 8., 6.)];
        let [i, j] = [p(0., 4., 6. + rise), p(10., 4., 6. + rise)];
        let quads = [[d, c, b, a], [e, f, j, i], [g, h, i, j], [a, b, f, e], [c, d, h, g], [b, c, g, f], [d, a, e, h]];
        let halves = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
        halves.chain([[f, g, j], [h, e, i]]).collect()
    }

    /// A gable with y up is recognised, straight and turned by 30 degrees; with z up it is not. A
    /// box with y up is recognised by the header of Blender or by a comment only.
    #[test]
    fn houses_on_their_side_are_recognised() {
        let on_side = |house: Vec<[DVec3; 3]>| -> Vec<[DVec3; 3]> {
            house.into_iter().map(|triangle| triangle.map(|p| DVec3::new(p.x, p.z, -p.y))).collect()
        };
        let header = HeaderUp::of_comment;
        assert_eq!((header(b" Blender 4.2.3 LTS"), header(b" made by hand")), (Some(HeaderUp::Blender), None));
        assert_eq!(header(b" origin: lat 48.1, y up, x east"), Some(HeaderUp::Y));
        for (rise, turned_deg, header, is_up, is_side) in [
            (3.0, 0.0, None, false, true),
            (3.0, 30.0, None, false, true),
            (3.0, 0.0, Some(HeaderUp::Blender), false, true),
            (0.0, 0.0, None, false, false),
            (0.0, 0.0, Some(HeaderUp::Blender), false, true),
            (0.0, 0.0, Some(HeaderUp::Y), true, true),
        ] {
            let found = |triangles: Vec<[DVec3; 3]>| sign_of_y_up(triangles.into_iter(), header).is_some();
            let (up, side) = (found(house(rise, turned_deg)), found(on_side(house(rise, turned_deg))));
            assert_eq!((up, side), (is_up, is_side), "{rise} {turned_deg} {header:?}");
        }
    }
}
