//! In: the bytes of an STL file, text or binary. Out: its triangles, corners not yet shared.
//!
//! The crate `stl_io` is not used. It looks up every corner in a table, which the scene does
//! anyway. It also takes a file for text by its first word, which binary files of some CAD programs
//! have too. STL names no unit: coordinates are read as metres, z up. Sources: 3D Systems,
//! SLC/StereoLithography Interface Specification, 1989; M. Burns, Automated Fabrication, 1993,
//! section 6.5.

use std::path::Path;

use glam::DVec3;

use crate::coordinate::is_position;
use crate::formats::obj::DEFAULT_MATERIAL;
use crate::formats::stem;
use crate::geometry::Geometry;
use crate::text::{Lines, Words, excerpt, keyword_and_rest, number, without_byte_order_mark};
use heliotile_core::error::{Error, Result};
use heliotile_core::text::Message;

/// Bytes before the first triangle of a binary file: a comment and the number of triangles.
const HEAD: usize = 84;
/// Bytes of a triangle: a normal, three corners and two bytes in which some programs store colours.
const RECORD: usize = 50;

pub(super) fn parse(bytes: &[u8], file: &Path) -> Result<Geometry> {
    // The size decides first: binary files may begin with `solid` too.
    let geometry = match claimed(bytes) {
        Some(count) if binary_size(count) == bytes.len() as u64 => binary(bytes, count, file)?,
        _ if is_text(bytes) => Text::new(file).read(bytes)?,
        Some(count) => binary(bytes, count, file)?,
        None => {
            let what = format!(
                "the file is not STL: its {} bytes do not begin with `solid` and are too few for a binary file",
                bytes.len()
            );
            return Err(Error::input(
                file,
                None,
                what,
                "export it again: a binary file has 84 bytes and 50 for each triangle",
            ));
        }
    };
    if geometry.face_count() == 0 {
        return Err(Error::input(file, None, "the file holds no triangles", "export the surfaces again"));
    }
    Ok(geometry)
}

/// Returns the number of triangles that a binary file claims to hold.
fn claimed(bytes: &[u8]) -> Option<u32> {
    bytes.get(HEAD - 4..HEAD)?.first_chunk().map(|count| u32::from_le_bytes(*count))
}

fn binary_size(count: u32) -> u64 {
    HEAD as u64 + RECORD as u64 * u64::from(count)
}

/// Returns true if the file is text: it begins with `solid` and its first 512 bytes hold no zero.
/// The first word alone does not decide, because binary files may have it too.
fn is_text(bytes: &[u8]) -> bool {
    let text = without_byte_order_mark(bytes).trim_ascii_start();
    let head = text.get(..512).unwrap_or(text);
    head.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) && !head.contains(&0)
}

fn binary(bytes: &[u8], count: u32, file: &Path) -> Result<Geometry> {
    let body = bytes.get(HEAD..).unwrap_or_default();
    let whole = body.len() / RECORD;
    if (whole as u64) < u64::from(count) {
        let what = format!("the file ends after {whole} of the {count} triangles that it announces");
        return Err(Error::input(file, None, what, "copy or export it again; text files begin with `solid`"));
    }
    let mut geometry = Geometry::default();
    let mut normals = Normals::default();
    let (material, object) = (geometry.materials.id(DEFAULT_MATERIAL), geometry.objects.id(&stem(file)));
    for (i, record) in (1..=count).zip(body.chunks_exact(RECORD)) {
        let (numbers, _) = record.as_chunks::<4>();
        let vector = |at: usize| {
            let mut three = numbers.iter().skip(at).map(|bytes| f64::from(f32::from_le_bytes(*bytes)));
            let mut next = || three.next().unwrap_or(f64::NAN);
            DVec3::new(next(), next(), next())
        };
        let corners = [vector(3), vector(6), vector(9)];
        if let Some(corner) = corners.iter().find(|corner| !is_position(**corner)) {
            let what = format!("triangle {i} of {count} has a corner at {corner}");
            return Err(Error::input(file, None, what, "positions are metres, at most 1e9 in size; export it again"));
        }
        normals.compare(vector(0), corners);
        for corner in corners {
            let corner = geometry.push_vertex(file, corner)?;
            geometry.push_corner(corner);
        }
        geometry.end_face(material, object, 0);
    }
    normals.warn(file, &mut geometry);
    let left = bytes.len() as u64 - binary_size(count);
    if left > 0 {
        let text = format!("{}: {left} bytes after the last of {count} triangles are ignored", file.display());
        geometry.warnings.push(text.into());
    }
    Ok(geometry)
}

/// Count of stored normals that disagree with the order of the corners. The corners decide.
#[derive(Default)]
struct Normals {
    judged: usize,
    against: usize,
}

