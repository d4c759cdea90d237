//! A file from city object to city object. In: its XML. Out: one draft after the other.

use std::path::Path;

use crate::formats::citygml::coordinates::Coordinates;
use crate::formats::citygml::feature::Feature;
use crate::formats::citygml::store::Store;
use crate::formats::citygml::xml::{Element, Xml};
use crate::text::excerpt;
use heliotile_core::error::{Error, Result};

/// What would mend a wrong file.
pub(super) const MEND: &str = "the file is no valid CityGML: validate it (val3dity, a schema) or export it again";

/// A city object with its parts, as far as it is read.
#[derive(Default)]
pub(super) struct Draft {
    pub store: Store,
    /// The object, its parts and what is built onto them, each behind the one that it is a part of.
    pub features: Vec<Feature>,
    /// The first thing that is wrong with the feature that is being read.
    pub wrong: Option<Error>,
}

/// A file that is being read.
pub(super) struct Scan<'f> {
    pub xml: Xml<'f>,
    pub coordinates: &'f mut Coordinates,
    /// The city object that is being read.
    pub draft: Draft,
    /// Numbers and corners of the ring that is being read.
    pub numbers: Vec<f64>,
    pub ring_corners: Vec<u32>,
    pub corners_read: u64,
}

/// Takes drafts.
pub(super) type Taker<'t> = dyn FnMut(Draft) -> Result<()> + 't;

impl<'f> Scan<'f> {
    pub(super) fn new(xml: Xml<'f>, coordinates: &'f mut Coordinates, corners_read: u64) -> Scan<'f> {
        Scan { xml, coordinates, draft: Draft::default(), numbers: Vec::new(), ring_corners: Vec::new(), corners_read }
    }

    /// Reads the file to its end; returns how many corners there were with those before.
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

    /// Reads the members of a city model or of an answer of a service.
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

    /// Takes note of the coordinate system of an envelope.
    pub(super) fn envelope(&mut self) -> Result<()> {
        while let Some(element) = self.xml.child()? {
            self.state_system(&element);
            self.xml.skip()?;
        }
        Ok(())
    }

    /// Takes note of `srsName`, if the element has one.
    pub(super) fn state_system(&mut self, element: &Element) {
        if let Some(text) = element.attribute("srsName")
            && let Err(what) = self.coordinates.state(text)
        {
            self.wrong(element.line, &what);
        }
    }

    /// Notes what is wrong with the feature that is being read, which is then left out.
    #[cold]
    pub(super) fn wrong(&mut self, line: usize, what: &str) {
        if self.draft.wrong.is_none() {
            let id = self.draft.features.last().map_or("", |feature| feature.id.as_str());
            let what = format!("object `{}`: {what}", excerpt(id.as_bytes()));
            self.draft.wrong = Some(Error::input(self.xml.file(), line, what, MEND));
        }
    }
}

fn is_collection(name: &str) -> bool {
    matches!(name, "CityModel" | "FeatureCollection" | "SimpleFeatureCollection")
}

fn other_root(root: &Element, file: &Path) -> Error {
    let (what, hint) = match root.name.as_str() {
        "gbXML" => ("this is gbXML, not CityGML".to_owned(), "convert the model to EnergyPlus or Honeybee"),
        "kml" => ("this is KML, not CityGML".to_owned(), "export the city model as CityGML or CityJSON"),
        name => (
            format!("the root element is `{}`, so this is no CityGML", excerpt(name.as_bytes())),
            "give a CityGML file, whose root element is CityModel",
        ),
    };
    Error::input(file, root.line, what, hint)
}
