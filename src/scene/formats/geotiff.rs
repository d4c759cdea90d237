//! In: the bytes of a GeoTIFF (OGC 19-008r4 "GeoTIFF 1.1" over TIFF 6.0 or BigTIFF). Out: the heights of its first band. Samples are
//! decoded by the crate `tiff`, a strip or tile at a time; what the file claims of its size is checked before.

use std::io::Cursor;
use std::path::Path;

use glam::DVec2;
use tiff::TiffError;
use tiff::decoder::{ChunkType, Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use crate::formats::geokeys::GeoKeys;
use crate::formats::tiff_directory;
use crate::terrain::raster::{Grid, Meaning, Raster, check_size};
use crate::text::excerpt;
use heliotile_core::error::{Error, Result};

/// Most bytes that a strip or tile may unpack to, and the most that the crate may allocate at once.
const MAX_CHUNK: usize = 1 << 28;

/// No byte of Deflate (1032) or LZW (some 2500) unpacks to more samples than this: a claim beyond is refused unread.
const MOST_PACKED: u64 = 4096;

type Tiff<'b> = Decoder<Cursor<&'b [u8]>>;

pub(crate) fn parse(bytes: &[u8], file: &Path) -> Result<Raster> {
    let bad = |doing: &'static str| move |e: TiffError| refused(file, doing, &e);
    let cut = "the file is damaged or cut off: fetch or export it again";
    tiff_directory::check(bytes).map_err(|what| Error::input(file, None, what, cut))?;
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MAX_CHUNK;
    limits.intermediate_buffer_size = MAX_CHUNK;
    let mut tiff = Decoder::new(Cursor::new(bytes)).map_err(bad("its header"))?.with_limits(limits);
    let (columns, rows) = tiff.dimensions().map_err(bad("its size"))?;
    let samples = check_size(file, columns.into(), rows.into())?;
    if samples as u64 > bytes.len() as u64 * MOST_PACKED {
        let what = format!("{columns} x {rows} samples are claimed in {} bytes", bytes.len());
        return Err(Error::input(file, None, what, "the file is damaged or cut off: fetch it again"));
    }
    let mut warnings = Vec::new();
    let (grid, mut meaning) = georeference(&mut tiff, file, [columns, rows], &mut warnings)?;
    meaning.nodata = nodata(&mut tiff, file, &mut warnings);
    let heights = first_band(&mut tiff, file, samples, &mut warnings)?;
    Raster::new(file, grid, heights, &meaning, warnings)
}

fn refused(file: &Path, doing: &str, error: &TiffError) -> Error {
    let problem = error.to_string();
    let why = excerpt(problem.as_bytes());
    match error {
        TiffError::UnsupportedError(_) => Error::Unsupported {
            what: format!("the raster {}", file.display()),
            found: why,
            supported: "16, 32 and 64 bit integers and 32 and 64 bit floats, raw, Deflate, LZW or PackBits; \
                        `gdal_translate -co COMPRESS=DEFLATE in.tif out.tif` writes that"
                .into(),
        },
        TiffError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
            let hint = "the file is cut off or no TIFF: fetch or export it again";
            Error::input(file, None, format!("the file ends within {doing}"), hint)
        }
        _ => Error::input(file, None, format!("{doing} cannot be read: {why}"), "export it again as GeoTIFF"),
    }
}

fn nodata(tiff: &mut Tiff, file: &Path, warnings: &mut Vec<String>) -> Option<f64> {
    let text = match tiff.find_tag(Tag::GdalNodata) {
        Ok(None) => return None,
        Ok(Some(value)) => value.into_string().unwrap_or_default(),
        Err(_) => String::new(),
    };
    let word = text.trim_matches(|c: char| c.is_whitespace() || c == '\0');
    let number = word.parse().ok();
    if number.is_none() {
        let shown = excerpt(word.as_bytes());
        warnings.push(format!("{}: the nodata value `{shown}` is not a number and ignored", file.display()));
    }
    number
}

/// Where the samples lie, and what their numbers are.
fn georeference(
    tiff: &mut Tiff,
    file: &Path,
    [columns, rows]: [u32; 2],
    warnings: &mut Vec<String>,
) -> Result<(Grid, Meaning)> {
    let mut doubles = |tag: Tag| -> Vec<f64> {
        let found = tiff.find_tag(tag).ok().flatten();
        found.and_then(|value| value.into_f64_vec().ok()).unwrap_or_default()
    };
    let (scale, ties) = (doubles(Tag::ModelPixelScaleTag), doubles(Tag::ModelTiepointTag));
    let transformation = doubles(Tag::ModelTransformationTag);
    let refuse = |what: &str, hint: &str| Err(Error::input(file, None, what, hint));
    // Both ways lead to the position of the corner (or sample) 0, 0 and a step eastwards and southwards.
    let (first, step) = match (scale.as_slice(), ties.as_slice(), transformation.as_slice()) {
        ([sx, sy, ..], [i, j, _, x, y, _, ..], _) => {
            let step = DVec2::new(*sx, *sy);
            (DVec2::new(x - i * step.x, y + j * step.y), step)
        }
        (_, _, [a, b, _, x, d, e, _, y, ..]) => {
            if b.abs() > 1e-9 * a.abs() || d.abs() > 1e-9 * e.abs() || *a <= 0.0 || *e >= 0.0 {
                return refuse(
                    "the raster is rotated or mirrored (tag 34264, ModelTransformation)",
                    "warp it to north up: `gdalwarp in.tif out.tif`",
                );
            }
            (DVec2::new(*x, *y), DVec2::new(*a, -*e))
        }
        ([_, _, ..], _, _) => {
            return refuse(
                "the raster has no ModelTiepoint (tag 33922): nobody says where it lies",
                "georeference it, for example with `gdal_translate -a_ullr`",
            );
        }
        _ => {
            return refuse(
                "the raster has neither ModelPixelScale (tag 33550) nor ModelTransformation (34264): nobody says where it lies",
                "georeference it, for example with `gdal_translate -a_srs EPSG:32632 -a_ullr west north east south`",
            );
        }
    };
    let directory = tiff.find_tag_unsigned_vec(Tag::GeoKeyDirectoryTag).ok().flatten().unwrap_or_default();
    let keys = GeoKeys::read(&directory);
    let meaning = keys.meaning(file, warnings)?;
    let plane = keys.metres_in_plane();
    // A sample stands for its cell, whose corner is meant, unless it is a point.
    let first = if keys.samples_are_points() { first } else { first + DVec2::new(0.5, -0.5) * step };
    let grid = Grid { columns: columns as usize, rows: rows as usize, first: first * plane, step: step * plane };
    Ok((grid, meaning))
}

