//! Matrices of Radiance. In: the bytes that `gendaymtx` writes, as text or floats, or the column of
//! `genskyvec`. Out: a checked [`PatchFile`] with a row for each column of the matrix.
//!
//! Rows are the ground and the patches of Reinhart's subdivision MF:1, 2 or 4, from the horizon up,
//! clockwise from north: checked against `gendaymtx` of Radiance 6 (`tests/data/skies`). The row of
//! the ground is not used. Three components become one number by the weights that Radiance gives
//! red, green and blue in a luminance (`src/common/color.h`, 0.265, 0.670 and 0.065).

use std::path::Path;

use crate::skies::{PatchFile, PatchQuantity, grid_of};
use heliotile_core::dome::series::PatchSeries;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::excerpt;

/// Weights of red, green and blue in a luminance.
const LUMINANCE: [f64; 3] = [0.265, 0.670, 0.065];

/// Returns one level of red, green and blue.
pub fn luminance(rgb: [f64; 3]) -> f64 {
    rgb.iter().zip(LUMINANCE).map(|(part, weight)| part * weight).sum()
}

/// First bytes of a header of Radiance.
const MAGIC: &[u8] = b"#?";

const HINT: &str = "write the matrix with its header by `gendaymtx -s -O1 -m 1` (or -m 2, -m 4), as text or with -of";

/// Fields of a header.
#[derive(Default)]
struct Header {
    rows: Option<usize>,
    columns: Option<usize>,
    components: Option<usize>,
    format: Option<String>,
    is_big_endian: bool,
}

/// Returns true if bytes are a matrix: they have a header of Radiance, or numbers between blanks
/// and no comma.
pub(super) fn is_matrix(bytes: &[u8]) -> bool {
    let start = bytes.get(..bytes.len().min(200)).unwrap_or_default();
    let is_number = |byte: &u8| byte.is_ascii_digit() || byte.is_ascii_whitespace() || b"+-.eEnaNif".contains(byte);
    start.starts_with(MAGIC) || !start.is_empty() && start.iter().all(is_number)
}

/// Reads a matrix.
pub(super) fn parse_matrix(path: &Path, bytes: &[u8], quantity: PatchQuantity) -> Result<PatchFile> {
    let refuse = |what: String| Error::input(path, None, what, HINT);
    let (header, body) = match bytes.starts_with(MAGIC) {
        true => header_of(bytes).ok_or_else(|| refuse("the header does not end with an empty line".into()))?,
        false => (Header::default(), bytes),
    };
    let numbers = match header.format.as_deref() {
        None | Some("ascii") => Numbers::Words(words(path, body)?),
        Some("float") => Numbers::Floats { bytes: body, size: 4, is_big_endian: header.is_big_endian },
        Some("double") => Numbers::Floats { bytes: body, size: 8, is_big_endian: header.is_big_endian },
        Some(other) => {
            return Err(refuse(format!("FORMAT is `{}`, not ascii, float or double", excerpt(other, 40))));
        }
    };
    let components = header.components.unwrap_or_else(|| components_of(body));
    if ![1, 3].contains(&components) {
        return Err(refuse(format!("each patch has {components} components, not 1 or 3")));
    }
    let columns = header.columns.unwrap_or(1);
    let rows = header.rows.unwrap_or(numbers.len() / components / columns.max(1));
    let Some((grid, true)) = grid_of(rows) else {
        let what = format!(
            "{rows} rows, not the 146 (MF:1), 578 (MF:2) or 2306 (MF:4) of the ground and the patches of the sky"
        );
        return Err(refuse(what));
    };
    let whole = rows.checked_mul(columns).and_then(|cells| cells.checked_mul(components));
    if whole != Some(numbers.len()) || columns == 0 {
        let what = format!("{} numbers for {rows} rows of {columns} columns of {components} components", numbers.len());
        return Err(refuse(what));
    }
    // Reorder from [patch][time][component] to [time][patch].
    let patches = grid.len();
    let mut found = vec![0.0_f32; columns * patches];
    for patch in 0..patches {
        for column in 0..columns {
            // The first row is the ground.
            let first = ((patch + 1) * columns + column) * components;
            let cell: Vec<f64> = (first..first + components).map(|at| numbers.at(at)).collect();
            if !cell.iter().all(|part| quantity.holds(*part)) {
                let cell = cell.iter().map(|part| (*part as f32).to_string()).collect::<Vec<_>>().join(" ");
                let what = format!("row {}, column {}, is {cell}", patch + 2, column + 1);
                return Err(Error::input(path, None, what, format!("{}: make the matrix again", quantity.range())));
            }
            let number = match cell.as_slice() {
                [one] => *one,
                cell => cell.iter().zip(LUMINANCE).map(|(part, weight)| part * weight).sum(),
            };
            if let Some(to) = found.get_mut(column * patches + patch) {
                *to = number as f32;
            }
        }
    }
    let series = PatchSeries::new(grid, found).ok_or_else(|| refuse("the matrix has no columns".into()))?;
    Ok(PatchFile { series, labels: None, is_matrix: true })
}

