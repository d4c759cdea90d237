//! `heliotile factors`: an archive -> what surroundings reflect over the sun's position -> a table.

use super::chosen::{choose, guard};
use super::sources::{self, say_north};
use crate::cli::FactorsArgs;
use crate::commands::terminal::Terminal;
use crate::commands::{Outcome, invocation, temporary_files};
use crate::outputs::factors::FactorTable;
use crate::recombine::FactorRows;
use heliotile_core::error::Result;
use heliotile_core::memory::MemoryBudget;

/// `heliotile factors`.
pub fn run(args: &FactorsArgs) -> Result<Outcome> {
    let asked = &args.table;
    guard(asked, &[])?;
    FactorTable::check(&asked.output)?;
    let sources = sources::open(asked)?;
    let archives = sources.borrowed();
    say_north(asked, archives.manifest());
    let chosen = choose(asked, archives)?;
    let storage = temporary_files();
    let steps_deg = (args.azimuth_step, args.altitude_step);
    let room = (MemoryBudget::new(asked.memory.0), &storage as _);
    let rows = FactorRows::new(&chosen, steps_deg, asked.by, room)?;
    let about = archives.told_in(invocation::provenance(), &asked.archive);
    let mut table = FactorTable::create(&asked.output, asked.by.name(), rows.grid(), &about)?;
    rows.each(&Terminal::default(), |name, factors| {
        table.write(name, factors)?;
        Ok(!table.is_closed())
    })?;
    table.finish()?;
    Ok(Outcome::Fine)
}
