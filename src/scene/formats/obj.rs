//! In: the bytes of a Wavefront OBJ file. Out: its polygons, materials and objects, every index
//! checked.

use std::path::Path;

use glam::DVec3;

use crate::coordinate::MAX_COORDINATE_M;
use crate::formats::mtl;
use crate::formats::mtl::{Library, UsedMaterials};
use crate::formats::{ReadOptions, stem};
use crate::geometry::Geometry;
use crate::placing::y_up::HeaderUp;
use crate::text::{Lines, Words, excerpt, keyword_and_rest, leading_index, number};
use heliotile_core::error::{Error, Problem, Result};

/// Name of the material of faces before any `usemtl`.
pub(super) const DEFAULT_MATERIAL: &str = "default";

/// Most kinds of ignored statements that get a warning each; a hostile file holds millions.
const MAX_KINDS_IGNORED: usize = 16;

/// Most lines of comments at the head of a file that are searched.
const MAX_COMMENTS: usize = 20;

/// Reads an OBJ file, and its MTL libraries where reflectances are wanted.
pub(super) fn read(bytes: &[u8], path: &Path, asked: &ReadOptions) -> Result<Geometry> {
    let (mut geometry, libraries) = parse(bytes, path)?;
    if geometry.materials.as_slice().iter().any(|name| asked.wants(name)) {
        let names = geometry.materials.as_slice();
        let wanted = UsedMaterials { asked, used: names.iter().map(String::as_str).collect() };
        geometry.stated = mtl::read_libraries(path, &libraries, &wanted, &mut geometry.warnings)?;
    }
    Ok(geometry)
}

pub(crate) fn parse(bytes: &[u8], file: &Path) -> Result<(Geometry, Vec<Library>)> {
    let mut reader = Reader::new(file);
    reader.geometry.header_up = header_up(bytes);
    let mut lines = Lines::new(bytes);
    while let Some((line, text)) = lines.next() {
        let (keyword, rest) = keyword_and_rest(text);
        match keyword {
            b"v" => reader.vertex(line, rest)?,
            b"f" => reader.face(line, rest)?,
            b"usemtl" => reader.use_material(rest),
            b"o" | b"g" => reader.use_object(rest),
            b"mtllib" => reader.libraries.push(Library { line, text: String::from_utf8_lossy(rest).into_owned() }),
            b"vn" | b"vt" | b"s" | b"l" | b"p" => {}
            other => reader.ignore(line, other),
        }
    }
    reader.finish()
}

/// Returns what the comments at the head of a file say about its up axis.
fn header_up(bytes: &[u8]) -> Option<HeaderUp> {
    let comments = bytes.split(|byte| *byte == b'\n').map_while(|line| line.trim_ascii().strip_prefix(b"#"));
    comments.take(MAX_COMMENTS).filter_map(HeaderUp::of_comment).max()
}

struct Reader<'f> {
    file: &'f Path,
    geometry: Geometry,
    libraries: Vec<Library>,
    material: Option<u32>,
    object: Option<u32>,
    /// Largest vertex index beyond the vertices read so far, and its line; it is allowed if the
    /// vertex comes later.
    ahead: Option<(i64, usize)>,
    /// Keyword, first line and count of each kind of statement that this reader ignores.
    ignored: Vec<(Vec<u8>, usize, usize)>,
}

