//! Areas on the ground: gardens, squares, yards. In: a CSV file of their corners, or a box. Out:
//! areas, and places in them at equal distances.

use std::path::Path;

use glam::DVec2;

use super::lines::{TravelCorner, named_corners};
use crate::plan::{is_within, sides, signed_area_m2};
use heliotile_core::error::{Error, Result};

/// An area in plan.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundArea {
    /// Name of the area: the cell of the column `area`, or the name of the file.
    pub name: String,
    /// Corners of its outline, input coordinates, metres.
    pub corners: Vec<DVec2>,
}

/// Columns of a file of areas, as messages describe them.
const HINT: &str = "give columns x and y in metres, a row for each corner; area (a name) is optional";

/// Reads areas from a CSV file with columns `x,y` and optional `area`, in any order. Each row is a
/// corner of an outline; consecutive rows of one name are an area. Fails if a cell is not a number
/// or an area has no extent.
pub fn read_areas(file: &Path) -> Result<Vec<GroundArea>> {
    let in_plan = |corners: Vec<TravelCorner>| corners.iter().map(|corner| corner.at).collect();
    let found = named_corners(file, &["area"], HINT)?;
    let areas: Vec<GroundArea> =
        found.into_iter().map(|(name, corners)| GroundArea { name, corners: in_plan(corners) }).collect();
    match areas.iter().find(|area| area.area_m2() <= 0.0) {
        Some(area) => {
            let what = format!("area `{}` has no extent", area.name);
            Err(Error::input(file, None, what, "give three corners or more, in their order around the area"))
        }
        None => Ok(areas),
    }
}

impl GroundArea {
    /// Returns the rectangle between two corners.
    pub fn of_box(name: String, low: DVec2, high: DVec2) -> Self {
        let corners = vec![low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        GroundArea { name, corners }
    }

    /// Returns the area in plan, m2.
    pub fn area_m2(&self) -> f64 {
        signed_area_m2(&self.corners).abs()
    }

    /// Returns the lowest and the highest coordinates of the corners.
    fn bounds(&self) -> [DVec2; 2] {
        let all = self.corners.iter().copied();
        [all.clone().fold(DVec2::INFINITY, DVec2::min), all.fold(DVec2::NEG_INFINITY, DVec2::max)]
    }

    /// Returns the largest number of places that the area may have at a spacing.
    pub fn most_places(&self, spacing_m: f64) -> f64 {
        let [low, high] = self.bounds();
        ((high - low) / spacing_m).ceil().element_product()
    }

    /// Returns the middles of squares of the spacing's width that lie in the area, row by row from
    /// the south-west of its bounds.
    pub fn places(&self, spacing_m: f64) -> Vec<DVec2> {
        let [low, high] = self.bounds();
        let count = ((high - low) / spacing_m).ceil().max(DVec2::ONE);
        let first = 0.5 * (low + high) - 0.5 * (count - 1.0) * spacing_m;
        let rows = 0..count.y as usize;
        let row = |row: usize| (0..count.x as usize).map(move |column| DVec2::new(column as f64, row as f64));
        let all = rows.flat_map(row).map(|step| first + step * spacing_m);
        all.filter(|place| is_within(sides(&self.corners), *place)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_files::TestFolder;

    fn read(text: &str) -> Result<Vec<GroundArea>> {
        let folder = TestFolder::new();
        read_areas(&folder.write("garden.csv", text))
    }

    /// An L of 4 x 4 m without its north-east quarter has 12 places at 1 m, 3 at 2 m, and 12 m2; a
    /// box of 3 x 1 m far away has 3; without a column of names an area has that of its file.
    #[test]
    fn places_fill_an_area() {
        let l = "area,x,y\nl,0,0\nl,4,0\nl,4,2\nl,2,2\nl,2,4\nl,0,4\n";
        let areas = read(&format!("{l}b,500000,5000000\nb,500003,5000000\nb,500003,5000001\nb,500000,5000001\n"));
        let areas = areas.expect("areas");
        let [l, b] = areas.as_slice() else { panic!("{areas:?}") };
        assert_eq!((l.area_m2(), l.places(1.0).len(), l.places(2.0).len()), (12.0, 12, 3));
        assert_eq!(l.places(2.0), [[1.0, 1.0], [3.0, 1.0], [1.0, 3.0]].map(DVec2::from_array));
        assert_eq!((b.places(1.0).len(), b.most_places(1.0)), (3, 3.0));
        let own = read("x,y\n0,0\n1,0\n0,1\n").expect("an area");
        assert_eq!((own[0].name.as_str(), own[0].area_m2()), ("garden", 0.5));
        let (low, high) = (DVec2::ZERO, DVec2::new(4.0, 2.0));
        assert_eq!(GroundArea::of_box("box".into(), low, high).places(1.0).len(), 8);
    }

    /// A file without a column of numbers, and areas of two corners or on one line, are refused
    /// with what is wrong: 4 of 4.
    #[test]
    fn malformed_areas_are_refused() {
        for (text, says) in [
            ("x,z\n1,2\n", "column `y` is missing"),
            ("x,y\n1,2\n1,two\n", "line 3"),
            ("x,y\n1,2\n3,2\n", "no extent"),
            ("area,x,y\na,0,0\na,1,0\nb,0,0\nb,1,1\na,2,2\n", "do not follow each other"),
        ] {
            assert!(read(text).is_err_and(|error| error.to_string().contains(says)), "{says}");
        }
    }
}
