//! Materials from a file. In: `materials.toml`. Out: checked materials by name, used or not.

use crate::materials::select::class_of_name;
use heliotile_core::text::Message;
use std::ops::Range;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::coordinate::MAX_COORDINATE_M;
use crate::ground::endless;
use crate::ground::endless::EndlessGround;
use crate::materials::select::{MaterialTable, table_header};
use crate::text::{excerpt, line_of_offset, without_byte_order_mark};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::site::bands::{Band, BandProperty};
use heliotile_core::site::material::{
    BROADLEAF_DIFFUSE, Class, Glass, MAX_LEAF_AREA_DENSITY, Material, left_after_metre,
};
use heliotile_files::input;

const KEYS: &str = "valid keys are `leaf_area_density` (m2/m3, of closed crowns), `diffuse`, `specular` and `transmittance` (numbers from 0 to 1, or by band as in \
                    { solar = 0.25, visible = 0.1, nir = 0.4 }), `emissivity` (longwave, a number from 0 to 1), `glass` (true, \"single\" or \"double\"), `class` (\"ground\" or \
                    \"obstruction\") and `group` (a name)";

/// Key of the value for all light, beside those of bands.
const SOLAR: &str = "solar";

pub(crate) fn read_toml(path: &Path) -> Result<(MaterialTable, Option<EndlessGround>)> {
    let bytes = input::read(path)?;
    let bytes = without_byte_order_mark(&bytes);
    let text = std::str::from_utf8(bytes).map_err(|bad| {
        Error::input(path, line_of_offset(bytes, bad.valid_up_to()), "the text is not UTF-8", "save the file as UTF-8")
    })?;
    parse_toml(text, path)
}

/// Reads all tables of a `materials.toml`. Unused tables are checked, too: a misspelt key must not
/// wait for the next scene. The endless ground is one of the materials.
pub(crate) fn parse_toml(text: &str, file: &Path) -> Result<(MaterialTable, Option<EndlessGround>)> {
    let reader = Reader { text, file };
    let document = DeTable::parse(text).map_err(|error| {
        let hint = "write one table per material, names with blanks or dots in quotes: [\"flat roof\"]";
        reader.error(error.span().unwrap_or(0..0), error.message().to_owned(), hint)
    })?;
    let mut entries: Vec<_> = document.get_ref().iter().collect();
    entries.sort_by_key(|(name, _)| name.span().start);
    let (mut table, mut ground) = (MaterialTable::new(), None);
    for (name, value) in entries {
        let (material, elevation_m) = reader.material(name.get_ref(), name.span(), value.get_ref())?;
        if material.name == endless::NAME {
            ground = Some(EndlessGround { elevation_m });
        }
        table.insert(material.name.clone(), material);
    }
    Ok((table, ground))
}

struct Reader<'t> {
    text: &'t str,
    file: &'t Path,
}