/// Returns the header and the bytes behind it; `None` if the header has no end.
fn header_of(bytes: &[u8]) -> Option<(Header, &[u8])> {
    let mut header = Header::default();
    let mut rest = bytes;
    loop {
        let end = rest.iter().position(|byte| *byte == b'\n')?;
        let (line, behind) = (rest.get(..end)?, rest.get(end + 1..)?);
        rest = behind;
        let line = String::from_utf8_lossy(line);
        let line = line.trim_end_matches('\r');
        if line.is_empty() {
            return Some((header, rest));
        }
        let Some((name, value)) = line.split_once('=') else { continue };
        let value = value.trim();
        match name {
            "NROWS" => header.rows = value.parse().ok(),
            "NCOLS" => header.columns = value.parse().ok(),
            "NCOMP" => header.components = value.parse().ok(),
            "FORMAT" => header.format = Some(value.to_owned()),
            "BigEndian" => header.is_big_endian = value == "1",
            _ => {}
        }
    }
}

/// The numbers behind a header.
enum Numbers<'b> {
    Words(Vec<f32>),
    /// Floats of 4 or 8 bytes each.
    Floats {
        bytes: &'b [u8],
        size: usize,
        is_big_endian: bool,
    },
}

impl Numbers<'_> {
    /// Returns the count of numbers. A part of a number at the end counts as one, so that the
    /// length check refuses it.
    fn len(&self) -> usize {
        match self {
            Numbers::Words(numbers) => numbers.len(),
            Numbers::Floats { bytes, size, .. } => bytes.len().div_ceil(*size),
        }
    }

    /// Returns a number by its index; NaN where there is none.
    fn at(&self, at: usize) -> f64 {
        let (bytes, size, is_big_endian) = match self {
            Numbers::Words(numbers) => return numbers.get(at).map_or(f64::NAN, |number| f64::from(*number)),
            Numbers::Floats { bytes, size, is_big_endian } => (bytes, *size, *is_big_endian),
        };
        let bytes = bytes.get(at * size..(at + 1) * size).unwrap_or_default();
        match (<[u8; 4]>::try_from(bytes), <[u8; 8]>::try_from(bytes)) {
            (Ok(four), _) if is_big_endian => f64::from(f32::from_be_bytes(four)),
            (Ok(four), _) => f64::from(f32::from_le_bytes(four)),
            (_, Ok(eight)) if is_big_endian => f64::from_be_bytes(eight),
            (_, Ok(eight)) => f64::from_le_bytes(eight),
            _ => f64::NAN,
        }
    }
}

/// Reads numbers between blanks.
fn words(path: &Path, body: &[u8]) -> Result<Vec<f32>> {
    let mut numbers = Vec::new();
    for word in body.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()) {
        let number = std::str::from_utf8(word).ok().and_then(|word| word.parse::<f32>().ok());
        let refuse = || {
            let word = excerpt(&String::from_utf8_lossy(word), 40);
            Error::input(path, None, format!("value {} is `{word}`, not a number", numbers.len() + 1), HINT)
        };
        numbers.push(number.ok_or_else(refuse)?);
    }
    Ok(numbers)
}

