//! Means over groups of receivers (a surface, an object, a building, a kind), weighted by area. In:
//! receivers, then their values tile by tile. Out: tiles of a table with these groups, in the order
//! of their names. Sums are f64 and are added in the archive's order, whatever the number of
//! threads.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DVec3;
use rayon::prelude::*;

use crate::outputs::tables::layout::{By, Fact};

use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::replay::components::Component;
use heliotile_core::replay::values::TileValues;
use heliotile_core::site::north::North;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::{FirstNames, message};

/// Number of groups that become one tile of a table.
const GROUPS_AT_ONCE: usize = 64;

/// Least length of the mean of unit normals of surfaces that face one way. The mean has this length
/// if normals spread by about 25 degrees: on terrain, but not on all walls of a house.
pub const ONE_WAY: f64 = 0.9;

/// Groups of receivers, with the group and the weight of each receiver.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Groups {
    /// Names of the groups, sorted.
    names: Vec<String>,
    /// `[receiver]`: index into `names`.
    places: Vec<u32>,
    /// `[receiver]`: share of the area of its group.
    shares: Vec<f64>,
    /// `[group]`: area and direction.
    extents: Vec<GroupGeometry>,
    /// Archive of the receivers, for messages.
    file: PathBuf,
}

/// Area and direction of a group.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GroupGeometry {
    /// Area in m2; `None` if no receiver has an area.
    pub area_m2: Option<f64>,
    /// Mean of the normals by area, of unit length; zero if they cancel.
    pub normal: DVec3,
    /// Length of the mean before it is normalised: 1 if all receivers face the same way.
    pub agreement: f64,
    /// Position of a receiver, input coordinates in metres; zero for groups.
    pub position: DVec3,
}

impl GroupGeometry {
    /// Returns the extent of a receiver, with its normal by true north.
    pub fn new(receiver: &Receiver, north: North) -> GroupGeometry {
        let Receiver { area, normal, position, .. } = *receiver;
        GroupGeometry { area_m2: area, normal: north.to_true(normal), agreement: 1.0, position }
    }
}

/// Running sums of a group while receivers are read.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    number: u32,
    receivers: u64,
    /// Number of receivers with an area; `area_m2` is the sum of their areas.
    with_area: u64,
    area_m2: f64,
    /// Sum of normals times areas; `plain` is the sum of normals.
    weighted: DVec3,
    plain: DVec3,
}

