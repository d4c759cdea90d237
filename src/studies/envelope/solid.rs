//! Mesh of an envelope. In: a grid, its heights. Out: a closed mesh as a Wavefront OBJ file.

use std::collections::BTreeMap;
use std::io::{BufWriter, Write};
use std::path::Path;

use glam::DVec3;

use super::grid::Grid;
use heliotile_core::error::{Error, Result};
use heliotile_files::writing::whole_file::WholeFile;
use heliotile_results::outputs::provenance::Provenance;

/// Triangles of a body over some squares of a grid.
pub struct Solid<'g> {
    grid: &'g Grid,
    tops_m: &'g [f64],
    /// Squares that are built on.
    built: Vec<[usize; 4]>,
}

impl<'g> Solid<'g> {
    /// Returns the body between the ground and the tops of nodes; squares with a corner that may
    /// not rise above the ground are left out.
    pub fn new(grid: &'g Grid, tops_m: &'g [f64]) -> Self {
        let is_built = |square: &&[usize; 4]| square.iter().all(|node| tops_m[*node] > grid.nodes[*node].ground_m);
        Solid { grid, tops_m, built: grid.squares.iter().filter(is_built).copied().collect() }
    }

    /// Returns true if a node belongs to the body.
    pub fn nodes(&self) -> Vec<bool> {
        let mut nodes = vec![false; self.grid.nodes.len()];
        self.built.iter().flatten().for_each(|node| nodes[*node] = true);
        nodes
    }

    /// Returns the volume, m3, and the largest height above the ground, metres.
    pub fn volume_m3_and_height_m(&self) -> (f64, f64) {
        let height = |node: usize| self.tops_m[node] - self.grid.nodes[node].ground_m;
        let prism = |[a, b, c]: [usize; 3]| {
            let at = |node: usize| self.grid.nodes[node].at;
            let area_m2 = 0.5 * (at(b) - at(a)).perp_dot(at(c) - at(a));
            area_m2 * (height(a) + height(b) + height(c)) / 3.0
        };
        let volume = self.built.iter().flat_map(halves).map(prism).sum();
        (volume, self.built.iter().flatten().map(|node| height(*node)).fold(0.0, f64::max))
    }

    /// Iterates over the triangles of the top and of the sides.
    pub fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        let low = |node: usize| self.grid.nodes[node].at.extend(self.grid.nodes[node].ground_m);
        let high = |node: usize| self.grid.nodes[node].at.extend(self.tops_m[node]);
        let top = self.built.iter().flat_map(halves).map(move |nodes| nodes.map(high));
        let sides = self.sides().into_iter();
        top.chain(sides.flat_map(move |[a, b]| [[low(a), low(b), high(b)], [low(a), high(b), high(a)]]))
    }

    /// Returns the nodes at the ends of the sides of squares that only one of them has, in the
    /// square's order.
    fn sides(&self) -> Vec<[usize; 2]> {
        let mut sides: BTreeMap<[usize; 2], i32> = BTreeMap::new();
        for square in &self.built {
            for (a, b) in square.iter().zip(square.iter().cycle().skip(1)) {
                *sides.entry([*a.min(b), *a.max(b)]).or_default() += if a < b { 1 } else { -1 };
            }
        }
        let own = sides.into_iter().filter(|(_, turns)| *turns != 0);
        own.map(|([a, b], turns)| if turns > 0 { [a, b] } else { [b, a] }).collect()
    }

    /// Writes the mesh, with outward faces.
    pub fn write(&self, path: &Path, about: &Provenance) -> Result<()> {
        let mut file = BufWriter::new(WholeFile::create(path)?);
        self.lines(&mut file, about).map_err(Error::io(path, "write"))?;
        file.into_inner().map_err(|error| Error::io(path, "write")(error.into_error()))?.finish()
    }

    fn lines(&self, file: &mut impl Write, about: &Provenance) -> std::io::Result<()> {
        for (name, value) in about.ascii() {
            writeln!(file, "# {name}: {value}")?;
        }
        writeln!(file, "o envelope")?;
        // Numbers of vertices start at 1; each node has one on the ground and one on top.
        let mut numbers = vec![0; self.grid.nodes.len()];
        let mut count = 0;
        for (node, _) in self.nodes().iter().enumerate().filter(|(_, is_built)| **is_built) {
            let at = self.grid.nodes[node].at;
            for z in [self.grid.nodes[node].ground_m, self.tops_m[node]] {
                writeln!(file, "v {:.4} {:.4} {z:.4}", at.x, at.y)?;
            }
            numbers[node] = count + 1;
            count += 2;
        }
        let (low, high) = (|node: usize| numbers[node], |node: usize| numbers[node] + 1);
        for square in &self.built {
            for [a, b, c] in halves(square) {
                writeln!(file, "f {} {} {}", high(a), high(b), high(c))?;
                writeln!(file, "f {} {} {}", low(a), low(c), low(b))?;
            }
        }
        for [a, b] in self.sides() {
            writeln!(file, "f {} {} {} {}", low(a), low(b), high(b), high(a))?;
        }
        Ok(())
    }
}

/// Returns the two triangles of a square.
fn halves(&[a, b, c, d]: &[usize; 4]) -> [[usize; 3]; 2] {
    [[a, b, c], [a, c, d]]
}
