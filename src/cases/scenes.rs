//! Requests of commands that read scenes and trace them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use heliotile_builder::planning::{AccuracyRequest, parse_negligible};
use heliotile_builder::settings::{EffectChoice, Share};
use heliotile_builder::trace::canopy::in_hulls;
use heliotile_builder::trace::placement::Placement;
use heliotile_core::error::Result;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::observer::Observer;
use heliotile_core::text::{Message, counted};
use heliotile_core::units::parse_metres;
use heliotile_core::weather::options::WeatherOptions;
use heliotile_energyplus::EnergyplusRequest;
use heliotile_files::spill::parse_memory;
use heliotile_files::writing::guards::guard_output;
use heliotile_requests::Request;
use heliotile_scene::edit::SceneEdits;
use heliotile_scene::request::SceneRequest;
use heliotile_scene::site::guard_site;
use heliotile_studies::covering::{CoverRequest, Density, cover_site, summary, write};
use heliotile_studies::on_ground::{AlongRequest, AreaSource, GroundPoint, WithinRequest, write_points};
use heliotile_studies::pv::PvRequest;
use heliotile_studies::{RunRequest, TradeoffRequest, UpdateRequest};

/// Request of the library, and the memory that it works in.
#[derive(Clone, Debug, Default, Request)]
pub struct InMemory<R: Request> {
    /// Request of the library.
    #[field(flatten)]
    pub request: R,
    /// Memory to work in, such as 512MiB or 2GiB.
    #[field(default = "4GiB", parse = parse_memory, neutral)]
    pub memory: MemoryBudget,
}

/// Request of `run`.
pub type Run = InMemory<RunRequest>;

/// Request of `energyplus`.
pub type Energyplus = InMemory<EnergyplusRequest>;

/// Request of `pv`.
pub type Pv = InMemory<PvRequest>;

/// Request of `tradeoff`.
pub type Tradeoff = InMemory<TradeoffRequest>;

/// Request of `update`.
#[derive(Clone, Debug, Default, Request)]
pub struct Update {
    /// Archive to edit, which must hold the triangles of its scene: a path or an address.
    #[field(positional, metavar = "BEFORE.helio", input = Archive)]
    pub before: PathBuf,
    /// Archive to write.
    #[field(short = 'o', metavar = "AFTER.helio", output = Archive, required)]
    pub output: PathBuf,
    /// Add the objects of a scene file, in the coordinates of the scene; may be repeated.
    #[field(metavar = "FILE", input = Scene)]
    pub add: Vec<PathBuf>,
    /// Edits of the objects.
    #[field(flatten)]
    pub edits: SceneEdits,
    /// Materials and place of what is added.
    #[field(
        flatten,
        without(
            "scene",
            "dsm",
            "dem",
            "canopy",
            "landcover",
            "height",
            "storey_height",
            "base",
            "height_above",
            "layer",
            "grid_north"
        )
    )]
    pub scene: SceneRequest,
    /// Surfaces of new or reshaped objects to cover with receivers, as for `receivers`.
    #[field(delimiter = ',')]
    pub on: Vec<String>,
    /// Distance between the receivers on new or reshaped objects, such as 2m [default: about that
    /// of the archive's own].
    #[field(metavar = "LENGTH", parse = parse_metres)]
    pub spacing_m: Option<f64>,
    /// Discard an interrupted update at the output path and start again. Without this option an
    /// update with the same edits is resumed.
    #[field(neutral)]
    pub fresh: bool,
    /// Memory to work in, such as 512MiB or 2GiB.
    #[field(default = "4GiB", parse = parse_memory, neutral)]
    pub memory: MemoryBudget,
}

