//! Heights on a grid. In: samples of a file, and its statements on nodata and units. Out: metres,
//! with NaN for nodata; no other number that is not finite, and none beyond the Earth's heights.

use std::ops::Range;
use std::path::Path;

use glam::{DVec2, DVec3};

use crate::coordinate::is_position;
use crate::placing::frame::{SiteFrame, UpAxis};
use crate::site::Part;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::{Message, message};
use heliotile_place::reference::Reference;

/// Most samples of a raster: 1 GB of heights, and as many triangles as a scene may have.
pub(crate) const MAX_SAMPLES: u64 = 1 << 28;

/// Range of heights of land and sea floor, metres: from below the Challenger Deep (-10,935) to
/// above Mount Everest (8,849).
const EARTH_M: [f32; 2] = [-12_000.0, 9_000.0];

/// Values within the Earth's heights that programs write for "no data" without stating it. No land
/// lies below -430 m, and sea floor at exactly such a depth is a sample or two.
const USUAL_NODATA: [f32; 3] = [-9999.0, -9998.0, -999.0];

/// Positions of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Grid {
    pub columns: usize,
    pub rows: usize,
    /// Position of the first sample, the north-west one, in the middle of its cell.
    pub first: DVec2,
    /// Distances from column to column, eastwards, and from row to row, southwards, metres; both
    /// positive.
    pub step: DVec2,
}

/// Statements of a file on its numbers.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Meaning {
    /// Number that stands for nodata, as written, before `scale`.
    pub nodata: Option<f64>,
    /// Factor from a stored number to a height; `None`: 1.
    pub scale: Option<f64>,
    /// Height added to the product.
    pub offset: f64,
    /// Metres a unit of height, if the file states the unit.
    pub height_unit_m: Option<f64>,
    /// Metres a unit of the plane coordinates, if the file states the unit; the grid is converted
    /// to metres by it.
    pub plane_unit_m: Option<f64>,
    /// True if the file states that its plane coordinates are metres or feet, not degrees.
    pub projected: bool,
    pub reference: Option<Reference>,
}

/// Heights on a grid of at least 2 x 2 samples, of which at least one is known.
#[derive(Debug)]
pub(crate) struct Raster {
    pub grid: Grid,
    /// Heights in metres, `[row][column]`, row 0 in the north; NaN for nodata. An f32 holds 9,000 m
    /// to 0.5 mm.
    pub(crate) heights: Vec<f32>,
    pub reference: Option<Reference>,
    /// Metres a unit of the file's plane coordinates, if the file or its user states it: the grid
    /// is then certainly in metres.
    pub plane_unit_m: Option<f64>,
    /// Metres a unit of the file's heights, if the file states it.
    pub(super) height_unit_m: Option<f64>,
    /// Step between heights, metres, if all are whole numbers as stored; 0 if they are not.
    pub quantum_m: f64,
    /// True if the raster was joined from several files, which need not fill the grid.
    pub(super) is_joined: bool,
    pub warnings: Vec<Message>,
}

/// Factors of a raster's plane coordinates and of its heights.
struct PlaneAndHeight {
    plane: f64,
    height: f64,
}

/// Returns true if two units are nearly equal, as a foot by any two definitions is, and not metres.
fn is_same_foot(unit_m: f64, scale: f64) -> bool {
    unit_m != 1.0 && (scale / unit_m - 1.0).abs() < 0.01
}

/// Counts of samples that are taken as nodata though the file does not state it.
#[derive(Default)]
struct Doubtful {
    infinite: usize,
    usual: (usize, f32),
    beyond: (usize, f32),
}

/// Checks that a grid has 2 x 2 samples or more and not too many, before memory of its size is
/// allocated.
pub(crate) fn check_size(file: &Path, columns: u64, rows: u64) -> Result<usize> {
    if columns < 2 || rows < 2 {
        let what = format!("the raster has {columns} x {rows} samples");
        return Err(Error::input(file, None, what, "a surface needs at least 2 x 2"));
    }
    match columns.checked_mul(rows) {
        Some(samples) if samples <= MAX_SAMPLES => Ok(samples as usize),
        samples => Err(Error::Limit {
            what: format!("the number of samples of {} ({columns} x {rows})", file.display()).into(),
            value: samples.unwrap_or(u64::MAX),
            max: MAX_SAMPLES,
        }),
    }
}

