//! Each source of error alone. In: a bench for trials. Out: the rate at which its error falls when
//! its setting is refined while all others stay.

use serde::Serialize;

use heliotile_builder::accuracy::conditions::{ErrorConditions, is_lit};
use heliotile_builder::accuracy::reference_sample::percent;
use heliotile_builder::accuracy::trial::{Bench, ErrorMeasures, ErrorSource, Irradiances};
use heliotile_builder::settings::BuildSettings;
use heliotile_builder::settings::{Effects, Quality, Share};
use heliotile_builder::settings::{Rungs, patches};
use heliotile_core::error::Result;
use heliotile_core::observer::Stage;

/// Setting at one value. Errors are those of its source in hourly values.
#[derive(Clone, Debug, Serialize)]
pub struct SettingPoint {
    /// Name of the setting.
    pub setting: &'static str,
    /// Value of the setting.
    pub value: f64,
    /// Finest setting that it is compared with, in words.
    pub truth: String,
    /// RMSE, percent of the mean total.
    pub rmse_percent: f64,
    /// Mean absolute error, percent of the mean total.
    pub mean_absolute_percent: f64,
    /// Mean difference, percent of the mean total.
    pub bias_percent: f64,
    /// Order of convergence: the number of times that the mean absolute error halves when the
    /// setting becomes twice as fine; `None` at the first value.
    pub order: Option<f64>,
    /// Number of rays that were traced.
    pub rays: u64,
    /// CPU seconds to build.
    pub build_s: f64,
}

/// Setting that is varied.
struct Row {
    setting: &'static str,
    source: ErrorSource,
    truth: &'static str,
    values: &'static [f64],
    set: fn(&mut BuildSettings, f64),
    /// Function that makes the finest settings, which the values are compared with, from the base
    /// settings.
    finest: fn(&mut BuildSettings),
}

const ROWS: [Row; 5] = [
    Row {
        setting: "sky_fine",
        source: ErrorSource::Sky,
        truth: "4096",
        values: &[128.0, 256.0, 512.0, 1024.0, 2048.0],
        set: |s, v| (s.sky_base, s.sky_fine) = (64, v as usize),
        finest: |s| (s.sky_base, s.sky_fine) = (64, 4096),
    },
    Row {
        setting: "hit",
        source: ErrorSource::Seen,
        truth: "128, cells of the same size",
        values: &[8.0, 16.0, 32.0, 64.0],
        // Cells keep their size, which is counted in texels of the hit texture.
        set: |s, v| (s.hit, s.cell_factor) = (v as usize, v / 8.0),
        finest: |s| (s.hit, s.cell_factor) = (128, 16.0),
    },
    Row {
        setting: "cell_factor",
        source: ErrorSource::Seen,
        truth: "a hemisphere for every hit ({share} none)",
        values: &[16.0, 8.0, 4.0, 2.0, 1.0],
        set: |s, v| (s.cell_factor, s.cell_floor_m) = (v, v / 8.0),
        finest: |s| s.share = Share::None,
    },
    Row {
        setting: "probe",
        source: ErrorSource::Seen,
        truth: "128",
        values: &[8.0, 16.0, 32.0, 64.0],
        set: |s, v| (s.probe, s.bounce_sky) = (v as usize, 8),
        finest: |s| (s.probe, s.bounce_sky) = (128, 8),
    },
    Row {
        setting: "closed_m",
        source: ErrorSource::Bounced,
        truth: "2",
        values: &[32.0, 16.0, 8.0, 4.0],
        set: |s, v| s.closed_m = v,
        finest: |s| s.closed_m = 2.0,
    },
];

/// Numbers of sun positions in an hour that are compared with `MAX_STEPS`, one a minute.
const STEPS: [usize; 6] = [1, 2, 4, 6, 12, 30];
const MAX_STEPS: usize = 60;

