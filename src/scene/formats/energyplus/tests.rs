//! Models of both syntaxes, valid and damaged.

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use crate::formats::building::frame::area_vector;
use crate::formats::energyplus::*;
use crate::ground::model::ModelGround;
use crate::polygon::triangulate;
use heliotile_core::site::bands::Band;
use heliotile_core::site::material::{Class, Glass};

const BOX_IDF: &str = include_str!("../../../../tests/data/energyplus/box.idf");
const BOX_JSON: &str = include_str!("../../../../tests/data/energyplus/box.epJSON");
/// Report of EnergyPlus 25.2 on the surfaces of the box, from its `.eio`.
const BOX_EIO: &str = include_str!("../../../../tests/data/energyplus/box.eio.csv");

fn read_bytes(bytes: &[u8], name: &str) -> Result<Geometry> {
    parse(bytes, Path::new(name), &ReadOptions { reflectances: true, ..ReadOptions::default() })
}

fn idf(text: &str) -> Geometry {
    read_bytes(text.as_bytes(), "m.idf").expect("readable")
}

/// Returns the outline and holes of every face, by the name of its object.
fn faces(geometry: &Geometry) -> HashMap<String, Vec<Vec<DVec3>>> {
    let ring = |ring: &[u32]| ring.iter().map(|&i| geometry.vertices[i as usize]).collect();
    let name = |object: u32| geometry.objects.as_slice()[object as usize].clone();
    geometry.faces().map(|face| (name(face.object), face.rings().map(ring).collect())).collect()
}

/// Returns the area of the triangles of every object.
fn areas(geometry: &Geometry) -> HashMap<String, f64> {
    let cut = triangulate(geometry).expect("cut");
    assert_eq!((cut.degenerate_faces, cut.crossing_faces), (0, None), "{cut:?}");
    let mut areas = HashMap::new();
    for (triangle, &object) in cut.triangles.iter().zip(&cut.objects) {
        let corners = triangle.corners.map(|corner| geometry.vertices[corner as usize]);
        let name = geometry.objects.as_slice()[object as usize].clone();
        *areas.entry(name).or_default() += area_vector(&corners).length();
    }
    areas
}

/// Net and gross area, azimuth, tilt and corners of all 28 surfaces of the box agree with
/// EnergyPlus to its last digit.
#[test]
fn areas_and_corners_agree_with_energyplus() {
    for (text, name) in [(BOX_IDF, "box.idf"), (BOX_JSON, "box.epJSON")] {
        let geometry = read_bytes(text.as_bytes(), name).expect("readable");
        assert_eq!((geometry.face_count(), geometry.warnings.as_slice()), (28, &[][..]));
        let of_name = |map: HashMap<String, _>| -> HashMap<String, _> {
            map.into_iter().map(|(name, rings): (String, Vec<Vec<DVec3>>)| (name.to_uppercase(), rings)).collect()
        };
        let (faces, areas) = (of_name(faces(&geometry)), areas(&geometry));
        let areas: HashMap<String, f64> = areas.into_iter().map(|(name, area)| (name.to_uppercase(), area)).collect();
        let mut compared = 0;
        for line in BOX_EIO.lines().skip(1) {
            let mut fields = line.split(',');
            let name = fields.next().expect("a name").to_uppercase();
            let numbers: Vec<f64> = fields.map(|field| field.parse().expect("a number")).collect();
            let outline = &faces[&name][0];
            let area = area_vector(outline);
            let normal = area.normalize();
            let azimuth = normal.x.atan2(normal.y).to_degrees().rem_euclid(360.0);
            let tilt = normal.z.acos().to_degrees();
            assert!((areas[&name] - numbers[0]).abs() < 0.0051, "{name}: net area {}", areas[&name]);
            assert!((area.length() - numbers[1]).abs() < 0.0051, "{name}: gross area {}", area.length());
            let level = normal.x.hypot(normal.y) < 1e-9;
            let off = (azimuth - numbers[2] + 180.0).rem_euclid(360.0) - 180.0;
            assert!(level || off.abs() < 0.0051, "{name}: azimuth {azimuth}");
            assert!((tilt - numbers[3]).abs() < 0.0051, "{name}: tilt {tilt}");
            let corners: Vec<DVec3> = numbers[4..].chunks(3).map(DVec3::from_slice).collect();
            assert_eq!(corners.len(), outline.len(), "{name}");
            for (theirs, ours) in corners.iter().zip(outline) {
                assert!((*theirs - *ours).abs().max_element() < 0.0051, "{name}: {ours}, not {theirs}");
            }
            compared += 1;
        }
        assert_eq!(compared, 28);
        let place = Reference::Place { latitude_deg: 39.74, longitude_deg: -105.18 };
        assert_eq!(geometry.reference, Some(place));
    }
}

