//! Where modules stand. In: a table of points, a scene that is asked. Out: places with their heights, each checked to lie where light can come
//! to, and the table of receivers that is traced.

use std::collections::HashMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use glam::DVec3;
use tempfile::TempDir;

use crate::outputs::pv::search::PointSearch;
use crate::outputs::sink::Sink;
use heliotile_builder::siting::{Enclosed, Siting};
use heliotile_core::error::{Error, Result};
use heliotile_core::orientation::fan::Turn;
use heliotile_core::site::north::North;
use heliotile_scene::pv::points::{PointHeight, PvPoint};

/// A place of a module.
#[derive(Clone, Debug)]
pub struct Spot {
    pub name: String,
    /// Input coordinates, metres.
    pub position: DVec3,
    /// How it is turned, by true north; nothing before a search has found it.
    pub given: Option<Turn>,
    /// What a search found, where nothing was given.
    found: Option<Turn>,
    /// Material of the ground below.
    pub ground: Option<u16>,
}

impl Spot {
    /// One that nobody has turned.
    pub fn at(name: &str, position: DVec3, ground: Option<u16>) -> Self {
        Spot { name: name.to_owned(), position, given: None, found: None, ground }
    }

    /// How it is turned; flat as long as nobody knows.
    pub fn turn(&self) -> Turn {
        self.given.or(self.found).unwrap_or(Turn::FLAT)
    }
}

/// All of them.
#[derive(Debug)]
pub struct Spots {
    pub list: Vec<Spot>,
    by_name: HashMap<String, usize>,
}

impl Spots {
    /// The points of a table in a scene.
    pub fn of_points(table: Option<&Path>, points: &[PvPoint], siting: &Siting) -> Result<Self> {
        let table = table.unwrap_or(Path::new(""));
        let list = points.iter().map(|point| placed(table, point, siting)).collect::<Result<Vec<Spot>>>()?;
        let by_name = list.iter().enumerate().map(|(i, spot)| (spot.name.clone(), i)).collect();
        Ok(Spots { list, by_name })
    }

    /// The one of a name.
    pub fn get(&self, name: &str) -> Option<&Spot> {
        self.list.get(*self.by_name.get(name)?)
    }

    /// Gives those that have no turn the best one.
    pub fn turn_unturned(&mut self, searched: &[PointSearch]) {
        for (spot, search) in self.list.iter_mut().zip(searched) {
            spot.found = Some(search.best.turn);
        }
    }

    /// Writes the receivers into a table that is not yet in its place.
    pub fn write_receivers(&self, folder: &Path, north: North) -> Result<Beside> {
        let beside = tempfile::Builder::new().prefix(".receivers").tempdir_in(folder);
        let beside = beside.map_err(Error::io(folder, "make a folder in"))?;
        let file = beside.path().join("receivers.csv");
        let mut sink = Sink::file(&file)?;
        let mut write = || -> std::io::Result<()> {
            writeln!(sink, "receiver,x,y,z,nx,ny,nz")?;
            for spot in &self.list {
                let (p, n) = (spot.position, north.to_axes(spot.turn().normal()));
                // Names are quoted, whatever they hold.
                let name = spot.name.replace('"', "\"\"");
                writeln!(sink, "\"{name}\",{},{},{},{},{},{}", p.x, p.y, p.z, n.x, n.y, n.z)?;
            }
            Ok(())
        };
        write().map_err(Error::io(&file, "write to"))?;
        sink.finish()?;
        Ok(Beside { _folder: beside, file })
    }
}

/// A table of receivers that is not yet in its place; it is removed with the value.
pub struct Beside {
    _folder: TempDir,
    file: PathBuf,
}

impl Beside {
    pub fn path(&self) -> &Path {
        &self.file
    }

    /// Puts the table into its place.
    pub fn place(self, to: &Path) -> Result<()> {
        fs::rename(&self.file, to).map_err(Error::io(to, "rename to"))
    }
}

/// A point with its height; refused inside of things.
fn placed(table: &Path, point: &PvPoint, siting: &Siting) -> Result<Spot> {
    let refuse = |what: String, hint: &str| Err(Error::input(table, point.line, what, hint));
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
        None => Ok(Spot {
            name: name.clone(),
            position,
            given: point.turn,
            found: None,
            ground: siting.ground_below(position).map(|ground| ground.material),
        }),
    }
}