/// Varies each setting alone, at the quality `fine` otherwise. Numbers of sun positions need a
/// weather file.
pub(super) fn each_alone(bench: &Bench, left_out: Effects, suns: &ErrorConditions) -> Result<Vec<SettingPoint>> {
    let base = BuildSettings { left_out, ..Rungs::new(Quality::Fine).settings() };
    let progress = Stage::begin(bench.observer, "settings", None);
    let mut points = Vec::new();
    let trial = |settings: BuildSettings| {
        progress.advance(1);
        bench.trial(settings)
    };
    let fine = trial(base)?;
    let mean = fine.light.mean();
    for row in &ROWS {
        let of_sky = row.source == ErrorSource::Sky;
        // Light that is seen directly needs no cells.
        let base = if of_sky { BuildSettings { left_out: Effects::ALL, ..base } } else { base };
        let mut finest = base;
        (row.finest)(&mut finest);
        let (truth, named) = (trial(finest)?, bench.observer.in_words(&row.truth.into()));
        let from = points.len();
        for &value in row.values {
            let mut settings = base;
            (row.set)(&mut settings, value);
            let tried = trial(settings)?;
            let error = tried.light.source_error(&truth.light, row.source);
            points.push(point(row.setting, value, &named, error, mean, tried.rays.total(), tried.build_s));
        }
        orders(&mut points[from..], row.setting == "cell_factor" || row.setting == "closed_m");
    }
    let lights: Vec<Irradiances> = patches().iter().map(|n| bench.light(&fine.archive, *n)).collect::<Result<_>>()?;
    let from = points.len();
    if let Some((truth, others)) = lights.split_last() {
        for (light, &patches) in others.iter().zip(&patches()) {
            points.push(point("patches", patches as f64, "2305", light.total_error(truth), mean, 0, 0.0));
        }
    }
    orders(&mut points[from..], false);
    let from = points.len();
    if let ErrorConditions::Weather(..) = suns {
        let light = |steps: usize| -> Result<Irradiances> {
            let mut conditions = suns.year(steps);
            conditions.retain(is_lit);
            Bench { conditions: &conditions, ..*bench }.light(&fine.archive, base.patches)
        };
        let truth = light(MAX_STEPS)?;
        for steps in STEPS {
            let error = light(steps)?.total_error(&truth);
            points.push(point("steps", steps as f64, "60", error, truth.mean(), 0, 0.0));
        }
    }
    orders(&mut points[from..], false);
    drop(progress);
    Ok(points)
}

/// Returns a point; `mean` in W/m2.
fn point(
    setting: &'static str,
    value: f64,
    truth: &str,
    error: ErrorMeasures,
    mean: f64,
    rays: u64,
    build_s: f64,
) -> SettingPoint {
    let [rmse_percent, mean_absolute_percent, bias_percent] =
        [error.rmse, error.mean_absolute, error.bias].map(|error| percent(error, mean));
    SettingPoint {
        setting,
        value,
        truth: truth.to_owned(),
        rmse_percent,
        mean_absolute_percent,
        bias_percent,
        order: None,
        rays,
        build_s,
    }
}

/// Fills in the orders of neighbouring values; `falling` is true if small values are the fine ones.
fn orders(points: &mut [SettingPoint], falling: bool) {
    for i in 1..points.len() {
        let ratio = points[i].value / points[i - 1].value;
        let finer = if falling { 1.0 / ratio } else { ratio };
        let (before, now) = (points[i - 1].mean_absolute_percent, points[i].mean_absolute_percent);
        points[i].order = (before > 0.0 && now > 0.0 && finer > 1.0).then(|| (before / now).ln() / finer.ln());
    }
}

/// Returns the points as a table for the terminal.
pub(super) fn table(points: &[SettingPoint]) -> String {
    let mut out = format!(
        "\n{:<13}{:>7}{:>10}{:>13}{:>9}{:>8}  against\n",
        "setting", "value", "RMSE %", "mean abs. %", "bias %", "order"
    );
    for p in points {
        let order = p.order.map_or("-".into(), |order| format!("{order:.2}"));
        let (setting, value) = (p.setting, p.value);
        out += &format!(
            "{setting:<13}{value:>7}{:>10.3}{:>13.4}{:>9.3}{order:>8}  {}\n",
            p.rmse_percent, p.mean_absolute_percent, p.bias_percent, p.truth
        );
    }
    out += "order: the mean absolute error of that source falls by 2^order when the setting becomes twice as fine\n";
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean absolute errors 4, 2, 0.5 at sides 8, 16, 32 fall with the orders 1 and 2; at cell
    /// sizes 4, 2, 1 as well; an error of 0 has no order.
    #[test]
    fn orders_follow_from_errors_at_doubled_settings() {
        let of = |values: [f64; 3], errors: [f64; 3], falling: bool| -> Vec<Option<f64>> {
            let at = |(value, mean_absolute): (f64, f64)| {
                let error = ErrorMeasures { rmse: 0.0, bias: 0.0, mean_absolute };
                point("hit", value, "", error, 100.0, 0, 0.0)
            };
            let mut points: Vec<SettingPoint> = values.into_iter().zip(errors).map(at).collect();
            orders(&mut points, falling);
            points.iter().map(|p| p.order).collect()
        };
        assert_eq!(of([8.0, 16.0, 32.0], [4.0, 2.0, 0.5], false), [None, Some(1.0), Some(2.0)]);
        assert_eq!(of([4.0, 2.0, 1.0], [4.0, 2.0, 0.5], true), [None, Some(1.0), Some(2.0)]);
        assert_eq!(of([8.0, 16.0, 32.0], [4.0, 0.0, 0.0], false), [None, None, None]);
    }
}
