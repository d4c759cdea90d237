//! Selection of materials. In: a table of materials and the names in use. Out: one checked material
//! for each name.

use std::collections::BTreeMap;
use std::path::Path;

use heliotile_core::site::material::{Class, Material};
use heliotile_core::site::receiver::MAX_NAME_BYTES;
use heliotile_core::text::{listed, message};

use crate::text::excerpt;
use heliotile_core::error::{Error, Problem, Result};

/// Parts of names that make a material ground.
const GROUND: [&str; 15] = [
    "terrain",
    "ground",
    "road",
    "grass",
    "soil",
    "water",
    "street",
    "pavement",
    "paved",
    "landcover",
    "landuse",
    "plantcover",
    "railway",
    "traffic",
    "transport",
];
/// Whole words that make a material ground if no word of `BUILT` stands beside them. Concrete is
/// missing: walls are made of it.
const GROUND_WORDS: [&str; 32] = [
    "asphalt",
    "boden",
    "court",
    "driveway",
    "earth",
    "fahrbahn",
    "footpath",
    "footway",
    "garden",
    "gehweg",
    "gravel",
    "lawn",
    "meadow",
    "mud",
    "parking",
    "parkplatz",
    "path",
    "platz",
    "playground",
    "plaza",
    "rasen",
    "sand",
    "schotter",
    "sidewalk",
    "snow",
    "square",
    "tarmac",
    "track",
    "wiese",
    "yard",
    "courtyard",
    "acker",
];
/// Words of what stands, or lies on a roof.
const BUILT: [&str; 22] = [
    "wall", "walls", "roof", "rooftop", "roofs", "facade", "house", "building", "tower", "hotel", "garage", "deck",
    "column", "beam", "brick", "tile", "window", "door", "frame", "fence", "shingle", "shingles",
];

/// Returns the class of a material that does not state one. It is ground if the name, in lower
/// case, ends with "relief" or contains a part of `GROUND`, or has a word of `GROUND_WORDS` and
/// none of `BUILT`; words end where letters end and before capitals. `class = "obstruction"`
/// corrects a "background".
pub fn class_of_name(name: &str) -> Class {
    let lower = name.to_lowercase();
    if lower.ends_with("relief") || GROUND.iter().any(|part| lower.replace("broad", "").contains(part)) {
        return Class::Ground;
    }
    let mut words = vec![String::new()];
    let mut before = ' ';
    for letter in name.chars() {
        if !letter.is_alphabetic() || letter.is_uppercase() && before.is_lowercase() {
            words.push(String::new());
        }
        if let (true, Some(word)) = (letter.is_alphabetic(), words.last_mut()) {
            word.extend(letter.to_lowercase());
        }
        before = letter;
    }
    let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    let lane = words.iter().any(|word| word.ends_with("strasse") || word.ends_with("straße"));
    if (lane || has(&GROUND_WORDS)) && !has(&BUILT) { Class::Ground } else { Class::Obstruction }
}

/// Name of a material in the scene, with the number of its triangles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MaterialUse {
    /// Name in the files of the scene.
    pub name: String,
    /// Number of triangles of this material.
    pub triangles: usize,
}

/// Materials by name, used or not.
pub(crate) type MaterialTable = BTreeMap<String, Material>;

/// Returns the materials in use, in their order, and the rest of the table. `source` is the file
/// that filled the table (`materials.toml`, or the OBJ file whose libraries were read), for errors.
pub(crate) fn select(
    mut table: MaterialTable,
    used: &[MaterialUse],
    source: &Path,
) -> Result<(Vec<Material>, MaterialTable)> {
    let missing: Vec<&MaterialUse> = used.iter().filter(|entry| !table.contains_key(&entry.name)).collect();
    if let [first, others @ ..] = missing.as_slice() {
        let mut what = format!(
            "no reflectances for material `{}`, which {} triangles use",
            excerpt(first.name.as_bytes()),
            first.triangles
        );
        if !others.is_empty() {
            let names = others.iter().take(10).map(|entry| format!("`{}`", excerpt(entry.name.as_bytes())));
            what += &format!("; {} more are missing: {}", others.len(), listed(names, others.len()));
        }
        let mut hint = message!(
            "add to materials.toml, given with {{materials}}: {} and below it: diffuse = 0.2",
            table_header(&first.name)
        );
        let alike = first.name.to_lowercase();
        if let Some(near) = table.keys().find(|name| name.trim().to_lowercase() == alike) {
            hint = hint.and(format!(" (there is a `{}`: case and blanks count)", excerpt(near.as_bytes())));
        }
        return Err(Error::input(source, None, what, hint).because(Problem::unknown(&first.name, [])));
    }
    let materials: Vec<Material> = used.iter().filter_map(|entry| table.remove(&entry.name)).collect();
    for material in &materials {
        let longest = material.name.len().max(material.group.as_ref().map_or(0, String::len));
        if longest > MAX_NAME_BYTES {
            let what =
                format!("material `{}` has a name or a group of {longest} bytes", excerpt(material.name.as_bytes()));
            return Err(Error::input(source, None, what, "names have at most 1024 bytes"));
        }
    }
    Ok((materials, table))
}

