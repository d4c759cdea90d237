//! Areas on the ground: gardens, squares, yards. In: a file of polygons, a CSV file of corners, or
//! a box. Out: areas, and places in them at equal distances.

use std::path::Path;

use glam::DVec2;

use super::lines::{TravelCorner, named_corners};
use crate::formats;
use crate::plan::{is_within, sides, signed_area_m2};
use heliotile_core::error::{Error, Result};
use heliotile_core::text::Message;
use heliotile_files::input;

/// An area in plan.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundArea {
    /// Name of the area: the cell of the column `area`, the attribute `area` or `name` of a
    /// polygon, or the name of the file.
    pub name: String,
    /// Outlines and holes, input coordinates, metres.
    rings: Vec<Vec<DVec2>>,
}

/// Columns of a file of areas, as messages describe them.
const HINT: &str = "give columns x and y in metres, a row for each corner; area (a name) is optional";

/// Reads areas: polygons of a file of features, in metres of the plane system `scene` (an EPSG
/// number), or corners of a CSV file. Also returns sentences for the user. Fails if the file cannot
/// be read or an area has no extent.
pub fn read_areas(file: &Path, scene: Option<u32>) -> Result<(Vec<GroundArea>, Vec<Message>)> {
    let (areas, said) = if input::ending(file) == "csv" {
        (of_corners(file)?, Vec::new())
    } else {
        let (outlines, said) = formats::read_areas(file, scene)?;
        (outlines.into_iter().map(|outline| GroundArea { name: outline.name, rings: outline.rings }).collect(), said)
    };
    match areas.iter().find(|area| area.area_m2() <= 0.0) {
        Some(area) => {
            let what = format!("area `{}` has no extent", area.name);
            Err(Error::input(file, None, what, "give three corners or more, in their order around the area"))
        }
        None => Ok((areas, said)),
    }
}

/// Reads areas from a CSV file with columns `x,y` and optional `area`, in any order. Each row is a
/// corner of an outline; consecutive rows of one name are an area.
fn of_corners(file: &Path) -> Result<Vec<GroundArea>> {
    let in_plan = |corners: Vec<TravelCorner>| vec![corners.iter().map(|corner| corner.at).collect()];
    let found = named_corners(file, &["area"], HINT)?.into_iter();
    Ok(found.map(|(name, corners)| GroundArea { name, rings: in_plan(corners) }).collect())
}

