//! Radiance pictures. In: the bytes of a file of the format RGBE, run-length encoded or flat. Out:
//! one radiance a pixel.
//!
//! The format is by Ward, "Real pixels", Graphics Gems II, 1991, with the newer run lengths by
//! component that `rpict` and `pfilt` write: lines of 8 to 32767 pixels begin with 2, 2 and their
//! length.

use std::path::Path;

use heliotile_core::error::{Error, Result};
use heliotile_core::text::excerpt;
use heliotile_weather::skies::luminance;

const FORMAT: &str = "32-bit_rle_rgbe";

/// Largest length of a header, bytes.
const HEAD: usize = 1 << 16;

/// Lines of a header, and the bytes behind it.
struct Head<'b> {
    lines: Vec<String>,
    body: &'b [u8],
}

impl<'b> Head<'b> {
    fn parse(bytes: &'b [u8]) -> Option<Self> {
        let (mut rest, mut lines) = (bytes, Vec::new());
        while bytes.len() - rest.len() < HEAD {
            let (line, behind) = split_line(rest)?;
            rest = behind;
            if line.is_empty() {
                return Some(Head { lines, body: rest });
            }
            lines.push(line);
        }
        None
    }

    fn values<'h>(&'h self, name: &'h str) -> impl Iterator<Item = &'h str> {
        self.lines.iter().filter_map(move |line| Some(line.strip_prefix(name)?.strip_prefix('=')?.trim()))
    }
}

fn split_line(bytes: &[u8]) -> Option<(String, &[u8])> {
    let end = bytes.iter().position(|byte| *byte == b'\n')?;
    let line = String::from_utf8_lossy(bytes.get(..end)?).trim_end_matches('\r').to_owned();
    Some((line, bytes.get(end + 1..)?))
}

/// Returns true if bytes are a Radiance picture, and not a matrix.
pub(super) fn is_hdr(bytes: &[u8]) -> bool {
    let is_picture = |head: Head| head.values("FORMAT").any(|format| format.starts_with("32-bit_rle"));
    bytes.starts_with(b"#?") && Head::parse(bytes).is_some_and(is_picture)
}

/// Reads a picture; levels are divided by its exposure.
pub(super) fn read_hdr(path: &Path, bytes: &[u8]) -> Result<Pixels> {
    let refuse = |what: String| Error::input(path, None, what, "save the picture as Radiance HDR again, in RGBE");
    let head = Head::parse(bytes).ok_or_else(|| refuse("its header does not end with an empty line".into()))?;
    if let Some(other) = head.values("FORMAT").find(|format| *format != FORMAT) {
        return Err(refuse(format!("its FORMAT is `{}`, not {FORMAT}", excerpt(other, 40))));
    }
    let exposure: f64 = head.values("EXPOSURE").filter_map(|value| value.parse::<f64>().ok()).product();
    let (size, mut body) = split_line(head.body).ok_or_else(|| refuse("it has no size".into()))?;
    let words: Vec<&str> = size.split_whitespace().collect();
    let sides = match words.as_slice() {
        ["-Y", height, "+X", width] => width.parse::<usize>().ok().zip(height.parse::<usize>().ok()),
        _ => None,
    };
    let what = || format!("its size is `{}`, not `-Y height +X width`", excerpt(&size, 40));
    let (width, height) = sides.ok_or_else(|| refuse(what()))?;
    check_sides(path, width, height)?;
    let mut levels = Vec::new();
    for row in 0..height {
        let (line, behind) =
            scanline(body, width).ok_or_else(|| refuse(format!("row {} of {height} is damaged", row + 1)))?;
        body = behind;
        levels.extend(line.into_iter().map(|pixel| radiance(pixel) / exposure));
    }
    Ok(Pixels { width, height, levels, are_coded: false })
}

/// Returns the radiance of mantissas and an exponent: (m + 0.5) x 2^(e - 136), and 0 if the
/// exponent is 0.
fn radiance([red, green, blue, exponent]: [u8; 4]) -> f64 {
    if exponent == 0 {
        return 0.0;
    }
    let scale = 2.0_f64.powi(i32::from(exponent) - 136);
    luminance([red, green, blue].map(|mantissa| (f64::from(mantissa) + 0.5) * scale))
}

