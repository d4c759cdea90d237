//! Publishing and fetching: whole files or none, and no file of others is replaced.

use std::fs;
use std::sync::atomic::Ordering;

use super::server::Fault;
use super::{HAGUE, afar, hague, run};
use crate::cli::{stderr, stdout};

const LARGE: usize = 20_000_000;

/// Returns an archive of 20 MB that opens: the block's archive with zeros behind its end.
fn large() -> Vec<u8> {
    let mut bytes = HAGUE.1.clone();
    bytes.resize(LARGE, 0);
    bytes
}

/// A small archive and a table go to a store and back unchanged. Existing files stay, at both ends,
/// unless `--replace` is given. A wrong clock of this machine is reported: 1 of 1. A damaged
/// archive is mended at either end: 2 of 2.
#[test]
fn files_are_copied_to_a_store_and_back() {
    let (folder, store) = hague();
    let ran = |line: &str| {
        let ran = run(&folder, &store, line);
        (ran.status.code(), format!("{}{}", stdout(&ran), stderr(&ran)))
    };
    assert_eq!(ran("archive copy site.helio s3://bucket/new/a.helio").0, Some(0));
    assert_eq!(store.get("bucket/new/a.helio").as_ref(), Some(&HAGUE.1));
    assert_eq!(ran("archive copy conditions.csv s3://bucket/new/c.csv").0, Some(0));
    assert_eq!(ran("archive copy s3://bucket/new/a.helio b.helio").0, Some(0));
    assert!(fs::read(folder.path("b.helio")).expect("a file") == HAGUE.1);
    assert_eq!(ran("archive copy s3://bucket/new/c.csv c.csv").0, Some(0));
    assert_eq!(fs::read(folder.path("c.csv")).ok(), fs::read(folder.path("conditions.csv")).ok());
    assert!(ran("archive copy site.helio s3://bucket/new/a.helio").1.contains("up to date"));
    for line in ["archive copy s3://bucket/new/c.csv b.helio", "archive copy conditions.csv s3://bucket/new/a.helio"] {
        let (code, said) = ran(line);
        assert!(code == Some(2) && said.contains("is there already") && said.contains("--replace"), "{said}");
    }
    assert_eq!(store.get("bucket/new/a.helio").as_ref(), Some(&HAGUE.1));
    assert_eq!(ran("archive copy conditions.csv s3://bucket/new/a.helio --replace").0, Some(0));
    assert_eq!(store.get("bucket/new/a.helio"), fs::read(folder.path("conditions.csv")).ok());
    // A damaged archive has the same root, and is mended by --replace, also in a file.
    let mut damaged = HAGUE.1.clone();
    damaged[HAGUE.1.len() / 2] ^= 1;
    store.put("bucket/new/e.helio", damaged.clone());
    fs::write(folder.path("b.helio"), &damaged).expect("written");
    for (line, mended) in [
        ("archive copy site.helio s3://bucket/new/e.helio --replace", "s3://bucket/new/e.helio"),
        ("archive copy s3://bucket/new/e.helio b.helio --replace", "b.helio"),
    ] {
        assert_eq!(ran(&format!("archive verify {mended}")).0, Some(1), "{mended}");
        assert_eq!(ran(line).0, Some(0), "{line}");
        assert_eq!(ran(&format!("archive verify {mended}")).0, Some(0), "{mended}");
    }
    assert!(ran("archive copy site.helio other.helio").1.contains("copy files with `cp`"));
    assert!(
        ran("archive copy site.helio https://host/site.helio").1.contains("heliotile writes to object stores only")
    );
    // The first request is a HEAD, whose answer has no body.
    store.set_faults(|_| Fault::Skewed);
    let (code, said) = ran("archive copy site.helio s3://bucket/new/d.helio");
    assert!(
        code == Some(2) && said.contains("this machine's clock is off, the store's clock says 2026-11-23"),
        "{said}"
    );
    let left = fs::read_dir(folder.path(""))
        .expect("a folder")
        .filter(|entry| entry.as_ref().is_ok_and(|entry| entry.file_name().to_string_lossy().starts_with(".copy")));
    assert_eq!(left.count(), 0);
}

