//! Tests of [`super`].

use std::path::Path;

use crate::formats::epw::parse_epw;
use crate::series::Weather;
use heliotile_core::error::Result;
use heliotile_core::weather::time::calendar::Date;

pub(super) const HEADER: &str = "LOCATION,Town,S,Country,X,0,45.0,8.0,1.0,250\nDESIGN CONDITIONS,0\nTYPICAL/EXTREME PERIODS,0\n\
                      GROUND TEMPERATURES,0\nHOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0\nCOMMENTS 1,\nCOMMENTS 2,\n";

/// Returns a data row with 35 columns; `light` is GHI, DNI, DHI.
pub(super) fn row(clock: [u32; 5], light: &str) -> String {
    let clock = clock.map(|n| n.to_string()).join(",");
    format!("{clock},?9,1,1,1,1,1,1,1,{light},1,1,1,1,1,1,1,1,1,1,1,1,1,1,999,1,999,1,1\n")
}

pub(super) fn read(rows: &str) -> Result<Weather> {
    file(&format!("{HEADER}DATA PERIODS,1,1,Data,Sunday,1/1,12/31\n{rows}"))
}

pub(super) fn file(text: &str) -> Result<Weather> {
    parse_epw(Path::new("w.epw"), text.as_bytes())
}

pub(super) fn hours(days: &[(u32, u32, u32)], light: &str) -> String {
    let rows = days.iter().flat_map(|&(y, m, d)| (1..=24).map(move |h| row([y, m, d, h, 0], light)));
    rows.collect()
}

/// A cut of a TMY3 file has 72 rows of March at 39.74 N, UTC-7. Noon of 20 March has the file's
/// numbers. All albedos are above 0.1, and there is one warning. Closure is below 3 W/m2 RMSE at
/// mid-interval and best there.
#[test]
fn a_cut_of_a_typical_year_reads_as_stated() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/weather/golden_3_days.epw");
    let w = parse_epw(&path, &std::fs::read(&path).expect("data")).expect("valid");
    assert_eq!((w.rows.len(), w.interval_hours), (72, 1.0));
    assert_eq!((w.site.latitude_deg, w.site.zone_hours), (39.74, -7.0));
    assert_eq!(w.place, "Denver Centennial  Golden   Nr, USA");
    // Three days are no year, which is the only warning.
    assert_eq!(w.report.warnings.len(), 1);
    assert!(w.report.warnings[0].contains("holds 72 of the 8760 hours"), "{:?}", w.report.warnings);
    assert!(w.rows.iter().all(|r| r.albedo.is_some_and(|a| a > 0.1) && r.snow_depth_cm == Some(0.0)));
    let closure = w.report.closure.expect("enough rows");
    assert!(closure.rmse_w_m2 < 3.0 && closure.best_shift_min == 0.0, "{closure:?}");
    let conditions = w.conditions(4);
    assert_eq!(conditions[0].label, format!("{}-03-20T00:00", w.rows[0].interval.date.year));
    let noon = &conditions[12];
    let horizontal: f64 = noon.suns.iter().map(|i| i.weight * i.sun.z).sum();
    let ghi = noon.dhi_w_m2 + noon.dni_w_m2 * horizontal;
    assert!((ghi - w.rows[12].ghi_w_m2.expect("given")).abs() < 3.0, "{ghi}");
    let days: Vec<u32> = conditions.iter().filter_map(|c| c.stamp.map(|s| s.date.day)).collect();
    assert_eq!((days[23], days[24]), (20, 21));
}

/// A file of the year 0, with words behind its elevation and GHI of -99, is read: 24 hours of 2017
/// at 250 m with DNI of 10 W/m2, and one sentence about the year.
#[test]
fn files_that_energyplus_accepts_are_read() {
    let header = HEADER.replace("1.0,250", "1.0,250.0  Morphed:TAS|DWPT");
    let rows: String = (1..=24).map(|hour| row([0, 6, 1, hour, 0], "-99,10,5")).collect();
    let weather = file(&format!("{header}DATA PERIODS,1,1,Data,Sunday,1/1,12/31\n{rows}")).expect("valid");
    assert_eq!((weather.rows.len(), weather.site.elevation_m), (24, 250.0));
    assert!(
        weather
            .rows
            .iter()
            .all(|row| row.ghi_w_m2.is_none() && row.dni_w_m2 == 10.0 && (row.dhi_w_m2 == 5.0 || row.sun.z < -0.1))
    );
    assert_eq!(weather.rows[0].interval.label(), "2017-06-01T00:00");
    let said = weather.report.warnings.iter().filter(|warning| warning.contains("24 rows state the year 0")).count();
    assert_eq!(said, 1, "{:?}", weather.report.warnings);
}

/// Hour 24 ends its own day: it starts at 23:00, and minute 60 means the same as minute 0.
#[test]
fn hour_24_ends_its_own_day() {
    for minute in [0, 60] {
        let day: String = (1..=24).map(|h| row([2017, 12, 31, h, minute], "0,0,0")).collect();
        let w = read(&day).expect("valid");
        let c = w.conditions(1);
        assert_eq!((c.len(), c[23].label.as_str()), (24, "2017-12-31T23:00"));
    }
}

