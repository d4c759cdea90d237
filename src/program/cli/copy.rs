//! The command line of `copy`.

use std::path::PathBuf;

use clap::Args;

/// Text at the end of `copy --help`.
const ABOUT: &str = "\
FROM, TO or both are addresses: s3://BUCKET/NAME, gs://BUCKET/NAME or az://CONTAINER/NAME; https://HOST/NAME can only be read. An object
appears under its name when it is complete. If two programs write one name at the same time, one succeeds and the other reports an error. An
archive of more than 16 MiB is stored as NAME.ROOT.helio, and NAME is a small pointer that every command follows. An atlas, named by its folder
or address, is copied as a whole, atlas.json last. Files that are already there and equal are not sent again, so the same command resumes an
interrupted copy. Credentials come from environment variables: see src/book/remote.md.";

#[derive(Args, Debug)]
#[command(after_long_help = ABOUT)]
pub struct CopyArgs {
    /// Source: an archive, another file, or the folder of an atlas; a path or an address
    #[arg(value_name = "FROM")]
    pub from: PathBuf,
    /// Destination: a path or an address
    #[arg(value_name = "TO")]
    pub to: PathBuf,
    /// Replace what the destination holds
    #[arg(long)]
    pub replace: bool,
}
