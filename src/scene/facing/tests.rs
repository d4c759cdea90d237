//! Generated solids with faults: they have the areas by kind of the sound solids, or a warning
//! names them.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use glam::DVec3;

use crate::Scene;
use crate::covering::surfaces::Surfaces;
use crate::site::{Part, SceneFiles};
use crate::test_files::{TestFolder, areas_m2, load_text};
use heliotile_core::hemisphere::{mix, unit};
use heliotile_core::site::semantics::SurfaceKind;

/// A face of a solid: outline, holes and semantics.
#[derive(Clone)]
struct Drawn {
    rings: Vec<Vec<DVec3>>,
    semantics: &'static str,
    /// Area that a right reading finds, m2.
    area_m2: f64,
}

/// Random numbers of one solid.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = mix(self.0, 7);
        low + (high - low) * unit(self.0)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.between(0.0, count as f64) as usize).min(count - 1)
    }
}

/// Returns the area vector of a flat ring, m2.
fn area(ring: &[DVec3]) -> DVec3 {
    let after = ring.iter().cycle().skip(1);
    ring.iter().zip(after).map(|(a, b)| 0.5 * (*a - ring[0]).cross(*b - ring[0])).sum()
}

fn drawn(rings: Vec<Vec<DVec3>>, semantics: &'static str) -> Drawn {
    let area_m2 = area(&rings[0]).length() - rings[1..].iter().map(|hole| area(hole).length()).sum::<f64>();
    Drawn { rings, semantics, area_m2 }
}

/// Returns floor, flat roof and walls over an outline that turns counter-clockwise, with a court
/// that turns clockwise.
fn prism(outline: &[[f64; 2]], court: &[[f64; 2]], height: f64) -> Vec<Drawn> {
    let at =
        |points: &[[f64; 2]], z: f64| -> Vec<DVec3> { points.iter().map(|[x, y]| DVec3::new(*x, *y, z)).collect() };
    let level = |z: f64| if court.is_empty() { vec![at(outline, z)] } else { vec![at(outline, z), at(court, z)] };
    let mut faces = vec![drawn(level(height), "RoofSurface")];
    let mut floor = level(0.0);
    floor.iter_mut().for_each(|ring| ring.reverse());
    faces.push(drawn(floor, "GroundSurface"));
    for ring in [outline, court] {
        for (i, [x, y]) in ring.iter().enumerate() {
            let [u, v] = ring[(i + 1) % ring.len()];
            let corner = DVec3::new;
            let wall = vec![corner(*x, *y, 0.0), corner(u, v, 0.0), corner(u, v, height), corner(*x, *y, height)];
            faces.push(drawn(vec![wall], "WallSurface"));
        }
    }
    faces
}

/// Returns a house with a gable: two roof faces, two rectangular walls and two of five corners.
fn gabled(w: f64, d: f64, h: f64, rise: f64) -> Vec<Drawn> {
    let p = DVec3::new;
    let (ridge0, ridge1) = (p(0.5 * w, 0.0, h + rise), p(0.5 * w, d, h + rise));
    let mut faces = vec![
        drawn(vec![vec![p(0.0, 0.0, h), ridge0, ridge1, p(0.0, d, h)]], "RoofSurface"),
        drawn(vec![vec![p(w, 0.0, h), p(w, d, h), ridge1, ridge0]], "RoofSurface"),
        drawn(vec![vec![p(0.0, 0.0, 0.0), p(0.0, d, 0.0), p(w, d, 0.0), p(w, 0.0, 0.0)]], "GroundSurface"),
        drawn(vec![vec![p(0.0, 0.0, 0.0), p(w, 0.0, 0.0), p(w, 0.0, h), ridge0, p(0.0, 0.0, h)]], "WallSurface"),
        drawn(vec![vec![p(w, d, 0.0), p(0.0, d, 0.0), p(0.0, d, h), ridge1, p(w, d, h)]], "WallSurface"),
        drawn(vec![vec![p(w, 0.0, 0.0), p(w, d, 0.0), p(w, d, h), p(w, 0.0, h)]], "WallSurface"),
    ];
    faces.push(drawn(vec![vec![p(0.0, d, 0.0), p(0.0, 0.0, 0.0), p(0.0, 0.0, h), p(0.0, d, h)]], "WallSurface"));
    // Roof faces look up.
    for face in &mut faces[..2] {
        if area(&face.rings[0]).z < 0.0 {
            face.rings[0].reverse();
        }
    }
    faces
}

