//! Static catalogue of an atlas in STAC 1.1 (SpatioTemporal Asset Catalog), with its extensions
//! `projection` and `file`. In: archives of parts, and the paths of their files. Out: an item for
//! each and a collection of all, with relative links: the folder may be copied anywhere.

use std::time::{SystemTime, UNIX_EPOCH};

use jiff::Timestamp;
use serde_json::{Map, Value, json};

use super::shapes::MapCrs;
use glam::{DVec2, DVec3};

const VERSION: &str = "1.1.0";
const OF_FILES: &str = "https://stac-extensions.github.io/file/v2.1.0/schema.json";
const OF_PROJECTIONS: &str = "https://stac-extensions.github.io/projection/v2.0.0/schema.json";

/// Media type of an archive.
const ARCHIVE: &str = "application/vnd.heliotile";

/// File name of the collection.
pub const COLLECTION: &str = "collection.json";

/// File name of the pictures of items and of the collection.
pub const THUMBNAIL: &str = "thumbnail.png";

/// File name of the page beside the collection.
pub const VIEWER: &str = "view.html";

/// Points along each side of a footprint: straight lines of a projected system are curved in
/// longitude and latitude.
const STEPS: usize = 4;

/// STAC item: the archive of a part.
pub struct StacItem {
    /// Name of the part; `collection` is the name of its collection.
    pub id: String,
    pub collection: String,
    /// Lowest corner of the built area, scene coordinates, metres; `high` is the highest.
    pub low: DVec2,
    pub high: DVec2,
    pub written: SystemTime,
    /// Further properties, by keys with their prefix.
    pub properties: Map<String, Value>,
    /// Files beside the item.
    pub assets: Vec<StacAsset>,
}

/// STAC collection without its items.
pub struct StacCollection<'a> {
    pub id: &'a str,
    pub title: &'a str,
    /// SPDX name of the licence.
    pub license: &'a str,
    /// Files beside the collection.
    pub assets: Vec<StacAsset>,
}

/// File of an item or of a collection.
pub struct StacAsset {
    pub key: &'static str,
    pub href: String,
    pub media_type: &'static str,
    pub role: &'static str,
    pub title: String,
    pub bytes: u64,
    /// BLAKE3 of the whole file.
    pub checksum: blake3::Hash,
}

impl StacAsset {
    /// Returns the asset of the archive itself.
    pub fn archive(name: &str, bytes: u64, checksum: blake3::Hash) -> Self {
        StacAsset {
            key: "archive",
            href: format!("./{name}"),
            media_type: ARCHIVE,
            role: "data",
            title: "Archive of heliotile: light of all receivers under any sun and sky".into(),
            bytes,
            checksum,
        }
    }

    /// Returns the asset of the thumbnail, a picture of a clear year; its brightest colour stands
    /// for `top_kwh_m2`.
    pub fn thumbnail(png: &[u8], top_kwh_m2: f64) -> Self {
        StacAsset {
            key: "thumbnail",
            href: format!("./{THUMBNAIL}"),
            media_type: "image/png",
            role: "thumbnail",
            title: format!("Sun of a clear year, 0 to {top_kwh_m2} kWh/m2, from above"),
            bytes: png.len() as u64,
            checksum: blake3::hash(png),
        }
    }

    fn json(&self) -> Value {
        json!({
            "href": self.href,
            "type": self.media_type,
            "title": self.title,
            "roles": [self.role],
            "file:size": self.bytes,
            // Multihash: `1e` is BLAKE3, `20` is 32 bytes.
            "file:checksum": format!("1e20{}", self.checksum.to_hex()),
        })
    }
}

