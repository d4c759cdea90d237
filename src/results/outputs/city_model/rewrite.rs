//! Rewrites the text of a city model with additions. In: a CityJSON object or one line of a
//! sequence; sums. Out: the text, in which only objects with sums are written anew: their
//! attributes, the attributes of their semantic surfaces, and the theme of their geometries.

use std::collections::BTreeMap;
use std::io::{self, Write};

use serde::de::IgnoredAny;
use serde_json::Value;
use serde_json::value::RawValue;

use super::fields::{Fields, Members, parsed};
use super::sums::{Means, ModelSums, ObjectSums, PREFIX};
use super::theme::Theme;
use heliotile_core::site::semantics::{FaceNote, FaceSource, SourceFace};

/// Error of a rewrite.
#[derive(Debug)]
pub enum RewriteError {
    /// Text that is no city model.
    Model(String),
    Write(io::Error),
}

impl From<serde_json::Error> for RewriteError {
    fn from(error: serde_json::Error) -> Self {
        RewriteError::Model(error.to_string())
    }
}

impl From<io::Error> for RewriteError {
    fn from(error: io::Error) -> Self {
        RewriteError::Write(error)
    }
}

type Result<T> = std::result::Result<T, RewriteError>;

/// Numbers of objects and faces of the sums that the model contains.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fitting {
    pub objects: usize,
    pub faces: usize,
}

/// Writer of city models with sums.
pub struct CityModelWriter<'s> {
    sums: &'s ModelSums,
    theme: Theme,
    fitting: Fitting,
}

/// Boundaries of a geometry, reduced to the number of faces: `[solid][shell]`, where some
/// geometries have fewer levels.
enum Faces {
    Surfaces(Vec<IgnoredAny>),
    Shells(Vec<Vec<IgnoredAny>>),
    Solids(Vec<Vec<Vec<IgnoredAny>>>),
}

impl<'s> CityModelWriter<'s> {
    pub fn new(sums: &'s ModelSums) -> Self {
        CityModelWriter { sums, theme: Theme::up_to(sums.largest()), fitting: Fitting::default() }
    }

    /// Returns the numbers of objects and faces that were found so far.
    pub fn fitting(&self) -> Fitting {
        self.fitting
    }

    /// Writes a CityJSON object, or a line of a sequence. `about` is the provenance for the header;
    /// lines after it have none.
    pub fn write(&mut self, text: &str, about: Option<&Value>, out: &mut impl Write) -> Result<()> {
        let root: Fields = serde_json::from_str(text)?;
        let kind = root.text("type").unwrap_or_default();
        let wanted = if about.is_some() { "CityJSON" } else { "CityJSONFeature" };
        if kind != wanted {
            return Err(RewriteError::Model(format!("its `type` is `{kind}`, not {wanted}")));
        }
        // Versions 1.0 and 2.0 allow further members in the metadata; 1.1 allows them only in the
        // root object.
        let version = root.text("version").unwrap_or_default();
        let (in_metadata, about) = (!version.starts_with("1.1"), about.map(Value::to_string));
        let objects: Fields = root.get("CityObjects").map_or(Ok(Fields::default()), parsed)?;
        let sums = self.sums;
        let coloured = objects.0.iter().any(|(id, _)| sums.object(id).is_some_and(|object| !object.faces.is_empty()));
        let appearance: Fields = root.get("appearance").map_or(Ok(Fields::default()), parsed)?;
        let materials: Vec<&RawValue> = appearance.get("materials").map_or(Ok(Vec::new()), parsed)?;
        let materials = foreign(&materials);
        let mut members = Members::begin(out)?;
        let (mut has_appearance, mut has_metadata) = (false, false);
        for (key, value) in &root.0 {
            let out = match key.as_str() {
                // An earlier run wrote this member; it is replaced.
                "heliotile" if about.is_some() => continue,
                _ => members.key(key)?,
            };
            match key.as_str() {
                "CityObjects" => self.objects(&objects, materials.len(), out)?,
                "appearance" if coloured => {
                    has_appearance = true;
                    self.appearance(&appearance, materials, out)?;
                }
                "metadata" if in_metadata => {
                    has_metadata = true;
                    match &about {
                        Some(about) => with_member(&parsed(value)?, "heliotile", about, out)?,
                        None => out.write_all(value.get().as_bytes())?,
                    }
                }
                _ => out.write_all(value.get().as_bytes())?,
            }
        }
        if coloured && !has_appearance {
            self.appearance(&appearance, materials, members.key("appearance")?)?;
        }
        if let Some(about) = about.filter(|_| !has_metadata) {
            match in_metadata {
                true => with_member(&Fields::default(), "heliotile", &about, members.key("metadata")?)?,
                false => members.member("heliotile", &about)?,
            }
        }
        Ok(members.end()?)
    }

