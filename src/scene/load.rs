//! Several files, one scene. In: the parts of a site. Out: a scene, and its triangles with the objects they belong to. Rasters come
//! last, in the light of what they are the horizon of.

use std::path::Path;

use glam::DVec3;

use crate::coordinate::is_position;
use crate::endless_ground::EndlessGround;
use crate::formats;
use crate::formats::{Asked, Content};
use crate::geometry::{Geometry, Names};
use crate::mesh::{Canonical, RawTriangle, bounds, canonical};
use crate::palette::Palette;
use crate::placing::extent::{Extent, Walls};
use crate::placing::plausible::doubts;
use crate::placing::whereabouts::place_of;
use crate::polygon;
use crate::polygon::{OFF_PLANE_M, Triangulation, object_name};
use crate::site::{Part, Site};
use crate::terrain::focus::Focus;
use crate::terrain::raster::Raster;
use crate::terrain::surface;
use crate::terrain::surface::{Wanted, surface};
use crate::{LoadReport, Scene, contested_warning, count_uses, rank_by_name};
use heliotile_core::error::{Error, Result};

/// Triangles of a scene in the order of its files, each with the object it is a part of.
#[derive(Debug, Default)]
pub struct Soup {
    /// Input coordinates, metres.
    pub positions: Vec<DVec3>,
    /// Corners, indices into `positions`.
    pub triangles: Vec<[u32; 3]>,
    /// Indices into `Scene::materials`, `u16::MAX` for one that no triangle of the scene bears.
    pub materials: Vec<u16>,
    /// Indices into `object_names`.
    pub objects: Vec<u32>,
    /// Names of the objects in the files.
    pub object_names: Vec<String>,
}

/// What was read so far.
#[derive(Default)]
struct Pile {
    positions: Vec<DVec3>,
    triangles: Vec<RawTriangle>,
    objects: Vec<u32>,
    names: Names,
    /// How far each file reaches, and what is said of its place.
    extents: Vec<Extent>,
    report: LoadReport,
    /// Centre of all geometry but far terrain, if there is such terrain.
    focus: Option<DVec3>,
}

impl Scene {
    /// Reads one file with `materials.toml`, or without it with the reflectances that the file itself gives.
    pub fn load(file: &Path, materials: Option<&Path>) -> Result<Scene> {
        Scene::load_site(&Site { parts: vec![Part::plain(file, materials)], ..Site::default() })
    }

    /// Reads all files of a site.
    pub fn load_site(site: &Site) -> Result<Scene> {
        load(site, false).map(|loaded| loaded.0)
    }

    /// The same, and what its triangles are parts of.
    pub fn load_with_objects(site: &Site) -> Result<(Scene, Soup)> {
        load(site, true)
    }
}

/// Reads all files; without `keep` the soup is empty.
fn load(site: &Site, keep: bool) -> Result<(Scene, Soup)> {
    let (mut palette, mut pile) = (Palette::default(), Pile::default());
    let mut rasters = Vec::new();
    for part in &site.parts {
        if let Some(path) = &part.materials {
            palette.open(path)?;
        }
        let asked = Asked { reflectances: part.materials.is_none(), lod: part.lod.clone() };
        match formats::read(&part.file, &asked)? {
            Content::Polygons(geometry) => {
                let part = part.in_frame(&site.frame);
                pile.add(&part, *geometry, &mut palette, Some(&|p| part.place(p)))?;
            }
            Content::Terrain(raster) => rasters.push((part, raster.placed(part)?)),
        }
    }
    pile.add_rasters(rasters, &mut palette)?;
    let ground = palette.ground();
    pile.finish(site, &palette, ground, keep)
}

impl Pile {
    /// Meshes rasters as the horizon of what was added before, if anything was.
    fn add_rasters(&mut self, rasters: Vec<(&Part, Raster)>, palette: &mut Palette) -> Result<()> {
        let used = self.triangles.iter().flat_map(|t| t.corners).filter_map(|i| self.positions.get(i as usize));
        let (low, high) = bounds(used.copied());
        let near = (!rasters.is_empty() && low.is_finite() && high.is_finite()).then_some((low, high));
        self.focus = near.map(|(low, high)| 0.5 * (low + high));
        let only = rasters.len() == 1;
        for (part, raster) in rasters {
            let stem = formats::stem(&part.file);
            let wanted = Wanted {
                file: &part.file,
                object: if only { surface::NAME } else { &stem },
                focus: near.map(|(low, high)| Focus::around(low.truncate(), high.truncate())),
                horizon_deg: part.horizon_deg,
            };
            let (geometry, note) = surface(raster, &wanted)?;
            self.report.notes.extend(note);
            // Its raster was placed before.
            self.add(part, geometry, palette, None)?;
        }
        Ok(())
    }