/// Returns a detailed wall and its windows in IDF; coordinates are world metres.
fn wall_and(windows: &[[f64; 4]]) -> String {
    let mut text = String::from(
        "Version,25.2; GlobalGeometryRules,UpperLeftCorner,Counterclockwise,World; Zone,Z; Construction,W,B; Material,B;\n\
         BuildingSurface:Detailed,Wall,Wall,W,Z,,Outdoors,,,,,4, 0,0,3, 0,0,0, 4,0,0, 4,0,3;\n",
    );
    for (i, [x0, z0, x1, z1]) in windows.iter().enumerate() {
        text += &format!(
            "FenestrationSurface:Detailed,Window {i},Window,W,Wall,,,,1,4, {x0},0,{z1}, {x0},0,{z0}, {x1},0,{z0}, {x1},0,{z1};\n"
        );
    }
    text
}

/// Windows within the wall, at one to three edges, side by side and corner to corner leave the wall
/// 12 m2 less their own area.
#[test]
fn windows_are_holes_of_their_wall() {
    for windows in [
        &[[1.0, 1.0, 2.0, 2.0]][..],
        &[[0.0, 1.0, 2.0, 2.0]],
        &[[0.0, 1.0, 4.0, 2.0]],
        &[[1.0, 0.0, 2.0, 2.0]],
        &[[0.0, 0.0, 1.0, 1.0]],
        &[[0.0, 0.0, 4.0, 2.5]],
        &[[0.5, 1.0, 1.5, 2.0], [1.5, 1.0, 2.5, 2.0]],
        &[[0.5, 1.0, 1.5, 2.0], [1.5, 2.0, 2.5, 2.5]],
        &[[0.0, 1.0, 2.0, 2.0], [2.0, 1.0, 4.0, 2.0]],
        &[[0.2, 0.0, 1.0, 2.0], [1.5, 0.0, 2.0, 2.0], [2.5, 1.0, 3.5, 2.0], [3.5, 1.0, 4.0, 3.0]],
        &[[-0.004, 1.0, 4.003, 2.0]],
    ] {
        let geometry = idf(&wall_and(windows));
        let areas = areas(&geometry);
        let glass: f64 = windows.iter().map(|[x0, z0, x1, z1]| (x1 - x0) * (z1 - z0)).sum();
        assert_eq!((geometry.face_count(), geometry.warnings.len()), (1 + windows.len(), 0), "{windows:?}");
        assert!((areas["Wall"] - (12.0 - glass)).abs() < 0.008, "{windows:?}: {}", areas["Wall"]);
    }
}

/// A window that reaches over the wall's edge, is bigger than the wall, lies off its plane or
/// overlaps another is left out. The wall keeps its 12 m2, or what the other window leaves. A
/// window that takes up the whole wall replaces it.
#[test]
fn windows_that_do_not_fit_are_left_out() {
    for (windows, wall) in [
        (&[[3.0, 1.0, 5.0, 2.0]][..], 12.0),
        (&[[-1.0, -1.0, 5.0, 4.0]], 12.0),
        (&[[-1.0, 1.0, 5.0, 2.0]], 12.0),
        (&[[7.0, 1.0, 8.0, 2.0]], 12.0),
        (&[[1.0, 1.0, 2.0, 2.0], [1.0, 1.0, 2.0, 2.0]], 11.0),
        (&[[1.0, 1.0, 2.0, 2.0], [1.5, 0.5, 3.0, 2.5]], 11.0),
    ] {
        let geometry = idf(&wall_and(windows));
        assert!((areas(&geometry)["Wall"] - wall).abs() < 1e-9, "{windows:?}");
        assert_eq!(geometry.warnings.len(), 1, "{windows:?}");
        assert!(geometry.warnings[0].contains("1 windows or doors are left out"), "{:?}", geometry.warnings[0]);
    }
    let off = wall_and(&[[1.0, 1.0, 2.0, 2.0]]).replace("1,0,2,", "1,0.2,2,");
    assert!((areas(&idf(&off))["Wall"] - 12.0).abs() < 1e-9);
    let whole = idf(&wall_and(&[[0.0, 0.0, 4.0, 3.0]]));
    assert_eq!((whole.face_count(), whole.left_out.len()), (1, 1));
    assert_eq!(areas(&whole).into_iter().collect::<Vec<_>>(), [("Window 0".to_owned(), 12.0)]);
}

