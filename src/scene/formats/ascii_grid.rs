//! In: the bytes of an Esri ASCII grid (ArcGIS "Esri ASCII raster format"; GDAL's AAIGrid). Out:
//! its heights.

use std::path::Path;

use glam::DVec2;

use crate::formats::sidecar;
use crate::terrain::raster::{Grid, Meaning, Raster, check_size};
use crate::text::{excerpt, line_of_offset, without_byte_order_mark};
use heliotile_core::error::{Error, Result};

const HEADER: &str = "write ncols, nrows, xllcorner (or xllcenter), yllcorner (or yllcenter), cellsize and NODATA_value, then the heights";

/// Header values by key, each with the byte offset of its key.
#[derive(Default)]
struct Header {
    entries: Vec<(&'static str, f64, usize)>,
}

const KEYS: [&str; 10] =
    ["ncols", "nrows", "xllcorner", "xllcenter", "yllcorner", "yllcenter", "cellsize", "dx", "dy", "nodata_value"];

impl Header {
    fn get(&self, key: &str) -> Option<f64> {
        self.entries.iter().find(|entry| entry.0 == key).map(|entry| entry.1)
    }
}

pub(crate) fn parse(bytes: &[u8], file: &Path) -> Result<Raster> {
    if let Some(other) = other_kind(bytes) {
        return Err(Error::Unsupported {
            what: format!("the terrain {}", file.display()).into(),
            found: other.into(),
            supported:
                "Esri ASCII grids, which begin with ncols, and GeoTIFF: `gdal_translate in.dem out.tif` makes one"
                    .into(),
        });
    }
    let mut words = Offsets { bytes: without_byte_order_mark(bytes), at: 0 };
    let refuse = |what: String| Error::input(file, None, what, HEADER);
    let mut header = Header::default();
    while let Some((word, at)) = words.peek() {
        let line = || line_of_offset(words.bytes, at);
        if !word.first().is_some_and(u8::is_ascii_alphabetic) || is_nan(word) {
            break;
        }
        let Some(&key) = KEYS.iter().find(|key| key.as_bytes().eq_ignore_ascii_case(word)) else {
            return Err(Error::input(
                file,
                line(),
                format!("`{}` is not a header key of an ASCII grid", excerpt(word)),
                HEADER,
            ));
        };
        if header.get(key).is_some() {
            return Err(Error::input(file, line(), format!("{key} is stated twice"), HEADER));
        }
        words.next();
        let value = words.next().map(|(word, _)| word).unwrap_or_default();
        // "nan" and "inf" are allowed for nodata only.
        let number = number(value).filter(|n| key == "nodata_value" || n.is_finite());
        let Some(number) = number else {
            return Err(Error::input(file, line(), format!("{key} is `{}`, not a number", excerpt(value)), HEADER));
        };
        header.entries.push((key, number, at));
    }
    let missing = |key: &str| refuse(format!("the grid has no {key}"));
    let count = |key: &str| -> Result<u64> {
        let value = header.get(key).ok_or_else(|| missing(key))?;
        // Below 2^53 an f64 holds every whole number, so the cast keeps the value.
        if value < 0.0 || value.fract() != 0.0 || value > 1e15 {
            return Err(refuse(format!("{key} is {value}, not a count of samples")));
        }
        Ok(value as u64)
    };
    let (columns, rows) = (count("ncols")?, count("nrows")?);
    let samples = check_size(file, columns, rows)?;
    let step = |key: &str| header.get(key).or_else(|| header.get("cellsize")).ok_or_else(|| missing("cellsize"));
    let step = DVec2::new(step("dx")?, step("dy")?);
    if step.min_element() <= 0.0 {
        return Err(refuse(format!("the cell size is {} x {}, but must be above 0", step.x, step.y)));
    }
    let least = |corner: &str, center: &str, step: f64| {
        header.get(center).or_else(|| header.get(corner).map(|at| at + step / 2.0)).ok_or_else(|| missing(corner))
    };
    let south_west = DVec2::new(least("xllcorner", "xllcenter", step.x)?, least("yllcorner", "yllcenter", step.y)?);
    let first = south_west + DVec2::new(0.0, step.y * (rows - 1) as f64);
    let heights = heights(&mut words, samples, file, [columns, rows])?;
    let grid = Grid { columns: columns as usize, rows: rows as usize, first, step };
    let (mut meaning, mut warnings) =
        (Meaning { nodata: header.get("nodata_value"), ..Meaning::default() }, Vec::new());
    sidecar::complete(&mut meaning, file, &sidecar::aux(file)?, &mut warnings)?;
    let plane = meaning.plane_unit_m.unwrap_or(1.0);
    let grid = Grid { first: grid.first * plane, step: grid.step * plane, ..grid };
    Raster::new(file, grid, heights, &meaning, warnings)
}

/// Returns the name of another format that uses the ending `.dem`, if the bytes are one. A USGS DEM
/// has whole numbers in columns 145 to 162: level, pattern (1 is a grid) and reference system (U.S.
/// Geological Survey, Standards for Digital Elevation Models, part 2, 1998, record A).
fn other_kind(bytes: &[u8]) -> Option<&'static str> {
    let head = bytes.get(..1024).unwrap_or(bytes);
    let (first, _) = Offsets { bytes: without_byte_order_mark(head), at: 0 }.next()?;
    if KEYS.iter().any(|key| key.as_bytes().eq_ignore_ascii_case(first)) {
        return None;
    }
    if head.contains(&0) {
        return Some("binary data, such as the raw heights of GTOPO30");
    }
    let small = |columns| {
        let text = std::str::from_utf8(head.get(columns)?).ok()?;
        text.trim().parse::<u8>().ok()
    };
    [144..150, 150..156, 156..162].into_iter().all(|columns| small(columns).is_some()).then_some("a USGS DEM")
}

