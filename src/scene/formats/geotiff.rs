//! In: the bytes of a GeoTIFF (OGC 19-008r4 "GeoTIFF 1.1" over TIFF 6.0 or BigTIFF). Out: the
//! heights of its first band; samples that a mask or an opacity band hides are nodata.
//!
//! The crate `tiff` decodes samples, one strip or tile at a time. The size that the file claims is
//! checked before.

use std::io;
use std::io::{Cursor, Read, Seek, SeekFrom};
use std::path::Path;

use glam::DVec2;
use tiff::decoder::{ChunkType, Decoder, DecodingResult, Limits};
use tiff::tags::{CompressionMethod, Tag};
use tiff::{TiffError, TiffUnsupportedError};

use crate::formats::gdal_metadata::{AuxNotes, BandNotes, metres_of_unit};
use crate::formats::geokeys::GeoKeys;
use crate::formats::sidecar;
use crate::formats::tiff_directory;
use crate::formats::tiff_directory::{Patch, Patches};
use crate::terrain::raster::{Grid, Meaning, Raster, check_size};
use crate::text::excerpt;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::Message;

/// Most bytes that a strip or tile may unpack to, and most that the crate may allocate at once.
const MAX_CHUNK: usize = 1 << 28;

/// Tag in which GDAL stores XML about the bands.
const GDAL_METADATA: u16 = 42112;

/// Most samples that a packed byte may unpack to: a file that claims more is refused unread. A byte
/// of Deflate yields at most 1032 bytes, of LZW some 2500; Zstandard has the higher limit below (4
/// bytes for a block of 128 KiB).
const MAX_PACKED: u64 = 4096;
const MAX_PACKED_ZSTD: u64 = 1 << 15;

/// GDAL's code of Zstandard in the compression tag.
const ZSTD: u16 = 50_000;

/// Ways to pack samples that are not read, by their codes in the compression tag (259): TIFF 6.0,
/// its supplements, and the registry of libtiff (`tiff.h`).
const UNREAD_COMPRESSIONS: [(u16, &str); 25] = [
    (2, "CCITT RLE"),
    (3, "CCITT Group 3 (fax)"),
    (4, "CCITT Group 4 (fax)"),
    (6, "JPEG of TIFF 6.0"),
    (7, "JPEG"),
    (9, "JBIG (T.85)"),
    (10, "JBIG (T.43)"),
    (32_766, "NeXT"),
    (32_771, "CCITT RLE in words"),
    (32_809, "ThunderScan"),
    (32_908, "PixarFilm"),
    (32_909, "PixarLog"),
    (33_003, "JPEG 2000 (Aperio)"),
    (33_004, "JPEG 2000 (Aperio)"),
    (33_005, "JPEG 2000 (Aperio)"),
    (34_661, "JBIG"),
    (34_676, "SGILog"),
    (34_677, "SGILog24"),
    (34_712, "JPEG 2000"),
    (34_887, "LERC"),
    (34_892, "JPEG of DNG"),
    (34_925, "LZMA"),
    (50_001, "WebP"),
    (50_002, "JPEG XL"),
    (52_546, "JPEG XL of DNG"),
];

/// Reader of a TIFF file that replaces some bytes and appends zeros, because the decoder needs
/// them.
struct Patched<'b> {
    inner: Cursor<&'b [u8]>,
    patches: Patches,
}

type Tiff<'b> = Decoder<Patched<'b>>;

impl Read for Patched<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let start = self.inner.position();
        let mut count = self.inner.read(buffer)?;
        let end = self.inner.get_ref().len() as u64 + self.patches.zeros;
        // Behind the end of the file the decoder reads the appended zeros.
        if count == 0 && start < end {
            count = buffer.len().min((end - start) as usize);
            buffer.iter_mut().take(count).for_each(|byte| *byte = 0);
            self.inner.set_position(start + count as u64);
        }
        for Patch { at, bytes } in &self.patches.list {
            let (from, to) = (start.max(*at), (start + count as u64).min(at + bytes.len() as u64));
            if from < to
                && let Some(into) = buffer.get_mut((from - start) as usize..(to - start) as usize)
                && let Some(of) = bytes.get((from - at) as usize..(to - at) as usize)
            {
                into.copy_from_slice(of);
            }
        }
        Ok(count)
    }
}

impl Seek for Patched<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.inner.seek(to)
    }
}

