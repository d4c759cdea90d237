//! Checks of a model before light is injected. In: a model. Out: a refusal, or warnings of the
//! parts that will not use the injected light.

use std::collections::{BTreeMap, BTreeSet};

use super::document::{Document, Form, ModelObject};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::{Message, message, with_list};
use heliotile_scene::ModelVersion;

/// EnergyPlus version whose rules were measured.
const VERSION: ModelVersion = ModelVersion { major: 25, minor: 2 };
/// Oldest version whose models [`VERSION`] runs as they are, with a warning; it stops at objects
/// that changed since.
const OLDEST_RUN: ModelVersion = ModelVersion { major: 24, minor: 1 };

/// Classes whose objects are surfaces with a name of their own.
const SURFACES: [&str; 22] = [
    "BuildingSurface:Detailed",
    "Wall:Detailed",
    "RoofCeiling:Detailed",
    "Floor:Detailed",
    "FenestrationSurface:Detailed",
    "Wall:Exterior",
    "Wall:Adiabatic",
    "Wall:Underground",
    "Wall:Interzone",
    "Roof",
    "Ceiling:Adiabatic",
    "Ceiling:Interzone",
    "Floor:GroundContact",
    "Floor:Adiabatic",
    "Floor:Interzone",
    "Window",
    "GlazedDoor",
    "Door",
    "Window:Interzone",
    "GlazedDoor:Interzone",
    "Door:Interzone",
    "InternalMass",
];

/// Classes of openings, each with the field number of its wall's name.
const OPENINGS: [(&str, usize); 4] =
    [("FenestrationSurface:Detailed", 4), ("Window", 3), ("GlazedDoor", 3), ("Door", 3)];

/// Control type of the actuators that are added.
const ACTUATED: &str = "View Factor To Ground";

/// Refuses a model that cannot work. `assumed` is the version that the model is taken for, whatever
/// it states.
pub fn check(document: &Document, assumed: Option<ModelVersion>) -> Result<()> {
    version_note(document, assumed)?;
    check_names(document)?;
    let actuators = document.of("EnergyManagementSystem:Actuator");
    if let Some(actuator) = actuators.into_iter().find(|a| a.text(4, "actuated_component_control_type") == ACTUATED) {
        let surface = actuator.text(2, "actuated_component_unique_name");
        let what =
            format!("{} sets `{ACTUATED}` of `{surface}` already: light would be injected twice", actuator.title());
        let hint = "give the original model, without the objects that heliotile added";
        return Err(Error::input(&document.file, line(actuator), what, hint).because(Problem::duplicate(surface)));
    }
    Ok(())
}

fn line(object: &ModelObject) -> Option<usize> {
    (object.line > 0).then_some(object.line)
}

/// Returns a warning about a model of another version; refuses a version that cannot be run.
fn version_note(document: &Document, assumed: Option<ModelVersion>) -> Result<Option<String>> {
    let Some(object) = document.of("Version").next() else { return Ok(None) };
    let text = object.text(1, "version_identifier");
    let stated = ModelVersion::parse(text);
    let version = assumed.or(stated);
    if version == Some(VERSION) {
        let other = stated != Some(VERSION);
        return Ok(other.then(|| {
            format!(
                "the model states EnergyPlus {text} but is read as {VERSION}: EnergyPlus {VERSION} warns of that, and stops at objects \
                 that differ between these versions"
            )
        }));
    }
    if assumed.is_none() && version.is_some_and(|version| (OLDEST_RUN..VERSION).contains(&version)) {
        return Ok(Some(format!(
            "the model was written for EnergyPlus {text}: EnergyPlus {VERSION} runs it with a warning, but stops at objects that changed \
             since; the Transition tool converts it to {VERSION}"
        )));
    }
    let version = version.map_or_else(|| text.to_owned(), |version| version.to_string());
    let what = format!("is a model for EnergyPlus {version}, but the result is to run in {VERSION}");
    Err(Error::input(&document.file, line(object), what, how_to_bring(document.form, &version))
        .because(Problem::OtherVersion(version.to_string())))
}

/// Returns the hint how to convert a model of a version to one that runs.
fn how_to_bring(form: Form, version: &str) -> Message {
    let newer = ModelVersion::parse(version).is_some_and(|version| version > VERSION);
    let way = match form {
        _ if newer => format!(
            "no tool converts models to an older version: export it for {VERSION} from the program that made it"
        ),
        Form::Idf => {
            format!("convert it to {VERSION} with the Transition tool (IDFVersionUpdater) that comes with EnergyPlus")
        }
        Form::EpJson => format!(
            "convert it to IDF with the ConvertInputFormat of EnergyPlus {version}, then to {VERSION} with the Transition tool, which \
             reads IDF only"
        ),
    };
    message!("{way}; if EnergyPlus {VERSION} runs it as it is, give {{assume_version}} {VERSION}")
}

