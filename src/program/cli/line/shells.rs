//! Arguments of `completions` and `man`.

use std::path::PathBuf;

use clap::Args;
use clap_complete::Shell;

#[derive(Args, Debug)]
pub struct CompletionsArgs {
    /// Shell to complete in; its script goes to standard output
    #[arg(value_enum)]
    pub shell: Shell,
}

#[derive(Args, Debug)]
pub struct ManArgs {
    /// Folder to write the pages heliotile.1, heliotile-run.1 and so on into; created if it does
    /// not exist
    #[arg(long, short, value_name = "FOLDER")]
    pub output: PathBuf,
}