/// 29 February is read in a leap year and may be absent; 2007-02-29 does not exist. Months of
/// different years follow on.
#[test]
fn leap_days_are_read_in_leap_years_only() {
    for days in [
        [(2016, 2, 28), (2016, 2, 29), (2016, 3, 1)],
        [(2016, 2, 27), (2016, 2, 28), (2016, 3, 1)],
        [(2008, 2, 27), (2008, 2, 28), (2013, 3, 1)],
        [(2016, 12, 30), (2016, 12, 31), (2018, 1, 1)],
    ] {
        assert_eq!(read(&hours(&days, "0,0,0")).expect("valid").rows.len(), 72);
    }
    let text = read(&hours(&[(2007, 2, 29)], "0,0,0")).expect_err("no such day").to_string();
    assert!(text.contains("line 9: the date 2007-2-29 does not exist"), "{text}");
}

/// A quarter-hourly file gives 96 intervals of 0.25 h a day, the first from 00:00, the last from
/// 23:45. A missing quarter, labels of the start and 7 records an hour are refused.
#[test]
fn quarter_hourly_files_have_96_intervals_a_day() {
    let quarters: Vec<String> =
        (1..=24).flat_map(|h| [15, 30, 45, 60].map(|m| row([2019, 5, 1, h, m], "0,0,0"))).collect();
    let header = format!("{HEADER}DATA PERIODS,1,4,Data\n");
    let w = file(&format!("{header}{}", quarters.concat())).expect("valid");
    let c = w.conditions(1);
    assert_eq!((c.len(), w.interval_hours), (96, 0.25));
    assert_eq!((c[0].label.as_str(), c[95].label.as_str()), ("2019-05-01T00:00", "2019-05-01T23:45"));
    let holed = [&quarters[..10], &quarters[11..]].concat().concat();
    let text = file(&format!("{header}{holed}")).expect_err("a hole").to_string();
    assert!(text.contains("line 19: the row starts at 2019-05-01T02:45"), "{text}");
    let text = file(&format!("{HEADER}DATA PERIODS,1,7\n")).expect_err("7").to_string();
    assert!(text.contains("divisors of 60"), "{text}");
    let starts: Vec<String> = [0, 15, 30, 45].map(|m| row([2019, 5, 1, 1, m], "0,0,0")).into();
    let text = file(&format!("{header}{}", starts.concat())).expect_err("labels of the start").to_string();
    assert!(text.contains("line 10") && text.contains("labelled with the end"), "{text}");
    let odd = row([2019, 5, 1, 1, 20], "0,0,0");
    assert!(file(&format!("{header}{odd}")).is_err());
}

/// A gap between January and June is one more period: 48 rows if the header states two, refused if
/// it states one. A year of its second half and then its first half is in order.
#[test]
fn each_stated_period_may_follow_a_gap() {
    let rows = hours(&[(2018, 1, 31), (2018, 6, 1)], "0,0,0");
    let two = file(&format!("{HEADER}DATA PERIODS,2,1,a,Monday,1/31,1/31,b,Friday,6/1,6/1\n{rows}")).expect("valid");
    assert_eq!((two.rows.len(), two.conditions(1)[24].label.as_str()), (48, "2018-06-01T00:00"));
    let text = read(&rows).expect_err("a gap").to_string();
    assert!(text.contains("line 33: the row starts at 2018-06-01T00:00"), "{text}");
    let half = |from, to| {
        let days = (from..=to).flat_map(|month| (1..=31).map(move |day| (2019, month, day)));
        days.filter(|&(_, month, day)| Date::new(2019, month, day).is_some())
    };
    let year: Vec<(u32, u32, u32)> = half(7, 12).chain(half(1, 6)).collect();
    let whole = read(&hours(&year, "0,0,0")).expect("valid");
    assert_eq!((whole.rows.len(), whole.report.warnings.len()), (8760, 0));
}

/// Broken rows and headers are errors that name line and column: 12 cases.
#[test]
fn errors_name_line_and_column() {
    for (rows, expected) in [
        (row([2018, 1, 1, 1, 0], "0,-99,0"), "line 9: column `direct normal radiation` holds `-99`"),
        (row([2018, 1, 1, 1, 0], "0,0,x"), "column `diffuse horizontal radiation` holds `x`"),
        (row([2018, 1, 1, 1, 0], "NaN,0,0"), "column `global horizontal radiation` holds `NaN`"),
        (row([2018, 1, 1, 25, 0], "0,0,0"), "column `hour` holds `25`"),
        (row([2018, 1, 1, 0, 0], "0,0,0"), "column `hour` holds `0`"),
        (row([0, 2, 30, 1, 0], "0,0,0"), "the date 0-2-30 does not exist"),
        (row([4_000_000_000, 1, 1, 1, 0], "0,0,0"), "does not exist"),
        (row([2018, 13, 1, 1, 0], "0,0,0"), "the date 2018-13-1 does not exist"),
        ("a,b\n".to_string(), "the row has 2 columns instead of 35"),
        (row([2018, 1, 1, 1, 0], "0,0,0") + "2018,1,1,2,0,?", "line 10: the row has 6 columns instead of 35"),
        (row([2018, 1, 1, 1, 0], "0,0,0").repeat(2), "line 10: the row starts at 2018-01-01T00:00"),
        (String::new(), "the file has no weather rows"),
    ] {
        let text = read(&rows).expect_err(expected).to_string();
        assert!(text.starts_with("w.epw") && text.contains(expected), "{text}");
    }
    for (text, expected) in [
        ("", "does not start with LOCATION"),
        ("LOCATION,a,b\n", "latitude of LOCATION holds ``"),
        ("LOCATION,a,b,c,d,e,95,8,1,0\n", "latitude is 95"),
        (HEADER, "DATA PERIODS is missing"),
    ] {
        let text = file(text).expect_err(expected).to_string();
        assert!(text.contains(expected), "{text}");
    }
    assert!(parse_epw(Path::new("w.epw"), &[0xff, 0, 10, 13, 200]).is_err());
}
