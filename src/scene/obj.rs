//! In: the bytes of a Wavefront OBJ file. Out: its vertices, polygons, material names and libraries, every index checked.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fs;
use std::path::Path;

use glam::DVec3;

use super::text::{Lines, Words, excerpt, keyword_and_rest, leading_index, number};
use crate::error::{Error, Result};

/// Largest coordinate that is taken for a position in metres and not for an accident.
pub(super) const MAX_COORDINATE_M: f64 = 1e9;

/// Name of the material of faces that stand before any `usemtl`.
const DEFAULT_MATERIAL: &str = "default";

/// Statements of other kinds of geometry that are named in warnings one by one; a hostile file holds millions.
const MAX_KINDS_IGNORED: usize = 16;

/// What an OBJ file says, in file order.
#[derive(Debug, Default)]
pub(super) struct ObjFile {
    /// Input coordinates, metres; finite.
    pub vertices: Vec<DVec3>,
    /// Corners of all faces one after the other: indices into `vertices`, all in range.
    corners: Vec<u32>,
    faces: Vec<Face>,
    /// Indexed by `Polygon::material`; no two equal.
    pub material_names: Vec<String>,
    pub libraries: Vec<Library>,
    pub warnings: Vec<String>,
}

#[derive(Debug)]
struct Face {
    end: usize,
    material: u32,
    line: usize,
}

/// One `mtllib` statement: a file name, or several.
#[derive(Debug)]
pub(super) struct Library {
    pub line: usize,
    pub text: String,
}

/// One `f` statement.
pub(super) struct Polygon<'a> {
    pub corners: &'a [u32],
    pub material: u32,
    pub line: usize,
}

impl ObjFile {
    pub(super) fn read(path: &Path) -> Result<ObjFile> {
        let bytes = fs::read(path).map_err(Error::io(path, "read"))?;
        ObjFile::parse(&bytes, path)
    }

    pub(super) fn parse(bytes: &[u8], file: &Path) -> Result<ObjFile> {
        let mut reader = Reader::new(file);
        let mut lines = Lines::new(bytes);
        while let Some((line, text)) = lines.next() {
            let (keyword, rest) = keyword_and_rest(text);
            match keyword {
                b"v" => reader.vertex(line, rest)?,
                b"f" => reader.face(line, rest)?,
                b"usemtl" => reader.use_material(line, rest)?,
                b"mtllib" => {
                    reader.obj.libraries.push(Library { line, text: String::from_utf8_lossy(rest).into_owned() })
                }
                b"vn" | b"vt" | b"g" | b"o" | b"s" | b"l" | b"p" => {}
                other => reader.ignore(line, other),
            }
        }
        reader.finish()
    }

    pub(super) fn faces_read(&self) -> usize {
        self.faces.len()
    }

    pub(super) fn polygons(&self) -> impl Iterator<Item = Polygon<'_>> {
        let mut start = 0;
        self.faces.iter().map(move |face| {
            let corners = self.corners.get(start..face.end).unwrap_or_default();
            start = face.end;
            Polygon { corners, material: face.material, line: face.line }
        })
    }
}

struct Reader<'f> {
    file: &'f Path,
    obj: ObjFile,
    material_of_name: HashMap<String, u32>,
    material: Option<u32>,
    /// Largest index that was beyond the vertices read so far, and its line: allowed if the vertex comes later.
    ahead: Option<(i64, usize)>,
    /// Keyword, first line and count of statements that this reader passes over.
    ignored: Vec<(Vec<u8>, usize, usize)>,
}

impl<'f> Reader<'f> {
    fn new(file: &'f Path) -> Self {
        Reader {
            file,
            obj: ObjFile::default(),
            material_of_name: HashMap::new(),
            material: None,
            ahead: None,
            ignored: Vec::new(),
        }
    }

    fn vertex(&mut self, line: usize, text: &[u8]) -> Result<()> {
        let mut words = Words(text);
        let position = DVec3::new(
            self.coordinate(line, "x", words.next())?,
            self.coordinate(line, "y", words.next())?,
            self.coordinate(line, "z", words.next())?,
        );
        if self.obj.vertices.len() >= u32::MAX as usize {
            return Err(Error::Limit {
                what: format!("the number of vertices of {}", self.file.display()),
                value: self.obj.vertices.len() as u64 + 1,
                max: u64::from(u32::MAX),
            });
        }
        self.obj.vertices.push(position);
        Ok(())
    }

    #[inline]
    fn coordinate(&self, line: usize, axis: &str, word: Option<&[u8]>) -> Result<f64> {
        let value = word.and_then(number);
        match value {
            // + 0.0 turns -0.0 into 0.0.
            Some(value) if value.abs() <= MAX_COORDINATE_M => Ok(value + 0.0),
            _ => Err(self.coordinate_error(line, axis, word, value)),
        }
    }

