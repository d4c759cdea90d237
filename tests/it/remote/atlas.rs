//! Atlases in a store or on a web server: queried like a folder, published so that no reader finds
//! an incomplete one.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;
use std::sync::atomic::Ordering;

use super::run;
use super::server::{Fault, Store};
use crate::cli::{Folder, golden, stderr, stdout};

/// The block of The Hague in four parts with a catalogue, built once for all tests here.
static BLOCK: LazyLock<Folder> = LazyLock::new(|| {
    let folder = Folder::new();
    let model = Path::new(crate::ROOT).join("tests/data/cityjson/hague.city.json");
    let cut = "--crs EPSG:28992 --part-size 45m --spacing 4m --quality draft --sample 0";
    for line in [
        &format!("atlas partition {} {cut} -o atlas", model.display()),
        "build atlas --part all",
        "atlas catalogue atlas --title Block",
    ] {
        let ran = folder.run(line);
        assert!(ran.status.success(), "{line}: {}", stderr(&ran));
    }
    folder
});

/// Returns the files of an atlas that are copied, with their contents.
fn files() -> Vec<(String, Vec<u8>)> {
    let root = BLOCK.path("atlas");
    let mut names: Vec<String> = vec!["atlas.json".into(), "collection.json".into()];
    for part in fs::read_dir(root.join("parts")).expect("parts") {
        let part = part.expect("a part").file_name().to_string_lossy().into_owned();
        names.extend(["site.helio", "item.json"].map(|name| format!("parts/{part}/{name}")));
    }
    names.sort();
    names.into_iter().map(|name| (name.clone(), fs::read(root.join(name)).expect("a file"))).collect()
}

