//! Which receivers a command line asks for. In: arguments, a file of ids. Out: those of the archives that count.

use std::path::Path;

use super::sources::{Archives, site_of};
use crate::cli::TableArgs;
use crate::commands::guard_output;
use crate::outputs::tables::writer::files_of;
use crate::recombine::Chosen;
use heliotile_builder::writing::copy::folder_of;
use heliotile_core::error::Result;
use heliotile_core::memory::{MemoryBudget, Use};
use heliotile_core::opened::OpenSite;

/// The receivers of a command line.
pub fn choose<'a>(args: &TableArgs, archives: Archives<'a>) -> Result<Chosen<'a>> {
    let sites: Vec<OpenSite> = archives.iter().map(|archive| site_of(args, archive)).collect::<Result<_>>()?;
    let kept = args.of.selection().map(|selection| {
        let folder = if args.output == Path::new("-") { std::env::temp_dir() } else { folder_of(&args.output).into() };
        let budget = MemoryBudget::new(args.memory.0).length(Use::ReceiverList);
        selection.resolve(&sites, &folder, budget)
    });
    Ok(Chosen::new(archives.iter().zip(sites), kept.transpose()?))
}

/// Refuses an output that is an input.
pub fn guard(args: &TableArgs, forcing: &[&Path]) -> Result<()> {
    let mut inputs = vec![args.archive.as_path()];
    inputs.extend(forcing);
    inputs.extend(args.of.receivers.as_deref());
    match args.output == Path::new("-") {
        true => Ok(()),
        false => files_of(&args.output).iter().try_for_each(|file| guard_output(file, &inputs)),
    }
}