impl GroundArea {
    /// Returns the rectangle between two corners.
    pub fn of_box(name: String, low: DVec2, high: DVec2) -> Self {
        let corners = vec![low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        GroundArea { name, rings: vec![corners] }
    }

    /// Returns the area in plan, m2. Holes run the other way than outlines.
    pub fn area_m2(&self) -> f64 {
        self.rings.iter().map(|ring| signed_area_m2(ring)).sum::<f64>().abs()
    }

    /// Returns the lowest and the highest coordinates of the corners.
    fn bounds(&self) -> [DVec2; 2] {
        let (low, high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        [self.corners().fold(low, DVec2::min), self.corners().fold(high, DVec2::max)]
    }

    /// Iterates over the corners of all outlines and holes.
    pub fn corners(&self) -> impl Iterator<Item = DVec2> + '_ {
        self.rings.iter().flatten().copied()
    }

    /// Returns the vector along the longest side.
    pub fn longest_side(&self) -> DVec2 {
        let all = self.rings.iter().flat_map(|ring| sides(ring)).map(|[a, b]| b - a);
        all.fold(DVec2::ZERO, |longest, side| {
            // Of sides that differ by rounding, the first counts.
            if side.length_squared() > longest.length_squared() * 1.000_001 { side } else { longest }
        })
    }

    /// Returns true if a square, or another convex outline of four corners, lies in the area but
    /// for a thousandth of its width along its rim.
    pub fn holds(&self, square: [DVec2; 4]) -> bool {
        let middle = 0.25 * square.iter().sum::<DVec2>();
        let inner = square.map(|corner| corner.lerp(middle, 0.001));
        let is_here = |place: DVec2| is_within(self.rings.iter().flat_map(|ring| sides(ring)), place);
        inner.iter().all(|corner| is_here(*corner)) && !self.corners().any(|corner| is_within(sides(&inner), corner))
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
        all.filter(|place| is_within(self.rings.iter().flat_map(|ring| sides(ring)), *place)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_files::TestFolder;

    fn read(text: &str) -> Result<Vec<GroundArea>> {
        let folder = TestFolder::new();
        read_areas(&folder.write("garden.csv", text), None).map(|read| read.0)
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
        let square = |x: f64, y: f64, side: f64| {
            [[x, y], [x + side, y], [x + side, y + side], [x, y + side]].map(DVec2::from_array)
        };
        let held = [(0.0, 0.0, 2.0), (2.0, 2.0, 2.0), (1.0, 1.0, 2.0), (0.0, 0.0, 4.0)];
        assert_eq!(held.map(|(x, y, side)| l.holds(square(x, y, side))), [true, false, false, false]);
        assert_eq!(l.longest_side(), DVec2::new(4.0, 0.0));
        assert_eq!((b.places(1.0).len(), b.most_places(1.0)), (3, 3.0));
        let own = read("x,y\n0,0\n1,0\n0,1\n").expect("an area");
        assert_eq!((own[0].name.as_str(), own[0].area_m2()), ("garden", 0.5));
        let (low, high) = (DVec2::ZERO, DVec2::new(4.0, 2.0));
        assert_eq!(GroundArea::of_box("box".into(), low, high).places(1.0).len(), 8);
    }

    /// A square of 4 m with a hole of 2 m and a square of 2 m beside it, in a GeoJSON file in the
    /// system of the scene, have 16 places at 1 m, and a point is left out with a sentence. Two
    /// areas of one name get two names. Degrees without a system of the scene, another system, and
    /// a file without polygons are refused.
    #[test]
    fn polygons_of_features_are_areas() {
        let folder = TestFolder::new();
        let ring = |x: f64, y: f64, side: f64| {
            format!("[[{x},{y}],[{},{y}],[{},{}],[{x},{}],[{x},{y}]]", x + side, x + side, y + side, y + side)
        };
        let feature = |geometry: &str| {
            format!(r#"{{"type":"Feature","properties":{{"Name":"court"}},"geometry":{{"type":{geometry}}}}}"#)
        };
        let crs =
            |epsg: u32| format!(r#""crs":{{"type":"name","properties":{{"name":"urn:ogc:def:crs:EPSG::{epsg}"}}}},"#);
        let write = |crs: String, features: &[String]| {
            let text = format!(r#"{{"type":"FeatureCollection",{crs}"features":[{}]}}"#, features.join(","));
            folder.write("areas.geojson", &text)
        };
        let (x, y) = (80_000.0, 455_000.0);
        let two = [ring(x, y, 4.0), ring(x + 1.0, y + 1.0, 2.0), ring(x + 6.0, y, 2.0)];
        let multi = feature(&format!(r#""MultiPolygon","coordinates":[[{},{}],[{}]]"#, two[0], two[1], two[2]));
        let point = feature(r#""Point","coordinates":[1,2]"#);
        let file = write(crs(28992), &[multi.clone(), point.clone(), multi]);
        let (areas, said) = read_areas(&file, Some(28992)).expect("areas");
        assert_eq!((areas[0].area_m2(), areas[0].places(1.0).len()), (16.0, 16));
        assert_eq!([&areas[0].name, &areas[1].name], ["court", "court-2"]);
        assert!(said.iter().any(|said| said.contains("1 feature left out")), "{said:?}");
        let refused = |file: &Path, scene: Option<u32>, says: &str| {
            let error = read_areas(file, scene).expect_err(says).to_string();
            assert!(error.contains(says), "{error}");
        };
        refused(&file, Some(25832), "EPSG:28992");
        refused(&write(crs(28992), &[point]), Some(28992), "no areas");
        let degrees = feature(&format!(r#""Polygon","coordinates":[{}]"#, ring(4.3, 52.0, 0.001)));
        let file = write(String::new(), &[degrees]);
        refused(&file, None, "the scene states no system");
        // 0.001 degrees are 111.3 m to the north and 68.6 m to the east.
        let (areas, _) = read_areas(&file, Some(28992)).expect("areas");
        assert!((areas[0].area_m2() - 7637.0).abs() < 20.0, "{}", areas[0].area_m2());
        refused(&folder.write("areas.kml", ""), None, "ends with .kml");
        // A shapefile in a zip has the areas of the same town as GeoPackage.
        let town = |ending: &str| {
            let file = format!("{}/../../tests/data/footprints/town.{ending}", env!("CARGO_MANIFEST_DIR"));
            let (areas, _) = read_areas(Path::new(&file), Some(25832)).expect("areas");
            (areas.len(), areas.iter().map(GroundArea::area_m2).sum::<f64>())
        };
        let (zipped, database) = (town("shp.zip"), town("gpkg"));
        assert!(zipped.0 == database.0 && (zipped.1 / database.1 - 1.0).abs() < 1e-6, "{zipped:?} {database:?}");
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