/// Returns a folder with a copy of the atlas, weather and conditions, and a store that holds the
/// atlas, put there without the program.
fn placed() -> (Folder, Store) {
    let (folder, store) = (Folder::new(), Store::new());
    fs::copy(golden(), folder.path("w.epw")).expect("copied");
    for (name, bytes) in files() {
        let path = folder.path("atlas").join(&name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        fs::write(path, &bytes).expect("written");
        store.put(&format!("bucket/atlas/{name}"), bytes);
    }
    (folder, store)
}

/// A box in one of the four parts.
const BOX: &str = "78706,457921,78749,457964";

/// 11 commands give the same bytes from a store and from a web server as from the folder, without
/// any scene file. `find` of a box takes at most 5 requests, `replay` of a box in one part less
/// than half of the bytes of all.
#[test]
fn an_atlas_reads_alike_from_a_store_and_a_folder() {
    let (folder, store) = placed();
    let mut bytes = Vec::new();
    for line in [
        &format!("atlas find AT --bbox {BOX}"),
        "atlas find AT",
        "info AT",
        "archive verify AT",
        "replay AT --conditions conditions.csv --by surface",
        &format!("replay AT --weather w.epw --every total --bbox {BOX}"),
        "replay AT --weather w.epw --every total",
        &format!("energyplus factors AT --bbox {BOX} --by surface"),
        "export AT --view-factors -o -",
        "buildings AT --weather w.epw -o out.csv",
        "places AT --weather w.epw -o out.csv",
    ] {
        let web = format!("http://{}/bucket/", store.address);
        let [near, far, at_web] = ["", "s3://bucket/", &web].map(|prefix| {
            store.set_faults(|_| Fault::None);
            let ran = run(&folder, &store, &line.replace("AT", &format!("{prefix}atlas")));
            assert_eq!(ran.status.code(), Some(0), "{prefix} {line}: {}", stderr(&ran));
            let table = fs::read_to_string(folder.path("out.csv")).unwrap_or_default();
            let requests = store.requests.load(Ordering::Relaxed);
            if !prefix.is_empty() {
                assert!((2..120).contains(&requests), "{line}: {requests}");
            }
            if prefix.starts_with("s3") {
                bytes.push((requests, store.sent.load(Ordering::Relaxed)));
            }
            let said = stdout(&ran);
            (if prefix.is_empty() { said } else { said.replace(prefix, "") }, table)
        });
        assert!(near == far && near == at_web, "{line}: {} {} {}", near.0, far.0, at_web.0);
    }
    assert!(bytes[0].0 <= 5, "{bytes:?}");
    assert!(bytes[5].1 * 2 < bytes[6].1 && bytes[5].1 > 10_000, "{bytes:?}");
}

/// Parts are built in the store that holds the plan alone: four parts by name and all at once, with
/// the bytes of those built in a folder and no other object beside the plan. A part that is there
/// is not traced again, which a missing scene file shows, and stays even if its object was
/// replaced. A web server, a missing part and atlas, and failing requests are refused: 4 of 4.
#[test]
fn parts_are_built_in_the_store_of_their_plan() {
    let (folder, store) = (Folder::new(), Store::new());
    fs::copy(golden(), folder.path("w.epw")).expect("copied");
    let model = folder.path("block.city.json");
    fs::copy(Path::new(crate::ROOT).join("tests/data/cityjson/hague.city.json"), &model).expect("copied");
    let cut = "--crs EPSG:28992 --part-size 45m --spacing 4m --quality draft --sample 0";
    let said = |line: &str, code: i32, words: &[&str]| {
        let ran = run(&folder, &store, line);
        let text = format!("{}{}", stdout(&ran), stderr(&ran));
        assert_eq!(ran.status.code(), Some(code), "{line}: {text}");
        for word in words {
            assert!(text.contains(word), "{line}: `{word}` is not in {text}");
        }
    };
    said(&format!("atlas partition block.city.json {cut} -o atlas"), 0, &["4 parts of 45 m"]);
    said("archive copy atlas s3://bucket/atlas", 0, &["4 parts not built yet", "1 file"]);
    let there = || store.names().into_iter().filter(|name| name.starts_with("bucket/atlas/")).collect::<Vec<_>>();
    assert_eq!(there(), ["bucket/atlas/atlas.json"]);
    let replay = "replay s3://bucket/atlas --weather w.epw --every total";
    said(replay, 2, &["4 of its parts are not built yet", "heliotile build s3://bucket/atlas --part x1749_y10176"]);
    said("build s3://bucket/atlas --part 9", 2, &["s3://bucket/atlas has no part `9`"]);
    said("build s3://bucket/atlas --part x1749_y10176", 0, &["atlas/parts/x1749_y10176/site.helio: 0."]);
    said("build s3://bucket/atlas --part all", 0, &["x1749_y10176: built already, nothing is traced again (--fresh"]);
    let built = |name: &str| fs::read(BLOCK.path("atlas").join(name)).expect("an archive");
    let archives: Vec<String> = there()
        .iter()
        .filter_map(|name| name.strip_prefix("bucket/atlas/parts/"))
        .map(|name| format!("parts/{name}"))
        .collect();
    assert_eq!((archives.len(), there().len()), (4, 5));
    for name in &archives {
        assert!(store.get(&format!("bucket/atlas/{name}")) == Some(built(name)), "{name}");
    }
    let near = stdout(&BLOCK.run(&format!("replay atlas --weather {} --every total", golden().display())));
    assert_eq!(stdout(&run(&folder, &store, replay)), near);
    // An object that another program wrote meanwhile stays, and no scene file is needed to see it.
    fs::remove_file(&model).expect("removed");
    store.put("bucket/atlas/parts/x1749_y10176/site.helio", b"theirs".to_vec());
    said("build s3://bucket/atlas --part all", 0, &["x1749_y10176: built already, nothing is traced again"]);
    assert_eq!(store.get("bucket/atlas/parts/x1749_y10176/site.helio"), Some(b"theirs".to_vec()));
    said("build s3://bucket/atlas --part 0 --fresh", 2, &["block.city.json"]);
    let web = format!("build http://{}/bucket/atlas --part 0", store.address);
    said(&web, 2, &["is on a web server, but heliotile writes to object stores only", "s3://BUCKET/NAME"]);
    said("build s3://bucket/nothing --part 0", 2, &["holds no atlas.json"]);
    store.set_faults(|_| Fault::Status(403));
    said("build s3://bucket/atlas --part 0", 2, &["access is denied"]);
}

/// An atlas of 10 files goes to a store, in a folder there or as a whole bucket, and back
/// unchanged, with atlas.json written last. The same command again writes nothing, but replaces a
/// catalogue that was made anew. A part that was left out of an interrupted copy is added. Another
/// part in a place stops the copy, and another atlas does even with `--replace`.
#[test]
fn an_atlas_is_copied_to_a_store_and_back() {
    let (folder, store) = placed();
    let ran = |line: &str| {
        let ran = run(&folder, &store, line);
        (ran.status.code(), format!("{}{}", stdout(&ran), stderr(&ran)))
    };
    let is_there = |prefix: &str| {
        files().iter().all(|(name, bytes)| store.get(&format!("{prefix}/{name}")).as_ref() == Some(bytes))
    };
    // The copy ends with an error while requests fail, before the plan is written.
    store.set_faults(|number| if number > 12 { Fault::Status(403) } else { Fault::None });
    let (code, said) = ran("archive copy atlas s3://bucket/new");
    assert!(code == Some(2) && store.get("bucket/new/atlas.json").is_none(), "{said}");
    store.set_faults(|_| Fault::None);
    let (code, said) = ran("archive copy atlas s3://bucket/new");
    assert!(code == Some(0) && is_there("bucket/new"), "{said}");
    assert_eq!(store.newest(), "bucket/new/atlas.json");
    let (code, said) = ran("archive copy atlas s3://bucket/new");
    assert!(code == Some(0) && said.contains("10 files, 0 of them new"), "{said}");
    // Files that are not of the catalogue are not copied, and files of the user are not replaced.
    folder.write("atlas/notes.txt", "mine");
    fs::create_dir(folder.path("mine")).expect("made");
    folder.write("mine/view.html", "mine");
    assert_eq!(ran("archive copy atlas s3://bucket/new").0, Some(0));
    assert!(store.get("bucket/new/notes.txt").is_none());
    folder.write("atlas/view.html", "the page");
    assert_eq!(ran("archive copy atlas s3://bucket/new").0, Some(0));
    let (code, said) = ran("archive copy s3://bucket/new mine");
    assert!(code == Some(2) && said.contains("view.html: is there already"), "{said}");
    assert_eq!(fs::read(folder.path("mine/view.html")).ok().as_deref(), Some(&b"mine"[..]));
    fs::remove_file(folder.path("atlas/view.html")).expect("removed");
    store.remove("bucket/new/view.html");
    // A catalogue that was made again replaces the older one.
    let catalogue = fs::read(folder.path("atlas/collection.json")).expect("a catalogue");
    folder.write("atlas/collection.json", "{}");
    let (code, said) = ran("archive copy atlas s3://bucket/new");
    assert!(code == Some(0) && said.contains("10 files, 1 of them new"), "{said}");
    fs::write(folder.path("atlas/collection.json"), catalogue).expect("written");
    assert_eq!(ran("archive copy atlas s3://bucket/new").0, Some(0));
    assert!(is_there("bucket/new"));
    assert_eq!(ran("archive copy s3://bucket/new s3://whole/").0, Some(0));
    assert!(is_there("whole"));
    assert!(ran("atlas find s3://whole").1.contains("s3://whole/parts/x1749_y10176/site.helio"));
    let places = ["s3://bucket/new", "s3://whole", "s3://whole/"].map(str::to_owned);
    for place in places.into_iter().chain([format!("http://{}/bucket/new", store.address)]) {
        let line = format!("archive copy {place} back");
        for new in ["10 of them new", "0 of them new"] {
            let (code, said) = ran(&line);
            assert!(code == Some(0) && said.contains(new), "{said}");
        }
        for (name, bytes) in files() {
            assert!(fs::read(folder.path("back").join(&name)).ok() == Some(bytes), "{name}");
        }
        fs::remove_dir_all(folder.path("back")).expect("removed");
    }
    assert_eq!(ran("archive copy s3://bucket/new s3://bucket/second").0, Some(0));
    assert!(is_there("bucket/second"));
    let part = files().into_iter().find(|(name, _)| name.ends_with(".helio")).expect("a part");
    store.put(&format!("bucket/new/{}", part.0), b"another".to_vec());
    let (code, said) = ran("archive copy atlas s3://bucket/new");
    assert!(code == Some(2) && said.contains("site.helio: is there already") && said.contains("--replace"), "{said}");
    assert_eq!(ran("archive copy atlas s3://bucket/new --replace").0, Some(0));
    assert!(is_there("bucket/new"));
    let plan = fs::read_to_string(folder.path("atlas/atlas.json")).expect("a plan");
    folder.write("atlas/atlas.json", &plan.replace("\"halo_m\": 300.0", "\"halo_m\": 200.0"));
    let (code, said) = ran("archive copy atlas s3://bucket/new --replace");
    assert!(code == Some(2) && said.contains("s3://bucket/new: holds another atlas"), "{said}");
    assert!(ran("archive copy atlas https://host/atlas").1.contains("to fix"));
    assert!(ran("archive copy atlas other").1.contains("copy files with `cp`"));
}

/// 14 wrong places and parts are refused with a finding and a hint, and no secret is printed. A
/// plan that is replaced while it is read is never mixed.
#[test]
fn wrong_places_and_parts_are_refused() {
    let (folder, store) = placed();
    let refused = |line: &str, parts: &[&str]| {
        let ran = run(&folder, &store, line);
        let said = stderr(&ran);
        assert_eq!(ran.status.code(), Some(2), "{line}: {said}");
        assert!(parts.iter().all(|part| said.contains(part)) && !said.contains("s3cret"), "{line}: {said}");
    };
    let replay = |place: &str| format!("replay {place} --weather w.epw --every total");
    refused(&replay("s3://bucket/nowhere"), &["s3://bucket/nowhere: is not there (404)", "atlas.json"]);
    refused("atlas find s3://bucket/nowhere", &["s3://bucket/nowhere: holds no atlas.json", "heliotile archive copy"]);
    refused("atlas find http://127.0.0.1:1/atlas?sig=s3cret", &["127.0.0.1:1/atlas/atlas.json: request failed"]);
    refused("atlas find s3://bucket/atlas --bbox 0,0,1,1", &["no part of the atlas touches the box"]);
    refused("build s3://bucket/nowhere --part 0", &["s3://bucket/nowhere: holds no atlas.json"]);
    refused("atlas catalogue s3://bucket/atlas", &["is an address"]);
    refused("view s3://bucket/atlas", &["is a remote atlas", "view.html"]);
    refused("view s3://bucket/nowhere", &["is not there"]);
    let site = "bucket/atlas/parts/x1749_y10177/site.helio";
    let whole = store.get(site).expect("a part");
    store.remove(site);
    refused(
        &replay("s3://bucket/atlas"),
        &["s3://bucket/atlas: 1 of its parts is not built yet: x1749_y10177", "--part x1749_y10177"],
    );
    let boxed = run(&folder, &store, &(replay("s3://bucket/atlas") + &format!(" --bbox {BOX}")));
    assert!(boxed.status.success(), "{}", stderr(&boxed));
    store.put("bucket/atlas/parts/x1749_y10177/no-receivers.txt", b"Nothing.".to_vec());
    let three = run(&folder, &store, &replay("s3://bucket/atlas"));
    assert!(three.status.success(), "{}", stderr(&three));
    let found = stdout(&run(&folder, &store, "atlas find s3://bucket/atlas"));
    assert!(found.contains("x1749_y10177,78705,457965,empty,\n"), "{found}");
    store.put(site, whole[..whole.len() / 2].to_vec());
    refused(&replay("s3://bucket/atlas"), &["x1749_y10177/site.helio"]);
    let model = Path::new(crate::ROOT).join("tests/data/cityjson/hague.city.json");
    for line in [
        format!("receivers {} --spacing 8m -o r.csv", model.display()),
        format!("build {} -r r.csv --quality draft --set hit=8 -o other.helio", model.display()),
    ] {
        let ran = folder.run(&line);
        assert!(ran.status.success(), "{}", stderr(&ran));
    }
    store.put(site, fs::read(folder.path("other.helio")).expect("an archive"));
    refused(&replay("s3://bucket/atlas"), &["x1749_y10177/site.helio: was built with other settings"]);
    store.put(site, whole);
    let plan = store.get("bucket/atlas/atlas.json").expect("a plan");
    let text = String::from_utf8(plan.clone()).expect("text");
    for (from, to, part) in [
        ("\"heliotile_atlas\": 4", "\"heliotile_atlas\": 9", "layout of s3://bucket/atlas/atlas.json: found 9"),
        ("{", "<html>", "s3://bucket/atlas/atlas.json: is no plan of an atlas"),
    ] {
        store.put("bucket/atlas/atlas.json", text.replacen(from, to, 1).into_bytes());
        refused(&replay("s3://bucket/atlas"), &[part]);
    }
    // The plan is longer than the first request, so that further ones follow.
    let long = text.replacen('{', &format!("{{{}", " ".repeat(200_000)), 1);
    store.put("bucket/atlas/atlas.json", long.into_bytes());
    store.set_faults(|number| if number == 2 { Fault::Replace } else { Fault::None });
    refused("atlas find s3://bucket/atlas", &["s3://bucket/atlas/atlas.json: has changed while it was read"]);
    store.set_faults(|_| Fault::Status(403));
    refused("info s3://bucket/atlas", &["access is denied (403, Injected)", "AWS_ACCESS_KEY_ID"]);
}
