//! Covers a scene's surfaces with receivers. In: a scene with its objects, a request. Out:
//! receivers by surface, buried ones included, and a table of the receivers.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;
use std::path::Path;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use heliotile_builder::trace::Tracer;
use heliotile_builder::trace::canopy::Canopies;
use heliotile_builder::trace::placement::{Placement, placement_of};
use heliotile_builder::trace::viewpoint::Viewpoint;
use heliotile_core::error::{Error, Problem, Result, check_ranges};
use heliotile_core::observer::{Observer, Stage};
use heliotile_core::site::material::Material;
use heliotile_core::site::model_part::ModelPart;
use heliotile_core::site::patch::Patch;
use heliotile_core::site::scene_object::ObjectNote;
use heliotile_core::site::semantics::{SourceFace, SurfaceKind};
use heliotile_core::text::{Message, counted, message, with_list};
use heliotile_core::units::parse_metres;
use heliotile_requests::{DefaultRequest, Request};
use heliotile_results::outputs::receivers::{ReceiverRow, ReceiverTable};
use heliotile_scene::Scene;
use heliotile_scene::covering::cover::{LENGTHS_M, MAX_POINTS, Piece, cover};
use heliotile_scene::covering::surfaces::{Surface, Surfaces};
use heliotile_scene::load::ObjectTriangles;
use heliotile_scene::mesh::bounds;
use heliotile_scene::objects::twins;
use heliotile_scene::region_part::RegionPart;
use heliotile_scene::site::SceneFiles;

pub use heliotile_scene::covering::cover::Density;

/// Surfaces that get receivers, and the density of the receivers.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, Request, DefaultRequest)]
#[serde(default, deny_unknown_fields)]
pub struct CoverRequest {
    /// Surfaces to cover: roof, wall, window, ground, floor (surfaces that face down), shade, all,
    /// or names of materials; several with commas [default: roofs, walls and windows; of a building
    /// energy model also outdoor floors, and only surfaces that the sun can reach].
    #[field(delimiter = ',')]
    pub on: Vec<String>,
    /// Types of city objects to cover, such as Bridge,GenericCityObject, or all [default:
    /// buildings; all types for --on ground and names of materials].
    #[field(delimiter = ',', metavar = "TYPES")]
    pub types: Vec<String>,
    /// Density of the receivers.
    #[field(flatten, default = Density::Spacing(2.0))]
    pub density: Density,
    /// Distance of receivers from their surfaces.
    #[field(metavar = "LENGTH", default = "20mm", parse = parse_metres, range = LENGTHS_M, says = "give a length from 1mm to 10km, such as 2m, 50cm or 20mm")]
    pub offset_m: f64,
    /// Least area of a surface that gets receivers, m2.
    #[field(metavar = "AREA", default = 0.1, range = AREAS_M2, says = "give an area from 0 to 1e9, in square metres")]
    pub min_area_m2: f64,
    /// Part of a region to which receivers are limited. It may hold none.
    #[serde(skip)]
    #[field(skip)]
    pub within: Option<RegionPart>,
    /// True if a scene without any such surface is no error.
    #[serde(skip)]
    #[field(skip)]
    pub may_be_none: bool,
}

/// Allowed areas below which a surface gets no receiver, m2.
const AREAS_M2: RangeInclusive<f64> = 0.0..=1e9;

/// Surfaces of a scene and the receivers on them.
pub struct PlacedReceivers {
    /// All surfaces of the scene.
    pub surfaces: Surfaces,
    /// Faces of the input files.
    pub faces: Vec<SourceFace>,
    /// Receivers by surface, for the requested surfaces only.
    pub chosen: Vec<ChosenSurface>,
    /// Number of surfaces too small for a receiver, and their area in m2.
    pub small: (usize, f64),
    /// Number of surfaces that face rooms, the ground or the border of a raster according to their
    /// file, and their area in m2.
    pub inner: (usize, f64),
    /// Number of free receivers in closed hulls of canopies.
    pub in_hulls: u64,
    /// Area in m2 of surfaces of objects that are no buildings, by type of object.
    pub beside: BTreeMap<String, f64>,
}

