//! Folder of results being written. In: grids, hours, values tile by tile. Out: the folder, which
//! appears under its name when it is complete.
//!
//! Receivers of a grid are scattered over tiles. Each array therefore has its whole size from the
//! start, and rows are written at their offsets. Memory holds the rows of one tile.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::grids::Grids;
use super::hours::LitHours;
use crate::outputs::provenance::Provenance;
use crate::outputs::tables::{npy_header, quoted};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::replay::components::Component;
use heliotile_core::replay::values::TileValues;
use heliotile_core::site::receiver::Receiver;

/// Name of the folder for results of static apertures, windows that never change; this writer has
/// no others.
const STATIC: &str = "__static_apertures__";

/// Arrays, by the names of the reader.
const ARRAYS: [(Component, &str); 2] = [(Component::Total, "total"), (Component::SunDirect, "direct")];

/// Folder of results being written.
pub struct ResultsFolder {
    path: PathBuf,
    partial: PathBuf,
    grids: Grids,
    hours: LitHours,
    arrays: Vec<(Component, PathBuf)>,
    /// `[grid]`: number of rows that were written.
    rows: Vec<u32>,
    /// Number of receivers that were written.
    done: usize,
    /// Table of the grid and row of each receiver.
    table: Option<BufWriter<File>>,
    finished: bool,
}