/// Fields of versions 8.9, 9.5 and 9.6 are found at their positions: three files give the same
/// geometry.
#[test]
fn fields_of_older_versions_are_found() {
    let newest = wall_and(&[[1.0, 1.0, 2.0, 2.0]]);
    let expected = faces(&idf(&newest));
    let no_space = newest.replace("W,Z,,Outdoors", "W,Z,Outdoors");
    let with_control = no_space.replace("Wall,,,,1,4,", "Wall,,,,,1,4,");
    for (text, version) in [(&newest, "9.6"), (&no_space, "9.5"), (&with_control, "8.9")] {
        let geometry = idf(&text.replace("25.2", version));
        assert_eq!((faces(&geometry), geometry.warnings.len()), (expected.clone(), 0), "{version}");
    }
    // A version at the end of the file counts as well.
    let last = format!("{}Version,9.5;", no_space.replace("Version,25.2;", ""));
    assert_eq!(faces(&idf(&last)), expected);
    // With 8.9 assumed, fields are read as those of 8.9 under any stated version.
    let assumed = ReadOptions { assume_version: "8.9".parse().ok(), ..ReadOptions::default() };
    for version in ["7.2", "25.2", "26.1"] {
        let geometry = parse(with_control.replace("25.2", version).as_bytes(), Path::new("m.idf"), &assumed);
        let geometry = geometry.expect("readable");
        assert_eq!((faces(&geometry), geometry.warnings.len()), (expected.clone(), 0), "{version}");
    }
    for (text, version, word) in [(with_control, "Version,7.2;", "Transition"), (newest, "", "no version")] {
        let geometry = idf(&text.replace("Version,25.2;", version));
        assert_eq!((faces(&geometry), geometry.warnings.len()), (expected.clone(), 1));
        assert!(geometry.warnings[0].contains(word), "{:?}", geometry.warnings[0]);
    }
}

/// Four of six walls form the hull: outdoors, to the ground, to a neighbour and one behind itself.
/// Two that separate zones are left out.
#[test]
fn walls_between_zones_are_left_out() {
    let wall = |name: &str, behind: &str, x: f64, flip: bool| {
        let (a, b) = if flip { (2.0, 0.0) } else { (0.0, 2.0) };
        format!(
            "BuildingSurface:Detailed,{name},Wall,W,Z,,{behind},,,,4, {x},{a},2, {x},{a},0, {x},{b},0, {x},{b},2;\n"
        )
    };
    let text = "Version,25.2; GlobalGeometryRules,UpperLeftCorner,Counterclockwise,World; Zone,Z; Construction,W,B; Material,B;\n"
        .to_owned()
        + &wall("Out", "Outdoors,", 0.0, false)
        + &wall("Ground", "GroundFCfactorMethod,", 1.0, false)
        + &wall("Neighbour", "Adiabatic,", 2.0, false)
        + &wall("Self", "Surface,SELF", 3.0, false)
        + &wall("Part", "Surface,Other", 4.0, false)
        + &wall("Back", "Adiabatic,", 5.0, false)
        + &wall("To back", "Adiabatic,", 5.0, true)
        + "FenestrationSurface:Detailed,Pane,Window,W,Part,,,,1,3, 4,0.5,1, 4,0.5,0.5, 4,1,0.5;\n";
    let geometry = idf(&text);
    assert_eq!(geometry.objects.as_slice(), ["Out", "Ground", "Neighbour", "Self"]);
    assert_eq!(geometry.left_out.into_iter().collect::<Vec<_>>(), [("because they lie inside the building".into(), 4)]);
}