impl Raster {
    /// Returns a raster of `columns` x `rows` stored numbers; those that are no heights become
    /// nodata.
    pub(crate) fn new(
        file: &Path,
        grid: Grid,
        mut heights: Vec<f32>,
        meaning: &Meaning,
        mut warnings: Vec<Message>,
    ) -> Result<Raster> {
        let samples = check_size(file, grid.columns as u64, grid.rows as u64)?;
        if heights.len() != samples {
            let what = format!("{} samples for {} x {}", heights.len(), grid.columns, grid.rows);
            return Err(Error::input(file, None, what, "export it again"));
        }
        check_grid(file, &grid)?;
        let unit_m = meaning.height_unit_m.unwrap_or(1.0);
        let (factor, shift) = (meaning.scale.unwrap_or(1.0) * unit_m, meaning.offset * unit_m);
        if !(factor.is_finite() && shift.is_finite() && factor != 0.0) {
            let what = format!("heights are stated as {} + {} times what is stored", meaning.offset, factor / unit_m);
            return Err(Error::input(
                file,
                None,
                what,
                "correct the scale and the offset of the band: `gdal_edit -scale -offset`",
            ));
        }
        let declared = meaning.nodata.map(|nodata| nodata as f32);
        let (mut doubtful, mut known) = (Doubtful::default(), 0_usize);
        let (mut least, mut greatest) = (f32::INFINITY, f32::NEG_INFINITY);
        let mut are_whole = true;
        for height in &mut heights {
            let metres = (f64::from(*height) * factor + shift) as f32;
            *height = match *height {
                // The number is NaN, or the one that stands for nodata.
                h if h.is_nan() || declared == Some(h) => f32::NAN,
                h if h.is_infinite() => doubtful.infinite(),
                h if declared.is_none() && USUAL_NODATA.contains(&h) => doubtful.usual(h),
                _ if !(EARTH_M[0]..=EARTH_M[1]).contains(&metres) => doubtful.beyond(metres),
                _ => {
                    known += 1;
                    are_whole &= height.fract() == 0.0;
                    (least, greatest) = (least.min(metres), greatest.max(metres));
                    metres
                }
            };
        }
        doubtful.warn(file, &mut warnings);
        if known == 0 {
            let what = format!("none of the {} samples is a height", heights.len());
            return Err(Error::input(file, None, what, "all are nodata: check the band and the nodata value"));
        }
        let extent = grid.step * DVec2::new(grid.columns as f64, grid.rows as f64);
        // Land in cells of less than 2 cm that is ten times as high as wide must be in degrees.
        if !meaning.projected
            && grid.step.max_element() < 0.02
            && f64::from(greatest - least) > 10.0 * extent.max_element()
        {
            return Err(degrees(
                file,
                &format!("its cells are {} wide and its heights span {}", grid.step.x, greatest - least),
            ));
        }
        Ok(Raster {
            grid,
            heights,
            reference: meaning.reference,
            plane_unit_m: meaning.plane_unit_m,
            height_unit_m: meaning.height_unit_m,
            quantum_m: if are_whole { factor.abs() } else { 0.0 },
            is_joined: false,
            warnings,
        })
    }

    /// Returns a raster of heights that are checked already; NaN is nodata.
    pub(crate) fn plain(grid: Grid, heights: Vec<f32>) -> Raster {
        Raster {
            grid,
            heights,
            reference: None,
            plane_unit_m: None,
            height_unit_m: None,
            quantum_m: 0.0,
            is_joined: false,
            warnings: Vec::new(),
        }
    }

    /// Returns the samples of some columns and rows; `None` for fewer than 2 x 2.
    pub(crate) fn cut(&self, columns: Range<usize>, rows: Range<usize>) -> Option<Raster> {
        let columns = columns.start..columns.end.min(self.grid.columns);
        let rows = rows.start..rows.end.min(self.grid.rows);
        let lines = self.heights.chunks(self.grid.columns).skip(rows.start).take(rows.len());
        let heights: Vec<f32> = lines.filter_map(|line| line.get(columns.clone())).flatten().copied().collect();
        let grid = Grid {
            columns: columns.len(),
            rows: rows.len(),
            first: self.plan(columns.start as i64, rows.start as i64),
            ..self.grid
        };
        let is_any = columns.len() > 1 && rows.len() > 1;
        is_any.then(|| Raster { grid, heights, warnings: Vec::new(), ..*self })
    }

