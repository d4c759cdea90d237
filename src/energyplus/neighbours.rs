//! Surroundings of a model as shading surfaces. In: a soup of triangles, and the place of the
//! model's origin among them. Out: polygons in the model's coordinates, one for each convex face,
//! so that EnergyPlus shades direct light, too.

use std::collections::BTreeMap;

use glam::DVec3;

use super::document::Document;
use super::new_object::{FieldValue, NewObject};
use heliotile_core::site::material::{Class, Material};
use heliotile_core::site::place::Place;
use heliotile_scene::load::ObjectTriangles;

/// Decimals of coordinates in metres: a tenth of a millimetre.
const DECIMALS: usize = 4;

/// Reflectance that EnergyPlus gives shading surfaces by default.
const USUAL: f64 = 0.2;

/// Position of a model in the coordinates of its surroundings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spot {
    /// Position of the model's origin, metres.
    pub origin: DVec3,
    /// Direction of true north, degrees clockwise from y: minus the convergence of the grid.
    pub north_deg: f64,
}

/// Surfaces around a model, in its coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Neighbours {
    /// Corners of each polygon, and the number of its material.
    pub polygons: Vec<(Vec<DVec3>, u16)>,
    /// Number of ground triangles, which are left out: EnergyPlus has a ground plane of its own.
    pub ground: usize,
}

impl Spot {
    /// Converts a position of the surroundings to model coordinates.
    pub fn to_model(self, p: DVec3) -> DVec3 {
        let (sin, cos) = self.north_deg.to_radians().sin_cos();
        let p = p - self.origin;
        // North is (sin, cos), east a right angle clockwise of it.
        DVec3::new(p.x * cos - p.y * sin, p.x * sin + p.y * cos, p.z)
    }

    /// Returns the spot of an origin where y points `convergence_deg` clockwise of true north.
    pub fn at(origin: DVec3, convergence_deg: f64) -> Spot {
        Spot { origin, north_deg: -convergence_deg }
    }
}

impl Neighbours {
    /// Collects the obstructions of a soup as polygons. The triangles of a face that is convex
    /// become one polygon.
    pub fn new(soup: &ObjectTriangles, materials: &[Material], spot: Spot) -> Neighbours {
        let mut found = Neighbours::default();
        let mut faces: BTreeMap<(u32, u16), Vec<[u32; 3]>> = BTreeMap::new();
        for (i, corners) in soup.triangles.iter().enumerate() {
            let Some(&number) = soup.materials.get(i) else { continue };
            match materials.get(usize::from(number)) {
                Some(material) if material.class == Class::Obstruction => {
                    // A triangle without a face comes from no file: it is the ground plane that
                    // heliotile adds.
                    let Some(&face) = soup.faces.get(i) else { continue };
                    faces.entry((face, number)).or_default().push(*corners);
                }
                Some(_) => found.ground += 1,
                None => {}
            }
        }
        let point = |corner: u32| spot.to_model(soup.positions.get(corner as usize).copied().unwrap_or_default());
        for ((_, material), triangles) in faces {
            match outline(&triangles).filter(|ring| is_convex(&ring.iter().map(|c| point(*c)).collect::<Vec<_>>())) {
                Some(ring) => found.polygons.push((ring.into_iter().map(point).collect(), material)),
                None => {
                    found.polygons.extend(triangles.iter().map(|t| (t.iter().map(|c| point(*c)).collect(), material)))
                }
            }
        }
        found
    }

