//! Roof face that receives its receivers one by one. In: receivers and their sums. Out: its area,
//! sum and direction, and its regions above a threshold. Patches are dropped once the face is
//! complete.

use glam::DVec3;

use super::regions::regions;
use heliotile_core::site::patch::Patch;

/// Criteria of a usable region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Usable {
    /// Least irradiation of a receiver, kWh/m2.
    pub threshold_kwh_m2: f64,
    /// Least area of a region, m2.
    pub least_m2: f64,
}

/// Area in m2, and the sum in kWh that falls on it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AreaSum {
    pub area_m2: f64,
    pub kwh: f64,
}

impl AreaSum {
    pub fn add(&mut self, other: AreaSum) {
        self.area_m2 += other.area_m2;
        self.kwh += other.kwh;
    }

    /// Returns the mean irradiation, kWh/m2; `None` without area.
    pub fn kwh_m2(&self) -> Option<f64> {
        (self.area_m2 > 0.0).then(|| self.kwh / self.area_m2)
    }
}

/// Roof face with its sums.
#[derive(Clone, Debug, Default)]
pub struct RoofFace {
    /// Index of its building.
    pub building: u32,
    pub name: String,
    /// Number of all receivers on the face.
    pub receivers: u32,
    seen: u32,
    pub all: AreaSum,
    /// Area and sum of receivers above the threshold.
    pub above: AreaSum,
    /// Area and sum of regions that are large enough.
    pub usable: AreaSum,
    pub regions: u32,
    /// Region with the largest sum, if it is large enough.
    pub best: AreaSum,
    /// Area of the largest region of any size.
    pub largest_m2: f64,
    /// Sum of normals times areas; `sky` is the sum of sky views times areas.
    normal: DVec3,
    sky: f64,
    pending: Vec<Pending>,
    /// True if a patch above the threshold is unknown: the face then counts as one region.
    pub is_vague: bool,
}

/// Receiver above the threshold, kept until the face is complete.
#[derive(Clone, Debug)]
struct Pending {
    place: DVec3,
    patch: Patch,
    lit: AreaSum,
}

/// Receiver on a face, with its sum.
pub struct OnRoof {
    pub place: DVec3,
    pub normal: DVec3,
    pub patch: Patch,
    pub sky_view: f64,
    pub area_m2: f64,
    pub kwh_m2: f64,
}

impl RoofFace {
    /// Returns a face of a building without receivers.
    pub fn new(building: u32, name: String) -> Self {
        RoofFace { building, name, ..RoofFace::default() }
    }

    /// Adds a receiver; the last one completes the face.
    pub fn add(&mut self, receiver: OnRoof, usable: Usable) {
        let OnRoof { place, normal, patch, sky_view, area_m2, kwh_m2 } = receiver;
        let lit = AreaSum { area_m2, kwh: area_m2 * kwh_m2 };
        self.seen += 1;
        self.all.add(lit);
        self.normal += area_m2 * normal;
        self.sky += area_m2 * sky_view;
        if kwh_m2 >= usable.threshold_kwh_m2 {
            self.above.add(lit);
            self.is_vague |= patch.is_empty();
            self.pending.push(Pending { place, patch, lit });
        }
        if self.seen == self.receivers {
            self.complete(usable);
        }
    }

    fn complete(&mut self, usable: Usable) {
        let pending = std::mem::take(&mut self.pending);
        let numbers = match self.is_vague {
            true => vec![0; pending.len()],
            false => regions(self.normal(), &pending.iter().map(|one| (one.place, &one.patch)).collect::<Vec<_>>()),
        };
        let mut found = vec![AreaSum::default(); numbers.iter().max().map_or(0, |most| most + 1)];
        for (number, one) in numbers.iter().zip(&pending) {
            found[*number].add(one.lit);
        }
        self.largest_m2 = found.iter().map(|region| region.area_m2).fold(0.0, f64::max);
        for region in found.into_iter().filter(|region| region.area_m2 >= usable.least_m2) {
            self.regions += 1;
            self.usable.add(region);
            if region.kwh > self.best.kwh {
                self.best = region;
            }
        }
    }

    /// Returns the mean of the normals by area, of unit length.
    pub fn normal(&self) -> DVec3 {
        self.normal.normalize_or_zero()
    }

    /// Returns the mean sky view by area.
    pub fn sky_view(&self) -> Option<f64> {
        (self.all.area_m2 > 0.0).then(|| self.sky / self.all.area_m2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In a row of 6 squares of 1 m2 the third is dark: the regions have 2 and 3 m2, and a least
    /// area of 2.5 m2 leaves one. Without patches all 5 m2 are one region.
    #[test]
    fn a_dark_square_splits_a_row_into_two_regions() {
        let usable = Usable { threshold_kwh_m2: 900.0, least_m2: 2.5 };
        let row = |patch: &Patch| {
            let mut face = RoofFace { receivers: 6, ..RoofFace::default() };
            for i in 0..6 {
                let kwh_m2 = if i == 2 { 899.9 } else { 1000.0 };
                let place = DVec3::new(f64::from(i), 0.0, 3.0);
                let patch = patch.clone();
                face.add(OnRoof { place, normal: DVec3::Z, patch, sky_view: 0.5, area_m2: 1.0, kwh_m2 }, usable);
            }
            face
        };
        let face = row(&Patch::square(DVec3::Z, 1.0));
        assert_eq!((face.all.area_m2, face.above.area_m2, face.usable.area_m2), (6.0, 5.0, 3.0));
        assert_eq!((face.regions, face.largest_m2, face.best.kwh, face.sky_view()), (1, 3.0, 3000.0, Some(0.5)));
        let vague = row(&Patch::default());
        assert_eq!((vague.is_vague, vague.usable.area_m2, vague.regions), (true, 5.0, 1));
    }
}
