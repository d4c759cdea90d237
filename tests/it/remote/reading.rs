//! Reading of remote archives: results are those of a file, or an error, however the store behaves.

use std::fs;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::server::Fault;
use super::{HAGUE, afar, hague, run};
use crate::cli::{stderr, stdout};

/// Commands that read archives, with `AT` for the archive; tables go to standard output, other
/// files to `out`.
const COMMANDS: [&str; 9] = [
    "info AT",
    "archive verify AT --deep",
    "replay AT --conditions conditions.csv",
    "replay AT --conditions conditions.csv --bounces 1 --reflectance ground=0.5",
    "replay AT --weather w.epw --every month --by surface",
    "energyplus factors AT --by surface",
    "buildings AT --weather w.epw -o out.csv",
    "export AT --view-factors -o out.csv",
    "archive extract AT --bbox 0,0,1e9,1e9 -o out.helio",
];

/// 9 commands print and write the same bytes from a store as from a file, but for the archive's
/// name, with fewer than 40 requests each.
#[test]
fn a_store_reads_like_a_file() {
    let (folder, store) = hague();
    for line in COMMANDS {
        let line = line.replace("0,0,1e9,1e9", "-1e9,-1e9,1e9,1e9");
        let outputs = ["out.csv", "out.csv-metadata.json", "out.helio"];
        let [near, far] = ["site.helio", "s3://bucket/site.helio"].map(|place| {
            outputs.iter().for_each(|name| drop(fs::remove_file(folder.path(name))));
            store.set_faults(|_| Fault::None);
            let ran = run(&folder, &store, &line.replace("AT", place));
            assert_eq!(ran.status.code(), Some(0), "{line}: {}", stderr(&ran));
            let said = stdout(&ran).replace("s3://bucket/", "");
            let files = outputs.map(|name| fs::read(folder.path(name)).unwrap_or_default());
            (said, files.map(|bytes| String::from_utf8_lossy(&bytes).replace("s3://bucket/", "").into_bytes()))
        });
        assert!(near == far, "{line}: {} {}", near.0, far.0);
        let requests = store.requests.load(Ordering::Relaxed);
        assert!(requests > 1 && requests < 40, "{line}: {requests} requests");
    }
}

/// With a cache the second query requests the ends of the archive only, 2 requests in place of 4 or
/// more. A damaged file of the cache is fetched again. `verify` fetches everything all the same. An
/// object that was replaced is read again, with its own values.
#[test]
fn a_cache_saves_requests() {
    let (folder, store) = hague();
    let query = "replay s3://bucket/site.helio --conditions conditions.csv";
    let asked = |line: &str| {
        store.set_faults(|_| Fault::None);
        let ran = afar(&folder, &store, line, true).output().expect("the program");
        assert!(ran.status.success(), "{}", stderr(&ran));
        (stdout(&ran), store.requests.load(Ordering::Relaxed), store.sent.load(Ordering::Relaxed))
    };
    let near = stdout(&folder.run("replay site.helio --conditions conditions.csv"));
    let (cold, warm) = (asked(query), asked(query));
    assert!(cold.0 == near && warm.0 == near);
    assert!(cold.1 > warm.1 && warm.1 == 2 && warm.2 <= 80 << 10, "{} {} {}", cold.1, warm.1, warm.2);
    let blocks: Vec<_> = fs::read_dir(folder.path("cache/blocks"))
        .expect("blocks")
        .flat_map(|entry| fs::read_dir(entry.expect("a folder").path()).expect("files"))
        .map(|entry| entry.expect("a file").path())
        .collect();
    assert!(blocks.len() > 10, "{}", blocks.len());
    for path in &blocks {
        let mut bytes = fs::read(path).expect("a block");
        bytes[0] ^= 1;
        fs::write(path, bytes).expect("written");
    }
    let mended = asked(query);
    assert!(mended.0 == near && mended.1 > 2, "{}", mended.1);
    assert!(asked("archive verify s3://bucket/site.helio").2 as usize >= HAGUE.1.len());
    let other = folder.run("archive extract site.helio -r some.csv -o other.helio");
    assert!(other.status.success(), "{}", stderr(&other));
    store.put("bucket/site.helio", fs::read(folder.path("other.helio")).expect("an archive"));
    assert_eq!(asked(query).0, stdout(&folder.run("replay other.helio --conditions conditions.csv")));
}