impl Normals {
    fn compare(&mut self, stored: DVec3, [a, b, c]: [DVec3; 3]) {
        let along = stored.dot((b - a).cross(c - a));
        self.judged += usize::from(along != 0.0 && along.is_finite());
        self.against += usize::from(along < 0.0);
    }

    fn warn(&self, file: &Path, geometry: &mut Geometry) {
        if 2 * self.against > self.judged {
            geometry.warnings.push(format!(
                "{}: {} of {} facet normals contradict the order of their corners; the order is used, so that outsides may be swapped",
                file.display(),
                self.against,
                self.judged
            ).into());
        }
    }
}

struct Text<'f> {
    file: &'f Path,
    geometry: Geometry,
    normals: Normals,
    material: u32,
    object: Option<u32>,
    /// Line of the `facet` being read, its normal and its corners.
    facet: Option<(usize, DVec3, Vec<DVec3>)>,
}

impl<'f> Text<'f> {
    fn new(file: &'f Path) -> Self {
        let mut geometry = Geometry::default();
        let material = geometry.materials.id(DEFAULT_MATERIAL);
        Text { file, geometry, normals: Normals::default(), material, object: None, facet: None }
    }

    fn read(mut self, bytes: &[u8]) -> Result<Geometry> {
        let mut lines = Lines::new(bytes);
        let mut last = 0;
        while let Some((line, text)) = lines.next() {
            last = line;
            let (keyword, rest) = keyword_and_rest(text);
            match keyword.to_ascii_lowercase().as_slice() {
                b"vertex" => self.vertex(line, rest)?,
                b"facet" => {
                    if self.facet.is_some() {
                        return Err(self.error(line, "a facet begins within another one"));
                    }
                    // A normal is only a hint, and many programs write nan for degenerate
                    // triangles.
                    let (_, rest) = keyword_and_rest(rest);
                    self.facet = Some((line, three(rest).unwrap_or(DVec3::NAN), Vec::new()));
                }
                b"endfacet" => self.end_facet(line)?,
                b"solid" => {
                    let name = String::from_utf8_lossy(rest);
                    self.object = (!rest.is_empty()).then(|| self.geometry.objects.id(&name));
                }
                b"outer" | b"endloop" | b"endsolid" => {}
                _ => {
                    let what = format!("`{}` is not a statement of an STL file", excerpt(text));
                    return Err(self.error(line, what));
                }
            }
        }
        if let Some((line, ..)) = self.facet {
            return Err(self.error(last, format!("the file ends within the facet of line {line}")));
        }
        self.normals.warn(self.file, &mut self.geometry);
        Ok(self.geometry)
    }

    fn vertex(&mut self, line: usize, rest: &[u8]) -> Result<()> {
        match (&mut self.facet, three(rest).filter(|position| is_position(*position))) {
            (Some((.., corners)), Some(position)) => corners.push(position),
            (None, _) => return Err(self.error(line, "a vertex stands outside of a facet")),
            (_, None) => {
                let what = format!("the vertex `{}` is not three numbers of at most 1e9", excerpt(rest));
                return Err(self.error(line, what));
            }
        }
        Ok(())
    }

    fn end_facet(&mut self, line: usize) -> Result<()> {
        let Some((begin, normal, corners)) = self.facet.take() else {
            return Err(self.error(line, "`endfacet` has no facet before it"));
        };
        if let &[a, b, c] = corners.as_slice() {
            self.normals.compare(normal, [a, b, c]);
        }
        let object = *self.object.get_or_insert_with(|| self.geometry.objects.id(&stem(self.file)));
        for corner in corners {
            let corner = self.geometry.push_vertex(self.file, corner)?;
            self.geometry.push_corner(corner);
        }
        self.geometry.end_face(self.material, object, begin);
        Ok(())
    }

    #[cold]
    fn error(&self, line: usize, what: impl Into<Message>) -> Error {
        Error::input(self.file, line, what, "export it again, as binary STL if the program can")
    }
}