    /// Adds the polygons to a model. With `reflecting`, their reflectances are added, too, so that
    /// EnergyPlus reflects light itself.
    pub fn add(&self, document: &mut Document, materials: &[Material], reflecting: bool) {
        let mut screens: BTreeMap<u16, String> = BTreeMap::new();
        for (i, (corners, number)) in self.polygons.iter().enumerate() {
            let name = format!("heliotile neighbour {}", i + 1);
            let Some(material) = materials.get(usize::from(*number)) else { continue };
            let screen = material.transmittance.map(|share| {
                screens.entry(*number).or_insert_with(|| {
                    let name = format!("heliotile screen {number}");
                    let mut schedule = NewObject::new("Schedule:Constant", &name, &[("schedule_type_limits_name", "")]);
                    schedule.fields.push(("hourly_value", FieldValue::number(share, DECIMALS)));
                    document.add(schedule);
                    name
                })
            });
            let transmittance = [("transmittance_schedule_name", screen.map_or("", |name| name.as_str()))];
            let mut shade = NewObject::new("Shading:Site:Detailed", &name, &transmittance);
            shade.fields.push(("number_of_vertices", FieldValue::Number(corners.len().to_string())));
            document.add(shade.with_vertices(corners.iter().map(|p| p.to_array()).collect(), DECIMALS));
            if reflecting && (material.diffuse - USUAL).abs() > 1e-6 {
                let mut property =
                    NewObject::new("ShadingProperty:Reflectance", &name, &[("shading_surface_name", &name)]);
                let diffuse = || FieldValue::number(material.diffuse, DECIMALS);
                property.fields.extend([
                    ("diffuse_solar_reflectance_of_unglazed_part_of_shading_surface", diffuse()),
                    ("diffuse_visible_reflectance_of_unglazed_part_of_shading_surface", diffuse()),
                ]);
                document.add(property.nameless());
            }
        }
    }
}

/// Returns the ring around triangles that share edges, if it is one ring through all of their
/// corners.
fn outline(triangles: &[[u32; 3]]) -> Option<Vec<u32>> {
    let mut next: BTreeMap<u32, u32> = BTreeMap::new();
    let edges = || triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    let all: std::collections::BTreeSet<(u32, u32)> = edges().collect();
    for (a, b) in edges().filter(|(a, b)| !all.contains(&(*b, *a))) {
        if next.insert(a, b).is_some() {
            return None;
        }
    }
    let (&first, _) = next.first_key_value()?;
    let mut ring = vec![first];
    let mut at = *next.get(&first)?;
    while at != first && ring.len() <= next.len() {
        ring.push(at);
        at = *next.get(&at)?;
    }
    (at == first && ring.len() == next.len()).then_some(ring)
}

/// Returns true if a ring turns to one side only, and lies in a plane.
fn is_convex(ring: &[DVec3]) -> bool {
    let corner = |i: usize| ring.get(i % ring.len()).copied().unwrap_or_default();
    let normal: DVec3 = (0..ring.len()).map(|i| (corner(i) - corner(0)).cross(corner(i + 1) - corner(0))).sum();
    let Some(up) = normal.try_normalize() else { return false };
    let turns =
        (0..ring.len()).all(|i| (corner(i + 1) - corner(i)).cross(corner(i + 2) - corner(i + 1)).dot(up) > -1e-9);
    turns && ring.iter().all(|p| (*p - corner(0)).dot(up).abs() < 0.01)
}

/// Returns the direction of y at a place, degrees clockwise from true north; 0 without a coordinate
/// reference system.
pub fn convergence_deg(place: Option<&Place>) -> f64 {
    place.filter(|place| place.epsg.is_some()).map_or(0.0, |place| place.convergence_deg)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where y points 30 degrees east of true north, 1 m along the grid's y is half a metre east
    /// and 0.87 m north in the model.
    #[test]
    fn points_turn_from_grid_to_true_north() {
        let spot = Spot::at(DVec3::new(10.0, 20.0, 3.0), 30.0);
        let p = spot.to_model(DVec3::new(10.0, 21.0, 4.0));
        assert!((p - DVec3::new(0.5, 0.75_f64.sqrt(), 1.0)).length() < 1e-12, "{p}");
    }

    /// Two triangles of a square are one ring of 4 corners; two that meet in a corner are none; an
    /// L is not convex.
    #[test]
    fn two_triangles_of_a_square_are_one_ring() {
        let ring = outline(&[[0, 1, 2], [0, 2, 3]]).expect("a ring");
        assert_eq!(ring, [0, 1, 2, 3]);
        assert_eq!(outline(&[[0, 1, 2], [2, 3, 4]]), None);
        let corners = |list: &[(f64, f64)]| list.iter().map(|(x, y)| DVec3::new(*x, *y, 0.0)).collect::<Vec<_>>();
        assert!(is_convex(&corners(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])));
        assert!(!is_convex(&corners(&[(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)])));
    }
}
