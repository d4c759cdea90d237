//! Footprints and faces from features. In: features one by one, then the coordinate system. Out:
//! the geometry of the file in metres.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use glam::{DVec2, DVec3};
use heliotile_core::error::{Error, Result};
use heliotile_core::site::scene_object::ObjectNote;
use heliotile_core::text::{Message, counted, message, with_list};
use serde_json::{Map, Value};

use super::feature::{Feature, FeaturePolygon};
use super::hstore;
use super::system::{FeatureSystem, Placing};
use crate::attributes::{flat, text_of};
use crate::coordinate::MAX_COORDINATE_M;
use crate::footprint::{Footprint, StatedHeights};
use crate::footprints::region::{is_crossed, oriented, repaired, united};
use crate::footprints::stated::{Heights, NO_HEIGHT, Stated};
use crate::formats::ReadOptions;
use crate::geometry::Geometry;
use crate::tree_point::TreePoint;
use crate::trees::{self, stated_tree};
use heliotile_core::site::semantics::FaceNote;

/// Difference of corner heights above which a polygon is not level, metres.
const LEVEL_M: f64 = 0.01;
/// Fewest faces of a body: a tetrahedron has four.
const MIN_FACES: usize = 4;

/// Share of a face's area in plan below which it is upright.
const UPRIGHT: f64 = 0.02;
/// Reason for leaving out features of OpenStreetMap that are no buildings.
const NO_KEY: &str = "as no buildings: others have a key `building`, they have none";

/// Material of faces until their tilt decides what they are.
const FACE: &str = "WallSurface";

/// Geometry from the features that were read so far.
pub(in crate::formats) struct Collector<'a> {
    file: &'a Path,
    asked: &'a ReadOptions,
    geometry: Geometry,
    names: HashSet<String>,
    /// Number of features that wanted a name that was taken.
    repeated: HashMap<String, usize>,
    features: usize,
    /// Names of the footprints that were repaired.
    mended: Vec<String>,
    has_heights: bool,
    /// Heights and true for a key `building`, for each footprint.
    stated: Vec<(Heights, bool)>,
    /// True if a feature has a key `building`.
    has_building_key: bool,
    /// Number of features without a height that have no key `building`.
    without_key: usize,
    /// Number of features that cannot be read, and what is wrong with the first.
    unreadable: usize,
    first_unreadable: Option<String>,
    /// Names of the footprints whose polygons overlapped.
    united: Vec<String>,
    /// Number of trees whose crowns have an assumed width.
    assumed_widths: usize,
    /// Sentences on the file, from its reader.
    doubts: Vec<Message>,
}

/// Reason for leaving out points and lines that are no trees.
const NO_FACE: &str = "as points or lines, which shade nothing";

impl<'a> Collector<'a> {
    pub(in crate::formats) fn new(file: &'a Path, asked: &'a ReadOptions) -> Self {
        Collector {
            file,
            asked,
            geometry: Geometry::default(),
            names: HashSet::new(),
            repeated: HashMap::new(),
            features: 0,
            mended: Vec::new(),
            has_heights: false,
            stated: Vec::new(),
            has_building_key: false,
            without_key: 0,
            unreadable: 0,
            first_unreadable: None,
            united: Vec::new(),
            assumed_widths: 0,
            doubts: Vec::new(),
        }
    }

