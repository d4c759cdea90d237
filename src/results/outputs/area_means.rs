//! Means over receivers, by area. In: receivers and their values, tile by tile. Out: a series for
//! each component. Sums are f64 and are added in the archive's order, whatever the number of
//! threads.

use heliotile_core::replay::components::Component;
use heliotile_core::replay::values::TileValues;
use heliotile_core::site::receiver::Receiver;

/// Running sums for means over receivers.
#[derive(Clone, Debug)]
pub struct AreaMeans {
    components: Vec<Component>,
    /// `[component][label]`: sums of values times areas; `plain` are sums of values.
    weighted: Vec<Vec<f64>>,
    plain: Vec<Vec<f64>>,
    receivers: u64,
    with_area: u64,
    area_m2: f64,
}

impl AreaMeans {
    /// Returns zero sums for `labels` labels.
    pub fn new(components: &[Component], labels: usize) -> Self {
        let zeros = vec![vec![0.0; labels]; components.len()];
        let (weighted, plain) = (zeros.clone(), zeros);
        AreaMeans { components: components.to_vec(), weighted, plain, receivers: 0, with_area: 0, area_m2: 0.0 }
    }

    /// Adds the receiver in row `row` of a tile.
    pub fn add(&mut self, receiver: &Receiver, values: &TileValues, row: usize) {
        let area_m2 = receiver.area.unwrap_or_default();
        self.receivers += 1;
        self.with_area += u64::from(receiver.area.is_some());
        self.area_m2 += area_m2;
        let sums = self.weighted.iter_mut().zip(&mut self.plain);
        for (component, (weighted, plain)) in self.components.iter().zip(sums) {
            for (value, (weighted, plain)) in values.row(*component, row).iter().zip(weighted.iter_mut().zip(plain)) {
                *weighted += area_m2 * f64::from(*value);
                *plain += f64::from(*value);
            }
        }
    }

    /// Returns the mean of a component for each label: by area if all receivers have one, or else a
    /// plain mean.
    pub fn mean(&self, component: Component) -> Option<Vec<f64>> {
        let place = self.components.iter().position(|one| *one == component)?;
        let (sums, whole) = match self.is_by_area() {
            true => (self.weighted.get(place)?, self.area_m2),
            false => (self.plain.get(place)?, self.receivers.max(1) as f64),
        };
        Some(sums.iter().map(|sum| sum / whole).collect())
    }

    fn is_by_area(&self) -> bool {
        self.with_area == self.receivers && self.area_m2 > 0.0
    }

    /// Returns a description in words of what the mean is over.
    pub fn called(&self) -> String {
        let receivers = heliotile_core::text::counted(self.receivers, "receiver");
        match self.is_by_area() {
            true => format!("mean by area of {receivers}, {:.0} m\u{b2}", self.area_m2),
            false => format!("mean of {receivers}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Totals of 1 and 4 on 1 and 3 m2 have the mean 3.25. With a third receiver of 2.5 without
    /// area the mean is 2.5: areas no longer count.
    #[test]
    fn a_receiver_without_area_makes_the_mean_plain() {
        let receiver = |area| Receiver { area, ..Receiver::new("r".into(), DVec3::ZERO, DVec3::Z) };
        let mut means = AreaMeans::new(&[Component::Total], 1);
        for (value, area) in [(1.0, Some(1.0)), (4.0, Some(3.0))] {
            let mut values = TileValues::new(1, 1);
            values.row_mut(Component::Total, 0)[0] = value;
            means.add(&receiver(area), &values, 0);
        }
        assert_eq!((means.mean(Component::Total), means.mean(Component::SunDirect)), (Some(vec![3.25]), None));
        assert_eq!(means.called(), "mean by area of 2 receivers, 4 m\u{b2}");
        let mut values = TileValues::new(1, 1);
        values.row_mut(Component::Total, 0)[0] = 2.5;
        means.add(&receiver(None), &values, 0);
        assert_eq!((means.mean(Component::Total), means.called().as_str()), (Some(vec![2.5]), "mean of 3 receivers"));
    }
}
