//! Features of GML that are no city objects: answers of a WFS, INSPIRE buildings in 2D. In: a
//! feature collection in which no city object has a surface. Out: its polygons as footprints,
//! raised by the heights or storeys that properties state.
//!
//! Every property without elements inside is an attribute by its local name; `value` is named after
//! the property around it (`heightAboveGround` of INSPIRE).

use std::path::Path;

use glam::DVec3;
use serde_json::Value;

use crate::formats::ReadOptions;
use crate::formats::citygml::attributes::Attributes;
use crate::formats::citygml::coordinates::{Coordinates, Unusable};
use crate::formats::citygml::scan::is_collection;
use crate::formats::cityjson::templates::MAX_CORNERS;
use crate::formats::features::{Collector, Feature, FeatureSystem};
use crate::formats::xml::{Element, Xml};
use crate::geometry::Geometry;
use heliotile_core::error::{Error, Result};
use heliotile_core::text::Message;
use heliotile_files::input;
use heliotile_place::epsg_numbers::Axes;
use heliotile_place::reference::Reference;

/// Aggregates of polygons.
const AGGREGATES: [&str; 10] = [
    "MultiSurface",
    "MultiPolygon",
    "MultiGeometry",
    "Surface",
    "CompositeSurface",
    "PolyhedralSurface",
    "TriangulatedSurface",
    "Solid",
    "MultiSolid",
    "Shell",
];
const POLYGONS: [&str; 4] = ["Polygon", "PolygonPatch", "Triangle", "Rectangle"];
/// Parts of the names of geometries without an area, and of curves that are not straight.
const LINES: [&str; 3] = ["Point", "Curve", "LineString"];
const BENT: [&str; 6] = ["Arc", "Circle", "Clothoid", "Spline", "Bezier", "Geodesic"];

/// Endings of CityGML file names.
pub(crate) const ENDINGS: [&str; 3] = ["gml", "citygml", "xml"];

/// Reads the features of a collection; `None` if it has city objects with levels of detail, or no
/// polygon.
pub(super) fn read(path: &Path, asked: &ReadOptions) -> Result<Option<Geometry>> {
    let mut coordinates = Coordinates::new(asked.system);
    let (mut features, mut has_levels, mut corners) = (Vec::new(), false, 0);
    input::members::each(path, &ENDINGS, &asked.footprints.layer, &mut |bytes| {
        let mut scan = FeatureScan {
            xml: Xml::new(bytes, path),
            coordinates: &mut coordinates,
            features: Vec::new(),
            has_levels: false,
            corners,
        };
        if let Some(root) = scan.xml.child()?.filter(|root| is_collection(&root.name) && root.name != "CityModel") {
            scan.collection(&root)?;
        }
        features.append(&mut scan.features);
        (has_levels, corners) = (has_levels || scan.has_levels, scan.corners);
        Ok(())
    })?;
    if has_levels || !features.iter().any(|feature| !feature.polygons.is_empty() || feature.unreadable.is_some()) {
        return Ok(None);
    }
    let mut collector = Collector::new(path, asked);
    for feature in features {
        collector.add(feature)?;
    }
    let system = match coordinates.reference() {
        // Its coordinates are metres already.
        Some(Reference::Epsg(epsg)) => {
            FeatureSystem { axes: Some(Axes::Plane), unit_m: Some(1.0), ..FeatureSystem::of_epsg(epsg) }
        }
        _ => FeatureSystem::default(),
    };
    let mut geometry = collector.finish(system)?;
    geometry
        .notes
        .extend(coordinates.notes.iter().map(|note| Message::from(format!("{}: ", path.display())).and(note)));
    geometry.doubts.append(&mut coordinates.doubts);
    Ok(Some(geometry))
}

/// Reader of the features of one file.
struct FeatureScan<'f> {
    xml: Xml<'f>,
    coordinates: &'f mut Coordinates,
    features: Vec<Feature>,
    /// True if a property has a level of detail, so that the collection is a city model.
    has_levels: bool,
    corners: u64,
}

/// A feature that is being read.
#[derive(Default)]
struct Draft {
    feature: Feature,
    attributes: Attributes,
}

