//! Archives in object stores and on web servers (feature `remote`), against a small store on this
//! machine that can be made to fail.

mod atlas;
mod copying;
mod reading;
mod server;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::LazyLock;

use crate::cli::{Folder, golden, stderr};
use server::Store;

/// A block of The Hague in an archive of 2.4 MB, traced once for all tests here; beside it
/// `some.csv`, a list of some of its receivers.
static HAGUE: LazyLock<(Folder, Vec<u8>)> = LazyLock::new(|| {
    let folder = Folder::new();
    fs::copy(golden(), folder.path("w.epw")).expect("copied");
    let model = Path::new(crate::ROOT).join("tests/data/cityjson/hague.city.json");
    let ran = folder.run(&format!("run {} --weather w.epw -o hague", model.display()));
    assert!(ran.status.success(), "{}", stderr(&ran));
    let table = fs::read_to_string(folder.path("hague/receivers.csv")).expect("receivers");
    let ids = table.lines().take(200).filter_map(|line| line.split(',').next());
    folder.write("some.csv", &ids.map(|id| format!("{id}\n")).collect::<String>());
    fs::copy(folder.path("hague/site.helio"), folder.path("site.helio")).expect("copied");
    let bytes = fs::read(folder.path("site.helio")).expect("an archive");
    (folder, bytes)
});

/// Returns a folder with that archive, weather and conditions, and a store with it, too.
fn hague() -> (Folder, Store) {
    let (folder, store) = (Folder::new(), Store::new());
    for name in ["site.helio", "w.epw", "some.csv"] {
        fs::copy(HAGUE.0.path(name), folder.path(name)).expect("copied");
    }
    store.put("bucket/site.helio", HAGUE.1.clone());
    (folder, store)
}

/// Returns a command that reaches the store as S3, waits 2 s for an answer, and keeps blocks in the
/// folder `cache` if asked to.
fn afar(folder: &Folder, store: &Store, arguments: &str, cached: bool) -> Command {
    let mut command = folder.command(arguments);
    command.env("AWS_ENDPOINT_URL", format!("http://{}", store.address)).env("AWS_REGION", "eu-west-1");
    command.env("AWS_ACCESS_KEY_ID", "me").env("AWS_SECRET_ACCESS_KEY", "s3cret").env("HELIOTILE_TIMEOUT", "2");
    let cache = if cached { folder.path("cache").into_os_string() } else { "off".into() };
    command.env("HELIOTILE_CACHE", cache).env_remove("HELIOTILE_CACHE_SIZE");
    command
}

fn run(folder: &Folder, store: &Store, arguments: &str) -> Output {
    afar(folder, store, arguments, false).output().expect("the program")
}