    /// Adds a feature, in the coordinates of the file.
    pub(in crate::formats) fn add(&mut self, mut feature: Feature) -> Result<()> {
        self.features += 1;
        hstore::unfold(&mut feature.attributes);
        if let Some(what) = feature.unreadable.take() {
            self.leave_unread(format!("feature {}: {what}", self.features));
            return Ok(());
        }
        if feature.polygons.is_empty() && feature.points.is_empty() {
            let reason = if feature.has_others { NO_FACE } else { "without a geometry" };
            self.geometry.leave_out(reason);
            return Ok(());
        }
        let corners = || feature.polygons.iter().flatten().flatten().chain(&feature.points);
        if let Some(bad) = corners().find(|p| !p.is_finite() || p.abs().max_element() > MAX_COORDINATE_M) {
            let what = format!("feature {} has a corner at {bad}, not degrees or metres of at most 1e9", self.features);
            self.leave_unread(what);
            return Ok(());
        }
        let attributes = flat(&feature.attributes);
        if feature.polygons.is_empty() {
            self.trees(feature, attributes);
            return Ok(());
        }
        let stated = Stated::new(&attributes, &self.asked.footprints);
        if let Some(reason) = stated.is_other() {
            self.geometry.leave_out(reason);
            return Ok(());
        }
        let has_key = stated.has_building_key();
        self.has_building_key |= has_key;
        let id = feature.id.take().filter(|id| !id.trim().is_empty()).or_else(|| stated.id());
        let name = self.name(id);
        if feature.is_body || are_faces(&feature.polygons) {
            let object = self.geometry.objects.id(&name);
            let note = ObjectNote {
                building: stated.whole().unwrap_or(name),
                object_type: "Building".to_owned(),
                attributes: text_of(attributes),
                ..ObjectNote::default()
            };
            self.geometry.object_notes.insert(object, note);
            return feature.polygons.iter().try_for_each(|polygon| self.face(object, polygon));
        }
        self.has_heights |= corners().any(|corner| corner.z != 0.0);
        let heights = match stated.heights() {
            Ok(heights) => heights,
            Err(NO_HEIGHT) if !has_key => {
                self.without_key += 1;
                return Ok(());
            }
            Err(reason) => {
                self.geometry.leave_out(reason);
                return Ok(());
            }
        };
        let mut polygons = Vec::new();
        for polygon in &feature.polygons {
            let plan = |ring: &Vec<DVec3>| ring.iter().map(|corner| corner.truncate()).collect();
            match oriented(polygon.iter().map(plan).collect()) {
                Some(whole) => polygons.push(whole),
                None => self.geometry.leave_out("as outlines with fewer than three corners"),
            }
        }
        if polygons.is_empty() {
            return Ok(());
        }
        self.stated.push((heights, has_key));
        self.geometry.footprints.push(Footprint {
            building: stated.whole().unwrap_or_default(),
            is_part: stated.is_part(),
            name,
            number: self.features,
            polygons,
            // Their unit is known at the end of the file.
            heights: StatedHeights { roof_m: 0.0, is_roof_absolute: false, foot_m: 0.0, base_m: None, has_walls: true },
            attributes: text_of(attributes),
        });
        Ok(())
    }

    /// Adds the trees that the points of a feature stand for.
    fn trees(&mut self, mut feature: Feature, attributes: Map<String, Value>) {
        let tree = match stated_tree(&attributes) {
            None => return self.geometry.leave_out(NO_FACE),
            Some(Err(reason)) => return self.geometry.leave_out(reason),
            Some(Ok(tree)) => tree,
        };
        self.assumed_widths += usize::from(tree.width_is_assumed);
        let id = feature.id.take().filter(|id| !id.trim().is_empty());
        let id = id.or_else(|| Stated::new(&attributes, &self.asked.footprints).id()).map(|id| format!("tree {id}"));
        let text = text_of(attributes);
        for at in feature.points {
            let name = self.name(id.clone());
            self.geometry.trees.push(TreePoint {
                name,
                number: self.features,
                at: at.truncate(),
                crown: tree.crown,
                leaves: tree.leaves,
                attributes: text.clone(),
            });
        }
    }

    /// Leaves out a feature that cannot be read; the others are read.
    fn leave_unread(&mut self, what: String) {
        self.unreadable += 1;
        self.first_unreadable.get_or_insert(what);
    }

    /// Returns a name that no other feature of the file has.
    fn name(&mut self, id: Option<String>) -> String {
        let wanted = id.unwrap_or_else(|| format!("feature {}", self.features));
        let mut name = wanted.clone();
        while !self.names.insert(name.clone()) {
            let count = self.repeated.entry(wanted.clone()).or_insert(1);
            *count += 1;
            name = format!("{wanted}-{count}");
        }
        name
    }

    /// Adds a face of a body; its tilt decides later what it is.
    fn face(&mut self, object: u32, polygon: &FeaturePolygon) -> Result<()> {
        let is_face = |ring: &&Vec<DVec3>| opened(ring).len() > 2;
        if !polygon.first().as_ref().is_some_and(is_face) {
            self.geometry.leave_out("with fewer than three corners");
            return Ok(());
        }
        for (number, ring) in polygon.iter().filter(is_face).enumerate() {
            if number > 0 {
                self.geometry.begin_hole();
            }
            for corner in opened(ring) {
                let corner = self.geometry.push_vertex(self.file, *corner)?;
                self.geometry.push_corner(corner);
            }
        }
        let material = self.geometry.materials.id(FACE);
        self.geometry.by_tilt.push(self.geometry.face_count());
        self.geometry.end_face(material, object, 0);
        self.geometry.note_face(FaceNote::default());
        Ok(())
    }