/// Returns a pseudo-random number for each seed.
fn mixed(seed: u64) -> u64 {
    let mut x = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// In 60 queries of a store where each request may meet one of 7 faults, each gives the right table
/// or an error that names the address and a hint, within 30 s, and most give the table. Over 100
/// faults are met, and no secret is printed.
#[test]
fn faults_end_in_the_table_or_an_error() {
    let (folder, store) = hague();
    let near = stdout(&folder.run("replay site.helio --conditions conditions.csv"));
    let (mut right, mut refused, mut met) = (0, 0, 0);
    for round in 0..60_u64 {
        // `Replace` changes the object for good.
        store.put("bucket/site.helio", HAGUE.1.clone());
        let fault = move |number: u64| match mixed(round * 1000 + number) % 24 {
            0 | 1 => Fault::Status(500),
            2 => Fault::Status(503),
            3 | 4 => Fault::Cut,
            5 => Fault::Flip,
            6 => Fault::Gone,
            7 if round % 4 == 0 => Fault::Stall,
            8 if round % 10 == 0 => Fault::Status(403),
            9 if round % 10 == 5 => Fault::Replace,
            _ => Fault::None,
        };
        store.set_faults(fault);
        let begun = Instant::now();
        let ran = run(&folder, &store, "replay s3://bucket/site.helio --conditions conditions.csv");
        assert!(begun.elapsed() < Duration::from_secs(30), "{round}: {:?}", begun.elapsed());
        met += (0..store.requests.load(Ordering::Relaxed)).filter(|&number| fault(number) != Fault::None).count();
        match ran.status.code() {
            Some(0) => {
                assert!(stdout(&ran) == near, "round {round}");
                right += 1;
            }
            Some(2) => {
                let said = stderr(&ran);
                assert!(said.contains("s3://bucket/site.helio") && said.contains("to fix: "), "{said}");
                assert!(
                    !said.contains("s3cret") && !said.contains("panicked") && near.starts_with(&stdout(&ran)),
                    "{said}"
                );
                refused += 1;
            }
            other => panic!("{round}: {other:?} {}", stderr(&ran)),
        }
    }
    assert!(met > 100 && right > 40 && right + refused == 60, "{met} faults, {right} right, {refused} refused");
}

/// An object that is replaced after it was opened is an error that says so, not a mixture: 2 of 2,
/// by the server's answer to If-Match.
#[test]
fn an_object_that_changes_is_an_error() {
    let (folder, store) = hague();
    for nth in [2, 3] {
        store.put("bucket/site.helio", HAGUE.1.clone());
        store.set_faults(move |number| if number == nth { Fault::Replace } else { Fault::None });
        let ran = run(&folder, &store, "replay s3://bucket/site.helio --conditions conditions.csv");
        let said = stderr(&ran);
        assert!(ran.status.code() == Some(2) && said.contains("has changed while it was read"), "{nth}: {said}");
    }
}

/// A user name and a password of an address go to a web server as RFC 7617 says, percent signs
/// decoded, and give the table of the file. Another password is refused, and no message holds it.
/// Variables that clients of stores accept and cannot use are refused by their names, without their
/// values; those of other stores are ignored.
#[test]
fn passwords_are_sent_and_never_printed() {
    let (folder, store) = hague();
    let near = stdout(&folder.run("replay site.helio --conditions conditions.csv"));
    // Python's base64 of `me and:s3cret:100%`.
    store.want("Basic bWUgYW5kOnMzY3JldDoxMDAl");
    let query = |user: &str| {
        let line = format!("replay http://{user}@{}/bucket/site.helio --conditions conditions.csv", store.address);
        run(&folder, &store, &line)
    };
    let right = query("me%20and:s3cret%3A100%25");
    assert!(stdout(&right) == near, "{}", stderr(&right));
    let wrong = query("me:s3cret");
    assert!(
        wrong.status.code() == Some(2) && stderr(&wrong).contains("requires credentials (401)"),
        "{}",
        stderr(&wrong)
    );
    assert!(!stderr(&wrong).contains("s3cret"), "{}", stderr(&wrong));
    for (name, value) in [
        ("AWS_ENDPOINT_URL", "127.0.0.1:9000"),
        ("AWS_ENDPOINT_URL_S3", "ftp://host"),
        ("AWS_ENDPOINT", "http://"),
        ("AWS_ENDPOINT", "me:s3cret@host:9000"),
        ("AWS_SESSION_TOKEN", "token\n"),
        ("AWS_ACCESS_KEY_ID", "m\u{e4}"),
        ("AWS_REGION", "eu\r"),
    ] {
        let mut command = afar(&folder, &store, "info s3://bucket/site.helio", false);
        let ran = command.env(name, value).output().expect("the program");
        let said = stderr(&ran);
        assert!(ran.status.code() == Some(2) && said.contains(name) && said.contains("to fix: "), "{name}: {said}");
        assert!(!said.contains("s3cret"), "{said}");
    }
    // Variables of another store, and empty ones, are ignored.
    let line = format!(
        "replay http://me%20and:s3cret%3A100%25@{}/bucket/site.helio --conditions conditions.csv",
        store.address
    );
    let mut command = afar(&folder, &store, &line, false);
    let ran = command.env("AWS_ENDPOINT_URL", "host:1").env("AWS_ENDPOINT", "").output().expect("the program");
    assert!(stdout(&ran) == near, "{}", stderr(&ran));
}

/// 10 wrong places are refused with a finding and a hint, within 10 s. A web server without ranges
/// serves a small archive whole; one beyond 50 MB is refused before it is read.
#[test]
fn wrong_places_are_refused() {
    let (folder, store) = hague();
    let refused = |place: &str, parts: &[&str]| {
        let begun = Instant::now();
        let ran = run(&folder, &store, &format!("info {place}"));
        let said = stderr(&ran);
        assert_eq!(ran.status.code(), Some(2), "{place}: {said}");
        assert!(parts.iter().all(|part| said.contains(part)) && said.contains("to fix: "), "{place}: {said}");
        assert!(begun.elapsed() < Duration::from_secs(10), "{place}");
    };
    store.put("bucket/empty.helio", Vec::new());
    store.put("bucket/text.helio", b"no archive".to_vec());
    store.put("bucket/long.helio", vec![7; 200_000]);
    refused("s3://bucket/nowhere.helio", &["s3://bucket/nowhere.helio: is not there (404)"]);
    refused("s3://bucket/empty.helio", &["is empty"]);
    refused("s3://bucket/text.helio", &["is not a heliotile archive"]);
    refused("s3://bucket/long.helio", &["is not a heliotile archive"]);
    refused("s3://bucket", &["names no object"]);
    refused("ftp://host/site.helio", &["`ftp://` is not supported"]);
    refused("http://127.0.0.1:1/site.helio?sig=s3cret", &["http://127.0.0.1:1/site.helio: request failed"]);
    store.set_faults(|_| Fault::Status(403));
    refused("s3://bucket/site.helio", &["access is denied (403, Injected)", "AWS_ACCESS_KEY_ID"]);
    store.set_faults(|_| Fault::Skewed);
    refused(
        "s3://bucket/site.helio",
        &[
            "s3://bucket/site.helio: this machine's clock is off, the store's clock says 2026-11-23T22:40:11Z",
            "set the clock",
        ],
    );
    store.set_faults(|_| Fault::Status(500));
    refused("s3://bucket/site.helio", &["answers 500 (Injected), also after retries"]);

    store.set_faults(|_| Fault::None);
    store.set_ranges(false);
    let web = format!("http://{}/bucket/", store.address);
    let whole = run(&folder, &store, &format!("replay {web}site.helio --conditions conditions.csv"));
    assert_eq!(stdout(&whole), stdout(&folder.run("replay site.helio --conditions conditions.csv")));
    store.put("bucket/large.helio", vec![0; 50_000_001]);
    refused(
        &format!("{web}large.helio"),
        &["50000001 bytes", "does not support byte ranges", "use a server with byte ranges"],
    );
}
