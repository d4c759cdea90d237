//! Features of a city model. In: the element of a building, a building part, a tree or terrain.
//! Out: its geometry by level of detail and its attributes. Its parts and installations become
//! features of their own.

use std::ops::Range;

use glam::{DMat4, DVec3};

use crate::formats::citygml::attributes::Attributes;
use crate::formats::citygml::drawing::{Around, LINES};
use crate::formats::citygml::scan::Scan;
use crate::formats::cityjson::document::Lod;
use crate::formats::cityjson::templates::matrix;
use crate::formats::xml::Element;
use heliotile_core::error::{Error, Result};

/// A city object, or a part of one.
#[derive(Default)]
pub(super) struct Feature {
    /// Its `gml:id`, or its type and line if it has none.
    pub id: String,
    /// Local name of its element.
    pub kind: String,
    pub line: usize,
    /// Index of the feature that it is a part of.
    pub parent: Option<usize>,
    pub attributes: Attributes,
    pub pieces: Vec<Piece>,
    /// Level of detail of terrain, which states it beside its geometry.
    lod: Option<Lod>,
    /// Error for which the feature is left out.
    pub wrong: Option<Error>,
}

/// Geometry of a feature in one level of detail.
pub(super) struct Piece {
    pub lod: Option<Lod>,
    pub members: Range<u32>,
    pub part: PiecePart,
    /// Place in the scene, if the members are a template.
    pub instance: Option<Instance>,
}

/// Role of a piece in its feature.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum PiecePart {
    /// Geometry of the whole feature.
    Whole,
    /// Outline of the roof seen from above.
    RoofEdge,
    /// A thematic surface, with the index of its name.
    Surface(Option<u16>),
}

/// Place of a template in the scene.
#[derive(Clone, Copy)]
pub(super) struct Instance {
    pub matrix: DMat4,
    pub at: DVec3,
}

/// Elements within features that become features of their own.
const PARTS: [&str; 25] = [
    "BuildingPart",
    "BuildingInstallation",
    "BuildingConstructiveElement",
    "BridgePart",
    "BridgeInstallation",
    "BridgeConstructionElement",
    "BridgeConstructiveElement",
    "TunnelPart",
    "TunnelInstallation",
    "TunnelConstructiveElement",
    "OtherConstruction",
    "TINRelief",
    "MassPointRelief",
    "BreaklineRelief",
    "RasterRelief",
    "Road",
    "Railway",
    "Square",
    "Track",
    "Waterway",
    "Section",
    "Intersection",
    "TrafficSpace",
    "AuxiliaryTrafficSpace",
    "PlantCover",
];

/// Elements inside buildings, bridges and tunnels, or that repeat their geometry by storeys.
const INSIDE: [&str; 15] = [
    "Room",
    "BuildingRoom",
    "BuildingFurniture",
    "IntBuildingInstallation",
    "Storey",
    "BuildingUnit",
    "BuildingSubdivision",
    "BridgeRoom",
    "BridgeFurniture",
    "IntBridgeInstallation",
    "HollowSpace",
    "TunnelFurniture",
    "IntTunnelInstallation",
    "ClearanceSpace",
    "RoomInstallation",
];

/// Properties whose content is neither geometry nor an attribute.
const SKIPPED: [&str; 12] = [
    "appearance",
    "appearanceMember",
    "address",
    "externalReference",
    "dynamizer",
    "generalizesTo",
    "relatedTo",
    "pointCloud",
    "genericAttributeSet",
    "metaDataProperty",
    "adeOfAbstractFeature",
    "groupMember",
];