impl StacItem {
    /// Returns the item as JSON. It lies two folders below its collection and the page that shows
    /// it.
    pub fn json(&self, crs: &MapCrs) -> Value {
        let footprint = footprint(self.low, self.high, crs);
        let mut properties = self.properties.clone();
        properties.insert("datetime".into(), time(self.written).into());
        let mut extensions = vec![OF_FILES];
        if let Some(epsg) = crs.epsg() {
            extensions.push(OF_PROJECTIONS);
            properties.insert("proj:code".into(), format!("EPSG:{epsg}").into());
            let [low, high] = [self.low, self.high].map(|corner| crs.coordinates(corner.extend(0.0)));
            properties.insert("proj:bbox".into(), json!([low[0], low[1], high[0], high[1]]));
        }
        let up = format!("../../{COLLECTION}");
        let link = |rel: &str| json!({ "rel": rel, "href": up, "type": "application/json" });
        let mut links = ["root", "parent", "collection"].map(link).to_vec();
        links.push(page_link(&format!("../../{VIEWER}#part={}", self.id)));
        let mut item = json!({
            "type": "Feature",
            "stac_version": VERSION,
            "stac_extensions": extensions,
            "id": self.id,
            "collection": self.collection,
            "geometry": footprint.as_ref().map(|ring| json!({ "type": "Polygon", "coordinates": [ring] })),
            "properties": properties,
            "links": links,
            "assets": assets(&self.assets),
        });
        if let (Some(ring), Some(item)) = (footprint, item.as_object_mut()) {
            item.insert("bbox".into(), json!(around(&ring)));
        }
        item
    }
}

/// Returns the collection of all items; each item comes with the path of its file.
pub fn collection(about: &StacCollection, items: &[(StacItem, String)], crs: &MapCrs) -> Value {
    let rings = items.iter().filter_map(|(item, _)| footprint(item.low, item.high, crs));
    let all: Vec<[f64; 2]> = rings.flatten().collect();
    let bbox = if all.is_empty() { [-180.0, -90.0, 180.0, 90.0] } else { around(&all) };
    let written = || items.iter().map(|(item, _)| item.written);
    let interval = [written().min(), written().max()].map(|at| at.map(time));
    let mut links = vec![json!({ "rel": "root", "href": format!("./{COLLECTION}"), "type": "application/json" })];
    links.push(page_link(&format!("./{VIEWER}")));
    links.extend(items.iter().map(|(item, place)| {
        json!({ "rel": "item", "href": format!("./{place}"), "type": "application/geo+json", "title": item.id })
    }));
    json!({
        "type": "Collection",
        "stac_version": VERSION,
        "stac_extensions": if about.assets.is_empty() { vec![] } else { vec![OF_FILES] },
        "id": about.id,
        "title": about.title,
        "description": "Parts of an atlas of heliotile: each archive holds the hemispheres of its receivers, traced once, and answers \
                        for any sun, sky, weather and reflectance.",
        "license": about.license,
        "extent": { "spatial": { "bbox": [bbox] }, "temporal": { "interval": [interval] } },
        "links": links,
        "assets": assets(&about.assets),
    })
}

/// Returns the link to the page for people, which needs a web server.
fn page_link(href: &str) -> Value {
    json!({ "rel": "alternate", "href": href, "type": "text/html", "title": "Look at it: any sun and sky" })
}

fn assets(files: &[StacAsset]) -> Map<String, Value> {
    files.iter().map(|asset| (asset.key.to_owned(), asset.json())).collect()
}

/// Returns the ring of a rectangle, counter-clockwise, longitudes and latitudes; `None` without a
/// coordinate system.
fn footprint(low: DVec2, high: DVec2, crs: &MapCrs) -> Option<Vec<[f64; 2]>> {
    let corners = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y), low];
    let mut ring = Vec::with_capacity(4 * STEPS + 1);
    for side in corners.array_windows::<2>() {
        for step in 0..STEPS {
            ring.push(side[0].lerp(side[1], step as f64 / STEPS as f64));
        }
    }
    ring.push(low);
    let degrees = |point: DVec2| crs.degrees(DVec3::new(point.x, point.y, 0.0)).map(|[x, y, _]| [x, y].map(rounded));
    ring.into_iter().map(degrees).collect()
}

/// Rounds to a ten-millionth of a degree, about a centimetre.
fn rounded(degrees: f64) -> f64 {
    (degrees * 1e7).round() / 1e7
}

/// Returns the bounding box: west, south, east, north.
fn around(points: &[[f64; 2]]) -> [f64; 4] {
    points.iter().fold([f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY], |[w, s, e, n], [x, y]| {
        [w.min(*x), s.min(*y), e.max(*x), n.max(*y)]
    })
}

/// Returns a time as in RFC 3339, in whole seconds; times that no calendar holds become 1970.
fn time(at: SystemTime) -> String {
    let since = at.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
    let at = i64::try_from(since).ok().and_then(|seconds| Timestamp::from_second(seconds).ok());
    at.unwrap_or_default().to_string()
}
