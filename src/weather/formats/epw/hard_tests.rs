//! Hard cases of weather files: gaps, impossible values, clocks that are wrong, high latitudes.
//! They belong to the tests of [`super`].

use std::path::Path;

use crate::findings::Finding;
use crate::formats::epw::tests::{HEADER, file, hours, read, row};
use crate::series::Weather;
use heliotile_core::error::Result;
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::sun::Location;

/// Columns of GHI, DNI, DHI.
const LIGHT: [usize; 3] = [13, 14, 15];

/// Reads the year of Golden with its header edited and columns overwritten.
fn golden(from: &str, to: &str, columns: &[(usize, &str)]) -> Result<Weather> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/weather/golden_tmy3.epw");
    let text = String::from_utf8_lossy(&std::fs::read(path).expect("data")).replacen(from, to, 1);
    let lines = text.lines().enumerate().map(|(i, line)| {
        let mut cells: Vec<&str> = line.split(',').collect();
        for (column, value) in columns.iter().filter(|_| i >= 8) {
            cells[*column] = value;
        }
        cells.join(",") + "\n"
    });
    file(&lines.collect::<String>())
}

fn sum(weather: &Weather, value: impl Fn(&heliotile_core::weather::row::WeatherRow) -> f64) -> f64 {
    weather.rows.iter().map(value).sum::<f64>() / 1000.0
}

/// Missing DHI is GHI - DNI cos z and missing DNI (GHI - DHI) / cos z with the hour's mean cosine.
/// GHI alone is split so that it closes, to 0.5 W/m2. At night DNI is 0. Without GHI a missing
/// value, 9999 or an empty cell, is 0. Hours are counted by kind, 2, 1, 1, 1 and 0 at night, and
/// the first line of each is named.
#[test]
fn missing_light_is_computed_from_the_rest() {
    let rows = [
        row([2018, 6, 1, 12, 0], "9999,700,100"),
        row([2018, 6, 1, 13, 0], "700,9999,100"),
        row([2018, 6, 1, 14, 0], "700,600,9999"),
        row([2018, 6, 1, 15, 0], "700,9999,9999"),
        row([2018, 6, 1, 16, 0], "9999,,50"),
        row([2018, 6, 1, 17, 0], "700,9999.9,100"),
    ];
    let w = read(&rows.concat()).expect("valid");
    assert_eq!((w.rows[0].dni_w_m2, w.rows[0].dhi_w_m2), (700.0, 100.0));
    for i in [1, 2, 3, 5] {
        let r = &w.rows[i];
        let suns = w.site.sunlit(&r.interval, r.sun.into(), 30);
        let cosine = suns.iter().map(|s| s.z).sum::<f64>() / 30.0;
        assert!((r.dhi_w_m2 + r.dni_w_m2 * cosine - 700.0).abs() < 0.5, "{i}");
    }
    assert_eq!((w.rows[1].dhi_w_m2, w.rows[2].dni_w_m2), (100.0, 600.0));
    assert!(w.rows[3].dni_w_m2 > 300.0 && w.rows[3].dhi_w_m2 > 100.0, "{:?}", w.rows[3]);
    assert_eq!((w.rows[4].dni_w_m2, w.rows[4].dhi_w_m2), (0.0, 50.0));
    let text = w.report.told();
    for part in [
        "line 10 and on: missing DNI of 2 hours computed",
        "line 11 and on: missing DHI of 1 hours computed",
        "line 12 and on: missing DNI and DHI of 1 hours estimated",
        "line 13 and on: DNI or DHI of 1 hours is missing and so is GHI",
    ] {
        assert!(text.contains(part), "{text}");
    }
    let night = read(&row([2018, 6, 1, 3, 0], "12,9999,5")).expect("valid");
    assert_eq!((night.rows[0].dni_w_m2, night.rows[0].dhi_w_m2), (0.0, 0.0));
    assert_eq!(night.report.warnings.len(), 2, "that it is no year, and the offset at night");
    // A given DNI is kept, however low the sun.
    let sunrise = read(&row([2018, 6, 1, 5, 0], "9,20,9999")).expect("valid").rows[0];
    assert!(sunrise.dni_w_m2 == 20.0 && sunrise.dhi_w_m2 > 8.0 && sunrise.dhi_w_m2 < 9.0, "{sunrise:?}");
}

