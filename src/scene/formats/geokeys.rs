//! In: the numbers of a GeoTIFF's GeoKeyDirectory (tag 34735, OGC 19-008r4 section 7.1). Out: which system and which units are meant.

use std::path::Path;

use crate::reference::Reference;
use crate::terrain::raster::{Meaning, degrees};
use heliotile_core::error::Result;

const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;
const GEOGRAPHIC_SYSTEM: u16 = 2048;
const PROJECTED_SYSTEM: u16 = 3072;
const PLANE_UNIT: u16 = 3076;
const HEIGHT_UNIT: u16 = 4099;

/// Numbers that are stated in the directory itself, by key.
pub(super) struct GeoKeys(Vec<(u16, u16)>);

impl GeoKeys {
    pub(super) fn read(directory: &[u16]) -> GeoKeys {
        let (_, entries) = directory.split_at(directory.len().min(4));
        // Key, tag that holds its value (0: here), count, value.
        let numbers = entries.as_chunks::<4>().0.iter().filter(|entry| entry[1] == 0);
        GeoKeys(numbers.map(|&[key, _, _, value]| (key, value)).collect())
    }

    fn get(&self, key: u16) -> Option<u16> {
        self.0.iter().find(|entry| entry.0 == key).map(|entry| entry.1)
    }

    pub(super) fn samples_are_points(&self) -> bool {
        self.get(RASTER_TYPE) == Some(2)
    }

    /// Metres a unit of the plane coordinates; 1 where it is not stated.
    pub(super) fn metres_in_plane(&self) -> f64 {
        self.get(PLANE_UNIT).and_then(metres).unwrap_or(1.0)
    }

    /// Refuses degrees.
    pub(super) fn meaning(&self, file: &Path, warnings: &mut Vec<String>) -> Result<Meaning> {
        // 1 is projected, 2 longitude and latitude, 3 geocentric.
        let model = self.get(MODEL_TYPE);
        if matches!(model, Some(2 | 3)) || (model.is_none() && self.get(GEOGRAPHIC_SYSTEM).is_some()) {
            let system =
                self.get(GEOGRAPHIC_SYSTEM).map_or("a geographic system".into(), |code| format!("EPSG:{code}"));
            return Err(degrees(file, &format!("it is stated in {system}")));
        }
        let file = file.display();
        let plane = self.metres_in_plane();
        let heights = self.get(HEIGHT_UNIT);
        for (key, what) in [(PLANE_UNIT, "coordinates"), (HEIGHT_UNIT, "heights")] {
            if let Some(unit) = self.get(key).filter(|&unit| metres(unit).is_none()) {
                warnings
                    .push(format!("{file}: the unit of the {what} (EPSG:{unit}) is not known and taken for metres"));
            }
        }
        // 32767 is "user-defined".
        let system = self.get(PROJECTED_SYSTEM).filter(|&code| (1024..32767).contains(&code));
        if plane != 1.0 {
            warnings.push(format!(
                "{file}: coordinates in feet are converted to metres, which leaves the coordinate system that the file names"
            ));
            if heights.is_none() {
                warnings.push(format!("{file}: no unit of heights is stated, taken are metres"));
            }
        }
        Ok(Meaning {
            nodata: None,
            metres: heights.and_then(metres).unwrap_or(1.0),
            projected: model == Some(1),
            reference: system.filter(|_| plane == 1.0).map(|code| Reference::Epsg(code.into())),
        })
    }
}

/// Metres of a unit of length of the EPSG register.
fn metres(unit: u16) -> Option<f64> {
    match unit {
        9001 => Some(1.0),
        // The international foot and the foot of the US survey.
        9002 => Some(0.3048),
        9003 => Some(1200.0 / 3937.0),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meaning(entries: &[[u16; 4]]) -> Result<(Meaning, usize)> {
        let directory: Vec<u16> = [[1, 1, 0, entries.len() as u16]].iter().chain(entries).flatten().copied().collect();
        let mut warnings = Vec::new();
        let found = GeoKeys::read(&directory).meaning(Path::new("r.tif"), &mut warnings)?;
        Ok((found, warnings.len()))
    }

    /// UTM zone 11 is EPSG:32611 without a warning; survey feet are 1200/3937 m and warn twice, as the system no longer holds and
    /// heights have no unit; longitude and latitude are refused.
    #[test]
    fn systems() {
        let (utm, warnings) = meaning(&[[1024, 0, 1, 1], [3072, 0, 1, 32611], [3076, 0, 1, 9001]]).expect("metres");
        assert_eq!((utm.reference, utm.metres, warnings), (Some(Reference::Epsg(32611)), 1.0, 0));
        let (feet, warnings) = meaning(&[[1024, 0, 1, 1], [3072, 0, 1, 2225], [3076, 0, 1, 9003]]).expect("feet");
        assert_eq!((feet.reference, feet.metres, warnings), (None, 1.0, 2));
        let (high, _) = meaning(&[[4099, 0, 1, 9002]]).expect("feet of height");
        assert_eq!(high.metres, 0.3048);
        let message = meaning(&[[1024, 0, 1, 2], [2048, 0, 1, 4326]]).expect_err("degrees").to_string();
        assert!(message.contains("EPSG:4326") && message.contains("reproject it to metres"), "{message}");
    }

    /// Directories of 0 to 9 numbers are read without a key that is not whole.
    #[test]
    fn short() {
        for length in 0..10 {
            assert_eq!(GeoKeys::read(&vec![1; length]).0.len(), 0);
        }
    }
}
