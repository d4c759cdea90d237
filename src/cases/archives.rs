//! Requests of commands on archives, atlases and pages.

use std::path::{Path, PathBuf};

use heliotile_archives::Workspace;
use heliotile_archives::transfer::{self, Bounds, Merged};
use heliotile_atlas::ExportRequest;
use heliotile_atlas::catalogue::CatalogueRequest;
use heliotile_core::archive::Access;
use heliotile_core::error::Result;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::observer::Observer;
use heliotile_core::text::Message;
use heliotile_core::weather::options::WeatherOptions;
use heliotile_files::spill::parse_memory;
use heliotile_files::writing::copy::folder_of;
use heliotile_files::writing::guards::{guard_archive, guard_output};
use heliotile_remote::naming::is_address;
use heliotile_remote::places::open_archive;
use heliotile_requests::Request;
use heliotile_results::PageRequest;
use heliotile_results::outputs::tables::format::table_help;
use heliotile_scene::request::SceneRequest;
use heliotile_studies::{AuditRequest, RepairRequest};

use super::{InMemory, SelectionRequest};

/// Request of `audit`.
#[derive(Clone, Debug, Default, Request)]
pub struct Audit {
    /// Archive, scene and hours.
    #[field(flatten)]
    pub request: AuditRequest,
    /// Folder to write audit.csv, pictures and index.html into.
    #[field(short = 'o', metavar = "FOLDER", output = Folder(&["audit.csv"]))]
    pub output: Option<PathBuf>,
    /// Memory to work in, such as 512MiB or 2GiB.
    #[field(default = "4GiB", parse = parse_memory, neutral)]
    pub memory: MemoryBudget,
}

/// Request of `repair`.
pub type Repair = InMemory<RepairRequest>;

/// Request of `catalogue`.
#[derive(Clone, Debug, Default, Request)]
pub struct Catalogue {
    /// Folder of the atlas.
    #[field(positional, required, input = Any)]
    pub atlas: PathBuf,
    /// Title and licence.
    #[field(flatten)]
    pub request: CatalogueRequest,
}

/// Request of `atlas find`.
#[derive(Clone, Debug, Default, Request)]
pub struct Find {
    /// Folder of the atlas, or its address.
    #[field(positional, required)]
    pub atlas: PathBuf,
    /// Box in the coordinates of the scene, metres: xmin,ymin,xmax,ymax; only parts that touch it
    /// are listed [default: all parts].
    #[field(metavar = "BOX", hyphen)]
    pub bbox: Option<Bounds>,
}

/// Request of `info`.
#[derive(Clone, Debug, Default, Request)]
#[request(any_of("files", "dsm", "dem", "canopy", "landcover", "weather", "rule"))]
pub struct Info {
    /// Archive or atlas to describe (a path or an address), or scene files as for `build`.
    #[field(metavar = "SITE.helio|SCENE", input = SceneOrArchive, positional)]
    pub files: Vec<PathBuf>,
    /// Weather file to describe: its place, clock and irradiation by month as `replay` reads them.
    #[field(short = 'w', conflicts("files", "dsm", "dem"), metavar = "FILE", input = Weather)]
    pub weather: Option<PathBuf>,
    /// Rule whose file is printed, to be copied and changed, or `all` to list those that `sunlight`
    /// and `glare` can check.
    #[field(metavar = "NAME", conflicts("files", "dsm", "dem", "weather"))]
    pub rule: Option<String>,
    /// Statements about scene files.
    #[field(flatten, without("scene", "grid_north"))]
    pub scene: SceneRequest,
    /// Facts about the weather file.
    #[field(flatten, without("latitude", "longitude"), heading = "About the weather file")]
    pub about_weather: WeatherOptions,
    /// Way to read the archive.
    #[field(default = "map", neutral)]
    pub io: Access,
}

/// Request of `extract`.
#[derive(Clone, Debug, Default, Request)]
#[request(any_of("receivers", "bbox", "surface", "object", "replay_only"))]
pub struct Extract {
    /// Archive to read, or an atlas of which one part holds all chosen receivers: a path or an
    /// address.
    #[field(positional, required, input = Archive)]
    pub archive: PathBuf,
    /// Archive to write.
    #[field(short = 'o', metavar = "PART.helio", output = Archive, required)]
    pub output: PathBuf,
    /// Receivers that are written.
    #[field(flatten)]
    pub receivers: SelectionRequest,
    /// Leave the scene's triangles out of the new archive.
    #[field(python = "with_scene")]
    pub no_scene: bool,
    /// Leave out hits and cells, about two thirds of the bytes: the archive answers for weather,
    /// suns, skies and hours of sun, but not for changed reflectances, a number of bounces, bands,
    /// longwave, comfort, maps of what a receiver sees or EnergyPlus; `build` makes it whole again.
    pub replay_only: bool,
    /// Memory to work in, such as 512MiB or 2GiB.
    #[field(default = "4GiB", parse = parse_memory, neutral)]
    pub memory: MemoryBudget,
    /// Way to read the archive.
    #[field(default = "pread", neutral)]
    pub io: Option<Access>,
}

/// Request of `merge`.
#[derive(Clone, Debug, Default, Request)]
pub struct Merge {
    /// First archive to read.
    #[field(positional, required, input = Archive)]
    pub first: PathBuf,
    /// Second archive to read, of the same scene.
    #[field(positional, required, input = Archive)]
    pub second: PathBuf,
    /// Archive to write.
    #[field(short = 'o', metavar = "SITE.helio", output = Archive, required)]
    pub output: PathBuf,
    /// Memory to work in, such as 512MiB or 2GiB.
    #[field(default = "4GiB", parse = parse_memory, neutral)]
    pub memory: MemoryBudget,
    /// Way to read the archives.
    #[field(default = "pread", neutral)]
    pub io: Option<Access>,
}

