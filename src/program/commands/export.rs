//! Layers that people can look at: archive -> maps of a receiver -> EXR or PNG; view factors -> a table.

use std::io::Write;
use std::path::Path;

use serde_json::{Map, Value, json};

use super::{Outcome, warn, workspace_beside};
use crate::cli::ExportArgs;
use heliotile_atlas::sources::{self, holding};
use heliotile_builder::spill::TempFiles;
use heliotile_builder::transfer::{ArchiveReceivers, Selection};
use heliotile_builder::writing::copy::folder_of;
use heliotile_builder::writing::guards::guard_output;
use heliotile_core::archive::{Archive, format};
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::MemoryBudget;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::maps::{Illumination, Map as LayerMap, maps};
use heliotile_core::replay::receiver_view::ReceiverView;
use heliotile_core::replay::sun_hours::SunHours;
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::distance::far_apart;
use heliotile_core::weather::options::WeatherOptions;
use heliotile_core::weather::series::Weather;
use heliotile_core::weather::time::sun::Location;
use heliotile_core::weather::time::sun_path::{MONTHS, SunPath};
use heliotile_remote::naming::shown;
use heliotile_remote::places::{hold, open_archive};
use heliotile_results::outputs::pictures::exr::exr;
use heliotile_results::outputs::pictures::fisheye::{Overlay, fisheye};
use heliotile_results::outputs::pictures::panel::{PanelSun, panel};
use heliotile_results::outputs::provenance::Provenance;
use heliotile_results::outputs::sink::Sink;
use heliotile_results::outputs::tables::format::files_of;
use heliotile_results::outputs::view_factors::ViewFactorTable;
use heliotile_results::outputs::viewer_page::ViewerPage;
use heliotile_scene::input;
use heliotile_scene::input::weather::read_weather_as;

/// Kinds of images.
enum Image {
    Exr,
    Png,
}