/// A year without DNI, DHI or both gives the sums of DNI and DHI of the whole file: to 0.6 %
/// computed from the two others, to 3 % and 0.3 % from GHI alone, with single hours of DNI off by
/// 65 W/m2 in the mean. A year without any of the three is refused.
#[test]
fn missing_columns_keep_the_sums_of_a_year() {
    let [ghi, dni, dhi] = LIGHT.map(|column| (column, "9999"));
    let whole = golden("", "", &[]).expect("valid");
    assert!(whole.report.warnings.is_empty(), "{:?}", whole.report.warnings);
    let sums = |w: &Weather| [sum(w, |r| r.dni_w_m2), sum(w, |r| r.dhi_w_m2)];
    let [all_dni, all_dhi] = sums(&whole);
    for (columns, kind, dni_within, dhi_within) in [
        (&[dni][..], Finding::ComputedDni, 0.006, 0.006),
        (&[dhi], Finding::ComputedDhi, 0.006, 0.006),
        (&[dni, dhi], Finding::SplitGhi, 0.03, 0.003),
    ] {
        let w = golden("", "", columns).expect("valid");
        let [sum_dni, sum_dhi] = sums(&w);
        let off = (sum_dni / all_dni - 1.0, sum_dhi / all_dhi - 1.0);
        assert!(off.0.abs() < dni_within && off.1.abs() < dhi_within, "{kind:?}: {off:?}");
        let tally = w.report.findings.of(kind);
        assert_eq!((tally.hours, w.report.warnings.len()), (4764.0, 1), "the hours with sun");
        if kind == Finding::SplitGhi {
            let sunny = || w.rows.iter().zip(&whole.rows).filter(|(_, r)| r.dni_w_m2 > 0.0);
            let mean = sunny().map(|(a, b)| (a.dni_w_m2 - b.dni_w_m2).abs()).sum::<f64>() / sunny().count() as f64;
            assert!((mean - 65.0).abs() < 1.0, "{mean}");
        }
    }
    let text = golden("", "", &[ghi, dni, dhi]).expect_err("no light").to_string();
    assert!(text.contains("line 16: no row holds light; DNI or DHI of 4764 hours is missing"), "{text}");
}

/// Pyranometers that read -2 W/m2 in five hours of the night count as 0 there, and a warning gives
/// the hours. -31 and -999 are refused, not guessed.
#[test]
fn small_negative_values_count_as_0() {
    let rows: String =
        (1..=24).map(|h| row([2019, 5, 1, h, 0], if h < 6 { "-2,-0.00,-1" } else { "50,10,45" })).collect();
    let w = read(&rows).expect("valid");
    assert_eq!(w.report.findings.of(Finding::Negative).hours, 5.0);
    assert!(w.rows.iter().all(|r| r.dhi_w_m2 >= 0.0 && r.ghi_w_m2 >= Some(0.0)));
    for light in ["-31,0,0", "0,-999,0", "0,0,-9999"] {
        assert!(read(&row([2019, 5, 1, 1, 0], light)).is_err(), "{light}");
    }
}

/// 1400 W/m2 at noon and 300 W/m2 in an hour of which the sun is up for two minutes are used
/// unchanged and counted, 2 hours of 1.7 kWh/m2. DHI of 60 under a GHI of 50 is counted once, and
/// of 54 not.
#[test]
fn impossible_values_are_used_and_counted() {
    // At 45 N, 8 E the sun sets at 17:02 of zone 1 (without refraction).
    let day: String = (1..=24)
        .map(|h| match h {
            12 => row([2019, 11, 7, h, 0], "560,1400,50"),
            13 => row([2019, 11, 7, h, 0], "50,0,60"),
            14 => row([2019, 11, 7, h, 0], "50,0,54"),
            18 => row([2019, 11, 7, h, 0], "1,300,1"),
            _ => row([2019, 11, 7, h, 0], "0,0,0"),
        })
        .collect();
    let w = read(&day).expect("valid");
    let last = w.rows[17];
    let lit = w.site.sunlit_hours(&last.interval, last.sun.into());
    assert!(lit > 0.0 && lit < 0.1, "{lit}");
    let tally = w.report.findings.of(Finding::AboveExtraterrestrial);
    assert_eq!((tally.rows, tally.first_line), (2, 20));
    assert!((tally.kwh_m2 - 1.7).abs() < 1e-12);
    assert_eq!((w.rows[11].dni_w_m2, last.dni_w_m2), (1400.0, 300.0));
    assert_eq!(w.report.findings.of(Finding::DhiAboveGhi).rows, 1);
}