    fn appearance(&self, appearance: &Fields, materials: &[&RawValue], out: &mut impl Write) -> Result<()> {
        let own = self.theme.materials();
        let all = materials.iter().map(|material| material.get().to_owned()).chain(own.iter().map(Value::to_string));
        let list = format!("[{}]", all.collect::<Vec<_>>().join(","));
        Ok(with_member(appearance, "materials", &list, out)?)
    }

    /// Writes all city objects; `first` is the index of the material of the first class.
    fn objects(&mut self, objects: &Fields, first: usize, out: &mut impl Write) -> Result<()> {
        let sums = self.sums;
        let mut members = Members::begin(out)?;
        for (id, value) in &objects.0 {
            let out = members.key(id)?;
            match sums.object(id) {
                Some(known) => {
                    self.fitting.objects += 1;
                    self.object(value, known, first, out)?;
                }
                None => out.write_all(value.get().as_bytes())?,
            }
        }
        Ok(members.end()?)
    }

    fn object(&mut self, text: &RawValue, known: &ObjectSums, first: usize, out: &mut impl Write) -> Result<()> {
        let object: Fields = parsed(text)?;
        let mut members = Members::begin(out)?;
        let mut has_attributes = false;
        for (key, value) in &object.0 {
            let out = members.key(key)?;
            match key.as_str() {
                "attributes" => {
                    has_attributes = true;
                    self.attributed(&parsed(value)?, &known.all, out)?;
                }
                "geometry" if !known.faces.is_empty() => {
                    let shapes: Vec<&RawValue> = parsed(value)?;
                    out.write_all(b"[")?;
                    for (number, shape) in shapes.iter().enumerate() {
                        out.write_all(if number > 0 { b"," } else { b"" })?;
                        self.shape(shape, number, known, first, out)?;
                    }
                    out.write_all(b"]")?;
                }
                _ => out.write_all(value.get().as_bytes())?,
            }
        }
        if !has_attributes {
            self.attributed(&Fields::default(), &known.all, members.key("attributes")?)?;
        }
        Ok(members.end()?)
    }

    /// Writes an object with the attributes of `means`; attributes of an earlier run are removed.
    fn attributed(&self, fields: &Fields, means: &Means, out: &mut impl Write) -> Result<()> {
        let mut members = Members::begin(out)?;
        for (key, value) in fields.0.iter().filter(|(key, _)| !key.starts_with(PREFIX)) {
            members.member(key, value.get())?;
        }
        for (key, number) in self.sums.attributes(means) {
            members.member(&key, &number)?;
        }
        Ok(members.end()?)
    }

    /// Writes a geometry with attributes of semantic surfaces, and a material for each face that
    /// has sums.
    fn shape(
        &mut self,
        text: &RawValue,
        number: usize,
        known: &ObjectSums,
        first: usize,
        out: &mut impl Write,
    ) -> Result<()> {
        let shape: Fields = parsed(text)?;
        let kind = shape.text("type").unwrap_or_default();
        let places = shape.get("boundaries").map_or(Ok(None), |boundaries| Faces::new(&kind, boundaries))?;
        let places = places.map(|places| places.paths()).unwrap_or_default();
        // Paths of the faces that have sums.
        let mut lit: BTreeMap<Vec<u32>, &Means> = BTreeMap::new();
        for path in places.iter() {
            if let Some(means) = known.faces.get(&name_of(number, path)) {
                lit.insert(path.clone(), means);
            }
        }
        if lit.is_empty() {
            return Ok(out.write_all(text.get().as_bytes())?);
        }
        self.fitting.faces += lit.len();
        let mut members = Members::begin(out)?;
        let mut has_material = false;
        for (key, value) in &shape.0 {
            let out = members.key(key)?;
            match key.as_str() {
                "semantics" => self.semantics(&parsed(value)?, &lit, out)?,
                "material" => {
                    has_material = true;
                    with_member(&parsed(value)?, Theme::NAME, &self.material(&places, &lit, first), out)?;
                }
                _ => out.write_all(value.get().as_bytes())?,
            }
        }
        if !has_material {
            let theme = self.material(&places, &lit, first);
            with_member(&Fields::default(), Theme::NAME, &theme, members.key("material")?)?;
        }
        Ok(members.end()?)
    }

