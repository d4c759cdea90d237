//! Air of a row of a weather file. In: the cells of a row. Out: temperatures, infrared radiation,
//! opaque sky cover and wind, as far as they are there.

use std::path::Path;

use crate::judging::raw_weather::{AIR_C, WIND_M_S};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::weather::air::Air;

/// Index of the column in a data row.
const DRY_BULB: usize = 6;
const DEW_POINT: usize = 7;
const INFRARED: usize = 12;
const OPAQUE_SKY: usize = 23;
const WIND: usize = 21;

const MISSING_RADIATION: f64 = 9999.0;

/// Reads the air from the cells of a line.
pub fn read_air(path: &Path, line: usize, cells: &[&str]) -> Result<Air> {
    let cell = |i: usize| cells.get(i).copied().unwrap_or_default();
    let optional = |i: usize, [low, high]: [f64; 2]| {
        let value = cell(i).parse::<f64>().ok();
        value.filter(|v| (low..=high).contains(v))
    };
    let text = cell(INFRARED);
    let infrared_w_m2 = match text.parse::<f64>() {
        _ if text.is_empty() => None,
        // EnergyPlus computes the radiation for 0, too (its weather converter).
        Ok(value) if value >= MISSING_RADIATION || value == 0.0 => None,
        Ok(value) if value > 0.0 => Some(value),
        _ => {
            let what = format!("column `horizontal infrared radiation` holds `{text}`");
            return Err(Error::input(path, line, what, "write W/m2 above 0, 9999 where missing")
                .because(Problem::value("horizontal infrared radiation", text)));
        }
    };
    Ok(Air {
        dry_bulb_c: optional(DRY_BULB, AIR_C),
        dew_point_c: optional(DEW_POINT, AIR_C),
        infrared_w_m2,
        opaque_sky_tenths: optional(OPAQUE_SKY, [0.0, 10.0]),
        wind_m_s: optional(WIND, WIND_M_S),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::findings::Finding;
    use crate::formats::epw::{parse_epw, parse_epw_with_air};

    /// Reads a row with cells for temperatures, infrared radiation and opaque sky cover.
    fn air([dry, dew, infrared, sky]: [&str; 4]) -> Result<Air> {
        let mut cells = vec!["1"; 35];
        for (place, text) in [(DRY_BULB, dry), (DEW_POINT, dew), (INFRARED, infrared), (OPAQUE_SKY, sky)] {
            cells[place] = text;
        }
        read_air(Path::new("w.epw"), 9, &cells)
    }

    /// Numbers are taken. The cells 99.9, 99, 9999, 0 and empty mean missing, 12 of 12. A negative
    /// infrared radiation, a word and NaN are refused with line and column.
    #[test]
    fn codes_for_missing_air_are_missing() {
        let given = air(["-5.7", "-8.0", "237", "6"]).expect("numbers");
        assert_eq!(given.dry_bulb_c.zip(given.dew_point_c), Some((-5.7, -8.0)));
        assert_eq!(given.infrared_w_m2.zip(given.opaque_sky_tenths), Some((237.0, 6.0)));
        for cells in [["99.9", "99.9", "9999", "99"], ["", "", "", ""], ["x", "-99", "0", "-1"]] {
            assert_eq!(air(cells).expect("missing"), Air { wind_m_s: Some(1.0), ..Air::default() }, "{cells:?}");
        }
        for text in ["-1", "x", "NaN", "-9999"] {
            let error = air(["1", "1", text, "1"]).expect_err(text).to_string();
            let expected = format!("w.epw, line 9: column `horizontal infrared radiation` holds `{text}`");
            assert!(error.contains(&expected), "{error}");
        }
    }

    /// The infrared radiation of Golden's 8760 hours, computed anew, agrees with the file (which
    /// was computed from a thermometer and the clouds, and rounded to whole W/m2) within 0.6 W/m2,
    /// and in the mean within 0.05. All hours are counted in one warning.
    #[test]
    fn computed_infrared_agrees_with_the_file() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/weather/golden_tmy3.epw");
        let bytes = std::fs::read(&path).expect("data");
        let whole = parse_epw_with_air(&path, &bytes).expect("weather");
        assert_eq!((whole.report.findings.of(Finding::ComputedInfrared).rows, whole.air.len()), (0, 8760));
        let errors: Vec<f64> = whole
            .air
            .iter()
            .map(|air| {
                let computed = Air { infrared_w_m2: None, ..*air }.sky_w_m2().expect("all is given");
                computed - air.infrared_w_m2.expect("given")
            })
            .collect();
        let mean = errors.iter().sum::<f64>() / 8760.0;
        assert!(mean.abs() < 0.05 && errors.iter().all(|error| error.abs() < 0.6), "{mean}");

        let text = String::from_utf8_lossy(&bytes).into_owned();
        let lines = text.lines().enumerate().map(|(i, line)| {
            let mut cells: Vec<&str> = line.split(',').collect();
            if i >= 8 {
                cells[INFRARED] = "9999";
            }
            cells.join(",") + "\n"
        });
        let gone = lines.collect::<String>().into_bytes();
        let warnings = parse_epw_with_air(&path, &gone).expect("weather").report.warnings;
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert!(
            warnings[0].contains("line 9 and on: missing infrared radiation of 8760 hours computed"),
            "{warnings:?}"
        );
        assert!(parse_epw(&path, &gone).expect("weather").report.warnings.is_empty());
    }
}