/// Albedo 0.15 is kept; 0 and 999 mean missing, and 20 (percent) is not guessed. Snow of 0 and 12
/// cm is kept, 999 is missing.
#[test]
fn codes_for_missing_albedo_and_snow_are_missing() {
    for (cells, albedo, snow) in [
        (",0,999,0.15,", Some(0.15), Some(0.0)),
        (",12,1,1,", Some(1.0), Some(12.0)),
        (",999,999,0,", None, None),
        (",999.0,999,999.00,", None, None),
        (",-1,999,20,", None, None),
    ] {
        let text = row([2019, 5, 1, 1, 0], "0,0,0").replace(",999,1,999,", cells);
        let r = read(&text).expect("valid").rows[0];
        assert_eq!((r.albedo, r.snow_depth_cm), (albedo, snow), "{cells}");
    }
}

/// In the polar night (70 N, 21 December) 24 hours of DNI 10 have no suns: they are counted as 24
/// hours and 0.24 kWh/m2.
#[test]
fn dni_in_the_polar_night_is_counted() {
    let text = HEADER.replace("45.0,8.0,1.0", "70.0,25.0,1.0");
    let rows = hours(&[(2019, 12, 21)], "5,10,5");
    let w = file(&format!("{text}DATA PERIODS,1,1\n{rows}")).expect("valid");
    let lost = w.report.findings.of(Finding::BelowHorizon);
    assert_eq!(lost.hours, 24.0);
    assert!((lost.kwh_m2 - 0.24).abs() < 1e-12);
    assert_eq!(w.report.warnings.len(), 3, "the cut, the lost energy and the offset at night");
    assert!(w.conditions(3).iter().all(|c| c.suns.is_empty() && c.sky_sun.is_finite()));
}

/// Zones of 5.5, 5.75 and -3.5 h are not rounded. At the equinox the sun, turned to the true noon
/// that longitude and the equation of time (-7.4 min) give, stands in the meridian to 0.3 deg, in
/// the south; at Marion Island, 46.9 S, in the north.
#[test]
fn zones_of_half_hours_are_not_rounded() {
    for (place, longitude, zone, north) in [
        ("28.6,77.2,5.5", 77.2, 5.5, false),
        ("27.7,85.3,5.75", 85.3, 5.75, false),
        ("47.6,-52.7,-3.5", -52.7, -3.5, false),
        ("-46.9,37.8,3.0", 37.8, 3.0, true),
    ] {
        let text = HEADER.replace("45.0,8.0,1.0", place);
        let rows = hours(&[(2019, 3, 21)], "5,0,5");
        let w = file(&format!("{text}DATA PERIODS,1,1\n{rows}")).expect("valid");
        let noon_min = 720.0 + 60.0 * zone - 4.0 * longitude + 7.4;
        let noon = w.site.turned(w.rows[12].sun, noon_min - 750.0);
        assert!(noon.x.abs() < 0.005 && (noon.y > 0.0) == north, "{place}: {noon}");
    }
}

/// Months of a typical year use the sun of their own year. The sun of 1 March 2003 stands 0.28 deg
/// of declination south of that of 1 March 2000, which leap days alone explain (0.75 days of 0.38
/// deg). A file with the two years keeps them apart.
#[test]
fn typical_months_use_the_sun_of_their_own_year() {
    let rows = hours(&[(2000, 2, 29), (2003, 3, 1)], "0,0,0");
    let noon = |rows: &str| read(rows).expect("valid").rows[36].sun.z.asin().to_degrees();
    let change = noon(&rows.replace("2003,", "2000,")) - noon(&rows);
    assert!((change - 0.28).abs() < 0.01, "{change}");
}

