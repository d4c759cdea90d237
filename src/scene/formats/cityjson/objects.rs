//! City objects as polygons. In: a parsed document, or a line of a sequence. Out: faces with holes,
//! each with a material and an object. One level of detail is read of each object.

use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use crate::attributes::{GONE, is_gone, text_of};
use crate::coordinate::is_position;
use crate::formats::cityjson::document::{CityObject, Document, Lod, Shape, Text};
use crate::formats::cityjson::frame::Frame;
use crate::formats::cityjson::surfaces::{
    INNER, VIRTUAL, WALL, by_tilt, depth_of, is_building, is_hull, kind_of, plain, semantic,
};
use crate::formats::cityjson::templates::{CORNER_BYTES, MAX_CORNERS, Template, matrix};
use crate::geometry::Geometry;
use crate::text::excerpt;
use heliotile_core::error::{Error, Result};
use heliotile_core::site::scene_object::ObjectNote;
use heliotile_core::site::semantics::{FaceNote, FaceSource};
use heliotile_files::input::budget::WorkBudget;

/// Reason for leaving out flat outlines of buildings.
pub(super) const OUTLINES: &str = "as flat outlines of buildings (LoD 0), which have neither walls nor a roof";

/// Reasons for leaving out geometry: of levels of detail that are not chosen, and of objects
/// without a level to choose.
pub(in crate::formats) const OTHER_LEVEL: &str = "as geometry in another level of detail";
pub(in crate::formats) const NO_LEVEL: &str =
    "because they have neither the requested level of detail nor a coarser one";

/// Most levels of detail that a message lists.
pub(in crate::formats) const LEVELS_NAMED: usize = 12;

/// Reader of city objects, with the geometry read so far.
pub(in crate::formats) struct Reader<'f, 'h> {
    pub file: &'f Path,
    /// Line of a sequence, or `None` for a single document.
    pub line: Option<usize>,
    pub asked: Option<Lod>,
    pub frame: Frame,
    pub templates: &'h [Template<'h>],
    pub geometry: Geometry,
    pub objects: usize,
    /// Some of the levels of detail that were found.
    pub levels: BTreeSet<Lod>,
    /// Corners of all template instances.
    pub instanced: u64,
    /// Memory that instances may take.
    pub budget: WorkBudget,
    /// Names of buildings whose finest level of detail has no walls while a coarser one has.
    pub coarser: Vec<String>,
    /// Errors of objects that are left out.
    pub skipped: Vec<Error>,
    /// Hint on how to repair a damaged file of the format.
    pub mend: &'static str,
}

/// Range of vertices that boundaries refer to.
#[derive(Clone, Copy)]
struct Range {
    first: u32,
    count: u32,
    /// True if rings must be reversed.
    mirrored: bool,
}

/// Object whose geometry is being read.
struct Owner<'d> {
    id: &'d str,
    kind: &'d str,
    number: u32,
    /// Index of the geometry that is being read.
    geometry: usize,
}

/// Place of a face in the file.
struct FacePlace {
    source: FaceSource,
    /// Line, counted from 1; 0 where the format has no lines.
    line: usize,
}

/// Geometries of an object that bound something, with their levels of detail.
type Offers<'d> = Vec<Offer<'d>>;

struct Offer<'d> {
    lod: Option<Lod>,
    shape: &'d Shape<'d>,
    /// Index among the geometries of the object.
    number: usize,
}