/// Returns the count of numbers on the first line that has some: the components of a patch where no
/// header states them.
fn components_of(body: &[u8]) -> usize {
    let lines = body.split(|byte| *byte == b'\n');
    let count = |line: &[u8]| line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).count();
    lines.map(count).find(|count| *count > 0).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8]) -> Result<PatchFile> {
        parse_matrix(Path::new("sky.mtx"), bytes, PatchQuantity::Radiance)
    }

    fn head(rows: usize, columns: usize, components: usize, more: &str) -> String {
        format!("#?RADIANCE\ngendaymtx -s a.wea\nNROWS={rows}\nNCOLS={columns}\nNCOMP={components}\n{more}\n\n")
    }

    /// Two columns of 145 patches as text with three components, as floats of either byte order,
    /// and as doubles give the same numbers: patch p at time t is p + 1000 t. A bare column of 577
    /// patches is read, too, with the weights of red, green and blue. The ground is left out.
    #[test]
    fn matrices_of_all_layouts_read_alike() {
        let number = |patch: usize, time: usize| (patch + 1000 * time) as f64;
        let cells: Vec<(usize, usize)> = (0..146).flat_map(|patch| [(patch, 0), (patch, 1)]).collect();
        let text: String = cells.iter().map(|(p, t)| format!("{0} {0} {0}\n", number(*p, *t))).collect();
        let bytes =
            |to: &dyn Fn(f64) -> Vec<u8>| cells.iter().flat_map(|(p, t)| to(number(*p, *t))).collect::<Vec<u8>>();
        let little = bytes(&|number| (number as f32).to_le_bytes().to_vec());
        let big = bytes(&|number| (number as f32).to_be_bytes().to_vec());
        let double = bytes(&|number| number.to_le_bytes().to_vec());
        let ascii = head(146, 2, 3, "FORMAT=ascii").into_bytes();
        for file in [
            [ascii, text.into_bytes()].concat(),
            [head(146, 2, 1, "BigEndian=0\nFORMAT=float").into_bytes(), little].concat(),
            [head(146, 2, 1, "BigEndian=1\nFORMAT=float").into_bytes(), big].concat(),
            [head(146, 2, 1, "BigEndian=0\nFORMAT=double").into_bytes(), double].concat(),
        ] {
            let found = read(&file).expect("a matrix").series;
            assert_eq!(found.rows(), 2);
            for time in 0..2 {
                let off = |(i, l): (usize, &f32)| (f64::from(*l) - number(i + 1, time)).abs() > 1e-3;
                assert!(!found.row(time).iter().enumerate().any(off));
            }
        }
        let bare: String = (0..578).map(|patch| format!("{patch} 0 0\n")).collect();
        assert!(is_matrix(bare.as_bytes()) && !is_matrix(b"time,p1"));
        let bare = read(bare.as_bytes()).expect("a column");
        assert_eq!((bare.series.rows(), bare.series.row(0).len()), (1, 577));
        assert!((f64::from(bare.series.row(0)[99]) - 26.5).abs() < 1e-5);
    }

    /// Ten broken matrices are errors that name what was found: another subdivision, missing
    /// numbers, too many, no number, one below 0, NaN, an unknown format, 20 components, a header
    /// without end, and a part of a float.
    #[test]
    fn broken_matrices_are_refused_by_what_was_found() {
        let ones = |count: usize| "1\n".repeat(count);
        for (text, expected) in [
            (head(1298, 1, 1, "FORMAT=ascii") + &ones(1298), "1298 rows, not the 146"),
            (head(146, 2, 1, "FORMAT=ascii") + &ones(291), "291 numbers for 146 rows of 2 columns"),
            (head(146, 1, 1, "FORMAT=ascii") + &ones(147), "147 numbers"),
            (head(146, 1, 1, "FORMAT=ascii") + &ones(145) + "x", "value 146 is `x`, not a number"),
            (head(146, 1, 1, "FORMAT=ascii") + &ones(145) + "-1", "row 146, column 1, is -1"),
            (head(146, 1, 1, "FORMAT=ascii") + &ones(145) + "nan", "row 146, column 1, is NaN"),
            (head(146, 1, 1, "FORMAT=32-bit_rle_rgbe") + &ones(146), "FORMAT is `32-bit_rle_rgbe`"),
            (head(146, 1, 20, "FORMAT=ascii") + &ones(2920), "20 components"),
            ("#?RADIANCE\nNROWS=146".to_owned(), "the header does not end"),
        ] {
            let found = read(text.as_bytes()).expect_err(expected).to_string();
            assert!(found.contains(expected), "{found}");
        }
        let short = [head(146, 1, 1, "FORMAT=float").into_bytes(), vec![0; 4 * 146 - 1]].concat();
        assert!(read(&short).expect_err("a part").to_string().contains("is NaN"));
    }
}
