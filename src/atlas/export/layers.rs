//! The layers of a receiver. In: an archive, a receiver, a light. Out: maps as EXR, a picture or a
//! panel of six as PNG.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::request::ExportRequest;
use crate::sources::holding;
use heliotile_archives::Workspace;
use heliotile_archives::transfer::Selection;
use heliotile_core::archive::{Archive, format};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::maps::{Illumination, Map as LayerMap, maps};
use heliotile_core::replay::receiver_view::ReceiverView;
use heliotile_core::replay::sun_hours::SunHours;
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::time::sun::Location;
use heliotile_core::weather::time::sun_path::{MONTHS, SunPath};
use heliotile_files::spill::TempFiles;
use heliotile_files::writing::copy::folder_of;
use heliotile_results::outputs::pictures::exr::exr;
use heliotile_results::outputs::pictures::fisheye::{Overlay, fisheye};
use heliotile_results::outputs::pictures::panel::{PanelSun, panel};
use heliotile_results::{Provenance, Resources};
use heliotile_weather::series::Weather;

/// Kinds of image files.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Image {
    /// Values, as EXR.
    Exr,
    /// A picture, as PNG.
    Png,
}

impl Image {
    /// Returns the kind that the extension of a file name states.
    pub(super) fn by_ending(output: &Path) -> Result<Self> {
        let ending = output.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        match ending.as_deref() {
            Some("exr") => Ok(Image::Exr),
            Some("png") => Ok(Image::Png),
            _ => Err(Error::Unsupported {
                what: "ending of the image".into(),
                found: format!("`{}`", output.display()),
                supported: ".exr (values) and .png (a picture)".into(),
            }),
        }
    }
}

/// A receiver of an open archive, and what is exported of it.
struct ReceiverLayers<'a> {
    request: &'a ExportRequest,
    resources: &'a Resources<'a>,
    archive: &'a Archive,
    site: &'a OpenSite<'a>,
    view: ReceiverView,
}

/// Returns the bytes of the image file.
pub(super) fn layers_of(
    request: &ExportRequest,
    receiver: &str,
    image: Image,
    about: Provenance,
    resources: &Resources,
) -> Result<Vec<u8>> {
    // The weather file is read before the archive, so that a wrong one is found at once.
    let (mut overlay, weather, about) = overlay(request, image, receiver, about, resources)?;
    let archive = holding_receiver(request, receiver, resources)?;
    let site = OpenSite::open(&archive)?;
    overlay.north = site.north();
    let view = ReceiverView::load(&site, receiver)?;
    let mut about = about.with_archive(&request.place, &archive);
    if let Some(weather) = &weather {
        let steps = weather.steps_of(archive.manifest().settings.steps());
        let hours = SunHours::new(&view, &weather.row_suns(steps), site.north());
        overlay.sun_hours = in_words(&hours, weather.rows.len());
        about = with_hours(about, &hours);
    }
    let layers = ReceiverLayers { request, resources, archive: &archive, site: &site, view };
    match (image, request.sun) {
        (Image::Png, Some(sun)) if request.panel => {
            let called = format!(
                "sun at {}\u{b0}, {}\u{b0} high; DNI {}, DHI {} W/m2",
                sun.azimuth_deg(),
                sun.altitude_deg(),
                request.dni_w_m2,
                request.dhi_w_m2
            );
            let sun = PanelSun { direction: site.north().to_axes(sun.direction()), called };
            panel(&layers.view, &layers.maps()?, &sun, site.north(), &about)
        }
        (Image::Png, _) => fisheye(&layers.view, &overlay, &about),
        (Image::Exr, _) => layers.values(&about),
    }
}

/// Opens the archive that holds a receiver; in an atlas, the archive of the part that holds it.
fn holding_receiver(request: &ExportRequest, id: &str, resources: &Resources) -> Result<Archive> {
    let workspace = Workspace { folder: folder_of(&request.output).into(), memory: resources.memory };
    holding(&request.place, Some(&Selection::Ids(vec![id.to_owned()])), request.access, &workspace)
}