/// By Google's protocol a small archive and one of 20 MB go to a store and back, and a table of the
/// remote archive is that of the file. An existing object stays unless `--replace` is given, 2 of
/// 2, and an object that another program wrote meanwhile stays: 1 of 1.
#[test]
fn google_stores_copy_and_keep_objects() {
    let (folder, store) = hague();
    fs::write(folder.path("large.helio"), large()).expect("written");
    let ran = |line: &str| {
        let mut command = afar(&folder, &store, line, false);
        let key =
            "{\"private_key\":\"s3cret\",\"private_key_id\":\"1\",\"client_email\":\"me@host\",\"disable_oauth\":true}";
        command.env("GOOGLE_BASE_URL", format!("http://{}", store.address)).env("GOOGLE_SERVICE_ACCOUNT_KEY", key);
        let ran = command.output().expect("the program");
        (ran.status.code(), format!("{}{}", stdout(&ran), stderr(&ran)))
    };
    for name in ["site.helio", "large.helio"] {
        let (code, said) = ran(&format!("archive copy {name} gs://bucket/{name}"));
        assert_eq!(code, Some(0), "{said}");
        let (code, said) = ran(&format!("archive copy gs://bucket/{name} back.helio --replace"));
        assert_eq!(code, Some(0), "{said}");
        assert!(fs::read(folder.path("back.helio")).ok() == fs::read(folder.path(name)).ok(), "{name}");
        assert!(ran(&format!("archive copy {name} gs://bucket/{name}")).1.contains("up to date"));
    }
    let query = |place: &str| ran(&format!("replay {place} --conditions conditions.csv"));
    assert!(query("gs://bucket/site.helio") == query("site.helio"));
    let (code, said) = ran("archive copy site.helio gs://bucket/large.helio");
    assert!(code == Some(2) && said.contains("is there already"), "{said}");
    assert_eq!(ran("archive copy site.helio gs://bucket/large.helio --replace").0, Some(0));
    assert_eq!(ran("archive copy gs://bucket/large.helio back.helio --replace").0, Some(0));
    assert!(fs::read(folder.path("back.helio")).ok().as_ref() == Some(&HAGUE.1));
    // Another program writes between the first look and the upload.
    store.set_faults(|number| if number == 1 { Fault::Replace } else { Fault::None });
    let (code, said) = ran("archive copy conditions.csv gs://bucket/large.helio --replace");
    assert!(code == Some(2) && said.contains("was written by another program"), "{said}");
}

/// An archive of 20 MB goes in parts to a name with its root, and a pointer of 201 bytes stands
/// under its name. Commands follow the pointer, in the store and where both are files. A pointer
/// that leads to another archive is refused.
#[test]
fn commands_follow_a_pointer() {
    let (folder, store) = hague();
    fs::write(folder.path("large.helio"), large()).expect("written");
    let sent = run(&folder, &store, "archive copy large.helio s3://bucket/large.helio");
    assert!(sent.status.success(), "{}", stderr(&sent));
    let names: Vec<String> = store.names().into_iter().filter(|name| name.contains("large")).collect();
    assert_eq!(names.len(), 2);
    let data = names.iter().find(|name| name.len() > 70).expect("a name with a root");
    assert!(store.get(data) == Some(large()));
    let pointer = store.get("bucket/large.helio").expect("a pointer");
    assert_eq!(pointer.len(), 201);
    let query = |place: &str| stdout(&run(&folder, &store, &format!("replay {place} --conditions conditions.csv")));
    let near = query("site.helio");
    assert!(near.len() > 1000 && query("s3://bucket/large.helio") == near);
    fs::create_dir(folder.path("copies")).expect("a folder");
    fs::write(folder.path("copies/large.helio"), &pointer).expect("written");
    fs::write(folder.path("copies").join(data.rsplit('/').next().expect("a name")), large()).expect("written");
    assert_eq!(query("copies/large.helio"), near);
    let fetched = run(&folder, &store, "archive copy s3://bucket/large.helio fetched.helio");
    assert!(
        fetched.status.success() && fs::read(folder.path("fetched.helio")).ok() == Some(large()),
        "{}",
        stderr(&fetched)
    );
    let other = folder.run("archive extract site.helio -r some.csv -o other.helio");
    assert!(other.status.success());
    store.put(data, fs::read(folder.path("other.helio")).expect("an archive"));
    let said = stderr(&run(&folder, &store, "info s3://bucket/large.helio"));
    assert!(said.contains("is not the archive that s3://bucket/large.helio points to"), "{said}");
}