/// Returns the name that a misspelt one most likely stands for; the first of equally similar names.
pub fn nearest<'n>(name: &str, others: &[&'n str]) -> Option<&'n str> {
    /// Least similarity: names below it are other names.
    const MIN_ALIKE: f64 = 0.6;
    let name = name.to_lowercase();
    let mut best: Option<(f64, &str)> = None;
    for other in others {
        let alike = strsim::normalized_damerau_levenshtein(&name, &other.to_lowercase());
        if alike >= MIN_ALIKE && best.is_none_or(|(most, _)| alike > most) {
            best = Some((alike, other));
        }
    }
    best.map(|found| found.1)
}

/// Returns the line that opens the table of a name, quoted where TOML requires it.
pub(crate) fn table_header(name: &str) -> String {
    let bare = !name.is_empty() && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-_".contains(&byte));
    // The name stays whole as far as possible, because the line is meant to be copied.
    let whole = name.len() <= 200 && !name.contains(char::is_control);
    let name = if whole { name.to_owned() } else { excerpt(name.as_bytes()) };
    if bare { format!("[{name}]") } else { format!("[\"{}\"]", name.replace('\\', "\\\\").replace('"', "\\\"")) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::materials::toml_file::parse_toml;

    fn parse(text: &str) -> Result<MaterialTable> {
        parse_toml(text, Path::new("materials.toml")).map(|read| read.0)
    }

    fn used(names: &[(&str, usize)]) -> Vec<MaterialUse> {
        names.iter().map(|&(name, triangles)| MaterialUse { name: name.to_owned(), triangles }).collect()
    }

    /// Names of ground as people and programs write them: 24 of 24 are ground; 12 of 12 names of
    /// what stands are not, though a word of ground is part of them.
    #[test]
    fn words_for_ground_are_known() {
        let ground = "asphalt Asphalt_01 gravel lawn meadow garden sidewalk plaza square sand snow earth parking path track \
                      court tarmac boden platz strasse Hauptstraße TennisCourt parkingLot GroundSurface";
        let built = "concrete sandstone roof_garden GravelRoof asphalt_shingles garden_wall ParkingGarage pathology broadleaf \
                     square_tower courtyardWall snow_fence";
        for (names, count, class) in [(ground, 24, Class::Ground), (built, 12, Class::Obstruction)] {
            let found: Vec<Class> = names.split_whitespace().map(class_of_name).collect();
            assert_eq!(found, vec![class; count], "{names}");
        }
    }

    /// A used material without a table is an error with its triangle count and the lines to add;
    /// [default] does not stand in for it.
    #[test]
    fn a_used_material_without_table_is_an_error() {
        let table = parse("[default]\ndiffuse = 0.2\n[roof]\ndiffuse = 0.2").expect("readable");
        let wanted = used(&[("Roof", 12), ("wall \"b\"", 3)]);
        let message = select(table, &wanted, Path::new("materials.toml")).expect_err("missing").to_string();
        for part in [
            "materials.toml: ",
            "`Roof`, which 12 triangles",
            "1 more are missing: `wall \"b\"`",
            "[Roof]",
            "there is a `roof`",
        ] {
            assert!(message.contains(part), "{part}: {message}");
        }
        assert_eq!(table_header("wall \"b\""), "[\"wall \\\"b\\\"\"]");
    }

    /// Four of five misspelt names find the right name; one that is similar to none finds none.
    #[test]
    fn misspelt_names_find_the_nearest_one() {
        let names = ["GroundSurface", "RoofSurface", "WallSurface", "roof"];
        for (name, near) in [
            ("wallsurface", Some("WallSurface")),
            ("Roof_Surface", Some("RoofSurface")),
            ("rof", Some("roof")),
            ("GroudSurface", Some("GroundSurface")),
            ("lawn", None),
        ] {
            assert_eq!(nearest(name, &names), near, "{name}");
        }
    }

    /// Materials come in the order of use; the unused one is left in the table.
    #[test]
    fn materials_come_in_the_order_of_use() {
        let table = parse("[c]\ndiffuse = 0.3\n[a]\ndiffuse = 0.1\n[b]\ndiffuse = 0.2").expect("readable");
        let (materials, left) = select(table, &used(&[("a", 1), ("c", 1)]), Path::new("m")).expect("all there");
        assert_eq!(materials.iter().map(|material| material.diffuse).collect::<Vec<_>>(), [0.1, 0.3]);
        assert_eq!(left.keys().collect::<Vec<_>>(), ["b"]);
    }

    /// A name or a group of 1025 bytes is refused before anything is traced; one of 1024 bytes is
    /// accepted.
    #[test]
    fn names_beyond_1024_bytes_are_refused() {
        for (name, group, fits) in [(1024, 1024, true), (1025, 1, false), (1, 1025, false)] {
            let (name, group) = ("n".repeat(name), "g".repeat(group));
            let table = parse(&format!("[{name}]\ndiffuse = 0.3\ngroup = \"{group}\"")).expect("readable");
            let message = select(table, &used(&[(&name, 1)]), Path::new("materials.toml")).err().map(|e| e.to_string());
            assert_eq!(message.is_none(), fits);
            assert!(message.is_none_or(|message| message.contains("a name or a group of 1025 bytes")));
        }
    }
}
