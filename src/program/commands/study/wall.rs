//! Fig. 5 of the paper. In: a wall, rays of several maps of the hemisphere. Out: form factors
//! beside the closed form, as a table and two pictures.

use std::fmt::Write as _;
use std::fs;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::cli::{RaySquare, WallArgs};
use crate::commands::{Outcome, say};
use heliotile::output::{guard_output, write_texts};
use heliotile::plot::{Axis, Plot, Series, Style};
use heliotile::text::counted;
use heliotile::tracing::{HemisphereMapping, MappedRay, Tracer, Viewpoint, Wall};
use heliotile::{Class, Error, Material, Result, Scene};

/// Edges of the wall, and of the receiver over which points are spread, metres.
const WALL_M: f64 = 10.0;
const RECEIVER_M: f64 = 1.0;

/// File names of the results.
const NAMES: [&str; 3] = ["wall.csv", "wall.svg", "wall_error.svg"];

/// Size of the pictures, pixels.
const PICTURE: (u32, u32) = (720, 440);

/// One row of the table.
struct Row {
    mapping: HemisphereMapping,
    rays: RaySquare,
    distance_m: f64,
    form_factor: f64,
    analytic: f64,
}

impl Row {
    fn error_percent(&self) -> f64 {
        100.0 * (self.form_factor / self.analytic - 1.0)
    }
}

/// `heliotile study wall`.
pub fn run(args: &WallArgs) -> Result<Outcome> {
    fs::create_dir_all(&args.output).map_err(Error::io(&args.output, "create the folder"))?;
    NAMES.iter().try_for_each(|name| guard_output(&args.output.join(name), &[]))?;
    let rows = rows(args)?;
    let picture = |plot: Plot| plot.svg(PICTURE.0, PICTURE.1);
    let texts = [table(&rows, args.points), picture(curves(&rows, args)), picture(errors(&rows, args))];
    write_texts(&args.output, &NAMES.into_iter().zip(texts).collect::<Vec<_>>())?;
    say(&report(&rows, args))?;
    Ok(Outcome::Fine)
}

/// A wall at one distance, with its tracer.
struct Faced {
    wall: Wall,
    tracer: Tracer,
}

impl Faced {
    fn new(distance_m: f64) -> Result<Self> {
        let wall = Wall { width_m: WALL_M, height_m: WALL_M, distance_m };
        let scene = Scene::from_triangles(&wall.triangles(0), vec![Material::matt("wall", 0.0, Class::Obstruction)])?;
        Ok(Faced { wall, tracer: Tracer::new(&scene.mesh)? })
    }

    /// Traces the form factor from a point (x, z) of the receiver.
    fn form_factor(&self, point: DVec2, rays: &[MappedRay]) -> f64 {
        let position = DVec3::new(point.x, 0.0, point.y);
        Viewpoint { position, normal: DVec3::Y }.form_factor(rays, &self.tracer)
    }
}

/// Computes form factors by every map and number of rays at every distance, in this order.
fn rows(args: &WallArgs) -> Result<Vec<Row>> {
    let walls: Vec<Faced> = args.distances.0.iter().map(|d| Faced::new(*d)).collect::<Result<_>>()?;
    let points = spread(args.points);
    let mut rows = Vec::new();
    for (mapping, rays) in maps(args).into_iter().flat_map(|m| sorted(args).into_iter().map(move |rays| (m, rays))) {
        let cast = mapping.rays(rays.side);
        let row = |faced: &Faced| {
            let mean = |of: &dyn Fn(DVec2) -> f64| points.iter().map(|p| of(*p)).sum::<f64>() / points.len() as f64;
            let form_factor = mean(&|point| faced.form_factor(point, &cast));
            let analytic = mean(&|point| faced.wall.form_factor(point));
            Row { mapping, rays, distance_m: faced.wall.distance_m, form_factor, analytic }
        };
        rows.par_extend(walls.par_iter().map(row));
    }
    Ok(rows)
}

/// Returns points spread evenly over the receiver, x and z in metres, a single one in its middle:
/// steps of the golden ratio (Niederreiter, "Random Number Generation and Quasi-Monte Carlo
/// Methods", 1992, multiples of irrational numbers), good for any number of points.
fn spread(points: u32) -> Vec<DVec2> {
    let golden = (5_f64.sqrt() - 1.0) / 2.0;
    let place = |i: u32| DVec2::new((f64::from(i) + 0.5) / f64::from(points), (0.5 + f64::from(i) * golden).fract());
    (0..points).map(|i| (place(i) - 0.5) * RECEIVER_M).collect()
}