/// If two programs publish different archives under one name at the same time, one wins and the
/// other says so, 5 times of 5, and the object is whole. Two programs that publish the same archive
/// both succeed.
#[test]
fn one_of_two_writers_wins() {
    let (folder, store) = hague();
    let mut other = large();
    let extracted = folder.run("archive extract site.helio -r some.csv -o other.helio");
    assert!(extracted.status.success());
    let small = fs::read(folder.path("other.helio")).expect("an archive");
    other.fill(0);
    other[..small.len()].copy_from_slice(&small);
    fs::write(folder.path("a.helio"), large()).expect("written");
    fs::write(folder.path("b.helio"), &other).expect("written");
    for round in 0..6 {
        let files = if round == 5 { ["a", "a"] } else { ["a", "b"] };
        let writers = files.map(|file| {
            let line = format!("archive copy {file}.helio s3://bucket/race{round}.helio");
            afar(&folder, &store, &line, false).stderr(std::process::Stdio::piped()).spawn().expect("the program")
        });
        let ended = writers.map(|writer| writer.wait_with_output().expect("an end"));
        let codes = [&ended[0], &ended[1]].map(|ended| ended.status.code().expect("a code"));
        let said = format!("{}{}", stderr(&ended[0]), stderr(&ended[1]));
        match round {
            5 => assert_eq!(codes, [0, 0], "{said}"),
            _ => {
                assert!(codes == [0, 2] || codes == [2, 0], "{codes:?} {said}");
                assert!(
                    said.contains("was written by another program meanwhile") || said.contains("is there already"),
                    "{said}"
                );
            }
        }
        let checked = run(&folder, &store, &format!("archive verify s3://bucket/race{round}.helio"));
        assert!(checked.status.success(), "{}", stderr(&checked));
    }
}

/// With a store that fails while an archive is sent or fetched, 40 copies end well or with an
/// error, and the object or file under the name is afterwards the whole archive, or absent.
#[test]
fn faults_leave_a_whole_object_or_none() {
    let (folder, store) = hague();
    fs::write(folder.path("large.helio"), large()).expect("written");
    let mut done = [0, 0];
    for round in 0..40_u64 {
        let fault = move |number: u64| match (number * 7 + round * 13) % 17 {
            0 => Fault::Status(500),
            1 => Fault::Gone,
            2 => Fault::Cut,
            3 if round % 3 == 0 => Fault::Status(403),
            _ => Fault::None,
        };
        let (line, name) = match round % 2 {
            0 => (format!("archive copy large.helio s3://bucket/f{round}.helio"), format!("bucket/f{round}.helio")),
            _ => (format!("archive copy s3://bucket/site.helio f{round}.helio"), String::new()),
        };
        store.set_faults(fault);
        let ran = run(&folder, &store, &line);
        assert!(matches!(ran.status.code(), Some(0 | 2)) && !stderr(&ran).contains("panicked"), "{}", stderr(&ran));
        done[usize::from(ran.status.code() == Some(2))] += 1;
        store.set_faults(|_| Fault::None);
        match (round % 2, ran.status.success()) {
            (1, true) => assert!(fs::read(folder.path(&format!("f{round}.helio"))).ok().as_ref() == Some(&HAGUE.1)),
            (1, false) => assert!(!folder.path(&format!("f{round}.helio")).exists()),
            (_, fine) => {
                let checked = run(&folder, &store, &format!("archive verify s3://{name}"));
                assert!(checked.status.success() || (!fine && store.get(&name).is_none()), "{}", stderr(&checked));
            }
        }
        assert!(store.requests.load(Ordering::Relaxed) < 100);
    }
    assert!(done[0] > 10 && done[0] + done[1] == 40, "{done:?}");
}
