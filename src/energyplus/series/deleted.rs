//! Removal of surroundings from a model. In: a model. Out: the model without its surroundings;
//! shades of zones stay.

use std::collections::BTreeSet;

use crate::document::{Document, ModelObject};

/// Classes of shades that belong to no zone.
const SURROUNDINGS: [&str; 4] =
    ["Shading:Site", "Shading:Site:Detailed", "Shading:Building", "Shading:Building:Detailed"];

/// Class of the reflectances of shades.
const REFLECTANCE: &str = "ShadingProperty:Reflectance";

/// Result of a removal.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Deleted {
    pub shades: usize,
    /// Names of shades that other objects stand on, such as modules: they stay.
    pub kept: Vec<String>,
}

/// Removes the shades around a model, and their reflectances.
pub fn delete(document: &mut Document) -> Deleted {
    let is_shade = |object: &ModelObject| SURROUNDINGS.iter().any(|class| object.is(class));
    let says_nothing = |object: &ModelObject| {
        is_shade(object) || object.is(REFLECTANCE) || object.class.to_lowercase().starts_with("output")
    };
    let others = document.objects.iter().filter(|object| !says_nothing(object));
    let used: BTreeSet<String> = others.flat_map(|object| object.texts().skip(1)).map(str::to_lowercase).collect();
    let is_used = |object: &ModelObject| used.contains(&object.name().to_lowercase());
    let (kept, gone): (Vec<&ModelObject>, Vec<&ModelObject>) =
        document.objects.iter().filter(|object| is_shade(object)).partition(|object| is_used(object));
    let kept = kept.into_iter().map(|object| object.name().to_owned()).collect();
    let gone: BTreeSet<String> = gone.into_iter().map(|object| object.name().to_lowercase()).collect();
    let shades = document.remove(|object| is_shade(object) && gone.contains(&object.name().to_lowercase()));
    document.remove(|object| {
        object.is(REFLECTANCE) && gone.contains(&object.text(1, "shading_surface_name").to_lowercase())
    });
    Deleted { shades, kept }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// Two of 3 shades around a model leave it, with the reflectance of 1. The shade that a module
    /// stands on stays, and the fin of a zone; in both forms.
    #[test]
    fn free_shades_leave_and_used_ones_stay() {
        let idf = "Version, 25.2;\nShading:Site:Detailed, A, , 0;\nShading:Building, B;\nShading:Site, C;\n\
                   Generator:Photovoltaic, p, C;\nShading:Zone:Detailed, F, wall;\nShadingProperty:Reflectance, a, 0.5;\n";
        let json = r#"{"Shading:Site:Detailed": {"A": {}}, "Shading:Building": {"B": {}}, "Shading:Site": {"C": {}},
            "Generator:Photovoltaic": {"p": {"surface_name": "C"}}, "Shading:Zone:Detailed": {"F": {}, "G": {}},
            "ShadingProperty:Reflectance": {"r": {"shading_surface_name": "a"}}}"#;
        for (name, text) in [("a.idf", idf), ("a.epJSON", json)] {
            let mut document = Document::read(Path::new(name), text.into()).expect("a model");
            let deleted = delete(&mut document);
            assert_eq!(deleted, Deleted { shades: 2, kept: vec!["C".into()] }, "{name}");
            let again = Document::read(Path::new(name), document.bytes()).expect("a model");
            let left: Vec<&str> = again.objects.iter().map(|object| object.class.as_str()).collect();
            assert_eq!(left, document.objects.iter().map(|object| object.class.as_str()).collect::<Vec<_>>());
            assert!(left.contains(&"Shading:Site") && left.contains(&"Shading:Zone:Detailed"), "{left:?}");
            assert!(!left.contains(&"Shading:Site:Detailed") && !left.contains(&REFLECTANCE), "{left:?}");
        }
    }
}