/// Samples of the first band, whatever the file's number format.
fn first_band(tiff: &mut Tiff, file: &Path, samples: usize, warnings: &mut Vec<String>) -> Result<Vec<f32>> {
    let bad = |e: TiffError| refused(file, "its samples", &e);
    let (columns, rows) = tiff.dimensions().map_err(bad)?;
    // White as zero turns numbers around; `tiff` would, and no height is meant so.
    if tiff.find_tag_unsigned::<u16>(Tag::PhotometricInterpretation).ok().flatten() == Some(0) {
        let what = "its samples are stated as white at 0 (tag 262)";
        return Err(Error::input(file, None, what, "export it as GeoTIFF of heights"));
    }
    let bands = tiff.colortype().map_err(bad)?.num_samples();
    if bands > 1 {
        warnings.push(format!("{}: the first of {bands} bands is taken for heights", file.display()));
    }
    let planar = tiff.find_tag_unsigned::<u16>(Tag::PlanarConfiguration).ok().flatten() == Some(2);
    let between = if planar { 1 } else { usize::from(bands).max(1) };
    let tag = match tiff.get_chunk_type() {
        ChunkType::Strip => Tag::StripByteCounts,
        ChunkType::Tile => Tag::TileByteCounts,
    };
    let counts: Vec<u64> = tiff.find_tag_unsigned_vec(tag).ok().flatten().unwrap_or_default();
    let (wide, high) = tiff.chunk_dimensions();
    let (across, down) = (columns.div_ceil(wide.max(1)), rows.div_ceil(high.max(1)));
    if wide == 0 || high == 0 || (counts.len() as u64) < u64::from(across) * u64::from(down) {
        let what = format!("{} strips or tiles are fewer than {across} x {down}", counts.len());
        return Err(Error::input(file, None, what, "the file is damaged: fetch or export it again"));
    }
    let mut heights = vec![f32::NAN; samples];
    for (chunk, &bytes) in (0..across * down).zip(&counts) {
        // GDAL leaves tiles without any data out of the file ("sparse").
        if bytes == 0 {
            continue;
        }
        let decoded = tiff.read_chunk(chunk).map_err(bad)?;
        let (width, height) = tiff.chunk_data_dimensions(chunk);
        let from = (chunk / across * high) as usize * columns as usize + (chunk % across * wide) as usize;
        for line in 0..height as usize {
            let start = from + line * columns as usize;
            let to = heights.get_mut(start..start + width as usize).unwrap_or_default();
            copy(to, &decoded, line * width as usize * between, between);
        }
    }
    Ok(heights)
}

/// Copies one line of a chunk, a sample in every `between`.
fn copy(to: &mut [f32], decoded: &DecodingResult, from: usize, between: usize) {
    fn each<T: Copy>(to: &mut [f32], all: &[T], from: usize, between: usize, height: impl Fn(T) -> f32) {
        let line = all.get(from..).unwrap_or_default();
        for (to, &value) in to.iter_mut().zip(line.iter().step_by(between)) {
            *to = height(value);
        }
    }
    match decoded {
        DecodingResult::U8(all) => each(to, all, from, between, f32::from),
        DecodingResult::I8(all) => each(to, all, from, between, f32::from),
        DecodingResult::U16(all) => each(to, all, from, between, f32::from),
        DecodingResult::I16(all) => each(to, all, from, between, f32::from),
        DecodingResult::U32(all) => each(to, all, from, between, |v| v as f32),
        DecodingResult::I32(all) => each(to, all, from, between, |v| v as f32),
        DecodingResult::U64(all) => each(to, all, from, between, |v| v as f32),
        DecodingResult::I64(all) => each(to, all, from, between, |v| v as f32),
        DecodingResult::F16(all) => each(to, all, from, between, f32::from),
        DecodingResult::F32(all) => each(to, all, from, between, |v| v),
        DecodingResult::F64(all) => each(to, all, from, between, |v| v as f32),
    }
}

#[cfg(test)]
#[path = "geotiff_tests.rs"]
mod tests;
