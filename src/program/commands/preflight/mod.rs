//! Checks before a command begins its work. In: a command line. Out: a refusal if a file to read is
//! not there or is of another kind, or a file to write has a wrong extension or no folder: at once,
//! not after an hour.

mod kind;

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use crate::cli::{Command, RecombineArgs, SceneArgs, StudyCommand, TableArgs, YearArgs};
use heliotile::archive::require_file;
use heliotile::covering::check_name;
use heliotile::output::{
    ClaimedOutput, Format, OutputGuard, ResultFormat, check_archive_name, files_of, folder_beside, folder_of,
    is_city_model,
};
use heliotile::remote::{is_address, shown};
use heliotile::scene::input;
use heliotile::{Error, Result, Temperature};
use kind::Wanted;

/// Kind of output.
enum Written {
    Archive,
    /// A table, in the format of its extension.
    Table,
    /// A table or a map, in the format of its extension.
    Results {
        geo: bool,
    },
    /// A table as CSV.
    Csv,
    /// Any other file, whose command checks the extension.
    File,
    /// A folder of one run, with the names of tables that it writes there.
    Folder(&'static [&'static str]),
    /// A folder that several runs may write into.
    SharedFolder,
}

/// Refuses a command line whose files cannot work, and claims its outputs: until the guard is
/// dropped, no other run writes them, and no file replaces an input.
pub fn check(command: &Command) -> Result<OutputGuard> {
    let mut files = Files::default();
    files.collect(command);
    files.outputs.iter().try_for_each(|(path, written)| check_output(path, written))?;
    files.inputs.iter().try_for_each(|(path, wanted)| match wanted {
        // The reader of an address checks it when it opens it.
        Wanted::Archive | Wanted::SceneOrArchive if is_address(path) => Ok(()),
        _ => {
            require_file(path, "only archives are read from addresses")?;
            input::check(path)?;
            wanted.check(path)
        }
    })?;
    let inputs: Vec<&Path> = files.inputs.iter().map(|(path, _)| *path).filter(|path| !is_address(path)).collect();
    let outputs: Vec<ClaimedOutput> =
        files.outputs.iter().filter_map(|(path, written)| output_of(path, written)).collect();
    OutputGuard::new(&inputs, &outputs)
}

/// Returns an output with all files that it consists of; `None` for standard output.
fn output_of(path: &Path, written: &Written) -> Option<ClaimedOutput> {
    match written {
        Written::Archive => Some(ClaimedOutput::archive(path)),
        Written::Folder(names) => Some(ClaimedOutput::folder(path, names)),
        Written::SharedFolder => Some(ClaimedOutput::shared(path)),
        _ if path == Path::new("-") => None,
        Written::Table | Written::Results { .. } | Written::Csv => {
            Some(ClaimedOutput::file(path, files_of(path).into_iter().skip(1).collect()))
        }
        Written::File => Some(ClaimedOutput::file(path, Vec::new())),
    }
}