impl ReceiverLayers<'_> {
    /// Returns the maps as EXR.
    fn values(&self, provenance: &Provenance) -> Result<Vec<u8>> {
        let mut about = self.about();
        about.insert("provenance".into(), provenance.json());
        exr(&self.maps()?, &about)
    }

    /// Computes the maps under the requested light.
    fn maps(&self) -> Result<Vec<LayerMap>> {
        let request = self.request;
        let light = match request.sun {
            None => None,
            Some(sun) => {
                let (dni, dhi) = (request.dni_w_m2, request.dhi_w_m2);
                if dni == 0.0 && dhi == 0.0 {
                    self.resources.observer.warn("neither {dni} nor {dhi} is given: the maps of light are dark");
                }
                let direction = sun.direction();
                let condition = Condition::new("export".into(), &[direction], direction, dni, dhi);
                let patches = request.patches.unwrap_or_else(|| self.archive.manifest().settings.patches());
                Some(Illumination::new(self.site, condition, request.sky, patches, request.bounces)?)
            }
        };
        let storage = TempFiles::new(folder_of(&request.output));
        maps(self.site, &self.view, light.as_ref(), self.resources.memory, &storage)
    }

    /// Returns the metadata of every part of an EXR file.
    fn about(&self) -> Map<String, Value> {
        let (request, receiver) = (self.request, &self.view.receiver);
        let names: Vec<&str> = self.view.materials.iter().map(|material| material.name.as_str()).collect();
        let mut about = Map::new();
        about.insert("receiver".into(), json!(receiver.id));
        about.insert("position_m".into(), json!(receiver.position.to_array()));
        about.insert("normal".into(), json!(receiver.normal.to_array()));
        about.insert("materials".into(), json!(names));
        about.insert("archive_root".into(), json!(format::hex(&self.archive.root())));
        if let Some(sun) = request.sun {
            about.insert("sun_azimuth_deg".into(), json!(sun.azimuth_deg()));
            about.insert("sun_altitude_deg".into(), json!(sun.altitude_deg()));
            about.insert("dni_w_m2".into(), json!(request.dni_w_m2));
            about.insert("dhi_w_m2".into(), json!(request.dhi_w_m2));
            about.insert("sky".into(), json!(request.sky.to_string()));
        }
        if let Some(place) = self.archive.manifest().place {
            about.insert("y_from_true_north_deg".into(), json!(place.convergence_deg));
        }
        about
    }
}

/// Returns the overlay of a picture, the weather file that it uses, and its provenance.
fn overlay(
    request: &ExportRequest,
    image: Image,
    receiver: &str,
    about: Provenance,
    resources: &Resources,
) -> Result<(Overlay, Option<Weather>, Provenance)> {
    if image == Image::Exr && request.panel {
        return Err(Error::Unsupported {
            what: "a panel".into(),
            found: format!("`{}`", request.output.display()),
            supported: "it as a .png".into(),
        });
    }
    if image == Image::Exr && (request.weather.is_some() || request.latitude_deg.is_some()) {
        return Err(Error::Unsupported {
            what: "paths of the sun ({weather}, {latitude})".into(),
            found: format!("`{}`", request.output.display()),
            supported: "them in a .png".into(),
        });
    }
    let mut provenance = about;
    let mut of_file = None;
    let path = match (&request.weather, request.latitude_deg) {
        (Some(file), _) => {
            let mut place = || match holding_receiver(request, receiver, resources)?.manifest().place {
                None => {
                    let what = "states no place, and neither does the archive";
                    let hint = "give a latitude in place of the file, such as {latitude} 52, or build the archive from a scene with a place";
                    Err(Error::input(file, None, what, hint).because(Problem::Lacks("place")))
                }
                place => Ok(place),
            };
            let weather = resources.weather(file, &request.about_weather, &mut place)?;
            provenance = provenance.with_weather(file, &weather);
            // Some files pad names with blanks.
            let place = weather.place.split_whitespace().collect::<Vec<_>>().join(" ");
            let weather = of_file.insert(weather);
            let zone = weather.site.zone_hours;
            Some((SunPath::on(&MONTHS, &weather.site), format!("{place}, hours of UTC{zone:+}")))
        }
        (None, Some(latitude)) => {
            let refuse = |what| Error::argument("latitude", what, "give degrees, north positive");
            let site = Location::new(latitude, 0.0, 0.0, 0.0).map_err(refuse)?;
            Some((SunPath::on(&MONTHS, &site), format!("latitude {latitude}\u{b0}, hours of mean solar time")))
        }
        (None, None) => None,
    };
    let overlay = Overlay { path, sun: request.sun.map(|sun| sun.direction()), ..Overlay::default() };
    Ok((overlay, of_file, provenance))
}

/// Describes in words how long the sun is visible over a weather file.
fn in_words(hours: &SunHours, rows: usize) -> Vec<String> {
    let [up, seen, hidden, behind] = hours.sums();
    vec![
        format!("sun up {up:.0} h: seen {seen:.0} h, hidden {hidden:.0} h, behind the surface {behind:.0} h"),
        format!("direct sun in {} of the weather file's {rows} rows", hours.sunny_rows),
    ]
}

/// Adds the hours in which the sun is visible to the provenance.
fn with_hours(about: Provenance, hours: &SunHours) -> Provenance {
    let names = ["sun_up_h", "sun_seen_h", "sun_hidden_h", "sun_behind_h"];
    let about = names.into_iter().zip(hours.sums()).fold(about, |about, (name, h)| about.with(name, format!("{h:.3}")));
    about.with("sunny_rows", hours.sunny_rows)
}