    fn semantics(&self, semantics: &Fields, lit: &BTreeMap<Vec<u32>, &Means>, out: &mut impl Write) -> Result<()> {
        let values: Value = semantics.get("values").map_or(Ok(Value::Null), |text| serde_json::from_str(text.get()))?;
        let mut by_surface: BTreeMap<u64, Means> = BTreeMap::new();
        for (path, means) in lit {
            let value = path.iter().try_fold(&values, |value, place| value.get(*place as usize));
            if let Some(surface) = value.and_then(Value::as_u64) {
                by_surface.entry(surface).or_default().join(means);
            }
        }
        let mut members = Members::begin(out)?;
        for (key, value) in &semantics.0 {
            let out = members.key(key)?;
            if key != "surfaces" {
                out.write_all(value.get().as_bytes())?;
                continue;
            }
            let surfaces: Vec<&RawValue> = parsed(value)?;
            out.write_all(b"[")?;
            for (number, surface) in (0..).zip(surfaces) {
                out.write_all(if number > 0 { b"," } else { b"" })?;
                match by_surface.get(&number) {
                    Some(means) => self.attributed(&parsed(surface)?, means, out)?,
                    None => out.write_all(surface.get().as_bytes())?,
                }
            }
            out.write_all(b"]")?;
        }
        Ok(members.end()?)
    }

    /// Returns the theme of a geometry: indices of materials, nested as its boundaries are without
    /// rings.
    fn material(&self, places: &[Vec<u32>], lit: &BTreeMap<Vec<u32>, &Means>, first: usize) -> String {
        let mut values = Value::Array(Vec::new());
        for path in places {
            let class =
                lit.get(path).map(|means| first as u64 + u64::from(self.theme.class_of(self.sums.total(means))));
            // Paths come in order, so each list only grows at its end.
            let mut list = &mut values;
            for place in path.iter().take(path.len().saturating_sub(1)) {
                let Value::Array(items) = list else { break };
                while items.len() <= *place as usize {
                    items.push(Value::Array(Vec::new()));
                }
                list = &mut items[*place as usize];
            }
            if let Value::Array(items) = list {
                items.push(class.map_or(Value::Null, Value::from));
            }
        }
        format!("{{\"values\":{values}}}")
    }
}

impl Faces {
    /// Reads the boundaries of a geometry; `None` if it has no faces of its own.
    fn new(kind: &str, boundaries: &RawValue) -> Result<Option<Faces>> {
        Ok(match kind {
            "MultiSurface" | "CompositeSurface" => Some(Faces::Surfaces(parsed(boundaries)?)),
            "Solid" => Some(Faces::Shells(parsed(boundaries)?)),
            "MultiSolid" | "CompositeSolid" => Some(Faces::Solids(parsed(boundaries)?)),
            _ => None,
        })
    }

    /// Returns the path of each face in the boundaries, in order.
    fn paths(&self) -> Vec<Vec<u32>> {
        let numbers = |list: &[IgnoredAny]| 0..list.len() as u32;
        match self {
            Faces::Surfaces(faces) => numbers(faces).map(|face| vec![face]).collect(),
            Faces::Shells(shells) => {
                let shells = (0..).zip(shells);
                shells.flat_map(|(shell, faces)| numbers(faces).map(move |face| vec![shell, face])).collect()
            }
            Faces::Solids(solids) => {
                let shells = (0..).zip(solids).flat_map(|(solid, shells)| (0..).zip(shells).map(move |s| (solid, s)));
                shells
                    .flat_map(|(solid, (shell, faces))| numbers(faces).map(move |face| vec![solid, shell, face]))
                    .collect()
            }
        }
    }
}

/// Returns the name that receivers have for a face.
fn name_of(geometry: usize, place: &[u32]) -> String {
    let mut path = [0; 3];
    path.iter_mut().zip(place).for_each(|(to, from)| *to = *from);
    let source = FaceSource::Boundary { geometry: geometry as u32, path, depth: place.len() as u8 };
    SourceFace { note: FaceNote { source, ..FaceNote::default() }, ..SourceFace::default() }.name("")
}

/// Returns the materials without those of an earlier run, which stand last.
fn foreign<'l, 'a>(materials: &'l [&'a RawValue]) -> &'l [&'a RawValue] {
    let own = |material: &&&RawValue| {
        parsed::<Fields>(material)
            .ok()
            .and_then(|material| material.text("name"))
            .is_some_and(|name| Theme::has_made(&name))
    };
    let count = materials.iter().rev().take_while(own).count();
    materials.get(..materials.len() - count).unwrap_or_default()
}

