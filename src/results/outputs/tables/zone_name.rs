//! Name of a time zone in a column's type. In: an offset from UTC. Out: the offset itself, or a
//! name of the time zone database.
//!
//! Arrow and Parquet's Arrow schema allow both. pandas reads every offset. Polars 1 and 2 read
//! whole hours only and panic at others, such as `+05:30`, but know all names. Offsets that are not
//! whole hours therefore get the name of a zone that has had this offset without daylight saving
//! time ever since. If there is none, as for `-03:30`, the offset stands.

use heliotile_core::weather::time::utc_offset::UtcOffset;

/// Offset in minutes, name, and the beginning of the time since which the zone has had it without a
/// break, local seconds since 1970: the first 1 January after its last change in the IANA time zone
/// database (files `asia`, `australasia`).
const NAMED: [(i32, &str, i64); 7] = [
    (-570, "Pacific/Marquesas", -1_798_761_600), // 1913
    (210, "Asia/Tehran", 1_672_531_200),         // 2023
    (270, "Asia/Kabul", -757_382_400),           // 1946
    (330, "Asia/Kolkata", -757_382_400),         // 1946
    (345, "Asia/Kathmandu", 536_457_600),        // 1987
    (390, "Asia/Yangon", -757_382_400),          // 1946
    (570, "Australia/Darwin", -788_918_400),     // 1945
];

/// Returns the zone for instants from `first_s` on, seconds since 1970-01-01 00:00 UTC.
pub fn of(offset: UtcOffset, first_s: i64) -> String {
    let fits = |(minutes, _, since): &&(i32, &str, i64)| {
        *minutes == offset.minutes() && *since <= first_s + 60 * i64::from(*minutes)
    };
    NAMED.iter().find(fits).map_or_else(|| offset.to_string(), |(_, name, _)| (*name).to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whole hours, and offsets that no zone keeps, stand as they are; 7 others have a name, from
    /// the year on in which the zone has them for good.
    #[test]
    fn offsets_get_the_name_of_a_zone_that_keeps_them() {
        let name = |hours: f64, first_s: i64| of(UtcOffset::of_hours(hours), first_s);
        for hours in [0.0, 1.0, -7.0, 10.0, 3.5, -3.5, 12.75] {
            assert_eq!(name(hours, 0), UtcOffset::of_hours(hours).to_string());
        }
        for (hours, expected) in [(5.5, "Asia/Kolkata"), (9.5, "Australia/Darwin"), (6.5, "Asia/Yangon")] {
            assert_eq!(name(hours, 0), expected);
        }
        assert_eq!((name(4.5, 0).as_str(), name(3.5, 1_672_518_600).as_str()), ("Asia/Kabul", "Asia/Tehran"));
        assert_eq!(name(-9.5, 0), "Pacific/Marquesas");
        // Instants are a midnight of the clock, and a second before; Nepal was at 05:30 until 1985.
        assert_eq!((name(5.75, 536_436_900).as_str(), name(5.75, 536_436_899).as_str()), ("Asia/Kathmandu", "+05:45"));
    }
}