impl Reader<'_> {
    fn error(&self, span: Range<usize>, what: impl Into<Message>, hint: impl Into<Message>) -> Error {
        Error::input(self.file, line_of_offset(self.text.as_bytes(), span.start), what, hint)
    }

    /// Returns a material, and the elevation if the material is the endless ground.
    fn material(&self, name: &str, place: Range<usize>, value: &DeValue) -> Result<(Material, Option<f64>)> {
        let shown = excerpt(name.as_bytes());
        let endless = name == endless::NAME;
        let DeValue::Table(keys) = value else {
            let hint = format!("begin a table with its name: {}; {KEYS}", table_header("roof"));
            return Err(self.error(place, format!("key `{shown}` stands outside any material"), hint));
        };
        let mut entries: Vec<_> = keys.iter().collect();
        entries.sort_by_key(|(key, _)| key.span().start);
        let (mut diffuse, mut class, mut elevation, mut density) = (None, None, None, None);
        let mut material = Material::matt(name, 0.0, class_of_name(name));
        for (key, value) in entries {
            match (key.get_ref().as_ref(), value.get_ref()) {
                ("diffuse", _) => diffuse = Some(self.share(&mut material, BandProperty::Diffuse, value)?),
                ("specular", _) => material.specular = self.share(&mut material, BandProperty::Specular, value)?,
                ("transmittance", _) => {
                    material.transmittance = Some(self.share(&mut material, BandProperty::Transmittance, value)?);
                }
                ("leaf_area_density", _) => density = Some(self.density(&shown, value)?),
                ("emissivity", _) => {
                    let called = format!("`emissivity` of material `{shown}`");
                    material.bands.emissivity = Some(self.fraction(&called, value)?);
                }
                ("glass", DeValue::Boolean(true)) => material.glass = Some(Glass::Single),
                ("glass", DeValue::Boolean(false)) => material.glass = None,
                ("glass", DeValue::String(text)) if text == "single" => material.glass = Some(Glass::Single),
                ("glass", DeValue::String(text)) if text == "double" => material.glass = Some(Glass::Double),
                ("elevation", _) if endless => elevation = Some(self.elevation(value)?),
                ("class", DeValue::String(text)) if Class::of_name(text).is_some() => class = Class::of_name(text),
                ("group", DeValue::String(text)) if !text.trim().is_empty() => material.group = Some(text.to_string()),
                ("class" | "group" | "glass", _) => {
                    let what = format!("`{}` of material `{shown}` is {}", key.get_ref(), self.quote(value));
                    return Err(self.error(value.span(), what, KEYS));
                }
                (inner, DeValue::Table(_)) => {
                    let whole = table_header(&format!("{name}.{inner}"));
                    let what = format!("material `{shown}` holds a table `{}`", excerpt(inner.as_bytes()));
                    let hint = format!("if the name holds a dot, put it in quotes: {whole}; {KEYS}");
                    return Err(self.error(key.span(), what, hint));
                }
                (unknown, _) => {
                    let what = format!("unknown key `{}` of material `{shown}`", excerpt(unknown.as_bytes()));
                    return Err(self.error(key.span(), what, KEYS).because(Problem::unknown(unknown, [])));
                }
            }
        }
        if let Some(density) = density {
            if material.transmittance.is_some() {
                let what = format!("material `{shown}` has a `leaf_area_density` and a `transmittance`");
                let hint = "leave one out: the density is of crowns as volumes, the transmittance of each face";
                return Err(self.error(place, what, hint).because(Problem::excludes("leaf_area_density")));
            }
            (material.transmittance, material.volume) = (Some(left_after_metre(density)), true);
            diffuse = diffuse.or(Some(BROADLEAF_DIFFUSE));
        }
        // Leaves and screens scatter nothing unless the file states it.
        let Some(diffuse) = diffuse.or(material.transmittance.map(|_| 0.0)) else {
            return Err(self.error(place, format!("material `{shown}` has no `diffuse`"), "add a line: diffuse = 0.2"));
        };
        material.diffuse = diffuse;
        material.class = class.unwrap_or(material.class);
        material.check().map_err(|what| self.error(place, format!("material `{shown}`: {what}"), KEYS))?;
        Ok((material, elevation))
    }

    fn density(&self, shown: &str, value: &Spanned<DeValue>) -> Result<f64> {
        number(value).filter(|number| (0.0..=MAX_LEAF_AREA_DENSITY).contains(number)).ok_or_else(|| {
            let what = format!("`leaf_area_density` of material `{shown}` is {}", self.quote(value));
            let hint = format!(
                "give m2 of leaves (one side) per m3 of crown, from 0 to {MAX_LEAF_AREA_DENSITY}; street trees have 0.5 to 2"
            );
            self.error(value.span(), what, hint).because(Problem::value("leaf_area_density", self.quote(value)))
        })
    }

    fn elevation(&self, value: &Spanned<DeValue>) -> Result<f64> {
        let highest = MAX_COORDINATE_M / 10.0;
        number(value).filter(|number| number.abs() <= highest).ok_or_else(|| {
            let what = format!("`elevation` is {}", self.quote(value));
            self.error(value.span(), what, "give the height of the endless ground in metres, or leave it out")
        })
    }

    /// Returns a number from 0 to 1; messages call it `called`.
    fn fraction(&self, called: &str, value: &Spanned<DeValue>) -> Result<f64> {
        number(value).filter(|number| (0.0..=1.0).contains(number)).ok_or_else(|| {
            let what = format!("{called} is {}, not a number from 0 to 1", self.quote(value));
            self.error(value.span(), what, KEYS).because(Problem::value(called, self.quote(value)))
        })
    }

    /// Returns the value of a property for all light, and adds its values by band to the material.
    fn share(&self, material: &mut Material, property: BandProperty, value: &Spanned<DeValue>) -> Result<f64> {
        let of = format!("`{}` of material `{}`", property.name(), excerpt(material.name.as_bytes()));
        let DeValue::Table(by_band) = value.get_ref() else { return self.fraction(&of, value) };
        let names: Vec<&str> = Band::ALL.into_iter().map(Band::name).collect();
        let mut solar = None;
        for (key, value) in by_band {
            let name = key.get_ref().as_ref();
            let share = self.fraction(&format!("{of} for `{}`", excerpt(name.as_bytes())), value)?;
            match Band::of_name(name) {
                Some(band) => {
                    let values = material.bands.of_mut(property);
                    *values = values.with(band, share);
                }
                None if name == SOLAR => solar = Some(share),
                None => {
                    let what = format!("{of} has no band `{}`", excerpt(name.as_bytes()));
                    let hint = format!("give `{SOLAR}` (all light) and some of {}", names.join(", "));
                    return Err(self.error(key.span(), what, hint));
                }
            }
        }
        solar.ok_or_else(|| {
            let what = format!("{of} has values by band and none for all light");
            self.error(
                value.span(),
                what,
                format!("add the value for all light, as in {{ {SOLAR} = 0.2, visible = 0.1 }}"),
            )
            .because(Problem::no_column("solar"))
        })
    }

    /// Returns the value as it is written in the file.
    fn quote(&self, value: &Spanned<DeValue>) -> String {
        excerpt(self.text.get(value.span()).unwrap_or_default().as_bytes())
    }
}

