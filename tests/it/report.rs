//! Statements about tables: what they hold, that others can check it, and tables that are refused.

use std::fs;

use crate::cli::{Folder, golden, stderr, stdout};

const RULE: &str = "[[rule]]\nname = \"own\"\ntitle = \"Two hours of sun & no less\"\nsource = \"Plan <b>7</b>\"\n\
                    unconfirmed = \"The height.\"\ndates = [\"03-21\"]\nat_least = 120\nkinds = [\"wall\", \"window\"]\n";

/// Returns a folder with an archive at 52 degrees north, and a table of verdicts with its map.
fn judged() -> Folder {
    let folder = Folder::new();
    folder.write("own.toml", RULE);
    let lines = "receiver,x,y,z,nx,ny,nz,kind\nn10,5,10.02,4,0,1,0,wall\nn9,4,10.02,4,0,1,0,wall\n";
    folder.write("receivers.csv", &format!("{lines}south,5,-0.02,4,0,-1,0,wall\nlawn,15,5,0.02,0,0,1,ground\n"));
    folder.run("build scene.obj -m materials.toml -r receivers.csv --latitude 52 --longitude 5 -o site.helio");
    folder.run("sunlight site.helio --rule own.toml --zone Europe/Amsterdam -o sun.csv --plot sun.png");
    folder
}

fn read(folder: &Folder, name: &str) -> String {
    fs::read_to_string(folder.path(name)).expect(name)
}

/// Returns a property of the metadata file of `sun.csv`.
fn property(folder: &Folder, name: &str) -> String {
    let all: serde_json::Value = serde_json::from_str(&read(folder, "sun.csv-metadata.json")).expect("JSON");
    let all = all["schema:additionalProperty"].as_array().expect("properties").iter();
    let mut found =
        all.filter(|one| one["schema:name"] == name).map(|one| one["schema:value"].as_str().expect("a text"));
    found.next_back().expect(name).to_owned()
}

/// A page about 4 places counts 1 that meets the rule, 2 that break it and 1 without a verdict. It
/// holds the map, the rule with its source and doubt, and the hashes of table, archive and rule as
/// `blake3` gives them. Text from files is escaped, there is no script, and a second page is equal.
#[test]
fn a_statement_holds_rule_result_and_hashes() {
    let folder = judged();
    let mut command = folder.command("report sun.csv -o one.html --title");
    let output = command.arg("Sun <i>& shade").output().expect("the program");
    assert!(stderr(&output).ends_with("1 table, 4 rows; own: 2 broken, 1 met, 1 not applicable\n"), "{output:?}");
    let page = read(&folder, "one.html");
    let plain = page.replace("<span>", "").replace("</span>", "");
    let hash = |name: &str| blake3::hash(&fs::read(folder.path(name)).expect(name)).to_hex().to_string();
    for part in [
        "<h1>Sun &lt;i&gt;&amp; shade</h1>",
        "<p class=\"verdict\">own: 2 broken, 1 met, 1 not applicable</p>",
        "own: Two hours of sun &amp; no less. Source: Plan &lt;b&gt;7&lt;/b&gt;.",
        "Not confirmed of own: The height.",
        "latitude 52.0000, longitude 5.0000",
        "Europe/Amsterdam",
        "src=\"data:image/png;base64,iVBORw0KGgo",
        "heliotile sunlight site.helio --rule own.toml --zone Europe/Amsterdam",
        &hash("sun.csv"),
        &hash("own.toml"),
        &hash("sun.png"),
        &property(&folder, "heliotile.archive_root"),
    ] {
        assert!(plain.contains(part), "`{part}` is not in: {page}");
    }
    let place = |text: &str| page.find(text).expect(text);
    // Broken rules stand first, and 9 before 10.
    assert!(place("<td>n9</td>") < place("<td>n10</td>") && place("<td>n10</td>") < place("<td>south</td>"));
    assert!(!page.contains("<script") && !page.contains("http://") && !page.contains("https://"));
    let mut command = folder.command("report sun.csv -o - --title");
    let other = stdout(&command.arg("Sun <i>& shade").output().expect("the program"));
    assert_eq!(other, page);
}

