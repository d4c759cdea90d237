//! `heliotile receivers`: the surfaces of a scene covered with receivers. In: a scene. Out: `receivers.csv`, without those that are
//! buried in a neighbour or the terrain, which are counted.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use rayon::prelude::*;

use super::terminal::Terminal;
use super::voice::remark_aside;
use super::{Outcome, guard_site, remark, warn};
use crate::cli::{CoverArgs, ReceiversArgs};
use crate::outputs::receivers::{ReceiverRow, ReceiverTable};
use crate::outputs::sink::Sink;
use heliotile_builder::observer::Stage;
use heliotile_builder::trace::Tracer;
use heliotile_builder::trace::canopy::Canopies;
use heliotile_builder::trace::placement::{Lying, lying};
use heliotile_builder::trace::receiver::Viewpoint;
use heliotile_core::error::{Error, Result};
use heliotile_core::site::material::Material;
use heliotile_core::text::counted;
use heliotile_scene::Scene;
use heliotile_scene::covering::cover::{Density, MOST_POINTS, Piece, cover};
use heliotile_scene::covering::surfaces::{Surface, SurfaceKind, Surfaces};
use heliotile_scene::load::Soup;
use heliotile_scene::site::Site;

/// Surfaces and the receivers on them.
pub(super) struct Covered {
    pub surfaces: Surfaces,
    /// By surface, only those that were asked for.
    pub chosen: Vec<ChosenSurface>,
    /// Surfaces too small for a receiver, and their area in m2.
    pub small: (usize, f64),
}

/// A surface that was asked for.
pub(super) struct ChosenSurface {
    /// Index into `Surfaces::list`.
    pub surface: usize,
    pub pieces: Vec<Piece>,
    /// `[piece]`
    pub lying: Vec<Lying>,
}

/// Name of a receiver, what it stands for, the surface it is on, and how it lies there.
type Row<'a> = (String, &'a Piece, &'a Surface, Lying);

impl Covered {
    /// Receivers that get light.
    pub fn free(&self) -> impl Iterator<Item = Row<'_>> {
        self.all().filter(|row| row.3 == Lying::Free)
    }

    fn all(&self) -> impl Iterator<Item = Row<'_>> {
        self.chosen.iter().flat_map(|chosen| {
            let surface = &self.surfaces.list[chosen.surface];
            let numbered = chosen.pieces.iter().zip(&chosen.lying).enumerate();
            numbered.map(move |(i, (piece, lying))| (format!("{}#{}", surface.name, i + 1), piece, surface, *lying))
        })
    }

    /// How many receivers lie so.
    pub fn count(&self, wanted: Lying) -> usize {
        self.chosen.iter().flat_map(|chosen| &chosen.lying).filter(|lying| **lying == wanted).count()
    }
}

/// `heliotile receivers`.
pub fn run(args: &ReceiversArgs) -> Result<Outcome> {
    let site = args.scene.site()?;
    let to_file = args.output != Path::new("-");
    if to_file {
        guard_site(&args.output, &site, &[])?;
    }
    if let Some(buried) = &args.buried {
        guard_site(buried, &site, &[Some(&args.output)])?;
    }
    let (scene, covered) = cover_site(&site, &args.cover)?;
    let (sink, offset_m) = (if to_file { Sink::file(&args.output)? } else { Sink::stdout() }, args.cover.offset.0);
    write(sink, covered.free(), offset_m, false)?;
    if let Some(path) = &args.buried {
        write(Sink::file(path)?, covered.all().filter(|row| row.3 != Lying::Free), offset_m, true)?;
    }
    let text = summary(&covered, &scene);
    // Standard output may be the table.
    if to_file {
        remark(&format!("{}: {text}", args.output.display()))?
    } else {
        remark_aside(&text)
    }
    Ok(Outcome::Fine)
}

/// Reads a scene and covers it.
pub(super) fn cover_site(site: &Site, args: &CoverArgs) -> Result<(Scene, Covered)> {
    let (scene, soup) = Scene::load_with_objects(site)?;
    scene.report.warnings.iter().for_each(|w| warn(w));
    // Standard output may be the table.
    scene.report.notes.iter().for_each(|note| remark_aside(&format!("{note}\n")));
    let covered = cover_scene(&scene, &soup, args)?;
    Ok((scene, covered))
}

