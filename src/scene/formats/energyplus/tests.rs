//! Models of both syntaxes, whole and broken.

use std::path::Path;

use super::*;

fn read_text(text: &str, name: &str) -> Result<Geometry> {
    parse(text.as_bytes(), Path::new(name), &Asked { reflectances: true, lod: None })
}

#[test]
fn dump() {
    let Ok(path) = std::env::var("ENERGYPLUS_DUMP") else { return };
    let geometry = read(Path::new(&path), &Asked { reflectances: true, lod: None }).expect("readable");
    for face in geometry.faces() {
        let mut sum = glam::DVec3::ZERO;
        let mut first = None;
        let mut gross = 0.0;
        for ring in face.rings() {
            let v: Vec<_> = ring.iter().map(|&i| geometry.vertices[i as usize]).collect();
            let a = place::area_vector(&v);
            match first {
                None => {
                    first = Some(a);
                    sum = a;
                    gross = a.length()
                }
                Some(f) => sum -= if f.dot(a) > 0.0 { a } else { -a },
            }
        }
        let n = sum.normalize();
        println!(
            "ROW,{},{},{},{},{},{}",
            geometry.objects.as_slice()[face.object as usize],
            gross,
            sum.length(),
            n.x,
            n.y,
            n.z
        );
    }
    eprintln!("{:#?} {:#?} {:#?}", geometry.warnings, geometry.left_out, geometry.stated);
    let cut = crate::scene::polygon::triangulate(&geometry).expect("cut");
    eprintln!("{:?} {:?} {}", cut.crossing_faces, cut.off_plane, cut.degenerate_faces);
    let mut cut_area = vec![0.0; geometry.objects.as_slice().len()];
    for (t, o) in cut.triangles.iter().zip(&cut.objects) {
        let v = t.corners.map(|i| geometry.vertices[i as usize]);
        cut_area[*o as usize] += place::area_vector(&v).length();
    }
    for (n, a) in geometry.objects.as_slice().iter().zip(cut_area) {
        println!("CUT,{n},{a}");
    }
}