    /// Returns the columns and rows whose samples lie between two corners in plan.
    pub(crate) fn window(&self, low: DVec2, high: DVec2) -> [Range<usize>; 2] {
        let from = (DVec2::new(low.x, high.y) - self.grid.first) / self.grid.step * DVec2::new(1.0, -1.0);
        let to = (DVec2::new(high.x, low.y) - self.grid.first) / self.grid.step * DVec2::new(1.0, -1.0);
        // The cast turns numbers below 0 into 0.
        [from.x.ceil() as usize..to.x.floor() as usize + 1, from.y.ceil() as usize..to.y.floor() as usize + 1]
    }

    /// Brings the raster to its place in the scene, whose coordinates are in `system` unless the
    /// file states another system.
    pub(crate) fn placed(mut self, part: &Part, frame: &SiteFrame, system: Option<Reference>) -> Result<Raster> {
        if part.up == Some(UpAxis::Y) {
            let hint = "leave up out: the values of a raster are heights, whatever axis points up elsewhere";
            return Err(Error::input(&part.file, None, "y up cannot be used for a raster", hint));
        }
        if part.rotate_deg != 0.0 {
            let hint = "leave rotate_deg out: rows of a raster run east, reproject it if they do not";
            return Err(Error::input(&part.file, None, "rotate_deg cannot be used for a raster", hint));
        }
        let (PlaneAndHeight { plane, height }, shift) = (self.factors(part, frame, system), part.shift());
        if !(plane > 0.0 && plane.is_finite() && height.is_finite() && shift.is_finite()) {
            let what = format!("the scale {plane} or the offset {shift} is not a valid number");
            return Err(Error::input(&part.file, None, what, "give metres a unit, above 0"));
        }
        if plane == 1.0 && height == 1.0 && shift == DVec3::ZERO {
            return Ok(self);
        }
        self.grid.first = self.grid.first * plane + shift.truncate();
        self.grid.step *= plane;
        self.quantum_m *= height.abs();
        for metres in &mut self.heights {
            *metres = (f64::from(*metres) * height + shift.z) as f32;
        }
        check_grid(&part.file, &self.grid)?;
        let highest = self.heights.iter().fold(0.0_f32, |most, h| most.max(h.abs()));
        if !is_position(DVec3::new(0.0, 0.0, f64::from(highest))) {
            let what = format!("offset and scale put a height at {highest}");
            return Err(Error::input(&part.file, None, what, "positions are metres, at most 1e9 in size"));
        }
        Ok(self)
    }

    /// Returns the factors of plane coordinates and heights, and adds warnings about decisions
    /// where the file states no unit.
    fn factors(&mut self, part: &Part, frame: &SiteFrame, system: Option<Reference>) -> PlaneAndHeight {
        let file = part.file.display();
        // A scale of the part counts where the file states no unit; converted coordinates are not
        // converted twice.
        if let Some(scale) = part.scale {
            let left =
                |stated: Option<f64>| if stated.is_some_and(|unit| is_same_foot(unit, scale)) { 1.0 } else { scale };
            let factors = PlaneAndHeight { plane: left(self.plane_unit_m), height: left(self.height_unit_m) };
            self.plane_unit_m = self.plane_unit_m.or(Some(scale));
            return factors;
        }
        let own = self.reference.is_some() || self.plane_unit_m.is_some();
        let feet = match (own, system) {
            (true, _) => self.plane_unit_m.filter(|unit| *unit != 1.0),
            (false, system) => system.map(Reference::unit_m).filter(|unit| *unit != 1.0),
        };
        let (Some(unit), scale) = (feet, frame.scale) else { return PlaneAndHeight { plane: 1.0, height: 1.0 } };
        let scale = scale.filter(|scale| is_same_foot(unit, *scale));
        let plane = scale.filter(|_| !own).unwrap_or(1.0);
        if plane != 1.0 {
            self.plane_unit_m = Some(plane);
            self.warnings.push(
                format!(
                    "{file}: names no coordinate system; it is read in the scene's system, in units of {plane:.7} m"
                )
                .into(),
            );
        }
        let height = scale.filter(|_| self.height_unit_m.is_none()).unwrap_or(1.0);
        if self.height_unit_m.is_none() && (own || scale.is_some()) {
            self.warnings.push(match scale {
                Some(scale) => format!("{file}: states no unit of its heights; they are read in units of {scale:.7} m, the stated scale").into(),
                None => message!(
                    "{file}: states no unit of its heights; they are read in metres: if they are feet like its coordinates, give \
                     {{scale}} {unit:.7}"
                ),
            });
        }
        PlaneAndHeight { plane, height }
    }