fn open<'b>(bytes: &'b [u8], patches: Patches, file: &Path) -> Result<Tiff<'b>> {
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MAX_CHUNK;
    limits.intermediate_buffer_size = MAX_CHUNK;
    let tiff = Decoder::new(Patched { inner: Cursor::new(bytes), patches });
    Ok(tiff.map_err(|e| refused(file, "its header", &e))?.with_limits(limits))
}

pub(crate) fn parse(bytes: &[u8], file: &Path) -> Result<Raster> {
    let bad = |doing: &'static str| move |e: TiffError| refused(file, doing, &e);
    let cut = "download or export the file again: it is damaged or cut off";
    let patches = tiff_directory::check(bytes).map_err(|what| Error::input(file, None, what, cut))?;
    let mut tiff = open(bytes, patches, file)?;
    let (columns, rows) = tiff.dimensions().map_err(bad("its size"))?;
    let samples = check_size(file, columns.into(), rows.into())?;
    let is_zstd = tiff.find_tag_unsigned::<u16>(Tag::Compression).ok().flatten() == Some(ZSTD);
    // An impossible claim is refused before anything of its size is allocated.
    if samples as u64 > bytes.len() as u64 * if is_zstd { MAX_PACKED_ZSTD } else { MAX_PACKED } {
        let what = format!("the header states {columns} x {rows} samples, more than {} bytes can hold", bytes.len());
        return Err(Error::input(file, None, what, cut));
    }
    let mut warnings = Vec::new();
    let aux = sidecar::aux(file)?;
    let (grid, mut meaning) = georeference(&mut tiff, file, &aux, &mut warnings)?;
    let notes = BandNotes::of_tag(&text_of(&mut tiff, Tag::Unknown(GDAL_METADATA)));
    let notes = notes.or(aux.band);
    meaning.nodata = nodata(&mut tiff, file, &mut warnings).or(notes.nodata);
    (meaning.scale, meaning.offset) = (notes.scale, notes.offset.unwrap_or_default());
    if let Some(unit) = &notes.unit {
        let metres = metres_of_unit(unit);
        if metres.is_none() {
            let (file, unit) = (file.display(), excerpt(unit.as_bytes()));
            warnings
                .push(format!("{file}: the unit of the heights, `{unit}`, is not known; metres are assumed").into());
        }
        meaning.height_unit_m = metres.or(meaning.height_unit_m);
    }
    let mut heights = first_band(&mut tiff, file, samples, &mut warnings)?;
    let mask = tiff_directory::mask(bytes).map_err(|what| Error::input(file, None, what, cut))?;
    if let Some(mask) = mask {
        let mut tiff = open(bytes, mask, file)?;
        hide(&mut heights, &band(&mut tiff, file, 0, samples)?);
    }
    Raster::new(file, grid, heights, &meaning, warnings)
}

/// Makes samples nodata whose mask or opacity is 0 or missing.
fn hide(heights: &mut [f32], shown: &[f32]) {
    for (height, shown) in heights.iter_mut().zip(shown) {
        if shown.is_nan() || *shown == 0.0 {
            *height = f32::NAN;
        }
    }
}

fn text_of(tiff: &mut Tiff, tag: Tag) -> String {
    tiff.find_tag(tag).ok().flatten().and_then(|value| value.into_string().ok()).unwrap_or_default()
}

fn refused(file: &Path, doing: &str, error: &TiffError) -> Error {
    let problem = error.to_string();
    let why = excerpt(problem.as_bytes());
    match error {
        TiffError::UnsupportedError(TiffUnsupportedError::UnsupportedCompressionMethod(method)) => Error::Unsupported {
            what: format!("the raster {}", file.display()).into(),
            found: compression(*method),
            supported: "samples without compression or with Deflate, LZW, Zstandard or PackBits: pack it again with \
                        `gdal_translate -co COMPRESS=DEFLATE in.tif out.tif`"
                .into(),
        },
        TiffError::UnsupportedError(_) => Error::Unsupported {
            what: format!("the raster {}", file.display()).into(),
            found: why,
            supported:
                "8, 16, 32 and 64 bit integers and 32 and 64 bit floats, uncompressed or with Deflate, LZW, Zstandard or \
                        PackBits, such as `gdal_translate -co COMPRESS=DEFLATE in.tif out.tif` writes"
                    .into(),
        },
        TiffError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
            let hint = "download or export the file again: it is cut off or is not a TIFF file";
            Error::input(file, None, format!("the file ends within {doing}"), hint)
        }
        _ => Error::input(file, None, format!("{doing} cannot be read: {why}"), "export it again as GeoTIFF"),
    }
}

