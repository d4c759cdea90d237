//! Order of latitude and longitude. In: a position in degrees in the stated order. Out: the reason
//! to read it in the other order, if the stated one puts it where no building of the scene can be.

use std::fmt;

use crate::placing::from_degrees::FromDegrees;
use heliotile_place::reference::Reference;

/// Relative difference between a metre of a system and a metre on the ground that is allowed where
/// the system is made for the place.
pub(crate) const STRETCH: f64 = 0.01;

/// Latitude south of which Antarctica begins, degrees (Antarctic Treaty, article VI).
const ANTARCTIC_DEG: f64 = -60.0;

/// Southernmost and northernmost latitudes of towns, degrees: Puerto Williams and Longyearbyen,
/// with a degree of margin.
const TOWNS_DEG: [f64; 2] = [-56.0, 79.0];

/// Latitude and longitude, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Degrees {
    pub latitude: f64,
    pub longitude: f64,
}

impl Degrees {
    /// Returns true if the numbers are within the range of latitudes and longitudes.
    pub(crate) fn is_in_range(self) -> bool {
        self.latitude.abs() <= 90.0 && self.longitude.abs() <= 360.0
    }

    /// Returns the two numbers in the other order.
    pub(crate) fn swapped(self) -> Degrees {
        Degrees { latitude: self.longitude, longitude: self.latitude }
    }
}

impl fmt::Display for Degrees {
    fn fmt(&self, to: &mut fmt::Formatter) -> fmt::Result {
        write!(to, "latitude {} and longitude {}", self.latitude, self.longitude)
    }
}

/// Reason to read two numbers in the other order than the stated one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Swap {
    /// The stated latitude is beyond 90 degrees.
    Impossible,
    /// The stated order lies far outside of the scene's system of this EPSG number.
    FarFromScene(u32),
    /// The stated order lies in Antarctica.
    Antarctic,
}

impl Swap {
    /// Returns the reason to read degrees of a geographic system in the other order; `None` if the
    /// stated order may be right, or the other one is no better. Antarctica counts only where the
    /// order is not certain.
    pub(crate) fn new(geographic: Option<u32>, scene: Option<u32>, stated: Degrees, is_certain: bool) -> Option<Swap> {
        let other = stated.swapped();
        if !other.is_in_range() {
            return None;
        }
        if !stated.is_in_range() {
            return Some(Swap::Impossible);
        }
        if let Some(epsg) = scene {
            let fits = |at: Degrees| {
                let from = FromDegrees::new(geographic, scene, at.latitude, at.longitude).ok()?;
                let plane = from.plane(at.latitude, at.longitude)?;
                let unit = from.reference().unit_m();
                stretch(epsg, plane.x / unit, plane.y / unit).filter(|stretch| *stretch <= STRETCH)
            };
            return (fits(stated).is_none() && fits(other).is_some()).then_some(Swap::FarFromScene(epsg));
        }
        let [south, north] = TOWNS_DEG;
        let is_town = (south..=north).contains(&other.latitude);
        (!is_certain && stated.latitude < ANTARCTIC_DEG && is_town).then_some(Swap::Antarctic)
    }

    /// Returns a sentence that continues "the file: ".
    pub(crate) fn sentence(self, stated: Degrees) -> String {
        let why = match self {
            Swap::Impossible => "which is no place on Earth".to_owned(),
            Swap::FarFromScene(epsg) => format!("far outside of EPSG:{epsg}, the system of the scene"),
            Swap::Antarctic => "which is in Antarctica".to_owned(),
        };
        format!(
            "latitude and longitude are swapped: the first position would have {stated}, {why}; it is read as {}",
            stated.swapped()
        )
    }
}

/// Returns the relative difference between a metre of a system and a metre on the ground, at a
/// point in the system's own unit.
pub(crate) fn stretch(epsg: u32, x: f64, y: f64) -> Option<f64> {
    let reference = Reference::Epsg(epsg);
    let (_, length) = reference.locate(x, y).ok()?;
    Some((length / reference.unit_m() - 1.0).abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five of eight positions are read in the other order: two with a latitude beyond 90, one far
    /// from a scene in Germany, and two in Antarctica under names that do not fix the order.
    /// Antarctica under names that do, stations without a better place, and places that may be
    /// meant keep their order.
    #[test]
    fn five_of_eight_positions_are_swapped() {
        for (scene, latitude, longitude, is_certain, expected) in [
            (None, 139.7, 35.25, true, Some(Swap::Impossible)),
            (Some(25832), 139.7, 35.25, true, Some(Swap::Impossible)),
            (Some(25832), 9.0, 52.0, true, Some(Swap::FarFromScene(25832))),
            (None, -77.0, 38.9, false, Some(Swap::Antarctic)),
            (None, -77.0, 38.9, true, None),
            (None, -62.2, -58.96, false, None),
            (None, 9.0, 52.0, false, None),
            (None, -74.0, 40.7, false, Some(Swap::Antarctic)),
        ] {
            let found = Swap::new(Some(4326), scene, Degrees { latitude, longitude }, is_certain);
            assert_eq!(found, expected, "{latitude} {longitude}");
        }
    }
}