/// Requested surface with its receivers.
pub struct ChosenSurface {
    /// Index into `Surfaces::list`.
    pub surface: usize,
    /// Piece of the surface that each receiver stands for.
    pub pieces: Vec<Piece>,
    /// `[piece]`: placement of the piece's receiver: free or buried.
    pub placements: Vec<Placement>,
}

/// Name of a receiver, the piece it stands for, the surface it is on, and its placement.
pub type PlacedRow<'a> = (String, &'a Piece, &'a Surface, Placement);

impl PlacedReceivers {
    /// Returns the receivers that get light.
    pub fn free(&self) -> impl Iterator<Item = PlacedRow<'_>> {
        self.all().filter(|row| row.3 == Placement::Free)
    }

    /// Returns all receivers, buried ones included.
    pub fn all(&self) -> impl Iterator<Item = PlacedRow<'_>> {
        self.chosen.iter().flat_map(|chosen| {
            let surface = &self.surfaces.list[chosen.surface];
            let pieces = chosen.pieces.iter().zip(&chosen.placements);
            pieces.map(move |(piece, placement)| {
                (format!("{}#{}", surface.name, piece.number), piece, surface, *placement)
            })
        })
    }

    /// Returns the part of the input model that `piece` stands for.
    pub fn part(&self, piece: &Piece, surface: &Surface) -> ModelPart {
        self.surfaces.part(surface, piece.face, &self.faces)
    }

    /// Returns the number of receivers with the placement `wanted`.
    pub fn count(&self, wanted: Placement) -> usize {
        self.chosen.iter().flat_map(|chosen| &chosen.placements).filter(|placement| **placement == wanted).count()
    }
}

/// Reads a site and covers its surfaces. Receivers are limited to the part of a region that the
/// site states. The observer gets warnings about the scene.
pub fn cover_site(
    site: &SceneFiles,
    request: &CoverRequest,
    observer: &dyn Observer,
) -> Result<(Scene, PlacedReceivers)> {
    let (scene, soup) = Scene::load_with_objects(site)?;
    // Warnings come first: covering may fail.
    scene.report.tell(observer);
    let asked = CoverRequest { within: site.within, ..request.clone() };
    let covered = cover_scene(&scene, soup, &asked, observer)?;
    Ok((scene, covered))
}

