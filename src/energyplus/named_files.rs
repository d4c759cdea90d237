//! Files that a model names. In: a model that is to be written into another folder. Out: the model
//! with absolute paths of the files that lie beside it, and a list of files that were not found.

use std::env;
use std::path::{Path, PathBuf};

use super::document::{Document, FieldEdit, Form, ModelObject};
use heliotile_core::error::{Error, Result};
use heliotile_core::text::{Message, with_list};

/// Classes whose objects name a file, with the field number and the key of the name (Input Output
/// Reference 25.2).
const NAMES: [(&str, usize, &str); 12] = [
    ("Schedule:File", 3, "file_name"),
    ("Schedule:File:Shading", 1, "file_name"),
    ("Construction:WindowDataFile", 2, "file_name"),
    ("Table:IndependentVariable", 8, "external_file_name"),
    ("Table:Lookup", 8, "external_file_name"),
    ("Coil:DX:ASHRAE205:Performance", 2, "representation_file_name"),
    ("Chiller:Electric:ASHRAE205", 2, "representation_file_name"),
    ("ExternalInterface:FunctionalMockupUnitImport", 1, "fmu_file_name"),
    ("ExternalInterface:FunctionalMockupUnitImport:From:Variable", 3, "fmu_file_name"),
    ("ExternalInterface:FunctionalMockupUnitImport:To:Schedule", 3, "fmu_file_name"),
    ("ExternalInterface:FunctionalMockupUnitImport:To:Actuator", 5, "fmu_file_name"),
    ("ExternalInterface:FunctionalMockupUnitImport:To:Variable", 2, "fmu_file_name"),
];

/// Result of making file names absolute.
#[derive(Debug, Default, PartialEq)]
pub struct NamedFiles {
    /// Sentences on the changes.
    pub notes: Vec<Message>,
    /// Sentences on files that the user has to copy.
    pub warnings: Vec<Message>,
}

/// Writes names of files as absolute paths: EnergyPlus looks for relative ones beside the model,
/// which moves.
pub fn make_absolute(document: &mut Document) -> Result<NamedFiles> {
    let model = std::path::absolute(&document.file).map_err(Error::io(&document.file, "find the folder of"))?;
    let mut roots: Vec<PathBuf> = model.parent().map(Path::to_owned).into_iter().collect();
    roots.extend(env::current_dir());
    let (mut whole, mut lost, mut edits) = (Vec::new(), Vec::new(), Vec::new());
    for (i, object) in document.objects.iter().enumerate() {
        let Some((_, place, key)) = NAMES.into_iter().find(|(class, ..)| object.is(class)) else { continue };
        let name = object.text(place, key);
        // EnergyPlus takes both slashes on any system.
        let path = PathBuf::from(if cfg!(windows) { name.to_owned() } else { name.replace('\\', "/") });
        if name.is_empty() || path.is_absolute() {
            continue;
        }
        let found = roots.iter().map(|root| root.join(&path)).find(|path| path.is_file());
        let found = found.and_then(|path| path.to_str().map(str::to_owned));
        match found.filter(|path| document.form == Form::EpJson || !path.contains([',', ';', '!', '\n', '\r'])) {
            Some(path) => {
                whole.push(name.to_owned());
                edits.push(FieldEdit { object: i, place, key, text: path });
            }
            None => lost.push(format!("`{name}` of {}", object.title())),
        }
    }
    document.edit(edits)?;
    lost.extend(plugins(document));
    let mut done = NamedFiles::default();
    if !whole.is_empty() {
        whole.sort();
        whole.dedup();
        done.notes.push(with_list("file names in the model now include the folder", whole));
    }
    if !lost.is_empty() {
        let what = format!("EnergyPlus looks for these files beside the new model: copy them there ({})", lost.len());
        done.warnings.push(with_list(&what, lost));
    }
    Ok(done)
}

/// Returns the Python modules of the model, which are found by module name and not by a file name.
fn plugins(document: &Document) -> Vec<String> {
    let named = |object: &ModelObject| format!("`{}.py` of {}", object.text(3, "python_module_name"), object.title());
    document.of("PythonPlugin:Instance").map(named).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two of five names, of files beside the model, become absolute in both forms, one of them
    /// with a backslash. An absolute name stays; a name without a file and a module of Python are
    /// warned of.
    #[test]
    fn names_of_files_become_whole() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(folder.path().join("data")).expect("made");
        for name in ["half.csv", "data/shade.csv"] {
            std::fs::write(folder.path().join(name), "1\n").expect("written");
        }
        let idf = "Schedule:File,Half,,half.csv,1,0;\nSchedule:File:Shading, data\\shade.csv;\nSchedule:File,Far,,/far/x.csv,1,0;\n\
                   Table:Lookup,T,,,,,,,lost.csv,1,1;\nPythonPlugin:Instance,P,No,module,Class;\n";
        let json = r#"{"Schedule:File": {"Half": {"file_name": "half.csv"}, "Far": {"file_name": "/far/x.csv"}},
            "Schedule:File:Shading": {"s": {"file_name": "data\\shade.csv"}}, "Table:Lookup": {"T": {"external_file_name": "lost.csv"}},
            "PythonPlugin:Instance": {"P": {"python_module_name": "module"}}}"#;
        for (name, text) in [("m.idf", idf), ("m.epJSON", json)] {
            let mut document = Document::read(&folder.path().join(name), text.as_bytes().to_vec()).expect("a model");
            let done = make_absolute(&mut document).expect("found");
            assert_eq!((done.notes.len(), done.warnings.len()), (1, 1), "{done:?}");
            assert!(
                done.warnings[0].contains("(2)") && done.warnings[0].contains("`lost.csv` of Table:Lookup `T`"),
                "{done:?}"
            );
            let written = String::from_utf8(document.bytes()).expect("text");
            for file in ["half.csv", "data/shade.csv"] {
                let whole = folder.path().join(file);
                assert!(written.contains(whole.to_str().expect("a path")), "{written}");
            }
            let again = Document::read(&folder.path().join(name), written.into_bytes()).expect("a model");
            assert_eq!(
                again.of("Schedule:File").filter(|file| Path::new(file.text(3, "file_name")).is_absolute()).count(),
                2
            );
        }
    }
}
