//! Tests of rows, of filling, and of fields that exclude or need each other.

use super::*;

/// Place.
#[derive(Debug, Default, PartialEq, Request)]
struct Place {
    /// Latitude, degrees
    #[field(range = -90.0..=90.0, says = "give degrees from -90 to 90", metavar = "DEGREES")]
    latitude_deg: Option<f64>,
}

/// A request with fields of each kind.
#[derive(Debug, Default, PartialEq, Request)]
#[request(at_most_one("steps", "rule"))]
struct Asked {
    /// Weather file
    #[field(input = Weather, short = 'w', required)]
    weather: PathBuf,
    #[field(flatten, heading = "Place")]
    place: Place,
    /// Number of sun positions
    #[field(range = 1..=60)]
    steps: Option<u16>,
    /// Rules, by name
    #[field(delimiter = ',')]
    rule: Vec<String>,
    /// Leave the scene out.
    #[field(negated = "no_scene")]
    with_scene: bool,
    /// Schedules of reflectances
    #[field(input = Any, metavar = "GROUP=FILE")]
    schedule: Vec<(String, PathBuf)>,
    /// Folder to write
    #[field(output = Folder(&["receivers.csv"]), conflicts("rule"), python = "to", neutral)]
    folder: Option<PathBuf>,
    #[field(skip)]
    known: u8,
}

fn asked(given: &[(&str, &[&str])]) -> Result<Asked, Refused> {
    let text = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
    let given: Vec<_> = given.iter().map(|(name, texts)| ((*name).to_owned(), text(texts))).collect();
    filled(&given)
}

/// Seven rows have the names of their fields without units, their forms and roles; a flattened
/// struct's stand under its heading.
#[test]
fn rows_follow_the_fields() {
    let rows = Asked::rows();
    let names: Vec<&str> = rows.iter().map(|row| row.name).collect();
    assert_eq!(names, ["weather", "latitude", "steps", "rule", "no_scene", "schedule", "folder"]);
    let [weather, latitude, steps, rule, no_scene, schedule, folder] = rows.as_slice() else { panic!("{names:?}") };
    assert_eq!((weather.short, weather.role), (Some('w'), Role::Input(InputKind::Weather)));
    assert_eq!((latitude.heading, latitude.metavar, latitude.many), (Some("Place"), Some("DEGREES"), Many::Optional));
    assert_eq!((steps.form.python, steps.role), ("int", Role::Value));
    assert_eq!((rule.many, rule.delimiter), (Many::List, Some(',')));
    assert_eq!(
        (no_scene.many, no_scene.negated, no_scene.help.plain().as_str()),
        (Many::Flag, true, "Leave the scene out")
    );
    assert_eq!(schedule.many, Many::List);
    assert_eq!(folder.role, Role::Output(OutputKind::Folder(&["receivers.csv"])));
    assert_eq!((folder.conflicts, folder.python), (["rule"].as_slice(), Some("to")));
    assert_eq!(Asked::groups(), [Group { kind: GroupKind::AtMostOne, names: &["steps", "rule"] }]);
    assert!(weather.required && (steps.test)("61").is_err() && (steps.test)("60").is_ok());
}

/// Texts fill fields; files come with their roles. Five wrong texts are refused, each with its
/// field.
#[test]
fn texts_fill_fields() {
    let all = asked(&[
        ("weather", &["a.epw", "b.epw"]),
        ("latitude", &["52.1"]),
        ("rule", &["one", "two"]),
        ("no_scene", &[]),
        ("schedule", &["roof=roof.csv"]),
    ]);
    let all = all.expect("a request");
    assert_eq!((all.weather.as_path(), all.place.latitude_deg), (Path::new("b.epw"), Some(52.1)));
    assert_eq!((all.rule.len(), all.with_scene, all.folder.is_none(), all.known), (2, false, true, 0));
    let mut files = Vec::new();
    all.files(&mut |name, role, path| files.push((name, role, path.to_owned())));
    let any = Role::Input(InputKind::Any);
    assert_eq!(files[0], ("weather", Role::Input(InputKind::Weather), "b.epw".into()));
    assert_eq!(files[1..], [("schedule", any, "roof.csv".into())]);
    for (name, text, says, kind) in [
        ("latitude", "91", "give degrees from -90 to 90", "out-of-range"),
        ("steps", "0", "0 is not in 1..=60", "out-of-range"),
        ("steps", "two", "two is not in", "unreadable"),
        ("schedule", "roof", "give NAME=VALUE", "unreadable"),
        ("weather", "", "a value is required", "unreadable"),
    ] {
        let refused = asked(&[(name, &[text])]).expect_err(text);
        assert!(
            refused.fields == [name] && (refused.what.contains(says) || refused.hint.contains(says)),
            "{refused:?}"
        );
        assert_eq!(refused.problem.name(), kind, "{text}");
    }
    let misspelt = asked(&[("weathr", &["a"])]).expect_err("misspelt");
    assert!(matches!(&misspelt.problem, Problem::Unknown { found, .. } if found == "weathr"), "{misspelt:?}");
}

/// Numbers that a program sets are judged like texts, those of flattened structs too: 3 of 5 are
/// refused, with their field and range; NaN is one of them.
#[test]
fn numbers_stay_in_their_range() {
    let with = |steps, latitude_deg| Asked { steps, place: Place { latitude_deg }, ..Asked::default() };
    assert_eq!(with(None, None).in_range().and(with(Some(60), Some(-90.0)).in_range()), Ok(()));
    for (request, field, (least, most)) in [
        (with(Some(61), None), "steps", (1.0, 60.0)),
        (with(None, Some(90.5)), "latitude", (-90.0, 90.0)),
        (with(Some(1), Some(f64::NAN)), "latitude", (-90.0, 90.0)),
    ] {
        let refused = request.in_range().expect_err(field);
        let range = match refused.problem {
            Problem::OutOfRange { least, most, .. } => (least, most),
            _ => (0.0, 0.0),
        };
        assert_eq!((refused.fields.as_slice(), range), ([field.to_owned()].as_slice(), (least, most)));
    }
}

/// Two of 5 sets of filled fields are complete: the others lack what is required, or name two
/// fields that exclude each other.
#[test]
fn fields_exclude_and_need_each_other() {
    let complete = |filled: &[&str]| {
        complete(&Asked::rows(), &Asked::groups(), filled)
            .map_err(|refused| (refused.fields.join(", "), refused.problem.name()))
    };
    assert_eq!(complete(&["weather"]), Ok(()));
    assert_eq!(complete(&["weather", "rule", "latitude"]), Ok(()));
    assert_eq!(complete(&["rule"]), Err(("weather".to_owned(), "missing")));
    assert_eq!(complete(&["weather", "rule", "folder"]), Err(("folder".to_owned(), "excludes")));
    assert_eq!(complete(&["weather", "rule", "steps"]), Err(("steps, rule".to_owned(), "excludes")));
}
