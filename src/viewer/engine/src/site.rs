//! Facts about an archive for the page when it opens it. In: its manifest and tables. Out: a
//! [`Site`].

use std::collections::BTreeSet;

use heliotile_core::archive::accuracy::Accuracy;
use heliotile_core::archive::format;
use heliotile_core::archive::format::TileNumber;
use heliotile_core::replay::components::Component;
use heliotile_core::site::material::{Class, Material};
use heliotile_core::site::place::Place;
use heliotile_core::sky::model::SkyModel;
use serde::{Deserialize, Serialize};

use crate::open::Opened;

/// Place of the archive.
#[derive(Debug, Deserialize, Serialize)]
pub struct SitePlace {
    latitude: f64,
    longitude: f64,
    /// Angle of the y axis from true north, degrees clockwise.
    convergence: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    crs: Option<String>,
}

/// Prefix of the number of a coordinate reference system.
const EPSG: &str = "EPSG:";

impl From<&Place> for SitePlace {
    fn from(place: &Place) -> Self {
        SitePlace {
            latitude: place.latitude_deg,
            longitude: place.longitude_deg,
            convergence: place.convergence_deg,
            crs: place.epsg.map(|epsg| format!("{EPSG}{epsg}")),
        }
    }
}

impl From<&SitePlace> for Place {
    fn from(place: &SitePlace) -> Self {
        Place {
            latitude_deg: place.latitude,
            longitude_deg: place.longitude,
            convergence_deg: place.convergence,
            epsg: place.crs.as_deref().and_then(|crs| crs.strip_prefix(EPSG)?.parse().ok()),
        }
    }
}

/// Archive that another one is shown with.
#[derive(Debug, Deserialize)]
pub struct Beside {
    place: Option<SitePlace>,
}

impl Beside {
    /// Returns true if an archive at `place` may be of the same site.
    pub fn is_of(&self, place: Option<&Place>) -> bool {
        Place::is_one_site(self.place.as_ref().map(Place::from).as_ref(), place)
    }
}

/// Material of the scene.
#[derive(Debug, Serialize)]
pub struct SiteMaterial {
    name: String,
    group: String,
    class: &'static str,
    reflectance: f64,
    changeable: bool,
    canopy: bool,
    transmittance: Option<f64>,
    mirror: bool,
}

/// Name that changes take, and the mean value of the materials that it stands for.
#[derive(Debug, Serialize)]
pub struct SiteGroup {
    name: String,
    kind: &'static str,
    value: f64,
    materials: usize,
}

/// Facts about an archive.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Site {
    name: String,
    root: String,
    format_version: String,
    creator: String,
    bytes: u64,
    receivers: u64,
    tiles: u32,
    tile_size: u32,
    origin: [f64; 3],
    bounds: [[f64; 3]; 2],
    place: Option<SitePlace>,
    north_deg: f64,
    materials: Vec<SiteMaterial>,
    groups: Vec<SiteGroup>,
    components: Vec<&'static str>,
    patches: usize,
    accuracy: Option<String>,
    scene_chunks: usize,
    has_reference: bool,
    skies: Vec<String>,
    /// Skies that no clouds can stand before.
    cloudless_skies: Vec<String>,
}

