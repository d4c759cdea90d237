//! Loading: several files, one scene. In: the parts of a site. Out: a scene, and its triangles with
//! the objects that they belong to. Rasters come last: they are thinned by what they are the
//! horizon of.

use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::coordinate::is_position;
use crate::footprints::ground_below::GroundBelow;
use crate::formats;
use crate::formats::{Content, ReadOptions};
use crate::geometry::{Geometry, Names};
use crate::ground::endless::EndlessGround;
use crate::ground::found::{DETACHED_M, lies_free, surrounds};
use crate::ground::missing;
use crate::ground::missing::{BELOW_M, heights};
use crate::ground::model::{ModelGround, USUAL};
use crate::mesh::{Canonical, RawTriangle, bounds, canonical};
use crate::mesh_objects::{MeshObjects, ranked};
use crate::outlined::{Outlined, raise_all};
use crate::palette::Palette;
use crate::placing::extent::{Extent, Walls};
use crate::placing::frame::SiteFrame;
use crate::placing::plausible::doubts;
use crate::placing::whereabouts::place_of;
use crate::placing::y_up::y_up_warning;
use crate::polygon;
use crate::polygon::{OFF_PLANE_M, Triangulation, object_name};
use crate::region_part::RegionPart;
use crate::site::{MissingGround, Part, SceneFiles};
use crate::surface_city::read::{Beyond, SurfaceRead, no_raster, read_surface};
use crate::terrain::focus::Focus;
use crate::terrain::mosaic::{Tile, joined};
use crate::terrain::raster::Raster;
use crate::terrain::surface;
use crate::terrain::surface::{RasterOptions, surface};
use crate::{LoadReport, Scene, contested_warning, count_uses, rank_by_name};
use heliotile_core::error::{Error, Result};
use heliotile_core::site::ground::MonthlyGround;
use heliotile_core::site::material::Class;
use heliotile_core::site::scene_object::{ObjectNote, SceneObject};
use heliotile_core::site::semantics::SourceFace;
use heliotile_core::text::{Message, message, with_list};
use heliotile_place::reference::Reference;

/// Most reasons for leaving out faces that get a warning each; more reasons become one list.
const MAX_REASONS: usize = 2;

/// Triangles of a scene in the order of its files, each with the object it is a part of.
#[derive(Debug, Default)]
pub struct ObjectTriangles {
    /// Positions in input coordinates, metres.
    pub positions: Vec<DVec3>,
    /// Corners of each triangle, indices into `positions`.
    pub triangles: Vec<[u32; 3]>,
    /// Material of each triangle, an index into `Scene::materials`; `u16::MAX` for a material that
    /// no triangle of the scene has.
    pub materials: Vec<u16>,
    /// Object of each triangle, an index into `object_names`.
    pub objects: Vec<u32>,
    /// Names of the objects in the files.
    pub object_names: Vec<String>,
    /// Notes on the objects, `[object]`.
    pub object_notes: Vec<ObjectNote>,
    /// Face that each triangle is a part of, an index into `source_faces`; `u32::MAX` for triangles
    /// of no file.
    pub faces: Vec<u32>,
    /// Faces of the files.
    pub source_faces: Vec<SourceFace>,
}

impl ObjectTriangles {
    /// Returns the lowest and the highest corner of all triangles except those of the endless
    /// ground.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let endless = self.object_names.iter().position(|name| name == crate::ground::endless::NAME);
        let named = self.triangles.iter().zip(&self.objects).filter(|(_, object)| Some(**object as usize) != endless);
        bounds(named.flat_map(|(triangle, _)| triangle).filter_map(|i| self.positions.get(*i as usize)).copied())
    }
}

/// A file whose format states a ground without a face for it.
struct Model {
    file: PathBuf,
    /// Its triangles, among those of all files.
    triangles: Range<usize>,
    ground: ModelGround,
}

/// Everything that was read so far.
#[derive(Default)]
struct Pile {
    positions: Vec<DVec3>,
    triangles: Vec<RawTriangle>,
    objects: Vec<u32>,
    names: Names,
    notes: HashMap<u32, ObjectNote>,
    /// True if the soup and its faces are kept.
    keep: bool,
    faces: Vec<u32>,
    source_faces: Vec<SourceFace>,
    /// Extent and stated place of each file.
    extents: Vec<Extent>,
    report: LoadReport,
    /// Files whose format states a ground without a face for it.
    models: Vec<Model>,
    /// Monthly ground reflectances, if they differ by month.
    by_month: Option<MonthlyGround>,
    /// Centre of all geometry except far terrain, if there is such terrain.
    focus: Option<DVec3>,
    aside: Aside,
}