/// Covers the requested surfaces. Errors: names that match nothing, too many receivers, no receiver
/// that gets light.
pub fn cover_scene(
    scene: &Scene,
    soup: ObjectTriangles,
    asked: &CoverRequest,
    observer: &dyn Observer,
) -> Result<PlacedReceivers> {
    check_ranges(asked)?;
    let surfaces = Surfaces::find(&soup, &scene.materials);
    doubts(&soup, &surfaces).iter().for_each(|doubt| observer.warn(doubt));
    // The rest of the soup is dropped to free its memory.
    let ObjectTriangles { source_faces: faces, .. } = soup;
    let wanted = SurfaceSelection::new(asked, &scene.materials, &surfaces)?;
    let density = asked.density;
    let (mut chosen, mut small, mut beside) = (Vec::new(), (0, 0.0), BTreeMap::new());
    let within = asked.within.as_ref();
    let reaches = |surface: &Surface| {
        let (low, high) = bounds(surface.triangles.iter().flatten().copied());
        within.is_none_or(|part| part.touches(low, high))
    };
    let mut inner = (0, 0.0);
    for surface in surfaces.list.iter().filter(|surface| wanted.leaves_to_rooms(surface) && reaches(surface)) {
        inner = (inner.0 + 1, inner.1 + surface.area_m2);
    }
    let list = surfaces.list.iter().enumerate();
    for (i, surface) in list.filter(|(_, surface)| wanted.asks(surface) && reaches(surface)) {
        let note = &surfaces.objects[surface.object].1;
        if !wanted.takes_object(surface, note) {
            *beside.entry(note.object_type.clone()).or_default() += surface.area_m2;
        } else if surface.area_m2 < asked.min_area_m2 {
            small = (small.0 + 1, small.1 + surface.area_m2);
        } else {
            chosen.push(i);
        }
    }
    let points: f64 = chosen.iter().map(|&i| density.points(&surfaces.list[i])).sum();
    if points > MAX_POINTS {
        let area_m2 = chosen.iter().map(|&i| surfaces.list[i].area_m2).sum();
        return Err(too_many(density, points, area_m2, |density| {
            chosen.iter().map(|&i| density.points(&surfaces.list[i])).sum()
        }));
    }
    let (tracer, canopies) = Canopies::split(scene);
    let progress = Stage::begin(observer, "surfaces", Some(chosen.len() as u64));
    let chosen: Vec<ChosenSurface> = chosen
        .into_par_iter()
        .map(|surface| {
            let mut pieces = cover(&surfaces.list[surface], density);
            pieces.retain(|piece| within.is_none_or(|part| part.owns(piece.position)));
            let placements = pieces.par_iter().map(|piece| lie(piece, asked.offset_m, scene, &tracer)).collect();
            progress.advance(1);
            ChosenSurface { surface, pieces, placements }
        })
        .collect();
    drop(progress);
    let in_hulls = canopies.map_or(0, |canopies| {
        let holds = |piece: &Piece| canopies.holds(piece.position + piece.normal * asked.offset_m);
        let free = |of: &ChosenSurface| {
            let pairs = of.pieces.par_iter().zip(&of.placements);
            pairs.filter(|(piece, placement)| **placement == Placement::Free && holds(piece)).count() as u64
        };
        chosen.iter().map(free).sum()
    });
    let covered = PlacedReceivers { surfaces, faces, chosen, small, inner, in_hulls, beside };
    if within.is_none() && !asked.may_be_none && covered.count(Placement::Free) == 0 {
        let what = Message::from("no receiver is left: ").and(summary(&covered).trim_end());
        let hint = match (covered.chosen.is_empty(), covered.count(Placement::Inside)) {
            (true, _) => {
                "lower {min_area}, cover other surfaces with {on}, or see with `{command:info}` whether the scene is in metres"
            }
            (_, 0) => "cover other surfaces with {on}: all of the chosen ones touch another surface, or the ground",
            _ => {
                "see where the parts of the scene lie (`{command:info}` of each): one may be below the terrain, or in another unit"
            }
        };
        return Err(Error::argument("on", what, hint).because(Problem::Empty));
    }
    Ok(covered)
}

/// Returns doubts about the surfaces of a scene, a sentence each.
pub fn doubts(soup: &ObjectTriangles, surfaces: &Surfaces) -> Vec<Message> {
    let mut found = Vec::new();
    if surfaces.contrary_edges > 0 {
        found.push(message!(
            "neighbouring faces of one object have opposite orientations at {}: receivers may be on the wrong side",
            counted(surfaces.contrary_edges as u64, "edge")
        ));
    }
    let pairs = twins(soup);
    if let [first, others @ ..] = pairs.as_slice() {
        let (a, b) = first;
        let sentence = message!(
            "{} of objects fill the same box, such as `{a}` and `{b}`: if it is one building twice, leave one out",
            counted(pairs.len() as u64, "pair")
        );
        found.push(match others {
            [] => sentence,
            _ => with_list(sentence, pairs.iter().map(|(a, b)| format!("`{a}` and `{b}`"))),
        });
    }
    found
}

