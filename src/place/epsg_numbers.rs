//! Numbers of the EPSG register that the crate of definitions lacks or does not tell apart. In: a
//! number. Out: the kind of the system, its horizontal part, or the unit of its heights. All lists
//! come from version 11.022 of the register (2024), read with pyproj 3.7.2 (`query_crs_info`).

/// Ranges (first and last number) of compound systems, and the horizontal part of the first; the
/// others have the numbers that follow.
const COMPOUND: [(u32, u32, u32); 21] = [
    (5554, 5556, 25831),
    (5698, 5698, 2154),
    (5845, 5845, 3006),
    (5971, 5973, 25831),
    (6190, 6190, 31370),
    (7405, 7405, 27700),
    (7415, 7415, 28992),
    (9715, 9715, 3159),
    (9897, 9897, 2169),
    (9920, 9920, 27700),
    (9922, 9922, 2157),
    (9928, 9931, 5682),
    (9932, 9935, 5682),
    (9951, 9951, 3057),
    (9952, 9952, 5325),
    (9953, 9953, 8088),
    (10162, 10174, 6669),
    (10246, 10246, 3794),
    (10633, 10633, 5490),
    (10660, 10660, 23700),
    (10687, 10687, 3794),
];

/// Ranges of geographic systems, and of compound ones with a geographic part, that the crate of
/// definitions lacks: the first and the last number of each in turn.
const GEOGRAPHIC: [u32; 262] = [
    8694, 8694, 8698, 8699, 8888, 8888, 8916, 8916, 8918, 8918, 8920, 8920, 8922, 8922, 8924, 8924, 8926, 8926, 8928,
    8928, 8930, 8930, 8932, 8932, 8934, 8934, 8936, 8936, 8938, 8938, 8940, 8940, 8942, 8942, 8944, 8944, 8946, 8946,
    8948, 8949, 8972, 8987, 9053, 9057, 9059, 9069, 9071, 9072, 9074, 9075, 9139, 9140, 9147, 9148, 9152, 9153, 9183,
    9184, 9248, 9248, 9251, 9251, 9253, 9253, 9267, 9267, 9286, 9286, 9289, 9290, 9293, 9294, 9299, 9299, 9308, 9309,
    9332, 9333, 9364, 9364, 9372, 9372, 9379, 9380, 9384, 9384, 9403, 9403, 9422, 9430, 9449, 9450, 9452, 9453, 9462,
    9464, 9469, 9470, 9474, 9475, 9500, 9544, 9546, 9547, 9656, 9657, 9695, 9696, 9701, 9702, 9705, 9705, 9707, 9707,
    9723, 9725, 9739, 9739, 9754, 9755, 9758, 9758, 9763, 9763, 9776, 9779, 9781, 9785, 9866, 9866, 9871, 9871, 9883,
    9883, 9893, 9893, 9907, 9907, 9924, 9924, 9939, 9939, 9948, 9950, 9964, 9964, 9969, 9969, 9974, 9974, 9989, 9990,
    10156, 10158, 10175, 10175, 10177, 10178, 10185, 10185, 10191, 10191, 10196, 10196, 10204, 10204, 10209, 10209,
    10214, 10214, 10219, 10219, 10224, 10224, 10229, 10229, 10237, 10237, 10245, 10245, 10249, 10249, 10252, 10252,
    10256, 10256, 10260, 10260, 10265, 10265, 10268, 10268, 10272, 10272, 10277, 10277, 10283, 10284, 10293, 10293,
    10298, 10300, 10304, 10305, 10307, 10307, 10309, 10312, 10318, 10318, 10327, 10328, 10345, 10346, 10355, 10357,
    10365, 10365, 10413, 10414, 10468, 10468, 10474, 10475, 10486, 10488, 10507, 10507, 10545, 10545, 10553, 10556,
    10570, 10571, 10605, 10606, 10623, 10623, 10628, 10628, 10651, 10652, 10659, 10659, 10670, 10673, 10679, 10679,
    10686, 10686, 20001, 20001, 20033, 20033, 20037, 20038, 20040, 20041, 20043, 20043, 20045, 20046,
];

/// Geocentric systems that the crate of definitions lacks.
const GEOCENTRIC: [u32; 51] = [
    8697, 8915, 8917, 8919, 8921, 8923, 8925, 8927, 8929, 8931, 8933, 8935, 8937, 8939, 8941, 8943, 8945, 8947, 9070,
    9073, 9138, 9146, 9151, 9182, 9266, 9292, 9307, 9331, 9378, 9468, 9545, 9694, 9700, 9753, 9775, 9780, 9892, 9988,
    10176, 10282, 10297, 10303, 10308, 10326, 10412, 10473, 10569, 10604, 10669, 20039, 20044,
];

