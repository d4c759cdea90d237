//! Options of all commands: which messages are printed, and how many threads do the work.

use clap::Args;

#[derive(Args, Debug)]
#[command(next_help_heading = "Options of all commands")]
pub struct EverywhereArgs {
    /// Print only results, warnings and errors: no progress, no notes, no remarks on what was done
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Print how results were made too: receivers by surface, effects, rays, times and the root of
    /// the archive; also the full lists behind warnings, and the traffic with remote archives
    #[arg(long, short, global = true, conflicts_with = "quiet")]
    pub verbose: bool,
    /// Number of threads, 1 to 1024; results do not depend on it [default: all processors]
    #[arg(long, value_name = "N", global = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}
