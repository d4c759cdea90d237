//! The commands: their names, what they do, and the fields of their requests. Every face lists them
//! from here.

use heliotile_atlas::VerifyRequest;
use heliotile_atlas::partition::PartitionRequest;
#[cfg(test)]
use heliotile_core::error::Result;
use heliotile_requests::{Group, Request, Row};
use heliotile_results::ReportRequest;

use super::*;

/// A command: a request that a user can make.
#[derive(Clone, Copy, Debug)]
pub struct Command {
    /// Name of the command: a word, or two if it belongs to a group.
    pub name: &'static str,
    /// Its purpose in a sentence.
    pub about: &'static str,
    /// Group of commands that it belongs to.
    pub aim: Aim,
    /// Fields of its request.
    pub rows: fn() -> Vec<Row>,
    /// Fields that exclude or need each other.
    pub groups: fn() -> Vec<Group>,
    /// Fills and checks its request, without running it.
    #[cfg(test)]
    pub check: fn(&Given) -> Result<()>,
}

/// Groups of commands by purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aim {
    /// From files to an archive or to results.
    Start,
    /// Light of an archive.
    Ask,
    /// Contents of files, and how far they can be trusted.
    Check,
    /// Archives and pages for others.
    Share,
    /// Sites that are built in parts.
    Large,
}