/// Sub-steps move light in time and make none: with 1, 2, 4 and 12 steps a row Golden's year keeps
/// all DNI to 1e-9, and the sun on the horizontal to 0.3 %.
#[test]
fn steps_conserve_energy() {
    let w = golden("", "", &[]).expect("valid");
    let all = sum(&w, |r| r.dni_w_m2);
    let sums = [1, 2, 4, 12].map(|steps| {
        let conditions = w.conditions(steps);
        let of = |value: fn(&heliotile_core::weather::conditions::Instant) -> f64| -> f64 {
            conditions.iter().map(|c| c.dni_w_m2 * c.suns.iter().map(value).sum::<f64>()).sum::<f64>() / 1000.0
        };
        let energy = of(|i| i.weight);
        assert!((energy / all - 1.0).abs() < 1e-9, "{steps}: {energy} of {all}");
        of(|i| i.weight * i.sun.z)
    });
    assert!(sums.iter().all(|s| (s / sums[3] - 1.0).abs() < 0.003), "{sums:?}");
}

/// 45 days of rows whose light belongs to a sun 96 min after mid-interval are flagged with that
/// shift to 2 min, and so are rows of a sun an hour before. Rows with the right sun give no warning
/// and an RMSE below 0.1 W/m2.
#[test]
fn wrong_time_stamps_are_found_with_their_shift() {
    let site = Location::new(45.0, 8.0, 1.0, 250.0).expect("a site");
    for (late_min, flagged) in [(0.0, false), (96.0, true), (-60.0, true)] {
        let mut rows = String::new();
        for (month, last) in [(3, 31), (4, 14)] {
            for day in 1..=last {
                let date = Date::new(2018, month, day).expect("a date");
                for hour in 1..=24_u32 {
                    let sun = site.sun(date, f64::from(hour) * 60.0 - 30.0 + late_min);
                    let dni = if sun.z > 0.05 { 700.0 } else { 0.0 };
                    let light = format!("{},{dni},60", 60.0 + dni * sun.z.max(0.0));
                    rows += &row([2018, month, day, hour, 0], &light);
                }
            }
        }
        let report = read(&rows).expect("valid").report;
        let closure = report.closure.expect("enough rows");
        let text = report.told();
        assert_eq!(text.contains("Nothing was shifted"), flagged, "{closure:?} {text}");
        assert!((closure.best_shift_min - late_min).abs() <= 2.0, "{closure:?}");
        assert!(flagged || closure.rmse_w_m2 < 0.1, "{closure:?}");
    }
}

/// Golden with a zone of -6 or 0, or with the longitude's sign lost, is found to be 60, 420 and
/// 598.7 min off (105.18 degrees twice). The last two are also at least 3 h from their meridian.
/// The zone or longitude in the warning closes to 1 W/m2. With the latitude's sign lost, or DHI of
/// 450, nothing fits. The unchanged file has 0.7 W/m2 and no warning.
#[test]
fn wrong_places_are_found_with_a_remedy() {
    let place = "39.74,-105.18,-7.0";
    let good = golden("", "", &[]).expect("valid").report;
    let closure = good.closure.expect("enough rows");
    assert!(closure.rmse_w_m2 < 1.0 && good.warnings.is_empty(), "{closure:?}");
    for (wrong, shift_min, apart, parts) in [
        ("39.74,-105.18,-6.0", 60.0, false, ["a time zone of -7.00", "a longitude of -90.2"]),
        ("39.74,-105.18,0.0", 420.0, true, ["a time zone of -7.00", "and time zone 0 are 7.0 h apart"]),
        ("39.74,105.18,-7.0", 598.7, true, ["a longitude of -105.1", "longitude 105.18 and"]),
    ] {
        let report = golden(place, wrong, &[]).expect("valid").report;
        let text = report.told();
        let closure = report.closure.expect("enough rows");
        assert_eq!(closure.best_shift_min, shift_min, "{text}");
        assert!(closure.best_rmse_w_m2 < 1.0 && parts.iter().all(|part| text.contains(part)), "{text}");
        assert_eq!(text.contains("h apart"), apart, "{text}");
    }
    let flipped = golden(place, "-39.74,-105.18,-7.0", &[]).expect("valid").report.told();
    assert!(flipped.contains("does not hold: 214") && flipped.contains("Latitude"), "{flipped}");
    let columns = golden("", "", &[(LIGHT[2], "450")]).expect("valid").report.told();
    assert!(columns.contains("does not hold") && columns.contains("DHI above GHI"), "{columns}");
}