    #[cold]
    fn coordinate_error(&self, line: usize, axis: &str, word: Option<&[u8]>, value: Option<f64>) -> Error {
        let hint = "write a vertex as `v x y z`: decimal numbers with a point, in metres, at most 1e9 in size";
        let what = match (word, value) {
            (None, _) => format!("the vertex has no {axis} coordinate"),
            (Some(word), None) => {
                format!("{axis} of the vertex is `{}`, not a number", excerpt(word))
            }
            (Some(word), Some(_)) => {
                format!("{axis} of the vertex is `{}`, beyond all positions on Earth", excerpt(word))
            }
        };
        Error::input(self.file, line, what, hint)
    }

    fn face(&mut self, line: usize, text: &[u8]) -> Result<()> {
        let material = match self.material {
            Some(material) => material,
            None => self.select_material(line, DEFAULT_MATERIAL.to_owned())?,
        };
        for word in Words(text) {
            let corner = self.corner(line, word)?;
            self.obj.corners.push(corner);
        }
        self.obj.faces.push(Face { end: self.obj.corners.len(), material, line });
        Ok(())
    }

    /// The vertex of `a`, `a/b`, `a//c` or `a/b/c`, counted from 0.
    #[inline]
    fn corner(&mut self, line: usize, word: &[u8]) -> Result<u32> {
        let count = self.obj.vertices.len() as i64;
        let zero_based = match leading_index(word) {
            Some(index) if index > 0 => {
                if index > count && self.ahead.is_none_or(|(furthest, _)| index > furthest) {
                    self.ahead = Some((index, line));
                }
                index - 1
            }
            Some(index) if index < 0 => count + index,
            _ => -1,
        };
        u32::try_from(zero_based).map_err(|_| self.corner_error(line, word))
    }

    #[cold]
    fn corner_error(&self, line: usize, word: &[u8]) -> Error {
        let count = self.obj.vertices.len();
        let what = match leading_index(word) {
            Some(0) => format!("face corner `{}` points to vertex 0, but vertices count from 1", excerpt(word)),
            Some(_) => format!("face corner `{}` points beyond the {count} vertices above this line", excerpt(word)),
            None => format!("face corner `{}` is not a vertex number", excerpt(word)),
        };
        let allowed = match count {
            0 => "put the `v` lines before the faces that use them".to_owned(),
            _ => format!("use 1 to {count}, or -{count} to -1 counted back from this line"),
        };
        Error::input(self.file, line, what, allowed)
    }

    fn use_material(&mut self, line: usize, name: &[u8]) -> Result<()> {
        let name = match name {
            [] => DEFAULT_MATERIAL.to_owned(),
            _ => String::from_utf8_lossy(name).into_owned(),
        };
        self.select_material(line, name).map(drop)
    }

    fn select_material(&mut self, line: usize, name: String) -> Result<u32> {
        let names = &mut self.obj.material_names;
        let material = match self.material_of_name.entry(name) {
            Entry::Occupied(known) => *known.get(),
            Entry::Vacant(new) => {
                let id = u32::try_from(names.len()).map_err(|_| {
                    Error::input(self.file, line, "more than 4294967295 material names", "join materials")
                })?;
                names.push(new.key().clone());
                *new.insert(id)
            }
        };
        self.material = Some(material);
        Ok(material)
    }

    fn ignore(&mut self, line: usize, keyword: &[u8]) {
        if let Some(known) = self.ignored.iter_mut().find(|(kind, ..)| kind == keyword) {
            known.2 += 1;
        } else if self.ignored.len() < MAX_KINDS_IGNORED {
            self.ignored.push((keyword.to_vec(), line, 1));
        }
    }