fn solid(random: &mut Random) -> Vec<Drawn> {
    let (w, d, h) = (random.between(4.0, 40.0), random.between(4.0, 40.0), random.between(2.5, 30.0));
    let (x, y) = (w * random.between(0.3, 0.7), d * random.between(0.3, 0.7));
    match random.below(4) {
        0 => prism(&[[0.0, 0.0], [w, 0.0], [w, d], [0.0, d]], &[], h),
        1 => prism(&[[0.0, 0.0], [w, 0.0], [w, y], [x, y], [x, d], [0.0, d]], &[], h),
        2 => {
            let (a, b) = (0.25 * w, 0.25 * d);
            let court = [[a, b], [a, d - b], [w - a, d - b], [w - a, b]];
            prism(&[[0.0, 0.0], [w, 0.0], [w, d], [0.0, d]], &court, h)
        }
        _ => gabled(w, d, h, random.between(1.0, 6.0)),
    }
}

/// Faults; each is put on solids alone and together with others.
const FAULTS: [&str; 9] =
    ["none", "turned", "all turned", "doubled", "doubled reversed", "two-sided", "crossed", "shifted", "missing"];

/// Puts a fault on a solid.
fn spoil(faces: &mut Vec<Drawn>, fault: &str, random: &mut Random) {
    let some = random.below(faces.len());
    let reverse = |face: &mut Drawn| face.rings.iter_mut().for_each(|ring| ring.reverse());
    let repeated = |face: &Drawn| Drawn { area_m2: 0.0, ..face.clone() };
    match fault {
        "turned" => {
            for face in faces.iter_mut() {
                if random.between(0.0, 1.0) < 0.3 {
                    reverse(face);
                }
            }
        }
        "all turned" => faces.iter_mut().for_each(reverse),
        "doubled" => {
            let mut twin = repeated(&faces[some]);
            twin.rings[0].rotate_left(1);
            faces.push(twin);
        }
        "doubled reversed" => {
            let mut twin = repeated(&faces[some]);
            reverse(&mut twin);
            faces.insert(random.below(faces.len()), twin);
        }
        "two-sided" => {
            for face in faces.clone() {
                let mut twin = repeated(&face);
                reverse(&mut twin);
                faces.push(twin);
            }
        }
        "crossed" => {
            let rings = &mut faces[some].rings;
            if rings.len() == 1 && rings[0].len() == 4 {
                let at = random.below(3);
                rings[0].swap(at, at + 1);
            }
        }
        "shifted" => {
            let by = area(&faces[some].rings[0]).normalize_or_zero() * random.between(0.01, 0.05);
            faces[some].rings.iter_mut().flatten().for_each(|corner| *corner += by);
        }
        // The missing face is most often the floor.
        "missing" => {
            let at = if random.between(0.0, 1.0) < 0.7 { 1 } else { some };
            faces.remove(at);
        }
        _ => {}
    }
}

/// Areas by kind, m2.
type Areas = BTreeMap<SurfaceKind, f64>;