/// Triangles that only receivers outside the part of a region see; surfaces need them to be whole.
#[derive(Default)]
struct Aside {
    triangles: Vec<RawTriangle>,
    objects: Vec<u32>,
    faces: Vec<u32>,
}

impl Scene {
    /// Loads one file, with its own reflectances except those that `materials.toml` states. No
    /// ground is assumed.
    pub fn load(file: &Path, materials: Option<&Path>) -> Result<Scene> {
        Scene::load_site(&SceneFiles { parts: vec![Part::plain(file, materials)], ..SceneFiles::default() })
    }

    /// Loads all files of a site.
    pub fn load_site(site: &SceneFiles) -> Result<Scene> {
        load(site, false).map(|loaded| loaded.0)
    }

    /// Loads all files of a site, with the soup of triangles and the objects that they are parts
    /// of.
    pub fn load_with_objects(site: &SceneFiles) -> Result<(Scene, ObjectTriangles)> {
        load(site, true)
    }
}

/// Loads all files of a site; without `keep` the soup is empty.
fn load(site: &SceneFiles, keep: bool) -> Result<(Scene, ObjectTriangles)> {
    let (mut palette, mut pile) = (Palette::default(), Pile { keep, ..Pile::default() });
    let (mut rasters, mut surfaces, mut outlines, mut local_frame) = (Vec::new(), Vec::new(), Vec::new(), None);
    pile.report.warnings.extend(site.unused_up().into_iter().map(Message::from));
    for part in &site.parts {
        if let Some(path) = &part.materials {
            palette.open(path)?;
        }
        let asked = ReadOptions {
            reflectances: part.materials.is_none() || !part.materials_only,
            described: palette.described(part.materials.as_deref()),
            lod: part.lod.clone(),
            local_frame,
            system: site.frame.epsg.or_else(|| pile.system()).or_else(|| outlines.iter().find_map(Outlined::epsg)),
            assume_version: part.assume_version,
            footprints: part.footprints.clone(),
        };
        match formats::read(&part.file, &asked)? {
            Content::Polygons(_) if part.surface.is_some() => return Err(no_raster(&part.file)),
            Content::Polygons(geometry) => {
                local_frame = local_frame.or(geometry.local_frame);
                let part = part.in_frame(&site.frame);
                match geometry.footprints.is_empty() && geometry.trees.is_empty() {
                    true => pile.add(&part, *geometry, &mut palette, Some(&|p| part.place(p)))?,
                    false => outlines.push(Outlined::new(part, *geometry)),
                }
            }
            Content::Terrain(raster) => match &part.surface {
                Some(options) => surfaces.push((part, raster, options)),
                None => rasters.push((part, raster)),
            },
        }
    }
    // City rasters come after polygons, whose coordinate system they take if they state none.
    let (mut beyond_parts, mut beyond) = (Vec::new(), Vec::new());
    for (part, raster, options) in surfaces {
        let SurfaceRead { city, beyond: more } =
            read_surface(part, raster, options, &site.frame, pile.reference(), site.within.as_ref())?;
        pile.report.notes.push(city.note.into());
        pile.add(part, city.geometry, &mut palette, None)?;
        if let Some(Beyond { part, raster }) = more {
            beyond_parts.push(part);
            beyond.push(raster);
        }
    }
    let (has_terrain, has_city) = (!rasters.is_empty(), !beyond.is_empty());
    let outlined = outlines.iter().find_map(Outlined::epsg).map(Reference::Epsg);
    let mut placed = pile.placed_rasters(rasters, &site.frame, outlined)?;
    placed.extend(beyond_parts.iter().zip(beyond));
    let (terrain, notes) = joined(placed);
    pile.report.notes.extend(notes.into_iter().map(Message::from));
    pile.add_footprints(outlines, &terrain, &mut palette)?;
    if let Some(part) = &site.within {
        pile.cut(part, &palette);
    }
    // Terrain is added after the cut, because all ground counts.
    pile.add_rasters(terrain, has_city, &mut palette)?;
    let mut ground = palette.ground();
    if ground.is_none() && !has_terrain && site.missing_ground == MissingGround::Assume {
        ground = pile.assume_ground(&mut palette);
    }
    pile.finish(site, &palette, ground, keep)
}