    pub(super) fn samples(&self) -> usize {
        self.heights.len()
    }

    /// Returns the height of a sample; NaN for nodata and beyond the edges.
    #[inline]
    pub(crate) fn height(&self, column: i64, row: i64) -> f32 {
        let (Ok(column), Ok(row)) = (usize::try_from(column), usize::try_from(row)) else { return f32::NAN };
        if column >= self.grid.columns {
            return f32::NAN;
        }
        self.heights.get(row * self.grid.columns + column).copied().unwrap_or(f32::NAN)
    }

    /// Returns the heights of a part of a row; empty if the part leaves the raster.
    #[inline]
    pub(super) fn row(&self, row: i64, columns: std::ops::RangeInclusive<i64>) -> &[f32] {
        let (Ok(row), Ok(from), Ok(to)) =
            (usize::try_from(row), usize::try_from(*columns.start()), usize::try_from(*columns.end()))
        else {
            return &[];
        };
        if to >= self.grid.columns {
            return &[];
        }
        self.heights.get(row * self.grid.columns + from..=row * self.grid.columns + to).unwrap_or_default()
    }

    /// Returns the position of a sample in plan.
    #[inline]
    pub(crate) fn plan(&self, column: i64, row: i64) -> DVec2 {
        self.grid.first + DVec2::new(column as f64, -(row as f64)) * self.grid.step
    }

    /// Returns the least and the greatest corner of the samples in plan.
    pub(crate) fn bounds(&self) -> (DVec2, DVec2) {
        let (last_column, last_row) = (self.grid.columns as i64 - 1, self.grid.rows as i64 - 1);
        (self.plan(0, last_row), self.plan(last_column, 0))
    }

    /// Returns the lowest and the highest corner of the samples, of which at least one is known.
    pub(crate) fn extent(&self) -> [DVec3; 2] {
        let (low, high) = self.bounds();
        // `min` and `max` skip NaN.
        let heights = self.heights.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), h| (a.min(*h), b.max(*h)));
        [low.extend(f64::from(heights.0)), high.extend(f64::from(heights.1))]
    }

    /// Lowers every sample by the depth that `drop_m` returns for its position.
    pub(super) fn lower(&mut self, drop_m: impl Fn(DVec2) -> f64) {
        let (columns, grid) = (self.grid.columns, self.grid);
        for (row, heights) in self.heights.chunks_mut(columns).enumerate() {
            for (column, height) in heights.iter_mut().enumerate() {
                let place = grid.first + DVec2::new(column as f64, -(row as f64)) * grid.step;
                *height = (f64::from(*height) - drop_m(place)) as f32;
            }
        }
    }
}

/// Returns the error for a raster whose coordinates are longitude and latitude.
pub(crate) fn degrees(file: &Path, why: &str) -> Error {
    let hint = "reproject it to metres, for example `gdalwarp -t_srs EPSG:32632 -r bilinear in.tif out.tif` with the zone of the place";
    Error::input(file, None, format!("the raster is in degrees: {why}"), hint)
}

/// Returns the error for a raster whose coordinates are distances from the Earth's centre.
pub(crate) fn geocentric(file: &Path, why: &str) -> Error {
    let hint = "reproject it to metres, for example `gdalwarp -t_srs EPSG:32632 -r bilinear in.tif out.tif` with the zone of the place";
    Error::input(file, None, format!("the raster is geocentric: {why}"), hint)
}

fn check_grid(file: &Path, grid: &Grid) -> Result<()> {
    let far = DVec2::new(grid.columns as f64, -(grid.rows as f64)) * grid.step + grid.first;
    let steps = grid.step.is_finite() && grid.step.min_element() > 0.0;
    if !steps || !is_position(grid.first.extend(0.0)) || !is_position(far.extend(0.0)) {
        let what = format!("the samples begin at {} and lie {} apart", grid.first, grid.step);
        let hint = "georeference it in metres: steps above 0, coordinates at most 1e9 in size";
        return Err(Error::input(file, None, what, hint));
    }
    Ok(())
}