impl Image {
    fn of(output: &Path) -> Result<Self> {
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

/// `heliotile export`.
pub fn run(args: &ExportArgs, about: Provenance) -> Result<Outcome> {
    if args.output() != Path::new("-") {
        let inputs: Vec<&Path> =
            [Some(args.archive.as_path()), args.weather.as_deref()].into_iter().flatten().collect();
        files_of(args.output()).iter().try_for_each(|file| guard_output(file, &inputs))?;
    }
    match &args.receiver {
        None if args.html.is_some() => page(args),
        None => view_factors(args, about),
        Some(id) => {
            let image = Image::of(args.output())?;
            // Before the archive: a wrong weather file is found at once.
            let (mut overlay, weather, about) = overlay(args, &image, id, about)?;
            let archive = holding_receiver(args, id)?;
            let site = OpenSite::of(&archive)?;
            overlay.north = site.north();
            let view = ReceiverView::load(&site, id)?;
            let mut about = about.with_archive(&args.archive, &archive);
            if let Some(weather) = &weather {
                let steps = weather.steps_of(archive.manifest().settings.steps());
                let hours = SunHours::of(&view, weather, steps, site.north());
                overlay.sun_hours = in_words(&hours, weather.rows.len());
                about = with_hours(about, &hours);
            }
            let bytes = match (image, args.sun) {
                (Image::Png, Some(sun)) if args.panel => {
                    let maps = lit_maps(args, (&archive, &site), &view)?;
                    let called = format!(
                        "sun at {}\u{b0}, {}\u{b0} high; DNI {}, DHI {} W/m2",
                        sun.azimuth_deg, sun.altitude_deg, args.dni, args.dhi
                    );
                    let sun = PanelSun { direction: site.north().to_axes(sun.direction()), called };
                    panel(&view, &maps, &sun, site.north(), &about)?
                }
                (Image::Png, _) => fisheye(&view, &overlay, &about)?,
                (Image::Exr, _) => layers(args, (&archive, &site), &view, &about)?,
            };
            let mut sink = Sink::file(args.output())?;
            sink.write_all(&bytes).map_err(Error::io(args.output(), "write to"))?;
            sink.finish()?;
            Ok(Outcome::Fine)
        }
    }
}

/// The archive, or that of the part of an atlas, which holds a receiver.
fn holding_receiver(args: &ExportArgs, id: &str) -> Result<Archive> {
    let workspace = workspace_beside(args.output(), args.memory);
    holding(&args.archive, &Selection::Ids(vec![id.to_owned()]), args.io, &workspace)
}

/// Maps of a receiver as EXR.
fn layers(
    args: &ExportArgs,
    (archive, site): (&Archive, &OpenSite),
    view: &ReceiverView,
    provenance: &Provenance,
) -> Result<Vec<u8>> {
    let maps = lit_maps(args, (archive, site), view)?;
    let mut about = about(args, archive, view);
    about.insert("provenance".into(), provenance.json());
    exr(&maps, &about)
}

/// Maps of a receiver under the light that is asked for.
fn lit_maps(args: &ExportArgs, (archive, site): (&Archive, &OpenSite), view: &ReceiverView) -> Result<Vec<LayerMap>> {
    let light = match args.sun {
        None => None,
        Some(sun) => {
            if args.dni == 0.0 && args.dhi == 0.0 {
                warn("neither --dni nor --dhi: the maps of light are dark");
            }
            let direction = sun.direction();
            let condition = Condition::new("export".into(), &[direction], direction, args.dni, args.dhi);
            let patches = args.patches.unwrap_or_else(|| archive.manifest().settings.patches());
            Some(Illumination::new(site, condition, args.sky, patches, args.bounces)?)
        }
    };
    let storage = TempFiles::new(folder_of(args.output()));
    maps(site, view, light.as_ref(), MemoryBudget::new(args.memory.0), &storage)
}

/// What stands in every part of an EXR file.
fn about(args: &ExportArgs, archive: &Archive, view: &ReceiverView) -> Map<String, Value> {
    let receiver = &view.receiver;
    let mut about = Map::new();
    about.insert("receiver".into(), json!(receiver.id));
    about.insert("position_m".into(), json!(receiver.position.to_array()));
    about.insert("normal".into(), json!(receiver.normal.to_array()));
    about.insert(
        "materials".into(),
        json!(view.materials.iter().map(|material| material.name.as_str()).collect::<Vec<_>>()),
    );
    about.insert("archive_root".into(), json!(format::hex(&archive.root())));
    if let Some(sun) = args.sun {
        about.insert("sun_azimuth_deg".into(), json!(sun.azimuth_deg));
        about.insert("sun_altitude_deg".into(), json!(sun.altitude_deg));
        about.insert("dni_w_m2".into(), json!(args.dni));
        about.insert("dhi_w_m2".into(), json!(args.dhi));
        about.insert("sky".into(), json!(args.sky.to_string()));
    }
    if let Some(place) = archive.manifest().place {
        about.insert("y_from_true_north_deg".into(), json!(place.convergence_deg));
    }
    about
}

/// What is drawn over a picture, and what it is made of.
fn overlay(
    args: &ExportArgs,
    image: &Image,
    receiver: &str,
    about: Provenance,
) -> Result<(Overlay, Option<Weather>, Provenance)> {
    if matches!(image, Image::Exr) && args.panel {
        return Err(Error::Unsupported {
            what: "a panel".into(),
            found: format!("`{}`", args.output().display()),
            supported: "it as a .png".into(),
        });
    }
    if matches!(image, Image::Exr) && (args.weather.is_some() || args.latitude.is_some()) {
        return Err(Error::Unsupported {
            what: "paths of the sun (--weather, --latitude)".into(),
            found: format!("`{}`", args.output().display()),
            supported: "them in a .png".into(),
        });
    }
    let mut provenance = about;
    let mut of_file = None;
    let path = match (&args.weather, args.latitude) {
        (Some(file), _) => {
            let options = WeatherOptions { zone_hours: args.time_zone, ..WeatherOptions::default() };
            let mut place = || match holding_receiver(args, receiver)?.manifest().place {
                None => {
                    let what = "does not say where it is from, nor does the archive say where it lies";
                    let hint = "draw the paths over a latitude in place of the file, such as --latitude 52, or build the archive of a \
                                scene with a place";
                    Err(Error::input(file, None, what, hint))
                }
                place => Ok(place),
            };
            let weather = read_weather_as(file, &options, &mut place)?;
            provenance = provenance.with_weather(file, &weather);
            // Names are filled up with blanks in some files.
            let place = weather.place.split_whitespace().collect::<Vec<_>>().join(" ");
            let weather = of_file.insert(weather);
            let zone = weather.site.zone_hours;
            Some((SunPath::on(&MONTHS, &weather.site), format!("{place}, hours of UTC{zone:+}")))
        }
        (None, Some(latitude)) => {
            let refuse = |what| Error::argument("--latitude", what, "give degrees, north positive");
            let site = Location::new(latitude, 0.0, 0.0, 0.0).map_err(refuse)?;
            Some((SunPath::on(&MONTHS, &site), format!("latitude {latitude}\u{b0}, hours of mean solar time")))
        }
        (None, None) => None,
    };
    let overlay = Overlay { path, sun: args.sun.map(|sun| sun.direction()), ..Overlay::default() };
    Ok((overlay, of_file, provenance))
}

/// How long the sun is seen through a weather file.
fn in_words(hours: &SunHours, rows: usize) -> Vec<String> {
    let [up, seen, hidden, behind] = hours.sums();
    vec![
        format!("sun up {up:.0} h: seen {seen:.0} h, hidden {hidden:.0} h, behind the surface {behind:.0} h"),
        format!("direct sun in {} of the weather file's {rows} rows", hours.sunny_rows),
    ]
}

/// The same for programs.
fn with_hours(about: Provenance, hours: &SunHours) -> Provenance {
    let names = ["sun_up_h", "sun_seen_h", "sun_hidden_h", "sun_behind_h"];
    let about = names.into_iter().zip(hours.sums()).fold(about, |about, (name, h)| about.with(name, format!("{h:.3}")));
    about.with("sunny_rows", hours.sunny_rows)
}

/// A page that shows the archive.
fn page(args: &ExportArgs) -> Result<Outcome> {
    let archive = open_archive(&args.archive, args.io)?;
    OpenSite::of(&archive)?;
    let mut page = ViewerPage::default().with_archive(&shown(&args.archive), hold(&args.archive)?.as_ref())?;
    if let Some(file) = &args.weather {
        let weather = read_weather_as(file, &WeatherOptions::default(), &mut || Ok(archive.manifest().place))?;
        weather.report.warnings.iter().for_each(|w| warn(w));
        archive.manifest().place.and_then(|place| far_apart(&place, &weather)).iter().for_each(|apart| warn(apart));
        page = page.with_weather(file, &input::read(file)?)?;
    }
    if !page.holds_archive() {
        warn(&format!("{} is larger than 50 MB: the page asks for it", archive.path().display()));
    }
    page.write(args.output())?;
    Ok(Outcome::Fine)
}

/// View factors of all receivers as a table.
fn view_factors(args: &ExportArgs, about: Provenance) -> Result<Outcome> {
    let sources = sources::open(&args.archive, args.io)?;
    let about = sources.borrowed().told_in(about, &args.archive);
    let count = sources.borrowed().iter().map(|archive| archive.manifest().receivers.count).sum();
    let mut table = ViewFactorTable::create(args.output(), count, &about)?;
    'all: for archive in sources.borrowed().iter() {
        for row in ArchiveReceivers::<()>::new(&OpenSite::of(archive)?) {
            let row = row?;
            table.row(&row.receiver.id, row.views)?;
            if table.is_closed() {
                break 'all;
            }
        }
    }
    table.finish()?;
    Ok(Outcome::Fine)
}
