//! In: small city models in XML, written for the tests. Out: proof of what is read, chosen, joined
//! and left out.

use std::io::Read;
use std::path::Path;

use glam::DVec3;

use crate::formats;
use crate::formats::citygml::coordinates::Coordinates;
use crate::formats::citygml::read_all;
use crate::formats::citygml::scan::Scan;
use crate::formats::xml::Xml;
use crate::formats::{Content, ReadOptions};
use crate::geometry::Geometry;
use crate::polygon::area_vector_of;
use crate::test_files::faces;
use heliotile_core::error::Result;
use heliotile_core::site::semantics::SurfaceKind;
use heliotile_place::reference::Reference;

/// Corners of a box of 10 x 10 x 5 m, and its six faces: floor, roof and four walls, turned
/// outwards.
const CORNERS: [[u32; 3]; 8] =
    [[0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0], [0, 0, 5], [10, 0, 5], [10, 10, 5], [0, 10, 5]];
const BOX: [[usize; 4]; 6] = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

pub(super) fn read_as(text: &str, asked: &ReadOptions) -> Result<Geometry> {
    let bytes = text.as_bytes().to_vec();
    read_all(Path::new("town.gml"), asked, &|take| {
        let stream: Box<dyn Read> = Box::new(std::io::Cursor::new(bytes.clone()));
        take(stream)
    })
}

pub(super) fn read(text: &str) -> Geometry {
    read_as(text, &ReadOptions::default()).expect(text)
}

/// Returns a city model of version 2.0 with the members.
pub(super) fn model(members: &str) -> String {
    format!(
        r##"<?xml version="1.0"?><core:CityModel xmlns:core="c" xmlns:gml="g" xmlns:xlink="x">
<gml:boundedBy><gml:Envelope srsName="EPSG:25832" srsDimension="3"><gml:lowerCorner>0 0 0</gml:lowerCorner></gml:Envelope></gml:boundedBy>
{members}
</core:CityModel>"##
    )
}

pub(super) fn member(element: &str) -> String {
    format!("<core:cityObjectMember>{element}</core:cityObjectMember>\n")
}