    /// Adds polygons, and puts them where `place` says; the surface of a raster stays where it is.
    fn add(
        &mut self,
        part: &Part,
        geometry: Geometry,
        palette: &mut Palette,
        place: Option<&dyn Fn(DVec3) -> DVec3>,
    ) -> Result<()> {
        let cut = polygon::triangulate(&geometry)?;
        self.note(part, &geometry, &cut);
        let materials = palette.add(&part.file, &geometry, part.materials.as_deref());
        let objects: Vec<u32> = geometry.objects.as_slice().iter().map(|name| self.names.id(name)).collect();
        let first = self.positions.len() as u64;
        if first + geometry.vertices.len() as u64 > u64::from(u32::MAX) - 4 {
            return Err(Error::Limit {
                what: "the number of vertices of the scene".into(),
                value: first + geometry.vertices.len() as u64,
                max: u64::from(u32::MAX) - 4,
            });
        }
        for &vertex in &geometry.vertices {
            let placed = place.map_or(vertex, |place| place(vertex));
            if !is_position(placed) {
                let what = format!("offset and scale put a vertex at {placed}");
                return Err(Error::input(&part.file, None, what, "positions are metres, at most 1e9 in size"));
            }
            self.positions.push(placed);
        }
        let number = |of: &[u32], local: u32| of.get(local as usize).copied().unwrap_or_default();
        self.triangles.extend(cut.triangles.iter().map(|triangle| RawTriangle {
            corners: triangle.corners.map(|corner| corner + first as u32),
            material: number(&materials, triangle.material),
        }));
        self.objects.extend(cut.objects.iter().map(|&object| number(&objects, object)));
        let position = |corner: u32| self.positions.get((u64::from(corner) + first) as usize).copied();
        let corners = || cut.triangles.iter().map(|t| t.corners.map(|corner| position(corner).unwrap_or_default()));
        let mut walls = Walls::default();
        corners().for_each(|triangle| walls.add(triangle));
        let (low, high) = bounds(corners().flatten());
        if !low.is_finite() {
            // Nothing that could lie anywhere.
            return Ok(());
        }
        self.extents.push(Extent {
            file: part.file.clone(),
            raster: place.is_none(),
            bounds: [low, high],
            shift: part.shift(),
            scale: part.metres(),
            own: geometry.reference,
            stated: part.reference,
            walls,
        });
        Ok(())
    }

    /// Notes what was found in a file.
    fn note(&mut self, part: &Part, geometry: &Geometry, cut: &Triangulation) {
        let (report, file) = (&mut self.report, part.file.display());
        report.faces_read += geometry.face_count();
        report.degenerate_dropped += cut.degenerate_faces;
        report.concave_faces += cut.concave_faces;
        report.warnings.extend(geometry.warnings.iter().cloned());
        for (reason, count) in &geometry.left_out {
            report.warnings.push(format!("{file}: {count} left out {reason}"));
        }
        if let Some((count, place)) = cut.crossing_faces {
            let first = match place.line {
                0 => format!("the outline of a face of {}", object_name(geometry, place.object)),
                line => format!("line {line}: the outline of the face"),
            };
            let between = if place.line == 0 { ": " } else { ", " };
            report.warnings.push(format!(
                "{file}{between}{first} crosses itself; of {count} such faces the area may not be right"
            ));
        }
        if cut.off_plane.0 > 0 {
            let (count, most) = cut.off_plane;
            report.warnings.push(format!(
                "{file}: {count} faces are not flat, corners lie up to {most:.2} m off (more than {OFF_PLANE_M} m counts); \
                 they are folded along their diagonals"
            ));
        }
    }

    fn finish(
        mut self,
        site: &Site,
        palette: &Palette,
        ground: Option<(EndlessGround, u32)>,
        keep: bool,
    ) -> Result<(Scene, Soup)> {
        let place = place_of(&self.extents, &site.frame, &mut self.report)?;
        doubts(&self.extents, &mut self.report)?;
        let Pile { mut positions, mut triangles, mut objects, mut names, mut report, focus, .. } = self;
        let mut late = Vec::new();
        if let Some((ground, material)) = ground {
            late.extend(ground.add(&mut positions, &mut triangles, material));
            objects.resize(triangles.len(), names.id(crate::endless_ground::NAME));
        }
        let sorted = rank_by_name(&palette.names(), &mut triangles);
        let soup = if keep { triangles.clone() } else { Vec::new() };
        let Canonical { mesh, used, dropped } = canonical(&positions, triangles, focus)?;
        if mesh.triangles.is_empty() {
            let file = site.parts.first().map_or(Path::new(""), |part| &part.file);
            let what = format!("none of the {} faces has an area", report.faces_read);
            return Err(Error::input(file, None, what, "check the export's unit: the scene is read in metres"));
        }
        report.triangles = mesh.triangles.len();
        report.degenerate_dropped += dropped.degenerate;
        report.duplicates_dropped = dropped.duplicates;
        report.materials = count_uses(&mesh, &used, |rank| sorted.get(rank).cloned());
        report.warnings.extend(contested_warning(dropped.contested));
        report.warnings.extend(late);
        let materials = palette.select(&mut report)?;
        let number = |rank: u32| used.binary_search(&rank).map_or(u16::MAX, |i| i as u16);
        let soup = Soup {
            positions,
            materials: soup.iter().map(|triangle| number(triangle.material)).collect(),
            triangles: soup.iter().map(|triangle| triangle.corners).collect(),
            objects,
            object_names: names.into_vec(),
        };
        Ok((Scene { mesh, materials, place, report }, soup))
    }
}