    /// Returns the geometry in metres.
    pub(in crate::formats) fn finish(mut self, system: FeatureSystem) -> Result<Geometry> {
        self.doubts.extend(system.doubts.iter().cloned());
        self.settle_heights(&system);
        self.refuse_nothing()?;
        // The extent of all coordinates helps to tell degrees from metres.
        let outlines = self.geometry.footprints.iter().flat_map(Footprint::rings).flatten().copied();
        let all = outlines.chain(self.geometry.vertices.iter().map(|vertex| vertex.truncate()));
        let all = all.chain(self.geometry.trees.iter().map(|tree| tree.at));
        let bounds = all.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)]);
        let placing = Placing::new(self.file, &system, bounds, self.asked.system)?;
        let place = |at: DVec2| placing.place(self.file, at);
        for vertex in &mut self.geometry.vertices {
            *vertex = place(vertex.truncate())?.extend(vertex.z) + 0.0;
        }
        for footprint in &mut self.geometry.footprints {
            for corner in footprint.polygons.iter_mut().flatten().flatten() {
                *corner = place(*corner)?;
            }
        }
        for tree in &mut self.geometry.trees {
            tree.at = place(tree.at)?;
        }
        self.geometry.reference = placing.reference;
        self.geometry.in_metres = placing.in_metres;
        self.geometry.notes.extend(placing.note);
        self.geometry.doubts.extend(placing.doubt.into_iter().map(Message::from));
        self.mend();
        self.say();
        Ok(self.geometry)
    }

    /// Sets the heights of footprints in metres, and leaves out what is no building.
    fn settle_heights(&mut self, system: &FeatureSystem) {
        let stated = std::mem::take(&mut self.stated);
        let left = if self.has_building_key { NO_KEY } else { NO_HEIGHT };
        (0..self.without_key).for_each(|_| self.geometry.leave_out(left));
        let unit_m = system.plane_unit_m().unwrap_or(1.0);
        let mut in_feet = 0;
        let mut kept = Vec::new();
        for (mut footprint, (heights, has_key)) in std::mem::take(&mut self.geometry.footprints).into_iter().zip(stated)
        {
            if self.has_building_key && !has_key {
                self.geometry.leave_out(NO_KEY);
                continue;
            }
            match heights.in_metres(unit_m) {
                Ok(heights) => footprint.heights = heights,
                Err(reason) => {
                    self.geometry.leave_out(reason);
                    continue;
                }
            }
            in_feet += usize::from(heights.lacks_unit() && unit_m != 1.0);
            kept.push(footprint);
        }
        self.geometry.footprints = kept;
        if in_feet > 0 {
            self.doubts.push(message!(
                "heights of {in_feet} features have no unit: they are read in the unit of the coordinates, {unit_m:.4} m; \
                 for metres, name the column with its unit: {{height}} height[m]"
            ));
        }
    }

    /// Repairs outlines that cross themselves, and unites polygons of one feature that overlap.
    fn mend(&mut self) {
        for footprint in &mut self.geometry.footprints {
            if footprint.polygons.iter().any(|polygon| is_crossed(polygon)) {
                footprint.polygons = footprint.polygons.iter().flat_map(|polygon| repaired(polygon)).collect();
                self.mended.push(footprint.name.clone());
            }
            if let Some(whole) = united(&footprint.polygons) {
                footprint.polygons = whole;
                self.united.push(footprint.name.clone());
            }
        }
        let before = self.geometry.footprints.len();
        self.geometry.footprints.retain(|footprint| !footprint.polygons.is_empty());
        (self.geometry.footprints.len()..before).for_each(|_| self.geometry.leave_out("as outlines without an area"));
    }

    fn say(&mut self) {
        let file = self.file.display();
        if !self.mended.is_empty() {
            let sentence = format!(
                "{} outlines cross themselves and were repaired: areas within an odd number of their loops belong to the building",
                self.mended.len()
            );
            self.geometry.doubts.push(with_list(&sentence, self.mended.drain(..)));
        }
        if !self.united.is_empty() {
            let sentence =
                format!("{} features have polygons that overlap: the shared area counts once", self.united.len());
            self.geometry.doubts.push(with_list(&sentence, self.united.drain(..)));
        }
        if let Some(first) = &self.first_unreadable {
            self.geometry
                .doubts
                .push(format!("{} features cannot be read and are left out: {first}", self.unreadable).into());
        }
        self.geometry.doubts.append(&mut self.doubts);
        if self.assumed_widths > 0 {
            self.geometry.doubts.push(message!(
                "no width of the crown is stated for {}: half of the height is assumed",
                counted(self.assumed_widths as u64, "tree")
            ));
        }
        if let Some(count) = self.geometry.left_out.remove(NO_HEIGHT) {
            self.geometry.doubts.push(message!(
                "{count} of {} features state neither a height nor storeys and are left out: {{height}} height,9m gives them 9 m",
                self.features
            ));
        }
        if self.has_heights && !self.geometry.footprints.is_empty() {
            self.geometry.notes.push(message!(
                "{file}: heights of the corners of outlines are not read; {{base}} sets the height at which buildings begin"
            ));
        }
    }

    /// Refuses a file of which nothing is left.
    fn refuse_nothing(&mut self) -> Result<()> {
        let has_none = self.geometry.footprints.is_empty() && self.geometry.trees.is_empty();
        if !has_none || self.geometry.face_count() > 0 {
            return Ok(());
        }
        let refuse = |what: Message, hint: &'static str| Err(Error::input(self.file, None, what, hint));
        if self.features == 0 {
            return refuse("the file holds no features".into(), "export outlines of buildings with their heights");
        }
        if let Some(first) = self.first_unreadable.take().filter(|_| self.unreadable == self.features) {
            return refuse(
                first.into(),
                "export the features again, as polygons with straight sides: `ogr2ogr -nlt CONVERT_TO_LINEAR out.gpkg FILE`",
            );
        }
        let mut reasons: Vec<Message> =
            self.geometry.left_out.iter().map(|(reason, count)| format!("{count} {reason}").into()).collect();
        if self.unreadable > 0 {
            reasons.push(format!("{} that cannot be read", self.unreadable).into());
        }
        reasons.append(&mut self.doubts);
        let what = message!("none of its {} features became a building or a tree; left out: ", self.features)
            .and(Message::joined(reasons, ", "));
        match &self.geometry.left_out {
            left if left.contains_key(NO_HEIGHT) => refuse(
                what,
                "name the column of heights in {height} (as in {height} HGT), or give one for all: {height} 9m",
            ),
            left if left.contains_key(trees::NO_HEIGHT) => {
                refuse(what, "state heights of trees in a column `height`; points that get light are {receivers}")
            }
            _ => refuse(what, "export outlines of buildings as polygons, with a column of heights"),
        }
    }
}