impl Scan<'_> {
    /// Reads a feature and its parts.
    pub(super) fn feature(&mut self, element: &Element, parent: Option<usize>) -> Result<()> {
        let number = self.draft.features.len();
        let named = || format!("{} at line {}", element.name, element.line);
        self.draft.features.push(Feature {
            id: element.attribute("id").map_or_else(named, str::to_owned),
            kind: element.name.clone(),
            line: element.line,
            parent,
            ..Feature::default()
        });
        // Features nest: an error in a part belongs to the part alone.
        let around = self.draft.wrong.take();
        while let Some(property) = self.xml.child()? {
            self.property(&property, number)?;
        }
        let wrong = std::mem::replace(&mut self.draft.wrong, around);
        if let Some(feature) = self.draft.features.get_mut(number) {
            feature.wrong = wrong;
        }
        Ok(())
    }

    fn property(&mut self, property: &Element, number: usize) -> Result<()> {
        let name = property.name.as_str();
        if let Some(level) = level_of(name) {
            return self.geometry_property(property, number, level, PiecePart::Whole);
        }
        match name {
            "boundedBy" | "boundary" => self.surfaces(number),
            "lod" => {
                let level = Lod::parse(&self.xml.words()?);
                self.feature_mut(number, |feature| feature.lod = level);
                Ok(())
            }
            "tin" => {
                let level = self.draft.features.get(number).and_then(|feature| feature.lod);
                self.geometry_property(property, number, level, PiecePart::Whole)
            }
            "breaklines" | "ridgeOrValleyLines" => self.leave_out(LINES),
            "reliefPoints" => self.leave_out("as mass points of terrain"),
            "grid" => self.leave_out("as grids of terrain in other files"),
            _ if SKIPPED.contains(&name) => self.xml.skip(),
            _ => self.other_property(property, number),
        }
    }

    /// Reads an attribute, or the parts of a feature.
    fn other_property(&mut self, property: &Element, number: usize) -> Result<()> {
        if let Some((name, value)) = self.attribute(property)? {
            self.feature_mut(number, |feature| feature.attributes.add(&name, value));
            return Ok(());
        }
        while let Some(element) = self.xml.child()? {
            match element.name.as_str() {
                name if PARTS.contains(&name) => self.feature(&element, Some(number))?,
                name if INSIDE.contains(&name) => {
                    self.leave_out("as rooms, furniture and storeys inside of buildings, bridges and tunnels")?;
                }
                name if is_surface(name) => self.surface(&element, number)?,
                _ => self.xml.skip()?,
            }
        }
        Ok(())
    }

    fn leave_out(&mut self, reason: &'static str) -> Result<()> {
        self.draft.store.leave_out(reason);
        self.xml.skip()
    }

    /// Reads the envelope or the thematic surfaces within a property.
    fn surfaces(&mut self, number: usize) -> Result<()> {
        while let Some(element) = self.xml.child()? {
            if element.name == "Envelope" {
                self.state_system(&element);
                self.xml.skip()?;
            } else if is_surface(&element.name) {
                self.surface(&element, number)?;
            } else {
                self.xml.skip()?;
            }
        }
        Ok(())
    }

    /// Reads a thematic surface and its openings.
    fn surface(&mut self, element: &Element, number: usize) -> Result<()> {
        let name = self.draft.store.name(usual_name(&element.name));
        while let Some(property) = self.xml.child()? {
            if let Some(level) = level_of(&property.name) {
                self.geometry_property(&property, number, level, PiecePart::Surface(name))?;
                continue;
            }
            match property.name.as_str() {
                "opening" | "fillingSurface" | "filling" | "boundedBy" | "boundary" => self.surfaces(number)?,
                _ => self.xml.skip()?,
            }
        }
        Ok(())
    }

    fn geometry_property(
        &mut self,
        property: &Element,
        number: usize,
        lod: Option<Lod>,
        part: PiecePart,
    ) -> Result<()> {
        let is = |word: &str| property.name.contains(word);
        if ["Curve", "TerrainIntersection", "Network", "Point"].into_iter().any(is) {
            return self.leave_out(LINES);
        }
        if is("Implicit") {
            return self.implicit(number, lod, part);
        }
        let name = if let PiecePart::Surface(name) = part { name } else { None };
        let start = self.draft.store.member_count();
        self.geometry_within(property, Around { name, ..Around::default() })?;
        let part = if is("RoofEdge") { PiecePart::RoofEdge } else { part };
        self.push_piece(number, Piece { lod, members: start..self.draft.store.member_count(), part, instance: None });
        Ok(())
    }

    fn push_piece(&mut self, number: usize, piece: Piece) {
        if !piece.members.is_empty() {
            self.feature_mut(number, |feature| feature.pieces.push(piece));
        }
    }

    /// Reads an instance of a template, which stands in the instance itself or elsewhere in the
    /// file.
    fn implicit(&mut self, number: usize, lod: Option<Lod>, part: PiecePart) -> Result<()> {
        while let Some(geometry) = self.xml.child()? {
            let (mut transformation, mut at, mut is_elsewhere) = (None, None, false);
            let start = self.draft.store.member_count();
            while let Some(property) = self.xml.child()? {
                match property.name.as_str() {
                    "transformationMatrix" => {
                        self.numbers.clear();
                        self.read_numbers(property.line)?;
                        match matrix(Some(&self.numbers)) {
                            Ok(found) => transformation = Some(found),
                            Err(what) => self.wrong(property.line, &what),
                        }
                    }
                    "relativeGMLGeometry" | "relativeGeometry" => {
                        self.geometry_within(&property, Around { is_template: true, ..Around::default() })?;
                    }
                    "referencePoint" => at = self.point_within()?,
                    "libraryObject" => {
                        is_elsewhere = true;
                        self.xml.skip()?;
                    }
                    _ => self.xml.skip()?,
                }
            }
            let members = start..self.draft.store.member_count();
            if members.is_empty() {
                if is_elsewhere {
                    self.draft.store.leave_out("as instances of shapes that stand in other files");
                }
                continue;
            }
            let Some(at) = at else {
                self.wrong(geometry.line, "its ImplicitGeometry has no `referencePoint` of three coordinates");
                continue;
            };
            let instance = Some(Instance { matrix: transformation.unwrap_or(DMat4::IDENTITY), at });
            self.push_piece(number, Piece { lod, members, part, instance });
        }
        Ok(())
    }

    fn feature_mut(&mut self, number: usize, change: impl FnOnce(&mut Feature)) {
        if let Some(feature) = self.draft.features.get_mut(number) {
            change(feature);
        }
    }
}

/// Returns the level of detail of a geometry property, such as `lod2MultiSurface` or
/// `lod0FootPrint`; `None` for other properties.
fn level_of(property: &str) -> Option<Option<Lod>> {
    let digits = property.strip_prefix("lod")?;
    let length = digits.bytes().take_while(u8::is_ascii_digit).count();
    Lod::parse(digits.get(..length)?).map(Some)
}

fn is_surface(name: &str) -> bool {
    let known = ["TrafficArea", "AuxiliaryTrafficArea", "Marking", "Window", "Door"];
    name.ends_with("Surface") || known.contains(&name)
}

/// Returns the CityGML 2.0 name of a type that CityGML 3.0 renamed.
fn usual_name(name: &str) -> &str {
    match name {
        "WindowSurface" => "Window",
        "DoorSurface" => "Door",
        "Marking" => "TransportationMarking",
        other => other,
    }
}
