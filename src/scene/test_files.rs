//! Files and solids for tests. In: names and texts. Out: files in folders that go with the test,
//! the scenes in them, their areas and volumes.

use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::Scene;
use crate::covering::surfaces::Surfaces;
use crate::geometry::Geometry;
use crate::load::ObjectTriangles;
use crate::polygon::triangulate;
use crate::site::{Part, SceneFiles};
use heliotile_core::site::semantics::SurfaceKind;

/// Folder that is removed with this value.
pub struct TestFolder(tempfile::TempDir);

impl TestFolder {
    pub fn new() -> Self {
        TestFolder(tempfile::tempdir().expect("a folder"))
    }

    /// Returns the path of a file of the folder.
    pub fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file; returns its path.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        std::fs::write(self.at(name), content).expect("written");
        self.at(name)
    }
}

/// Reads one scene file.
pub fn load_file(path: &Path) -> Result<(Scene, ObjectTriangles), String> {
    let site = SceneFiles { parts: vec![Part::plain(path, None)], ..SceneFiles::default() };
    Scene::load_with_objects(&site).map_err(|error| error.to_string())
}

/// Reads a scene file of `tests/data`.
pub fn load_case(name: &str) -> Result<(Scene, ObjectTriangles), String> {
    load_file(&Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data")).join(name))
}

/// Writes a scene file and reads it.
pub fn load_text(name: &str, text: &str) -> Result<(Scene, ObjectTriangles), String> {
    load_file(&TestFolder::new().write(name, text))
}

/// Returns the areas of roofs and walls, m2.
pub fn areas_m2(scene: &Scene, soup: &ObjectTriangles) -> [f64; 2] {
    let surfaces = Surfaces::find(soup, &scene.materials);
    [SurfaceKind::Roof, SurfaceKind::Wall].map(|kind| {
        let own = surfaces.list.iter().filter(|surface| surface.kind == kind);
        own.map(|surface| surface.area_m2).sum()
    })
}

/// Returns the object and material of every face.
pub fn faces(geometry: &Geometry) -> Vec<(&str, &str)> {
    let (objects, materials) = (geometry.objects.as_slice(), geometry.materials.as_slice());
    geometry
        .faces()
        .map(|face| (objects[face.object as usize].as_str(), materials[face.material as usize].as_str()))
        .collect()
}

/// Checks that a file with a fault gives `count` faces, no more than one sentence, which contains
/// `words`, and triangles.
pub fn assert_said(geometry: &Geometry, count: usize, words: &str) {
    assert_eq!(geometry.face_count(), count, "{words}");
    let left = geometry.left_out.iter().map(|(reason, count)| format!("LEFT {count} {reason}"));
    let said: Vec<String> = geometry.warnings.iter().map(|said| said.plain()).chain(left).collect();
    assert!(said.len() <= 1 && said.join("").contains(words), "{words}: {said:?}");
    triangulate(geometry).expect(words);
}

/// Checks that an outline of a million corners is read unchanged, and that triangulation refuses
/// it.
pub fn assert_too_many_corners(geometry: &Geometry) {
    assert_eq!((geometry.face_count(), geometry.vertices.len()), (1, 1_000_000));
    let message = triangulate(geometry).expect_err("too many").to_string();
    assert!(message.contains("1000000, the limit is 65536"), "{message}");
}

/// Random numbers below a limit, equal in every run.
pub struct Random(u64);

impl Random {
    pub fn new() -> Self {
        Random(0x2545_f491_4f6c_dd1d)
    }

    pub fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % limit as u64) as usize
    }
}

/// Returns corners and 12 triangles of the cube from 0 to 1: outsides counter-clockwise, z up.
pub fn cube() -> ([DVec3; 8], [[u32; 3]; 12]) {
    let vertices = std::array::from_fn(|i| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64));
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = std::array::from_fn(|i| {
        let [a, b, c, d]: [u32; 4] = sides[i / 2];
        if i % 2 == 0 { [a, b, c] } else { [a, c, d] }
    });
    (vertices, triangles)
}

/// Returns the area and, by the divergence theorem, the volume of a closed surface; the volume is
/// negative if the surface is inside out.
pub fn area_and_volume(geometry: &Geometry) -> (f64, f64) {
    let triangles = triangulate(geometry).expect("within limits").triangles;
    triangles.iter().fold((0.0, 0.0), |(area, volume), triangle| {
        let [a, b, c] = triangle.corners.map(|corner| geometry.vertices[corner as usize]);
        let normal = (b - a).cross(c - a);
        (area + 0.5 * normal.length(), volume + a.dot(normal) / 6.0)
    })
}