impl Groups {
    /// Groups the receivers of `file`, which must come in the same order as their values; `by` is
    /// not [`By::Receiver`]. Every receiver must belong to a group. If no receiver of a group has
    /// an area, all have equal weight; if some have one, all must.
    pub fn new(receivers: impl Iterator<Item = Result<Receiver>>, by: By, file: &Path) -> Result<Self> {
        let mut found: BTreeMap<String, Found> = BTreeMap::new();
        let (mut places, mut areas) = (Vec::new(), Vec::new());
        let mut homeless = FirstNames::<3>::default();
        for receiver in receivers {
            let receiver = receiver?;
            let name = name_of(&receiver, by);
            let Receiver { id, area, normal, .. } = receiver;
            let Some(name) = name else {
                homeless.add(|| id);
                continue;
            };
            let next = found.len() as u32;
            let surface = found.entry(name).or_insert(Found { number: next, ..Found::default() });
            surface.receivers += 1;
            surface.with_area += u64::from(area.is_some());
            surface.area_m2 += area.unwrap_or_default();
            surface.weighted += area.unwrap_or_default() * normal;
            surface.plain += normal;
            places.push(surface.number);
            areas.push(area.unwrap_or_default());
        }
        if homeless.count > 0 {
            let column = by.name();
            let what = format!("{} receivers have no {column}: {}", homeless.count, homeless.listed());
            let hint =
                message!("choose those that have one with {{receivers}}, or build with names in the column `{column}`");
            return Err(Error::input(file, None, what, hint).because(Problem::Lacks(column)));
        }
        if let Some((name, some)) = found.iter().find(|(_, s)| s.with_area != 0 && s.with_area != s.receivers) {
            let what =
                format!("{} `{name}`: {} of {} receivers have an area", by.name(), some.with_area, some.receivers);
            let hint =
                "build with an area for each receiver of a group, or for none: without areas, all count the same";
            return Err(Error::input(file, None, what, hint).because(Problem::Lacks("area")));
        }
        // Groups were numbered by first appearance; results list them by name.
        let mut by_number = vec![(0, 0.0, false); found.len()];
        for (place, surface) in found.values().enumerate() {
            let equal = surface.with_area == 0;
            let whole = if equal { surface.receivers as f64 } else { surface.area_m2 };
            by_number[surface.number as usize] = (place as u32, whole, equal);
        }
        let extent = |group: &Found| match group.with_area {
            0 => {
                let agreement = group.plain.length() / group.receivers.max(1) as f64;
                GroupGeometry { normal: group.plain.normalize_or_zero(), agreement, ..GroupGeometry::default() }
            }
            _ => {
                let agreement = group.weighted.length() / group.area_m2;
                GroupGeometry {
                    area_m2: Some(group.area_m2),
                    normal: group.weighted.normalize_or_zero(),
                    agreement,
                    ..GroupGeometry::default()
                }
            }
        };
        let extents = found.values().map(extent).collect();
        let (file, names) = (file.to_path_buf(), found.into_keys().collect());
        let mut surfaces = Groups { file, names, extents, ..Groups::default() };
        for (number, area_m2) in places.into_iter().zip(areas) {
            let (place, whole, equal) = by_number[number as usize];
            surfaces.places.push(place);
            surfaces.shares.push(if equal { 1.0 } else { area_m2 } / whole);
        }
        Ok(surfaces)
    }

    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the index of the group that a receiver belongs to.
    pub fn place_of(&self, receiver: usize) -> Result<u32> {
        self.places.get(receiver).copied().ok_or_else(|| self.missing(receiver))
    }

    /// Returns the share of its group's area that a receiver stands for.
    pub fn share_of(&self, receiver: usize) -> Result<f64> {
        self.shares.get(receiver).copied().ok_or_else(|| self.missing(receiver))
    }

    /// Returns the area and direction of each group.
    pub fn extents(&self) -> &[GroupGeometry] {
        &self.extents
    }

    /// Returns the error for a receiver that the groups do not contain.
    fn missing(&self, receiver: usize) -> Error {
        let what = format!("hold {} receivers, but not number {receiver}", self.places.len());
        Error::defect(&self.file, "receivers", "groups", what)
    }

    /// Returns the further columns that a table of the groups has. Areas need an area for each
    /// group, sums an energy as well. Directions need surfaces that each face one way, not names
    /// shared by several surfaces.
    pub fn facts(&self, by: By, has_energy: bool) -> Vec<Fact> {
        let has_areas = !self.extents.is_empty() && self.extents.iter().all(|extent| extent.area_m2.is_some());
        let has_sides =
            matches!(by, By::Surface | By::Window) && self.extents.iter().all(|extent| extent.agreement >= ONE_WAY);
        let facts = [
            (Fact::Area, has_areas),
            (Fact::Tilt, has_sides),
            (Fact::Azimuth, has_sides),
            (Fact::Sum, has_areas && has_energy),
        ];
        facts.into_iter().filter_map(|(fact, is_known)| is_known.then_some(fact)).collect()
    }

    /// Returns the groups with directions by true north.
    pub fn facing(mut self, north: North) -> Self {
        self.extents.iter_mut().for_each(|extent| extent.normal = north.to_true(extent.normal));
        self
    }
}

/// Returns the name of the group that a receiver belongs to.
fn name_of(receiver: &Receiver, by: By) -> Option<String> {
    let part = &receiver.part;
    let name = match by {
        By::Receiver => &receiver.id,
        By::Surface | By::Pane => receiver.surface.as_ref()?,
        By::Window => receiver.surface.as_ref().filter(|_| part.kind == "window")?,
        By::Object => &part.object,
        By::Building => &part.building,
        By::Kind => &part.kind,
    };
    (!name.is_empty()).then(|| name.clone())
}

