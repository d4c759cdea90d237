//! In: the MTL libraries that an OBJ file names. Out: materials by name, for scenes without a
//! `materials.toml`.
//!
//! MTL files were made for pictures, so they are a fallback. A material without `Kd`, or with a
//! white one, says nothing of its colour, and the usual reflectance for its name applies. Diffuse
//! is the plain mean of the three `Kd` channels. Specular is the mean of `Ks` where `illum` is 3 or
//! above (the models with true mirrors) and 0 otherwise, because `Ks` is mere gloss there.

use crate::materials::assumed::{WHITE_WORDS, assumed, is_white, undescribed};
use crate::materials::select::class_of_name;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

use crate::formats::ReadOptions;
use crate::materials::select::MaterialTable;
use crate::text::{Lines, Words, excerpt, keyword_and_rest, number, utf8};
use heliotile_core::error::{Error, Result};
use heliotile_core::site::material::Material;
use heliotile_core::text::{Message, message, with_list};
use heliotile_files::input;

/// Materials that are wanted from the libraries of an OBJ file.
pub(super) struct UsedMaterials<'a> {
    pub asked: &'a ReadOptions,
    /// Names that faces use; several files may share a library and use a part of it each.
    pub used: HashSet<&'a str>,
}

impl UsedMaterials<'_> {
    fn wants(&self, material: &str) -> bool {
        self.asked.wants(material) && self.used.contains(material)
    }
}

/// Names of materials that a library names but does not describe: without a `Kd`, or with a white
/// one.
#[derive(Debug, Default)]
struct Undescribed {
    without: Vec<String>,
    white: Vec<String>,
}

/// Reads the libraries of an OBJ file. A missing library is only a warning, because its materials
/// may not be needed.
pub(super) fn read_libraries(
    obj: &Path,
    libraries: &[Library],
    wanted: &UsedMaterials,
    warnings: &mut Vec<Message>,
) -> Result<MaterialTable> {
    let folder = obj.parent().unwrap_or(Path::new(""));
    let mut table = MaterialTable::new();
    let mut done: Vec<PathBuf> = Vec::new();
    for library in libraries {
        for path in files_of(folder, &library.text) {
            if done.contains(&path) {
                continue;
            }
            if path.is_file() {
                let bytes = utf8(input::read(&path)?);
                let mut odd = Vec::new();
                let nothing = parse(&bytes, &path, wanted, &mut table, &mut odd)?;
                warnings.extend(undescribed(&path, &nothing.without, "without a `Kd`"));
                warnings.extend(undescribed(&path, &nothing.white, WHITE_WORDS));
                // A library of hundreds of materials would otherwise flood the warnings.
                if odd.len() > MAX_ODD {
                    let sentence = format!(
                        "{}: {} properties of materials are ignored or changed (textures, transparency, reflectances above 1 in \
                         sum, second definitions)",
                        path.display(),
                        odd.len()
                    );
                    warnings.push(with_list(sentence, odd.drain(..).map(|odd| odd.plain())));
                }
                warnings.append(&mut odd);
            } else {
                warnings.push(
                    format!(
                        "{}, line {}: the material library {} was not found",
                        obj.display(),
                        library.line,
                        path.display()
                    )
                    .into(),
                );
            }
            done.push(path);
        }
    }
    Ok(table)
}

/// Most remarks on a library that get a warning each; more than that become one list.
const MAX_ODD: usize = 3;

/// Returns the paths in the text of an `mtllib` statement: one path if a file has the whole text as
/// its name (with its blanks), otherwise one for each word.
fn files_of(folder: &Path, text: &str) -> Vec<PathBuf> {
    let place = |name: &str| {
        let direct = input::plain_or_packed(folder.join(name));
        if direct.is_file() { direct } else { input::plain_or_packed(folder.join(name.replace('\\', "/"))) }
    };
    let whole = place(text.trim_matches('"'));
    if whole.is_file() {
        return vec![whole];
    }
    text.split_whitespace().map(place).collect()
}

/// A `newmtl` block that is being read.
struct Block {
    name: String,
    line: usize,
    diffuse: Option<f64>,
    specular: f64,
    mirror: bool,
    not_modelled: bool,
}