/// Returns the name and the code of a way to pack samples.
fn compression(method: CompressionMethod) -> String {
    let code = method.to_u16();
    match UNREAD_COMPRESSIONS.iter().find(|(known, _)| *known == code) {
        Some((_, name)) => format!("the compression {name} (code {code})"),
        None => format!("the unknown compression {code}"),
    }
}

fn nodata(tiff: &mut Tiff, file: &Path, warnings: &mut Vec<Message>) -> Option<f64> {
    let text = match tiff.find_tag(Tag::GdalNodata) {
        Ok(None) => return None,
        Ok(Some(value)) => value.into_string().unwrap_or_default(),
        Err(_) => String::new(),
    };
    let word = text.trim_matches(|c: char| c.is_whitespace() || c == '\0');
    let number = word.parse().ok();
    if number.is_none() {
        let shown = excerpt(word.as_bytes());
        warnings.push(format!("{}: the nodata value `{shown}` is not a number and is ignored", file.display()).into());
    }
    number
}

/// Returns the position of the samples, and the meaning of their numbers.
fn georeference(tiff: &mut Tiff, file: &Path, aux: &AuxNotes, warnings: &mut Vec<Message>) -> Result<(Grid, Meaning)> {
    let (columns, rows) = tiff.dimensions().map_err(|e| refused(file, "its size", &e))?;
    let mut doubles = |tag: Tag| -> Vec<f64> {
        let found = tiff.find_tag(tag).ok().flatten();
        found.and_then(|value| value.into_f64_vec().ok()).unwrap_or_default()
    };
    let (scale, ties) = (doubles(Tag::ModelPixelScaleTag), doubles(Tag::ModelTiepointTag));
    let transformation = doubles(Tag::ModelTransformationTag);
    let parameters = doubles(Tag::GeoDoubleParamsTag);
    // The georeference in the raster itself comes before the files beside it.
    let stated = (scale.len() >= 2 && ties.len() >= 6) || transformation.len() >= 8;
    let beside = if stated { None } else { sidecar::world_file(file)?.or_else(|| sidecar::place_of_aux(aux)) };
    let refuse = |what: &'static str, hint: &'static str| Err(Error::input(file, None, what, hint));
    // Scale with tie point, and transformation, both lead to the position of corner (or sample) 0,
    // 0 and a step east and south.
    let (first, step) = match (scale.as_slice(), ties.as_slice(), transformation.as_slice()) {
        _ if beside.is_some() => (DVec2::ZERO, DVec2::ZERO),
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
                "the raster states no position: it has no ModelTiepoint (tag 33922)",
                "georeference it, for example with `gdal_translate -a_ullr`",
            );
        }
        _ => {
            return refuse(
                "the raster states no position: it has neither ModelPixelScale (tag 33550) nor ModelTransformation (34264)",
                "georeference it, for example with `gdal_translate -a_srs EPSG:32632 -a_ullr west north east south`",
            );
        }
    };
    let directory = tiff.find_tag_unsigned_vec(Tag::GeoKeyDirectoryTag).ok().flatten().unwrap_or_default();
    let keys = GeoKeys::read(&directory, &parameters);
    let mut meaning = keys.meaning(file, warnings)?;
    sidecar::complete(&mut meaning, file, aux, warnings)?;
    let plane = meaning.plane_unit_m.unwrap_or(1.0);
    // A sample stands for its cell, and the position is the cell's corner, unless samples are
    // points. World files state the centre of the cell.
    let (first, step) = match beside {
        Some(world) => (world.first, world.step),
        None if keys.samples_are_points() => (first, step),
        None => (first + DVec2::new(0.5, -0.5) * step, step),
    };
    let grid = Grid { columns: columns as usize, rows: rows as usize, first: first * plane, step: step * plane };
    Ok((grid, meaning))
}