impl ResultsFolder {
    /// Refuses a folder that holds anything.
    pub fn check(path: &Path) -> Result<()> {
        let is_empty = |path: &Path| fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_none());
        if path.exists() && !is_empty(path) {
            return Err(Error::input(path, None, "exists and is not empty", "give another folder, or remove this one")
                .because(Problem::Exists));
        }
        let partial = partial_of(path);
        match partial.exists() {
            true => Err(Error::input(&partial, None, "is left over from a run that was stopped", "remove it")),
            false => Ok(()),
        }
    }

    /// Creates the arrays of `total` and `sun_direct`, if they are among the components.
    pub fn create(
        path: &Path,
        grids: Grids,
        hours: LitHours,
        components: &[Component],
        about: &Provenance,
    ) -> Result<Self> {
        ResultsFolder::check(path)?;
        let partial = partial_of(path);
        let asked = ARRAYS.into_iter().filter(|(component, _)| components.contains(component));
        let arrays = asked.map(|(component, name)| (component, partial.join(STATIC).join("default").join(name)));
        let mut folder = ResultsFolder {
            path: path.to_owned(),
            rows: vec![0; grids.list.len()],
            arrays: arrays.collect(),
            partial,
            grids,
            hours,
            done: 0,
            table: None,
            finished: false,
        };
        let here = folder.partial.clone();
        folder.begin(about).map_err(Error::io(&here, "write into"))?;
        Ok(folder)
    }

    fn begin(&mut self, about: &Provenance) -> io::Result<()> {
        let (partial, hours) = (&self.partial, self.hours.lit.len());
        fs::create_dir_all(partial.join("grids"))?;
        for (_, folder) in &self.arrays {
            fs::create_dir_all(folder)?;
            // Arrays get their whole size now: a grid's receivers come scattered over tiles.
            for grid in &self.grids.list {
                let header = npy_header("<f4", &[grid.count.into(), hours as u64]);
                let mut file = File::create(array_of(folder, &grid.identifier))?;
                file.write_all(&header)?;
                file.set_len((header.len() + 4 * grid.count as usize * hours) as u64)?;
            }
        }
        let info = |grid: &super::grids::SensorGrid| {
            json!({
                "name": grid.name, "identifier": grid.identifier, "full_id": grid.identifier, "group": "", "count": grid.count,
                "light_path": [[STATIC]],
            })
        };
        let study: Vec<Value> = self
            .hours
            .all
            .iter()
            .map(|hour| match self.hours.timestep {
                // The reader needs integers here, not floats.
                1 => json!(*hour as u32),
                _ => json!(hour),
            })
            .collect();
        write(partial, "grids_info.json", json!(self.grids.list.iter().map(info).collect::<Vec<_>>()))?;
        write(partial, "study_info.json", json!({"timestep": self.hours.timestep, "study_hours": study}))?;
        write(partial, "provenance.json", about.json())?;
        fs::write(partial.join("sun-up-hours.txt"), self.hours.text())?;
        let mut table = BufWriter::new(File::create(partial.join("receivers.csv"))?);
        writeln!(table, "grid,row,receiver,x,y,z,nx,ny,nz")?;
        self.table = Some(table);
        Ok(())
    }

    /// Appends the next receivers and their values.
    pub fn write(&mut self, receivers: &[Receiver], values: &TileValues) -> Result<()> {
        let here = self.partial.clone();
        self.add(receivers, values).map_err(Error::io(&here, "write into"))
    }

    fn add(&mut self, receivers: &[Receiver], values: &TileValues) -> io::Result<()> {
        let mut by_grid: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for row in 0..receivers.len() {
            let grid = self.grids.of_receiver.get(self.done + row).copied().unwrap_or_default();
            by_grid.entry(grid).or_default().push(row);
        }
        self.done += receivers.len();
        for (number, rows) in by_grid {
            let (Some(grid), Some(first)) = (self.grids.list.get(number as usize), self.rows.get_mut(number as usize))
            else {
                continue;
            };
            for (component, folder) in &self.arrays {
                let mut file = OpenOptions::new().write(true).open(array_of(folder, &grid.identifier))?;
                let head = npy_header("<f4", &[grid.count.into(), self.hours.lit.len() as u64]).len() as u64;
                file.seek(SeekFrom::Start(head + 4 * u64::from(*first) * self.hours.lit.len() as u64))?;
                let mut bytes = Vec::with_capacity(4 * rows.len() * self.hours.lit.len());
                for row in &rows {
                    let values = values.row(*component, *row);
                    let lit = self.hours.lit.iter().map(|hour| values.get(*hour).copied().unwrap_or_default());
                    lit.for_each(|value| bytes.extend(value.to_le_bytes()));
                }
                file.write_all(&bytes)?;
            }
            let points = self.partial.join("grids").join(format!("{}.pts", grid.identifier));
            let mut points = BufWriter::new(OpenOptions::new().create(true).append(true).open(points)?);
            for (i, receiver) in rows.iter().filter_map(|row| receivers.get(*row)).enumerate() {
                let (p, n) = (receiver.position, receiver.normal);
                let place = [p.x, p.y, p.z].map(|metres| format!("{metres:.4}"));
                let normal = [n.x, n.y, n.z].map(|share| format!("{share:.6}"));
                writeln!(points, "{} {}", place.join(" "), normal.join(" "))?;
                if let Some(table) = &mut self.table {
                    let row = *first as usize + i;
                    writeln!(
                        table,
                        "{},{row},{},{},{}",
                        quoted(&grid.identifier),
                        quoted(&receiver.id),
                        place.join(","),
                        normal.join(",")
                    )?;
                }
            }
            points.flush()?;
            *first += rows.len() as u32;
        }
        Ok(())
    }

    /// Completes the folder, which appears only now, and returns the number of grids.
    pub fn finish(mut self) -> Result<usize> {
        if let Some(mut table) = self.table.take() {
            table.flush().map_err(Error::io(&self.partial, "write into"))?;
        }
        if self.path.exists() {
            // `check` made sure that it is empty.
            fs::remove_dir(&self.path).map_err(Error::io(&self.path, "replace"))?;
        }
        fs::rename(&self.partial, &self.path).map_err(Error::io(&self.path, "rename to"))?;
        self.finished = true;
        Ok(self.grids.list.len())
    }
}

impl Drop for ResultsFolder {
    fn drop(&mut self) {
        if !self.finished {
            let _ = fs::remove_dir_all(&self.partial);
        }
    }
}

fn write(folder: &Path, name: &str, value: Value) -> io::Result<()> {
    fs::write(folder.join(name), format!("{value}\n"))
}

fn array_of(folder: &Path, identifier: &str) -> PathBuf {
    folder.join(format!("{identifier}.npy"))
}

fn partial_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_os_string();
    name.push(".partial");
    PathBuf::from(name)
}