fn parse(
    bytes: &[u8],
    file: &Path,
    wanted: &UsedMaterials,
    table: &mut MaterialTable,
    warnings: &mut Vec<Message>,
) -> Result<Undescribed> {
    let mut nothing = Undescribed::default();
    let mut lines = Lines::new(bytes);
    let mut block: Option<Block> = None;
    while let Some((line, text)) = lines.next() {
        let (keyword, rest) = keyword_and_rest(text);
        if keyword == b"newmtl" {
            if let Some(finished) = block.take() {
                finish(finished, file, table, &mut nothing, warnings);
            }
            let name = String::from_utf8_lossy(rest).into_owned();
            block = wanted.wants(&name).then_some(Block {
                name,
                line,
                diffuse: None,
                specular: 0.0,
                mirror: false,
                not_modelled: false,
            });
            continue;
        }
        // Materials that no face uses are not even checked: libraries are shared by files.
        let Some(block) = &mut block else { continue };
        match keyword {
            b"Kd" => block.diffuse = Some(mean_of_channels(file, line, "Kd", rest)?),
            b"Ks" => block.specular = mean_of_channels(file, line, "Ks", rest)?,
            b"illum" => {
                let model = Words(rest).next().and_then(number).ok_or_else(|| {
                    let what = format!("`illum` is `{}`, not a number", excerpt(rest));
                    Error::input(file, line, what, "write an illumination model from 0 to 10")
                })?;
                block.mirror = model >= 3.0;
            }
            b"map_Kd" | b"map_Ks" | b"map_d" => block.not_modelled = true,
            b"d" => block.not_modelled |= number(rest).is_some_and(|opacity| opacity < 1.0),
            b"Tr" => block.not_modelled |= number(rest).is_some_and(|transparency| transparency > 0.0),
            _ => {}
        }
    }
    if let Some(finished) = block {
        finish(finished, file, table, &mut nothing, warnings);
    }
    Ok(nothing)
}

/// Returns the mean of `r g b`, or `r` alone, which stands for all three channels.
fn mean_of_channels(file: &Path, line: usize, keyword: &str, text: &[u8]) -> Result<f64> {
    let channels: Vec<Option<f64>> = Words(text).take(4).map(number).collect();
    let (sum, count) = match channels.as_slice() {
        [Some(r)] if (0.0..=1.0).contains(r) => (*r, 1.0),
        [Some(r), Some(g), Some(b), ..] if [r, g, b].iter().all(|c| (0.0..=1.0).contains(*c)) => (r + g + b, 3.0),
        _ => {
            let what = format!("`{keyword}` is `{}`, not three numbers from 0 to 1", excerpt(text));
            let hint = message!("write `{keyword} r g b`, or give reflectances in materials.toml ({{materials}})");
            return Err(Error::input(file, line, what, hint));
        }
    };
    Ok(sum / count)
}

fn finish(
    block: Block,
    file: &Path,
    table: &mut MaterialTable,
    nothing: &mut Undescribed,
    warnings: &mut Vec<Message>,
) {
    let shown = excerpt(block.name.as_bytes());
    let place = format!("{}, line {}: material `{shown}`", file.display(), block.line);
    if table.contains_key(&block.name) {
        warnings.push(format!("{place} is defined twice; the first definition is used").into());
        return;
    }
    let stated = block.diffuse.filter(|diffuse| !is_white(*diffuse));
    if stated.is_none() {
        let names = if block.diffuse.is_none() { &mut nothing.without } else { &mut nothing.white };
        names.push(block.name.clone());
        // A mirror is usable: the part that it does not reflect is scattered as usual for its name.
        // Other materials without a colour are unknown.
        if !block.mirror || block.specular == 0.0 {
            return;
        }
    }
    let mut diffuse = stated.unwrap_or_else(|| assumed(&block.name).diffuse);
    let mut specular = if block.mirror { block.specular } else { 0.0 };
    let sum = diffuse + specular;
    if sum > 1.0 {
        diffuse /= sum;
        specular /= sum;
        warnings.push(
            format!("{place} reflects {sum:.3} of the light; scaled to diffuse {diffuse:.3}, specular {specular:.3}")
                .into(),
        );
    }
    if block.not_modelled {
        warnings.push(
            format!("{place} has a texture or is transparent, which is ignored: it is opaque and reflects its Kd")
                .into(),
        );
    }
    let class = class_of_name(&block.name);
    table.insert(block.name.clone(), Material { specular, ..Material::matt(block.name, diffuse, class) });
}

/// One `mtllib` statement: one file name or several, and its line.
#[derive(Debug)]
pub(crate) struct Library {
    pub line: usize,
    pub text: String,
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn asked() -> ReadOptions {
        ReadOptions { reflectances: true, ..ReadOptions::default() }
    }

    fn read(text: &str) -> Result<(MaterialTable, Vec<String>)> {
        let (mut table, mut warnings) = (MaterialTable::new(), Vec::new());
        let used = text.lines().filter_map(|line| line.strip_prefix("newmtl ")).map(str::trim).collect();
        let wanted = UsedMaterials { asked: &asked(), used };
        parse(text.as_bytes(), Path::new("town.mtl"), &wanted, &mut table, &mut warnings)?;
        Ok((table, warnings.iter().map(|said| said.plain()).collect()))
    }

    /// Diffuse is the mean of `Kd`; `Ks` counts only from illumination model 3 on.
    #[test]
    fn diffuse_is_the_mean_of_kd() {
        let (table, warnings) = read(
            "# x\nnewmtl gloss\n\tKd 0.1 0.2 0.6\n Ks 0.5 0.5 0.5\nillum 2\r\nnewmtl my mirror\nKd 0.1\nKs 0.8 0.7 0.9\nillum 3 # mirror\n",
        )
        .expect("readable");
        assert!((table["gloss"].diffuse - 0.3).abs() < 1e-15);
        assert_eq!(table["gloss"].specular, 0.0);
        assert!((table["my mirror"].specular - 0.8).abs() < 1e-15);
        assert_eq!((table["my mirror"].diffuse, warnings.len()), (0.1, 0));
    }

