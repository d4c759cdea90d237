//! In: city models that are broken, cut off or malicious. Out: proof that they are refused with a
//! message, or that only the wrong part is lost.

use crate::formats::ReadOptions;
use crate::formats::citygml::tests::{building, left_out, member, model, polygon, read, read_as, solid};

const ALL: [usize; 6] = [0, 1, 2, 3, 4, 5];

fn refused(text: &str) -> String {
    read_as(text, &ReadOptions::default()).expect_err(text).to_string()
}

/// One of three buildings, with a coordinate that is no number, is infinite or is missing, is left
/// out by name and line; the 12 faces of the other two stay.
#[test]
fn a_wrong_object_costs_no_other() {
    let one = |id: &str, geometry: &str| member(&format!(r#"<bldg:Building gml:id="{id}">{geometry}</bldg:Building>"#));
    let sound = solid(1, &ALL);
    for (from, to, said) in [
        ("10 10 5", "10 ten 5", "`ten`, not a number"),
        ("10 10 5", "10 NaN 5", "`NaN`, not a number"),
        ("10 10 5", "10 1e999 5", "`1e999`, not a number"),
        ("10 10 5", "10 1e12 5", "a corner has impossible coordinates: 10 1000000000000 5"),
        ("<gml:posList>", "<gml:posList srsDimension=\"3\">7 ", "a ring has 16 numbers"),
        ("<gml:Solid>", "<gml:Solid srsName=\"EPSG:25833\">", "its coordinate system is `EPSG:25833`"),
    ] {
        let wrong = sound.replacen(from, to, 1);
        assert_ne!(wrong, sound);
        let geometry = read(&model(&(one("a", &sound) + &one("b", &wrong) + &one("c", &sound))));
        assert_eq!(geometry.face_count(), 12, "{to}");
        let [warning] = geometry.warnings.as_slice() else { panic!("{:?}", geometry.warnings) };
        assert!(warning.contains("1 city object left out") && warning.contains("object `b`: "), "{warning:?}");
        let line = if to.starts_with("10 ") { "line 11, " } else { "line 10, " };
        assert!(warning.contains(said) && warning.contains(line), "{warning:?}");
    }
}

/// Ten files are refused with what they are or lack.
#[test]
fn unreadable_files_are_refused_with_a_reason() {
    let sound = building(&solid(1, &ALL));
    let with = |from: &str, to: &str| sound.replace(from, to);
    for (text, said) in [
        (String::new(), "the file is empty"),
        ("<gbXML/>".into(), "the file is gbXML"),
        ("<html><body/></html>".into(), "the root element is `html`"),
        ("{\"type\":\"CityJSON\"}".into(), "the file is empty"),
        (model(""), "holds no city objects"),
        (building(""), "none of the 1 city objects has a surface"),
        (with("EPSG:25832", "EPSG:4978"), "geocentric"),
        (with("EPSG:25832", "EPSG:6697").replace("10 10 5", "139 135 5").replace("0 0", "139 135"), "latitude 139"),
        (with("<?xml version=\"1.0\"?>", "<!DOCTYPE a [<!ENTITY x \"y\">]>"), "DOCTYPE declares"),
        (sound[..sound.len() / 2].to_owned(), "the file ends within"),
    ] {
        let message = refused(&text);
        assert!(message.contains("town.gml") && message.contains(said), "{said}: {message}");
    }
}

/// A circle of references, a reference that leads nowhere, one into another file and an outline
/// without heights leave 1 face and 4 reasons.
#[test]
fn references_that_lead_nowhere_are_left_out() {
    let text = building(&format!(
        r##"<lod2MultiSurface><gml:MultiSurface gml:id="m"><gml:surfaceMember>{}</gml:surfaceMember><gml:surfaceMember xlink:href="#m"/>
        <gml:surfaceMember xlink:href="#n"/><gml:surfaceMember xlink:href="other.gml#n"/><gml:surfaceMember><gml:Polygon><gml:exterior><gml:LinearRing>
        <gml:posList srsDimension="2">0 0 1 0 1 1 0 1 0 0 1 1</gml:posList></gml:LinearRing></gml:exterior></gml:Polygon></gml:surfaceMember></gml:MultiSurface></lod2MultiSurface>"##,
        polygon(1, 0)
    ));
    let geometry = read(&text);
    assert_eq!((geometry.face_count(), geometry.left_out.len()), (1, 4), "{:?}", geometry.left_out);
}

/// Two objects that refer to each other's aggregates in a circle do not loop: 4 faces in all.
#[test]
fn circles_across_objects_end() {
    let one = |id: &str, own: &str, other: &str, face: usize| {
        member(&format!(
            r##"<bldg:Building gml:id="{id}"><lod2MultiSurface><gml:MultiSurface gml:id="{own}"><gml:surfaceMember>{}</gml:surfaceMember>
            <gml:surfaceMember xlink:href="#{other}"/></gml:MultiSurface></lod2MultiSurface></bldg:Building>"##,
            polygon(face, 0)
        ))
    };
    let geometry = read(&model(&(one("a", "m", "n", 1) + &one("b", "n", "m", 2))));
    assert_eq!(geometry.face_count(), 4);
}

/// A hundred thousand rings in one polygon, and a ring of a hundred thousand corners, are read: 2
/// faces.
#[test]
fn many_rings_and_corners_are_read() {
    let ring = |corners: usize| "1 2 3 4 5 6 ".repeat(corners / 2);
    let hole =
        format!("<gml:interior><gml:LinearRing><gml:posList>{}</gml:posList></gml:LinearRing></gml:interior>", ring(4));
    let holed = polygon(1, 0).replace("</gml:Polygon>", &(hole.repeat(100_000) + "</gml:Polygon>"));
    let long = format!(
        "<gml:Polygon><gml:exterior><gml:LinearRing><gml:posList>{}</gml:posList></gml:LinearRing></gml:exterior></gml:Polygon>",
        ring(100_000)
    );
    let text = building(&format!(
        "<lod1MultiSurface><gml:MultiSurface><gml:surfaceMembers>{holed}{long}</gml:surfaceMembers></gml:MultiSurface></lod1MultiSurface>"
    ));
    let geometry = read(&text);
    assert_eq!((geometry.face_count(), left_out(&geometry)), (2, 0));
    assert_eq!(geometry.faces().map(|face| face.corners().len()).collect::<Vec<_>>(), [400_004, 100_000]);
}

/// A template of 100,000 corners in 1,400 places is refused: it expands to more than its file may.
#[test]
fn a_template_bomb_ends_at_the_limit() {
    let ring = "1 2 3 4 5 6 ".repeat(50_000);
    let place = |geometry: &str| {
        format!(
            "<lod1ImplicitRepresentation><ImplicitGeometry><relativeGMLGeometry{geometry}</relativeGMLGeometry><referencePoint><gml:Point><gml:pos>1 2 3</gml:pos>\
             </gml:Point></referencePoint></ImplicitGeometry></lod1ImplicitRepresentation>"
        )
    };
    let inline = format!(
        "><gml:MultiSurface gml:id=\"t\"><gml:surfaceMember><gml:Polygon><gml:exterior><gml:LinearRing><gml:posList>{ring}</gml:posList></gml:LinearRing></gml:exterior></gml:Polygon></gml:surfaceMember></gml:MultiSurface>"
    );
    let tree = |geometry: &str, times: usize| {
        member(&format!("<veg:PlantCover>{}</veg:PlantCover>", place(geometry).repeat(times)))
    };
    let text = model(&(tree(&inline, 1) + &tree(" xlink:href=\"#t\">", 1399)));
    let message = refused(&text);
    assert!(message.contains("town.gml: its instances of templates expand to more than 512 MiB"), "{message}");
}

/// A file of 3 kB that is cut after any byte, or has one bit of any byte flipped, is read or
/// refused without a panic.
#[test]
fn any_cut_and_any_bit_cause_no_panic() {
    let tree = member(
        r#"<veg:SolitaryVegetationObject gml:id="t"><lod1ImplicitRepresentation><ImplicitGeometry><transformationMatrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1
        </transformationMatrix><relativeGMLGeometry xlink:href="&#35;p1"/><referencePoint><gml:Point><gml:pos>1 2 3</gml:pos></gml:Point></referencePoint>
        </ImplicitGeometry></lod1ImplicitRepresentation><genericAttribute><StringAttribute><name>a</name><value><![CDATA[b]]></value></StringAttribute></genericAttribute>
        </veg:SolitaryVegetationObject>"#,
    );
    let text =
        building(&(solid(1, &ALL) + &solid(2, &ALL[1..]))).replace("</core:CityModel>", &(tree + "</core:CityModel>"));
    let (mut read, mut refused) = (0, 0);
    for at in 0..text.len() {
        let mut bytes = text.clone().into_bytes();
        bytes[at] ^= 1 << (at % 8);
        for text in [text[..at].to_owned(), String::from_utf8_lossy(&bytes).into_owned()] {
            match read_as(&text, &ReadOptions::default()) {
                Ok(_) => read += 1,
                Err(_) => refused += 1,
            }
        }
    }
    assert!(read > 500 && refused > 3000, "{read} {refused}");
}