/// Files that a command line names.
#[derive(Default)]
struct Files<'a> {
    inputs: Vec<(&'a Path, Wanted)>,
    outputs: Vec<(Cow<'a, Path>, Written)>,
}

impl<'a> Files<'a> {
    fn collect(&mut self, command: &'a Command) {
        match command {
            Command::Run(args) => {
                self.scene(&args.scene);
                self.read(&args.weather, Wanted::Weather);
                self.read_if(&args.receivers, Wanted::Receivers);
                self.read_if(&args.accuracy.error_weather, Wanted::Weather);
                self.read_if(&args.from, Wanted::Archive);
                let folder = || folder_beside(args.scene.first(), "sun").into();
                let folder = args.output.as_deref().map_or_else(folder, Cow::Borrowed);
                self.outputs.push((folder, Written::Folder(&["receivers.csv"])));
            }
            Command::Pv(args) => {
                self.scene(&args.scene);
                self.read(&args.weather, Wanted::Weather);
                self.read_if(&args.points, Wanted::Other);
                self.read_if(&args.rows, Wanted::Other);
                self.read_if(&args.accuracy.error_weather, Wanted::Weather);
                self.write(&args.output, Written::Folder(&[]));
            }
            Command::Energyplus(args) => {
                self.read(&args.model, Wanted::Scene);
                args.scene.iter().for_each(|file| self.read(file, Wanted::Scene));
                self.read_if(&args.surfaces.materials, Wanted::Other);
                self.read_if(&args.weather, Wanted::Weather);
                self.read_if(&args.accuracy.error_weather, Wanted::Weather);
                self.write(&args.output, Written::Folder(&[]));
            }
            Command::Receivers(args) => {
                self.scene(&args.scene);
                self.write(&args.output, Written::Csv);
                self.write_if(&args.buried, Written::Csv);
                self.read_if(&args.along, Wanted::Other);
            }
            Command::Build(args) => {
                // An atlas is recognised when it is read.
                if args.part.is_none() {
                    self.scene(&args.scene);
                    self.read_if(&args.from, Wanted::Archive);
                }
                self.read_if(&args.receivers, Wanted::Receivers);
                self.read_if(&args.accuracy.error_weather, Wanted::Weather);
                self.read_if(&args.weather, Wanted::Weather);
                self.write_if(&args.output, Written::Archive);
                self.write_if(&args.store, Written::SharedFolder);
            }
            Command::Update(args) => {
                self.read(&args.before, Wanted::Archive);
                args.add.iter().for_each(|file| self.read(file, Wanted::Scene));
                self.read_if(&args.surfaces.materials, Wanted::Other);
                self.write(&args.output, Written::Archive);
            }
            Command::Partition(args) => {
                self.scene(&args.scene);
                self.write(&args.output, Written::Folder(&[]));
            }
            Command::Plan(args) => {
                self.scene(&args.scene);
                self.read(&args.receivers, Wanted::Receivers);
                self.read_if(&args.accuracy.error_weather, Wanted::Weather);
                self.read_if(&args.weather, Wanted::Weather);
            }
            Command::Tradeoff(args) => {
                self.scene(&args.scene);
                self.read(&args.receivers, Wanted::Receivers);
                self.read_if(&args.weather, Wanted::Weather);
                self.write(&args.output, Written::Folder(&["tradeoff.csv"]));
            }
            Command::Query(args) => {
                self.recombined(&args.common);
                self.read(&args.conditions, Wanted::Conditions);
            }
            Command::Replay(args) => {
                self.recombined(&args.common);
                self.read(&args.weather, Wanted::Weather);
                let temperatures = args.period.temperature.iter().filter_map(Temperature::file);
                self.inputs.extend(temperatures.map(|table| (table, Wanted::Other)));
                self.read_if(&args.model, Wanted::Other);
                self.write_if(&args.honeybee, Written::Folder(&[]));
            }
            Command::Compare(args) => {
                self.recombined(&args.common);
                args.after.iter().for_each(|archive| self.read(archive, Wanted::Archive));
                self.read_if(&args.weather, Wanted::Weather);
                self.read_if(&args.conditions, Wanted::Conditions);
                let temperatures = args.period.temperature.iter().filter_map(Temperature::file);
                self.inputs.extend(temperatures.map(|table| (table, Wanted::Other)));
                self.write_if(&args.summary, Written::Table);
                self.write_if(&args.unmatched, Written::Table);
            }
            Command::Sunlight(args) => {
                self.read_table(&args.table);
                self.write(&args.table.output, Written::Results { geo: args.days.geo });
                args.plot.iter().for_each(|picture| self.write(picture, Written::File));
                self.read_if(&args.weather, Wanted::Weather);
                self.read_if(&args.days.before, Wanted::Archive);
            }
            Command::Glare(args) => {
                self.read_table(&args.table);
                self.write(&args.table.output, Written::Results { geo: args.days.geo });
                args.plot.iter().for_each(|picture| self.write(picture, Written::File));
                self.write_if(&args.spells, Written::Table);
                self.write_if(&args.panes, Written::Results { geo: false });
                self.read_if(&args.days.before, Wanted::Archive);
            }
            Command::Comfort(args) => {
                match args.place() {
                    Some(place) => self.read(place, Wanted::Archive),
                    None => self.scene(&args.scene),
                }
                self.read(&args.weather, Wanted::Weather);
                self.read_if(&args.people.points, Wanted::Other);
                self.read_if(&args.accuracy.error_weather, Wanted::Weather);
                self.inputs.extend(args.tables().map(|table| (table, Wanted::Other)));
                self.write(&args.output, Written::Results { geo: args.geo });
                args.plot.iter().for_each(|picture| self.write(picture, Written::File));
            }
            Command::Factors(args) => self.table(&args.table),
            Command::Buildings(args) => {
                self.year(&args.year);
                self.write(&args.output, Written::Table);
                self.write_if(&args.faces, Written::Table);
            }
            Command::Places(args) => {
                self.year(&args.year);
                self.write(&args.output, Written::Table);
            }
            Command::Info(args) => {
                args.files.iter().for_each(|file| self.read(file, Wanted::SceneOrArchive));
                args.rasters.files().for_each(|file| self.read(file, Wanted::Scene));
                self.read_if(&args.surfaces.materials, Wanted::Other);
                self.read_if(&args.weather, Wanted::Weather);
            }
            Command::Verify(args) => self.read(&args.archive, Wanted::Archive),
            Command::Repair(args) => {
                self.read(&args.archive, Wanted::Archive);
                self.scene(&args.scene);
                self.read_if(&args.receivers, Wanted::Receivers);
                self.write_if(&args.output, Written::Archive);
            }
            Command::Audit(args) => {
                self.read(&args.archive, Wanted::Archive);
                self.scene(&args.scene);
                self.read_if(&args.weather, Wanted::Weather);
                self.read_if(&args.conditions, Wanted::Conditions);
                self.write_if(&args.output, Written::Folder(&["audit.csv"]));
            }
            Command::Extract(args) => {
                self.read(&args.archive, Wanted::Archive);
                self.read_if(&args.of.receivers, Wanted::Other);
                self.write(&args.output, Written::Archive);
            }
            Command::Merge(args) => {
                self.read(&args.first, Wanted::Archive);
                self.read(&args.second, Wanted::Archive);
                self.write(&args.output, Written::Archive);
            }
            Command::Diff(args) => {
                self.read(&args.first, Wanted::Archive);
                self.read(&args.second, Wanted::Archive);
            }
            Command::Copy(args) => {
                self.inputs.extend(Some((args.from.as_path(), Wanted::Other)).filter(|from| !is_address(from.0)));
                self.outputs
                    .extend(Some((Cow::Borrowed(args.to.as_path()), Written::File)).filter(|to| !is_address(&to.0)));
            }
            Command::View(args) => {
                self.read(&args.archive, Wanted::Archive);
                self.read_if(&args.weather, Wanted::Weather);
            }
            Command::Export(args) => {
                self.read(&args.archive, Wanted::Archive);
                self.read_if(&args.weather, Wanted::Weather);
                let written = if args.view_factors { Written::Table } else { Written::File };
                self.write(args.output(), written);
            }
            Command::Study(args) => match &args.command {
                StudyCommand::Wall(args) => self.write(&args.output, Written::Folder(&[])),
            },
            Command::Man(args) => self.write(&args.output, Written::Folder(&[])),
            Command::Catalogue(args) => self.read(&args.atlas, Wanted::Other),
            // An atlas is recognised when it is read.
            Command::Find(_) | Command::Store(_) | Command::Completions(_) | Command::Rules(_) => {}
        }
    }

    fn scene(&mut self, args: &'a SceneArgs) {
        args.scene.iter().chain(args.rasters.files()).for_each(|file| self.read(file, Wanted::Scene));
        self.read_if(&args.surfaces.materials, Wanted::Other);
    }

    fn recombined(&mut self, args: &'a RecombineArgs) {
        self.read_table(&args.table);
        self.write(&args.table.output, Written::Results { geo: args.geo });
        args.plot.iter().for_each(|picture| self.write(picture, Written::File));
        self.inputs.extend(args.schedules().map(|table| (table, Wanted::Other)));
    }

    fn table(&mut self, args: &'a TableArgs) {
        self.read_table(args);
        self.write(&args.output, Written::Table);
    }

    fn read_table(&mut self, args: &'a TableArgs) {
        self.read(&args.site.archive, Wanted::Archive);
        self.read_if(&args.of.receivers, Wanted::Other);
    }

    fn read(&mut self, path: &'a Path, wanted: Wanted) {
        self.inputs.push((path, wanted));
    }

    fn read_if(&mut self, path: &'a Option<PathBuf>, wanted: Wanted) {
        self.inputs.extend(path.as_deref().map(|path| (path, wanted)));
    }

    fn write(&mut self, path: &'a Path, written: Written) {
        self.outputs.push((path.into(), written));
    }

    fn year(&mut self, args: &'a YearArgs) {
        self.read(&args.site.archive, Wanted::Archive);
        self.read(&args.weather, Wanted::Weather);
    }

    fn write_if(&mut self, path: &'a Option<PathBuf>, written: Written) {
        self.outputs.extend(path.as_deref().map(|path| (path.into(), written)));
    }
}

fn check_output(path: &Path, written: &Written) -> Result<()> {
    if path == Path::new("-") && !matches!(written, Written::Archive | Written::Folder(_) | Written::SharedFolder) {
        return Ok(());
    }
    if is_address(path) {
        let hint = format!("write a file, and then: heliotile copy FILE {}", shown(path).display());
        return Err(Error::input(&shown(path), None, "is an address, and only `copy` writes to addresses", hint));
    }
    match written {
        Written::Archive => check_archive_name(path)?,
        Written::Table => drop(Format::of(path)?),
        // `replay` names the other formats that it writes.
        Written::Results { .. } if is_city_model(path) => {}
        Written::Results { geo } => drop(ResultFormat::of(path, *geo)?),
        Written::Csv => check_name(path)?,
        Written::Folder(_) | Written::SharedFolder if FILES.contains(&ending(path).as_str()) && !path.is_dir() => {
            let what = "has the ending of a file, and the output is a folder of several files";
            return Err(Error::input(
                path,
                None,
                what,
                format!("give a folder: -o {}", path.with_extension("").display()),
            ));
        }
        Written::Folder(_) | Written::SharedFolder if path.exists() && !path.is_dir() => {
            let what = "is an existing file, and the output is a folder";
            return Err(Error::input(path, None, what, "give the folder another name"));
        }
        // The folder is made together with its parents.
        Written::Folder(_) | Written::SharedFolder => return Ok(()),
        Written::File => {}
    }
    let folder = folder_of(path);
    if folder.is_dir() {
        return Ok(());
    }
    let (what, hint) = match folder.exists() {
        true => (format!("{} is not a folder", folder.display()), "give a path in a folder".into()),
        false => (format!("there is no folder {}", folder.display()), format!("mkdir -p {}", folder.display())),
    };
    Err(Error::input(path, None, what, hint))
}

/// Extensions that no folder is meant to have.
const FILES: [&str; 19] = [
    "helio", "csv", "parquet", "arrow", "feather", "npy", "npz", "json", "geojson", "gpkg", "ply", "obj", "epw",
    "toml", "png", "exr", "svg", "html", "txt",
];

/// Returns the extension of an output's name, in small letters.
fn ending(path: &Path) -> String {
    path.extension().map_or(String::new(), |ending| ending.to_string_lossy().to_lowercase())
}