    /// Reflectances above 1 in sum are scaled to 1 with a warning. A second definition is ignored
    /// with a warning, and a texture gets a warning.
    #[test]
    fn scaled_and_repeated_materials_give_warnings() {
        let (table, warnings) =
            read("newmtl a\nKd 1 1 1\nKs 1 1 1\nillum 5\nmap_Kd a.png\nnewmtl a\nKd 0 0 0\n").expect("readable");
        assert_eq!((table["a"].diffuse, table["a"].specular), (0.2 / 1.2, 1.0 / 1.2));
        assert_eq!(warnings.len(), 3);
        assert!(warnings.iter().all(|warning| warning.starts_with("town.mtl, line ")), "{warnings:?}");
    }

    /// Every refusal names the file, the line and the offending text.
    #[test]
    fn refusals_name_file_line_and_text() {
        for (text, line, quoted) in [
            ("newmtl a\nKd 0.1 x 0.2", 2, "`0.1 x 0.2`"),
            ("newmtl a\nKd 0.1 0.2", 2, "`0.1 0.2`"),
            ("newmtl a\nKd spectral a.rfl 1", 2, "`spectral a.rfl 1`"),
            ("newmtl a\nKd 1 1 255", 2, "`1 1 255`"),
            ("newmtl a\nKd 1 1 1\nKs nan 0 0", 3, "`Ks` is `nan 0 0`"),
            ("newmtl a\nKd 1 1 1\nillum matt", 3, "`illum` is `matt`"),
        ] {
            let message = read(text).expect_err(text).to_string();
            assert!(message.starts_with(&format!("town.mtl, line {line}: ")), "{text:?}: {message}");
            assert!(message.contains(quoted), "{text:?}: {message}");
        }
    }

    /// A library describes one of five materials, with 0.9. Three without a `Kd` or with a white
    /// one are not described, textured or not. A white mirror keeps its specular 0.7 and scatters
    /// the usual 0.2. A material that no face uses is not read.
    #[test]
    fn white_materials_have_no_stated_reflectance() {
        let text = "newmtl wall\nKd 1 1 1\nnewmtl roof\nKa 1 1 1\nmap_Kd a.png\nnewmtl near\nKd 0.98 0.99 0.98\nmap_Kd b.png\n\
                    newmtl paint\nKd 0.9 0.9 0.9\nnewmtl mirror\nKd 1 1 1\nKs 0.7 0.7 0.7\nillum 3\nnewmtl unused\nKd spectral a.rfl\n";
        let used = ["wall", "roof", "near", "paint", "mirror"].into();
        let (mut table, mut warnings) = (MaterialTable::new(), Vec::new());
        let wanted = UsedMaterials { asked: &asked(), used };
        let nothing = parse(text.as_bytes(), Path::new("t.mtl"), &wanted, &mut table, &mut warnings).expect("readable");
        assert_eq!(table.keys().collect::<Vec<_>>(), ["mirror", "paint"]);
        assert!((table["paint"].diffuse - 0.9).abs() < 1e-12 && warnings.is_empty(), "{warnings:?}");
        assert!((table["mirror"].specular - 0.7).abs() < 1e-12 && table["mirror"].diffuse == 0.2);
        assert_eq!((nothing.without.len(), nothing.white.len()), (1, 3));
        let said = undescribed(Path::new("t.mtl"), &nothing.white, WHITE_WORDS).expect("white ones");
        assert!(said.plain().starts_with("t.mtl: 3 materials (first: `wall`) of white"), "{said:?}");
    }

    /// Libraries are found beside the OBJ file, with blanks in the name or two on a line. A missing
    /// one is a warning.
    #[test]
    fn libraries_are_found_beside_the_obj_file() {
        let folder = tempfile::tempdir().expect("a scratch folder");
        for (name, material) in [("my town.mtl", "a"), ("b.mtl", "b"), ("c.mtl", "c")] {
            fs::write(folder.path().join(name), format!("newmtl {material}\nKd 0.5\n")).expect("written");
        }
        let libraries =
            ["my town.mtl", "b.mtl c.mtl", "gone.mtl"].map(|text| Library { line: 7, text: text.to_owned() });
        let mut warnings = Vec::new();
        let used = ["a", "b", "c"].into();
        let wanted = UsedMaterials { asked: &asked(), used };
        let table =
            read_libraries(&folder.path().join("town.obj"), &libraries, &wanted, &mut warnings).expect("readable");
        assert_eq!(table.keys().collect::<Vec<_>>(), ["a", "b", "c"]);
        assert_eq!(warnings.len(), 1);
        assert!(warnings[0].contains("line 7") && warnings[0].contains("gone.mtl"), "{:?}", warnings[0]);
    }
}