fn check_names(document: &Document) -> Result<()> {
    let mut seen: BTreeMap<String, &ModelObject> = BTreeMap::new();
    for object in document.objects.iter().filter(|object| SURFACES.iter().any(|class| object.is(class))) {
        if object.name().contains('\u{fffd}') {
            let what = format!("{}: the name is not UTF-8", object.title());
            return Err(Error::input(&document.file, line(object), what, "save the model in UTF-8"));
        }
        if let Some(other) = seen.insert(object.name().to_uppercase(), object) {
            let at = line(other).map_or(String::new(), |line| format!(" (line {line})"));
            let what = format!(
                "{} has the same name as {}{at}: EnergyPlus accepts each name of a surface once",
                object.title(),
                other.title()
            );
            return Err(Error::input(&document.file, line(object), what, "give every surface a name of its own")
                .because(Problem::duplicate(object.name())));
        }
    }
    Ok(())
}

/// Returns the openings of walls in `injected` that are not in there themselves, each with the name
/// of its wall. Names are in small letters.
pub fn openings_left_out(document: &Document, injected: &BTreeSet<String>) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for object in &document.objects {
        let Some((_, place)) = OPENINGS.into_iter().find(|(class, _)| object.is(class)) else { continue };
        let wall = object.text(place, "building_surface_name").to_lowercase();
        if injected.contains(&wall) && !injected.contains(&object.name().to_lowercase()) {
            found.push((object.name().to_owned(), wall));
        }
    }
    found
}

/// Returns warnings of results that EnergyPlus will get wrong under injection. `injected` are names
/// in small letters.
pub fn warnings(document: &Document, assumed: Option<ModelVersion>, injected: &BTreeSet<String>) -> Vec<Message> {
    let mut found: Vec<Message> =
        version_note(document, assumed).ok().flatten().into_iter().map(Message::from).collect();
    let mut say = |what: &str, names: Vec<String>| {
        if !names.is_empty() {
            found.push(with_list(format!("{what} ({})", names.len()), names));
        }
    };
    let controls = |place, key: &'static str, words: &'static [&'static str]| -> Vec<String> {
        let has = |object: &&ModelObject| {
            let text = object.text(place, key).to_lowercase();
            words.iter().any(|word| text.contains(word))
        };
        document.of("WindowShadingControl").filter(has).map(|object| object.name().to_owned()).collect()
    };
    say(
        "exterior blinds and screens: EnergyPlus treats light reflected by walls as if it came from the ground (in one case cooling was 6 \
         % too high; without reflections it was off by 28 %)",
        controls(4, "shading_type", &["exteriorblind", "exteriorscreen"]),
    );
    say(
        "blinds inside or between panes: EnergyPlus treats light reflected by walls as if it came from the ground",
        controls(4, "shading_type", &["interiorblind", "betweenglassblind"]),
    );
    say(
        "shading controls follow the incident sun that EnergyPlus reports, which is wrong on injected surfaces: they switch at other times",
        controls(6, "shading_control_type", &["solaronwindow"]),
    );
    let named = |class: &str| document.of(class).map(|object| object.name().to_owned()).collect::<Vec<_>>();
    say(
        "complex fenestration (BSDF): EnergyPlus treats light reflected by walls as if it came from the ground",
        named("Construction:ComplexFenestrationState"),
    );
    say(
        "daylighting controls ignore the injected light: EnergyPlus computes reflections of daylight by itself",
        [named("Daylighting:Controls"), named("Daylighting:DELight:Controls")].concat(),
    );
    let on_injected =
        |object: &&ModelObject| object.texts().skip(1).any(|text| injected.contains(&text.to_lowercase()));
    let gains = [
        "Generator:Photovoltaic",
        "Generator:PVWatts",
        "SolarCollector:FlatPlate:Water",
        "SolarCollector:FlatPlate:PhotovoltaicThermal",
    ];
    say(
        "PV modules and solar collectors read the incident sun that EnergyPlus reports, which is wrong on injected surfaces: use \
         irradiance computed by heliotile for them",
        gains.iter().flat_map(|class| document.of(class)).filter(on_injected).map(ModelObject::title).collect(),
    );
    found.push(
        "EnergyPlus's outputs of incident and ground-reflected sun on injected surfaces are wrong, at windows by up to 42 %; absorbed and \
         transmitted sun and loads are right"
            .into(),
    );
    found
}
