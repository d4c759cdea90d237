//! The page: served, and as a file.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Stdio};

use crate::cli::{Folder, golden, stderr, stdout};

/// A program that serves until the test ends.
struct Served {
    child: Child,
    address: String,
}

impl Served {
    fn new(folder: &Folder, arguments: &str) -> Self {
        let mut child = folder.command(arguments).stdout(Stdio::piped()).spawn().expect("the program");
        let mut line = String::new();
        BufReader::new(child.stdout.take().expect("an output")).read_line(&mut line).expect("a line");
        let address = line.split("http://").nth(1).and_then(|rest| rest.split('/').next()).expect("an address");
        Served { address: address.to_owned(), child }
    }

    /// Sends a request with some headers; returns status, headers in lower case, and body.
    fn ask(&self, method: &str, path: &str, headers: &[(&str, &str)]) -> (u16, String, Vec<u8>) {
        let mut stream = TcpStream::connect(&self.address).expect("a connection");
        let host = headers.iter().all(|header| header.0 != "Host").then(|| format!("Host: {}\r\n", self.address));
        let more: String = headers.iter().map(|(name, value)| format!("{name}: {value}\r\n")).collect();
        let request =
            format!("{method} {path} HTTP/1.1\r\n{}{more}Connection: close\r\n\r\n", host.unwrap_or_default());
        stream.write_all(request.as_bytes()).expect("asked");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("an answer");
        let end = answer.windows(4).position(|bytes| bytes == b"\r\n\r\n").expect("a head");
        let head = String::from_utf8_lossy(&answer[..end]).to_lowercase();
        let status = head.split(' ').nth(1).and_then(|status| status.parse().ok()).expect("a status");
        (status, head, answer[end + 4..].to_vec())
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        // The program may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// `view` answers on 127.0.0.1 with the page, compressed below 1.3 MB for browsers that accept it,
/// the archive by ranges with an ETag, and the weather. 6 other paths, 3 foreign hosts and other
/// methods get none of it.
#[test]
fn view_serves_its_own_files() {
    let folder = Folder::new();
    folder.build();
    let weather = fs::read(golden()).expect("weather");
    fs::write(folder.path("w.epw"), &weather).expect("written");
    let served = Served::new(&folder, "view site.helio --weather w.epw --port 0");
    assert!(served.address.starts_with("127.0.0.1:"), "{}", served.address);
    let archive = fs::read(folder.path("site.helio")).expect("an archive");
    let (status, head, body) = served.ask("GET", "/", &[]);
    let page = String::from_utf8(body).expect("text");
    assert!(status == 200 && head.contains("text/html") && head.contains("nosniff"), "{head}");
    assert!(page.contains("\"archive\":\"site.helio\"") && page.contains("\"weather\":\"weather\""));
    assert!(page.contains("Content-Security-Policy"));
    for (accepted, is_packed) in [("br, gzip;q=0.8", true), ("gzip", true), ("gzip;q=0, br", false), ("br", false)] {
        let (_, head, body) = served.ask("GET", "/", &[("Accept-Encoding", accepted)]);
        assert_eq!(head.contains("content-encoding: gzip"), is_packed, "{accepted}");
        let mut unpacked = String::new();
        match is_packed {
            true => flate2::read::GzDecoder::new(body.as_slice()).read_to_string(&mut unpacked),
            false => body.as_slice().read_to_string(&mut unpacked),
        }
        .expect("the page");
        assert!(unpacked == page && (body.len() < 1_300_000) == is_packed, "{accepted}: {}", body.len());
    }
    let (status, head, body) = served.ask("GET", "/site.helio", &[("Range", "bytes=100-299")]);
    assert!(status == 206 && head.contains("etag:") && head.contains(&format!("bytes 100-299/{}", archive.len())));
    assert!(body == archive[100..300]);
    assert!(served.ask("GET", "/site.helio", &[]).2 == archive);
    assert!(served.ask("GET", "/weather", &[]).2 == weather);
    for path in ["/scene.obj", "/receivers.csv", "/../scene.obj", "/%2e%2e/scene.obj", "/site.helio/..", "//etc/passwd"]
    {
        assert_eq!(served.ask("GET", path, &[]).0, 404, "{path}");
    }
    for host in ["example.org", "127.0.0.1", "localhost:1"] {
        let (status, _, body) = served.ask("GET", "/site.helio", &[("Host", host)]);
        assert!(status == 403 && body.len() < 100, "{host}: {status}");
    }
    let local = served.address.replace("127.0.0.1", "localhost");
    assert_eq!(served.ask("GET", "/", &[("Host", &local)]).0, 200);
    assert!([404, 405].contains(&served.ask("POST", "/site.helio", &[]).0));
    assert!(fs::read(folder.path("site.helio")).expect("an archive") == archive);
}

/// For an atlas with two of its four parts built, `view` serves the page, the list of parts and the
/// archives of the built ones by ranges. A part that is not built, receivers, the plan and 4 other
/// paths are not found.
#[test]
fn view_serves_the_parts_of_an_atlas() {
    let folder = Folder::new();
    let model = std::path::Path::new(crate::ROOT).join("tests/data/cityjson/hague.city.json");
    let cut = "--crs EPSG:28992 --spacing 4m --quality draft --part-size 45m --sample 0 -o atlas";
    assert!(folder.run(&format!("atlas partition {} {cut}", model.display())).status.success());
    folder.fails("view atlas --port 0", "input lacks atlas parts");
    for part in ["x1749_y10177", "x1750_y10177"] {
        assert!(folder.run(&format!("build atlas --part {part}")).status.success());
    }
    let served = Served::new(&folder, "view atlas --port 0");
    let page = String::from_utf8(served.ask("GET", "/", &[]).2).expect("text");
    assert!(page.contains("{\"parts\":\"parts.json\"}"));
    let list: serde_json::Value = serde_json::from_slice(&served.ask("GET", "/parts.json", &[]).2).expect("JSON");
    let states: Vec<_> = list["parts"].as_array().expect("parts").iter().map(|part| &part["state"]).collect();
    assert_eq!(states, ["missing", "built", "missing", "built"]);
    let place = "parts/x1749_y10177/site.helio";
    assert!(list["parts"][1]["archive"] == place && list["parts"][0]["archive"].is_null());
    let archive = fs::read(folder.path("atlas").join(place)).expect("an archive");
    let (status, head, body) = served.ask("GET", &format!("/{place}"), &[("Range", "bytes=100-299")]);
    assert!(status == 206 && head.contains(&format!("bytes 100-299/{}", archive.len())), "{head}");
    assert!(body == archive[100..300]);
    for path in [
        "/parts/x1749_y10176/site.helio",
        "/parts/x1749_y10177/receivers.csv",
        "/atlas.json",
        "/site.helio",
        "/parts/%2e%2e/atlas.json",
        "/parts/../atlas.json",
        "/parts/x1749_y10177%2fsite.helio",
    ] {
        assert_eq!(served.ask("GET", path, &[]).0, 404, "{path}");
    }
}

/// Builds an archive of other receivers or at another place.
fn another(folder: &Folder, name: &str, receivers: &str, more: &str) {
    folder.write("others.csv", receivers);
    let built =
        folder.run(&format!("build scene.obj --materials materials.toml --receivers others.csv {more} -o {name}"));
    assert!(built.status.success(), "{}", stderr(&built));
}

/// Two receivers of the site and a new one.
const CHANGED: &str = "receiver,x,y,z,nx,ny,nz\na,5,5,10.02,0,0,1\nb,5,-0.02,4,0,-1,0\nc,15,9,0.02,0,0,1\n";
const ELSEWHERE: &str = "receiver,x,y,z,nx,ny,nz\nx,12,9,0.02,0,0,1\n";

/// `view --with` serves the page, which names both archives, and the bytes of both by ranges;
/// `export --with` writes one file that holds both, each under its name. For equal archives there
/// is a warning and a page.
#[test]
fn view_shows_two_archives_on_one_page() {
    let folder = Folder::new();
    folder.build();
    another(&folder, "changed.helio", CHANGED, "");
    let served = Served::new(&folder, "view site.helio --with changed.helio --port 0");
    let page = String::from_utf8(served.ask("GET", "/", &[]).2).expect("text");
    assert!(page.contains("\"archive\":\"site.helio\"") && page.contains("\"after\":\"after.helio\""));
    for (name, file) in [("/site.helio", "site.helio"), ("/after.helio", "changed.helio")] {
        let bytes = fs::read(folder.path(file)).expect("an archive");
        let (status, head, body) = served.ask("GET", name, &[("Range", "bytes=100-299")]);
        assert!(status == 206 && head.contains(&format!("bytes 100-299/{}", bytes.len())), "{head}");
        assert!(body == bytes[100..300]);
    }
    assert_eq!(served.ask("GET", "/changed.helio", &[]).0, 404);
    let alone = Served::new(&folder, "view site.helio --port 0");
    assert_eq!(alone.ask("GET", "/after.helio", &[]).0, 404);

    let output = folder.run("export site.helio --html page.html --with changed.helio");
    assert!(output.status.success() && stderr(&output).is_empty(), "{}", stderr(&output));
    let page = fs::read_to_string(folder.path("page.html")).expect("a page");
    assert!(page.contains("id=\"archive\" data-name=\"site.helio\""));
    assert!(page.contains("id=\"after\" data-name=\"changed.helio\""));
    fs::copy(folder.path("site.helio"), folder.path("copy.helio")).expect("copied");
    let output = folder.run("export site.helio --html equal.html --with copy.helio");
    assert!(output.status.success() && stderr(&output).contains("equal"), "{}", stderr(&output));
}

/// Two archives that cannot be compared are refused with exit code 2, and each error gives the
/// reason: no receiver in common, another coordinate system, places 100 km apart, an atlas, a
/// missing archive, no page: 6 of 6 by `view` or `export`.
#[test]
fn archives_that_cannot_be_compared_are_refused() {
    let folder = Folder::new();
    folder.build();
    another(&folder, "elsewhere.helio", ELSEWHERE, "");
    another(&folder, "dutch.helio", CHANGED, "--latitude 52 --longitude 5");
    another(&folder, "german.helio", CHANGED, "--latitude 51 --longitude 5");
    let data = format!("{}/tests/data/hague", crate::ROOT);
    folder.write("one.csv", "receiver,x,y,z,nx,ny,nz\na,78716.2410,458018.2889,30,0,0,1\n");
    for (name, crs) in [("grid.helio", "EPSG:28992"), ("other_grid.helio", "EPSG:25832")] {
        let built =
            folder.run(&format!("build {data}/scene.obj -m {data}/materials.toml -r one.csv --crs {crs} -o {name}"));
        assert!(built.status.success(), "{}", stderr(&built));
    }
    for command in ["view site.helio --port 0", "export site.helio --html page.html"] {
        folder.fails(&format!("{command} --with elsewhere.helio"), "input other-site elsewhere.helio");
        folder.fails(&format!("{command} --with nowhere.helio"), "missing-file nowhere.helio");
    }
    folder.fails("view grid.helio --with other_grid.helio", "input other-site other_grid.helio");
    folder.fails("view dutch.helio --with german.helio", "input other-site german.helio");
    folder
        .fails("export site.helio --receiver roof -o r.png --with dutch.helio", "argument excludes --receiver --with");
    fs::create_dir(folder.path("atlas")).expect("a folder");
    folder.write("atlas/atlas.json", "{}");
    folder.fails("view site.helio --with atlas", "input other-kind atlas atlas");
    assert!(!folder.path("page.html").exists());
}

/// Files that cannot be shown are refused before anything is served, 5 of 5, with the name of the
/// file.
#[test]
fn files_that_cannot_be_shown_are_refused() {
    let folder = Folder::new();
    folder.build();
    fs::write(folder.path("cut.helio"), &fs::read(folder.path("site.helio")).expect("an archive")[..3000])
        .expect("written");
    folder.fails("view nowhere.helio", "missing-file nowhere.helio");
    folder.fails("view scene.obj", "input other-kind scene.obj a scene (OBJ)");
    folder.fails("view cut.helio", "input other-kind cut.helio not an archive");
    folder.fails("view site.helio --weather scene.obj", "input other-kind scene.obj a scene (OBJ)");
    folder.fails("export site.helio --html nowhere/page.html", "input lacks nowhere/page.html folder");
}

/// `export --html` writes one file that holds the archive's bytes and those of the weather, and no
/// foreign address; names with tags stay text.
#[test]
fn an_exported_page_holds_archive_and_weather() {
    let folder = Folder::new();
    folder.build();
    let name = "a<script>b.helio";
    fs::copy(folder.path("site.helio"), folder.path(name)).expect("copied");
    fs::copy(golden(), folder.path("w.epw")).expect("copied");
    let output = folder.run(&format!("export {name} --html page.html --weather w.epw"));
    assert!(output.status.success() && stdout(&output).is_empty());
    let page = fs::read_to_string(folder.path("page.html")).expect("a page");
    let archive = fs::read(folder.path("site.helio")).expect("an archive");
    assert!(page.contains("data-name=\"a&lt;script&gt;b.helio\"") && !page.contains(name));
    let packed = page.split("id=\"weather\"").nth(1).expect("weather").split('>').nth(1).expect("bytes");
    assert!(page.len() > archive.len() * 4 / 3 && packed.len() > 1000);
    for from in ["src=\"http", "href=\"http", "url(http", "import(\"http"] {
        assert!(!page.contains(from), "{from}");
    }
}
