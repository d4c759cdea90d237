//! In: the numbers of a GeoTIFF's GeoKeyDirectory (tag 34735, OGC 19-008r4 section 7.1). Out: the
//! coordinate system and the units that it states.

use std::path::Path;

use crate::formats::projections::{Projection, half_axis_of};
use crate::terrain::raster::{Meaning, degrees, geocentric};
use heliotile_core::error::Result;
use heliotile_core::text::{Message, message};
use heliotile_place::epsg_numbers::{Axes, FOOT_M, US_FOOT_M, axes_of, height_unit_m};
use heliotile_place::reference::Reference;

const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;
const GEOGRAPHIC_SYSTEM: u16 = 2048;
const PROJECTED_SYSTEM: u16 = 3072;
const PLANE_UNIT: u16 = 3076;
const PLANE_UNIT_SIZE: u16 = 3077;
const HEIGHT_SYSTEM: u16 = 4096;
const HEIGHT_UNIT: u16 = 4099;

const METHOD: u16 = 3075;
const HALF_AXIS: u16 = 2057;

/// Codes of projections (OGC 19-008r4, annex on `ProjMethodGeoKey`), with their names in well-known
/// text.
const METHODS: [(u16, &str); 8] = [
    (1, "transverse_mercator"),
    (7, "mercator"),
    (8, "lambert_conformal_conic_2sp"),
    (9, "lambert_conformal_conic_1sp"),
    (10, "lambert_azimuthal_equal_area"),
    (11, "albers"),
    (15, "polar_stereographic"),
    (16, "oblique_stereographic"),
];

/// Keys of parameters, with their names in well-known text.
const PARAMETERS: [(u16, &str); 16] = [
    (3078, "standard_parallel_1"),
    (3079, "standard_parallel_2"),
    (3080, "central_meridian"),
    (3081, "latitude_of_origin"),
    (3082, "false_easting"),
    (3083, "false_northing"),
    (3084, "central_meridian"),
    (3085, "latitude_of_origin"),
    (3086, "false_easting"),
    (3087, "false_northing"),
    (3088, "central_meridian"),
    (3089, "latitude_of_origin"),
    (3090, "false_easting"),
    (3091, "false_northing"),
    (3092, "scale_factor"),
    (3095, "central_meridian"),
];

/// Tag of the floating-point numbers that keys point to, and the code for user-defined values.
const DOUBLES: u16 = 34736;
const USER_DEFINED: u16 = 32767;

/// Values of the directory by key: short codes in the directory itself, and numbers in the tag of
/// floating-point numbers.
pub(super) struct GeoKeys {
    codes: Vec<(u16, u16)>,
    numbers: Vec<(u16, f64)>,
}

impl GeoKeys {
    pub(super) fn read(directory: &[u16], doubles: &[f64]) -> GeoKeys {
        let (_, entries) = directory.split_at(directory.len().min(4));
        // An entry is: key, tag that holds its value (0 for the entry itself), count, value or
        // index in the tag.
        let entries = entries.as_chunks::<4>().0;
        let codes = entries.iter().filter(|entry| entry[1] == 0).map(|&[key, _, _, value]| (key, value)).collect();
        let numbers = entries
            .iter()
            .filter(|entry| entry[1] == DOUBLES)
            .filter_map(|&[key, _, _, place]| Some((key, doubles.get(usize::from(place)).copied()?)))
            .collect();
        GeoKeys { codes, numbers }
    }

    fn get(&self, key: u16) -> Option<u16> {
        self.codes.iter().find(|entry| entry.0 == key).map(|entry| entry.1)
    }

    fn number(&self, key: u16) -> Option<f64> {
        self.numbers.iter().find(|entry| entry.0 == key).map(|entry| entry.1)
    }

    pub(super) fn samples_are_points(&self) -> bool {
        self.get(RASTER_TYPE) == Some(2)
    }

    /// Returns the plane system by its EPSG number, or by the parameters that the file states.
    /// Codes below 1024 and from 32767 on are user-defined.
    fn system(&self) -> Option<Reference> {
        let stated = self.get(PROJECTED_SYSTEM).filter(|code| (1024..USER_DEFINED).contains(code));
        stated.map(u32::from).or_else(|| self.number_of_parameters()).map(Reference::Epsg)
    }