/// Returns all solids as one city model, each a building 100 m from the next, and their areas by
/// kind.
fn city(count: usize) -> (String, Vec<(String, Areas)>) {
    let (mut vertices, mut objects, mut right) = (Vec::new(), String::new(), Vec::new());
    for number in 0..count {
        let mut random = Random(mix(number as u64, 11));
        let mut faces = solid(&mut random);
        let (first, second) = (FAULTS[number % FAULTS.len()], FAULTS[random.below(FAULTS.len())]);
        // Faces are moved and removed before they are doubled.
        let mut faults: Vec<&str> = if number % 2 == 1 && second != first { vec![first, second] } else { vec![first] };
        faults.sort_by_key(|fault| std::cmp::Reverse(FAULTS.iter().position(|known| known == fault)));
        faults.iter().for_each(|fault| spoil(&mut faces, fault, &mut random));
        let with_semantics = number % 4 < 2;
        let mut areas = BTreeMap::new();
        let (mut boundaries, mut values) = (Vec::new(), Vec::new());
        for face in &faces {
            let kind = match face.semantics {
                "RoofSurface" => SurfaceKind::Roof,
                "WallSurface" => SurfaceKind::Wall,
                _ => SurfaceKind::Floor,
            };
            *areas.entry(kind).or_default() += face.area_m2;
            let ring = |ring: &Vec<DVec3>| {
                let corners = ring.iter().map(|corner| {
                    let at = *corner + DVec3::new(100.0 * (number % 40) as f64, 100.0 * (number / 40) as f64, 0.0);
                    vertices.push((at * 1000.0).round());
                    (vertices.len() - 1).to_string()
                });
                format!("[{}]", corners.collect::<Vec<_>>().join(","))
            };
            boundaries.push(format!("[{}]", face.rings.iter().map(ring).collect::<Vec<_>>().join(",")));
            values.push(["RoofSurface", "WallSurface", "GroundSurface"].iter().position(|s| *s == face.semantics));
        }
        let values: Vec<String> = values.into_iter().map(|value| value.unwrap_or_default().to_string()).collect();
        let semantics = if with_semantics {
            let surfaces = r#"[{"type":"RoofSurface"},{"type":"WallSurface"},{"type":"GroundSurface"}]"#;
            format!(r#","semantics":{{"surfaces":{surfaces},"values":[{}]}}"#, values.join(","))
        } else {
            String::new()
        };
        let name = format!("s{number:04}");
        let comma = if number > 0 { "," } else { "" };
        write!(
            objects,
            r#"{comma}"{name}":{{"type":"Building","geometry":[{{"type":"MultiSurface","lod":"2","boundaries":[{}]{semantics}}}]}}"#,
            boundaries.join(",")
        )
        .expect("a string takes all");
        right.push((format!("{name} {}", faults.join(", ")), areas));
    }
    let list: Vec<String> = vertices.iter().map(|v| format!("[{},{},{}]", v.x, v.y, v.z)).collect();
    let text = format!(
        r#"{{"type":"CityJSON","version":"2.0","transform":{{"scale":[0.001,0.001,0.001],"translate":[0,0,0]}},"CityObjects":{{{objects}}},"vertices":[{}]}}"#,
        list.join(",")
    );
    (text, right)
}

/// Returns the areas of a scene file by object and kind, m2, and the warnings.
fn areas(name: &str, text: &str) -> (BTreeMap<String, Areas>, Vec<String>) {
    let (scene, soup) = load_text(name, text).expect("a scene");
    let surfaces = Surfaces::find(&soup, &scene.materials);
    let mut found: BTreeMap<String, Areas> = BTreeMap::new();
    for surface in &surfaces.list {
        let object = surfaces.objects[surface.object].0.clone();
        *found.entry(object).or_default().entry(surface.kind).or_default() += surface.area_m2;
    }
    (found, scene.report.warnings.iter().map(|said| said.plain()).collect())
}

/// For each of 1,000 boxes, L, courts and gabled houses with one or two faults (faces turned,
/// doubled, crossed, shifted, missing; with and without semantics), the areas of roofs, walls and
/// floors are right within 0.1 % or a warning names the solid; at least 990 are right.
#[test]
fn generated_solids_with_faults_have_the_right_areas_by_kind() {
    let (text, right) = city(1000);
    let (found, warnings) = areas("city.city.json", &text);
    let (mut good, mut named, mut wrong) = (0, 0, Vec::new());
    for (name_and_faults, expected) in &right {
        let name = name_and_faults.split(' ').next().unwrap_or_default();
        let nothing = BTreeMap::new();
        let own = found.get(name).unwrap_or(&nothing);
        let near = |kind: &SurfaceKind| {
            let (a, b) = (own.get(kind).copied().unwrap_or(0.0), expected.get(kind).copied().unwrap_or(0.0));
            (a - b).abs() <= 1e-3 * b.max(1.0)
        };
        if [SurfaceKind::Roof, SurfaceKind::Wall, SurfaceKind::Floor].iter().all(near) {
            good += 1;
        } else if warnings
            .iter()
            .any(|warning| warning.contains("no clear outside") && warning.contains(&format!("`{name}`")))
        {
            named += 1;
        } else {
            wrong.push(format!("{name_and_faults}: {own:?}, right {expected:?}"));
        }
    }
    assert!(wrong.is_empty(), "{good} right, {named} named, {} wrong:\n{}", wrong.len(), wrong.join("\n"));
    assert!(good >= 990, "{good} right, {named} named");
}

/// Reads an OBJ file of one object; returns its areas of roof, wall and floor, m2, and the
/// warnings.
fn of_obj(corners: &[[f64; 3]], faces: &[&[usize]]) -> ([f64; 3], Vec<String>) {
    let mut text = String::from("o house\n");
    corners.iter().for_each(|[x, y, z]| text += &format!("v {x} {y} {z}\n"));
    for face in faces {
        let numbers: Vec<String> = face.iter().map(|number| (number + 1).to_string()).collect();
        text += &format!("f {}\n", numbers.join(" "));
    }
    let (found, warnings) = areas("house.obj", &text);
    let kinds = found.get("house").cloned().unwrap_or_default();
    let area = |kind| kinds.get(&kind).copied().unwrap_or(0.0);
    ([SurfaceKind::Roof, SurfaceKind::Wall, SurfaceKind::Floor].map(area), warnings)
}

const BOX: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [10.0, 0.0, 0.0],
    [10.0, 10.0, 0.0],
    [0.0, 10.0, 0.0],
    [0.0, 0.0, 8.0],
    [10.0, 0.0, 8.0],
    [10.0, 10.0, 8.0],
    [0.0, 10.0, 8.0],
];
const OUTWARDS: [[usize; 4]; 6] = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