fn three(text: &[u8]) -> Option<DVec3> {
    let mut words = Words(text).map(number);
    let mut next = || words.next().flatten();
    Some(DVec3::new(next()?, next()?, next()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_files::{area_and_volume, cube};

    fn parse(bytes: &[u8]) -> Result<Geometry> {
        super::parse(bytes, Path::new("town.stl"))
    }

    fn binary_cube(head: &[u8]) -> Vec<u8> {
        let mut bytes = head.to_vec();
        bytes.resize(80, b' ');
        let (vertices, triangles) = cube();
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for corners in triangles {
            let [a, b, c] = corners.map(|corner| vertices[corner as usize]);
            let normal = (b - a).cross(c - a);
            for vector in [normal, a, b, c] {
                vector.to_array().iter().for_each(|metres| bytes.extend((*metres as f32).to_le_bytes()));
            }
            bytes.extend([0, 0]);
        }
        bytes
    }

    fn text_cube(normals: f64) -> String {
        let (vertices, triangles) = cube();
        let line = |v: DVec3| format!("{} {} {:e}", v.x, v.y, v.z);
        let facets = triangles.map(|corners| {
            let [a, b, c] = corners.map(|corner| vertices[corner as usize]);
            let normal = normals * (b - a).cross(c - a);
            let corners = [a, b, c].map(|v| format!("vertex {}\n", line(v))).concat();
            format!("facet normal {}\nouter loop\n{corners}endloop\nendfacet\n", line(normal))
        });
        format!("solid my cube\r\n{}endsolid my cube\n", facets.concat())
    }

    /// A cube has 12 triangles, 6 m2 and a volume of 1 m3 as text and as binary, even if its head
    /// begins with "solid".
    #[test]
    fn text_and_binary_give_the_same_cube() {
        for (bytes, object) in [
            (binary_cube(b"exported"), "town"),
            (binary_cube(b"solid of no text"), "town"),
            (text_cube(1.0).into_bytes(), "my cube"),
            (text_cube(1.0).to_uppercase().into_bytes(), "MY CUBE"),
        ] {
            let geometry = parse(&bytes).expect("readable");
            assert_eq!(geometry.face_count(), 12);
            let (area, volume) = area_and_volume(&geometry);
            assert!((area - 6.0).abs() < 1e-6 && (volume - 1.0).abs() < 1e-6, "{area} {volume}");
            assert_eq!(geometry.objects.as_slice(), [object]);
            assert_eq!(geometry.materials.as_slice(), ["default"]);
            assert!(geometry.warnings.is_empty(), "{:?}", geometry.warnings);
        }
    }

    /// 12 normals against the corner order and 7 extra bytes are warnings; two solids are two
    /// objects.
    #[test]
    fn swapped_normals_and_extra_bytes_give_warnings() {
        let swapped = parse(text_cube(-1.0).as_bytes()).expect("readable");
        assert_eq!(swapped.warnings.len(), 1);
        assert!(swapped.warnings[0].plain().starts_with("town.stl: 12 of 12 facet normals"), "{:?}", swapped.warnings);
        let longer = parse(&[binary_cube(b"long"), vec![0; 7]].concat()).expect("readable");
        assert!(longer.warnings[0].contains("town.stl: 7 bytes after the last of 12 triangles are ignored"));
        let two = text_cube(1.0) + &text_cube(1.0).replace("my cube", "other");
        assert_eq!(parse(two.as_bytes()).expect("readable").objects.as_slice(), ["my cube", "other"]);
    }

    /// 15 files that are not STL or are damaged are refused with a message of what was found; 4
    /// billion claimed triangles take no memory.
    #[test]
    fn damaged_files_are_refused_with_a_reason() {
        let facet = |inside: &str| format!("solid a\nfacet normal 0 0 1\nouter loop\n{inside}").into_bytes();
        let mut claims = binary_cube(b"")[..84].to_vec();
        claims[80..84].fill(255);
        let mut nan = binary_cube(b"");
        nan[84 + 50 + 12..84 + 50 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
        for (bytes, said) in [
            (vec![], "town.stl: the file is not STL: its 0 bytes"),
            (b"hello".to_vec(), "is not STL: its 5 bytes"),
            (b"solid".to_vec(), "holds no triangles"),
            (claims, "ends after 0 of the 4294967295 triangles"),
            (binary_cube(b"")[..400].to_vec(), "ends after 6 of the 12 triangles"),
            (binary_cube(b"solid")[..400].to_vec(), "ends after 6 of the 12 triangles"),
            (nan, "triangle 2 of 12 has a corner at [NaN, "),
            (facet("vertex 0 0 nan\n"), "line 4: the vertex `0 0 nan` is not three"),
            (facet("vertex 0 0\n"), "line 4: the vertex `0 0` is not three"),
            (facet("vertex 1e10 0 0\n"), "line 4: the vertex `1e10 0 0`"),
            (facet("vertex 0 0 0\nfacet"), "line 5: a facet begins within another one"),
            (facet("vertex 0 0 0\n"), "line 4: the file ends within the facet of line 2"),
            (b"solid\nvertex 0 0 0".to_vec(), "line 2: a vertex stands outside of a facet"),
            (b"solid\nendfacet".to_vec(), "line 2: `endfacet` has no facet"),
            (b"solid\n<html>\x1b[1m".to_vec(), "line 2: `<html>\u{fffd}[1m` is not a statement"),
        ] {
            let message = parse(&bytes).map(drop).expect_err(said).to_string();
            assert!(message.starts_with("town.stl") && message.contains(said), "{said}: {message}");
        }
    }
}