    /// Returns the EPSG number of the system whose parameters the file states.
    fn number_of_parameters(&self) -> Option<u32> {
        let method = self.get(METHOD)?;
        let (_, method) = METHODS.iter().find(|(code, _)| *code == method)?;
        let parameters: Vec<(String, f64)> =
            PARAMETERS.iter().filter_map(|(key, name)| Some(((*name).to_owned(), self.number(*key)?))).collect();
        let geographic = self.get(GEOGRAPHIC_SYSTEM);
        let half_axis_m = self.number(HALF_AXIS).or_else(|| half_axis_of(geographic?.into()))?;
        let datum = match geographic {
            // EPSG numbers of WGS 84, NAD83 and ETRS89 in degrees.
            Some(4326) => "WGS_1984",
            Some(4269) => "NAD_1983",
            Some(4258) => "ETRS",
            _ => "",
        };
        let unit = self.stated_plane_unit_m().unwrap_or(1.0);
        Projection::of_parameters(method, &parameters, unit, half_axis_m)?.epsg(datum)
    }

    /// Returns the unit of plane coordinates that the file states, in metres.
    fn stated_plane_unit_m(&self) -> Option<f64> {
        match self.get(PLANE_UNIT)? {
            USER_DEFINED => self.number(PLANE_UNIT_SIZE).filter(|size| *size > 0.0 && size.is_finite()),
            unit => metres(unit),
        }
    }

    /// Returns the unit of plane coordinates, in metres: the stated one, or the one that the
    /// coordinate system has by definition.
    fn plane_unit_m(&self) -> Option<f64> {
        self.stated_plane_unit_m().or_else(|| {
            let Reference::Epsg(number) = self.system()? else { return None };
            (axes_of(number) == Some(Axes::Plane)).then(|| Reference::Epsg(number).unit_m())
        })
    }

    /// Returns the unit of heights, in metres: the stated one, or the one that the vertical system
    /// has by definition.
    fn height_unit_m(&self) -> Option<f64> {
        let by_system = || self.get(HEIGHT_SYSTEM).and_then(|code| height_unit_m(code.into()));
        self.get(HEIGHT_UNIT).and_then(metres).or_else(by_system)
    }

    /// Returns the coordinate system and units; refuses degrees and geocentric coordinates.
    pub(super) fn meaning(&self, file: &Path, warnings: &mut Vec<Message>) -> Result<Meaning> {
        // 1 is projected, 2 longitude and latitude, 3 geocentric.
        let model = self.get(MODEL_TYPE);
        let geographic = self.get(GEOGRAPHIC_SYSTEM);
        let system = geographic.map_or("geographic".into(), |code| format!("EPSG:{code}"));
        let axes = match self.system() {
            Some(Reference::Epsg(number)) => axes_of(number),
            _ => None,
        };
        if model == Some(3) || axes == Some(Axes::Geocentric) {
            return Err(geocentric(file, &format!("its coordinate system is {system}")));
        }
        if model == Some(2) || (model.is_none() && geographic.is_some()) || axes == Some(Axes::Degrees) {
            return Err(degrees(file, &format!("its coordinate system is {system}")));
        }
        let file = file.display();
        if self.get(PROJECTED_SYSTEM) == Some(USER_DEFINED) && self.system().is_none() {
            warnings.push(message!(
                "{file}: no EPSG code was found for the coordinate system that the file defines; the place on Earth stays unknown: \
                 give {{crs}}"
            ));
        }
        for (key, known, what) in
            [(PLANE_UNIT, self.plane_unit_m(), "coordinates"), (HEIGHT_UNIT, self.height_unit_m(), "heights")]
        {
            if let Some(unit) = self.get(key).filter(|_| known.is_none()) {
                warnings.push(
                    format!("{file}: the unit of the {what} (EPSG:{unit}) is not known; metres are assumed").into(),
                );
            }
        }
        Ok(Meaning {
            height_unit_m: self.height_unit_m(),
            plane_unit_m: self.plane_unit_m(),
            projected: model == Some(1),
            reference: self.system(),
            ..Meaning::default()
        })
    }
}

