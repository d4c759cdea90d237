//! Plane systems whose first coordinate is the northing. In: an EPSG number. Out: true if the
//! register has the northing first.

/// First and last EPSG numbers of ranges of systems with the axes north, east. No other plane
/// systems lie within the ranges. Source: version 11.022 of the register (2024), read with pyproj
/// 3.7.2 (`query_crs_info`, `axis_info`). Systems that count south or west are not among them.
#[rustfmt::skip]
const NORTHING_FIRST: [(u32, u32); 96] = [
    (2044, 2045), (2081, 2083), (2093, 2093), (2096, 2098), (2105, 2132), (2169, 2180), (2193, 2193), (2200, 2200), (2206, 2212),
    (2319, 2735), (2738, 2758), (2935, 2941), (2953, 2953), (3006, 3030), (3034, 3035), (3040, 3049), (3058, 3059), (3068, 3068),
    (3114, 3118), (3120, 3120), (3126, 3140), (3152, 3152), (3300, 3301), (3328, 3335), (3346, 3346), (3350, 3352), (3386, 3390),
    (3396, 3399), (3407, 3407), (3414, 3414), (3416, 3416), (3764, 3764), (3788, 3793), (3795, 3796), (3833, 3854), (3873, 3885),
    (4026, 4038), (4417, 4417), (4434, 4434), (4491, 4554), (4568, 4589), (4652, 4822), (4839, 4839), (5048, 5048), (5105, 5188),
    (5253, 5259), (5269, 5275), (5343, 5349), (5367, 5367), (5479, 5481), (5518, 5520), (5562, 5588), (5632, 5639), (5651, 5653),
    (6244, 6275), (6362, 6362), (6372, 6387), (6669, 6687), (6707, 6709), (6870, 6876), (6962, 6962), (7799, 7801), (7825, 7831),
    (8433, 8441), (9039, 9040), (9221, 9254), (9271, 9285), (9377, 9377), (9498, 9498), (9821, 9821), (9831, 9841), (9851, 9865),
    (9895, 9895), (10286, 10286), (10288, 10288), (10290, 10290), (10306, 10306), (10329, 10329), (11114, 11118), (20004, 20032), (20904, 20932),
    (21004, 21032), (21207, 21264), (21307, 21463), (21896, 21899), (22171, 22197), (22240, 22240), (23301, 23333), (25884, 25884), (27205, 27232),
    (27391, 27398), (28404, 28432), (29701, 29702), (30161, 30179), (31251, 31290), (31466, 31469),
];

/// Returns true if the register has the northing first.
pub(super) fn is_northing_first(epsg: u32) -> bool {
    NORTHING_FIRST.iter().any(|(first, last)| (*first..=*last).contains(&epsg))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six of ten systems in use have the northing first: Gauss-Krueger, Poland, Japan, Sweden, and
    /// two of Europe.
    #[test]
    fn six_of_ten_systems_have_the_northing_first() {
        for (epsg, expected) in [
            (31467, true),
            (2180, true),
            (6677, true),
            (3006, true),
            (3035, true),
            (4839, true),
            (5243, false),
            (25832, false),
            (28992, false),
            (2154, false),
        ] {
            assert_eq!(is_northing_first(epsg), expected, "{epsg}");
        }
    }
}