impl<'h> Reader<'_, 'h> {
    /// Adds the objects of a document or of a feature.
    pub(in crate::formats) fn add(&mut self, document: &Document) -> Result<()> {
        let range = self.vertices(&document.vertices)?;
        self.objects += document.objects.len();
        let chosen: Vec<Offers> =
            document.objects.iter().map(|(id, object)| self.choose(&id.0, object, range)).collect();
        self.count_instances(&chosen)?;
        let parts = finest_parts(&document.objects, &chosen);
        let parents = Parents::new(&document.objects);
        let stating = document.objects.iter().filter(|(_, object)| !object.attributes.is_empty());
        let stated: HashMap<&str, &CityObject> = stating.map(|(id, object)| (id.0.as_ref(), object)).collect();
        for (((id, object), shapes), finest) in document.objects.iter().zip(chosen).zip(parts) {
            let level = shapes.first().and_then(|offer| offer.lod);
            let whole = stated.get(parents.top_of(&id.0));
            if !shapes.is_empty()
                && (is_gone(&object.attributes) || whole.is_some_and(|whole| is_gone(&whole.attributes)))
            {
                self.geometry.leave_out(GONE);
                continue;
            }
            if finest > level {
                (0..shapes.len())
                    .for_each(|_| self.geometry.leave_out("as coarser geometry of objects whose parts have finer"));
                continue;
            }
            if shapes.is_empty() {
                continue;
            }
            if self.is_outline(plain(&object.kind), level) {
                (0..shapes.len()).for_each(|_| self.geometry.leave_out(OUTLINES));
                continue;
            }
            let number = self.geometry.objects.id(&id.0);
            let kind = plain(&object.kind);
            let note = ObjectNote {
                building: parents.top_of(&id.0).to_owned(),
                object_type: kind.to_owned(),
                beside: !is_hull(kind),
                attributes: attributes_of(object, stated.get(parents.top_of(&id.0)).copied()),
                ..ObjectNote::default()
            };
            self.geometry.object_notes.insert(number, note);
            let mark = self.geometry.mark();
            let read = shapes.into_iter().try_for_each(|Offer { shape, number: geometry, .. }| {
                self.shape(&Owner { id: &id.0, kind, number, geometry }, shape, range)
            });
            match read {
                // An error within an object does not affect other objects.
                Err(error @ Error::Input { .. }) => {
                    self.geometry.back_to(&mark);
                    self.skipped.push(error);
                }
                other => other?,
            }
        }
        Ok(())
    }

    /// Returns true for a building's flat outline that was not asked for.
    fn is_outline(&self, kind: &str, level: Option<Lod>) -> bool {
        is_hull(kind) && level.is_some_and(Lod::is_flat) && !self.asked.is_some_and(Lod::is_flat)
    }

    /// Counts the corners of template instances, and refuses more than memory may hold before the
    /// first instance is made.
    fn count_instances(&mut self, chosen: &[Offers]) -> Result<()> {
        let instances = chosen.iter().flatten().filter_map(|offer| self.template(offer.shape));
        let corners = instances.map(|template| template.corners).sum::<u64>();
        self.budget.spend(corners, CORNER_BYTES, "instances of templates", self.file)?;
        self.instanced += corners;
        if self.instanced > MAX_CORNERS {
            return Err(Error::Limit {
                what: format!("the number of corners of instances of templates in {}", self.file.display()).into(),
                value: self.instanced,
                max: MAX_CORNERS,
            });
        }
        Ok(())
    }

    /// Returns the template of which a geometry is an instance.
    fn template(&self, shape: &Shape) -> Option<&'h Template<'h>> {
        let number = shape.template.filter(|_| shape.kind.0 == "GeometryInstance")?;
        self.templates.get(usize::try_from(number).ok()?)
    }

    fn vertices(&mut self, vertices: &[[f64; 3]]) -> Result<Range> {
        let first = self.geometry.vertices.len();
        for (i, &vertex) in vertices.iter().enumerate() {
            let position = self.frame.place(vertex);
            if !is_position(position) {
                let what = format!("vertex {i} lies at {position}, beyond all positions on Earth");
                return Err(self.error(what, "scale and translation of `transform` give metres, at most 1e9 in size"));
            }
            self.geometry.push_vertex(self.file, position)?;
        }
        // `push_vertex` allows no more vertices than u32 counts.
        Ok(Range { first: first as u32, count: vertices.len() as u32, mirrored: false })
    }

    /// Returns the geometries of an object's chosen level of detail: the level asked for, otherwise
    /// the finest below it; the finest of all if no level is asked for. All geometries of that
    /// level belong to the object (CityJSON 2.0.1, section 3). A building whose finest level has no
    /// walls gets its finest level that has.
    fn choose<'d>(&mut self, id: &str, object: &'d CityObject, range: Range) -> Offers<'d> {
        let mut offers: Offers = Vec::new();
        if object.kind.0 == "CityObjectGroup" {
            let outlines = object.geometry.iter().flatten().count();
            (0..outlines).for_each(|_| self.geometry.leave_out("as outlines of groups of objects"));
            return offers;
        }
        for (number, shape) in object.geometry.iter().flatten().enumerate() {
            // An instance has the type and the level of detail of its template.
            let shown = self.template(shape).map_or(shape, |template| &template.shape);
            match depth_of(&shown.kind.0) {
                None if shown.kind.0 != "GeometryInstance" => self.geometry.leave_out(match shown.kind.0.as_ref() {
                    "MultiPoint" | "MultiLineString" => "as points or lines, which shade nothing",
                    _ => "as geometry of a type that CityJSON 2.0 does not have",
                }),
                _ => offers.push(Offer { lod: shown.lod, shape, number }),
            }
        }
        if self.levels.len() < LEVELS_NAMED {
            self.levels.extend(offers.iter().filter_map(|offer| offer.lod));
        }
        let Some(mut level) = level_of(offers.iter().map(|offer| offer.lod), self.asked) else {
            offers.iter().for_each(|_| self.geometry.leave_out(NO_LEVEL));
            return Vec::new();
        };
        if self.asked.is_none() && is_hull(plain(&object.kind)) && offers.iter().any(|offer| offer.lod != level) {
            let walled = offers.iter().filter(|offer| self.has_walls(offer.shape, range)).map(|offer| offer.lod).max();
            if let Some(walled) = walled.filter(|walled| *walled < level) {
                level = walled;
                self.coarser.push(id.to_owned());
            }
        }
        let before = offers.len();
        offers.retain(|offer| offer.lod == level);
        (offers.len()..before).for_each(|_| self.geometry.leave_out(OTHER_LEVEL));
        offers
    }

    /// Returns true if a geometry has an upright face, or is an instance of a template.
    fn has_walls(&self, shape: &Shape, range: Range) -> bool {
        let Some(boundaries) = shape.boundaries.as_ref().filter(|_| shape.kind.0 != "GeometryInstance") else {
            return shape.template.is_some();
        };
        let surfaces = boundaries.surfaces(depth_of(&shape.kind.0).unwrap_or_default(), None).unwrap_or_default();
        let outlines = surfaces.iter().filter_map(|surface| boundaries.rings(surface).next());
        let mut known =
            outlines.filter(|outline| outline.len() > 2 && outline.iter().all(|corner| *corner < range.count));
        known.any(|outline| self.tilt(outline, range) == WALL)
    }

    fn shape(&mut self, owner: &Owner, shape: &Shape, range: Range) -> Result<()> {
        if shape.kind.0 != "GeometryInstance" {
            return self.surfaces(owner, shape, range);
        }
        let Some(template) = self.template(shape) else {
            let what = match shape.template {
                Some(number) => format!(
                    "its `template` is {number}, but the {} templates are numbered from 0",
                    self.templates.len()
                ),
                None => "its instance of a template has no `template`".into(),
            };
            return Err(self.wrong(owner, what));
        };
        let matrix = matrix(shape.matrix.as_deref()).map_err(|what| self.wrong(owner, what))?;
        let Some(anchor) = shape.boundaries.as_ref().and_then(|boundaries| boundaries.single()) else {
            return Err(self.wrong(owner, "boundaries of an instance of a template are not one vertex number".into()));
        };
        let at = self.geometry.vertices.get(self.corner(owner, range, anchor)? as usize).copied().unwrap_or_default();
        let first = self.geometry.vertices.len() as u32;
        for &vertex in &template.vertices {
            let position = matrix.transform_point3(vertex) + at;
            if !is_position(position) {
                let what = format!("its template would have a vertex at {position}, beyond all positions on Earth");
                return Err(self.wrong(owner, what));
            }
            self.geometry.push_vertex(self.file, position)?;
        }
        // Mirroring turns faces inside out; reversed rings turn them back.
        let mirrored = matrix.determinant() < 0.0;
        self.surfaces(owner, &template.shape, Range { first, count: template.vertices.len() as u32, mirrored })
    }

    fn surfaces(&mut self, owner: &Owner, shape: &Shape, range: Range) -> Result<()> {
        let Some(boundaries) = &shape.boundaries else {
            return Err(self.wrong(owner, format!("its {} has no `boundaries`", excerpt(shape.kind.0.as_bytes()))));
        };
        let values = shape.semantics.as_ref().and_then(|semantics| semantics.values.as_ref());
        let depth = depth_of(&shape.kind.0).unwrap_or_default();
        let surfaces = boundaries.surfaces(depth, values).map_err(|what| self.wrong(owner, what))?;
        for (i, surface) in surfaces.iter().enumerate() {
            let line = shape.lines.get(i).map(|line| *line as usize);
            let stated = semantic(shape, surface.value).map_err(|what| self.wrong(owner, what))?;
            if stated.is_some_and(|name| VIRTUAL.contains(&name)) {
                self.geometry.leave_out("as surfaces that only close a volume, such as ClosureSurface");
                continue;
            }
            let source = match line {
                Some(_) => FaceSource::Order,
                None => FaceSource::Boundary {
                    // Vertices are counted in 32 bits, and there are no more geometries than
                    // vertices; depths are 3 to 5.
                    geometry: owner.geometry as u32,
                    path: surface.path,
                    depth: depth.saturating_sub(2) as u8,
                },
            };
            let place = FacePlace { source, line: line.or(self.line).unwrap_or_default() };
            self.face(owner, boundaries.rings(surface), stated, range, place)?;
        }
        Ok(())
    }

    fn face<'r>(
        &mut self,
        owner: &Owner,
        mut rings: impl Iterator<Item = &'r [u32]>,
        stated: Option<&str>,
        range: Range,
        place: FacePlace,
    ) -> Result<()> {
        let outline = rings.next().unwrap_or_default();
        if outline.len() < 3 {
            self.geometry.leave_out("with fewer than three corners");
            return Ok(());
        }
        self.ring(owner, outline, range)?;
        for hole in rings {
            if hole.len() < 3 {
                self.geometry.leave_out("as holes with fewer than three corners");
                continue;
            }
            self.geometry.begin_hole();
            self.ring(owner, hole, range)?;
        }
        let name = match stated {
            Some(name) => name,
            None if is_building(owner.kind) => self.tilt(outline, range),
            None => owner.kind,
        };
        let kind = kind_of(name);
        let material = self.geometry.materials.id(name);
        // The face may be turned outwards later, and is then named again.
        if stated.is_none() && is_building(owner.kind) {
            self.geometry.by_tilt.push(self.geometry.face_count());
        }
        self.geometry.end_face(material, owner.number, place.line);
        let exposed = INNER.contains(&name).then_some(false);
        self.geometry.note_face(FaceNote { kind, exposed, source: place.source });
        Ok(())
    }

    fn ring(&mut self, owner: &Owner, ring: &[u32], range: Range) -> Result<()> {
        let mut push = |number: &u32| {
            let corner = self.corner(owner, range, *number)?;
            self.geometry.push_corner(corner);
            Ok(())
        };
        if range.mirrored { ring.iter().rev().try_for_each(&mut push) } else { ring.iter().try_for_each(&mut push) }
    }

    /// Returns the vertex that a number refers to.
    #[inline]
    fn corner(&self, owner: &Owner, range: Range, number: u32) -> Result<u32> {
        if number < range.count {
            return Ok(range.first + number);
        }
        Err(self
            .wrong(owner, format!("its boundaries name vertex {number} of {} vertices, counted from 0", range.count)))
    }

    fn tilt(&self, outline: &[u32], range: Range) -> &'static str {
        let position = |number: &u32| self.geometry.vertices.get((range.first + number) as usize).copied();
        let ring = outline.iter().map(|number| position(number).unwrap_or_default());
        if range.mirrored { by_tilt(ring.rev()) } else { by_tilt(ring) }
    }

    fn error(&self, what: String, hint: &'static str) -> Error {
        Error::input(self.file, self.line, what, hint)
    }

    #[cold]
    fn wrong(&self, owner: &Owner, what: String) -> Error {
        self.error(format!("object `{}`: {what}", excerpt(owner.id.as_bytes())), self.mend)
    }
}