/// Returns one line of pixels, and the bytes behind it.
fn scanline(bytes: &[u8], width: usize) -> Option<(Vec<[u8; 4]>, &[u8])> {
    let (start, rest) = bytes.split_first_chunk::<4>()?;
    let [2, 2, high, low] = *start else { return flat(bytes, width) };
    if usize::from(high) << 8 | usize::from(low) != width || high & 0x80 != 0 {
        return flat(bytes, width);
    }
    let mut rest = rest;
    let mut pixels = vec![[0_u8; 4]; width];
    for component in 0..4 {
        let mut at = 0;
        while at < width {
            let (count, behind) = rest.split_first()?;
            let run = usize::from(*count);
            let (values, behind) = if run > 128 {
                let (value, behind) = behind.split_first()?;
                (vec![*value; run - 128], behind)
            } else {
                let (values, behind) = behind.split_at_checked(run)?;
                (values.to_vec(), behind)
            };
            let to = pixels.get_mut(at..at + values.len())?;
            if values.is_empty() {
                return None;
            }
            for (pixel, value) in to.iter_mut().zip(&values) {
                *pixel.get_mut(component)? = *value;
            }
            at += values.len();
            rest = behind;
        }
    }
    Some((pixels, rest))
}

/// Returns uncompressed pixels. Runs of the oldest files, which repeat a pixel after three ones,
/// are not supported.
fn flat(bytes: &[u8], width: usize) -> Option<(Vec<[u8; 4]>, &[u8])> {
    let (line, behind) = bytes.split_at_checked(4 * width)?;
    let (pixels, _) = line.as_chunks::<4>();
    let is_run = |pixel: &[u8; 4]| pixel.starts_with(&[1, 1, 1]);
    (!pixels.iter().any(is_run)).then(|| (pixels.to_vec(), behind))
}

/// Pixels of a picture, one number each.
pub(super) struct Pixels {
    pub width: usize,
    pub height: usize,
    /// Levels, `[row][column]`, from the top left.
    pub levels: Vec<f64>,
    /// True if levels come from a display encoding, from 0 to 1.
    pub are_coded: bool,
}

/// Largest side of a picture, pixels.
const MAX_SIDE: usize = 8192;

/// Refuses sides beyond what memory is planned for.
pub(super) fn check_sides(path: &Path, width: usize, height: usize) -> Result<()> {
    if width.max(height) <= MAX_SIDE {
        return Ok(());
    }
    let what = format!("the picture has {width} x {height} pixels, and at most {MAX_SIDE} a side are supported");
    Err(Error::input(path, None, what, "scale the picture down"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(more: &str, size: &str, body: &[u8]) -> Vec<u8> {
        [format!("#?RADIANCE\nFORMAT={FORMAT}\n{more}\n{size}\n").as_bytes(), body].concat()
    }

    /// Mantissa 127 with exponent 137 is 255, flat and as runs, and 51 with an exposure of 5;
    /// exponent 0 is black.
    #[test]
    fn mantissa_and_exponent_give_the_radiance() {
        let first = |bytes: &[u8]| read_hdr(Path::new("a.hdr"), bytes).expect("a picture").levels;
        assert_eq!(first(&file("", "-Y 1 +X 1", &[127, 127, 127, 137])), [255.0]);
        assert_eq!(first(&file("EXPOSURE=2.5\nEXPOSURE=2\n", "-Y 1 +X 1", &[127, 127, 127, 137])), [51.0]);
        assert_eq!(first(&file("", "-Y 1 +X 1", &[127, 127, 127, 0])), [0.0]);
        let runs = [2, 2, 0, 9, 137, 127, 137, 127, 137, 127, 133, 137, 4, 137, 137, 137, 0];
        let found = first(&file("", "-Y 1 +X 9", &runs));
        assert_eq!((found.len(), found[0], found[7], found[8]), (9, 255.0, 255.0, 0.0));
        assert!(is_hdr(&file("", "", &[])) && !is_hdr(b"#?RADIANCE\nFORMAT=float\n\n"));
    }

    /// Five broken pictures are errors: another format, a size from below, too few bytes, a run
    /// beyond the line, a side of 9000.
    #[test]
    fn broken_hdr_pictures_are_errors() {
        for bytes in [
            b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n\x01\x02\x03\x04".to_vec(),
            file("", "+Y 1 +X 1", &[1; 4]),
            file("", "-Y 2 +X 1", &[9; 4]),
            file("", "-Y 1 +X 9", &[2, 2, 0, 9, 200, 1]),
            file("", "-Y 1 +X 9000", &[0; 4]),
        ] {
            assert!(matches!(read_hdr(Path::new("a.hdr"), &bytes), Err(Error::Input { .. })));
        }
    }
}