/// Visible absorptances and reflectances become values of the visible band, 3 of 3: 1 - 0.8 of a
/// layer, 0.3 of a shade and 0.2 of a half-glazed shade. A layer that states none, a layer with
/// equal absorptances and a shade without a statement have no value by band. IDF and epJSON agree.
#[test]
fn visible_absorptances_become_visible_reflectances() {
    let text = "Version,25.2; GlobalGeometryRules,UpperLeftCorner,Counterclockwise,World; Zone,Z;\n".to_owned()
        + "Material,Brick,Rough,0.1,0.5,1000,900,0.9,0.6,0.8;\nMaterial,Plain,Rough,0.1,0.5,1000,900,0.9,0.6;\n"
        + "Material:NoMass,Same,Rough,1,0.9,0.7,0.7;\nConstruction,Wall,Brick;\nConstruction,Bare,Plain;\nConstruction,Even,Same;\n"
        + "Wall:Exterior,W1,Wall,Z,,0,90,0,0,0,3,2;\nWall:Exterior,W2,Bare,Z,,0,90,5,0,0,3,2;\nWall:Exterior,W3,Even,Z,,0,90,9,0,0,3,2;\n"
        + "Shading:Site:Detailed,S1,,3,0,9,0,1,9,0,1,9,1;\nShading:Site:Detailed,S2,,3,0,19,0,1,19,0,1,19,1;\n"
        + "ShadingProperty:Reflectance,S1,0.35,0.3;\nShadingProperty:Reflectance,S2,0.5,0.4,0.5;\n";
    let stated = idf(&text).stated;
    let seen = |name: &str| stated[name].bands.diffuse.stated(Band::Visible);
    for (name, expected) in [("Wall", Some(0.2)), ("Bare", None), ("Even", None), ("shading 0.35", Some(0.3))] {
        assert!(seen(name).zip(expected).map_or(seen(name) == expected, |(a, b)| (a - b).abs() < 1e-12), "{name}");
    }
    assert_eq!(seen("shading 0.5 glazed 0.5"), Some(0.2));
    assert!(stated.values().all(|material| material.check().is_ok()));
    let json = r#"{"Version":{"v":{"version_identifier":"25.2"}},"Zone":{"Z":{}},
        "GlobalGeometryRules":{"g":{"starting_vertex_position":"UpperLeftCorner","vertex_entry_direction":"Counterclockwise","coordinate_system":"World"}},
        "Material":{"Brick":{"solar_absorptance":0.6,"visible_absorptance":0.8}},"Construction":{"Wall":{"outside_layer":"Brick"}},
        "Wall:Exterior":{"W1":{"construction_name":"Wall","zone_name":"Z","azimuth_angle":0,"tilt_angle":90,"length":3,"height":2}}}"#;
    let other = read_bytes(json.as_bytes(), "m.epJSON").expect("readable").stated;
    assert_eq!(other["Wall"].bands, stated["Wall"].bands);
}