impl Aim {
    /// Aims and their headings, in the order of lists.
    pub const ALL: [(Aim, &'static str); 5] = [
        (Aim::Start, "Start: from files of a site to results"),
        (Aim::Ask, "Ask: light of a site that is traced"),
        (Aim::Check, "Check: what files hold, and what accuracy costs"),
        (Aim::Share, "Share: pages and archives for others"),
        (Aim::Large, "Large sites: parts that are built one by one"),
    ];
}

/// Names that several commands begin with, and what these do.
pub const GROUPS: [(&str, &str); 2] = [
    ("archive", "Verify, audit, repair, extract, merge, compare (diff) and copy archives"),
    ("atlas", "Cut a region into parts, find them, and list them in a catalogue"),
];

macro_rules! commands {
    ($(($name:literal, $request:ty, $aim:ident, $about:literal)),+ $(,)?) => {
        /// All commands, by aim.
        pub const COMMANDS: &[Command] = &[$(Command {
            name: $name,
            about: $about,
            aim: Aim::$aim,
            rows: <$request as Request>::rows,
            groups: <$request as Request>::groups,
            #[cfg(test)]
            check: |given| prepared::<$request>(given, &[], &|_| false).map(drop),
        }),+];

        /// Fields of each command whose stated default is not that of the request.
        #[cfg(test)]
        fn odd_defaults() -> Vec<String> {
            [$(tests::odd::<$request>($name)),+].concat()
        }
    };
}

commands![
    (
        "run",
        Run,
        Start,
        "Compute a year of solar irradiation from scene files with one command: receivers, archive, sums, pictures, a page"
    ),
    (
        "pv",
        Pv,
        Start,
        "Compute hourly irradiance on both sides of solar modules, with shading losses, horizons, the best tilt and azimuth, energy and money"
    ),
    (
        "energyplus",
        Energyplus,
        Start,
        "Add the sunlight that its surroundings reflect to an EnergyPlus model; an unmodified EnergyPlus then runs it with any weather"
    ),
    (
        "receivers",
        Receivers,
        Start,
        "Cover the surfaces of a scene with receivers: the points at which light is computed"
    ),
    ("build", Build, Start, "Trace once what every receiver of a scene sees, and store it in an archive"),
    (
        "update",
        Update,
        Start,
        "Edit the scene of an archive: add, remove, move, raise or repaint objects. Only light that the edits can alter is traced again"
    ),
    (
        "replay",
        Replay,
        Ask,
        "Compute the irradiance of every receiver through a weather file, by hour or as sums, or under given suns and skies"
    ),
    (
        "compare",
        Compare,
        Ask,
        "Compare the light of a site before and after a change: both values, their difference, and a summary of the losses"
    ),
    (
        "sunlight",
        Sunlight,
        Ask,
        "Compute hours of possible sun on given days, and check rules for windows, facades and gardens"
    ),
    (
        "glare",
        Glare,
        Ask,
        "Find when mirrors and glass facades reflect the sun to receivers, and which pane does, and check rules on glare"
    ),
    (
        "envelope",
        Envelope,
        Ask,
        "Find the largest building on a plot that leaves the receivers around it hours of sun, as a table of heights and a mesh"
    ),
    (
        "shading",
        Shading,
        Ask,
        "Compute who takes the sun: the direct light of sun and sky that each building, tree and terrain takes from receivers, and the light that it reflects to them"
    ),
    (
        "comfort",
        Comfort,
        Ask,
        "Compute thermal comfort of people outdoors: mean radiant temperature, UTCI and PET at points of a site, by hour or over periods"
    ),
    (
        "energyplus factors",
        Factors,
        Ask,
        "Compute EnergyPlus's reflection factors: the light that surroundings reflect to receivers or surfaces, by position of the sun"
    ),
    (
        "buildings",
        Buildings,
        Ask,
        "Write a solar cadastre of buildings and roof faces: usable area, sums by orientation, best usable region"
    ),
    ("places", Places, Ask, "Find the best places for modules on roofs and facades, as points that `pv` reads"),
    ("info", Info, Check, "Describe an archive, an atlas, scene files, a weather file or a rule"),
    ("archive verify", VerifyRequest, Share, "Check every block of an archive; exit code 1 if one is damaged"),
    (
        "archive audit",
        Audit,
        Share,
        "Check an archive against an independent reference path tracer for random receivers and hours; exit code 1 if the error is larger than the archive states"
    ),
    (
        "tradeoff",
        Tradeoff,
        Check,
        "Measure the time and error of each accuracy level on some receivers of a site, as tables, pictures and a page"
    ),
    ("archive diff", Diff, Share, "List the differences of two archives; exit code 1 if they differ"),
    ("archive repair", Repair, Share, "Trace the damaged parts of an archive again"),
    (
        "report",
        ReportRequest,
        Share,
        "Write a statement about tables of results for a person who decides, as one page that prints well: question, rule, results, uncertainty, and how to check them"
    ),
    (
        "view",
        View,
        Share,
        "Show an archive in the browser of this machine: any sun, sky, weather and reflectance, live"
    ),
    (
        "export",
        Export,
        Share,
        "Export what a receiver sees as images, view factors of all receivers as a table, or a page that shows the archive"
    ),
    ("archive extract", Extract, Share, "Write some receivers of an archive into a new archive"),
    ("archive merge", Merge, Share, "Write the union of two archives of one scene"),
    ("archive copy", Copy, Share, "Copy an archive or an atlas to or from an object store, or from a web server"),
    (
        "atlas partition",
        PartitionRequest,
        Large,
        "Cut a region into parts (an atlas) that are built one by one, on any machines, and then queried like one archive"
    ),
    ("atlas find", Find, Large, "List the parts of an atlas that touch a box"),
    (
        "atlas catalogue",
        Catalogue,
        Large,
        "Write a static STAC catalogue of the parts of an atlas, with pictures and a page"
    ),
];

impl Command {
    /// Returns the command of a name.
    pub fn by_name(name: &str) -> Option<&'static Command> {
        COMMANDS.iter().find(|command| command.name == name)
    }

    /// Returns the last word of the name, which no other command has.
    pub fn last_word(&self) -> &'static str {
        self.name.rsplit(' ').next().unwrap_or(self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_requests::Many;

    /// Returns the fields that change when they are filled with their stated default.
    pub fn odd<R: Request + Default + std::fmt::Debug>(command: &str) -> Vec<String> {
        let usual = format!("{:?}", R::default());
        let is_odd = |row: &Row| {
            let Some(texts) = row.default_texts().filter(|_| row.many != Many::Optional) else { return false };
            let mut request = R::default();
            request.fill(row.name, &texts).is_err() || format!("{request:?}") != usual
        };
        R::rows().iter().filter(|row| is_odd(row)).map(|row| format!("{command} {}", row.name)).collect()
    }

    /// Defaults that faces show are those of the requests: of all fields of 31 commands none
    /// differs.
    #[test]
    fn stated_defaults_are_those_of_requests() {
        assert_eq!(odd_defaults(), Vec::<String>::new());
    }
}
