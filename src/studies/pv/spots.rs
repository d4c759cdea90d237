//! Positions of modules and points. In: a table of points or modules of rows, a scene. Out: places
//! with their sides, each checked to lie where light can reach it, and the table of receivers that
//! is traced.

use std::collections::HashMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::ground::{GroundSpot, OFF_M};
use heliotile_builder::siting::{Enclosed, Siting};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::orientation::fan::Orientation;
use heliotile_core::site::north::North;
use heliotile_results::outputs::pv::energy::ARRAY;
use heliotile_results::outputs::pv::search::PointSearch;
use heliotile_results::outputs::sink::Sink;
use heliotile_scene::Scene;
use heliotile_scene::points::places::{PlacePoint, PointHeight, Rating};
use heliotile_scene::points::rows::ONE_DIRECTION;
use heliotile_scene::pv::cells::CellGrid;
use heliotile_scene::pv::layout::Module;
use heliotile_scene::pv::rows::RowsOfModules;

/// Place of a module or a point.
#[derive(Clone, Debug)]
pub struct Spot {
    pub name: String,
    /// Position in input coordinates, metres.
    pub position: DVec3,
    /// Orientation of the front, by true north, as the table states it; `None` if it is left to a
    /// search.
    pub given: Option<Orientation>,
    /// Orientation that a search found, if none was stated.
    found: Option<Orientation>,
    /// Material of the ground below.
    pub ground: Option<u16>,
    /// Rated power and string.
    pub rating: Rating,
    /// Cells of the front, and the number of the chain of modules that it is in series with.
    pub cells: Option<(CellGrid, usize)>,
    /// Sides: one of a point, front and rear of a module.
    pub sides: Vec<SpotSide>,
}

/// Side of a place; its light is the mean of its receivers'.
#[derive(Clone, Debug)]
pub struct SpotSide {
    /// `front`, `rear`, or empty.
    pub name: &'static str,
    pub receivers: Vec<(String, DVec3)>,
    /// Area that each receiver stands for, m2, if it is known.
    pub area_m2: Option<f64>,
}

impl Spot {
    /// Returns a point without an orientation.
    pub fn at(name: &str, position: DVec3, ground: Option<u16>) -> Self {
        let side = SpotSide { name: "", receivers: vec![(name.to_owned(), position)], area_m2: None };
        Spot {
            name: name.to_owned(),
            position,
            given: None,
            found: None,
            ground,
            rating: Rating::default(),
            cells: None,
            sides: vec![side],
        }
    }

    /// Returns a module of rows with its two sides.
    fn of_module(module: &Module, rows: &RowsOfModules, chain: usize, ground: Option<u16>) -> Self {
        let side = |name: &'static str, [across, up]: [usize; 2]| {
            let points = module.points(name == "rear", [across, up], OFF_M).into_iter().enumerate();
            let receivers = points.map(|(i, p)| (format!("{}/{name}/{}", module.name, i + 1), p)).collect();
            SpotSide { name, receivers, area_m2: Some(rows.width_m * rows.height_m / (across * up) as f64) }
        };
        let evenly = [1, rows.samples];
        let sides = vec![side("front", rows.cells.map_or(evenly, |grid| grid.cells)), side("rear", evenly)];
        let (name, rating, cells) = (module.name.clone(), rows.rating.clone(), rows.cells.map(|grid| (grid, chain)));
        Spot { name, position: module.middle(), given: Some(rows.turn), found: None, ground, rating, cells, sides }
    }

    /// Returns the area of the front, m2; `None` of a point.
    pub fn front_m2(&self) -> Option<f64> {
        let front = self.sides.first()?;
        Some(front.area_m2? * front.receivers.len() as f64)
    }

    /// Returns the orientation of the front, which is flat while unknown.
    pub fn turn(&self) -> Orientation {
        self.given.or(self.found).unwrap_or(Orientation::FLAT)
    }

    /// Returns the orientation of a side.
    pub fn turn_of(&self, side: &SpotSide) -> Orientation {
        match side.name {
            "rear" => Orientation::new(-self.turn().normal()),
            _ => self.turn(),
        }
    }
}

/// All places of a study.
#[derive(Debug)]
pub struct Spots {
    pub list: Vec<Spot>,
    /// Index into `list`, index of the side and number on it, by the name of a receiver.
    of_receiver: HashMap<String, [usize; 3]>,
}

impl Spots {
    fn new(list: Vec<Spot>) -> Self {
        let mut of_receiver = HashMap::new();
        for (i, spot) in list.iter().enumerate() {
            for (k, side) in spot.sides.iter().enumerate() {
                let ids = side.receivers.iter().map(|(id, _)| id.clone());
                of_receiver.extend(ids.enumerate().map(|(number, id)| (id, [i, k, number])));
            }
        }
        Spots { list, of_receiver }
    }

