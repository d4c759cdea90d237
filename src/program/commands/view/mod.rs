//! `heliotile view`: an archive, two of them, or the parts of an atlas in the browser. In:
//! archives, weather. Out: a page on an address of this machine, until Ctrl-C.

mod server;

use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::Path;

use super::console::terminal::Terminal;
use super::console::voice::tell_waiting;
use super::{Outcome, remark, warn};
use heliotile::archive::{OpenSite, hold, open_archive};
use heliotile::atlas::{Atlas, PARTS, archive_of, built, list};
use heliotile::cases::View;
use heliotile::output::{ViewerPage, packed};
use heliotile::remote::{is_address, shown};
use heliotile::requests::Problem;
use heliotile::scene::{input, read_weather_as};
use heliotile::tables::open_after;
use heliotile::weather::far_apart;
use heliotile::{Access, Error, Provenance, Result};
use server::{Served, ServedArchive, serve};

/// Default port of the page; if it is taken, any free port is used.
const PORT: u16 = 8017;

/// `heliotile view`.
pub fn run(args: &View, _: Provenance) -> Result<Outcome> {
    // The first archive is shown first; the page itself opens the others.
    let (parts, first) = match Atlas::find(&args.page.archive)? {
        Some(atlas) if atlas.folder.is_remote() => {
            let hint = "copy the atlas to a folder, or open its view.html, which `atlas catalogue` writes and `archive copy` uploads";
            return Err(Error::input(&atlas.shown(), None, "is a remote atlas, and only local ones are served", hint));
        }
        Some(atlas) => {
            (atlas.parts(None)?, built(&atlas)?.into_iter().next().map(|(_, path)| path).unwrap_or_default())
        }
        None => (Vec::new(), args.page.archive.clone()),
    };
    let archive = open_archive(&first, Access::Read)?;
    OpenSite::open(&archive)?;
    let mut page = match parts.is_empty() {
        true => ViewerPage::default().with_option("archive", server::ARCHIVE),
        false => ViewerPage::default().with_option("parts", PARTS),
    };
    let mut after = None;
    if let Some(place) = &args.page.with {
        if !parts.is_empty() {
            let what = "is an atlas, and only archives are shown before and after a change";
            return Err(Error::input(
                &args.page.archive,
                None,
                what,
                "give the site.helio of a part, and with {with} that of the part after the change",
            )
            .because(Problem::other_kind("atlas")));
        }
        let opened = open_after(&archive, place, Access::Read, &Terminal::default())?;
        page = page.with_option("after", server::AFTER);
        after = Some(served(place, opened.path())?);
    }
    let mut weather = None;
    if let Some(path) = &args.page.weather {
        let place = archive.manifest().place;
        let read = read_weather_as(path, &args.page.about_weather, &mut || Ok(place))?;
        read.report.warnings.iter().for_each(warn);
        place.and_then(|place| far_apart(&place, &read)).iter().for_each(warn);
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        page = page.with_option("weather", server::WEATHER).with_option("weatherName", name);
        page = page.with_weather_options(&args.page.about_weather);
        weather = Some(input::read(path)?);
    }
    let listener = listen(args.port)?;
    let address = listener.local_addr().map_err(Error::io(archive.path(), "find an address for"))?;
    remark(format!("{} is shown at http://{address}/ until Ctrl-C\n", shown(&args.page.archive).display()))?;
    let page = page.html();
    let packed_page = packed(page.as_bytes()).map_err(Error::io(archive.path(), "pack the page of"))?;
    let archive = match parts.is_empty() {
        true => served(&args.page.archive, archive.path())?,
        false => {
            let files =
                parts.iter().filter_map(|part| archive_of(part).map(|(at, path)| (format!("/{at}"), path.clone())));
            ServedArchive::Parts { list: list(&parts), files: files.collect() }
        }
    };
    // The page is served until the program is stopped.
    tell_waiting();
    serve(listener, Served { page, packed_page, archive, after, weather })?;
    Ok(Outcome::Fine)
}

/// Returns the way to serve the archive at a place; `path` is its file unless the place is an
/// address.
fn served(place: &Path, path: &Path) -> Result<ServedArchive> {
    Ok(match is_address(place) {
        true => ServedArchive::Held(hold(place)?.into()),
        false => ServedArchive::File(path.to_path_buf()),
    })
}

/// Listens on the given port, or on the default one, or on any free one.
fn listen(port: Option<u16>) -> Result<TcpListener> {
    let bind = |port| TcpListener::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, port)));
    match port {
        Some(port) => bind(port).map_err(|error| {
            Error::argument(
                "--port",
                format!("port {port} cannot be used: {error}"),
                "leave the option out to use a free port",
            )
        }),
        None => bind(PORT).or_else(|_| bind(0)).map_err(|error| {
            Error::argument("--port", format!("no free port is available: {error}"), "give a port with --port")
        }),
    }
}
