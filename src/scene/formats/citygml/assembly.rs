//! City objects in the form that the CityJSON reader takes. In: a draft. Out: a document of its
//! features, each with the one level of detail that is read, every surface once, with the name of
//! its thematic surface.

use std::collections::{BTreeMap, HashMap, HashSet};

use crate::attributes::flat;
use crate::coordinate::is_position;
use crate::formats::citygml::closed::is_closed;
use crate::formats::citygml::feature::{Feature, Instance, Piece, PiecePart};
use crate::formats::citygml::levels::{Levels, Offer};
use crate::formats::citygml::members::follow;
use crate::formats::citygml::scan::{Draft, MEND};
use crate::formats::citygml::store::{Side, Store};
use crate::formats::cityjson::document::{CityObject, Document, Semantics, Shape, SurfaceKind, Text};
use crate::formats::cityjson::nested::Nested;
use crate::formats::cityjson::objects::Reader;
use crate::formats::cityjson::templates::{CORNER_BYTES, MAX_CORNERS};
use crate::text::excerpt;
use heliotile_core::error::{Error, Result};

const NOWHERE: &str = "as references to ids that are not in the file";
const ENDLESS: &str = "as references that lead to each other in circles or without end";
const BESIDE: &str = "as solids whose surfaces are repeated as thematic surfaces";

/// Surfaces of a feature in one level of detail.
#[derive(Default)]
pub(super) struct Surfaces {
    /// Surfaces of its solids and multi-surfaces.
    whole: Vec<Side>,
    /// Surfaces of its thematic surfaces.
    thematic: Vec<Side>,
    roof_edge: Vec<Side>,
}

/// Adds the features of a draft to the geometry read so far.
pub(super) fn add(reader: &mut Reader, levels: &mut Levels, draft: Draft) -> Result<()> {
    let Draft { mut store, features, .. } = draft;
    let ids: Vec<String> = features.iter().map(|feature| feature.id.clone()).collect();
    let name = |number: usize| ids.get(number).cloned().unwrap_or_default();
    count_instances(reader, &store, &features)?;
    let mut document = Document::default();
    let mut numbers = Numbers::default();
    for feature in features {
        let Feature { id, kind, line, parent, attributes, pieces, mut wrong, .. } = feature;
        let mut by_level: BTreeMap<_, Surfaces> = BTreeMap::new();
        for piece in pieces {
            match surfaces_of(&mut store, &piece) {
                Ok(sides) => by_level.entry(piece.lod).or_default().add(piece.part, sides),
                Err(what) => {
                    let what = format!("object `{}`: {what}", excerpt(id.as_bytes()));
                    wrong.get_or_insert(Error::input(reader.file, line, what, MEND));
                }
            }
        }
        if let Some(wrong) = wrong {
            reader.skipped.push(wrong);
            continue;
        }
        by_level.retain(|_, surfaces| !surfaces.is_empty());
        let offers: Vec<Offer> = by_level
            .into_iter()
            .map(|(lod, surfaces)| {
                let (sides, is_closed) = surfaces.joined(&mut store);
                Offer { lod, sides, is_closed }
            })
            .collect();
        let shapes = levels.choose(&id, &kind, &store, offers, reader);
        let geometry = shapes.into_iter().map(|offer| numbers.shape(&store, offer, &mut document.vertices)).collect();
        let object = CityObject {
            kind: text(kind),
            geometry: Some(geometry),
            parents: parent.map(|parent| vec![text(name(parent))]),
            children: None,
            attributes: flat(&attributes.into_values()),
        };
        document.objects.push((text(id), object));
    }
    for (reason, count) in &store.left_out {
        (0..*count).for_each(|_| reader.geometry.leave_out(reason));
    }
    // Frees the geometry of the object before the reader stores it again.
    drop(store);
    reader.add(&document)
}