/// Request of `diff`.
#[derive(Clone, Debug, Default, Request)]
pub struct Diff {
    /// First archive to compare, A.
    #[field(positional, required, input = Archive)]
    pub first: PathBuf,
    /// Second archive to compare, B.
    #[field(positional, required, input = Archive)]
    pub second: PathBuf,
    /// Memory to work in, such as 512MiB or 2GiB.
    #[field(default = "4GiB", parse = parse_memory, neutral)]
    pub memory: MemoryBudget,
    /// Way to read the archives.
    #[field(default = "pread", neutral)]
    pub io: Option<Access>,
}

/// Request of `copy`.
#[derive(Clone, Debug, Default, Request)]
#[request(skips = Copy::skipped)]
pub struct Copy {
    /// Source: an archive, another file, or the folder of an atlas; a path or an address.
    #[field(metavar = "FROM", positional, required, input = Any)]
    pub from: PathBuf,
    /// Destination: a path or an address.
    #[field(metavar = "TO", positional, required, output = File)]
    pub to: PathBuf,
    /// Replace what the destination holds.
    #[field(neutral)]
    pub replace: bool,
}

/// Request of `view`.
#[derive(Clone, Debug, Default, Request)]
pub struct View {
    /// Archives and weather of the page.
    #[field(flatten)]
    pub page: PageRequest,
    /// Port of the page's address [default: 8017, or any free port if it is taken].
    #[field(metavar = "PORT", neutral)]
    pub port: Option<u16>,
}

/// Request of `export`.
#[derive(Clone, Debug, Default, Request)]
#[request(exactly_one("receiver", "view_factors", "html"), any_of("output", "html"))]
pub struct Export {
    /// Archive, receiver and light.
    #[field(flatten)]
    pub request: ExportRequest,
    /// .
    #[field(short = 'o', help = export_help, output = File)]
    pub output: Option<PathBuf>,
    /// Export the shares of every receiver's hemisphere that are sky, ground, obstructions and
    /// nothing (they sum to 1).
    #[field(conflicts("sun", "weather", "latitude"))]
    pub view_factors: bool,
    /// Write a page that shows the archive in a browser, as `view` does, but needs no server. An
    /// archive of up to 50 MB is inside the page, with the weather file if one is given; for a
    /// larger one the page asks for the file.
    #[field(metavar = "PAGE.html", conflicts("output", "sun", "latitude", "time_zone"), output = File)]
    pub html: Option<PathBuf>,
    /// Archive of the same site after a change, for the page of --html: it shows before, after and
    /// the change, as `view --with` does.
    #[field(python = "with_", metavar = "AFTER", conflicts("receiver", "view_factors"), input = Archive)]
    pub with: Option<PathBuf>,
    /// Memory to work in, such as 512MiB or 2GiB.
    #[field(default = "4GiB", parse = parse_memory, neutral)]
    pub memory: MemoryBudget,
}

fn export_help() -> Message {
    table_help("File to write: .exr or .png for a receiver; for view factors")
}

impl Merge {
    /// Writes the union. Returns what it holds.
    pub fn write(&self, observer: &dyn Observer) -> Result<Merged> {
        guard_output(&self.output, &[&self.first, &self.second])?;
        guard_archive(&self.output)?;
        let access = self.io.unwrap_or(Access::Read);
        let (a, b) = (open_archive(&self.first, access)?, open_archive(&self.second, access)?);
        let workspace = Workspace { folder: folder_of(&self.output).to_path_buf(), memory: self.memory };
        transfer::merge([&a, &b], &self.output, &workspace, observer)
    }
}

impl Diff {
    /// Returns true if the archives are equal, and their differences as text.
    pub fn found(&self) -> Result<(bool, String)> {
        let access = self.io.unwrap_or(Access::Read);
        let (a, b) = (open_archive(&self.first, access)?, open_archive(&self.second, access)?);
        let workspace = Workspace { folder: std::env::temp_dir(), memory: self.memory };
        let found = transfer::diff(&a, &b, &workspace)?;
        Ok((found.is_equal(), found.table([a.path(), b.path()])))
    }
}

impl Copy {
    /// Addresses are judged when they are read or written.
    fn skipped(&self) -> Vec<&'static str> {
        let places = [("from", &self.from), ("to", &self.to)];
        places.into_iter().filter(|(_, place)| is_address(place)).map(|(name, _)| name).collect()
    }
}

impl Export {
    /// Returns the file to write; one of two is always given.
    pub fn output(&self) -> &Path {
        self.output.as_deref().or(self.html.as_deref()).unwrap_or(Path::new("-"))
    }

    /// Returns the request for a page, if one is requested.
    pub fn page(&self) -> Option<PageRequest> {
        Some(PageRequest {
            archive: self.request.place.clone(),
            with: self.with.clone(),
            access: self.request.access,
            weather: self.request.weather.clone(),
            about_weather: WeatherOptions::default(),
            output: self.html.clone().filter(|_| self.request.receiver.is_none())?,
        })
    }

    /// Returns the request for images or view factors.
    pub fn request(&self) -> ExportRequest {
        ExportRequest { output: self.output().into(), ..self.request.clone() }
    }
}