/// Returns a ring without the corner that closes it.
fn opened(ring: &[DVec3]) -> &[DVec3] {
    match ring {
        [first, .., last] if first == last => ring.get(..ring.len() - 1).unwrap_or_default(),
        _ => ring,
    }
}

/// Returns true if polygons are the faces of a body: one is upright, or at least four, of which one
/// is not level, meet along their sides. Outlines with the heights of the ground at their corners
/// are no body.
fn are_faces(polygons: &[FeaturePolygon]) -> bool {
    let rises = |polygon: &FeaturePolygon| {
        let heights = polygon.iter().flatten().map(|corner| corner.z);
        let [low, high] = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)]);
        high - low > LEVEL_M
    };
    if polygons.len() < MIN_FACES || !polygons.iter().any(rises) {
        return false;
    }
    let is_upright = |polygon: &FeaturePolygon| {
        let normal = polygon.first().map_or(DVec3::ZERO, |ring| normal(ring));
        normal.z.abs() < UPRIGHT * normal.length()
    };
    polygons.iter().any(is_upright) || shared_sides(polygons) + 1 >= polygons.len()
}

/// Returns the normal of a ring, with its area twice as length (Newell).
fn normal(ring: &[DVec3]) -> DVec3 {
    let from = ring.first().copied().unwrap_or_default();
    ring.array_windows::<2>().map(|[a, b]| (*a - from).cross(*b - from)).sum()
}

/// Returns the number of sides that two faces share, by the positions of both ends.
fn shared_sides(polygons: &[FeaturePolygon]) -> usize {
    let key = |corner: &DVec3| corner.to_array().map(f64::to_bits);
    let mut seen: HashSet<[[u64; 3]; 2]> = HashSet::new();
    let sides = polygons.iter().flatten().flat_map(|ring| ring.array_windows::<2>());
    sides
        .filter(|[a, b]| a != b)
        .filter(|[a, b]| {
            let mut side = [key(a), key(b)];
            side.sort_unstable();
            !seen.insert(side)
        })
        .count()
}