/// A house of 10 x 10 x 8 m drawn on both sides, inside out, or inside out without a floor has 100
/// m2 of roof and 320 m2 of walls, and one sentence reports each fault. Two walls that face each
/// other across a street keep their sides: 480 m2 of 480 face the street.
#[test]
fn a_house_is_turned_outwards_and_a_street_is_not() {
    let reversed: Vec<Vec<usize>> = OUTWARDS.iter().map(|face| face.iter().rev().copied().collect()).collect();
    let inwards: Vec<&[usize]> = reversed.iter().map(Vec::as_slice).collect();
    let both: Vec<&[usize]> = OUTWARDS.iter().map(|face| face.as_slice()).chain(inwards.iter().copied()).collect();
    for (faces, expected, said) in [
        (both, [100.0, 320.0, 100.0], "6 faces of `house` appeared twice"),
        (inwards.clone(), [100.0, 320.0, 100.0], "6 faces of `house` pointed into their object"),
        (inwards[1..].to_vec(), [100.0, 320.0, 0.0], "5 faces of `house` pointed into their object"),
    ] {
        let (found, warnings) = of_obj(&BOX, &faces);
        assert_eq!(found, expected);
        assert!(warnings.iter().filter(|warning| warning.contains(said)).count() == 1, "{said}: {warnings:?}");
    }
    let street = [
        [0.0, 0.0, 0.0],
        [0.0, 40.0, 0.0],
        [0.0, 40.0, 6.0],
        [0.0, 0.0, 6.0],
        [8.0, 0.0, 0.0],
        [8.0, 40.0, 0.0],
        [8.0, 40.0, 6.0],
        [8.0, 0.0, 6.0],
    ];
    let text = street.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect::<String>()
        + "o street\nf 1 2 3 4\nf 5 8 7 6\n";
    let (scene, soup) = load_text("street.obj", &text).expect("a scene");
    let found = Surfaces::find(&soup, &scene.materials);
    let to_street = |x: f64, normal: f64| if x < 4.0 { normal > 0.99 } else { normal < -0.99 };
    let area: f64 = found.list.iter().filter(|s| to_street(s.triangles[0][0].x, s.normal.x)).map(|s| s.area_m2).sum();
    assert_eq!((area, scene.report.warnings.len()), (480.0, 1), "{:?}", scene.report.warnings);
}

