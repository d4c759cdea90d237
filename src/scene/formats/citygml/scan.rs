//! A file, city object by city object. In: its XML. Out: one draft for each city object.

use std::path::Path;

use crate::formats::citygml::coordinates::Coordinates;
use crate::formats::citygml::feature::Feature;
use crate::formats::citygml::store::Store;
use crate::formats::xml::{Element, Xml};
use crate::text::excerpt;
use heliotile_core::error::{Error, Result};

/// Hint on how to repair a damaged file.
pub(super) const MEND: &str = "validate the file (val3dity, a schema) or export it again: it is not valid CityGML";

/// A city object with its parts, as far as it is read.
#[derive(Default)]
pub(super) struct Draft {
    pub store: Store,
    /// The object, its parts and its installations, each behind the feature that it is a part of.
    pub features: Vec<Feature>,
    /// First error in the feature that is being read.
    pub wrong: Option<Error>,
}

/// Reader of one file.
pub(super) struct Scan<'f> {
    pub xml: Xml<'f>,
    pub coordinates: &'f mut Coordinates,
    /// City object that is being read.
    pub draft: Draft,
    /// Numbers, and below corners, of the ring that is being read.
    pub numbers: Vec<f64>,
    pub ring_corners: Vec<u32>,
    pub corners_read: u64,
}

/// Function that takes drafts.
pub(super) type Taker<'t> = dyn FnMut(Draft) -> Result<()> + 't;

impl<'f> Scan<'f> {
    pub(super) fn new(xml: Xml<'f>, coordinates: &'f mut Coordinates, corners_read: u64) -> Scan<'f> {
        Scan { xml, coordinates, draft: Draft::default(), numbers: Vec::new(), ring_corners: Vec::new(), corners_read }
    }

    /// Reads the file to its end; returns the number of corners read so far, including those of
    /// earlier files.
    pub(super) fn all(mut self, take: &mut Taker) -> Result<u64> {
        let Some(root) = self.xml.child()? else {
            return Err(Error::input(self.xml.file(), None, "the file is empty", "export the city model again"));
        };
        if !is_collection(&root.name) {
            return Err(other_root(&root, self.xml.file()));
        }
        self.collection(take)?;
        Ok(self.corners_read)
    }

    /// Reads the members of a city model or of a service's answer.
    fn collection(&mut self, take: &mut Taker) -> Result<()> {
        while let Some(property) = self.xml.child()? {
            match property.name.as_str() {
                "boundedBy" => self.envelope()?,
                "cityObjectMember" | "featureMember" | "featureMembers" | "member" => {
                    while let Some(element) = self.xml.child()? {
                        if is_collection(&element.name) {
                            self.collection(take)?;
                        } else {
                            self.city_object(&element, take)?;
                        }
                    }
                }
                _ => self.xml.skip()?,
            }
        }
        Ok(())
    }

    fn city_object(&mut self, element: &Element, take: &mut Taker) -> Result<()> {
        self.draft = Draft::default();
        self.feature(element, None)?;
        take(std::mem::take(&mut self.draft))
    }

    /// Records the coordinate system of an envelope.
    pub(super) fn envelope(&mut self) -> Result<()> {
        while let Some(element) = self.xml.child()? {
            self.state_system(&element);
            self.xml.skip()?;
        }
        Ok(())
    }

    /// Records the `srsName` of an element, if it has one.
    pub(super) fn state_system(&mut self, element: &Element) {
        if let Some(text) = element.attribute("srsName")
            && let Err(what) = self.coordinates.state(text)
        {
            self.wrong(element.line, &what);
        }
    }

    /// Records an error in the feature that is being read, which is then left out. Only the first
    /// error counts.
    #[cold]
    pub(super) fn wrong(&mut self, line: usize, what: &str) {
        if self.draft.wrong.is_none() {
            let id = self.draft.features.last().map_or("", |feature| feature.id.as_str());
            let what = format!("object `{}`: {what}", excerpt(id.as_bytes()));
            self.draft.wrong = Some(Error::input(self.xml.file(), line, what, MEND));
        }
    }
}

/// Returns true for the elements that hold city objects or features.
pub(super) fn is_collection(name: &str) -> bool {
    matches!(name, "CityModel" | "FeatureCollection" | "SimpleFeatureCollection")
}

fn other_root(root: &Element, file: &Path) -> Error {
    let (what, hint) = match root.name.as_str() {
        "gbXML" => (
            "the file is gbXML, not CityGML".to_owned(),
            "convert it to Honeybee: `honeybee-energy translate model-from-gbxml model.xml -f model.hbjson`, and give model.hbjson",
        ),
        "LandXML" => {
            ("the file is LandXML, not CityGML".to_owned(), "export the terrain as GeoTIFF, or its triangles as OBJ")
        }
        "IndoorFeatures" => (
            "the file is IndoorGML, which holds rooms, not CityGML".to_owned(),
            "give the outside of the buildings as CityGML or CityJSON",
        ),
        "kml" => ("the file is KML, not CityGML".to_owned(), "export the city model as CityGML or CityJSON"),
        name => (
            format!("the root element is `{}`, so the file is not CityGML", excerpt(name.as_bytes())),
            "give a CityGML file, whose root element is CityModel",
        ),
    };
    Error::input(file, root.line, what, hint)
}