fn number(value: &Spanned<DeValue>) -> Option<f64> {
    match value.get_ref() {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<MaterialTable> {
        parse_toml(text, Path::new("materials.toml")).map(|read| read.0)
    }

    /// Quoted names, optional keys and integers are read. A `specular` that is not given is 0, and
    /// a class that is not given follows the name.
    #[test]
    fn optional_keys_of_a_material_have_defaults() {
        let table = parse(
            "[\"flat roof.1\"]\ndiffuse = 1\n[Road]\ndiffuse = 0.1\nclass = \"obstruction\"\n[mirror]\ndiffuse = 0.05\n\
             specular = 0.9\ngroup = \"facade\"\n[TINRelief]\ndiffuse = 2e-1",
        )
        .expect("readable");
        let roof = &table["flat roof.1"];
        assert_eq!((roof.diffuse, roof.specular, roof.class), (1.0, 0.0, Class::Obstruction));
        assert_eq!(table["Road"].class, Class::Obstruction);
        assert_eq!((table["mirror"].specular, table["mirror"].group.as_deref()), (0.9, Some("facade")));
        assert_eq!((table["TINRelief"].diffuse, table["TINRelief"].class), (0.2, Class::Ground));
    }

    /// Glass has one or two panes, and none if it is false, 4 of 4 ways to state it; a
    /// `transmittance` needs no `diffuse`.
    #[test]
    fn glass_is_read_in_four_ways() {
        for (value, glass) in [
            ("true", Some(Glass::Single)),
            ("\"single\"", Some(Glass::Single)),
            ("\"double\"", Some(Glass::Double)),
            ("false", None),
        ] {
            let table = parse(&format!("[pane]\ndiffuse = 0.02\nglass = {value}")).expect("readable");
            let pane = &table["pane"];
            assert_eq!((pane.glass, pane.specular, pane.mirrors()), (glass, 0.0, glass.is_some()), "{value}");
        }
        let table = parse("[tree]\ntransmittance = 0.25").expect("readable");
        let tree = &table["tree"];
        assert_eq!((tree.transmittance, tree.diffuse, tree.mirrors()), (Some(0.25), 0.0, false));
    }

    /// A leaf with values by band, in one line or in tables of their own, 2 of 2, has the 4 stated
    /// values by band and 2 for all light; a tree has one more for all light.
    #[test]
    fn values_by_band_are_read_in_two_ways() {
        let by_line = "[leaf]\ndiffuse = { solar = 0.25, visible = 0.08, nir = 0.45 }\nspecular = { solar = 0.02, par = 0.03, uv = 0 }";
        let by_table = "[leaf.diffuse]\nsolar = 0.25\nvisible = 0.08\nnir = 0.45\n[leaf.specular]\nsolar = 0.02\npar = 0.03\nuv = 0";
        for text in [by_line, by_table] {
            let leaf = &parse(text).expect("readable")["leaf"];
            assert_eq!((leaf.diffuse, leaf.specular, leaf.bands.all().count()), (0.25, 0.02, 4), "{text}");
            assert_eq!(leaf.bands.diffuse.stated(Band::Visible), Some(0.08));
            assert_eq!(leaf.bands.specular.stated(Band::Par), Some(0.03));
        }
        let tree = &parse("[tree]\ntransmittance = { solar = 0.3, visible = 0.1 }").expect("readable")["tree"];
        assert_eq!((tree.transmittance, tree.in_band(Band::Par).transmittance), (Some(0.3), Some(0.1)));
    }

    /// An emissivity is read; it is no band of the light.
    #[test]
    fn an_emissivity_is_no_band_of_the_light() {
        let zinc = &parse("[zinc]\ndiffuse = 0.4\nemissivity = 0.25").expect("readable")["zinc"];
        assert_eq!((zinc.bands.emissivity, zinc.bands.is_empty()), (Some(0.25), true));
    }

    /// Every refusal names the file, the line and the offending text.
    #[test]
    fn a_refused_table_names_its_line() {
        for (text, line, quoted) in [
            ("[roof]\ndifuse = 0.2", 2, "unknown key `difuse` of material `roof`"),
            ("[roof]\nspecular = 0.2", 1, "`roof` has no `diffuse`"),
            ("[roof]\n\ndiffuse = \"0.2\"", 3, "is \"0.2\", not a number"),
            ("[roof]\ndiffuse = nan", 2, "is nan,"),
            ("[roof]\ndiffuse = inf", 2, "is inf,"),
            ("[roof]\ndiffuse = 20", 2, "is 20,"),
            ("[roof]\ndiffuse = -0.1", 2, "is -0.1,"),
            ("[a]\ndiffuse = 0.1\n[roof]\ndiffuse = 0.6\nspecular = 0.6", 3, "add up to more than 1"),
            ("[roof]\ndiffuse = 0.2\nclass = \"roof\"", 3, "is \"roof\""),
            ("[roof]\ndiffuse = 0.2\ngroup = \"\"", 3, "`group` of material `roof` is \"\""),
            ("diffuse = 0.2", 1, "`diffuse` stands outside any material"),
            ("[roof.red]\ndiffuse = 0.2", 1, "[\"roof.red\"]"),
            ("[roof]\ndiffuse = 0.2\n[roof]\ndiffuse = 0.3", 3, "duplicate key"),
            ("[roof\ndiffuse = 0.2", 1, "quotes"),
            ("\n[endless_ground]\nalbedo = 0.2", 3, "unknown key `albedo`"),
            ("[endless_ground]\ndiffuse = 0.2\nelevation = \"low\"", 3, "`elevation` is \"low\""),
            ("[endless_ground]\ndiffuse = 0.2\nelevation = inf", 3, "`elevation` is inf"),
            ("[roof]\ndiffuse = 0.2\nelevation = 2", 3, "unknown key `elevation`"),
            ("[pane]\ndiffuse = 0.1\nglass = \"triple\"", 3, "`glass` of material `pane` is \"triple\""),
            ("[pane]\ndiffuse = 0.1\nglass = 1", 3, "`glass` of material `pane` is 1"),
            ("[pane]\ndiffuse = 0.1\nglass = true\nspecular = 0.1", 1, "`glass` excludes `specular`"),
            ("[pane]\nglass = true", 1, "`pane` has no `diffuse`"),
            ("[pane]\ndiffuse = 0.1\nspecular = 1.1", 3, "`specular` of material `pane` is 1.1"),
            ("[tree]\ntransmittance = -0.1", 2, "is -0.1, not a number"),
            ("[tree]\ntransmittance = 0.5\ndiffuse = 0.6", 1, "add up to more than 1"),
            ("[tree]\ntransmittance = 0.5\nglass = true", 1, "cannot be a mirror"),
            ("[a]\n\ndiffuse = { visible = 0.1 }", 3, "has values by band and none for all light"),
            ("[a]\ndiffuse = { solar = 0.2, red = 0.1 }", 2, "`diffuse` of material `a` has no band `red`"),
            ("[a]\ndiffuse = { solar = 0.2, visible = 1.1 }", 2, "for `visible` is 1.1, not a number"),
            ("[a]\ndiffuse = { solar = 0.2, nir = \"x\" }", 2, "for `nir` is \"x\""),
            ("[a]\ndiffuse = { solar = 0.2, visible = 0.1, visible = 0.1 }", 2, "duplicate key"),
            ("[a]\ndiffuse = { solar = 0.2, visible = 0.6 }\nspecular = 0.5", 1, "add up to 1.1 for `visible`"),
            ("[a]\ndiffuse = 0.2\nspecular = { solar = 0, visible = 0.5 }", 1, "0 for all light"),
            ("[a.diffuse]\nvisible = 0.1", 1, "none for all light"),
            ("[a]\ndiffuse = 0.2\nemissivity = 1.2", 3, "`emissivity` of material `a` is 1.2, not a number"),
            ("[a]\ndiffuse = 0.2\nemissivity = { solar = 0.9 }", 3, "`emissivity` of material `a` is {"),
        ] {
            let message = parse(text).expect_err(text).to_string();
            assert!(message.starts_with(&format!("materials.toml, line {line}")), "{text:?}: {message}");
            assert!(message.contains(quoted), "{text:?}: {message}");
        }
    }
}
