//! Outlines of areas from features. In: features one by one, then the coordinate system. Out: areas
//! with names, in metres of the scene's system.

use std::collections::HashSet;
use std::path::Path;

use glam::DVec2;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::{Message, counted, message};
use heliotile_place::reference::Reference;
use serde_json::{Map, Value};

use super::feature::Feature;
use super::system::{FeatureSystem, Placing};
use crate::coordinate::MAX_COORDINATE_M;
use crate::footprint::PlanRing;
use crate::footprints::region::oriented;

/// Attributes that name an area, in lower case; the first one that a feature has counts.
const NAMES: [&str; 2] = ["area", "name"];

/// An area in plan.
#[derive(Clone, Debug)]
pub(crate) struct Outline {
    /// Name of the area; unique in its file.
    pub name: String,
    /// Outlines and holes, metres.
    pub rings: Vec<PlanRing>,
}

/// Areas of the features that were read so far.
pub(super) struct OutlineCollector<'a> {
    file: &'a Path,
    areas: Vec<Outline>,
    names: HashSet<String>,
    features: usize,
    /// Number of features that are no areas.
    others: u64,
}

impl<'a> OutlineCollector<'a> {
    pub(super) fn new(file: &'a Path) -> Self {
        OutlineCollector { file, areas: Vec::new(), names: HashSet::new(), features: 0, others: 0 }
    }

    /// Adds a feature, in the coordinates of the file.
    pub(super) fn add(&mut self, feature: Feature) -> Result<()> {
        self.features += 1;
        if let Some(what) = feature.unreadable {
            let what = format!("feature {}: {what}", self.features);
            return Err(Error::input(self.file, None, what, "export the areas as polygons with straight sides"));
        }
        let mut rings = Vec::new();
        for polygon in &feature.polygons {
            let plan = |ring: &Vec<glam::DVec3>| ring.iter().map(|corner| corner.truncate()).collect();
            rings.extend(oriented(polygon.iter().map(plan).collect()).into_iter().flatten());
        }
        let is_wrong = |corner: &&DVec2| !corner.is_finite() || corner.abs().max_element() > MAX_COORDINATE_M;
        if let Some(bad) = rings.iter().flatten().find(is_wrong) {
            let what = format!("feature {} has a corner at {bad}, not degrees or metres", self.features);
            return Err(Error::input(self.file, None, what, "give corners of at most 1e9"));
        }
        if rings.is_empty() {
            self.others += 1;
            return Ok(());
        }
        let wanted = name_of(&feature.attributes).or(feature.id).unwrap_or_else(|| format!("area {}", self.features));
        let again = (2..).map(|count| format!("{wanted}-{count}"));
        let name = std::iter::once(wanted.clone()).chain(again).find(|name| !self.names.contains(name));
        let name = name.unwrap_or(wanted);
        self.names.insert(name.clone());
        self.areas.push(Outline { name, rings });
        Ok(())
    }

    /// Returns the areas in metres of the system `scene`, and sentences for the user.
    pub(super) fn finish(self, system: FeatureSystem, scene: Option<u32>) -> Result<(Vec<Outline>, Vec<Message>)> {
        let OutlineCollector { file, mut areas, others, .. } = self;
        if areas.is_empty() {
            return Err(Error::input(file, None, "the file holds no areas", "give polygons"));
        }
        let corners = areas.iter().flat_map(|area| &area.rings).flatten();
        let bounds = corners.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], p| [low.min(*p), high.max(*p)]);
        let placing = Placing::new(file, &system, bounds, scene)?;
        let refuse =
            |what: String, hint: &'static str| Err(Error::input(file, None, what, hint).because(Problem::Misplaced));
        match (placing.reference, scene) {
            (Some(found), Some(scene)) if found != Reference::Epsg(scene) => {
                let what = format!("its coordinates are {found}, those of the scene EPSG:{scene}");
                return refuse(what, "reproject the areas to the system of the scene, or to longitude and latitude");
            }
            (Some(found), None) if system.plane_unit_m().is_none() => {
                let what = format!("its longitudes and latitudes become {found}, but the scene states no system");
                return refuse(what, "state the system of the scene as {crs}, or give areas in its coordinates");
            }
            _ => {}
        }
        for corner in areas.iter_mut().flat_map(|area| &mut area.rings).flatten() {
            *corner = placing.place(file, *corner)?;
        }
        let mut said = system.doubts;
        said.extend(placing.doubt.map(Message::from));
        if others > 0 {
            said.push(message!("{}: {} left out: no polygons", file.display(), counted(others, "feature")));
        }
        Ok((areas, said))
    }
}

/// Returns the name that the attributes of a feature state.
fn name_of(attributes: &Map<String, Value>) -> Option<String> {
    let value = |name: &str| attributes.iter().find(|(key, _)| key.eq_ignore_ascii_case(name)).map(|(_, value)| value);
    let text = |value: &Value| match value {
        Value::String(text) => Some(text.trim().to_owned()).filter(|text| !text.is_empty()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    };
    NAMES.iter().filter_map(|name| value(name)).find_map(text)
}