/// Request of `receivers`.
#[derive(Clone, Debug, Default, Request)]
pub struct Receivers {
    /// Scene that gets receivers.
    #[field(flatten, without("grid_north"))]
    pub scene: SceneRequest,
    /// Table of receivers to write, CSV, or - for standard output:
    /// receiver,x,y,z,nx,ny,nz,area_m2,surface, and the object, building and kind that each
    /// receiver stands for.
    #[field(short = 'o', default = "-", output = Csv)]
    pub output: Option<PathBuf>,
    /// Surfaces that get receivers.
    #[field(flatten)]
    pub cover: CoverRequest,
    /// Table to write of receivers that are left out because they are buried in an object or the
    /// terrain, with the same columns and `reason`.
    #[field(metavar = "FILE", output = Csv)]
    pub buried: Option<PathBuf>,
    /// Put receivers along lines, such as roads, in place of surfaces, --spacing apart and facing
    /// the direction of travel: a CSV file of the corners of the lines with columns x and y, and
    /// optionally z and line (a name).
    #[field(metavar = "FILE", conflicts("on", "types", "per_surface", "buried", "offset", "min_area"), input = Any)]
    pub along: Option<PathBuf>,
    /// Height of the receivers, the eyes of drivers, above the z of --along, or above the ground of
    /// the scene where --along states no z.
    #[field(metavar = "LENGTH", default = "1.2m", requires("along"), parse = parse_metres)]
    pub eye_height_m: Option<f64>,
    /// Add receivers of --along that face backwards, for travel in both directions.
    #[field(requires("along"))]
    pub both_ways: bool,
    /// Put level receivers on the ground within areas, such as gardens and squares, in place of
    /// surfaces, --spacing apart and --offset above the ground: polygons (.geojson, .gpkg, .shp,
    /// .parquet), a CSV file of the corners of areas with columns x and y, and optionally area (a
    /// name), or a box xmin,ymin,xmax,ymax.
    #[field(metavar = "FILE|BOX", conflicts("on", "types", "per_surface", "buried", "min_area", "along"), input = Any)]
    pub within: Option<AreaSource>,
}

/// Request of `build`.
#[derive(Clone, Debug, Default, Request)]
#[request(skips = Build::skipped)]
pub struct Build {
    /// Scene to trace, or the folder of an atlas.
    #[field(flatten)]
    pub scene: SceneRequest,
    /// Table of receivers, CSV with columns receiver,x,y,z, tilt_deg,azimuth_deg (from true north)
    /// or nx,ny,nz, and optionally area_m2,surface; height (above the roof or ground below) may
    /// stand for z.
    #[field(short = 'r', input = Receivers)]
    pub receivers: Option<PathBuf>,
    /// Archive to write.
    #[field(short = 'o', metavar = "SITE.helio", output = Archive)]
    pub output: Option<PathBuf>,
    /// Build one part of an atlas, by its name or number, or `all` parts. SCENE is then the folder
    /// or address of the atlas, which states inputs and settings.
    #[field(
        metavar = "K",
        conflicts(
            "receivers",
            "output",
            "materials",
            "materials_only",
            "no_ground",
            "assume_version",
            "crs",
            "latitude",
            "longitude",
            "rotate_deg",
            "grid_north",
            "elevation",
            "scale",
            "up",
            "effects",
            "negligible",
            "weather",
            "no_scene",
            "error",
            "set",
            "quality",
            "share"
        )
    )]
    pub part: Option<String>,
    /// Only forecast rays and seconds, and with --weather the light that each light path adds:
    /// nothing is traced, and no file is written.
    #[field(neutral, conflicts("part", "from"))]
    pub dry_run: bool,
    /// Seconds between checkpoints: a crash loses no more work than this.
    #[field(metavar = "SECONDS", default = 30, neutral, range = 0..=u32::MAX, says = "give whole seconds from 0 (a checkpoint whenever something is written) to 4294967295")]
    pub checkpoint: Option<u32>,
    /// Discard an interrupted build at the output path and start again. Without this option a build
    /// of the same inputs is resumed, and a build of other inputs is an error.
    #[field(neutral)]
    pub fresh: bool,
    /// Sharing of probes (traced samples of what the surroundings see) between receivers.
    #[field(default = "cells", conflicts("error"))]
    pub share: Share,
    /// Light paths to trace besides direct sun and sky: `auto` (those that can matter in the
    /// scene), `all`, `none`, or some of diffuse, bounces, mirrors, canopies, leaves.
    #[field(metavar = "LIST", default = EffectChoice::Auto)]
    pub effects: EffectChoice,
    /// Leave out light paths that add no more than this share of the sum over --weather, in any
    /// group of receivers, such as 0.5%.
    #[field(metavar = "PERCENT", requires("weather"), conflicts("effects"), parse = parse_negligible)]
    pub negligible_percent: Option<f64>,
    /// Weather file of --negligible: light paths are left out by what they add under it; with
    /// --dry-run, what each of them adds is printed.
    #[field(short = 'w', metavar = "FILE", requires("negligible", "dry_run"), input = Weather)]
    pub weather: Option<PathBuf>,
    /// Archive of this scene before a change, or with --part an atlas of it; a path or an address.
    /// Only light that the change can alter is traced; the new archive has the same bytes as
    /// without this option.
    #[field(python = "before", metavar = "BEFORE.helio", input = Archive)]
    pub from: Option<PathBuf>,
    /// Leave the scene's triangles out of the archive, if they may not be passed on.
    #[field(python = "with_scene")]
    pub no_scene: bool,
    /// Accuracy of the archive.
    #[field(flatten)]
    pub accuracy: AccuracyRequest,
    /// Memory to work in, such as 512MiB or 2GiB; what does not fit goes to temporary files beside
    /// the archive.
    #[field(default = "4GiB", parse = parse_memory, neutral)]
    pub memory: MemoryBudget,
    /// Facts about the weather files.
    #[field(
        flatten,
        without("latitude", "longitude"),
        heading = "About the weather file",
        needs("weather", "error_weather")
    )]
    pub about_weather: WeatherOptions,
}