/// Counts the corners of template instances, and refuses more than memory may hold before the first
/// instance is made.
fn count_instances(reader: &mut Reader, store: &Store, features: &[Feature]) -> Result<()> {
    for piece in features.iter().flat_map(|feature| &feature.pieces).filter(|piece| piece.instance.is_some()) {
        let sides = follow(store, piece.members.clone()).sides;
        let corners = sides.iter().map(|side| store.corners_of(side.polygon)).sum::<u64>();
        reader.budget.spend(corners, CORNER_BYTES, "instances of templates", reader.file)?;
        reader.instanced += corners;
    }
    if reader.instanced <= MAX_CORNERS {
        return Ok(());
    }
    Err(Error::Limit {
        what: format!("the number of corners of instances of templates in {}", reader.file.display()).into(),
        value: reader.instanced,
        max: MAX_CORNERS,
    })
}

/// Returns the polygons of a piece, or an error that says what is wrong with the piece.
fn surfaces_of(store: &mut Store, piece: &Piece) -> std::result::Result<Vec<Side>, String> {
    let found = follow(store, piece.members.clone());
    for _ in &found.missing {
        store.leave_out(NOWHERE);
    }
    (0..found.endless).for_each(|_| store.leave_out(ENDLESS));
    let sides = match piece.instance {
        None => found.sides,
        Some(instance) => placed(store, &found.sides, instance)?,
    };
    if let PiecePart::Surface(Some(name)) = piece.part {
        for side in &sides {
            if let Some(polygon) = store.polygons.get_mut(side.polygon as usize) {
                polygon.name.get_or_insert(name);
            }
        }
    }
    Ok(sides)
}

/// Returns the polygons of a template, placed by an instance.
fn placed(store: &mut Store, sides: &[Side], instance: Instance) -> std::result::Result<Vec<Side>, String> {
    let template = store.lift(sides);
    let place = |vertex| instance.matrix.transform_point3(vertex) + instance.at;
    if let Some(far) = template.vertices.iter().map(|vertex| place(*vertex)).find(|place| !is_position(*place)) {
        return Err(format!("its template would have a corner at {far}, beyond all positions on Earth"));
    }
    let members = store.put(&template, place);
    let is_mirrored = instance.matrix.determinant() < 0.0;
    let turned = |side: Side| Side { is_reversed: side.is_reversed != is_mirrored, ..side };
    Ok(follow(store, members).sides.into_iter().map(turned).collect())
}

impl Surfaces {
    fn add(&mut self, part: PiecePart, sides: Vec<Side>) {
        match part {
            PiecePart::Whole => self.whole.extend(sides),
            PiecePart::RoofEdge => self.roof_edge.extend(sides),
            PiecePart::Surface(_) => self.thematic.extend(sides),
        }
    }

    fn is_empty(&self) -> bool {
        self.whole.is_empty() && self.thematic.is_empty() && self.roof_edge.is_empty()
    }

    /// Returns every surface once, and `Some(true)` if a solid or all surfaces are known to be
    /// closed.
    fn joined(self, store: &mut Store) -> (Vec<Side>, Option<bool>) {
        let Surfaces { whole, thematic, roof_edge } = self;
        if whole.is_empty() && thematic.is_empty() {
            return (roof_edge, None);
        }
        let (whole, thematic) = (once(whole), once(thematic));
        if whole.is_empty() || thematic.is_empty() {
            return (if whole.is_empty() { thematic } else { whole }, None);
        }
        let of_whole: HashSet<u32> = whole.iter().map(|side| side.polygon).collect();
        let mut others: Vec<Side> = thematic.iter().filter(|side| !of_whole.contains(&side.polygon)).copied().collect();
        let before = others.len();
        let is_shared = before < thematic.len();
        name_twins(store, &whole, &mut others);
        if is_shared || others.len() < before {
            let is_closed = is_closed(store, &whole).then_some(true);
            return ([whole, others].concat(), is_closed);
        }
        // Neither refers to the other: they are the same volume drawn twice.
        store.leave_out(BESIDE);
        match is_closed(store, &thematic) {
            true => (thematic, Some(true)),
            false if is_closed(store, &whole) => (whole, Some(true)),
            false => (thematic, None),
        }
    }
}