/// The command in a page writes a table whose hash is the one in the page: equal, byte by byte.
#[test]
fn the_command_in_a_statement_repeats_the_table() {
    let folder = judged();
    let command = property(&folder, "heliotile.command");
    let arguments = command.strip_prefix("heliotile ").expect("a command").to_owned();
    folder.run(&format!("{arguments} -o again.csv"));
    let hash = blake3::hash(&fs::read(folder.path("again.csv")).expect("a table")).to_hex();
    assert_eq!(property(&folder, "heliotile.table_blake3"), *hash);
    folder.run("report sun.csv -o page.html");
    assert!(read(&folder, "page.html").contains(hash.as_str()));
}

/// A page of 216 rows of hours shows 10 and says that 206 are left out; the least and the greatest
/// total of all rows stand above them. Two tables have a section each, the second with a question
/// of its own.
#[test]
fn long_tables_state_what_they_leave_out() {
    let folder = judged();
    let weather = format!("--weather {} --time-zone -07:00", golden().display());
    folder.run(&format!("replay site.helio {weather} -r receivers.csv --every hour -o hours.csv"));
    let rows = read(&folder, "hours.csv").lines().count() - 1;
    folder.run("report hours.csv sun.csv --rows 10 -o page.html");
    let page = read(&folder, "page.html");
    let said = format!("10 rows of {rows} are shown, {} are left out.", rows - 10);
    for part in [said.as_str(), "least of", "greatest of", "How much light do these places get?", "Is the rule met?"] {
        assert!(page.contains(part), "{part}");
    }
    let hours = page.split("<h2>").next().expect("a section");
    assert_eq!(hours.matches("<tr><td").count(), 10);
}

/// A wall of 900 receivers before a lit one makes 1 newly broken rule, which the page counts and
/// shows as the first row.
#[test]
fn newly_broken_rules_stand_first() {
    let folder = judged();
    folder.write("wall.obj", "o wall\nv -40 -6 0\nv 50 -6 0\nv 50 -6 40\nv -40 -6 40\nf 1 2 3 4\n");
    folder.run("update site.helio --add wall.obj -o after.helio");
    folder.run("sunlight after.helio --before site.helio --rule own.toml --zone +01:00 -o both.csv");
    let said = stderr(&folder.run("report both.csv -o page.html"));
    assert!(said.ends_with("own: 3 broken, 900 met, 1 not applicable, 1 newly broken\n"), "{said}");
    let page = read(&folder, "page.html");
    let rows: Vec<&str> = page.split("<tr><td>").skip(1).collect();
    assert!(rows.len() == 100 && rows[0].starts_with("south<") && rows[1].starts_with("n9<"), "{page}");
}

/// A table that was edited, one without its metadata, a Parquet table, and an output that is a file
/// beside a table are refused, 6 of 6, and a map of another archive is left out with a note.
#[test]
fn tables_that_nothing_vouches_for_are_refused() {
    let folder = judged();
    folder.fails("report sun.csv -o sun.csv", "input same-file sun.csv sun.csv");
    let beside = "sun.csv-metadata.json";
    folder.fails(&format!("report sun.csv -o {beside}"), &format!("input same-file {beside} {beside}"));
    folder.fails("report sun.csv -o sun.png", "input same-file sun.png sun.png");
    folder.fails("report scene.obj -o page.html", "input ending scene.obj");
    folder.fails("report receivers.csv -o page.html", "input lacks receivers.csv metadata");
    let table = read(&folder, "sun.csv");
    folder.write("sun.csv", &table.replace("broken", "met"));
    folder.fails("report sun.csv -o page.html", "input damaged sun.csv");
    folder.refused("report sun.csv -o page.html", &["write it again: heliotile sunlight site.helio --rule own.toml"]);
    assert!(!folder.path("page.html").exists());
    folder.write("sun.csv", &table);
    folder.run("replay site.helio --conditions conditions.csv --columns total -o other.csv");
    fs::copy(folder.path("sun.png"), folder.path("other.png")).expect("copied");
    folder.run("build scene.obj -m materials.toml -r receivers.csv --latitude 40 --longitude 5 -o far.helio");
    folder.run("replay far.helio --conditions conditions.csv --columns total -o other.csv");
    let said = stderr(&folder.run("report other.csv -o page.html"));
    assert!(said.contains("other.png is left out") && !read(&folder, "page.html").contains("<img"), "{said}");
}