/// The roof of a carport, a single face that the file calls a roof and draws downwards, looks up:
/// 100 m2 of roof.
#[test]
fn a_roof_without_walls_looks_up() {
    let semantics = r#","semantics":{"surfaces":[{"type":"RoofSurface"}],"values":[0]}"#;
    let (found, _) = areas("town.city.json", &model(&building("b", "Building", "", "[[7,6,5,4]]", semantics), ""));
    assert_eq!(found["b"], BTreeMap::from([(SurfaceKind::Roof, 100.0)]));
}

/// Returns a city model on the box of 10 x 10 x 8 m: vertices 0 to 7, and more.
fn model(objects: &str, more: &str) -> String {
    let corners: Vec<String> = BOX.iter().map(|[x, y, z]| format!("[{x},{y},{z}]")).collect();
    format!(
        r#"{{"type":"CityJSON","version":"2.0","transform":{{"scale":[1,1,1],"translate":[0,0,0]}},"CityObjects":{{{objects}}},"vertices":[{}{more}]}}"#,
        corners.join(",")
    )
}

fn building(id: &str, kind: &str, relation: &str, faces: &str, semantics: &str) -> String {
    format!(
        r#""{id}":{{"type":"{kind}",{relation}"geometry":[{{"type":"MultiSurface","lod":"2","boundaries":[{faces}]{semantics}}}]}}"#
    )
}

const BOX_FACES: &str = "[[0,3,2,1]],[[4,5,6,7]],[[0,1,5,4]],[[1,2,6,5]],[[2,3,7,6]],[[3,0,4,7]]";