fn cover_scene(scene: &Scene, soup: &Soup, args: &CoverArgs) -> Result<Covered> {
    let surfaces = Surfaces::find(soup, &scene.materials);
    if surfaces.turned_objects > 0 {
        warn(&format!(
            "all faces of {} looked inwards; receivers go on the outside",
            counted(surfaces.turned_objects as u64, "closed object")
        ));
    }
    let wanted = Wanted::of(&args.on, &scene.materials, &surfaces)?;
    let density = match args.per_surface {
        Some(count) => Density::PerSurface(count),
        None => Density::Spacing(args.spacing.0),
    };
    let (mut chosen, mut small) = (Vec::new(), (0, 0.0));
    for (i, surface) in surfaces.list.iter().enumerate().filter(|(_, surface)| wanted.contains(surface)) {
        if surface.area_m2 < args.min_area {
            small = (small.0 + 1, small.1 + surface.area_m2);
        } else {
            chosen.push(i);
        }
    }
    let points: f64 = chosen.iter().map(|&i| density.points(&surfaces.list[i])).sum();
    if points > MOST_POINTS {
        return Err(too_many(args, points, |density| chosen.iter().map(|&i| density.points(&surfaces.list[i])).sum()));
    }
    let (tracer, _) = Canopies::split(scene);
    let terminal = Terminal::default();
    let progress = Stage::begin(&terminal, "surfaces", Some(chosen.len() as u64));
    let chosen: Vec<ChosenSurface> = chosen
        .into_par_iter()
        .map(|surface| {
            let pieces = cover(&surfaces.list[surface], density);
            let lying = pieces.par_iter().map(|piece| lie(piece, args.offset.0, scene, &tracer)).collect();
            progress.advance(1);
            ChosenSurface { surface, pieces, lying }
        })
        .collect();
    drop(progress);
    let covered = Covered { surfaces, chosen, small };
    if covered.count(Lying::Free) == 0 {
        let what = format!("no receiver: {}", summary(&covered, scene));
        let hint = match (covered.chosen.is_empty(), covered.count(Lying::Inside)) {
            (true, _) => {
                "lower --min-area, cover other surfaces with --on, or see with `heliotile info` whether the scene is in metres"
            }
            (_, 0) => "cover other surfaces with --on: these all touch one another, or the ground",
            _ => {
                "see where the parts of the scene lie (`heliotile info` of each): one may be below the terrain, or in another unit"
            }
        };
        return Err(Error::argument("--on", what.trim_end(), hint));
    }
    Ok(covered)
}

/// The refusal of too many receivers, with what would be few enough.
fn too_many(args: &CoverArgs, points: f64, of: impl Fn(Density) -> f64) -> Error {
    let limit = format!("the limit is {:.0} million", MOST_POINTS / 1e6);
    if let Some(count) = args.per_surface {
        // At least one for each surface.
        let fewer = (f64::from(count) * MOST_POINTS / points).floor().max(1.0);
        let what = format!("{count} for each surface are {:.0} million receivers, {limit}", points / 1e6);
        return Error::argument(
            "--per-surface",
            what,
            format!("--per-surface {fewer:.0}, or fewer surfaces with --on"),
        );
    }
    let wider = wide_enough(args.spacing.0, points, |metres| of(Density::Spacing(metres)));
    let hint = match wider {
        Some((metres, count)) => format!("--spacing {metres}m would give {}, or cover less with --on", millions(count)),
        None => "cover fewer surfaces with --on".into(),
    };
    let what = format!("{} m would give {} receivers, {limit}", args.spacing.0, millions(points));
    Error::argument("--spacing", what, hint)
}

fn millions(count: f64) -> String {
    if count < 1e6 { format!("{count:.0}") } else { format!("{:.0} million", count / 1e6) }
}

/// The least spacing of two digits that is wide enough, metres, and how many receivers it gives.
fn wide_enough(metres: f64, points: f64, of: impl Fn(f64) -> f64) -> Option<(f64, f64)> {
    // Areas take most of them, by the square of the spacing.
    let about = metres * (points / MOST_POINTS).sqrt();
    let step = 10_f64.powf(about.log10().floor() - 1.0);
    let first = (about / step).floor();
    (0..1000).find_map(|i| {
        // Decimal digits, such as 0.35, as they are written.
        let wider = ((first + f64::from(i)) * step * 1e6).round() / 1e6;
        let count = of(wider);
        (count <= MOST_POINTS).then_some((wider, count))
    })
}

fn lie(piece: &Piece, offset_m: f64, scene: &Scene, tracer: &Tracer) -> Lying {
    let position = piece.position + piece.normal * offset_m;
    lying(&Viewpoint { position, normal: piece.normal }, offset_m, &scene.mesh, tracer)
}

/// Surfaces that are asked for.
struct Wanted {
    kinds: Vec<SurfaceKind>,
    /// Numbers of materials.
    materials: Vec<u16>,
}