/// Returns a city model of one building `b` with the properties.
pub(super) fn building(properties: &str) -> String {
    model(&member(&format!(r#"<bldg:Building gml:id="b">{properties}</bldg:Building>"#)))
}

/// Returns a face of the box, raised by `up` metres, as a polygon with an id.
pub(super) fn polygon(face: usize, up: u32) -> String {
    let corner = |corner: &usize| CORNERS[*corner].map(f64::from).map(|n| n.to_string());
    let ring: Vec<String> = BOX[face]
        .iter()
        .chain(&BOX[face][..1])
        .map(corner)
        .map(|[x, y, z]| format!("{x} {y} {}", z.parse::<u32>().expect("a number") + up))
        .collect();
    format!(
        r#"<gml:Polygon gml:id="p{face}"><gml:exterior><gml:LinearRing><gml:posList>{}</gml:posList></gml:LinearRing></gml:exterior></gml:Polygon>"#,
        ring.join(" ")
    )
}

fn members(faces: &[usize], up: u32) -> String {
    faces.iter().map(|face| format!("<gml:surfaceMember>{}</gml:surfaceMember>\n", polygon(*face, up))).collect()
}

/// Returns the faces as a solid of a level of detail.
pub(super) fn solid(lod: u32, faces: &[usize]) -> String {
    format!(
        "<bldg:lod{lod}Solid><gml:Solid><gml:exterior><gml:CompositeSurface>{}</gml:CompositeSurface></gml:exterior></gml:Solid></bldg:lod{lod}Solid>",
        members(faces, 0)
    )
}

/// Returns a thematic surface of level 2 with one face.
fn surface(kind: &str, face: usize) -> String {
    format!(
        "<bldg:boundedBy><bldg:{kind} gml:id=\"s{face}\"><bldg:lod2MultiSurface><gml:MultiSurface>{}</gml:MultiSurface></bldg:lod2MultiSurface></bldg:{kind}></bldg:boundedBy>",
        members(&[face], 0)
    )
}

fn surfaces() -> String {
    let kinds = ["GroundSurface", "RoofSurface", "WallSurface", "WallSurface", "WallSurface", "WallSurface"];
    kinds.iter().enumerate().map(|(face, kind)| surface(kind, face)).collect()
}

const REFERENCES: &str = r##"<bldg:lod2Solid><gml:Solid><gml:exterior><gml:CompositeSurface><gml:surfaceMember xlink:href="#p0"/><gml:surfaceMember
xlink:href="#p1"/><gml:surfaceMember xlink:href="#p2"/><gml:surfaceMember xlink:href="#p3"/><gml:surfaceMember xlink:href="#p4"/><gml:surfaceMember
xlink:href="#p5"/></gml:CompositeSurface></gml:exterior></gml:Solid></bldg:lod2Solid>"##;

const ALL: [usize; 6] = [0, 1, 2, 3, 4, 5];

fn count(geometry: &Geometry, material: &str) -> usize {
    faces(geometry).iter().filter(|face| face.1 == material).count()
}

pub(super) fn left_out(geometry: &Geometry) -> usize {
    geometry.left_out.values().sum()
}

/// A solid of 6 inline polygons is named by tilt, its 8 corners are stored once, and faces are
/// named after their lines.
#[test]
fn a_solid_without_surface_names_is_named_by_tilt() {
    let geometry = read(&building(&solid(1, &ALL)));
    assert_eq!((geometry.face_count(), geometry.vertices.len()), (6, 8));
    assert_eq!(
        (count(&geometry, "RoofSurface"), count(&geometry, "GroundSurface"), count(&geometry, "WallSurface")),
        (1, 1, 4)
    );
    assert_eq!((geometry.reference, geometry.in_metres), (Some(Reference::Epsg(25832)), false));
    let names: Vec<String> = geometry.source_faces().map(|face| face.name("b")).collect();
    assert_eq!(names, ["line 3", "line 4", "line 5", "line 6", "line 7", "line 8"]);
    let one_line = read(&building(&solid(1, &ALL)).replace('\n', " "));
    assert_eq!(one_line.source_faces().nth(2).expect("a face").name("b"), "geometry[0].boundaries[2]");
    assert_eq!(geometry.vertices.iter().fold(DVec3::ZERO, |high, vertex| high.max(*vertex)), DVec3::new(10., 10., 5.));
    assert_eq!((geometry.warnings.len(), geometry.doubts.len(), left_out(&geometry)), (0, 0, 0));
}

/// Thematic surfaces alone, with a solid before or behind that refers to them, and with a solid
/// that repeats them, give 6 faces and 3 names each time.
#[test]
fn a_solid_and_its_surfaces_count_once() {
    for text in [
        surfaces(),
        surfaces() + REFERENCES,
        REFERENCES.to_owned() + &surfaces(),
        surfaces() + &solid(2, &ALL).replace("gml:id=\"p", "gml:id=\"q"),
    ] {
        let geometry = read(&building(&text));
        assert_eq!(
            (geometry.face_count(), count(&geometry, "RoofSurface"), count(&geometry, "WallSurface")),
            (6, 1, 4)
        );
        assert_eq!(left_out(&geometry), 0, "{:?}", geometry.left_out);
    }
    // The solid has other corners than its thematic surfaces: the surfaces are read, because they
    // have names.
    let other = solid(2, &ALL).replace("gml:id=\"p", "gml:id=\"q").replace("10", "10.5");
    let geometry = read(&building(&(surfaces() + &other)));
    assert_eq!((geometry.face_count(), left_out(&geometry), geometry.vertices.len()), (6, 1, 8));
}

/// A thematic surface that refers to a polygon of the solid gives the polygon its name. The
/// orientation `-` turns its normal, and a second `-` turns it back.
#[test]
fn names_and_orientations_go_through_references() {
    let roof = r##"<bldg:boundedBy><bldg:OuterFloorSurface><bldg:lod2MultiSurface><gml:MultiSurface><gml:surfaceMember xlink:href="#p1"/>
        </gml:MultiSurface></bldg:lod2MultiSurface></bldg:OuterFloorSurface></bldg:boundedBy>"##;
    let geometry = read(&building(&(solid(2, &ALL) + roof)));
    assert_eq!((geometry.face_count(), count(&geometry, "OuterFloorSurface")), (6, 1));
    let turned = |inner: &str| {
        let text = format!(
            r#"<gml:OrientableSurface orientation="-"><gml:baseSurface>{inner}</gml:baseSurface></gml:OrientableSurface>"#
        );
        text
    };
    let up = |surface: &str| {
        let text = format!(
            "<lod2MultiSurface><gml:MultiSurface><gml:surfaceMembers>{surface}</gml:surfaceMembers></gml:MultiSurface></lod2MultiSurface>"
        );
        let geometry = read(&building(&text));
        assert_eq!(geometry.face_count(), 1);
        let corners: Vec<DVec3> =
            geometry.faces().next().expect("a face").corners().iter().map(|i| geometry.vertices[*i as usize]).collect();
        (corners[1] - corners[0]).cross(corners[2] - corners[0]).z
    };
    let roof = polygon(1, 0);
    assert_eq!([up(&roof), up(&turned(&roof)), up(&turned(&turned(&roof)))], [100.0, -100.0, 100.0]);
}

/// The finest outside level of levels 0 to 4 is read; level 4 is read if there is no other, and a
/// level that is asked for is read.
#[test]
fn the_finest_outside_level_is_read() {
    let outline = format!("<lod0FootPrint><gml:MultiSurface>{}</gml:MultiSurface></lod0FootPrint>", members(&[1], 0));
    let text = building(&(outline.clone() + &solid(1, &ALL) + &solid(2, &ALL) + &solid(4, &ALL[..5])));
    for (lod, found, others) in [(None, 6, 3), (Some("1"), 6, 3), (Some("4"), 5, 3), (Some("0"), 1, 3)] {
        let asked = ReadOptions { lod: lod.map(str::to_owned), ..ReadOptions::default() };
        let geometry = read_as(&text, &asked).expect("readable");
        assert_eq!((geometry.face_count(), left_out(&geometry)), (found, others), "{lod:?}");
    }
    assert_eq!(read(&building(&solid(4, &ALL))).face_count(), 6);
    let message = read_as(&building(&outline), &ReadOptions::default()).expect_err("an outline").to_string();
    assert!(message.contains("flat outlines of buildings"), "{message}");
}

/// A building whose level 2 lacks a wall is read in its closed level 1, with 1 name in a warning.
/// If level 2 lacks only its floor, level 2 is read.
#[test]
fn an_open_level_gives_way_to_a_closed_one() {
    let geometry = read(&building(&(solid(1, &ALL) + &solid(2, &[0, 1, 2, 3, 4]))));
    assert_eq!(geometry.face_count(), 6);
    let [doubt] = geometry.doubts.as_slice() else { panic!("{:?}", geometry.doubts) };
    assert!(doubt.plain().starts_with("1 building (`b`) read in a coarser level of detail"), "{doubt:?}");
    let geometry = read(&building(&(solid(1, &ALL) + &solid(2, &[1, 2, 3, 4, 5]))));
    assert_eq!((geometry.face_count(), geometry.doubts.len()), (5, 0));
    // Both levels are open: the finer one is read.
    assert_eq!(read(&building(&(solid(1, &[0, 1, 2]) + &solid(2, &[0, 1, 2, 3])))).face_count(), 4);
}

/// Parts belong to their building, whose own coarser geometry is left out. An installation is an
/// object, and a room is left out.
#[test]
fn parts_are_read_and_rooms_are_left_out() {
    let part = |property: &str, kind: &str, id: &str, lod: u32| {
        format!(r#"<bldg:{property}><bldg:{kind} gml:id="{id}">{}</bldg:{kind}></bldg:{property}>"#, solid(lod, &ALL))
    };
    let text = solid(1, &ALL)
        + &part("consistsOfBuildingPart", "BuildingPart", "c", 2)
        + &part("outerBuildingInstallation", "BuildingInstallation", "d", 2)
        + &part("interiorRoom", "Room", "e", 4);
    let geometry = read(&building(&text));
    assert_eq!(geometry.objects.as_slice(), ["c", "d"]);
    assert_eq!((geometry.face_count(), left_out(&geometry)), (12, 2), "{:?}", geometry.left_out);
    assert!(geometry.object_notes.values().all(|note| note.building == "b" && !note.beside));
}

/// Version 3.0 with its namespaces, a window in a wall and a default prefix gives 4 faces with 4
/// names, one of them a window.
#[test]
fn version_3_0_gives_named_faces() {
    let filled = format!(
        r#"<boundary><con:WallSurface><con:fillingSurface><con:WindowSurface><lod3MultiSurface><gml:MultiSurface>{}</gml:MultiSurface></lod3MultiSurface>
        </con:WindowSurface></con:fillingSurface><lod3MultiSurface><gml:MultiSurface>{}</gml:MultiSurface></lod3MultiSurface></con:WallSurface></boundary>"#,
        members(&[3], 7),
        members(&[2], 0)
    );
    let more: String = [("RoofSurface", 1), ("GroundSurface", 0)]
        .map(|(kind, face)| {
            format!("<boundary><con:{kind}><lod3MultiSurface><gml:MultiSurface>{}</gml:MultiSurface></lod3MultiSurface></con:{kind}></boundary>", members(&[face], 0))
        })
        .concat();
    let geometry = read(&building(&(filled + &more)));
    assert_eq!(geometry.materials.as_slice(), ["Window", "WallSurface", "RoofSurface", "GroundSurface"]);
    let windows = (0..4).filter(|face| geometry.note_of(*face).kind == Some(SurfaceKind::Window)).count();
    assert_eq!((geometry.face_count(), windows), (4, 1));
}

/// Terrain of two triangles has the material `TINRelief`; breaklines and mass points are left out,
/// 2 of 2.
#[test]
fn terrain_is_read_without_its_breaklines() {
    let triangle = |ring: &str| {
        format!(
            "<gml:Triangle><gml:exterior><gml:LinearRing><gml:posList>{ring}</gml:posList></gml:LinearRing></gml:exterior></gml:Triangle>"
        )
    };
    let text = model(&member(&format!(
        r#"<dem:ReliefFeature gml:id="r"><dem:lod>2</dem:lod><dem:reliefComponent><dem:TINRelief gml:id="t"><dem:lod>2</dem:lod><dem:tin><gml:Tin>
        <gml:stopLines/><gml:maxLength uom="m">50</gml:maxLength><gml:trianglePatches>{}{}</gml:trianglePatches></gml:Tin></dem:tin></dem:TINRelief></dem:reliefComponent>
        <dem:reliefComponent><dem:MassPointRelief><dem:lod>2</dem:lod><dem:reliefPoints><gml:MultiPoint/></dem:reliefPoints></dem:MassPointRelief></dem:reliefComponent>
        </dem:ReliefFeature>"#,
        triangle("0 0 1 10 0 1 10 10 2 0 0 1"),
        triangle("0 0 1 10 10 2 0 10 1 0 0 1")
    )));
    let geometry = read(&text);
    assert_eq!(faces(&geometry), [("t", "TINRelief"), ("t", "TINRelief")]);
    assert_eq!((geometry.vertices.len(), left_out(&geometry)), (4, 2));
}

/// A template is placed for three trees, 10 m apart, one of them mirrored; a tree may come before
/// the tree that holds the template.
#[test]
fn a_template_is_placed_for_each_tree() {
    let tree = |id: &str, geometry: &str, scale: &str, x: u32| {
        member(&format!(
            r#"<veg:SolitaryVegetationObject gml:id="{id}"><veg:lod2ImplicitRepresentation><core:ImplicitGeometry>
            <core:transformationMatrix>{scale} 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1</core:transformationMatrix>
            <core:relativeGMLGeometry{geometry}</core:relativeGMLGeometry><core:referencePoint><gml:Point><gml:pos>{x} 500 7</gml:pos></gml:Point></core:referencePoint>
            </core:ImplicitGeometry></veg:lod2ImplicitRepresentation></veg:SolitaryVegetationObject>"#
        ))
    };
    let inline = format!(r#"><gml:MultiSurface gml:id="crown">{}</gml:MultiSurface>"#, members(&[1], 0));
    let reference = r##" xlink:href="#crown">"##;
    let text =
        model(&(tree("c", reference, "1", 120) + &tree("a", &inline, "1", 100) + &tree("b", reference, "-1", 110)));
    let geometry = read(&text);
    let mut found: Vec<(&str, f64, f64)> = Vec::new();
    for face in geometry.faces() {
        let corners: Vec<DVec3> = face.corners().iter().map(|i| geometry.vertices[*i as usize]).collect();
        let low = corners.iter().fold(f64::INFINITY, |low, corner| low.min(corner.x));
        let up = (corners[1] - corners[0]).cross(corners[2] - corners[0]).z;
        assert_eq!((corners.len(), corners[0].z), (4, 12.0));
        found.push((geometry.objects.as_slice()[face.object as usize].as_str(), low, up));
    }
    assert_eq!(found, [("a", 101.0, 100.0), ("b", 101.0, 100.0), ("c", 121.0, 100.0)]);
    assert!(geometry.object_notes.values().all(|note| note.beside));
}

/// Buildings that refer to each other's walls are read with them, in either order; a reference to
/// nothing is counted.
#[test]
fn references_across_objects_are_followed() {
    let one = |id: &str, geometry: &str| {
        member(&format!(
            r#"<bldg:Building gml:id="{id}"><bldg:lod2MultiSurface><gml:MultiSurface>{geometry}</gml:MultiSurface></bldg:lod2MultiSurface></bldg:Building>"#
        ))
    };
    let refer = |id: &str| format!(r##"<gml:surfaceMember xlink:href="#{id}"/>"##);
    let text = model(
        &(one("a", &(members(&[1], 0) + &refer("p2")))
            + &one("b", &(members(&[2], 0) + &refer("p1") + &refer("nothing")))),
    );
    let geometry = read(&text);
    assert_eq!((geometry.face_count(), left_out(&geometry)), (4, 1), "{:?}", geometry.left_out);
}

/// Latitude and longitude in Japan become metres of UTM, 10 m apart, or of the scene's system; a
/// note says which.
#[test]
fn degrees_become_metres_with_a_note() {
    let text = building(
        "<lod1MultiSurface><gml:MultiSurface srsName=\"http://www.opengis.net/def/crs/EPSG/0/6697\"><gml:surfaceMember><gml:Polygon><gml:exterior><gml:LinearRing>\
         <gml:posList>35.25 139.7 1 35.25 139.70011 1 35.2501 139.7 1 35.25 139.7 1</gml:posList></gml:LinearRing></gml:exterior></gml:Polygon>\
         </gml:surfaceMember></gml:MultiSurface></lod1MultiSurface>",
    )
    .replace("srsName=\"EPSG:25832\"", "");
    let geometry = read(&text);
    assert_eq!((geometry.reference, geometry.in_metres, geometry.notes.len()), (Some(Reference::Epsg(32654)), true, 1));
    let sides = [1, 2].map(|i| geometry.vertices[i].distance(geometry.vertices[0]));
    assert!((sides[0] - 10.01).abs() < 0.02 && (sides[1] - 11.09).abs() < 0.02, "{sides:?}");
    let own = read_as(&text, &ReadOptions { system: Some(6677), ..ReadOptions::default() }).expect("readable");
    assert!((own.vertices[0] - DVec3::new(-12_133.41, -83_197.58, 1.0)).length() < 0.1, "{}", own.vertices[0]);
}

/// Attributes of a building in version 2.0 and of its part in 3.0 are kept by name, 7 of them;
/// attributes of extensions and addresses are dropped.
#[test]
fn attributes_are_kept_by_name() {
    let text = building(
        r#"<gml:name>Town hall</gml:name><bldg:usage>1000</bldg:usage><bldg:usage>1010</bldg:usage><bldg:measuredHeight uom="m">7.50</bldg:measuredHeight>
        <gen:stringAttribute name="owner"><gen:value>A &amp; B</gen:value></gen:stringAttribute><uro:surveyYear>2020</uro:surveyYear>
        <bldg:address><core:Address><name>no</name></core:Address></bldg:address>
        <buildingPart><BuildingPart><genericAttribute><gen:IntAttribute><gen:name>flats</gen:name><gen:value>3</gen:value></gen:IntAttribute></genericAttribute>
        <class>x</class></BuildingPart></buildingPart>"#,
    );
    let mut coordinates = Coordinates::new(None);
    let xml = Xml::new(Box::new(text.as_bytes()), Path::new("town.gml"));
    let mut found = Vec::new();
    let read = Scan::new(xml, &mut coordinates, 0).all(&mut |draft| {
        found.extend(
            draft
                .features
                .into_iter()
                .map(|feature| serde_json::Value::Object(feature.attributes.into_values()).to_string()),
        );
        Ok(())
    });
    assert_eq!(read.expect("readable"), 0);
    let own = r#"{"measuredHeight":7.5,"name":"Town hall","owner":"A & B","usage":["1000","1010"]}"#;
    assert_eq!(found, [own, r#"{"class":"x","flats":3}"#]);
}

/// The hamlet of the repository has the areas by material that `tools/citygml/areas.py` sums,
/// within 0.01 m2, and 13 objects, of which 9 are buildings or building parts. The solid of
/// `house_5` that refers to its surfaces adds none.
#[test]
fn the_hamlet_has_the_areas_of_the_second_reader() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/citygml/small.gml");
    let Ok(Content::Polygons(geometry)) = formats::read(&file, &ReadOptions::default()) else { panic!("no polygons") };
    for (material, expected) in [
        ("GroundSurface", 1747.00),
        ("RoofSurface", 1932.74),
        ("TINRelief", 19_204.80),
        ("WallSurface", 3073.00),
        ("Window", 3.00),
    ] {
        let number = geometry.materials.as_slice().iter().position(|name| name == material).expect(material);
        let of_material = geometry.faces().filter(|face| face.material as usize == number);
        let area: f64 = of_material.map(|face| area_vector_of(&face, &geometry.vertices).length()).sum();
        assert!((area - expected).abs() < 0.01, "{material}: {area}");
    }
    let buildings = geometry.object_notes.values().filter(|note| !note.beside).count();
    assert_eq!((geometry.objects.as_slice().len(), buildings, geometry.doubts.len()), (13, 9, 0));
}

/// Holes, single points and coordinates of GML 2 are read: 1 face of 8 corners, 4 of which are a
/// hole, and 1 face of 4.
#[test]
fn every_spelling_of_a_ring_is_read() {
    let pos = |text: &str| text.split(',').map(|pos| format!("<gml:pos>{pos}</gml:pos>")).collect::<String>();
    let holed = format!(
        "<gml:surfaceMember><gml:Polygon><gml:exterior><gml:LinearRing>{}</gml:LinearRing></gml:exterior><gml:interior><gml:LinearRing>{}</gml:LinearRing></gml:interior></gml:Polygon></gml:surfaceMember>",
        pos("0 0 0,9 0 0,9 9 0,0 9 0,0 0 0"),
        pos("1 1 0,1 2 0,2 2 0,2 1 0,1 1 0")
    );
    let old = "<gml:surfaceMember><gml:Polygon><gml:outerBoundaryIs><gml:LinearRing><gml:coordinates>0,0,1 9,0,1 9,9,1 0,9,1 0,0,1</gml:coordinates></gml:LinearRing></gml:outerBoundaryIs></gml:Polygon></gml:surfaceMember>";
    let geometry = read(&building(&format!(
        "<lod1MultiSurface><gml:MultiSurface>{holed}{old}</gml:MultiSurface></lod1MultiSurface>"
    )));
    let found: Vec<(usize, bool)> = geometry.faces().map(|face| (face.corners().len(), face.has_holes())).collect();
    assert_eq!(found, [(8, true), (4, false)]);
}