/// Running means of groups.
#[derive(Clone, Debug)]
pub struct GroupMeans {
    groups: Groups,
    bins: usize,
    /// Requested components with their sums, `[group][bin]`.
    sums: Vec<(Component, Vec<f64>)>,
    /// Number of receivers that were added.
    done: usize,
}

impl GroupMeans {
    /// Returns zero sums; fails if they take more than `memory_bytes`.
    pub fn new(groups: Groups, components: &[Component], bins: usize, memory_bytes: u64) -> Result<Self> {
        let cells = groups.names.len().saturating_mul(bins);
        let bytes = (cells as u64).saturating_mul(8 * components.len() as u64);
        if bytes > memory_bytes {
            let (s, c) = (groups.names.len(), components.len());
            return Err(Error::Limit {
                what: message!(
                    "the memory of sums, in bytes, for {s} rows of names, {bins} rows of each and {c} columns (raise {{memory}}, \
                     choose fewer {{columns}} or a longer {{every}})"
                ),
                value: bytes,
                max: memory_bytes,
            });
        }
        let sums = components.iter().map(|component| (*component, vec![0.0; cells])).collect();
        Ok(GroupMeans { groups, bins, sums, done: 0 })
    }

    pub fn groups(&self) -> &Groups {
        &self.groups
    }