/// Writes an object with one member added, or replaced if its key exists.
fn with_member(fields: &Fields, key: &str, value: &str, out: &mut impl Write) -> io::Result<()> {
    let mut members = Members::begin(out)?;
    let mut is_there = false;
    for (name, own) in &fields.0 {
        let same = name == key;
        is_there |= same;
        members.member(name, if same { value } else { own.get() })?;
    }
    if !is_there {
        members.member(key, value)?;
    }
    members.end()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use heliotile_core::replay::components::{Component, ComponentList};
    use heliotile_core::replay::values::TileValues;
    use heliotile_core::site::receiver::Receiver;

    /// Returns sums of 1,000 kWh/m2 on 2 m2 for each of these faces of objects.
    fn sums(faces: &[(&str, &str)]) -> ModelSums {
        let mut sums = ModelSums::new(&ComponentList::new(Component::Total), &[]);
        let mut values = TileValues::new(1, 1);
        values.row_mut(Component::Total, 0).fill(1000.0);
        for (object, face) in faces {
            let mut receiver = Receiver { area: Some(2.0), ..Receiver::new("r".into(), DVec3::ZERO, DVec3::Z) };
            (receiver.part.object, receiver.part.face) = ((*object).into(), (*face).into());
            sums.add(&receiver, &values, 0);
        }
        sums
    }

    fn written(sums: &ModelSums, text: &str) -> (String, Fitting) {
        let mut out = Vec::new();
        let mut writer = CityModelWriter::new(sums);
        writer.write(text, Some(&Value::from("here")), &mut out).expect("a city model");
        (String::from_utf8(out).expect("text"), writer.fitting())
    }

    /// Faces of composite solids and of plain surfaces get the class of 1,000 behind the 1 existing
    /// material; faces without sums get none. Semantic surfaces named by values get their sums,
    /// null values get none. Null attributes become attributes. An object without sums stays as it
    /// is, spaces included. Version 1.1 has its provenance in the root object.
    #[test]
    fn faces_at_every_depth_get_their_sums() {
        let sums = sums(&[
            ("a", "geometry[1].boundaries[0][1][0]"),
            ("a", "geometry[0].boundaries[1]"),
            ("b", "geometry[0].boundaries[7]"),
        ]);
        let text = r#"{"type":"CityJSON","version":"1.1","metadata":{"title": "t"},
"CityObjects":{"c":{ "type" : "Bridge" },"a":{"type":"Building","attributes":null,"geometry":[
{"type":"MultiSurface","lod":"1","boundaries":[[[0,1,2]],[[0,1,3]]],"semantics":{"surfaces":[{"type":"RoofSurface"}],"values":[null,0]}},
{"type":"CompositeSolid","lod":"1","boundaries":[[[[[0,1,2]]],[[[0,1,3]],[[1,2,3]]]]],"material":{"":{"value":0}},"semantics":{"surfaces":[{"type":"RoofSurface"}],"values":[null]}}]}},
"appearance":{"materials":[{"name":"brick"}]},"vertices":[]}"#;
        let (out, fitting) = written(&sums, text);
        assert_eq!(fitting, Fitting { objects: 1, faces: 2 });
        let model: Value = serde_json::from_str(&out).expect("JSON");
        let shapes = &model["CityObjects"]["a"]["geometry"];
        assert_eq!(shapes[0]["material"]["irradiation"]["values"].to_string(), "[null,20]");
        assert_eq!(shapes[1]["material"]["irradiation"]["values"].to_string(), "[[[null],[20,null]]]");
        assert_eq!(shapes[1]["material"][""]["value"], 0);
        assert_eq!(shapes[0]["semantics"]["surfaces"][0]["heliotile_total_kwh_m2"], 1000.0);
        assert_eq!(shapes[1]["semantics"]["surfaces"][0].as_object().map(serde_json::Map::len), Some(1));
        assert_eq!(model["CityObjects"]["a"]["attributes"]["heliotile_total_kwh"], 4000.0);
        assert!(out.contains(r#""c":{ "type" : "Bridge" }"#) && out.contains(r#""metadata":{"title": "t"}"#), "{out}");
        assert_eq!(
            (&model["heliotile"], model["appearance"]["materials"].as_array().map(Vec::len)),
            (&"here".into(), Some(21))
        );
        // A second run adds nothing.
        assert_eq!(written(&sums, &out).0, out);
        let (newer, _) = written(&sums, &text.replace("\"1.1\"", "\"2.0\""));
        assert!(newer.contains(r#""metadata":{"title":"t","heliotile":"here"}"#), "{newer}");
    }

    /// Texts that are no city model are refused with a message that says what they are, 4 of 4.
    #[test]
    fn texts_that_are_not_city_models_are_refused() {
        let sums = sums(&[("a", "geometry[0].boundaries[0]")]);
        for (text, part) in [
            ("[]", "an object"),
            (r#"{"type":"Model"}"#, "`Model`"),
            (r#"{"type":"CityJSON","CityObjects":[]}"#, "an object"),
            (r#"{"type":"CityJSON","CityObjects":{"a":{"geometry":[{"type":"Solid","boundaries":[3]}]}}}"#, "sequence"),
        ] {
            let refused = CityModelWriter::new(&sums).write(text, Some(&Value::Null), &mut Vec::new());
            assert!(matches!(&refused, Err(RewriteError::Model(what)) if what.contains(part)), "{text}: {refused:?}");
        }
    }
}
