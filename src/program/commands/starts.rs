//! How each command starts. In: a command with the texts of its fields. Out: the command ran.

use super::{
    Outcome, atlas, build, comfort, copy, export, inspect, pv, receivers, replay, run, start, sunlight, transfer, view,
};
use heliotile::atlas::{PartitionRequest, VerifyRequest};
use heliotile::cases::{self, *};
use heliotile::{Provenance, ReportRequest, Result};

/// Fills the request of a command and runs it.
type Start = fn(&Given, Provenance) -> Result<Outcome>;

macro_rules! runs {
    ($(($name:literal, $request:ty, $run:path)),+ $(,)?) => {
        /// How each command starts.
        const RUNS: &[(&str, Start)] =
            &[$(($name, |given, about| start::<$request>(given, about, $run))),+];
    };
}

runs![
    ("run", Run, run::run),
    ("pv", Pv, pv::run),
    ("energyplus", Energyplus, run::energyplus),
    ("receivers", Receivers, receivers::run),
    ("build", Build, build::run),
    ("update", Update, transfer::update),
    ("replay", Replay, replay::replay),
    ("compare", Compare, replay::compare),
    ("sunlight", Sunlight, sunlight::run),
    ("glare", Glare, sunlight::glare),
    ("envelope", Envelope, sunlight::envelope),
    ("shading", Shading, replay::shading),
    ("comfort", Comfort, comfort::run),
    ("energyplus factors", Factors, replay::factors),
    ("buildings", Buildings, replay::buildings),
    ("places", Places, replay::places),
    ("info", Info, inspect::info),
    ("archive verify", VerifyRequest, inspect::verify),
    ("archive audit", Audit, transfer::audit),
    ("tradeoff", Tradeoff, run::tradeoff),
    ("archive diff", Diff, transfer::diff),
    ("archive repair", Repair, transfer::repair),
    ("report", ReportRequest, export::report),
    ("view", View, view::run),
    ("export", Export, export::run),
    ("archive extract", Extract, transfer::extract),
    ("archive merge", Merge, transfer::merge),
    ("archive copy", Copy, copy::run),
    ("atlas partition", PartitionRequest, atlas::partition),
    ("atlas find", Find, atlas::find),
    ("atlas catalogue", Catalogue, atlas::catalogue),
];

/// Runs a command.
pub fn carry_out(command: &cases::Command, given: &Given, about: Provenance) -> Result<Outcome> {
    let start = RUNS.iter().find(|(name, _)| *name == command.name).map(|(_, start)| start);
    start.map_or(Ok(Outcome::Fine), |start| start(given, about))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each command of the library starts, and has no other start.
    #[test]
    fn every_command_starts() {
        let names: Vec<&str> = cases::COMMANDS.iter().map(|command| command.name).collect();
        assert_eq!(names, RUNS.iter().map(|(name, _)| *name).collect::<Vec<_>>());
    }
}
