//! Roofs and walls of a city. In: chains drawn straight, planes of roofs, heights of the ground
//! along them. Out: faces of buildings, closed where the ground closes them.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use glam::DVec2;

use crate::plan::signed_area_m2;
use crate::surface_city::floor::Moved;
use crate::surface_city::lattice::{Lattice, Spot};
use crate::surface_city::layers::Layers;
use crate::surface_city::outlines::{Chain, FIRST_ROOF, GROUND, Link, OUTSIDE};
use crate::surface_city::plane::Plane;
use crate::surface_city::roofs::RoofPiece;
use crate::surface_city::straight::Polyline;
use crate::surface_city::writer::{Corner, FaceOf, Writer};
use heliotile_core::error::Result;
use heliotile_core::site::semantics::SurfaceKind;

/// Difference below which heights of two planes at a corner are equal, metres.
const ONE_HEIGHT_M: f64 = 0.02;
/// Height below which a step between roofs of a building is a seam, where planes do not quite meet,
/// metres. Seams let no light through and get no receivers.
const SEAM_M: f64 = 0.5;

/// Foot of a building.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Foot {
    /// Height that walls without ground beside them reach down to.
    pub height: f64,
    /// True if ground lies beside the building somewhere.
    pub meets_ground: bool,
}

/// Everything that the faces of buildings are made from.
pub(super) struct Buildings<'a> {
    pub layers: &'a Layers,
    pub chains: &'a [Chain],
    pub lines: Vec<Polyline>,
    pub rings: &'a BTreeMap<u32, Vec<Vec<Link>>>,
    pub roofs: &'a [RoofPiece],
    /// `[building]`.
    pub feet: &'a [Foot],
    /// Height of the ground, `[corner]`.
    pub ground: &'a Lattice<f32>,
    /// Places of corners of cells along chains.
    pub moved: &'a Moved,
}

/// Numbers of the materials and objects of buildings.
pub(super) struct BuildingNames {
    pub roof: u32,
    pub wall: u32,
    /// Number of the object, `[building]`.
    pub objects: Vec<u32>,
}

/// Heights of roofs at corners in plan, with the piece of each.
type Heights = HashMap<[u64; 2], Vec<(u32, f64)>>;

fn key(place: DVec2) -> [u64; 2] {
    [place.x.to_bits(), place.y.to_bits()]
}

/// Returns the roof of a piece; `None` if the piece is no roof.
pub(super) fn roof_of(roofs: &[RoofPiece], piece: u32) -> Option<&RoofPiece> {
    piece.checked_sub(FIRST_ROOF).and_then(|number| roofs.get(number as usize))
}

/// Returns the corners of a ring in plan, the first one not repeated.
pub(super) fn outline(lines: &[Polyline], ring: &[Link]) -> Vec<DVec2> {
    let mut found = Vec::new();
    for link in ring {
        let points = lines.get(link.chain).map(|line| line.points.as_slice()).unwrap_or_default();
        let count = points.len().saturating_sub(1);
        match link.forwards {
            true => found.extend(points.iter().take(count)),
            false => found.extend(points.iter().rev().take(count)),
        }
    }
    found
}