/// Seventeen surfaces get the material of their construction or shade, and all these materials pass
/// the checks.
#[test]
fn surfaces_get_the_material_of_their_construction() {
    let text = r#"{"Version":{"v":{"version_identifier":"25.2"}},"Zone":{"Z":{}},
        "GlobalGeometryRules":{"g":{"starting_vertex_position":"UpperLeftCorner","vertex_entry_direction":"Counterclockwise","coordinate_system":"World"}},
        "Material":{"Brick":{"solar_absorptance":0.6},"Plain":{},"Odd":{"solar_absorptance":1.5}},"Material:AirGap":{"Gap":{}},
        "WindowMaterial:Glazing":{"Pane":{}},"WindowMaterial:SimpleGlazingSystem":{"Old":{"u_factor":5.8},"New":{"u_factor":1.3}},
        "Construction":{"Wall":{"outside_layer":"BRICK","layer_2":"Plain"},"Default":{"outside_layer":"Plain"},"Odd":{"outside_layer":"Odd"},
          "Air":{"outside_layer":"Gap"},"One":{"outside_layer":"Pane"},"Two":{"outside_layer":"Pane","layer_2":"Gap","layer_3":"pane"},
          "Old":{"outside_layer":"Old"},"New":{"outside_layer":"New"},"shading":{"outside_layer":"Brick"}},
        "Wall:Exterior":{WALLS},
        "Floor:GroundContact":{"Slab":{"construction_name":"wall","zone_name":"Z","length":3,"width":3}},
        "Shading:Site:Detailed":{SHADES},"Schedule:Constant":{"Half":{"hourly_value":0.5},"Shut":{"hourly_value":0}},
        "ShadingProperty:Reflectance":{"1":{"shading_surface_name":"b","diffuse_solar_reflectance_of_unglazed_part_of_shading_surface":0.35},
          "2":{"shading_surface_name":"C","fraction_of_shading_surface_that_is_glazed":0.5,"glazing_construction_name":"two"},
          "3":{"shading_surface_name":"d","fraction_of_shading_surface_that_is_glazed":1,"glazing_construction_name":"One"}}}"#;
    let walls = ["wall", "Default", "Odd", "Air", "One", "Two", "Old", "New", "shading", "nowhere"]
        .map(|name| format!(r#""w {name}":{{"construction_name":"{name}","zone_name":"z","length":3,"height":2}}"#));
    let shades = [("a", ""), ("b", ""), ("c", ""), ("d", ""), ("e", "half"), ("f", "Shut"), ("g", "never")].map(
        |(name, schedule)| {
            let vertices = [(0, 0), (1, 0), (1, 1)].map(|(x, z)| {
                format!(r#"{{"vertex_x_coordinate":{x},"vertex_y_coordinate":9,"vertex_z_coordinate":{z}}}"#)
            });
            format!(r#""{name}":{{"transmittance_schedule_name":"{schedule}","vertices":[{}]}}"#, vertices.join(","))
        },
    );
    let text = text.replace("WALLS", &walls.join(",")).replace("SHADES", &shades.join(","));
    let geometry = read_bytes(text.as_bytes(), "m.epJSON").expect("readable");
    let names = geometry.materials.as_slice();
    let of: HashMap<&str, &str> = geometry
        .faces()
        .map(|face| {
            (geometry.objects.as_slice()[face.object as usize].as_str(), names[face.material as usize].as_str())
        })
        .collect();
    let (single, double) = (Some(Glass::Single), Some(Glass::Double));
    for (object, name, diffuse, specular, glass, transmittance) in [
        ("w wall", "Wall", 0.4, 0.0, None, None),
        ("w Default", "Default", 0.3, 0.0, None, None),
        ("w Odd", "Odd", 0.0, 0.0, None, None),
        ("w Air", "Air", 0.3, 0.0, None, None),
        ("w One", "One", 0.0, 0.0, single, None),
        ("w Two", "Two", 0.0, 0.0, double, None),
        ("w Old", "Old", 0.0, 0.0, single, None),
        ("w New", "New", 0.0, 0.0, double, None),
        ("w shading", "shading", 0.4, 0.0, None, None),
        ("Slab", "Wall (2)", 0.4, 0.0, None, None),
        ("a", "shading (2)", 0.2, 0.0, None, None),
        ("b", "shading 0.35", 0.35, 0.0, None, None),
        ("c", "shading 0.2 glazed 0.5", 0.1, 0.075, None, None),
        ("d", "shading 0.2 glazed 1", 0.0, 0.0, single, None),
        ("e", "shading transmittance 0.5", 0.0, 0.0, None, Some(0.5)),
        ("f", "shading (2)", 0.2, 0.0, None, None),
        ("g", "shading (2)", 0.2, 0.0, None, None),
    ] {
        assert_eq!(of[object], name, "{object}");
        let material = &geometry.stated[name];
        assert!((material.diffuse - diffuse).abs() < 1e-12 && (material.specular - specular).abs() < 1e-12, "{object}");
        assert_eq!((material.glass, material.transmittance), (glass, transmittance), "{object}");
        assert_eq!(material.class == Class::Ground, object == "Slab", "{object}");
        material.check().expect(object);
    }
    assert!(of["w nowhere"] == "nowhere" && !geometry.stated.contains_key("nowhere"));
    assert_eq!((of.len(), geometry.warnings.len()), (18, 5), "{:?}", geometry.warnings);
}

/// Shades that are glazed by 1, 1, 0.4, 1 and 1 reflect as their panes state: 0.4 for a coated
/// pane, 0.12 + 0.5^2 x 0.4 / (1 - 0.2 x 0.4) for a tinted one before it, and the glazed share
/// beside 0.35 on the rest. Clear panes (0.075, or n = 1.526, and 0.128 for two) stay glass with
/// its dependence on the angle.
#[test]
fn glazed_shades_reflect_as_their_panes_state() {
    let mut text = String::from(
        "Version,25.2; GlobalGeometryRules,UpperLeftCorner,Counterclockwise,World;\n\
         WindowMaterial:Glazing,Coated,SpectralAverage,,0.006,0.3,0.4,0.35; WindowMaterial:Glazing,Tinted,SpectralAverage,,0.006,0.5,0.12,0.2;\n\
         WindowMaterial:Glazing,Clear,SpectralAverage,,0.003,0.837,0.075,0.075; WindowMaterial:Glazing:RefractionExtinctionMethod,Thin,0.003,1.526,10;\n\
         Construction,One,Coated; Construction,Two,Tinted,Coated; Construction,Plain,Clear,Clear; Construction,Fresnel,Thin;\n",
    );
    let shades = [("a", "One", 1.0), ("b", "Two", 1.0), ("c", "One", 0.4), ("d", "Plain", 1.0), ("e", "Fresnel", 1.0)];
    for (name, construction, share) in shades {
        text += &format!(
            "Shading:Site:Detailed,{name},,3, 0,9,0, 1,9,0, 1,9,1; ShadingProperty:Reflectance,{name},0.35,0.35,{share},{construction};\n"
        );
    }
    let geometry = idf(&text);
    let two = 0.12 + 0.25 * 0.4 / (1.0 - 0.2 * 0.4);
    for (face, (diffuse, specular, glass)) in geometry.faces().zip([
        (0.0, 0.4, None),
        (0.0, two, None),
        (0.6 * 0.35, 0.4 * 0.4, None),
        (0.0, 0.0, Some(Glass::Double)),
        (0.0, 0.0, Some(Glass::Single)),
    ]) {
        let material = &geometry.stated[&geometry.materials.as_slice()[face.material as usize]];
        let off = ((material.diffuse - diffuse).abs(), (material.specular - specular).abs());
        assert!(off.0 < 1e-12 && off.1 < 1e-12 && material.glass == glass, "{material:?}");
    }
    assert!(
        geometry.warnings.len() == 1 && geometry.warnings[0].contains("3 shades are glazed"),
        "{:?}",
        geometry.warnings
    );
}

/// The ground of seven models lies at z = 0, as in EnergyPlus, or at -3 m where a wall in the sun
/// reaches so low; only then a warning says so. Under a wall without sun, a wall to the ground and
/// a shade in a pit it stays at 0; a model at 30 m gets a warning. The ground reflects 0.2, or the
/// values of January to December, and 1.5 times as much under snow; 1.4 counts as 1, -2 as 0.
#[test]
fn the_ground_of_energyplus_lies_at_zero() {
    let wall = |behind: &str, low: f64| {
        format!(
            "Version,25.2; GlobalGeometryRules,UpperLeftCorner,Counterclockwise,World; Zone,Z; Construction,W,B; Material,B;\n\
             BuildingSurface:Detailed,Wall,Wall,W,Z,,{behind},,,,,4, 0,0,39, 0,0,{low}, 4,0,{low}, 4,0,39;\n"
        )
    };
    let shade = "Shading:Site:Detailed,S,,3, 0,9,1, 1,9,1, 1,9,2;";
    for (text, elevation_m, said) in [
        (wall("Outdoors", 1.5), 0.0, None),
        (wall("Outdoors", 30.0), 0.0, Some("lies 30.00 m above the ground")),
        (wall("Outdoors", -3.0), -3.0, Some("1 surfaces in the sun reach below z = 0, down to -3.00 m")),
        (wall("Outdoors", -3.0).replace("Outdoors,,,", "Outdoors,,NoSun,"), 0.0, None),
        (wall("Outdoors", 1.5) + &shade.replace(",1,", ",-1,"), 0.0, None),
        (wall("Ground", 0.5) + shade, 0.0, None),
        (wall("Ground", -2.0), 0.0, None),
    ] {
        let geometry = idf(&text);
        assert_eq!(geometry.ground, Some(ModelGround::usual(elevation_m)), "{text}");
        assert_eq!(geometry.warnings.len(), usize::from(said.is_some()), "{:?}", geometry.warnings);
        assert!(said.is_none_or(|said| geometry.warnings[0].contains(said)), "{:?}", geometry.warnings);
    }
    let stated = "Site:GroundReflectance,0.1,0.2,0.3,1.4,0.5,0.6,0.7,,0.9,0.1,0.1,0.12; Site:GroundReflectance:SnowModifier,1.5,9;";
    let geometry = idf(&(wall("Outdoors", 0.0) + stated));
    let ground = geometry.ground.expect("a plane");
    assert_eq!(ground.reflectance, [0.1, 0.2, 0.3, 1.0, 0.5, 0.6, 0.7, 0.2, 0.9, 0.1, 0.1, 0.12]);
    assert_eq!((ground.snow_modifier, ground.stated, ground.changes()), (1.5, true, true));
    assert!(geometry.warnings[0].contains("optical properties lie outside 0 to 1"), "{:?}", geometry.warnings);
    let below = idf(&(wall("Outdoors", 0.0) + "Site:GroundReflectance:SnowModifier,-2;"));
    assert_eq!((below.ground.map(|ground| ground.snow_modifier), below.warnings.len()), (Some(0.0), 1));
}

/// A zone of 10 x 8 x 3 m has a window of 3 m2. With all walls wound inwards, with one, and with
/// only the window turned, areas and normals are those of the correct zone, and a warning counts 4,
/// 1 and 1.
#[test]
fn walls_of_a_closed_zone_look_outwards() {
    let head = "Version,25.2; GlobalGeometryRules,UpperLeftCorner,Counterclockwise,World; Zone,Z; Construction,C,M; Material,M;\n";
    let corner = |number: char| match number {
        'a' => "0,0",
        'b' => "10,0",
        'c' => "10,8",
        _ => "0,8",
    };
    let ring = |corners: [String; 4], turned: bool| {
        let mut corners = corners.to_vec();
        if turned {
            corners.reverse();
        }
        corners.join(",")
    };
    let zone = |walls: &[char], window: bool| {
        let mut text = head.to_owned();
        for (name, from, to) in [('S', 'a', 'b'), ('E', 'b', 'c'), ('N', 'c', 'd'), ('W', 'd', 'a')] {
            let (from, to) = (corner(from), corner(to));
            let corners = [format!("{from},3"), format!("{from},0"), format!("{to},0"), format!("{to},3")];
            text += &format!(
                "BuildingSurface:Detailed,{name},Wall,C,Z,,Outdoors,,SunExposed,WindExposed,,4,{};\n",
                ring(corners, walls.contains(&name))
            );
        }
        for (name, kind, z) in [("R", "Roof", 3), ("F", "Floor", 0)] {
            let corners = ['d', 'a', 'b', 'c'].map(|at| format!("{},{z}", corner(at)));
            text += &format!(
                "BuildingSurface:Detailed,{name},{kind},C,Z,,Outdoors,,SunExposed,WindExposed,,4,{};\n",
                ring(corners, z == 0)
            );
        }
        let corners = ["2,0,2", "2,0,1", "5,0,1", "5,0,2"].map(str::to_owned);
        text + &format!("FenestrationSurface:Detailed,P,Window,C,S,,,,1,4,{};\n", ring(corners, window))
    };
    let vectors = |geometry: &Geometry| -> HashMap<String, DVec3> {
        let faces = faces(geometry).into_iter();
        faces.map(|(name, rings)| (name, area_vector(&rings[0]))).collect()
    };
    let right = idf(&zone(&[], false));
    assert!(right.warnings.is_empty(), "{:?}", right.warnings);
    let right = vectors(&right);
    assert!((right["P"] - DVec3::new(0.0, -3.0, 0.0)).length() < 1e-9 && (right["W"].x + 24.0).abs() < 1e-9);
    for (text, said) in [
        (zone(&['S', 'E', 'N', 'W'], true), "4 surfaces look into their zone and are turned"),
        (zone(&['N'], false), "1 surfaces look into their zone and are turned"),
        (zone(&[], true), "1 windows or doors face against their wall"),
    ] {
        let geometry = idf(&text);
        assert!(geometry.warnings.len() == 1 && geometry.warnings[0].contains(said), "{:?}", geometry.warnings);
        for (name, vector) in vectors(&geometry) {
            assert!((vector - right[&name]).length() < 1e-9, "{name}: {vector}");
        }
    }
}
