//! A roof face while its receivers come. In: receivers and their sums. Out: its area, sum and direction, and the regions of it that get more
//! than a threshold; the patches that these are made of are dropped once the face is complete.

use glam::DVec3;

use super::regions::regions;
use heliotile_core::site::patch::Patch;

/// What counts as usable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Usable {
    /// A receiver gets this at least.
    pub threshold_kwh_m2: f64,
    /// A region has this area at least.
    pub least_m2: f64,
}

/// Area, and the sum that falls on it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lit {
    pub area_m2: f64,
    pub kwh: f64,
}

impl Lit {
    pub fn add(&mut self, other: Lit) {
        self.area_m2 += other.area_m2;
        self.kwh += other.kwh;
    }

    /// `None` without area.
    pub fn kwh_m2(&self) -> Option<f64> {
        (self.area_m2 > 0.0).then(|| self.kwh / self.area_m2)
    }
}

/// A roof face.
#[derive(Clone, Debug, Default)]
pub struct RoofFace {
    /// Number of its building.
    pub building: u32,
    pub name: String,
    /// All that belong to it.
    pub receivers: u32,
    seen: u32,
    pub all: Lit,
    /// Of receivers above the threshold.
    pub above: Lit,
    /// Of regions that are large enough.
    pub usable: Lit,
    pub regions: u32,
    /// The region that gets the most, if it is large enough.
    pub best: Lit,
    /// The largest region of any size.
    pub largest_m2: f64,
    /// Sums by area.
    normal: DVec3,
    sky: f64,
    pending: Vec<Pending>,
    /// Whether a patch above the threshold is not known: the face then counts as one region.
    pub is_vague: bool,
}

/// A receiver above the threshold.
#[derive(Clone, Debug)]
struct Pending {
    place: DVec3,
    patch: Patch,
    lit: Lit,
}

/// A receiver on a face, with its sum.
pub struct OnRoof {
    pub place: DVec3,
    pub normal: DVec3,
    pub patch: Patch,
    pub sky_view: f64,
    pub area_m2: f64,
    pub kwh_m2: f64,
}

impl RoofFace {
    /// One of a building that no receiver is known of yet.
    pub fn new(building: u32, name: String) -> Self {
        RoofFace { building, name, ..RoofFace::default() }
    }

    /// Adds a receiver; the last one completes the face.
    pub fn add(&mut self, receiver: OnRoof, usable: Usable) {
        let OnRoof { place, normal, patch, sky_view, area_m2, kwh_m2 } = receiver;
        let lit = Lit { area_m2, kwh: area_m2 * kwh_m2 };
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
        let mut found = vec![Lit::default(); numbers.iter().max().map_or(0, |most| most + 1)];
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

    /// Mean by area, of unit length.
    pub fn normal(&self) -> DVec3 {
        self.normal.normalize_or_zero()
    }

    /// Share of sky, mean by area.
    pub fn sky_view(&self) -> Option<f64> {
        (self.all.area_m2 > 0.0).then(|| self.sky / self.all.area_m2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 6 squares in a row, 1 m2 each, the third is dark: regions of 2 and 3 m2, of which at least 2.5 m2 leaves one; without
    /// patches all 5 m2 are one region.
    #[test]
    fn a_row() {
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