/// A building with the geometry of its only part counts once, 100 m2 of roof, and so does one that
/// stands under two names; a main part and a part beside it both count.
#[test]
fn a_building_that_stands_twice_counts_once() {
    let part = |faces: &str| building("part", "BuildingPart", r#""parents":["whole"],"#, faces, "");
    let whole = building("whole", "Building", r#""children":["part"],"#, BOX_FACES, "");
    let roof = |objects: &str, more: &str| -> BTreeMap<String, f64> {
        let (found, _) = areas("town.city.json", &model(objects, more));
        found.into_iter().map(|(name, kinds)| (name, kinds[&SurfaceKind::Roof])).collect()
    };
    let one = |name: &str| BTreeMap::from([(name.to_owned(), 100.0)]);
    assert_eq!(roof(&[whole.clone(), part(BOX_FACES)].join(","), ""), one("part"));
    let alone = building("b", "Building", "", BOX_FACES, "");
    assert_eq!(roof(&[alone.clone(), alone.replacen("\"b\"", "\"a\"", 1)].join(","), ""), one("a"));
    let beside = "[[8,11,10,9]],[[12,13,14,15]],[[8,9,13,12]],[[9,10,14,13]],[[10,11,15,14]],[[11,8,12,15]]";
    let more: String = BOX.iter().map(|[x, y, z]| format!(",[{},{y},{z}]", x + 30.0)).collect();
    assert_eq!(roof(&[whole, part(beside)].join(","), &more).values().sum::<f64>(), 200.0);
}

/// A window of 6 m2 and a door of 2 m2 drawn on a whole wall of 80 m2 leave 72 + 2 m2 of wall and 6
/// m2 of window. A wall that already has its holes stays as it is.
#[test]
fn windows_on_a_whole_wall_are_cut_out_of_it() {
    let more = ",[2,0,2],[5,0,2],[5,0,4],[2,0,4],[7,0,0],[8,0,0],[8,0,2],[7,0,2]";
    let semantics = r#","semantics":{"surfaces":[{"type":"GroundSurface"},{"type":"RoofSurface"},{"type":"WallSurface"},{"type":"Window"},{"type":"Door"}],"values":[0,1,2,2,2,2,3,4]}"#;
    let openings = "[[8,9,10,11]],[[12,13,14,15]]";
    let whole = format!("{BOX_FACES},{openings}");
    let cut = whole.replace("[[0,1,5,4]]", "[[0,1,5,4],[11,10,9,8],[15,14,13,12]]");
    for (faces, said) in [(whole, 1), (cut, 0)] {
        let (found, warnings) =
            areas("town.city.json", &model(&building("b", "Building", "", &faces, semantics), more));
        let kinds = &found["b"];
        assert!((kinds[&SurfaceKind::Wall] - (320.0 - 6.0)).abs() < 1e-9, "{kinds:?}");
        assert_eq!(kinds[&SurfaceKind::Window], 6.0);
        let sentences = warnings.iter().filter(|w| w.contains("2 openings (windows, doors) lie on walls"));
        assert_eq!(sentences.count(), said, "{warnings:?}");
    }
}

/// A building that is only an outline of LoD 0 does not count beside a house, unless LoD 0 is
/// requested. A file of outlines alone is refused with what to export.
#[test]
fn flat_outlines_are_no_roofs() {
    let outline =
        r#""flat":{"type":"Building","geometry":[{"type":"MultiSurface","lod":"0","boundaries":[[[0,1,2,3]]]}]}"#;
    let beside: String = BOX.iter().map(|[x, y, z]| format!(",[{},{y},{z}]", x + 30.0)).collect();
    let house = "[[8,11,10,9]],[[12,13,14,15]],[[8,9,13,12]],[[9,10,14,13]],[[10,11,15,14]],[[11,8,12,15]]";
    let house = building("house", "Building", "", house, "");
    let (found, warnings) = areas("town.city.json", &model(&[outline, &house].join(","), &beside));
    assert_eq!(found.keys().collect::<Vec<_>>(), ["house"]);
    assert!(warnings.iter().any(|w| w.contains("1 left out as flat outlines of buildings (LoD 0)")), "{warnings:?}");
    let folder = TestFolder::new();
    let path = folder.write("flat.city.json", model(outline, ""));
    let load = |lod: Option<&str>| {
        let part = Part { lod: lod.map(str::to_owned), ..Part::plain(&path, None) };
        Scene::load_site(&SceneFiles { parts: vec![part], ..SceneFiles::default() })
    };
    assert_eq!(load(Some("0")).expect("asked for").mesh.triangles.len(), 2);
    let message = load(None).expect_err("no walls").to_string();
    assert!(message.contains("the file holds flat outlines of buildings (LoD 0)"), "{message}");
}

/// An outline of five corners of which two neighbours changed places is put in order, 26 m2; one
/// that crosses itself twice stays as it is and gets a warning.
#[test]
fn crossed_outlines_are_put_in_order_or_named() {
    let wall = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 0.0, 5.0], [2.0, 0.0, 8.0], [0.0, 0.0, 5.0]];
    let area = |order: &[usize]| {
        let (found, warnings) = of_obj(&wall, &[order]);
        (found[1], warnings.iter().filter(|w| w.contains("crossed itself") || w.contains("crosses itself")).count())
    };
    assert_eq!(area(&[0, 1, 2, 3, 4]), (26.0, 0));
    for order in [[0, 2, 1, 3, 4], [1, 0, 2, 3, 4], [0, 1, 3, 2, 4]] {
        assert_eq!(area(&order), (26.0, 1), "{order:?}");
    }
    assert_eq!(area(&[0, 2, 4, 1, 3]).1, 1);
}

/// A house with a gable that stands twice in one object, cut along other diagonals, has its areas
/// once: roof 100, walls 240 m2. The order of its faces does not matter, and without one face of
/// the second copy nothing is left out.
#[test]
fn a_house_with_other_diagonals_counts_once() {
    let text = include_str!("../../../tests/data/footprints/cases/same_house_other_diagonal.obj");
    let areas = |text: &str| {
        let (scene, soup) = load_text("house.obj", text).expect("a scene");
        let [roof, walls] = areas_m2(&scene, &soup).map(f64::round);
        (roof, walls, scene.report.warnings)
    };
    let (mut faces, others): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with("f "));
    let (roof, walls, warnings) = areas(text);
    assert_eq!((roof, walls), (100.0, 240.0));
    assert!(warnings.iter().any(|warning| warning.contains("16 faces of `house` appeared twice")), "{warnings:?}");
    faces.reverse();
    let (roof, walls, _) = areas(&[others.clone(), faces.clone()].concat().join("\n"));
    assert_eq!((roof, walls), (100.0, 240.0));
    let (roof, ..) = areas(&[others, faces.split_off(1)].concat().join("\n"));
    assert_eq!(roof, 200.0);
}