/// Returns the length in metres of a unit of the EPSG register.
fn metres(unit: u16) -> Option<f64> {
    Some(match unit {
        9001 => 1.0,
        9002 => FOOT_M,
        9003 => US_FOOT_M,
        // Millimetres, centimetres, kilometres.
        1025 => 0.001,
        1033 => 0.01,
        9036 => 1000.0,
        // Clarke's, Gold Coast, Sears's, British (1936) and Indian feet.
        9005 => 0.304_797_265_4,
        9094 => 0.304_799_710_181_508_8,
        9041 => 0.304_799_471_538_676_2,
        9095 => 0.304_800_749_1,
        9080 => 0.304_799_510_248_146_94,
        // Yards and chains.
        9096 => 0.9144,
        9097 => 20.1168,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meaning(entries: &[[u16; 4]]) -> Result<(Meaning, usize)> {
        let directory: Vec<u16> = [[1, 1, 0, entries.len() as u16]].iter().chain(entries).flatten().copied().collect();
        let mut warnings = Vec::new();
        let found = GeoKeys::read(&directory, &[]).meaning(Path::new("r.tif"), &mut warnings)?;
        Ok((found, warnings.len()))
    }

    /// UTM zone 11 is EPSG:32611 in metres. Survey feet are 1200/3937 m, by their key or by the
    /// number of the system, which is kept. Longitude and latitude and geocentric coordinates are
    /// refused.
    #[test]
    fn projected_systems_pass_and_degrees_are_refused() {
        let (utm, warnings) = meaning(&[[1024, 0, 1, 1], [3072, 0, 1, 32611], [3076, 0, 1, 9001]]).expect("metres");
        assert_eq!((utm.reference, utm.plane_unit_m, warnings), (Some(Reference::Epsg(32611)), Some(1.0), 0));
        for keys in [&[[1024, 0, 1, 1], [3072, 0, 1, 2225], [3076, 0, 1, 9003]][..], &[[3072, 0, 1, 2225]]] {
            let (feet, warnings) = meaning(keys).expect("feet");
            assert_eq!((feet.reference, feet.plane_unit_m), (Some(Reference::Epsg(2225)), Some(1200.0 / 3937.0)));
            assert_eq!((feet.height_unit_m, warnings), (None, 0));
        }
        let message = meaning(&[[1024, 0, 1, 2], [2048, 0, 1, 4326]]).expect_err("degrees").to_string();
        assert!(message.contains("EPSG:4326") && message.contains("reproject it to metres"), "{message}");
        let message = meaning(&[[1024, 0, 1, 3], [2048, 0, 1, 4978]]).expect_err("geocentric").to_string();
        assert!(message.contains("geocentric") && message.contains("reproject it to metres"), "{message}");
    }

    /// Heights are in feet by their unit (0.3048 m) or by their system (EPSG:6360: 1200/3937 m;
    /// EPSG:5703: 1 m); otherwise their unit is unknown.
    #[test]
    fn unit_of_heights_follows_from_key_or_system() {
        for (keys, unit) in [
            (&[[4099, 0, 1, 9002]][..], Some(0.3048)),
            (&[[4096, 0, 1, 6360]], Some(1200.0 / 3937.0)),
            (&[[4096, 0, 1, 5703]], Some(1.0)),
            (&[[4096, 0, 1, 5103], [4099, 0, 1, 9003]], Some(1200.0 / 3937.0)),
            (&[[3072, 0, 1, 2225]], None),
        ] {
            assert_eq!(meaning(keys).expect("heights").0.height_unit_m, unit, "{keys:?}");
        }
    }

    /// A system without a number is found by its parameters: NAD83 with the Lambert cone of Long
    /// Island in US feet is EPSG:2263. An unregistered system gets a warning.
    #[test]
    fn parameters_find_the_epsg_code() {
        let doubles = [40.666_666_666_7, 41.033_333_333_3, -74.0, 40.166_666_666_7, 984_250.0, 0.0];
        let keys = |first: u16| {
            let mut keys =
                vec![1, 1, 0, 11, 1024, 0, 1, 1, 2048, 0, 1, 4269, 3072, 0, 1, 32767, 3075, 0, 1, 8, 3076, 0, 1, 9003];
            for (i, key) in [first, 3079, 3084, 3085, 3086, 3087].into_iter().enumerate() {
                keys.extend([key, 34736, 1, i as u16]);
            }
            keys
        };
        let mut warnings = Vec::new();
        let found = GeoKeys::read(&keys(3078), &doubles).meaning(Path::new("r.tif"), &mut warnings).expect("read");
        assert_eq!((found.reference, warnings.len()), (Some(Reference::Epsg(2263)), 0));
        let found = GeoKeys::read(&keys(3999), &doubles).meaning(Path::new("r.tif"), &mut warnings).expect("read");
        assert_eq!((found.reference, found.plane_unit_m, warnings.len()), (None, Some(1200.0 / 3937.0), 1));
    }

    /// A user-defined unit of 0.5 m is read from the tag of floating-point numbers.
    #[test]
    fn a_user_defined_unit_is_read() {
        let directory = [1, 1, 0, 2, 3076, 0, 1, 32767, 3077, 34736, 1, 1];
        let keys = GeoKeys::read(&directory, &[7.0, 0.5]);
        assert_eq!(keys.meaning(Path::new("r.tif"), &mut Vec::new()).expect("read").plane_unit_m, Some(0.5));
    }

    /// Directories of 0 to 9 numbers are read without keys; nothing panics.
    #[test]
    fn short_directories_hold_no_keys() {
        for length in 0..10 {
            assert_eq!(GeoKeys::read(&vec![1; length], &[]).codes.len(), 0);
        }
    }
}
