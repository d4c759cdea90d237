//! Layers of a file of several. In: their names, and those that the user asks for. Out: the layers
//! that are read, and a sentence on those that are left out.

use heliotile_core::text::{Message, message, with_list};

use crate::text::excerpt;

/// Parts of names of layers of buildings, in lower case.
const BUILDINGS: [&str; 17] = [
    "building",
    "bldg",
    "footprint",
    "gebaeude",
    "geb\u{e4}ude",
    "geb_",
    "batiment",
    "b\u{e2}timent",
    "edific",
    "edifici",
    "pand",
    "bygning",
    "byggnad",
    "rakennus",
    "budyn",
    "immeuble",
    "house",
];

/// Layers of a file.
pub(super) struct Chosen {
    pub read: Vec<String>,
    pub left_out: Vec<String>,
}

impl Chosen {
    /// Returns a sentence on the layers that are left out, if there are any.
    pub(super) fn said(&self) -> Option<Message> {
        let quoted = |name: &String| format!("`{}`", excerpt(name.as_bytes()));
        let read: Vec<String> = self.read.iter().map(quoted).collect();
        let sentence =
            message!("layers read: {}; layers left out, which {{layer}} NAME reads instead", read.join(", "));
        (!self.left_out.is_empty()).then(|| with_list(&sentence, self.left_out.iter().map(quoted)))
    }
}

/// Chooses among layers: those that `asked` names; else, of layers that are levels of detail of one
/// model, the level `lod` or the finest one, bodies before outlines; else those with names of
/// buildings; else all.
pub(super) fn chosen(names: &[String], asked: &[String], lod: Option<&str>) -> Result<Chosen, String> {
    let split = |is_read: &dyn Fn(&String) -> bool| {
        let (read, left_out) = names.iter().cloned().partition(|name| is_read(name));
        Chosen { read, left_out }
    };
    if let Some(missing) = asked.iter().find(|asked| !names.iter().any(|name| name.eq_ignore_ascii_case(asked))) {
        let all: Vec<String> = names.iter().map(|name| format!("`{}`", excerpt(name.as_bytes()))).collect();
        return Err(format!("the file has no layer `{}`, but {}", excerpt(missing.as_bytes()), all.join(", ")));
    }
    if !asked.is_empty() {
        return Ok(split(&|name| asked.iter().any(|asked| name.eq_ignore_ascii_case(asked))));
    }
    let wanted = lod.map(|lod| lod.chars().filter(char::is_ascii_digit).collect::<String>());
    let levels = names.iter().filter_map(|name| level_of(name));
    let of_wanted = |level: &Level| wanted.as_ref().is_none_or(|wanted| level.digits.starts_with(wanted));
    if let Some(finest) = levels.filter(of_wanted).max() {
        return Ok(split(&|name| level_of(name).as_ref() == Some(&finest)));
    }
    let is_building = |name: &String| {
        let lower = name.to_lowercase();
        BUILDINGS.iter().any(|part| lower.contains(part))
    };
    Ok(match names.iter().any(is_building) {
        true => split(&is_building),
        false => split(&|_| true),
    })
}

/// Level of detail that the name of a layer states; solids order after outlines.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Level {
    is_solid: bool,
    digits: String,
}

/// Returns the level in a name such as `lod22_3d` (3DBAG), `lod13_2d`, `LoD2.2` or `lod2`.
fn level_of(name: &str) -> Option<Level> {
    let lower = name.to_lowercase();
    let (_, rest) = lower.split_once("lod")?;
    let (number, kind) = rest.split_at(rest.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(rest.len()));
    let digits: String = number.chars().filter(char::is_ascii_digit).collect();
    (!digits.is_empty()).then(|| Level { is_solid: !kind.contains("2d"), digits })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Among three layers the one of buildings is read, among three levels the finest solids or the
    /// one that is asked for; a name that is asked for counts alone, and one that is missing is
    /// refused.
    #[test]
    fn one_theme_and_one_level_of_a_file_are_read() {
        let read = |names: &[&str], asked: &[&str], lod: Option<&str>| {
            let [names, asked] = [names, asked].map(|names| names.iter().map(ToString::to_string).collect::<Vec<_>>());
            chosen(&names, &asked, lod).map(|chosen| chosen.read.join(" ")).map_err(|_| ())
        };
        let mixed = ["buildings", "forest", "districts"];
        let bag = ["lod12_3d", "lod13_3d", "lod22_2d", "lod22_3d", "pand"];
        for (names, asked, lod, expected) in [
            (&mixed[..], &[][..], None, Ok("buildings")),
            (&mixed, &["FOREST"], None, Ok("forest")),
            (&mixed, &["woods"], None, Err(())),
            (&bag, &[], None, Ok("lod22_3d")),
            (&bag, &[], Some("1.3"), Ok("lod13_3d")),
            (&bag, &["pand"], None, Ok("pand")),
            (&["lines", "multipolygons"], &[], None, Ok("lines multipolygons")),
        ] {
            assert_eq!(read(names, asked, lod), expected.map(str::to_owned), "{names:?} {asked:?} {lod:?}");
        }
        let all = mixed.map(str::to_owned);
        let said = chosen(&all, &[], None).ok().and_then(|chosen| chosen.said()).expect("a sentence");
        assert!(said.contains("layers read: `buildings`") && said.contains("`forest`"), "{said:?}");
    }
}