fn once(mut sides: Vec<Side>) -> Vec<Side> {
    let mut seen = HashSet::new();
    sides.retain(|side| seen.insert(side.polygon));
    sides
}

/// Gives a polygon without a name the name of the thematic surface with the same corners, and
/// removes that surface.
fn name_twins(store: &mut Store, whole: &[Side], thematic: &mut Vec<Side>) {
    if thematic.is_empty() {
        return;
    }
    let nameless = |side: &&Side| store.polygon(side.polygon).is_some_and(|polygon| polygon.name.is_none());
    let twins: HashMap<Vec<u32>, u32> =
        whole.iter().filter(nameless).map(|side| (corners_of(store, *side), side.polygon)).collect();
    thematic.retain(|side| {
        let Some(twin) = twins.get(&corners_of(store, *side)) else { return true };
        let name = store.polygon(side.polygon).and_then(|polygon| polygon.name);
        if let Some(polygon) = store.polygons.get_mut(*twin as usize) {
            polygon.name = name;
        }
        false
    });
}

/// Returns the corners of a polygon's outline, sorted.
fn corners_of(store: &Store, side: Side) -> Vec<u32> {
    let outline = store.polygon(side.polygon).and_then(|polygon| store.rings(polygon).next());
    let mut corners = outline.unwrap_or_default().to_vec();
    corners.sort_unstable();
    corners
}

/// Vertices of a document by the vertices of a store; `u32::MAX` for a vertex that is not in the
/// document.
#[derive(Default)]
struct Numbers(Vec<u32>);

impl Numbers {
    /// Returns a geometry of the document, and adds the vertices that the document does not have
    /// yet.
    fn shape(&mut self, store: &Store, offer: Offer, vertices: &mut Vec<[f64; 3]>) -> Shape<'static> {
        self.0.resize(store.vertices.len(), u32::MAX);
        let (mut boundaries, mut values, mut lines) = (Nested::default(), Nested::default(), Vec::new());
        boundaries.open();
        values.open();
        for side in offer.sides {
            let Some(polygon) = store.polygon(side.polygon) else { continue };
            boundaries.open();
            for ring in store.rings(polygon) {
                boundaries.open();
                let mut push = |corner: &u32| boundaries.push(Some(self.number(store, *corner, vertices)));
                if side.is_reversed {
                    ring.iter().rev().for_each(&mut push)
                } else {
                    ring.iter().for_each(&mut push)
                }
                boundaries.close();
            }
            boundaries.close();
            values.push(polygon.name.map(u32::from));
            lines.push(polygon.line);
        }
        boundaries.close();
        values.close();
        // Lines name surfaces only where each surface has its own; a text without line breaks has
        // only one line.
        if !lines.is_sorted_by(|a, b| a < b) && lines.iter().collect::<HashSet<_>>().len() < lines.len() {
            lines.clear();
        }
        let surfaces = store.names.iter().map(|name| SurfaceKind { kind: text(name.clone()) }).collect();
        Shape {
            kind: Text("MultiSurface".into()),
            lod: offer.lod,
            boundaries: Some(boundaries),
            semantics: Some(Semantics { surfaces: Some(surfaces), values: Some(values) }),
            template: None,
            matrix: None,
            lines,
        }
    }

    fn number(&mut self, store: &Store, corner: u32, vertices: &mut Vec<[f64; 3]>) -> u32 {
        let Some(slot) = self.0.get_mut(corner as usize) else { return 0 };
        if *slot == u32::MAX {
            *slot = vertices.len() as u32;
            vertices.push(store.position(corner).to_array());
        }
        *slot
    }
}

fn text(text: String) -> Text<'static> {
    Text(text.into())
}