/// Returns the error for too many receivers, with a density that is low enough.
fn too_many(density: Density, points: f64, area_m2: f64, of: impl Fn(Density) -> f64) -> Error {
    let area = if area_m2 < 1e6 { format!("{area_m2:.0} m2") } else { format!("{:.1} km2", area_m2 / 1e6) };
    let limit = format!("on {area} of surfaces, and the limit is {:.0} million", MAX_POINTS / 1e6);
    let unit = Message::from(
        "; if the area looks too large, state the unit of the scene, as in {scale} 0.001 for millimetres",
    );
    let too_many = Problem::OutOfRange { found: points, least: 0.0, most: MAX_POINTS };
    let spacing_m = match density {
        Density::Spacing(metres) => metres,
        Density::PerSurface(count) => {
            // Each surface gets at least one receiver.
            let fewer = (f64::from(count) * MAX_POINTS / points).floor().max(1.0);
            let what = format!("{count} for each surface are {:.0} million receivers {limit}", points / 1e6);
            let hint = message!("{{per_surface}} {fewer:.0}, or fewer surfaces with {{on}}").and(unit);
            return Error::argument("per_surface", what, hint).because(too_many);
        }
    };
    let wider = wide_enough(spacing_m, points, |metres| of(Density::Spacing(metres)));
    let hint = match wider {
        Some((metres, count)) => {
            message!("{{spacing}} {metres}m would give {}, or cover less with {{on}}", millions(count)).and(unit)
        }
        None => Message::from("cover fewer surfaces with {on}").and(unit),
    };
    let what = format!("{spacing_m} m would give {} receivers {limit}", millions(points));
    Error::argument("spacing", what, hint).because(too_many)
}

fn millions(count: f64) -> String {
    if count < 1e6 { format!("{count:.0}") } else { format!("{:.0} million", count / 1e6) }
}

/// Returns the least spacing of two digits that is wide enough, in metres, and the number of
/// receivers it gives.
fn wide_enough(metres: f64, points: f64, of: impl Fn(f64) -> f64) -> Option<(f64, f64)> {
    // Large areas take most of the receivers, so the number falls with the square of the spacing.
    let about = metres * (points / MAX_POINTS).sqrt();
    let step = 10_f64.powf(about.log10().floor() - 1.0);
    let first = (about / step).floor();
    (0..1000).find_map(|i| {
        // Rounding keeps decimal digits such as 0.35 as they are written.
        let wider = ((first + f64::from(i)) * step * 1e6).round() / 1e6;
        let count = of(wider);
        (count <= MAX_POINTS).then_some((wider, count))
    })
}

fn lie(piece: &Piece, offset_m: f64, scene: &Scene, tracer: &Tracer) -> Placement {
    let position = piece.position + piece.normal * offset_m;
    placement_of(&Viewpoint { position, normal: piece.normal }, offset_m, &scene.mesh, tracer)
}

/// Requested surfaces, with names resolved.
struct SurfaceSelection {
    /// Kinds of surfaces; if nothing is named, the roofs, walls and windows that the sun may reach.
    kinds: Vec<SurfaceKind>,
    /// Indices of materials.
    materials: Vec<u16>,
    /// True if `all` was requested, which includes surfaces in the ground.
    all: bool,
    /// True if a requested name matches nothing in this part of the region.
    missing: bool,
    /// Types of objects, in lower case; empty: buildings.
    types: Vec<String>,
}

impl SurfaceSelection {
    fn new(asked: &CoverRequest, materials: &[Material], surfaces: &Surfaces) -> Result<SurfaceSelection> {
        // A part of a region, and what is added to a scene, may lack some requested names.
        let is_part = asked.within.is_some() || asked.may_be_none;
        let types = asked.types.iter().map(|name| name.trim().to_lowercase()).collect();
        let mut wanted =
            SurfaceSelection { kinds: Vec::new(), materials: Vec::new(), all: false, missing: false, types };
        for name in asked.on.iter().map(|name| name.trim()) {
            let kind = SurfaceKind::ALL.into_iter().find(|kind| kind.name() == name.to_lowercase());
            let material = materials.iter().position(|material| material.name == name);
            match (name, kind, material) {
                ("all", ..) => {
                    wanted.kinds.extend(SurfaceKind::ALL);
                    wanted.all = true;
                }
                (_, Some(kind), _) => wanted.kinds.push(kind),
                (_, None, Some(material)) => wanted.materials.push(material as u16),
                (_, None, None) if is_part => wanted.missing = true,
                (_, None, None) => {
                    let what = format!("`{name}` is neither a kind of surface nor a material of the scene");
                    let known = materials.iter().map(|material| material.name.as_str());
                    let known = known.chain(SurfaceKind::ALL.map(SurfaceKind::name));
                    let unknown = Problem::unknown(name, known);
                    return Err(Error::argument("on", what, choice(materials, surfaces)).because(unknown));
                }
            }
        }
        if is_part {
            return Ok(wanted);
        }
        let mut of_type = surfaces.list.iter().map(|surface| (surface, &surfaces.objects[surface.object].1));
        let unknown = |name: &&String| {
            let has = |note: &ObjectNote| note.object_type.to_lowercase() == **name;
            name.as_str() != "all" && !surfaces.objects.iter().any(|(_, note)| has(note))
        };
        if let Some(at) = wanted.types.iter().position(|name| unknown(&name)) {
            let what =
                format!("the scene has no object of type `{}`", asked.types.get(at).map_or("", |name| name.trim()));
            return Err(Error::argument("types", what, choice(materials, surfaces)));
        }
        if !of_type.any(|(surface, note)| wanted.asks(surface) && wanted.takes_object(surface, note)) {
            let what = match asked.on.as_slice() {
                [] => "the scene has no roof, wall or window of a building".to_owned(),
                names => format!("the scene has no surface of {}", names.join(", ")),
            };
            return Err(Error::argument("on", what, choice(materials, surfaces)).because(Problem::Empty));
        }
        Ok(wanted)
    }