impl Wanted {
    fn of(names: &[String], materials: &[Material], surfaces: &Surfaces) -> Result<Wanted> {
        let mut wanted = Wanted { kinds: Vec::new(), materials: Vec::new() };
        for name in names.iter().map(|name| name.trim()) {
            let kind = SurfaceKind::ALL.into_iter().find(|kind| kind.name() == name.to_lowercase());
            let material = materials.iter().position(|material| material.name == name);
            match (name, kind, material) {
                ("all", ..) => wanted.kinds.extend(SurfaceKind::ALL),
                // A material that is called like a kind is most likely of it.
                (_, Some(kind), _) => wanted.kinds.push(kind),
                (_, None, Some(material)) => wanted.materials.push(material as u16),
                (_, None, None) => {
                    let what = format!("there is no kind of surface and no material `{name}`");
                    return Err(Error::argument("--on", what, wanted.choice(materials, surfaces)));
                }
            }
        }
        if !surfaces.list.iter().any(|surface| wanted.contains(surface)) {
            let what = format!("the scene has no surface of {}", names.join(", "));
            return Err(Error::argument("--on", what, wanted.choice(materials, surfaces)));
        }
        Ok(wanted)
    }

    fn contains(&self, surface: &Surface) -> bool {
        self.kinds.contains(&surface.kind) || self.materials.contains(&surface.material)
    }

    /// What could be asked for.
    fn choice(&self, materials: &[Material], surfaces: &Surfaces) -> String {
        let mut count: BTreeMap<SurfaceKind, usize> = BTreeMap::new();
        surfaces.list.iter().for_each(|surface| *count.entry(surface.kind).or_default() += 1);
        let kinds: Vec<String> = count.iter().map(|(kind, count)| format!("{} ({count})", kind.name())).collect();
        let names: Vec<&str> = materials.iter().take(20).map(|material| material.name.as_str()).collect();
        format!("there are surfaces of {}; materials are {}", kinds.join(", "), names.join(", "))
    }
}

/// Writes a table of receivers, with a reason where they are buried.
pub(super) fn write<'a>(
    sink: Sink,
    rows: impl Iterator<Item = Row<'a>>,
    offset_m: f64,
    with_reason: bool,
) -> Result<()> {
    let mut table = ReceiverTable::create(sink, with_reason)?;
    for (name, piece, surface, lying) in rows {
        table.write(&ReceiverRow {
            name: &name,
            position: piece.position + piece.normal * offset_m,
            normal: piece.normal,
            area_m2: piece.area_m2,
            surface: &surface.name,
            reason: Some(reason(lying)),
        })?;
    }
    table.finish()
}

fn reason(lying: Lying) -> &'static str {
    match lying {
        Lying::Free => "free",
        Lying::Covered => "covered",
        Lying::Inside => "inside",
    }
}

/// What was done, by kind of surface.
pub(super) fn summary(covered: &Covered, scene: &Scene) -> String {
    let [free, hidden, inside] = [Lying::Free, Lying::Covered, Lying::Inside].map(|lying| covered.count(lying));
    let mut out = format!(
        "{} on {} of {}\n",
        counted(free as u64, "receiver"),
        counted(covered.chosen.len() as u64, "surface"),
        counted(covered.surfaces.objects as u64, "object")
    );
    // Writing to a string cannot fail.
    let mut line = |text: String| {
        let _ = writeln!(out, "  {text}");
    };
    for kind in SurfaceKind::ALL {
        let of_kind = || covered.chosen.iter().filter(|c| covered.surfaces.list[c.surface].kind == kind);
        // An empty sum is -0.0.
        let area: f64 = of_kind().map(|c| covered.surfaces.list[c.surface].area_m2).sum::<f64>() + 0.0;
        let pieces =
            || of_kind().flat_map(|c| c.pieces.iter().zip(&c.lying)).filter(|(_, lying)| **lying == Lying::Free);
        let covered_area: f64 = pieces().map(|(piece, _)| piece.area_m2).sum::<f64>() + 0.0;
        if of_kind().next().is_some() {
            line(format!(
                "{:7} {:>8} surfaces {:>9} receivers, {covered_area:.1} of {area:.1} m2 get light",
                kind.name(),
                of_kind().count(),
                pieces().count()
            ));
        }
    }
    if hidden + inside > 0 {
        line(format!(
            "left out: {inside} inside a neighbour or below the terrain, {hidden} covered by another surface"
        ));
    }
    if covered.small.0 > 0 {
        line(format!(
            "left out: {} of less than --min-area, {:.1} m2",
            counted(covered.small.0 as u64, "surface"),
            covered.small.1
        ));
    }
    if !scene.report.warnings.is_empty() {
        line(format!("{} above", counted(scene.report.warnings.len() as u64, "warning")));
    }
    out
}
