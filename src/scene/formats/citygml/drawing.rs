//! Geometry of GML. In: an element that draws something. Out: its polygons and references, in the
//! store of the object being read.

use crate::formats::citygml::coordinates::Unusable;
use crate::formats::citygml::scan::Scan;
use crate::formats::cityjson::templates::MAX_CORNERS;
use crate::formats::xml::Element;
use glam::DVec3;
use heliotile_core::error::{Error, Result};

/// Context of a geometry element: what the elements around it state.
#[derive(Clone, Copy, Default)]
pub(super) struct Around {
    /// Numbers in a position, where stated.
    pub dimension: Option<u8>,
    /// True if positions belong to a template, in metres about its own origin.
    pub is_template: bool,
    /// True if an element around this one reverses its surfaces.
    pub is_reversed: bool,
    /// Index of the name of the thematic surface to which it belongs.
    pub name: Option<u16>,
}

/// Result of reading a ring.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Ring {
    Sound,
    /// A ring without heights.
    Flat,
    Wrong,
}

pub(super) const LINES: &str = "as points or lines, which shade nothing";
const FLAT: &str = "as outlines whose corners have no heights";
const CURVED: &str = "as surfaces that are bounded by curves";
const UNKNOWN: &str = "as geometry of a kind that is not read";

impl Scan<'_> {
    /// Reads all geometry within a property.
    pub(super) fn geometry_within(&mut self, property: &Element, around: Around) -> Result<()> {
        if let Some(href) = property.attribute("href") {
            self.refer(href, around);
        }
        while let Some(element) = self.xml.child()? {
            self.geometry(&element, around)?;
        }
        Ok(())
    }

    fn refer(&mut self, href: &str, around: Around) {
        if href.starts_with('#') {
            self.draft.store.refer(href, around.is_reversed);
        } else {
            self.draft.store.leave_out("as references to other files");
        }
    }

    /// Reads a geometry element to its end.
    fn geometry(&mut self, element: &Element, mut around: Around) -> Result<()> {
        self.stated(element, &mut around);
        let start = self.draft.store.member_count();
        match element.name.as_str() {
            "Polygon" | "PolygonPatch" | "Triangle" | "Rectangle" => self.polygon(element, around)?,
            "OrientableSurface" => {
                let is_other = element.attribute("orientation") == Some("-");
                self.parts(Around { is_reversed: around.is_reversed != is_other, ..around })?;
            }
            "MultiSurface"
            | "CompositeSurface"
            | "Shell"
            | "Surface"
            | "PolyhedralSurface"
            | "TriangulatedSurface"
            | "Tin"
            | "Solid"
            | "MultiSolid"
            | "CompositeSolid"
            | "MultiGeometry"
            | "GeometricComplex"
            | "MultiPolygon" => self.parts(around)?,
            name => {
                let is_line = ["Point", "Curve", "Line"].iter().any(|word| name.contains(word));
                self.draft.store.leave_out(if is_line { LINES } else { UNKNOWN });
                self.xml.skip()?;
            }
        }
        if let Some(id) = element.attribute("id") {
            self.draft.store.set_place(id, start, around.is_reversed);
        }
        Ok(())
    }

    /// Records the dimension and the coordinate system that an element states.
    fn stated(&mut self, element: &Element, around: &mut Around) {
        let dimension = element.attribute("srsDimension").and_then(|text| text.trim().parse().ok());
        around.dimension = dimension.or(around.dimension);
        if let Some(text) = element.attribute("srsName").filter(|_| !around.is_template)
            && let Err(what) = self.coordinates.state(text)
        {
            self.wrong(element.line, &what);
        }
    }

    /// Reads the members of an aggregate.
    fn parts(&mut self, around: Around) -> Result<()> {
        while let Some(property) = self.xml.child()? {
            match property.name.as_str() {
                "stopLines" | "breakLines" => {
                    self.draft.store.leave_out(LINES);
                    self.xml.skip()?;
                }
                "controlPoint" | "maxLength" | "boundedBy" | "metaDataProperty" | "name" | "description" => {
                    self.xml.skip()?;
                }
                _ => self.geometry_within(&property, around)?,
            }
        }
        Ok(())
    }

    fn polygon(&mut self, element: &Element, around: Around) -> Result<()> {
        let first = self.draft.store.corner_count();
        let mut state = Ring::Sound;
        while let Some(property) = self.xml.child()? {
            if !["exterior", "interior", "outerBoundaryIs", "innerBoundaryIs"].contains(&property.name.as_str()) {
                self.xml.skip()?;
                continue;
            }
            while let Some(ring) = self.xml.child()? {
                let found = self.ring(&ring, around)?;
                state = if state == Ring::Sound { found } else { state };
            }
        }
        let store = &mut self.draft.store;
        if state == Ring::Sound {
            let polygon = store.end_polygon(first, around.name, element.line);
            store.push_polygon(polygon, around.is_reversed);
        } else {
            store.back_to(first);
            if state == Ring::Flat {
                store.leave_out(FLAT);
            }
        }
        Ok(())
    }

    fn ring(&mut self, ring: &Element, mut around: Around) -> Result<Ring> {
        if ring.name == "Ring" {
            return self.ring_of_curves(ring, around);
        }
        if ring.name != "LinearRing" {
            self.draft.store.leave_out(CURVED);
            self.xml.skip()?;
            return Ok(Ring::Wrong);
        }
        self.stated(ring, &mut around);
        self.numbers.clear();
        let mut sound = true;
        while let Some(part) = self.xml.child()? {
            match part.name.as_str() {
                "posList" | "pos" | "coordinates" => {
                    self.stated(&part, &mut around);
                    sound &= self.read_numbers(part.line)?;
                }
                "pointProperty" | "pointRep" => {
                    while let Some(_point) = self.xml.child()? {
                        while let Some(position) = self.xml.child()? {
                            sound &= self.read_numbers(position.line)?;
                        }
                    }
                }
                _ => self.xml.skip()?,
            }
        }
        if !sound {
            return Ok(Ring::Wrong);
        }
        self.ring_of_numbers(ring, around)
    }

    /// Reads a ring whose sides are curves; all of them have to be straight lines.
    fn ring_of_curves(&mut self, ring: &Element, mut around: Around) -> Result<Ring> {
        self.stated(ring, &mut around);
        self.numbers.clear();
        let (mut sound, mut is_straight) = (true, true);
        self.straight_sides(&mut around, &mut sound, &mut is_straight)?;
        if !is_straight {
            self.draft.store.leave_out(CURVED);
        }
        if !sound || !is_straight || self.numbers.is_empty() {
            return Ok(Ring::Wrong);
        }
        self.ring_of_numbers(ring, around)
    }

    /// Appends the corners of all straight lines within an element to the numbers. A line begins
    /// where the one before it ends, and that corner counts once.
    fn straight_sides(&mut self, around: &mut Around, sound: &mut bool, is_straight: &mut bool) -> Result<()> {
        while let Some(element) = self.xml.child()? {
            self.stated(&element, around);
            match element.name.as_str() {
                "curveMember" | "curveMembers" | "segments" | "Curve" | "CompositeCurve" | "LineString"
                | "LineStringSegment" => self.straight_sides(around, sound, is_straight)?,
                "posList" | "pos" | "coordinates" => {
                    let (before, size) = (self.numbers.len(), around.dimension.map_or(3, usize::from));
                    *sound &= self.read_numbers(element.line)?;
                    let end = before.checked_sub(size).and_then(|start| self.numbers.get(start..before));
                    if end.is_some() && end == self.numbers.get(before..before + size) {
                        self.numbers.drain(before..before + size);
                    }
                }
                _ => {
                    *is_straight = false;
                    self.xml.skip()?;
                }
            }
        }
        Ok(())
    }

    /// Makes a ring from the numbers that were read, if they are three for each corner.
    fn ring_of_numbers(&mut self, ring: &Element, around: Around) -> Result<Ring> {
        let count = self.numbers.len();
        match around.dimension {
            Some(2) => Ok(Ring::Flat),
            // An even number that 3 does not divide means corners of two coordinates.
            None if !count.is_multiple_of(3) && count.is_multiple_of(2) => Ok(Ring::Flat),
            _ if !count.is_multiple_of(3) => {
                self.wrong(ring.line, &format!("a ring has {count} numbers, not three for each corner"));
                Ok(Ring::Wrong)
            }
            _ => self.corners(ring, around),
        }
    }

    /// Appends the numbers of an element to those read before; returns true if all of them are
    /// numbers.
    pub(super) fn read_numbers(&mut self, line: usize) -> Result<bool> {
        let text = self.xml.text()?;
        let words = text.split(|byte| byte.is_ascii_whitespace() || *byte == b',').filter(|word| !word.is_empty());
        for word in words {
            match crate::text::number(word).filter(|number| number.is_finite()) {
                Some(number) => self.numbers.push(number),
                None => {
                    let what = format!("a coordinate is `{}`, not a number", crate::text::excerpt(word));
                    self.wrong(line, &what);
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// Makes a ring from the numbers that were read.
    fn corners(&mut self, ring: &Element, around: Around) -> Result<Ring> {
        let mut numbers = std::mem::take(&mut self.numbers);
        self.ring_corners.clear();
        // The last corner of a ring repeats the first one.
        let repeated = numbers.len() > 3 && numbers.first_chunk::<3>() == numbers.last_chunk::<3>();
        numbers.truncate(numbers.len() - if repeated { 3 } else { 0 });
        let mut found = Ok(Ring::Sound);
        for corner in numbers.as_chunks::<3>().0 {
            match self.vertex(*corner, around) {
                Ok(vertex) => self.ring_corners.push(vertex),
                Err(Unusable::Object(what)) => {
                    self.wrong(ring.line, &what);
                    found = Ok(Ring::Wrong);
                    break;
                }
                Err(Unusable::File { what, hint }) => {
                    found = Err(Error::input(self.xml.file(), ring.line, what, hint));
                    break;
                }
            }
        }
        self.numbers = numbers;
        self.corners_read += self.ring_corners.len() as u64;
        if self.corners_read > MAX_CORNERS {
            return Err(Error::Limit {
                what: format!("the number of corners of {} (split it into tiles)", self.xml.file().display()).into(),
                value: self.corners_read,
                max: MAX_CORNERS,
            });
        }
        self.draft.store.push_ring(&self.ring_corners);
        found
    }

    fn vertex(&mut self, numbers: [f64; 3], around: Around) -> std::result::Result<u32, Unusable> {
        let store = &mut self.draft.store;
        if around.is_template {
            let position = DVec3::from(numbers);
            let known = crate::coordinate::is_position(position);
            let far = || Unusable::Object(format!("a corner of a template lies at {position}"));
            return if known { Ok(store.push_vertex(position)) } else { Err(far()) };
        }
        if let Some(vertex) = store.known(numbers) {
            return Ok(vertex);
        }
        let position = self.coordinates.place(numbers)?;
        Ok(store.add_vertex(numbers, position))
    }

    /// Returns the position of a `Point` within a property.
    pub(super) fn point_within(&mut self) -> Result<Option<DVec3>> {
        let mut found = None;
        while let Some(point) = self.xml.child()? {
            let mut around = Around::default();
            self.stated(&point, &mut around);
            while let Some(position) = self.xml.child()? {
                self.numbers.clear();
                if !self.read_numbers(position.line)? {
                    continue;
                }
                let Ok(numbers) = <[f64; 3]>::try_from(self.numbers.as_slice()) else { continue };
                match self.coordinates.place(numbers) {
                    Ok(place) => found = Some(place),
                    Err(Unusable::Object(what)) => self.wrong(position.line, &what),
                    Err(Unusable::File { what, hint }) => {
                        return Err(Error::input(self.xml.file(), position.line, what, hint));
                    }
                }
            }
        }
        Ok(found)
    }
}