impl FeatureScan<'_> {
    fn collection(&mut self, element: &Element) -> Result<()> {
        self.state(element, &mut Draft::default());
        while let Some(property) = self.xml.child()? {
            match property.name.as_str() {
                "boundedBy" => self.envelope(&mut Draft::default())?,
                "featureMember" | "featureMembers" | "member" => self.members()?,
                _ => self.xml.skip()?,
            }
        }
        Ok(())
    }

    fn members(&mut self) -> Result<()> {
        while let Some(element) = self.xml.child()? {
            if is_collection(&element.name) {
                self.collection(&element)?;
                continue;
            }
            let mut draft = Draft::default();
            draft.feature.id = element.attribute("id").map(str::to_owned);
            self.content(&element.name, &mut draft)?;
            draft.feature.attributes = draft.attributes.into_values();
            self.features.push(draft.feature);
        }
        Ok(())
    }

    /// Reads all that an element holds; an element without others inside is an attribute `name`.
    fn content(&mut self, name: &str, draft: &mut Draft) -> Result<()> {
        let mut is_leaf = true;
        loop {
            let (child, words) = self.xml.child_or_words()?;
            let Some(child) = child else {
                if is_leaf {
                    draft.attributes.add(name, Value::String(words));
                }
                return Ok(());
            };
            is_leaf = false;
            let kind = child.name.as_str();
            let digits = kind.strip_prefix("lod");
            self.has_levels |= digits.is_some_and(|rest| rest.starts_with(|first: char| first.is_ascii_digit()));
            match kind {
                "boundedBy" => self.envelope(draft)?,
                _ if POLYGONS.contains(&kind) || AGGREGATES.contains(&kind) => self.geometry(&child, draft, None)?,
                _ if LINES.iter().any(|line| kind.contains(line)) => {
                    draft.feature.has_others = true;
                    self.xml.skip()?;
                }
                "value" => self.content(name, draft)?,
                // A property is written with a small first letter, the type in it with a capital.
                _ if kind.starts_with(char::is_uppercase) => self.content(name, draft)?,
                _ => self.content(kind, draft)?,
            }
        }
    }

    fn envelope(&mut self, draft: &mut Draft) -> Result<()> {
        while let Some(element) = self.xml.child()? {
            self.state(&element, draft);
            self.xml.skip()?;
        }
        Ok(())
    }

    /// Records the coordinate system that an element states.
    fn state(&mut self, element: &Element, draft: &mut Draft) {
        if let Some(text) = element.attribute("srsName")
            && let Err(what) = self.coordinates.state(text)
        {
            draft.feature.unreadable.get_or_insert(what);
        }
    }

    fn geometry(&mut self, element: &Element, draft: &mut Draft, dimension: Option<usize>) -> Result<()> {
        self.state(element, draft);
        let dimension = dimension_of(element).or(dimension);
        if POLYGONS.contains(&element.name.as_str()) {
            return self.polygon(draft, dimension);
        }
        while let Some(property) = self.xml.child()? {
            while let Some(part) = self.xml.child()? {
                let kind = part.name.as_str();
                if POLYGONS.contains(&kind) || AGGREGATES.contains(&kind) {
                    self.geometry(&part, draft, dimension)?;
                } else {
                    let what = format!("its geometry has a `{kind}` in `{}`, which is not read", property.name);
                    draft.feature.unreadable.get_or_insert(what);
                    self.xml.skip()?;
                }
            }
        }
        Ok(())
    }

    fn polygon(&mut self, draft: &mut Draft, dimension: Option<usize>) -> Result<()> {
        let mut rings = Vec::new();
        while let Some(_property) = self.xml.child()? {
            while let Some(ring) = self.xml.child()? {
                self.state(&ring, draft);
                let mut numbers = Vec::new();
                let mut dimension = dimension_of(&ring).or(dimension);
                self.numbers(draft, &mut numbers, &mut dimension)?;
                rings.push(self.ring(&numbers, dimension, draft)?);
            }
        }
        // INSPIRE repeats the outline as reference geometry.
        if !draft.feature.polygons.contains(&rings) {
            draft.feature.polygons.push(rings);
        }
        Ok(())
    }

    /// Collects the numbers of the straight sides of a ring.
    fn numbers(&mut self, draft: &mut Draft, numbers: &mut Vec<f64>, dimension: &mut Option<usize>) -> Result<()> {
        while let Some(element) = self.xml.child()? {
            *dimension = dimension_of(&element).or(*dimension);
            let name = element.name.as_str();
            if BENT.iter().any(|bent| name.contains(bent)) {
                draft.feature.unreadable.get_or_insert("its outline has arcs or other bent curves".to_owned());
                self.xml.skip()?;
            } else if ["posList", "pos", "coordinates"].contains(&name) {
                let text = self.xml.text()?;
                let words = text.split(|byte| byte.is_ascii_whitespace() || *byte == b',');
                for word in words.filter(|word| !word.is_empty()) {
                    match crate::text::number(word).filter(|number| number.is_finite()) {
                        Some(number) => numbers.push(number),
                        None => {
                            let what = format!("a coordinate is `{}`, not a number", crate::text::excerpt(word));
                            draft.feature.unreadable.get_or_insert(what);
                        }
                    }
                }
            } else {
                self.numbers(draft, numbers, dimension)?;
            }
        }
        Ok(())
    }

    /// Returns the corners of a ring, metres.
    fn ring(&mut self, numbers: &[f64], dimension: Option<usize>, draft: &mut Draft) -> Result<Vec<DVec3>> {
        let is_closed_plan = numbers.len().is_multiple_of(2)
            && numbers.len() > 2
            && numbers.first_chunk::<2>() == numbers.last_chunk::<2>();
        let size = dimension.unwrap_or(if is_closed_plan || !numbers.len().is_multiple_of(3) { 2 } else { 3 });
        self.corners += numbers.len() as u64 / 2;
        if self.corners > MAX_CORNERS {
            return Err(Error::Limit {
                what: format!("the number of corners of {} (split it into tiles)", self.xml.file().display()).into(),
                value: self.corners,
                max: MAX_CORNERS,
            });
        }
        let mut ring = Vec::with_capacity(numbers.len() / size);
        for corner in numbers.chunks_exact(size) {
            let [a, b, height] = [0, 1, 2].map(|i| corner.get(i).copied().unwrap_or_default());
            match self.coordinates.place([a, b, height]) {
                Ok(place) => ring.push(place),
                Err(Unusable::Object(what)) => drop(draft.feature.unreadable.get_or_insert(what)),
                Err(Unusable::File { what, hint }) => return Err(Error::input(self.xml.file(), None, what, hint)),
            }
        }
        Ok(ring)
    }
}

/// Returns the number of coordinates of a position, 2 or 3, if an element states it.
fn dimension_of(element: &Element) -> Option<usize> {
    element.attribute("srsDimension").and_then(|text| text.trim().parse().ok()).filter(|size| [2, 3].contains(size))
}