/// Returns the rows of a map and a number of rays.
fn of(rows: &[Row], mapping: HemisphereMapping, rays: RaySquare) -> impl Iterator<Item = &Row> {
    rows.iter().filter(move |row| row.mapping == mapping && row.rays == rays)
}

/// Returns the mean over the distances of `of_error` of the error in percent.
fn mean_error(rows: &[Row], mapping: HemisphereMapping, rays: RaySquare, of_error: fn(f64) -> f64) -> f64 {
    let (sum, count) =
        of(rows, mapping, rays).fold((0.0, 0.0), |(s, n), row| (s + of_error(row.error_percent()), n + 1.0));
    sum / count
}

fn table(rows: &[Row], points: u32) -> String {
    let mut text = String::from("mapping,rays,points,distance_m,form_factor,analytic,error_percent\n");
    for row in rows {
        let Row { mapping, rays, distance_m, form_factor, analytic } = row;
        let (rays, error) = (rays.count(), row.error_percent());
        // Writing into memory cannot fail.
        let _ = writeln!(text, "{mapping},{rays},{points},{distance_m},{form_factor:.9},{analytic:.9},{error:.4}");
    }
    text
}

/// Plots the form factor against distance: the middle number of rays, and the closed form.
fn curves(rows: &[Row], args: &WallArgs) -> Plot {
    let sorted = sorted(args);
    let rays = sorted[sorted.len() / 2];
    let by_map = |mapping: HemisphereMapping| {
        let points = of(rows, mapping, rays).map(|row| (row.distance_m, row.form_factor)).collect();
        Series::new(mapping.name(), points, Style::Marks)
    };
    let mut series: Vec<Series> = maps(args).into_iter().map(by_map).collect();
    let one = maps(args).into_iter().take(1).flat_map(|mapping| of(rows, mapping, rays));
    let analytic = one.map(|row| (row.distance_m, row.analytic)).collect();
    series.push(Series::new("analytic", analytic, Style::Line));
    Plot {
        title: format!(
            "A wall of {WALL_M} m x {WALL_M} m, {} rays, {}",
            rays.count(),
            counted(args.points.into(), "point")
        ),
        x: Axis { label: "distance, m".into(), log: true },
        y: Axis { label: "form factor".into(), log: true },
        series,
    }
}

/// Plots the mean error against the number of rays, one line a map.
fn errors(rows: &[Row], args: &WallArgs) -> Plot {
    let by_map = |mapping: HemisphereMapping| {
        let point = |rays: RaySquare| (rays.count() as f64, mean_error(rows, mapping, rays, f64::abs));
        Series::new(mapping.name(), sorted(args).into_iter().map(point).collect(), Style::Both)
    };
    Plot {
        title: format!("Mean error of its form factor, {}", counted(args.points.into(), "point")),
        x: Axis { label: "rays".into(), log: true },
        y: Axis { label: "mean absolute error, %".into(), log: true },
        series: maps(args).into_iter().map(by_map).collect(),
    }
}

/// Returns the maps to use, each once.
fn maps(args: &WallArgs) -> Vec<HemisphereMapping> {
    HemisphereMapping::ALL.into_iter().filter(|mapping| args.mapping.contains(mapping)).collect()
}

/// Returns the numbers of rays, ascending, each once.
fn sorted(args: &WallArgs) -> Vec<RaySquare> {
    let mut rays = args.rays.clone();
    rays.sort_unstable();
    rays.dedup();
    rays
}

/// Returns the short table: a line for each number of rays, a column for each map.
fn report(rows: &[Row], args: &WallArgs) -> String {
    let (near, far) = rows
        .iter()
        .fold((f64::INFINITY, 0.0_f64), |(near, far), row| (near.min(row.distance_m), far.max(row.distance_m)));
    let distances = counted(args.distances.0.len() as u64, "distance");
    let points = counted(args.points.into(), "point");
    let mut text = format!(
        "RMS error of the form factor of a wall of {WALL_M} m x {WALL_M} m, percent, {distances} from {near} to {far} m, {points}:\nrays   "
    );
    for mapping in maps(args) {
        let _ = write!(text, "  {:>18}", mapping.name());
    }
    text.push('\n');
    for rays in sorted(args) {
        let _ = write!(text, "{:<7}", rays.count());
        for mapping in maps(args) {
            let _ = write!(text, "  {:>18.2}", mean_error(rows, mapping, rays, |error| error * error).sqrt());
        }
        text.push('\n');
    }
    let _ = writeln!(text, "wall.csv, wall.svg and wall_error.svg in {}", args.output.display());
    text
}