    fn finish(mut self) -> Result<ObjFile> {
        let count = self.obj.vertices.len();
        if let Some((index, line)) = self.ahead.filter(|&(index, _)| index > count as i64) {
            return Err(Error::input(
                self.file,
                line,
                format!("face corner {index} points beyond the {count} vertices of the file"),
                format!("use 1 to {count}, or negative numbers to count back from the line"),
            ));
        }
        if self.obj.faces.is_empty() {
            return Err(Error::input(
                self.file,
                None,
                format!("the file holds no faces ({count} vertices were read)"),
                "export surfaces as `f` lines; points, lines and free-form surfaces shade nothing",
            ));
        }
        for (keyword, line, times) in &self.ignored {
            self.obj.warnings.push(format!(
                "{}, line {line}: `{}` is no polygon statement; {times} such lines were passed over",
                self.file.display(),
                excerpt(keyword)
            ));
        }
        Ok(self.obj)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<ObjFile> {
        ObjFile::parse(text.as_bytes(), Path::new("town.obj"))
    }

    fn corners(text: &str) -> Vec<Vec<u32>> {
        let obj = parse(text).expect("readable");
        obj.polygons().map(|face| face.corners.to_vec()).collect()
    }

    const SQUARE: &str = "v 0 0 0\nv 1 0 0 1.0\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0\n";

    /// All four spellings of a corner, relative ones and later vertices name the same vertex.
    #[test]
    fn corner_forms() {
        let text = format!("{SQUARE}f 1 2/7 3//8 4/9/9\nf -4 -3/1 -2//1 -1/1/1\nf 1 2 5\nv 3 3 3 # late\n");
        assert_eq!(corners(&text), [vec![0, 1, 2, 3], vec![0, 1, 2, 3], vec![0, 1, 4]]);
    }

    /// CRLF, tabs, leading blanks, continuation, comments and bytes that are not UTF-8 change nothing.
    #[test]
    fn as_found_in_the_wild() {
        let wild = b"\xef\xbb\xbf# caf\xe9\r\no b\r\n \tv\t0 0 0\r\nv 1. +0 .0e0\r\nv 1 1 0\r\nv 0 1 0\r\nvn 0 0 1\r\n\
            vt 0 0\r\ng roof\r\ns off\r\nmtllib my town.mtl\r\nusemtl tile\xe9 red \r\nf 1 2\\\r\n 3 4 # end\r\nl 1 2\r\ncurv 0 1\r\n";
        let obj = ObjFile::parse(wild, Path::new("town.obj")).expect("readable");
        assert_eq!(obj.vertices.len(), 4);
        assert_eq!(obj.vertices[1], DVec3::new(1.0, 0.0, 0.0));
        assert_eq!(obj.polygons().next().expect("a face").corners, [0, 1, 2, 3]);
        assert_eq!(obj.material_names, ["tile\u{fffd} red"]);
        assert_eq!((obj.libraries[0].line, obj.libraries[0].text.as_str()), (11, "my town.mtl"));
        assert_eq!(obj.warnings.len(), 1);
        assert!(obj.warnings[0].contains("line 16: `curv`"), "{}", obj.warnings[0]);
    }

    /// Faces before any `usemtl` are of the material "default", and a name used twice is one material.
    #[test]
    fn materials_in_file_order() {
        let obj = parse(&format!("{SQUARE}f 1 2 3\nusemtl b\nf 1 2 3\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n"));
        let obj = obj.expect("readable");
        assert_eq!(obj.material_names, ["default", "b", "a"]);
        let used: Vec<u32> = obj.polygons().map(|face| face.material).collect();
        assert_eq!(used, [0, 1, 2, 1]);
    }

    /// Every refusal names the file, the line and the offending text.
    #[test]
    fn refusals() {
        for (text, line, quoted) in [
            ("v 0 0\nf 1", Some(1), "no z coordinate"),
            ("v 0 1,5 0\nf 1", Some(1), "y of the vertex is `1,5`"),
            ("#\nv nan 0 0\nf 1", Some(2), "x of the vertex is `nan`"),
            ("v 0 0 -inf\nf 1", Some(1), "z of the vertex is `-inf`"),
            ("v 0 0 1e999\nf 1", Some(1), "`1e999`"),
            ("v 0 -1.1e9 0\nf 1", Some(1), "`-1.1e9`"),
            ("v 0 0 0\nf 1 0/1 1", Some(2), "`0/1`"),
            ("v 0 0 0\nf 1 -2 1", Some(2), "use 1 to 1, or -1 to -1"),
            ("f -1 -2 -3\nv 0 0 0", Some(1), "before the faces"),
            ("v 0 0 0\nf 1 2 9/4 1\n", Some(2), "corner 9 points beyond the 1 vertices"),
            ("v 0 0 0\nf 1 x 1", Some(2), "`x`"),
            ("v 0 0 0\nf 1 1.5 1", Some(2), "`1.5`"),
            ("v 0 0 0\nf 1 /2 1", Some(2), "`/2`"),
            ("v 0 0 0\nf 99999999999999999999 1 1", Some(2), "`99999999999999999999`"),
            ("v 0 0 0\nf 5000000000 1 1", Some(2), "5000000000"),
            ("v 0 0 0\nl 1 1\n", None, "holds no faces"),
            ("", None, "holds no faces"),
        ] {
            let message = parse(text).expect_err(text).to_string();
            let place = match line {
                Some(line) => format!("town.obj, line {line}: "),
                None => "town.obj: ".to_owned(),
            };
            assert!(message.starts_with(&place) && message.contains(quoted), "{text:?}: {message}");
        }
    }
}