    /// Returns true if the surface is requested, whatever object it belongs to.
    fn asks(&self, surface: &Surface) -> bool {
        let named = self.materials.contains(&surface.material);
        let reached = self.all || surface.exposed != Some(false);
        let of_kind = match surface.kind {
            kind if !self.kinds.is_empty() || !self.materials.is_empty() || self.missing => self.kinds.contains(&kind),
            SurfaceKind::Roof | SurfaceKind::Wall | SurfaceKind::Window => true,
            // This takes the floor of a storey that juts out. The floor of a city model lies on the
            // ground.
            SurfaceKind::Floor => surface.exposed == Some(true),
            SurfaceKind::Ground | SurfaceKind::Shade => false,
        };
        named || (of_kind && reached)
    }

    /// Returns true if the surface would be requested had its file not said that no sun reaches it.
    fn leaves_to_rooms(&self, surface: &Surface) -> bool {
        let of_kind = match surface.kind {
            kind if !self.kinds.is_empty() => self.kinds.contains(&kind),
            kind => matches!(kind, SurfaceKind::Roof | SurfaceKind::Wall | SurfaceKind::Window),
        };
        surface.exposed == Some(false) && of_kind && !self.asks(surface)
    }

    /// Returns true if the surface's object is requested.
    fn takes_object(&self, surface: &Surface, note: &ObjectNote) -> bool {
        let by_name = self.materials.contains(&surface.material) || surface.kind == SurfaceKind::Ground;
        match self.types.as_slice() {
            [] => self.all || by_name || !note.beside,
            types => types.iter().any(|name| name == "all" || *name == note.object_type.to_lowercase()),
        }
    }
}

/// Returns the hint that lists the kinds, types and materials of the scene.
fn choice(materials: &[Material], surfaces: &Surfaces) -> Message {
    let mut count: BTreeMap<SurfaceKind, usize> = BTreeMap::new();
    surfaces.list.iter().for_each(|surface| *count.entry(surface.kind).or_default() += 1);
    let kinds: Vec<String> = count.iter().map(|(kind, count)| format!("{} ({count})", kind.name())).collect();
    let types: BTreeSet<&str> = surfaces.objects.iter().map(|(_, note)| note.object_type.as_str()).collect();
    let types: Vec<&str> = types.into_iter().filter(|name| !name.is_empty()).take(20).collect();
    let names: Vec<&str> = materials.iter().take(20).map(|material| material.name.as_str()).collect();
    let types = match types.is_empty() {
        true => Message::default(),
        false => message!("types of objects ({{types}}) {}; ", types.join(", ")),
    };
    message!("the scene has: surfaces of {}; ", kinds.join(", "))
        .and(types)
        .and(format!("materials {}", names.join(", ")))
}

