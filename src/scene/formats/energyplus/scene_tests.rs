//! In: one EnergyPlus model in both of its syntaxes. Out: proof that they give the same scene.

use std::path::Path;

use crate::Scene;

/// An IDF file and the epJSON that EnergyPlus made of it give the same scene of 6 materials, byte
/// for byte. A model in a file named `.json` is read too.
#[test]
fn both_syntaxes_give_the_same_scene() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/energyplus");
    let load = |path: &Path| Scene::load(path, None).expect("readable");
    let (text, json) = (load(&data.join("box.idf")), load(&data.join("box.epJSON")));
    assert_eq!(text.content_hash(), json.content_hash());
    let folder = tempfile::tempdir().expect("a scratch folder");
    let plain = folder.path().join("box.json");
    std::fs::copy(data.join("box.epJSON"), &plain).expect("copied");
    assert_eq!(text.content_hash(), load(&plain).content_hash());
    let names: Vec<&str> = text.materials.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names, ["Glass", "Wall", "Wall (2)", "shading", "shading 0.35", "shading transmittance 0.5"]);
    assert_eq!((text.report.faces_read, text.report.warnings.as_slice()), (28, &[][..]));
}