impl Pile {
    /// Returns the coordinate system of the first file that states one.
    fn reference(&self) -> Option<Reference> {
        self.extents.iter().find_map(Extent::reference)
    }

    /// Returns the EPSG number of that coordinate system.
    fn system(&self) -> Option<u32> {
        self.reference().and_then(|reference| match reference {
            Reference::Epsg(epsg) => Some(epsg),
            Reference::Place { .. } => None,
        })
    }

    /// Puts aside the triangles that receivers in a part of the region do not see.
    fn cut(&mut self, part: &RegionPart, palette: &Palette) {
        let is_ground = |material| palette.class(material).0 == Class::Ground;
        let seen = part.seen(&self.positions, &self.triangles, &self.objects, is_ground);
        let kept_before = |end: usize| seen.iter().take(end).filter(|seen| **seen).count();
        for model in &mut self.models {
            model.triangles = kept_before(model.triangles.start)..kept_before(model.triangles.end);
        }
        self.aside = Aside {
            triangles: parted(&mut self.triangles, &seen),
            objects: parted(&mut self.objects, &seen),
            faces: parted(&mut self.faces, &seen),
        };
    }

    /// Returns the rasters in scene coordinates; `outlined` is the system of footprints that are
    /// not added yet.
    fn placed_rasters<'p>(
        &self,
        rasters: Vec<(&'p Part, Raster)>,
        frame: &SiteFrame,
        outlined: Option<Reference>,
    ) -> Result<Vec<(&'p Part, Raster)>> {
        let [stated, _] = frame.references();
        let system = stated.or_else(|| self.reference()).or(outlined);
        let place =
            |(part, raster): (&'p Part, Raster)| Ok((part, raster.placed(part, frame, part.reference.or(system))?));
        rasters.into_iter().map(place).collect()
    }

    /// Adds buildings from footprints on the ground that was read: rasters, and triangles of class
    /// ground.
    fn add_footprints(&mut self, mut outlines: Vec<Outlined>, terrain: &[Tile], palette: &mut Palette) -> Result<()> {
        if outlines.is_empty() {
            return Ok(());
        }
        let corner = |corner: u32| self.positions.get(corner as usize).copied().unwrap_or_default();
        let ground =
            self.triangles.iter().filter(|triangle| palette.class(triangle.material) == (Class::Ground, false));
        let ground = ground.map(|triangle| triangle.corners.map(corner)).collect();
        let below = GroundBelow::new(terrain.iter().map(|tile| &tile.raster).collect(), ground);
        let is_house = |material| {
            let (class, is_canopy) = palette.class(material);
            class != Class::Ground && !is_canopy
        };
        let houses = self.triangles.iter().filter(|triangle| is_house(triangle.material));
        let houses = houses.map(|triangle| triangle.corners.map(corner)).collect();
        self.report.notes.extend(raise_all(&mut outlines, &below, houses)?);
        for Outlined { part, geometry } in outlines {
            // Their coordinates are scene coordinates already.
            self.add(&part, geometry, palette, Some(&|p| p))?;
        }
        Ok(())
    }

    /// Adds rasters as meshes, thinned as the horizon of what was added before, if anything was.
    /// `has_city` is true if some of them extend a city.
    fn add_rasters(&mut self, rasters: Vec<Tile>, has_city: bool, palette: &mut Palette) -> Result<()> {
        let used = self.triangles.iter().flat_map(|t| t.corners).filter_map(|i| self.positions.get(i as usize));
        let (low, high) = bounds(used.copied());
        let near = (!rasters.is_empty() && low.is_finite() && high.is_finite()).then_some((low, high));
        self.focus = near.map(|(low, high)| 0.5 * (low + high));
        let only = rasters.len() == 1 && !has_city;
        for Tile { part, raster, .. } in rasters {
            let stem = formats::stem(&part.file);
            let wanted = RasterOptions {
                file: &part.file,
                object: if only { surface::NAME } else { &stem },
                focus: near.map(|(low, high)| Focus::around(low.truncate(), high.truncate())),
                horizon_deg: part.horizon_deg,
            };
            let (geometry, note) = surface(raster, &wanted)?;
            self.report.notes.extend(note.into_iter().map(Message::from));
            // Its raster is in scene coordinates already.
            self.add(part, geometry, palette, None)?;
        }
        Ok(())
    }

    /// Returns the plane of a scene whose files have no ground around it and the number of its
    /// material, and reports it.
    fn assume_ground(&mut self, palette: &mut Palette) -> Option<(EndlessGround, u32)> {
        let Pile { positions, triangles, objects, models, report, names, notes, .. } = self;
        let of_model = |i: &usize| models.iter().any(|model| model.triangles.contains(i));
        let others: Vec<&RawTriangle> =
            triangles.iter().enumerate().filter(|(i, _)| !of_model(i)).map(|(_, triangle)| triangle).collect();
        let corner = |corner: u32| positions.get(corner as usize).copied().unwrap_or_default();
        let known: &Palette = palette;
        let of_class = |class| {
            let bears = move |triangle: &&&RawTriangle| known.class(triangle.material) == (class, false);
            others.iter().filter(bears).map(|triangle| triangle.corners.map(corner))
        };
        let of_material = others.iter().map(|triangle| (triangle.material, triangle.corners.map(corner)));
        let by_shape =
            missing::ground_by_shape(of_material, |number| known.class(number) == (Class::Obstruction, false));
        for (number, area_m2) in by_shape {
            let name = known.names().get(number as usize).cloned().unwrap_or_default();
            report.warnings.push(missing::ground_warning(&name, area_m2));
        }
        let free = lies_free(of_class(Class::Ground), of_class(Class::Obstruction));
        let found = free && surrounds(of_class(Class::Ground), of_class(Class::Obstruction));
        let Some(Model { file, ground, .. }) = models.first() else {
            let [lowest, _] = heights(positions, triangles.iter())?;
            if found {
                return None;
            }
            // Ground far below of what stands is land that was drawn at height 0.
            let stands = |triangle: &&&RawTriangle| known.class(triangle.material).0 == Class::Obstruction;
            let feet = heights(positions, others.iter().filter(stands).copied()).map_or(lowest, |[low, _]| low);
            let low = if lowest < feet - DETACHED_M { feet } else { lowest };
            let plane_m = low - BELOW_M;
            let wholes: Vec<u32> = objects.iter().map(|object| whole_of(*object, names, notes)).collect();
            report.warnings.push(missing::warning(positions, triangles, &wholes, plane_m, free));
            let (material, name) = palette.add_ground(Path::new(""), USUAL);
            report.assumed.push(name);
            return Some((EndlessGround { elevation_m: Some(plane_m) }, material));
        };
        if let Some(other) = models
            .iter()
            .find(|other| (ModelGround { elevation_m: ground.elevation_m, ..other.ground.clone() }) != *ground)
        {
            let (first, second) = (file.display(), other.file.display());
            report.warnings.push(message!(
                "the ground of {first} {}, but that of {second} {}; the first one is used",
                ground.words(),
                other.ground.words()
            ));
        }
        if found {
            report.notes.push(format!("ground: the scene's own, not the plane of {}", file.display()).into());
            return None;
        }
        let lowest = models.iter().map(|model| model.ground.elevation_m);
        let lowest = lowest.chain(heights(positions, others).map(|[low, _]| low)).fold(f64::INFINITY, f64::min);
        let by_month = MonthlyGround {
            material: String::new(),
            reflectance: ground.reflectance,
            snow_modifier: ground.snow_modifier,
        };
        report.notes.push(message!(
            "ground: a plane at {lowest:.2} m that {}, {} ({{no_ground}}: none)",
            ground.words(),
            if ground.stated { format!("as {} states", file.display()) } else { "as EnergyPlus assumes".to_owned() }
        ));
        let (material, name) = palette.add_ground(file, by_month.mean());
        self.by_month = ground.changes().then_some(MonthlyGround { material: name, ..by_month });
        Some((EndlessGround { elevation_m: Some(lowest - BELOW_M) }, material))
    }

    /// Adds polygons at the positions that `place` gives; `None` leaves the surface of a raster
    /// where it is.
    fn add(
        &mut self,
        part: &Part,
        geometry: Geometry,
        palette: &mut Palette,
        place: Option<&dyn Fn(DVec3) -> DVec3>,
    ) -> Result<()> {
        let cut = polygon::triangulate(&geometry)?;
        self.note(part, &geometry, &cut);
        let materials = palette.add(part, &geometry);
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
        let first_triangle = self.triangles.len();
        self.triangles.extend(cut.triangles.iter().map(|triangle| RawTriangle {
            corners: triangle.corners.map(|corner| corner + first as u32),
            material: number(&materials, triangle.material),
            object: 0,
        }));
        self.objects.extend(cut.objects.iter().map(|&object| number(&objects, object)));
        for (&object, note) in &geometry.object_notes {
            self.notes.entry(number(&objects, object)).or_insert_with(|| note.clone());
        }
        if self.keep {
            // A triangle count fits 32 bits, and there are no more faces than triangles.
            let first = self.source_faces.len() as u32;
            self.source_faces.extend(geometry.source_faces());
            self.faces.extend(cut.faces.iter().map(|face| first + face));
        }
        let position = |corner: u32| self.positions.get((u64::from(corner) + first) as usize).copied();
        let corners = || cut.triangles.iter().map(|t| t.corners.map(|corner| position(corner).unwrap_or_default()));
        let mut walls = Walls::default();
        corners().for_each(|triangle| walls.add(triangle));
        let header_up = part.lacks_up().then_some(geometry.header_up);
        self.report.warnings.extend(header_up.and_then(|header| y_up_warning(&part.file, corners(), header)));
        let (low, high) = bounds(corners().flatten());
        if !low.is_finite() {
            // A file without triangles has no extent to check.
            return Ok(());
        }
        self.extents.push(Extent {
            file: part.file.clone(),
            raster: place.is_none(),
            is_raised: geometry.is_raised,
            bounds: [low, high],
            shift: part.shift(),
            scale: part.metres(),
            in_metres: geometry.in_metres,
            own: geometry.reference.filter(|_| !part.is_moved),
            stated: part.reference,
            walls,
        });
        if let Some(ground) = geometry.ground {
            let elevation_m = part.place(DVec3::new(0.0, 0.0, ground.elevation_m)).z;
            let stated = if part.materials_only { ModelGround::usual(elevation_m) } else { ground };
            let triangles = first_triangle..self.triangles.len();
            self.models.push(Model {
                file: part.file.clone(),
                triangles,
                ground: ModelGround { elevation_m, ..stated },
            });
        }
        Ok(())
    }

    /// Adds the findings of a file to the report.
    fn note(&mut self, part: &Part, geometry: &Geometry, cut: &Triangulation) {
        let (report, file) = (&mut self.report, part.file.display());
        report.faces_read += geometry.face_count();
        report.degenerate_dropped += cut.degenerate_faces;
        report.concave_faces += cut.concave_faces;
        report.warnings.extend(geometry.warnings.iter().cloned());
        report.notes.extend(geometry.notes.iter().cloned());
        report.warnings.extend(geometry.doubts.iter().map(|doubt| message!("{file}: ").and(doubt)));
        let mut left_out: Vec<String> =
            geometry.left_out.iter().map(|(reason, count)| format!("{count} left out {reason}")).collect();
        if left_out.len() > MAX_REASONS {
            let count: usize = geometry.left_out.values().sum();
            let sentence = format!("{file}: {count} left out for {} reasons", left_out.len());
            report.warnings.push(with_list(sentence, left_out.drain(..)));
        }
        report.warnings.extend(left_out.iter().map(|reason| message!("{file}: ").and(reason)));
        if let Some((count, place)) = cut.crossing_faces {
            let first = match place.line {
                0 => format!("the outline of a face of {}", object_name(geometry, place.object)),
                line => format!("line {line}: the outline of the face"),
            };
            let between = if place.line == 0 { ": " } else { ", " };
            report.warnings.push(
                format!("{file}{between}{first} crosses itself; the areas of {count} such faces may be wrong").into(),
            );
        }
        if cut.off_plane.0 > 0 {
            let (count, most) = cut.off_plane;
            report.warnings.push(format!(
                "{file}: {count} faces are not flat, with corners up to {most:.2} m off their plane (limit {OFF_PLANE_M} m); they are \
                 folded along their diagonals"
            ).into());
        }
    }

    // The mesh is made of the triangles that count; the soup also holds those that were put aside.
    fn finish(
        mut self,
        site: &SceneFiles,
        palette: &Palette,
        ground: Option<(EndlessGround, u32)>,
        keep: bool,
    ) -> Result<(Scene, ObjectTriangles)> {
        let place = place_of(&self.extents, &site.frame, &mut self.report)?;
        doubts(&self.extents, &mut self.report)?;
        let Pile { mut positions, mut triangles, mut objects, mut names, mut report, focus, by_month, .. } = self;
        let (notes, mut faces, source_faces, aside) = (self.notes, self.faces, self.source_faces, self.aside);
        let mut late = Vec::new();
        if let Some((ground, material)) = ground {
            late.extend(ground.add(&mut positions, &mut triangles, material));
            objects.resize(triangles.len(), names.id(crate::ground::endless::NAME));
        }
        let of_scene = triangles.len();
        let note = |id: u32| notes.get(&id).cloned().unwrap_or_default();
        let object = |(id, name): (u32, &String)| SceneObject { name: name.clone(), note: note(id) };
        let known_objects: Vec<SceneObject> = (0..).zip(names.as_slice()).map(object).collect();
        let (ranks, sorted_objects) = ranked(&known_objects);
        for (triangle, &object) in triangles.iter_mut().zip(&objects) {
            triangle.object = ranks.get(object as usize).copied().unwrap_or_default();
        }
        if keep {
            triangles.extend(aside.triangles);
            objects.extend(aside.objects);
            // Triangles of no file have no face.
            faces.resize(of_scene, u32::MAX);
            faces.extend(aside.faces);
        }
        let sorted = rank_by_name(&palette.names(), &mut triangles);
        let soup = if keep { triangles.clone() } else { Vec::new() };
        triangles.truncate(of_scene);
        let Canonical { mesh, used, objects: ranks, dropped } = canonical(&positions, triangles, focus)?;
        let mesh_objects = MeshObjects::of_sorted(&sorted_objects, ranks);
        if mesh.triangles.is_empty() {
            let file = site.parts.first().map_or(Path::new(""), |part| &part.file);
            let what = format!("none of the {} faces has an area", report.faces_read);
            return Err(Error::input(file, None, what, "check the export's unit: the scene is read in metres"));
        }
        report.triangles = mesh.triangles.len();
        report.degenerate_dropped += dropped.degenerate;
        report.duplicates_dropped = dropped.duplicates;
        report.materials = count_uses(&mesh, &used, &sorted);
        report.warnings.extend(contested_warning(dropped.contested).into_iter().map(Message::from));
        report.warnings.extend(late.into_iter().map(Message::from));
        let ground_assumed = std::mem::take(&mut report.assumed);
        let materials = palette.select(&mut report)?;
        report.assumed.extend(ground_assumed);
        let number = |rank: u32| used.binary_search(&rank).map_or(u16::MAX, |i| i as u16);
        let soup = ObjectTriangles {
            positions,
            materials: soup.iter().map(|triangle| number(triangle.material)).collect(),
            triangles: soup.iter().map(|triangle| triangle.corners).collect(),
            objects,
            object_notes: known_objects.into_iter().map(|object| object.note).collect(),
            object_names: names.into_vec(),
            faces,
            source_faces,
        };
        let grid_north = site.frame.grid_north;
        Ok((Scene { mesh, materials, objects: mesh_objects, place, grid_north, ground: by_month, report }, soup))
    }
}

/// Returns the number of the building that an object is a part of; `object` itself if no building
/// is stated.
fn whole_of(object: u32, names: &mut Names, notes: &HashMap<u32, ObjectNote>) -> u32 {
    let building = notes.get(&object).map(|note| note.building.as_str()).filter(|building| !building.is_empty());
    building.map_or(object, |building| names.id(building))
}

/// Removes the items that are not kept and returns them. Missing items of a shorter list are
/// skipped.
fn parted<T: Copy>(list: &mut Vec<T>, kept: &[bool]) -> Vec<T> {
    let out = list.iter().zip(kept).filter_map(|(item, kept)| (!kept).then_some(*item)).collect();
    let mut flags = kept.iter();
    list.retain(|_| flags.next().copied().unwrap_or(true));
    out
}