/// Refuses a name that does not end with `.csv`, so that a table replaces no other kind of file.
pub fn check_name(path: &Path) -> Result<()> {
    let is_csv = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"));
    if is_csv || path.exists() && !path.is_file() {
        return Ok(());
    }
    let what = "does not end with .csv, and this table is CSV";
    Err(Error::input(path, None, what, format!("name it {}", path.with_extension("csv").display()))
        .because(Problem::Ending))
}

/// Writes the table of the receivers that get light.
pub fn save(path: &Path, covered: &PlacedReceivers, offset_m: f64) -> Result<()> {
    write(path, covered, covered.free(), offset_m, false)
}

/// Writes a table of receivers; `with_reason` adds a column that says which ones are buried.
pub fn write<'a>(
    path: &Path,
    covered: &PlacedReceivers,
    rows: impl Iterator<Item = PlacedRow<'a>>,
    offset_m: f64,
    with_reason: bool,
) -> Result<()> {
    let mut table = ReceiverTable::create(path, with_reason)?;
    for (name, piece, surface, placement) in rows {
        let position = piece.position + piece.normal * offset_m;
        table.write(&ReceiverRow {
            name: &name,
            position,
            normal: piece.normal,
            area_m2: Some(piece.area_m2),
            surface: &surface.name,
            part: covered.part(piece, surface),
            patch: Patch::of_triangles(position, piece.normal, &piece.triangles),
            reason: Some(reason(placement)),
        })?;
    }
    table.finish()
}

fn reason(placement: Placement) -> &'static str {
    match placement {
        Placement::Free => "free",
        Placement::Blocked => "covered",
        Placement::Inside => "inside",
    }
}

/// Returns a summary of the receivers by kind of surface, for the terminal.
pub fn summary(covered: &PlacedReceivers) -> Message {
    let [free, hidden, inside] =
        [Placement::Free, Placement::Blocked, Placement::Inside].map(|placement| covered.count(placement));
    let mut out = message!(
        "{} on {} of {}\n",
        counted(free as u64, "receiver"),
        counted(covered.chosen.len() as u64, "surface"),
        counted(covered.surfaces.objects.len() as u64, "object")
    );
    let mut line = |text: Message| out = std::mem::take(&mut out).and("  ").and(text).and("\n");
    for kind in SurfaceKind::ALL {
        let of_kind = || covered.chosen.iter().filter(|c| covered.surfaces.list[c.surface].kind == kind);
        // Adding 0.0 turns the -0.0 of an empty sum into 0.
        let area: f64 = of_kind().map(|c| covered.surfaces.list[c.surface].area_m2).sum::<f64>() + 0.0;
        let pieces = || {
            of_kind()
                .flat_map(|c| c.pieces.iter().zip(&c.placements))
                .filter(|(_, placement)| **placement == Placement::Free)
        };
        let covered_area: f64 = pieces().map(|(piece, _)| piece.area_m2).sum::<f64>() + 0.0;
        if of_kind().next().is_some() {
            line(message!(
                "{:7} {:>8} surfaces {:>9} receivers, {covered_area:.1} of {area:.1} m2 get light",
                kind.name(),
                of_kind().count(),
                pieces().count()
            ));
        }
    }
    if hidden + inside > 0 {
        line(message!(
            "left out: {inside} inside a neighbour or below the terrain, {hidden} covered by another surface"
        ));
    }
    if covered.inner.0 > 0 {
        line(message!(
            "left out: {} that face rooms, the ground or the border of a raster, {:.1} m2",
            counted(covered.inner.0 as u64, "surface"),
            covered.inner.1
        ));
    }
    if covered.small.0 > 0 {
        line(message!(
            "left out: {} of less than {{min_area}}, {:.1} m2",
            counted(covered.small.0 as u64, "surface"),
            covered.small.1
        ));
    }
    if !covered.beside.is_empty() {
        let types: Vec<&str> = covered.beside.keys().map(String::as_str).collect();
        let area: f64 = covered.beside.values().sum();
        line(message!("left out: {area:.1} m2 of objects that are not buildings ({{types}} {})", types.join(",")));
    }
    out
}