impl Buildings<'_> {
    fn plane(&self, piece: u32) -> Option<Plane> {
        roof_of(self.roofs, piece).map(|roof| roof.plane)
    }

    /// Adds corners to chains between roofs where one plane crosses the other.
    fn cross(&mut self) {
        for (chain, line) in self.chains.iter().zip(&mut self.lines) {
            let of = |piece: u32| roof_of(self.roofs, piece).map(|roof| roof.plane);
            let (Some(left), Some(right)) = (of(chain.left), of(chain.right)) else { continue };
            let gap = |place: DVec2| left.at(place) - right.at(place);
            let (mut points, mut corners) = (Vec::new(), Vec::new());
            let ends = line.points.iter().skip(1).map(Some).chain([None]);
            for ((point, at), next) in line.points.iter().zip(&line.corners).zip(ends) {
                points.push(*point);
                corners.push(*at);
                let Some(next) = next else { continue };
                let (here, there) = (gap(*point), gap(*next));
                if here * there < 0.0 && here.abs().min(there.abs()) > ONE_HEIGHT_M {
                    points.push(point.lerp(*next, here / (here - there)));
                    corners.push(*at);
                }
            }
            *line = Polyline { points, corners };
        }
    }

    /// Returns the heights of all roofs at their corners; nearly equal heights become equal.
    fn heights(&self) -> Heights {
        let mut all = Heights::new();
        for (piece, rings) in self.rings {
            let Some(plane) = self.plane(*piece) else { continue };
            for place in rings.iter().flat_map(|ring| outline(&self.lines, ring)) {
                let found = all.entry(key(place)).or_default();
                if !found.iter().any(|(known, _)| known == piece) {
                    found.push((*piece, plane.at(place)));
                }
            }
        }
        for found in all.values_mut() {
            found.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
            for group in found.chunk_by_mut(|a, b| b.1 - a.1 < ONE_HEIGHT_M) {
                let mean = group.iter().map(|(_, height)| height).sum::<f64>() / group.len() as f64;
                group.iter_mut().for_each(|(_, height)| *height = mean);
            }
        }
        all
    }

    fn corner(&self, heights: &Heights, piece: u32, place: DVec2) -> Corner {
        let known = heights.get(&key(place)).into_iter().flatten().find(|(known, _)| *known == piece);
        let height = known.map(|(_, height)| *height).or_else(|| Some(self.plane(piece)?.at(place)));
        Corner { place, height: height.unwrap_or_default() }
    }

    /// Writes all roofs and walls, and returns the number of buildings that the border cuts.
    pub(super) fn write(mut self, writer: &mut Writer, names: &BuildingNames) -> Result<usize> {
        self.cross();
        let heights = self.heights();
        for (piece, rings) in self.rings {
            let Some(roof) = roof_of(self.roofs, *piece) else { continue };
            let object = names.objects.get(roof.building as usize).copied().unwrap_or_default();
            let of = FaceOf { material: names.roof, object, kind: Some(SurfaceKind::Roof), exposed: None };
            let mut numbers: Vec<(f64, Vec<u32>)> = Vec::new();
            for ring in rings {
                let plan = outline(&self.lines, ring);
                let corners: Vec<Corner> = plan.iter().map(|place| self.corner(&heights, *piece, *place)).collect();
                numbers.push((signed_area_m2(&plan), writer.ring(&corners)?));
            }
            // The outline is the one ring that turns counter-clockwise.
            numbers.sort_by(|a, b| b.0.total_cmp(&a.0));
            numbers.retain(|(_, ring)| ring.len() > 2);
            writer.face(numbers.iter().map(|(_, ring)| ring.as_slice()), &of);
        }
        let mut cut = BTreeSet::new();
        for number in 0..self.chains.len() {
            cut.extend(self.walls(writer, names, &heights, number)?);
        }
        Ok(cut.len())
    }

    /// Returns true if no wall stands along a straight line, because the surface ends there: at the
    /// border of the raster, or at nodata if the surface shows ground elsewhere beside the
    /// building.
    fn is_cut(&self, chain: &Chain, line: &Polyline, from: usize, foot: &Foot) -> bool {
        let ends = line.corners.get(from).zip(line.corners.get(from + 1));
        let corners = ends.and_then(|(a, b)| chain.corners.get(*a..=*b)).unwrap_or_default();
        let [columns, rows] = [self.layers.grid.columns as i64, self.layers.grid.rows as i64];
        let on_border = |[column, row]: &Spot| [0, columns].contains(column) || [0, rows].contains(row);
        chain.left.min(chain.right) == OUTSIDE && (foot.meets_ground || corners.iter().all(on_border))
    }

    /// Writes the walls along a chain, and returns the building if the border cuts it there.
    fn walls(
        &self,
        writer: &mut Writer,
        names: &BuildingNames,
        heights: &Heights,
        number: usize,
    ) -> Result<Option<u32>> {
        let (Some(chain), Some(line)) = (self.chains.get(number), self.lines.get(number)) else { return Ok(None) };
        let (left, right) = (roof_of(self.roofs, chain.left), roof_of(self.roofs, chain.right));
        let Some(building) = left.or(right).map(|roof| roof.building) else { return Ok(None) };
        let object = names.objects.get(building as usize).copied().unwrap_or_default();
        let Some(foot) = self.feet.get(building as usize) else { return Ok(None) };
        let mut cut = None;
        let side = |piece: u32, from: usize, to: usize| -> Option<Vec<Corner>> {
            let ends = [*line.points.get(from)?, *line.points.get(to)?];
            if roof_of(self.roofs, piece).is_some() {
                return Some(ends.map(|place| self.corner(heights, piece, place)).to_vec());
            }
            if piece != GROUND {
                return Some(ends.map(|place| Corner { place, height: foot.height }).to_vec());
            }
            let corners = chain.corners.get(*line.corners.get(from)?..=*line.corners.get(to)?)?;
            let ground = corners.iter().map(|corner| Corner {
                place: self.moved.get(corner).copied().unwrap_or_else(|| self.layers.corner(*corner)),
                height: f64::from(self.ground.at(*corner)),
            });
            Some(ground.collect())
        };
        for from in 0..line.points.len().saturating_sub(1) {
            let (Some(left), Some(right)) = (side(chain.left, from, from + 1), side(chain.right, from, from + 1))
            else {
                continue;
            };
            let is_cut = self.is_cut(chain, line, from, foot);
            cut = cut.or(is_cut.then_some(building));
            for panel in panels(&left, &right) {
                let tallest = panel.iter().map(|corner| corner.height);
                let (low, high) = tallest.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (a.min(h), b.max(h)));
                let is_seam = chain.left.min(chain.right) >= FIRST_ROOF && high - low < SEAM_M;
                let of = FaceOf {
                    material: names.wall,
                    object,
                    kind: Some(SurfaceKind::Wall),
                    exposed: (is_seam || is_cut).then_some(false),
                };
                let ring = writer.ring(&panel)?;
                if ring.len() > 2 {
                    writer.face([ring.as_slice()], &of);
                }
            }
        }
        Ok(cut)
    }
}

