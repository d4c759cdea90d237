//! Counts of losses. In: receivers with their sums before and after. Out: means by area, and the
//! numbers of receivers, windows and buildings that lose more than certain shares.

use std::collections::BTreeMap;

use crate::outputs::buildings::building_of;
use heliotile_core::site::receiver::Receiver;

/// Losses that are counted, percent.
pub const LOSSES_PERCENT: [u32; 3] = [5, 10, 20];

/// Kind of surfaces whose losses are counted separately.
const WINDOW: &str = "window";

/// Number of receivers, windows or buildings, and how many of them lose more than each of
/// [`LOSSES_PERCENT`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LossCounts {
    /// Number of all.
    pub all: u64,
    /// Numbers of those that lose more than each of [`LOSSES_PERCENT`].
    pub losing: [u64; 3],
}

/// Running sums before and after.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    receivers: u64,
    with_area: u64,
    area_m2: f64,
    /// Sums before and after of values times areas; `plain` are sums of values.
    weighted: [f64; 2],
    plain: [f64; 2],
}

/// Running counts and sums of a comparison.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    pub all: Sums,
    pub receivers: LossCounts,
    windows: BTreeMap<String, Sums>,
    buildings: BTreeMap<String, Sums>,
}

impl Sums {
    fn add(&mut self, area_m2: Option<f64>, sides: [f64; 2]) {
        self.receivers += 1;
        self.with_area += u64::from(area_m2.is_some());
        let area_m2 = area_m2.unwrap_or_default();
        self.area_m2 += area_m2;
        for ((weighted, plain), value) in self.weighted.iter_mut().zip(&mut self.plain).zip(sides) {
            *weighted += area_m2 * value;
            *plain += value;
        }
    }

    /// Returns the means before and after: by area if all receivers have one, or else plain means.
    pub fn means(&self) -> [f64; 2] {
        match self.is_by_area() {
            true => self.weighted.map(|sum| sum / self.area_m2),
            false => self.plain.map(|sum| sum / self.receivers.max(1) as f64),
        }
    }

    /// Returns the area of the receivers, if all have one.
    pub fn area_m2(&self) -> Option<f64> {
        self.is_by_area().then_some(self.area_m2)
    }

    fn is_by_area(&self) -> bool {
        self.with_area == self.receivers && self.area_m2 > 0.0
    }
}

impl Tally {
    /// Adds a receiver with its sums before and after.
    pub fn add(&mut self, receiver: &Receiver, sides: [f64; 2]) {
        self.all.add(receiver.area, sides);
        self.receivers.add(sides);
        if receiver.part.kind == WINDOW {
            let name = receiver.surface.as_ref().unwrap_or(&receiver.id);
            self.windows.entry(name.clone()).or_default().add(receiver.area, sides);
        }
        if let Some(name) = building_of(receiver) {
            match self.buildings.get_mut(name) {
                Some(building) => building.add(receiver.area, sides),
                None => self.buildings.entry(name.to_owned()).or_default().add(receiver.area, sides),
            }
        }
    }

    /// Counts windows that lose light, by the means of their receivers.
    pub fn windows(&self) -> LossCounts {
        counts(&self.windows)
    }

    /// Counts buildings that lose light, by the means of their receivers.
    pub fn buildings(&self) -> LossCounts {
        counts(&self.buildings)
    }
}

impl LossCounts {
    fn add(&mut self, [before, after]: [f64; 2]) {
        self.all += 1;
        for (count, percent) in self.losing.iter_mut().zip(LOSSES_PERCENT) {
            *count += u64::from(before - after > before * f64::from(percent) / 100.0);
        }
    }
}

fn counts(groups: &BTreeMap<String, Sums>) -> LossCounts {
    let mut counts = LossCounts::default();
    groups.values().for_each(|sums| counts.add(sums.means()));
    counts
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// A window of 1 m2 that loses all and 3 m2 that lose nothing is one window that loses 25 %;
    /// its building with a dark wall of 4 m2 loses as much; one of 3 receivers loses, and a
    /// receiver without light before loses nothing.
    #[test]
    fn losses_are_counted_by_area() {
        let receiver = |id: &str, area: f64, kind: &str| {
            let mut receiver = Receiver { area: Some(area), ..Receiver::new(id.into(), DVec3::ZERO, DVec3::Z) };
            receiver.surface = Some(kind.into());
            (receiver.part.kind, receiver.part.building) = (kind.into(), "b".into());
            receiver
        };
        let mut tally = Tally::default();
        tally.add(&receiver("1", 1.0, "window"), [100.0, 0.0]);
        tally.add(&receiver("2", 3.0, "window"), [100.0, 100.0]);
        tally.add(&receiver("3", 4.0, "wall"), [0.0, 0.0]);
        let lose = |all, losing| LossCounts { all, losing };
        assert_eq!(tally.receivers, lose(3, [1, 1, 1]));
        assert_eq!((tally.windows(), tally.buildings()), (lose(1, [1, 1, 1]), lose(1, [1, 1, 1])));
        assert_eq!((tally.all.means(), tally.all.area_m2()), ([50.0, 37.5], Some(8.0)));
        let mut edge = LossCounts::default();
        [[100.0, 95.0], [100.0, 89.9], [100.0, 120.0]].into_iter().for_each(|sides| edge.add(sides));
        assert_eq!(edge, lose(3, [1, 1, 0]));
    }
}