impl Doubtful {
    fn infinite(&mut self) -> f32 {
        self.infinite += 1;
        f32::NAN
    }

    fn usual(&mut self, value: f32) -> f32 {
        self.usual = (self.usual.0 + 1, value);
        f32::NAN
    }

    fn beyond(&mut self, metres: f32) -> f32 {
        if self.beyond.0 == 0 {
            self.beyond.1 = metres;
        }
        self.beyond.0 += 1;
        f32::NAN
    }

    fn warn(&self, file: &Path, warnings: &mut Vec<Message>) {
        let file = file.display();
        if self.infinite > 0 {
            warnings.push(format!("{file}: {} samples are infinite and taken as nodata", self.infinite).into());
        }
        if self.usual.0 > 0 {
            let (count, value) = self.usual;
            warnings.push(
                format!("{file}: {count} samples of {value} are taken as nodata, though the file declares none").into(),
            );
        }
        if self.beyond.0 > 0 {
            let (count, first) = self.beyond;
            let [low, high] = EARTH_M;
            warnings.push(format!(
                "{file}: {count} samples are beyond the Earth's heights ({low} to {high} m; the first is {first}) and taken as nodata"
            ).into());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raster(heights: &[f32], meaning: &Meaning) -> Result<Raster> {
        let grid = Grid { columns: 3, rows: 2, first: DVec2::ZERO, step: DVec2::ONE };
        Raster::new(Path::new("r"), grid, heights.to_vec(), meaning, Vec::new())
    }

    /// A sample of -9999, -32768, 3.4e38, NaN or infinity is nodata, declared or not. A warning
    /// counts it unless it is NaN or declared.
    #[test]
    fn invalid_samples_are_nodata_and_counted() {
        let bad = [-9999.0, -32768.0, 3.4e38, f32::NAN, f32::INFINITY];
        for (i, value) in bad.into_iter().enumerate() {
            for declared in [None, Some(f64::from(value))] {
                let found =
                    raster(&[5.0, value, 7.0, 8.0, 9.0, 10.0], &Meaning { nodata: declared, ..Meaning::default() });
                let found = found.expect("five heights");
                assert!(found.height(1, 0).is_nan() && found.heights.iter().filter(|h| h.is_finite()).count() == 5);
                let quiet = value.is_nan() || declared.is_some();
                assert_eq!(found.warnings.len(), usize::from(!quiet), "{i} {declared:?} {:?}", found.warnings);
            }
        }
        let message = raster(&[-9999.0; 6], &Meaning::default()).expect_err("nothing known").to_string();
        assert!(message.contains("none of the 6 samples is a height"), "{message}");
    }

    /// A window from 0.9 to 2.1 m eastwards on 3 x 2 samples 1 m apart holds the last two columns,
    /// whose heights are 7, 9 and 20, 30.
    #[test]
    fn a_window_holds_the_samples_it_touches() {
        let whole = raster(&[5.0, 7.0, 9.0, 10.0, 20.0, 30.0], &Meaning::default()).expect("heights");
        let [columns, rows] = whole.window(DVec2::new(0.9, -5.0), DVec2::new(2.1, 0.0));
        let part = whole.cut(columns, rows).expect("a part");
        assert_eq!((part.heights.as_slice(), part.grid.first), (&[7.0, 9.0, 20.0, 30.0][..], DVec2::X));
        let [columns, rows] = whole.window(DVec2::new(5.0, -5.0), DVec2::new(9.0, 0.0));
        assert!(whole.cut(columns, rows).is_none());
    }

    /// Feet become metres: 1000 ft are 304.8 m.
    #[test]
    fn heights_in_feet_become_metres() {
        let found =
            raster(&[1000.0; 6], &Meaning { height_unit_m: Some(0.3048), ..Meaning::default() }).expect("heights");
        assert!((found.height(2, 1) - 304.8).abs() < 1e-3);
        assert!(found.height(3, 0).is_nan() && found.height(0, 2).is_nan() && found.height(-1, 0).is_nan());
    }
}