impl<'f> Reader<'f> {
    fn new(file: &'f Path) -> Self {
        Reader {
            file,
            geometry: Geometry::default(),
            libraries: Vec::new(),
            material: None,
            object: None,
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
        self.geometry.push_vertex(self.file, position).map(drop)
    }

    #[inline]
    fn coordinate(&self, line: usize, axis: &str, word: Option<&[u8]>) -> Result<f64> {
        let value = word.and_then(number);
        match value {
            Some(value) if value.abs() <= MAX_COORDINATE_M => Ok(value),
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
        let found = word.map(|word| excerpt(word).to_string()).unwrap_or_default();
        Error::input(self.file, line, what, hint).because(Problem::value(axis, found))
    }

    fn face(&mut self, line: usize, text: &[u8]) -> Result<()> {
        let Geometry { materials, objects, .. } = &mut self.geometry;
        let material = *self.material.get_or_insert_with(|| materials.id(DEFAULT_MATERIAL));
        let object = *self.object.get_or_insert_with(|| objects.id(&stem(self.file)));
        for word in Words(text) {
            let corner = self.corner(line, word)?;
            self.geometry.push_corner(corner);
        }
        self.geometry.end_face(material, object, line);
        Ok(())
    }

    /// Returns the vertex of a face corner `a`, `a/b`, `a//c` or `a/b/c`, counted from 0.
    #[inline]
    fn corner(&mut self, line: usize, word: &[u8]) -> Result<u32> {
        let count = self.geometry.vertices.len() as i64;
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
        let count = self.geometry.vertices.len();
        let what = match leading_index(word) {
            Some(0) => format!("face corner `{}` points to vertex 0, but vertices count from 1", excerpt(word)),
            Some(_) => format!("face corner `{}` points beyond the {count} vertices above this line", excerpt(word)),
            None => format!("face corner `{}` is not a vertex number", excerpt(word)),
        };
        let allowed = match count {
            0 => "put the `v` lines before the faces that use them".to_owned(),
            _ => format!("use 1 to {count}, or -{count} to -1 counted back from this line"),
        };
        Error::input(self.file, line, what, allowed).because(Problem::value("f", String::from_utf8_lossy(word)))
    }

    fn use_material(&mut self, name: &[u8]) {
        let name = match name {
            [] => DEFAULT_MATERIAL.into(),
            _ => String::from_utf8_lossy(name),
        };
        self.material = Some(self.geometry.materials.id(&name));
    }

    /// Starts a group or object; without a name, faces belong to the object named after the file.
    fn use_object(&mut self, name: &[u8]) {
        self.object = match name {
            [] => None,
            _ => Some(self.geometry.objects.id(&String::from_utf8_lossy(name))),
        };
    }

    fn ignore(&mut self, line: usize, keyword: &[u8]) {
        if let Some(known) = self.ignored.iter_mut().find(|(kind, ..)| kind == keyword) {
            known.2 += 1;
        } else if self.ignored.len() < MAX_KINDS_IGNORED {
            self.ignored.push((keyword.to_vec(), line, 1));
        }
    }

    fn finish(mut self) -> Result<(Geometry, Vec<Library>)> {
        let count = self.geometry.vertices.len();
        // A face may name a later vertex, so that its index can be checked only now.
        if let Some((index, line)) = self.ahead.filter(|&(index, _)| index > count as i64) {
            return Err(Error::input(
                self.file,
                line,
                format!("face corner {index} points beyond the {count} vertices of the file"),
                format!("use 1 to {count}, or negative numbers to count back from the line"),
            )
            .because(Problem::value("f", index.to_string())));
        }
        if self.geometry.face_count() == 0 {
            return Err(Error::input(
                self.file,
                None,
                format!("the file holds no faces ({count} vertices were read)"),
                "export surfaces as `f` lines; points, lines and free-form surfaces are not read",
            )
            .because(Problem::Empty));
        }
        for (keyword, line, times) in &self.ignored {
            self.geometry.warnings.push(
                format!(
                    "{}, line {line}: `{}` is not a polygon statement; {times} such lines are ignored",
                    self.file.display(),
                    excerpt(keyword)
                )
                .into(),
            );
        }
        Ok((self.geometry, self.libraries))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Geometry> {
        super::parse(text.as_bytes(), Path::new("town.obj")).map(|read| read.0)
    }

    fn corners(text: &str) -> Vec<Vec<u32>> {
        let obj = parse(text).expect("readable");
        obj.faces().map(|face| face.corners().to_vec()).collect()
    }

    const SQUARE: &str = "v 0 0 0\nv 1 0 0 1.0\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0\n";

    /// All four spellings of a corner, relative indices and indices of later vertices name the
    /// right vertex.
    #[test]
    fn every_spelling_of_a_corner_names_its_vertex() {
        let text = format!("{SQUARE}f 1 2/7 3//8 4/9/9\nf -4 -3/1 -2//1 -1/1/1\nf 1 2 5\nv 3 3 3 # late\n");
        assert_eq!(corners(&text), [vec![0, 1, 2, 3], vec![0, 1, 2, 3], vec![0, 1, 4]]);
    }

    /// CRLF, tabs, leading blanks, continued lines, comments and bytes that are not UTF-8 change
    /// nothing.
    #[test]
    fn line_ends_and_comments_change_nothing() {
        let wild = b"\xef\xbb\xbf# caf\xe9\r\no b\r\n \tv\t0 0 0\r\nv 1. +0 .0e0\r\nv 1 1 0\r\nv 0 1 0\r\nvn 0 0 1\r\n\
            vt 0 0\r\ng roof\r\ns off\r\nmtllib my town.mtl\r\nusemtl tile\xe9 red \r\nf 1 2\\\r\n 3 4 # end\r\nl 1 2\r\ncurv 0 1\r\n";
        let (obj, libraries) = super::parse(wild, Path::new("town.obj")).expect("readable");
        assert_eq!(obj.vertices.len(), 4);
        assert_eq!(obj.vertices[1], DVec3::new(1.0, 0.0, 0.0));
        assert_eq!(obj.faces().next().expect("a face").corners(), [0, 1, 2, 3]);
        assert_eq!(obj.materials.as_slice(), ["tile\u{fffd} red"]);
        assert_eq!((libraries[0].line, libraries[0].text.as_str()), (11, "my town.mtl"));
        assert_eq!((obj.objects.as_slice(), obj.warnings.len()), (&["b".to_owned(), "roof".to_owned()][..], 1));
        assert!(obj.warnings[0].contains("line 16: `curv`"), "{:?}", obj.warnings[0]);
    }

    /// Faces before any `usemtl` have the material "default", and a name used twice is one
    /// material.
    #[test]
    fn materials_keep_the_order_of_the_file() {
        let obj = parse(&format!("{SQUARE}f 1 2 3\nusemtl b\nf 1 2 3\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n"));
        let obj = obj.expect("readable");
        assert_eq!(obj.materials.as_slice(), ["default", "b", "a"]);
        let used: Vec<u32> = obj.faces().map(|face| face.material).collect();
        assert_eq!(used, [0, 1, 2, 1]);
    }

    /// Every refusal names the file, the line and the offending text.
    #[test]
    fn refusals_name_file_line_and_text() {
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
