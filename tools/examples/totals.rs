//! From a city model to a year's sun: reads a scene, traces it once, replays a weather file and
//! prints what each receiver gets.
//!
//! `cargo run --release --example totals -- SCENE WEATHER FOLDER`

use heliotile::{ReplayRequest, Resources, SceneRequest, Silent, Site, SiteArchiveRequest};

fn main() -> heliotile::Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match words.as_slice() {
        [scene, weather, folder] => totals(scene, weather, folder),
        _ => Err(heliotile::Error::argument("words", "are not three", "SCENE WEATHER FOLDER")),
    }
}

fn totals(scene: &str, weather: &str, folder: &str) -> heliotile::Result<()> {
    let archive = SiteArchiveRequest::new(SceneRequest::of([scene]), folder).build(&Silent)?;
    for receiver in Site::open(archive)?.totals(&ReplayRequest::new(weather), &Resources::usual())? {
        println!("{}: {:.1} kWh/m2", receiver.id, receiver.kwh_m2);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    /// The scene of a house in a street is traced, and its receivers get their sums over three
    /// days.
    #[test]
    fn totals_of_a_town() {
        let folder = tempfile::tempdir().expect("a folder");
        let data = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data");
        let (scene, weather) =
            (format!("{data}/cityjson/small.city.jsonl"), format!("{data}/weather/golden_3_days.epw"));
        super::totals(&scene, &weather, &folder.path().to_string_lossy()).expect("totals");
    }
}