    /// Adds the next receivers; more receivers than the groups contain are a defect.
    pub fn add(&mut self, values: &TileValues) -> Result<()> {
        let range = self.done..self.done + values.receivers();
        let Groups { places, shares, .. } = &self.groups;
        let (Some(places), Some(shares)) = (places.get(range.clone()), shares.get(range.clone())) else {
            return Err(self.groups.missing(range.end - 1));
        };
        self.done = range.end;
        let bins = self.bins;
        // Each thread adds one component, so each sum is added in the order of receivers.
        self.sums.par_iter_mut().for_each(|(component, sums)| {
            for (row, (place, share)) in places.iter().zip(shares).enumerate() {
                let first = *place as usize * bins;
                let values = values.row(*component, row);
                let sums = &mut sums[first..first + bins];
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += share * f64::from(*value));
            }
        });
        Ok(())
    }

    /// Returns the means, tile by tile: names, values and extents of some groups. Components that
    /// were not requested are zero.
    pub fn tiles(&self) -> impl Iterator<Item = (Vec<String>, TileValues, &[GroupGeometry])> + '_ {
        self.groups.names.chunks(GROUPS_AT_ONCE).enumerate().map(move |(i, names)| {
            let mut values = TileValues::new(names.len(), self.bins);
            let first = i * GROUPS_AT_ONCE * self.bins;
            for (component, sums) in &self.sums {
                let here = sums.iter().skip(first);
                let target = values.component_mut(*component);
                target.iter_mut().zip(here).for_each(|(value, sum)| *value = *sum as f32);
            }
            let extents = self.groups.extents.chunks(GROUPS_AT_ONCE).nth(i).unwrap_or_default();
            (names.to_vec(), values, extents)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn receiver(id: &str, surface: &str, area: f64) -> Result<Receiver> {
        Ok(Receiver {
            area: (area > 0.0).then_some(area),
            surface: (!surface.is_empty()).then(|| surface.to_string()),
            ..Receiver::new(id.into(), DVec3::ZERO, DVec3::Z)
        })
    }

    fn surfaces(receivers: &[(&str, f64)]) -> Result<Groups> {
        let all = receivers.iter().enumerate().map(|(i, (surface, area))| receiver(&format!("r{i}"), surface, *area));
        Groups::new(all, By::Surface, Path::new("site.helio"))
    }

    /// Totals of 1 and 4 on areas of 1 and 3 m2 have the mean 3.25; 2 and 5 without areas have 3.5.
    /// Surfaces come by name, 2 tiles of receivers become 1 tile of surfaces, a component that is
    /// not requested stays 0, and a fifth receiver is a defect.
    #[test]
    fn means_of_groups_are_weighted_by_area() {
        let surfaces = surfaces(&[("wall", 1.0), ("lawn", 0.0), ("wall", 3.0), ("lawn", 0.0)]).expect("surfaces");
        assert_eq!(surfaces.names(), ["lawn", "wall"]);
        let mut means = GroupMeans::new(surfaces, &[Component::Total], 2, 32).expect("32 bytes");
        for pair in [[1.0, 2.0], [4.0, 5.0]] {
            let mut values = TileValues::new(2, 2);
            for (row, value) in pair.into_iter().enumerate() {
                values.row_mut(Component::Total, row).copy_from_slice(&[value, -value]);
                values.row_mut(Component::SunDirect, row).fill(9.0);
            }
            means.add(&values).expect("known receivers");
        }
        let unknown = means.add(&TileValues::new(1, 2)).expect_err("a fifth receiver").to_string();
        assert!(unknown.contains("hold 4 receivers, but not number 4"), "{unknown}");
        let areas: Vec<Option<f64>> = means.groups().extents.iter().map(|extent| extent.area_m2).collect();
        assert_eq!(areas, [None, Some(4.0)]);
        let tiles: Vec<_> = means.tiles().collect();
        assert_eq!(tiles.len(), 1);
        let (names, values, _) = &tiles[0];
        assert_eq!(names, &["lawn", "wall"]);
        assert_eq!(values.component(Component::Total), [3.5, -3.5, 3.25, -3.25]);
        assert!(values.component(Component::SunDirect).iter().all(|v| *v == 0.0));
    }

    /// 130 surfaces come as tiles of 64, 64 and 2.
    #[test]
    fn groups_come_in_tiles_of_64() {
        let names: Vec<String> = (0..130).map(|i| format!("s{i:03}")).collect();
        let receivers: Vec<(&str, f64)> = names.iter().rev().map(|n| (n.as_str(), 2.0)).collect();
        let mut means =
            GroupMeans::new(surfaces(&receivers).expect("surfaces"), &[Component::SunDirect], 1, 2000).expect("memory");
        let mut values = TileValues::new(130, 1);
        values.component_mut(Component::SunDirect).iter_mut().enumerate().for_each(|(i, v)| *v = i as f32);
        means.add(&values).expect("known receivers");
        let tiles: Vec<_> = means.tiles().collect();
        assert_eq!(tiles.iter().map(|t| t.0.len()).collect::<Vec<_>>(), [64, 64, 2]);
        let all: Vec<f32> = tiles.iter().flat_map(|t| t.1.component(Component::SunDirect).to_vec()).collect();
        assert_eq!(all, (0..130).rev().map(|i| i as f32).collect::<Vec<_>>());
    }

    /// Receivers without a surface are counted and 3 of them named, a surface with some areas is
    /// named with 1 of 2, and sums of 5 bytes too many are refused with their size.
    #[test]
    fn missing_surfaces_and_mixed_areas_are_refused() {
        let text = surfaces(&[("", 0.0); 5]).expect_err("no surfaces").to_string();
        assert!(text.contains("site.helio: 5 receivers have no surface: r0, r1, r2, ..."), "{text}");
        let text = surfaces(&[("a", 0.0), ("b", 1.0), ("b", 0.0)]).expect_err("mixed").to_string();
        assert!(text.contains("surface `b`: 1 of 2 receivers have an area"), "{text}");
        let one = surfaces(&[("a", 0.0)]).expect("a surface");
        let text = GroupMeans::new(one, &Component::ALL, 10, 555).expect_err("560 bytes").to_string();
        assert!(text.contains("1 rows of names, 10 rows") && text.contains("is 560, the limit is 555"), "{text}");
    }
}
