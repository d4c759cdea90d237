//! Font of all pictures: Arimo, whose source `font/README.md` states. In: words and the size of
//! their letters. Out: their width, and their outlines.

use std::sync::LazyLock;

use ttf_parser::{Face, OutlineBuilder};

/// Families of SVG: letters of the first four are equally wide, and systems have one of them.
pub const FAMILIES: &str = "Arial, Helvetica, Liberation Sans, Arimo, sans-serif";

/// Offset of the baseline below the middle of capital letters, as a multiple of their size.
pub const BASELINE: f64 = 0.5 * 1409.0 / 2048.0;

static FACES: LazyLock<[Option<Face<'static>>; 2]> = LazyLock::new(|| {
    let files: [&[u8]; 2] = [include_bytes!("font/regular.ttf"), include_bytes!("font/bold.ttf")];
    files.map(|file| Face::parse(file, 0).ok())
});

/// Size of letters, pixels, and their weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Font {
    pub size: f64,
    pub is_bold: bool,
}

impl Font {
    pub const fn new(size: f64) -> Self {
        Font { size, is_bold: false }
    }

    pub const fn bold(size: f64) -> Self {
        Font { size, is_bold: true }
    }

    fn face(self) -> Option<&'static Face<'static>> {
        FACES[usize::from(self.is_bold)].as_ref()
    }

    /// Returns pixels for each unit of outlines.
    pub fn scale(self) -> f64 {
        self.face().map_or(0.0, |face| self.size / f64::from(face.units_per_em()))
    }

    /// Returns the width of words, pixels.
    pub fn width(self, words: &str) -> f64 {
        let Some(face) = self.face() else { return 0.0 };
        let letter = |letter| face.glyph_hor_advance(face.glyph_index(letter).unwrap_or_default()).unwrap_or_default();
        words.chars().map(|c| f64::from(letter(c))).sum::<f64>() * self.scale()
    }

    /// Returns words that are at most `room` pixels wide: longer ones end with an ellipsis.
    pub fn fitted(self, words: &str, room: f64) -> String {
        if self.width(words) <= room {
            return words.to_owned();
        }
        let ends = words.char_indices().rev().map(|(at, _)| format!("{}\u{2026}", words[..at].trim_end()));
        ends.into_iter().find(|short| self.width(short) <= room).unwrap_or_default()
    }

    /// Passes the outlines of words to `pen`, letter by letter; `move_by` gets the distance of each
    /// letter from the first. Both are in units of outlines, y up. A letter that the font lacks is
    /// an empty box.
    pub fn outline<P: OutlineBuilder>(self, words: &str, pen: &mut P, move_by: impl Fn(&mut P, f32)) {
        let Some(face) = self.face() else { return };
        let mut along = 0_u32;
        for glyph in words.chars().map(|letter| face.glyph_index(letter).unwrap_or_default()) {
            move_by(pen, along as f32);
            // Blanks have no outline.
            let _ = face.outline_glyph(glyph, pen);
            along += u32::from(face.glyph_hor_advance(glyph).unwrap_or_default());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both faces have letters with accents, Greek, Cyrillic and the symbols of pictures, 10 of 10;
    /// bold words are wider, and a width is proportional to the size.
    #[test]
    fn the_font_has_the_letters_of_pictures() {
        for face in FACES.iter() {
            let face = face.as_ref().expect("a font");
            let found = "Aé\u{142}\u{3a9}\u{416}\u{b2}\u{b0}\u{2026}\u{2264}\u{25b2}".chars();
            assert_eq!(found.filter(|letter| face.glyph_index(*letter).is_some()).count(), 10);
        }
        let width = |font: Font| font.width("Irradiation");
        assert!(width(Font::bold(14.0)) > width(Font::new(14.0)));
        assert!((width(Font::new(28.0)) - 2.0 * width(Font::new(14.0))).abs() < 1e-9 && width(Font::new(14.0)) > 50.0);
    }

    /// Words that have room stay whole. Longer ones end with an ellipsis within the room, and
    /// without any room nothing is left.
    #[test]
    fn long_words_end_with_an_ellipsis() {
        let (font, name) = (Font::new(13.0), "NL.IMBAG.Pand.0518100000271783");
        assert_eq!(font.fitted(name, 300.0), name);
        let short = font.fitted(name, 100.0);
        assert!(short.starts_with("NL.IMBAG") && short.ends_with('\u{2026}') && font.width(&short) <= 100.0, "{short}");
        assert_eq!(font.fitted(name, 1.0), "");
    }
}