/// Returns the level of detail asked for, otherwise the finest below it; the finest of all if no
/// level is asked for.
pub(in crate::formats) fn level_of(
    levels: impl Iterator<Item = Option<Lod>>,
    asked: Option<Lod>,
) -> Option<Option<Lod>> {
    levels.filter(|level| asked.is_none() || *level <= asked).max()
}

/// Returns the attributes of an object as text, completed by the attributes of the whole that it
/// belongs to.
fn attributes_of(object: &CityObject, whole: Option<&CityObject>) -> String {
    let mut all = whole.map(|whole| whole.attributes.clone()).unwrap_or_default();
    all.extend(object.attributes.clone());
    text_of(all)
}

/// Returns the finest level among the parts of each object; `None` for an object without parts.
///
/// A Building and its BuildingParts both have geometry in two cases. In the first it is a coarser
/// stand-in for all parts, which must be left out: 3DBAG gives every building its footprint as LoD
/// 0 beside parts of LoD 2.2. In the second it is a main part beside the other parts (CityGML 2.0,
/// section 10.3.1), which has their level of detail and must stay. Children that are not parts,
/// such as installations, replace nothing.
fn finest_parts(objects: &[(Text, CityObject)], chosen: &[Offers]) -> Vec<Option<Lod>> {
    let mut finest = vec![None; objects.len()];
    if objects.iter().all(|(_, object)| object.parents.is_none() && object.children.is_none()) {
        return finest;
    }
    let numbers: HashMap<&str, usize> = objects.iter().enumerate().map(|(i, (id, _))| (id.0.as_ref(), i)).collect();
    let number = |id: &Text| numbers.get(id.0.as_ref()).copied();
    let mut link = |parent: usize, child: usize| {
        let is_part = objects.get(child).is_some_and(|(_, object)| plain(&object.kind).ends_with("Part"));
        let level = chosen.get(child).and_then(|shapes| shapes.first()).and_then(|offer| offer.lod);
        if let (true, Some(slot)) = (is_part && parent != child, finest.get_mut(parent)) {
            *slot = level.max(*slot);
        }
    };
    // Files state the relation at the parent, at the part, or at both.
    for (i, (_, object)) in objects.iter().enumerate() {
        object.parents.iter().flatten().filter_map(number).for_each(|parent| link(parent, i));
        object.children.iter().flatten().filter_map(number).for_each(|child| link(i, child));
    }
    finest
}