impl Update {
    /// Returns the request of the library.
    pub fn request(&self) -> UpdateRequest {
        UpdateRequest {
            before: self.before.clone(),
            output: self.output.clone(),
            edits: self.edits.clone(),
            add: SceneRequest { files: self.add.clone(), ..self.scene.clone() },
            cover: CoverRequest { on: self.on.clone(), ..CoverRequest::default() },
            density: self.spacing_m.map(Density::Spacing),
            fresh: self.fresh,
        }
    }
}

impl Receivers {
    /// Returns the table to write; `-`: standard output.
    pub fn output(&self) -> &Path {
        self.output.as_deref().unwrap_or(Path::new("-"))
    }

    /// Returns the lines that receivers go along, if they are given.
    pub fn lines(&self) -> Option<AlongRequest> {
        let (height_m, both_ways) = (self.eye_height_m.unwrap_or(EYES_M), self.both_ways);
        Some(AlongRequest { lines: self.along.clone()?, spacing_m: self.spacing_m(), height_m, both_ways })
    }

    /// Returns the areas that receivers lie in, if they are given.
    pub fn areas(&self) -> Option<WithinRequest> {
        let above_m = self.cover.offset_m;
        Some(WithinRequest { areas: self.within.clone()?, spacing_m: self.spacing_m(), above_m })
    }

    fn spacing_m(&self) -> f64 {
        if let Density::Spacing(metres) = self.cover.density { metres } else { 2.0 }
    }
}

impl Receivers {
    /// Writes the tables. Returns a summary.
    pub fn write(&self, observer: &dyn Observer) -> Result<Message> {
        let (site, output) = (self.scene.site()?, self.output());
        let to_file = output != Path::new("-");
        if to_file {
            guard_site(output, &site, &[])?;
        }
        if let Some(buried) = &self.buried {
            guard_site(buried, &site, &[Some(output)])?;
        }
        if let Some(along) = self.lines() {
            if to_file {
                guard_output(output, &[&along.lines])?;
            }
            let points = along.points(&site, observer)?;
            write_points(output, &points)?;
            return Ok(
                format!("{}, {} m above the road\n", counted(points.len() as u64, "receiver"), along.height_m).into()
            );
        }
        if let Some(within) = self.areas() {
            if let (true, AreaSource::File(file)) = (to_file, &within.areas) {
                guard_output(output, &[file])?;
            }
            let points = within.points(&site, observer)?;
            write_points(output, &points)?;
            let areas: BTreeSet<&str> = points.iter().filter_map(GroundPoint::area).collect();
            let (count, areas) = (counted(points.len() as u64, "receiver"), counted(areas.len() as u64, "area"));
            return Ok(format!("{count} in {areas}, {} m above the ground\n", within.above_m).into());
        }
        let (_, covered) = cover_site(&site, &self.cover, observer)?;
        // A build warns of them itself.
        in_hulls(covered.in_hulls).iter().for_each(|text| observer.warn(text));
        let offset_m = self.cover.offset_m;
        write(output, &covered, covered.free(), offset_m, false)?;
        if let Some(path) = &self.buried {
            let buried = covered.all().filter(|row| row.3 != Placement::Free);
            write(path, &covered, buried, offset_m, true)?;
        }
        Ok(summary(&covered))
    }
}

/// Height of the eyes of drivers above the road, metres.
const EYES_M: f64 = 1.2;

impl Build {
    /// An atlas is recognised when it is read.
    fn skipped(&self) -> Vec<&'static str> {
        if self.part.is_some() { vec!["scene", "from"] } else { Vec::new() }
    }
}
