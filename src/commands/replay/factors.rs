//! `heliotile factors`: an archive -> what surroundings reflect over the sun's position -> a table.

use super::chosen::{Chosen, guard};
use super::sources::{Sources, say_north};
use crate::cli::FactorsArgs;
use crate::commands::terminal::Terminal;
use crate::commands::{Outcome, invocation, temporary_files};
use crate::outputs::factors::FactorTable;
use crate::outputs::groups::{GroupMeans, Groups};
use crate::outputs::tables::layout::By;
use heliotile_builder::observer::Stage;
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::{MemoryBudget, Use};
use heliotile_core::replay::factors::{Factors, PARTS, SunGrid};
use heliotile_core::replay::run::ReplaySettings;
use heliotile_core::replay::values::TileValues;

/// `heliotile factors`.
pub fn run(args: &FactorsArgs) -> Result<Outcome> {
    let asked = &args.table;
    guard(asked, &[])?;
    FactorTable::check(&asked.output)?;
    let grid = SunGrid::new(args.azimuth_step, args.altitude_step);
    let hint = "give divisors of 360 and 90, such as 10 and 5";
    let grid = grid.map_err(|what| Error::argument("--azimuth-step, --altitude-step", what, hint))?;
    let sources = Sources::open(asked)?;
    let archives = sources.borrowed();
    say_north(asked, archives.manifest());
    let chosen = Chosen::of(asked, archives)?;
    let (Some(archive), [part]) = (archives.only(), chosen.parts()) else {
        let what = "is an atlas of several parts, and factors are of one archive";
        return Err(Error::input(&asked.archive, None, what, "name the site.helio of one of its parts"));
    };
    let budget = MemoryBudget::new(asked.memory.0);
    let storage = temporary_files();
    let settings = ReplaySettings {
        patches: archive.manifest().settings.patches(),
        memory: budget,
        storage: &storage,
        ..ReplaySettings::default()
    };
    let factors = Factors::new(&part.site, grid, settings)?;
    let mut means = match asked.by {
        By::Receiver => None,
        by => {
            let groups = Groups::new(chosen.receivers(), by, &asked.archive)?;
            Some(GroupMeans::new(groups, &PARTS, factors.labels(), budget.share(Use::SurfaceSums))?)
        }
    };
    let about = invocation::provenance().with_archive(&asked.archive, archive);
    let mut table = FactorTable::create(&asked.output, asked.by.name(), factors.grid(), &about)?;
    let mut write = |names: &[String], values: &TileValues| {
        let mut rows = names.iter().enumerate();
        rows.try_for_each(|(i, name)| table.write(name, factors.of(|part| values.row(part, i))))?;
        Ok::<bool, Error>(table.is_closed())
    };
    let terminal = Terminal::default();
    let progress = Stage::begin(&terminal, "receivers", Some(chosen.count()));
    let results = factors.irradiances().results(part.tiles().iter().map(|tile| tile.number));
    for (tile, result) in part.tiles().iter().zip(results) {
        let (receivers, values) = part.results(*tile, result?);
        progress.advance(receivers.len() as u64);
        match &mut means {
            Some(means) => means.add(&values),
            None if write(&receivers, &values)? => break,
            None => {}
        }
    }
    for (names, values, _) in means.iter().flat_map(GroupMeans::tiles) {
        write(&names, &values)?;
    }
    drop(progress);
    table.finish()?;
    Ok(Outcome::Fine)
}