fn heights(words: &mut Offsets, samples: usize, file: &Path, [columns, rows]: [u64; 2]) -> Result<Vec<f32>> {
    // A height and the blank behind it take at least two bytes, which bounds the allocation.
    let mut heights = Vec::with_capacity(samples.min(words.bytes.len() / 2 + 1));
    while let Some((word, at)) = words.next() {
        let Some(height) = number(word) else {
            let what = format!("`{}` is not a height", excerpt(word));
            let hint = "write heights as decimal numbers with a point, separated by blanks";
            return Err(Error::input(file, line_of_offset(words.bytes, at), what, hint));
        };
        if heights.len() == samples {
            let what = format!("the file holds more than the {samples} heights of {columns} x {rows} samples");
            return Err(Error::input(file, line_of_offset(words.bytes, at), what, "correct ncols and nrows"));
        }
        heights.push(height as f32);
    }
    if heights.len() < samples {
        let what =
            format!("the file holds only {} of the {samples} heights of {columns} x {rows} samples", heights.len());
        return Err(Error::input(file, None, what, "export or download the file again: it may be cut off"));
    }
    Ok(heights)
}

fn is_nan(word: &[u8]) -> bool {
    number(word).is_some()
}

fn number(word: &[u8]) -> Option<f64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Iterator over words between blanks, with the offset of each.
struct Offsets<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Offsets<'a> {
    fn peek(&self) -> Option<(&'a [u8], usize)> {
        Offsets { ..*self }.next()
    }

    #[inline]
    fn next(&mut self) -> Option<(&'a [u8], usize)> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let blank = |byte: &u8| byte.is_ascii_whitespace();
        let start = self.at + rest.iter().position(|byte| !blank(byte))?;
        let rest = self.bytes.get(start..).unwrap_or_default();
        let end = start + rest.iter().position(blank).unwrap_or(rest.len());
        self.at = end;
        self.bytes.get(start..end).map(|word| (word, start))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 10\n";

    fn message(text: &str) -> String {
        parse(text.as_bytes(), Path::new("g.asc")).expect_err(text).to_string()
    }

    /// The south-west corner 100, 200 of 10 m cells puts the first of 6 samples at 105, 215. Keys
    /// in any case, values over any lines, centres instead of corners, and `dx` with `dy` give the
    /// same grid.
    #[test]
    fn spellings_of_the_header_give_the_same_grid() {
        let read = |text: &str| parse(text.as_bytes(), Path::new("g.asc")).expect("a grid");
        let plain = read(&format!("{HEAD}NODATA_value -9999\n1 2 3\n4 5 -9999\n"));
        assert_eq!(plain.grid, Grid { columns: 3, rows: 2, first: DVec2::new(105.0, 215.0), step: DVec2::splat(10.0) });
        let other = read(
            "NROWS 2 NCOLS 3\r\nXLLCENTER 105\r\nYLLCENTER 205\r\ndx 10 dy 10\r\nnodata_value nan\r\n1\r\n2 3 4 5\r\n\r\nnan",
        );
        assert_eq!(other.grid, plain.grid);
        for raster in [&plain, &other] {
            let found: Vec<f32> = (0..6).map(|i| raster.height(i % 3, i / 3)).collect();
            assert_eq!(found.get(..5), Some(&[1.0, 2.0, 3.0, 4.0, 5.0][..]));
            assert!(found.get(5).is_some_and(|h| h.is_nan()) && raster.warnings.is_empty());
        }
    }

    /// Other files named `.dem` are recognised by their bytes, 2 of 2: a USGS DEM by its columns,
    /// raw heights by their zeros. A grid with whole numbers in those columns is read.
    #[test]
    fn other_formats_named_dem_are_recognised() {
        let usgs = format!("{:<40}{:<104}{:>6}{:>6}{:>6}{:>6}", "MT WASHINGTON, NH", "BIG BASIN", 1, 1, 1, 19);
        for (bytes, expected) in [(usgs.as_bytes(), "found a USGS DEM"), (&[0, 7, 0, 9][..], "raw heights of GTOPO30")]
        {
            let found = parse(bytes, Path::new("g.dem")).expect_err(expected).to_string();
            assert!(found.contains(expected) && found.contains("gdal_translate in.dem out.tif"), "{found}");
        }
        let wide = format!("{:<144}{:>6}{:>6}{:>6} 4 5 6\n", HEAD.replace('\n', " "), 1, 2, 3);
        assert_eq!(parse(wide.as_bytes(), Path::new("g.dem")).expect("a grid").height(2, 1), 6.0);
    }

    /// Twelve damaged files are refused with a message of what was found; where a value is at
    /// fault, the message names its line.
    #[test]
    fn damaged_files_are_refused_with_a_reason() {
        let body = "1 2 3\n4 5 6\n";
        for (text, expected) in [
            (String::new(), "the grid has no ncols"),
            (format!("{}{body}", HEAD.replace("nrows 2\n", "")), "the grid has no nrows"),
            (format!("{}{body}", HEAD.replace("cellsize 10\n", "")), "the grid has no cellsize"),
            (format!("{}{body}", HEAD.replace("yllcorner 200\n", "")), "the grid has no yllcorner"),
            (format!("{HEAD}1 2 3\n4 5\n"), "only 5 of the 6 heights of 3 x 2"),
            (format!("{HEAD}1 2 3\n4 5 6\n7"), "line 8: the file holds more than the 6 heights"),
            (format!("{HEAD}1 2 3\n4 x5 6\n"), "line 7: `x5` is not a height"),
            (
                format!("{}{body}", HEAD.replace("cellsize 10", "cellsize -10")),
                "the cell size is -10 x -10, but must be above 0",
            ),
            (format!("{}{body}", HEAD.replace("ncols 3", "ncols 1e14")), "the limit is 268435456"),
            (format!("{}{body}", HEAD.replace("ncols 3", "ncols 1")), "the raster has 1 x 2 samples"),
            (format!("{HEAD}NODATA_value none\n{body}"), "line 6: nodata_value is `none`, not a number"),
            (format!("{HEAD}colour 7\n{body}"), "line 6: `colour` is not a header key"),
            (format!("{HEAD}-9999 -9999 -9999 nan inf 1e30"), "none of the 6 samples is a height"),
            (
                "ncols 2 nrows 2 xllcorner 11.5 yllcorner 47.5 cellsize 0.000833 700 800 900 650".into(),
                "the raster is in degrees",
            ),
        ] {
            let found = message(&text);
            assert!(found.contains(expected), "{found}\nin place of {expected}");
        }
        // The file claims 250 million samples; nothing of that size is allocated.
        assert!(message(&format!("{HEAD}1").replace("ncols 3", "ncols 125000000")).contains("only 1 of the 250000000"));
    }
}
