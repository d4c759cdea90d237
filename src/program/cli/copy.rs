//! The command line of `copy`.

use std::path::PathBuf;

use clap::Args;

/// Text at the end of `copy --help`.
const ABOUT: &str = "\
At least one of both is an address: s3://BUCKET/NAME, gs://BUCKET/NAME, az://CONTAINER/NAME, and to read from https://HOST/NAME. An object
appears under its name once it is whole, and of two who write it at the same time one is told so. Archives beyond 16 MiB go to
NAME.ROOT.helio, and under the name stands a small pointer that every command follows. Of an atlas, its folder or its address goes as a whole,
atlas.json last; what is there and is the same stays, so the same command goes on after an interruption. Credentials are those of the
environment: src/book/remote.md.";

#[derive(Args, Debug)]
#[command(after_long_help = ABOUT)]
pub struct CopyArgs {
    /// Archive, another file, or the folder of an atlas: a path or an address
    #[arg(value_name = "FROM")]
    pub from: PathBuf,
    /// Destination: a path or an address
    #[arg(value_name = "TO")]
    pub to: PathBuf,
    /// Replace what is there
    #[arg(long)]
    pub replace: bool,
}