/// Most steps upwards. Real models need three: a room of a storey of a part of a building. Hostile
/// ones go in circles.
const MAX_STEPS: usize = 16;

/// Parent of each object that has one, by name.
pub(super) struct Parents<'d>(HashMap<&'d str, &'d str>);

impl<'d> Parents<'d> {
    /// Collects the parents. An object's own statement overrides that of an object that names it as
    /// a child; the first of several parents counts.
    pub(super) fn new(objects: &'d [(Text, CityObject)]) -> Self {
        let mut parents = HashMap::new();
        for (id, object) in objects {
            for child in object.children.iter().flatten() {
                parents.insert(child.0.as_ref(), id.0.as_ref());
            }
        }
        for (id, object) in objects {
            if let Some(parent) = object.parents.iter().flatten().next() {
                parents.insert(id.0.as_ref(), parent.0.as_ref());
            }
        }
        Parents(parents)
    }

    /// Returns the topmost parent of an object, or the object itself if it has no parent.
    pub(super) fn top_of<'s>(&self, id: &'s str) -> &'s str
    where
        'd: 's,
    {
        let mut top = id;
        for _ in 0..MAX_STEPS {
            match self.0.get(top) {
                Some(&parent) if parent != top => top = parent,
                _ => break,
            }
        }
        top
    }
}
