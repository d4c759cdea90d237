//! Arguments of commands on archives as files: `info`, `verify`, `repair`, `store`, `extract`,
//! `merge`, `diff`.

use std::path::PathBuf;

use clap::{ArgGroup, Args, Subcommand};

use super::values::{Bytes, SelectionArgs, choice, parse_memory};
use super::{ClockArgs, FootprintArgs, MaterialsArgs, PlaceArgs, RasterArgs, SceneArgs, TableNorthArgs};
use heliotile::atlas::VerifyRequest;
use heliotile::{Access, RepairRequest};

#[derive(Args, Debug)]
pub struct VerifyArgs {
    /// Archive to check, or the folder of an atlas: a path or an address
    pub archive: PathBuf,
    /// Also decode every layer and follow every reference between blocks
    #[arg(long)]
    pub deep: bool,
    /// Way to read the archive
    #[arg(long, value_parser = choice::<Access>(), default_value = "pread")]
    pub io: Access,
}

impl VerifyArgs {
    /// Returns the request of `verify`.
    pub fn request(&self) -> VerifyRequest {
        VerifyRequest { place: self.archive.clone(), deep: self.deep, access: self.io }
    }
}

#[derive(Args, Debug)]
pub struct RepairArgs {
    /// Archive to repair
    pub archive: PathBuf,
    #[command(flatten)]
    pub scene: SceneArgs,
    #[command(flatten)]
    pub table_north: TableNorthArgs,
    /// Table of the receivers that the archive was built from; needed if the archive's own table is
    /// damaged
    #[arg(long, short)]
    pub receivers: Option<PathBuf>,
    /// Repaired archive to write [default: replace the damaged one]
    #[arg(long, short, value_name = "SITE.helio")]
    pub output: Option<PathBuf>,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
}

impl RepairArgs {
    /// Returns the request of `repair`.
    pub fn request(&self) -> RepairRequest {
        RepairRequest {
            archive: self.archive.clone(),
            scene: self.scene.request_by(&self.table_north),
            receivers: self.receivers.clone(),
            output: self.output.clone(),
        }
    }
}

#[derive(Args, Debug)]
pub struct StoreArgs {
    #[command(subcommand)]
    pub command: StoreCommand,
}

#[derive(Debug, Subcommand)]
pub enum StoreCommand {
    /// List the archives of a store, least recently used first
    Ls {
        /// Folder of the store
        folder: PathBuf,
    },
    /// Remove the least recently used archives of a store
    Gc {
        /// Folder of the store
        folder: PathBuf,
        /// Largest total size of the archives that stay, such as 10GiB
        #[arg(long)]
        keep: Bytes,
    },
    /// Check every archive of a store; exit code 1 if one is damaged
    Verify {
        /// Folder of the store
        folder: PathBuf,
    },
}

#[derive(Args, Debug)]
pub struct InfoArgs {
    /// Archive or atlas to describe (a path or an address), or scene files as for `build`
    #[arg(required_unless_present_any = ["dsm", "dem", "canopy", "landcover", "weather"], value_name = "SITE.helio|SCENE")]
    pub files: Vec<PathBuf>,
    /// Weather file to describe: its place, clock and irradiation by month as `replay` reads them
    #[arg(long, short, conflicts_with_all = ["files", "dsm", "dem"], value_name = "FILE")]
    pub weather: Option<PathBuf>,
    #[command(flatten)]
    pub about_weather: ClockArgs,
    #[command(flatten)]
    pub rasters: RasterArgs,
    #[command(flatten)]
    pub surfaces: MaterialsArgs,
    #[command(flatten)]
    pub place: PlaceArgs,
    #[command(flatten)]
    pub footprints: FootprintArgs,
    /// Way to read the archive
    #[arg(long, value_parser = choice::<Access>(), default_value = "map")]
    pub io: Access,
}

#[derive(Args, Debug)]
#[command(group(ArgGroup::new("some").required(true).args(["receivers", "bbox", "surface", "object"])))]
pub struct ExtractArgs {
    /// Archive to read, or an atlas of which one part holds all chosen receivers: a path or an
    /// address
    pub archive: PathBuf,
    /// Archive to write
    #[arg(long, short, value_name = "PART.helio")]
    pub output: PathBuf,
    #[command(flatten)]
    pub of: SelectionArgs,
    /// Leave the scene's triangles out of the new archive
    #[arg(long)]
    pub no_scene: bool,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
    /// Way to read the archive
    #[arg(long, value_parser = choice::<Access>(), default_value = "pread")]
    pub io: Access,
}

#[derive(Args, Debug)]
pub struct MergeArgs {
    /// First archive to read
    pub first: PathBuf,
    /// Second archive to read, of the same scene
    pub second: PathBuf,
    /// Archive to write
    #[arg(long, short, value_name = "SITE.helio")]
    pub output: PathBuf,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
    /// Way to read the archives
    #[arg(long, value_parser = choice::<Access>(), default_value = "pread")]
    pub io: Access,
}

#[derive(Args, Debug)]
pub struct DiffArgs {
    /// First archive to compare, A
    pub first: PathBuf,
    /// Second archive to compare, B
    pub second: PathBuf,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
    /// Way to read the archives
    #[arg(long, value_parser = choice::<Access>(), default_value = "pread")]
    pub io: Access,
}