impl Site {
    /// Collects the facts of an archive of `bytes` bytes.
    pub fn new(opened: &Opened, bytes: u64) -> Self {
        let (archive, manifest) = (opened.archive, opened.archive.manifest());
        let slot = &archive.header().slot;
        let (materials, diffuse) = (opened.site.materials(), opened.site.settings().diffuse);
        let material = |material: &Material| SiteMaterial {
            name: material.name.clone(),
            group: material.group.clone().unwrap_or_default(),
            class: material.class.name(),
            reflectance: material.diffuse,
            changeable: material.transmittance.is_some() || diffuse,
            canopy: material.transmittance.is_some(),
            transmittance: material.transmittance,
            mirror: material.mirrors(),
        };
        Site {
            name: archive.path().display().to_string(),
            root: format::hex(&archive.root()),
            format_version: format!("{}.{}", slot.major, slot.minor),
            creator: format!("{} {}", manifest.creator.name, manifest.creator.version),
            bytes,
            receivers: manifest.receivers.count,
            tiles: manifest.receivers.tiles,
            tile_size: manifest.receivers.tile_size,
            origin: manifest.scene.origin_m,
            bounds: manifest.scene.bounds_m,
            place: manifest.place.as_ref().map(SitePlace::from),
            // `north_deg` is the angle from y to true north, the reverse of the angle from true
            // north to y.
            north_deg: -opened.site.north().y_deg(),
            materials: materials.iter().map(material).collect(),
            groups: groups(materials, diffuse),
            components: Component::ALL.map(Component::name).to_vec(),
            patches: manifest.settings.patches(),
            accuracy: manifest.accuracy.as_ref().map(stated),
            scene_chunks: archive.entries_of(format::SCENE).len(),
            has_reference: archive.has(format::OVERVIEW, TileNumber::FIRST) && manifest.place.is_some(),
            skies: SkyModel::all().map(|sky| sky.to_string()).collect(),
            cloudless_skies: SkyModel::all().filter(|sky| sky.brightens()).map(|sky| sky.to_string()).collect(),
        }
    }
}

/// Largest number of materials that are listed one by one; if there are more, their classes are
/// listed.
const MAX_MATERIALS: usize = 8;

/// Returns the names that changes take: groups, and the materials without a group, or their classes
/// if these materials are many. Names with a reflectance come first, then canopies.
fn groups(materials: &[Material], diffuse: bool) -> Vec<SiteGroup> {
    let named: BTreeSet<&str> = materials.iter().filter_map(|material| material.group.as_deref()).collect();
    let alone: Vec<&Material> = materials.iter().filter(|material| material.group.is_none()).collect();
    let taken = |name: &str| named.contains(name) || materials.iter().any(|material| material.name == name);
    let by_group = named.iter().map(|&name| {
        let members: Vec<&Material> = materials.iter().filter(|m| m.group.as_deref() == Some(name)).collect();
        (name, members)
    });
    let rest: Vec<(&str, Vec<&Material>)> = if alone.len() <= MAX_MATERIALS {
        let of_its_own = alone.iter().filter(|material| !named.contains(material.name.as_str()));
        of_its_own.map(|material| (material.name.as_str(), vec![*material])).collect()
    } else {
        let by_class = Class::ALL.into_iter().filter(|class| !taken(class.name()));
        by_class.map(|class| (class.name(), materials.iter().filter(|m| m.class == class).collect())).collect()
    };
    let all: Vec<(&str, Vec<&Material>)> = by_group.chain(rest).collect();
    let of = |kind: &'static str, value: fn(&Material) -> Option<f64>| {
        let group = move |(name, members): &(&str, Vec<&Material>)| {
            let values: Vec<f64> = members.iter().filter_map(|material| value(material)).collect();
            let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
            let of_name = SiteGroup { name: name.to_string(), kind, value: mean, materials: values.len() };
            (!values.is_empty()).then_some(of_name)
        };
        all.iter().filter_map(group).collect::<Vec<_>>()
    };
    let mut found = match diffuse {
        true => of("opaque", |material| material.transmittance.is_none().then_some(material.diffuse)),
        false => Vec::new(),
    };
    found.extend(of("canopy", |material| material.transmittance));
    found
}

/// Returns the stated error in the words of `info`.
fn stated(accuracy: &Accuracy) -> String {
    format!(
        "{} % of the mean total ({} W/m2), RMSE of hourly totals; bias {} %, means over all hours {} %; {} receivers, {} conditions ({})",
        accuracy.rmse_percent,
        accuracy.mean_w_m2,
        accuracy.bias_percent,
        accuracy.yearly_percent,
        accuracy.sample,
        accuracy.conditions,
        accuracy.weather
    )
}
