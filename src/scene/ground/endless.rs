//! The endless ground: a horizontal plane under the whole scene, lit and shadowed like any surface
//! near it. In: its table in `materials.toml` and the corners of the scene. Out: two triangles so
//! large that almost nothing can be seen beyond them.

use glam::DVec3;

use crate::mesh::RawTriangle;

/// Name of the table, the object and the material of the endless ground.
pub(crate) const NAME: &str = "endless_ground";

/// Reach of the plane beyond the scene, in metres and in heights of the scene above the plane; the
/// larger one counts. Seen from the scene, 0.003 rad below the horizon are missing, 0.1 % of the
/// view of a wall.
const BEYOND_M: f64 = 20_000.0;
const HEIGHTS: f64 = 400.0;

/// Largest half side of the plane, metres: scenes end there. From 2.5 km up, 0.0025 rad below the
/// horizon are missing.
const MAX_M: f64 = 1e6;

/// Properties of the endless ground besides its material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EndlessGround {
    /// Height of the plane, metres; `None`: the scene's lowest point.
    pub elevation_m: Option<f64>,
}

impl EndlessGround {
    /// Adds the plane to a scene's corners and triangles; returns a warning if it hides a part of
    /// the scene.
    pub(crate) fn add(
        self,
        corners: &mut Vec<DVec3>,
        triangles: &mut Vec<RawTriangle>,
        material: u32,
    ) -> Option<String> {
        let used = triangles.iter().flat_map(|t| t.corners).filter_map(|i| corners.get(i as usize));
        let (low, high) =
            used.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
        if !(low.is_finite() && high.is_finite()) {
            return None;
        }
        let z = self.elevation_m.unwrap_or(low.z);
        let middle = (low + high) / 2.0;
        let half = (high - low).truncate().max_element() / 2.0 + BEYOND_M.max(HEIGHTS * (high.z - z));
        let half = half.min(MAX_M);
        let first = corners.len() as u32;
        for (x, y) in [(-half, -half), (half, -half), (half, half), (-half, half)] {
            corners.push(DVec3::new(middle.x + x, middle.y + y, z));
        }
        for [b, c] in [[1, 2], [2, 3]] {
            triangles.push(RawTriangle { corners: [first, first + b, first + c], material, object: 0 });
        }
        let hidden = z - low.z;
        (hidden > 0.01).then(|| {
            format!("the scene reaches {hidden:.2} m below the endless ground at {z} m, which hides that part")
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::Scene;
    use crate::test_files::TestFolder;

    const BOX: &str = "v 0 0 2\nv 4 0 2\nv 4 6 2\nv 0 6 2\nv 0 0 5\nv 4 0 5\nv 4 6 5\nv 0 6 5\nusemtl roof\nf 5 6 7 8\nusemtl wall\n\
                       f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

    fn load(obj: &str, toml: &str) -> Scene {
        let folder = TestFolder::new();
        let materials = folder.write("m.toml", format!("[roof]\ndiffuse = 0.2\n[wall]\ndiffuse = 0.3\n{toml}"));
        Scene::load(&folder.write("s.obj", obj), Some(&materials)).expect("a scene")
    }

    /// The plane equals two triangles of 40,006 m in the OBJ file, at the lowest point or at a
    /// stated height. A plane above the foot of the walls gets a warning with the 0.50 m that it
    /// hides; one below gets none.
    #[test]
    fn the_plane_equals_two_large_triangles() {
        let ground = |z: f64| {
            format!(
                "v -20001 -20000 {z}\nv 20005 -20000 {z}\nv 20005 20006 {z}\nv -20001 20006 {z}\nusemtl earth\nf -4 -3 -2 -1\n"
            )
        };
        let plain = "[endless_ground]\ndiffuse = 0.25\n";
        for (z, stated, warnings) in [(2.0, "", 0), (1.5, "elevation = 1.5\n", 0), (2.5, "elevation = 2.5\n", 1)] {
            let endless = load(BOX, &format!("{plain}{stated}"));
            let explicit = load(&format!("{BOX}{}", ground(z)), "[earth]\ndiffuse = 0.25\n");
            assert_eq!(endless.mesh.triangles.len(), 12);
            assert_eq!(
                (&endless.mesh.vertices, &endless.mesh.triangles),
                (&explicit.mesh.vertices, &explicit.mesh.triangles)
            );
            let named =
                endless.report.warnings.iter().filter(|w| w.contains("0.50 m below the endless ground")).count();
            assert_eq!((named, endless.report.warnings.len()), (warnings, warnings));
        }
        assert_eq!(load(BOX, "").mesh.triangles.len(), 10);
    }
}
