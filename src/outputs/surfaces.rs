//! Means over the receivers of a surface, weighted by area. In: receivers, then their values tile by tile. Out: a table's tiles
//! of surfaces, in the order of their names. Sums are f64 and added in the archive's order, whatever the number of threads.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;

use heliotile_core::error::{Error, Result};
use heliotile_core::replay::components::Component;
use heliotile_core::replay::values::TileValues;
use heliotile_core::site::receiver::Receiver;

/// Surfaces that become one tile of a table.
const SURFACES_AT_ONCE: usize = 64;

/// Receivers that a message names.
const NAMED: usize = 3;

/// Which surface each receiver counts to, and how much.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceGroups {
    /// Sorted.
    names: Vec<String>,
    /// `[receiver]`: place in `names`.
    places: Vec<u32>,
    /// `[receiver]`: its share of the area of its surface.
    shares: Vec<f64>,
}

/// What is known of a surface while receivers are read.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    number: u32,
    receivers: u64,
    /// Receivers with an area, and the sum of these.
    with_area: u64,
    area_m2: f64,
}

impl SurfaceGroups {
    /// From the receivers of `file`, in the order in which their values will come. Every receiver must have a surface. Where
    /// no receiver of a surface has an area all count the same; where some have, all must.
    pub fn new(receivers: impl Iterator<Item = Result<Receiver>>, file: &Path) -> Result<Self> {
        let mut found: BTreeMap<String, Found> = BTreeMap::new();
        let (mut places, mut areas) = (Vec::new(), Vec::new());
        let (mut homeless, mut count) = (Vec::new(), 0_u64);
        for receiver in receivers {
            let Receiver { id, area, surface, .. } = receiver?;
            let Some(name) = surface else {
                count += 1;
                if homeless.len() < NAMED {
                    homeless.push(id);
                }
                continue;
            };
            let next = found.len() as u32;
            let surface = found.entry(name).or_insert(Found { number: next, ..Found::default() });
            surface.receivers += 1;
            surface.with_area += u64::from(area.is_some());
            surface.area_m2 += area.unwrap_or_default();
            places.push(surface.number);
            areas.push(area.unwrap_or_default());
        }
        if count > 0 {
            let more = if count > NAMED as u64 { ", ..." } else { "" };
            let what = format!("{count} receivers have no surface: {}{more}", homeless.join(", "));
            let hint = "choose those that have one with --receivers, or build with names in the column `surface`";
            return Err(Error::input(file, None, what, hint));
        }
        if let Some((name, some)) = found.iter().find(|(_, s)| s.with_area != 0 && s.with_area != s.receivers) {
            let what = format!("surface `{name}`: {} of {} receivers have an area", some.with_area, some.receivers);
            let hint = "build with an area for each receiver of a surface, or for none: they count the same then";
            return Err(Error::input(file, None, what, hint));
        }
        // Numbers in order of appearance become places in the order of names.
        let mut by_number = vec![(0, 0.0, false); found.len()];
        for (place, surface) in found.values().enumerate() {
            let equal = surface.with_area == 0;
            let whole = if equal { surface.receivers as f64 } else { surface.area_m2 };
            if let Some(slot) = by_number.get_mut(surface.number as usize) {
                *slot = (place as u32, whole, equal);
            }
        }
        let mut surfaces = SurfaceGroups { names: found.into_keys().collect(), ..SurfaceGroups::default() };
        for (number, area_m2) in places.into_iter().zip(areas) {
            let (place, whole, equal) = by_number.get(number as usize).copied().unwrap_or_default();
            surfaces.places.push(place);
            surfaces.shares.push(if equal { 1.0 } else { area_m2 } / whole);
        }
        Ok(surfaces)
    }

    pub fn names(&self) -> &[String] {
        &self.names
    }
}

/// Means of surfaces, being added up.
#[derive(Clone, Debug)]
pub struct SurfaceMeans {
    surfaces: SurfaceGroups,
    labels: usize,
    /// Components that are asked for, with their sums: `[surface][label]`.
    sums: Vec<(Component, Vec<f64>)>,
    /// Receivers that were added.
    done: usize,
}

impl SurfaceMeans {
    /// Zeros; an error if they take more than `memory_bytes`.
    pub fn new(surfaces: SurfaceGroups, components: &[Component], labels: usize, memory_bytes: u64) -> Result<Self> {
        let cells = surfaces.names.len().saturating_mul(labels);
        let bytes = (cells as u64).saturating_mul(8 * components.len() as u64);
        if bytes > memory_bytes {
            let (s, c) = (surfaces.names.len(), components.len());
            return Err(Error::Limit {
                what: format!(
                    "the memory of sums, in bytes, for {s} surfaces, {labels} rows of each and {c} columns (raise --memory, \
                     take fewer --columns or a longer --every)"
                ),
                value: bytes,
                max: memory_bytes,
            });
        }
        let sums = components.iter().map(|component| (*component, vec![0.0; cells])).collect();
        Ok(SurfaceMeans { surfaces, labels, sums, done: 0 })
    }

    pub fn surfaces(&self) -> &SurfaceGroups {
        &self.surfaces
    }

