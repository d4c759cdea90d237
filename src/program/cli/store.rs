//! Arguments of `store`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use heliotile::Bytes;

#[derive(Args, Debug)]
pub struct StoreArgs {
    #[command(subcommand)]
    pub command: StoreCommand,
}

#[derive(Debug, Subcommand)]
pub enum StoreCommand {
    /// List the archives of a store, least recently used first
    Ls {
        /// Folder of the store
        folder: PathBuf,
    },
    /// Remove the least recently used archives of a store
    Gc {
        /// Folder of the store
        folder: PathBuf,
        /// Largest total size of the archives that stay, such as 10GiB
        #[arg(long)]
        keep: Bytes,
    },
    /// Check every archive of a store; exit code 1 if one is damaged
    Verify {
        /// Folder of the store
        folder: PathBuf,
    },
}