/// Returns the samples of the first band, in any number format. Samples that an opacity band hides
/// are NaN.
fn first_band(tiff: &mut Tiff, file: &Path, samples: usize, warnings: &mut Vec<Message>) -> Result<Vec<f32>> {
    let bad = |e: TiffError| refused(file, "its samples", &e);
    // "White is zero" inverts numbers, and `tiff` would invert them; no heights are meant that way.
    if tiff.find_tag_unsigned::<u16>(Tag::PhotometricInterpretation).ok().flatten() == Some(0) {
        let what = "its samples are a picture with white at 0 (tag 262, PhotometricInterpretation), not heights";
        return Err(Error::input(file, None, what, "export it as a GeoTIFF of heights"));
    }
    let bands = tiff.colortype().map_err(bad)?.num_samples();
    // The extra bands stand behind the colour bands; kinds 1 and 2 are opacity (tag 338).
    let extra: Vec<u16> = tiff.find_tag_unsigned_vec(Tag::ExtraSamples).ok().flatten().unwrap_or_default();
    let colours = usize::from(bands).saturating_sub(extra.len());
    let alpha =
        extra.iter().position(|kind| matches!(kind, 1 | 2)).map(|place| colours + place).filter(|place| *place > 0);
    if usize::from(bands) > 1 + usize::from(alpha.is_some()) {
        warnings.push(
            format!("{}: the first of {bands} bands holds the heights; the others are ignored", file.display()).into(),
        );
    }
    let mut heights = band(tiff, file, 0, samples)?;
    if let Some(alpha) = alpha {
        hide(&mut heights, &band(tiff, file, alpha, samples)?);
    }
    Ok(heights)
}

/// Returns the samples of one band, NaN where the file leaves them out.
fn band(tiff: &mut Tiff, file: &Path, number: usize, samples: usize) -> Result<Vec<f32>> {
    let bad = |e: TiffError| refused(file, "its samples", &e);
    let (columns, rows) = tiff.dimensions().map_err(bad)?;
    let color = tiff.colortype().map_err(bad)?;
    let planar = tiff.find_tag_unsigned::<u16>(Tag::PlanarConfiguration).ok().flatten() == Some(2);
    let between = if planar { 1 } else { usize::from(color.num_samples()).max(1) };
    let within = if planar { 0 } else { number };
    let bits = color.bit_depth();
    if bits < 8 && !(bits == 1 && between == 1) {
        let what = format!("its samples have {bits} bits, fewer than 8");
        return Err(Error::input(file, None, what, "export it as a GeoTIFF of heights"));
    }
    let tag = match tiff.get_chunk_type() {
        ChunkType::Strip => Tag::StripByteCounts,
        ChunkType::Tile => Tag::TileByteCounts,
    };
    let counts: Vec<u64> = tiff.find_tag_unsigned_vec(tag).ok().flatten().unwrap_or_default();
    let (wide, high) = tiff.chunk_dimensions();
    let (across, down) = (columns.div_ceil(wide.max(1)), rows.div_ceil(high.max(1)));
    let plane = u64::from(across) * u64::from(down);
    let first = if planar { number as u64 * plane } else { 0 };
    if wide == 0 || high == 0 || (counts.len() as u64) < first + plane {
        let what = format!("the file has {} strips or tiles, fewer than {across} x {down}", counts.len());
        return Err(Error::input(file, None, what, "download or export the file again: it is damaged"));
    }
    let mut heights = vec![f32::NAN; samples];
    for (chunk, &bytes) in (0..across * down).zip(counts.iter().skip(first as usize)) {
        // GDAL leaves tiles without any data out of the file ("sparse").
        if bytes == 0 {
            continue;
        }
        let decoded = tiff.read_chunk(first as u32 + chunk).map_err(bad)?;
        let (width, height) = tiff.chunk_data_dimensions(first as u32 + chunk);
        let from = (chunk / across * high) as usize * columns as usize + (chunk % across * wide) as usize;
        for line in 0..height as usize {
            let start = from + line * columns as usize;
            let to = heights.get_mut(start..start + width as usize).unwrap_or_default();
            match &decoded {
                DecodingResult::U8(all) if bits == 1 => copy_bits(to, all, line * (width as usize).div_ceil(8)),
                _ => copy(to, &decoded, line * width as usize * between + within, between),
            }
        }
    }
    Ok(heights)
}

/// Copies one line of single bits, the highest bit of a byte first.
fn copy_bits(to: &mut [f32], all: &[u8], from: usize) {
    let line = all.get(from..).unwrap_or_default();
    for (i, to) in to.iter_mut().enumerate() {
        let byte = line.get(i / 8).copied().unwrap_or_default();
        *to = f32::from(byte >> (7 - i % 8) & 1);
    }
}

/// Copies one line of a strip or tile; `between` is the distance from one sample of the band to the
/// next.
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

#[cfg(test)]
#[path = "geotiff_gdal_tests.rs"]
mod gdal_tests;