    /// Adds the next receivers.
    pub fn add(&mut self, values: &TileValues) {
        let range = self.done..self.done + values.receivers();
        self.done = range.end;
        let places = self.surfaces.places.get(range.clone()).unwrap_or_default();
        let shares = self.surfaces.shares.get(range).unwrap_or_default();
        let labels = self.labels;
        // One component a thread: each sum is added in the order of receivers.
        self.sums.par_iter_mut().for_each(|(component, sums)| {
            for (row, (place, share)) in places.iter().zip(shares).enumerate() {
                let first = *place as usize * labels;
                let sums = sums.get_mut(first..first + labels).unwrap_or_default();
                let values = values.row(*component, row);
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += share * f64::from(*value));
            }
        });
    }

    /// The means: names of some surfaces and their values, all other components zero.
    pub fn tiles(&self) -> impl Iterator<Item = (Vec<String>, TileValues)> + '_ {
        self.surfaces.names.chunks(SURFACES_AT_ONCE).enumerate().map(move |(i, names)| {
            let mut values = TileValues::new(names.len(), self.labels);
            let first = i * SURFACES_AT_ONCE * self.labels;
            for (component, sums) in &self.sums {
                let here = sums.iter().skip(first);
                let target = values.component_mut(*component);
                target.iter_mut().zip(here).for_each(|(value, sum)| *value = *sum as f32);
            }
            (names.to_vec(), values)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn receiver(id: &str, surface: &str, area: f64) -> Result<Receiver> {
        Ok(Receiver {
            id: id.into(),
            position: DVec3::ZERO,
            normal: DVec3::Z,
            area: (area > 0.0).then_some(area),
            surface: (!surface.is_empty()).then(|| surface.to_string()),
        })
    }

    fn surfaces(receivers: &[(&str, f64)]) -> Result<SurfaceGroups> {
        let all = receivers.iter().enumerate().map(|(i, (surface, area))| receiver(&format!("r{i}"), surface, *area));
        SurfaceGroups::new(all, Path::new("site.helio"))
    }

    /// Totals of 1 and 4 on areas of 1 and 3 m2 are 3.25; 2 and 5 without areas are 3.5; surfaces come by name, 2 tiles of
    /// receivers as 1 of surfaces, and a component that is not asked for stays 0.
    #[test]
    fn weighted_means() {
        let surfaces = surfaces(&[("wall", 1.0), ("lawn", 0.0), ("wall", 3.0), ("lawn", 0.0)]).expect("surfaces");
        assert_eq!(surfaces.names(), ["lawn", "wall"]);
        let mut means = SurfaceMeans::new(surfaces, &[Component::Total], 2, 32).expect("32 bytes");
        for pair in [[1.0, 2.0], [4.0, 5.0]] {
            let mut values = TileValues::new(2, 2);
            for (row, value) in pair.into_iter().enumerate() {
                values.row_mut(Component::Total, row).copy_from_slice(&[value, -value]);
                values.row_mut(Component::SunDirect, row).fill(9.0);
            }
            means.add(&values);
        }
        let tiles: Vec<_> = means.tiles().collect();
        assert_eq!(tiles.len(), 1);
        let (names, values) = &tiles[0];
        assert_eq!(names, &["lawn", "wall"]);
        assert_eq!(values.component(Component::Total), [3.5, -3.5, 3.25, -3.25]);
        assert!(values.component(Component::SunDirect).iter().all(|v| *v == 0.0));
    }

    /// 130 surfaces come as tiles of 64, 64 and 2.
    #[test]
    fn many_surfaces() {
        let names: Vec<String> = (0..130).map(|i| format!("s{i:03}")).collect();
        let receivers: Vec<(&str, f64)> = names.iter().rev().map(|n| (n.as_str(), 2.0)).collect();
        let mut means = SurfaceMeans::new(surfaces(&receivers).expect("surfaces"), &[Component::SunDirect], 1, 2000)
            .expect("memory");
        let mut values = TileValues::new(130, 1);
        values.component_mut(Component::SunDirect).iter_mut().enumerate().for_each(|(i, v)| *v = i as f32);
        means.add(&values);
        let tiles: Vec<_> = means.tiles().collect();
        assert_eq!(tiles.iter().map(|t| t.0.len()).collect::<Vec<_>>(), [64, 64, 2]);
        let all: Vec<f32> = tiles.iter().flat_map(|t| t.1.component(Component::SunDirect).to_vec()).collect();
        assert_eq!(all, (0..130).rev().map(|i| i as f32).collect::<Vec<_>>());
    }

    /// Receivers without a surface are counted and 3 named, a surface with some areas is named with 1 of 2, and sums of 5
    /// bytes too many are refused with their size.
    #[test]
    fn refusals() {
        let text = surfaces(&[("", 0.0); 5]).expect_err("no surfaces").to_string();
        assert!(text.contains("site.helio: 5 receivers have no surface: r0, r1, r2, ..."), "{text}");
        let text = surfaces(&[("a", 0.0), ("b", 1.0), ("b", 0.0)]).expect_err("mixed").to_string();
        assert!(text.contains("surface `b`: 1 of 2 receivers have an area"), "{text}");
        let one = surfaces(&[("a", 0.0)]).expect("a surface");
        let text = SurfaceMeans::new(one, &Component::ALL, 10, 555).expect_err("560 bytes").to_string();
        assert!(text.contains("1 surfaces, 10 rows") && text.contains("is 560, the limit is 555"), "{text}");
    }
}