    /// Returns the points of a table in a scene.
    pub fn of_points(table: &Path, points: &[PlacePoint], siting: &Siting, scene: &Scene) -> Result<Self> {
        let (site, azimuths_from) = (North::new(scene.place.as_ref()), scene.table_north());
        let spot = |point: &PlacePoint| {
            let given = point.facing.map(|facing| facing.turn(site, azimuths_from)).transpose();
            let given = given.map_err(|what| Error::input(table, point.line, what, ONE_DIRECTION))?;
            Ok(Spot { given, rating: point.rating.clone(), ..placed(table, point, siting)? })
        };
        let list = points.iter().map(spot).collect::<Result<Vec<Spot>>>()?;
        Ok(Spots::new(list))
    }

    /// Returns the modules of rows.
    pub fn of_modules<'m>(modules: impl Iterator<Item = (&'m Module, &'m RowsOfModules)>, siting: &Siting) -> Self {
        let ground = |module: &Module| siting.ground_below(module.middle()).map(|ground| ground.material);
        let (mut list, mut chain, mut of_chain) = (Vec::new(), 0, ("", 0));
        for (module, rows) in modules {
            // Modules are in series in their order, row by row.
            let is_full = rows.cells.is_some_and(|grid| of_chain.1 == grid.series);
            if of_chain.0 != rows.name || is_full {
                (chain, of_chain) = (chain + 1, (rows.name.as_str(), 0));
            }
            of_chain.1 += 1;
            list.push(Spot::of_module(module, rows, chain, ground(module)));
        }
        Spots::new(list)
    }

    /// Returns the index in the list, the side of a receiver and its number there.
    pub fn of_receiver(&self, id: &str) -> Option<[usize; 3]> {
        self.of_receiver.get(id).copied()
    }

    /// Sets the best orientation of places that have none.
    pub fn turn_unturned(&mut self, searched: &[PointSearch]) {
        for (spot, search) in self.list.iter_mut().zip(searched) {
            spot.found = Some(search.best.turn);
        }
    }

    /// Writes the receivers, and those on the ground, into a temporary folder and returns the file.
    pub fn write_receivers(&self, ground: &[GroundSpot], folder: &Path, north: North) -> Result<PathBuf> {
        let file = folder.join("receivers.csv");
        let mut sink = Sink::file(&file)?;
        let mut write = || -> std::io::Result<()> {
            writeln!(sink, "receiver,x,y,z,nx,ny,nz,area_m2,surface,object,kind")?;
            // Names are always quoted, so that any characters are safe.
            let quoted = |name: &str| format!("\"{}\"", name.replace('"', "\"\""));
            let mut row = |id: &str, p: DVec3, n: DVec3, area: &str, part: [&str; 3]| {
                let (id, part) = (quoted(id), part.map(quoted).join(","));
                writeln!(sink, "{id},{},{},{},{},{},{},{area},{part}", p.x, p.y, p.z, n.x, n.y, n.z)
            };
            for spot in &self.list {
                let string = if spot.rating.string.is_empty() { ARRAY } else { &spot.rating.string };
                for side in &spot.sides {
                    let n = north.to_axes(spot.turn_of(side).normal());
                    let area = side.area_m2.map_or(String::new(), |area_m2| area_m2.to_string());
                    // The rear is no part of the string: its light is not that of the front.
                    let (object, kind) = match side.name {
                        "rear" => (format!("{string} rear"), "module_rear"),
                        _ => (string.to_owned(), "module"),
                    };
                    let surface = [spot.name.as_str(), side.name].join(" ");
                    for (id, p) in &side.receivers {
                        row(id, *p, n, &area, [surface.trim_end(), &object, kind])?;
                    }
                }
            }
            ground.iter().try_for_each(|spot| {
                let part = [&format!("{} ground", spot.rows), &spot.rows, "ground"];
                row(&spot.place.name, spot.place.position, DVec3::Z, "", part)
            })
        };
        write().map_err(Error::io(&file, "write to"))?;
        sink.finish()?;
        Ok(file)
    }
}

/// Returns a point with its height, without an orientation; refuses a point inside an object or
/// below the ground.
pub fn placed(table: &Path, point: &PlacePoint, siting: &Siting) -> Result<Spot> {
    let refuse =
        |what: String, hint: &'static str| Err(Error::input(table, point.line, what, hint).because(Problem::Misplaced));
    let name = &point.name;
    let z = match point.height {
        PointHeight::Z(z) => z,
        PointHeight::Above(height) => match siting.top(point.x, point.y) {
            Some(top) => top.z + height,
            None => {
                let what =
                    format!("below point `{name}` ({}, {}) the scene has neither roof nor ground", point.x, point.y);
                return refuse(what, "check the coordinates, or give its z in place of a height");
            }
        },
    };
    let position = DVec3::new(point.x, point.y, z);
    let hint = "move it, or give a height above the roof or ground in place of z";
    match siting.enclosed(position) {
        Some(Enclosed::BelowGround) => {
            let above =
                siting.top(point.x, point.y).map_or(String::new(), |top| format!(", which is at {:.2} m", top.z));
            refuse(format!("point `{name}` at z = {z:.2} m lies below the ground{above}"), hint)
        }
        Some(Enclosed::Inside(material)) => {
            refuse(format!("point `{name}` at z = {z:.2} m lies inside of `{material}`, where no light is"), hint)
        }
        None => {
            let ground = siting.ground_below(position).map(|ground| ground.material);
            Ok(Spot::at(name, position, ground))
        }
    }
}