/// Returns the faces between the left and the right side of a straight line, facing the lower side.
/// There is one face if the same side is higher all along, or else one for each piece.
fn panels(left: &[Corner], right: &[Corner]) -> Vec<Vec<Corner>> {
    let (Some([first, last]), Some([low_first, low_last])) = (ends(left), ends(right)) else { return Vec::new() };
    let many = if left.len() > right.len() { left } else { right };
    let along = (last.place - first.place).length().max(1e-9);
    let on = |ends: [Corner; 2], place: DVec2| {
        let share = ((place - ends[0].place).length() / along).clamp(0.0, 1.0);
        ends[0].height + share * (ends[1].height - ends[0].height)
    };
    // Heights of both sides at all corners; one side has corners at the ends alone.
    let both: Vec<[Corner; 2]> = many
        .iter()
        .map(|corner| {
            let (mut one, mut other) = (*corner, *corner);
            if left.len() > right.len() {
                other.height = on([low_first, low_last], corner.place);
            } else {
                one.height = on([first, last], corner.place);
            }
            [one, other]
        })
        .collect();
    const NONE_M: f64 = 1e-6;
    let gap = |pair: &[Corner; 2]| pair[0].height - pair[1].height;
    if both.iter().all(|pair| gap(pair).abs() < NONE_M) {
        return Vec::new();
    }
    // Along the right side and back along the left one, the face looks to the lower side, whichever
    // it is.
    if both.iter().all(|pair| gap(pair) > -NONE_M) || both.iter().all(|pair| gap(pair) < NONE_M) {
        return vec![right.iter().chain(left.iter().rev()).copied().collect()];
    }
    let mut found = Vec::new();
    for [a, b] in both.array_windows() {
        let (here, there) = (gap(a), gap(b));
        if here * there >= 0.0 {
            found.push(vec![a[1], b[1], b[0], a[0]]);
            continue;
        }
        let share = here / (here - there);
        let height = a[0].height + share * (b[0].height - a[0].height);
        let middle = Corner { place: a[0].place.lerp(b[0].place, share), height };
        found.push(vec![a[1], middle, a[0]]);
        found.push(vec![middle, b[1], b[0]]);
    }
    found
}

fn ends(side: &[Corner]) -> Option<[Corner; 2]> {
    Some([*side.first()?, *side.last()?])
}
