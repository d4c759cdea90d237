//! Receivers and weather in memory: traces ten points above the middle of a scene, and replays two
//! hours.
//!
//! `cargo run --release --example memory -- SCENE SITE.helio`

use heliotile::{
    AccuracyRequest, Output, Receiver, ReplayRequest, Resources, Scene, SceneRequest, Silent, Site, SiteBuild,
};

fn main() -> heliotile::Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [scene, archive] = words.as_slice() else {
        return Err(heliotile::Error::argument("words", "are not two", "SCENE SITE.helio"));
    };
    totals(scene, archive)?.iter().for_each(|(point, kwh_m2)| println!("{point}: {kwh_m2:.3} kWh/m2"));
    Ok(())
}

fn totals(scene: &str, archive: &str) -> heliotile::Result<Vec<(String, f64)>> {
    let scene = Scene::load_site(&SceneRequest::of([scene]).site()?)?;
    let point = |i: u8| {
        let height_m = 100.0 + f64::from(i);
        Receiver::new(format!("p{i}"), scene.mesh.origin + height_m * glam::DVec3::Z, glam::DVec3::Z)
    };
    let receivers: Vec<Receiver> = (0..10).map(point).collect();
    SiteBuild::new(&scene, &receivers[..], &AccuracyRequest::default()).build(&Output::new(archive), &Silent)?;
    let weather = "time,ghi,dni,dhi\n2021-06-21T11:00+01:00,800,700,150\n2021-06-21T12:00+01:00,820,720,150\n";
    let files = |_: &std::path::Path| Ok(weather.into());
    let resources = Resources { files: &files, ..Resources::usual() };
    let all = Site::open(archive)?.totals(&ReplayRequest::new("weather.csv"), &resources)?;
    Ok(all.into_iter().map(|total| (total.id, total.kwh_m2)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Ten points above all roofs get the direct and diffuse light of two hours on a horizontal
    /// plane, 1.5 to 1.7 kWh/m2.
    #[test]
    fn points_in_memory_get_light() {
        let folder = tempfile::tempdir().expect("a folder");
        let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/cityjson/small.city.jsonl");
        let archive = folder.path().join("site.helio");
        let found = totals(scene, &archive.to_string_lossy()).expect("totals");
        assert_eq!(found.len(), 10);
        assert!(found.iter().all(|(_, kwh_m2)| (1.5..1.7).contains(kwh_m2)), "{found:?}");
    }

    /// No receivers, a position or a normal that is none, and a name that is there twice are
    /// refused, and no file is written.
    #[test]
    fn wrong_receivers_in_memory_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/cityjson/small.city.jsonl");
        let site = SceneRequest::of([scene]).site().expect("a site");
        let scene = Scene::load_site(&site).expect("a scene");
        let at = |name: &str, z, normal| Receiver::new(name.into(), DVec3::new(0.0, 0.0, z), normal);
        let (accuracy, output) = (AccuracyRequest::default(), Output::new(folder.path().join("site.helio")));
        for (receivers, said) in [
            (vec![], "there are none"),
            (vec![at("a", f64::NAN, DVec3::Z)], "not finite"),
            (vec![at("a", 1.0, DVec3::ZERO)], "length is not 1"),
            (vec![at("a", 1.0, DVec3::Z), at("a", 2.0, DVec3::Z)], "no name of its own"),
        ] {
            let done = SiteBuild::new(&scene, &receivers[..], &accuracy).build(&output, &Silent);
            let error = done.err().map(|error| error.to_string()).unwrap_or_default();
            assert!(error.contains(said), "{said}: {error}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
    }
}