/// Vertical systems in international feet, and vertical systems in US survey feet.
const HEIGHTS_IN_FEET: [u32; 8] = [5614, 6130, 6131, 6132, 8050, 8051, 8228, 8897];
const HEIGHTS_IN_US_FEET: [u32; 6] = [5702, 6358, 6359, 6360, 8052, 8053];

/// International foot, metres.
pub const FOOT_M: f64 = 0.3048;
/// US survey foot, metres.
pub const US_FOOT_M: f64 = 1200.0 / 3937.0;

/// Kind of the coordinates of a reference system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    /// Longitude and latitude.
    Degrees,
    /// Metres from the Earth's centre.
    Geocentric,
    /// Lengths in a plane.
    Plane,
}

/// Returns the horizontal part of a compound system, or `epsg` itself if the system is not
/// compound.
pub fn horizontal_part(epsg: u32) -> u32 {
    let found = COMPOUND.iter().find(|(first, last, _)| (*first..=*last).contains(&epsg));
    found.map_or(epsg, |(first, _, part)| part + epsg - first)
}

/// Returns the kind of a system's coordinates; `None` for numbers that are not known here.
pub fn axes_of(epsg: u32) -> Option<Axes> {
    if GEOGRAPHIC.chunks_exact(2).any(|range| matches!(range, [first, last] if (*first..=*last).contains(&epsg))) {
        return Some(Axes::Degrees);
    }
    if GEOCENTRIC.contains(&epsg) {
        return Some(Axes::Geocentric);
    }
    let definition = crs_definitions::from_code(u16::try_from(horizontal_part(epsg)).ok()?)?;
    let projection = definition.proj4.split_whitespace().find_map(|word| word.strip_prefix("+proj="));
    projection.map(|name| match name {
        "longlat" => Axes::Degrees,
        "geocent" => Axes::Geocentric,
        _ => Axes::Plane,
    })
}

/// Returns the metres a unit of the heights of a vertical system; `None` if the number states no
/// unit.
pub fn height_unit_m(epsg: u32) -> Option<f64> {
    match epsg {
        _ if HEIGHTS_IN_FEET.contains(&epsg) => Some(FOOT_M),
        _ if HEIGHTS_IN_US_FEET.contains(&epsg) => Some(US_FOOT_M),
        // Heights above Poolbeg, feet of Britain of 1936.
        5754 => Some(0.304_800_749_1),
        // Numbers of GeoTIFF 1.0 (5001 to 5106) state a surface and no unit; all other vertical
        // systems are in metres.
        1024..=5000 | 5107..=32_766 => Some(1.0),
        _ => None,
    }
}

/// Returns the EPSG numbers that a text names, the horizontal one first. It reads
/// `https://www.opengis.net/def/crs/EPSG/0/7415`, `urn:ogc:def:crs:EPSG::7415`, `EPSG:7415`,
/// `EPSG:25832+5783` and `urn:ogc:def:crs,crs:EPSG::28992,crs:EPSG::5709`.
pub fn epsg_numbers_in(text: &str) -> Vec<u32> {
    let upper = text.to_ascii_uppercase();
    let behind = upper.find("EPSG").and_then(|at| upper.get(at..)).unwrap_or_default();
    let number = |part: &str| part.split(['/', ':', '#', '=']).rfind(|word| !word.is_empty())?.parse().ok();
    behind.split([',', '&', '+', '?']).filter_map(number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fourteen numbers are known as degrees (8), geocentric (4) or plane (2); one is not known.
    #[test]
    fn epsg_numbers_state_degrees_or_metres() {
        for (axes, numbers) in [
            (Some(Axes::Degrees), &[4326, 4979, 4258, 6697, 6668, 9518, 9707, 10158][..]),
            (Some(Axes::Geocentric), &[4978, 4936, 7789, 20044]),
            (Some(Axes::Plane), &[28992, 10162]),
            (None, &[70_000]),
        ] {
            numbers.iter().for_each(|number| assert_eq!(axes_of(*number), axes, "{number}"));
        }
    }

    /// Heights of NAVD88 are metres (5703), US feet (6360) or feet (8228); a surface of GeoTIFF 1.0
    /// has no unit.
    #[test]
    fn epsg_numbers_state_the_unit_of_heights() {
        assert_eq!([5703, 6360, 8228].map(height_unit_m), [Some(1.0), Some(1200.0 / 3937.0), Some(0.3048)]);
        assert_eq!((height_unit_m(5103), height_unit_m(32_767)), (None, None));
        assert_eq!((horizontal_part(10_162), horizontal_part(28_992)), (6669, 28_992));
    }
}
