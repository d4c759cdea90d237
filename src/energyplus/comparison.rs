//! Comparison of three runs of one model. In: hourly series without reflections, with EnergyPlus's
//! own, and with injected light. Out: tables and pictures of loads and of the sun on surfaces.

use std::collections::BTreeMap;

use super::eso::HourlySeries;
use super::report::Block;
use heliotile_results::outputs::pictures::plot::{Axis, Plot, Series, Style};

/// Output variables that are requested, each with its unit and its title in the report.
pub const VARIABLES: [(&str, &str, &str); 4] = [
    ("Zone Air System Sensible Heating Rate", "W", "Heating of zones"),
    ("Zone Air System Sensible Cooling Rate", "W", "Cooling of zones"),
    ("Surface Outside Face Solar Radiation Heat Gain Rate per Area", "W/m2", "Sun absorbed by opaque surfaces"),
    ("Surface Window Transmitted Solar Radiation Rate", "W", "Sun transmitted by windows"),
];

/// Names of the runs and of their folders, in order.
pub const RUNS: [&str; 3] = ["none", "own", "injected"];

/// Size of a picture, pixels.
const SIZE: (u32, u32) = (760, 460);

/// Name of the row of all keys; EnergyPlus writes names of surfaces in capitals.
const ALL: &str = "all";

/// Hours in a day.
const DAY: usize = 24;

/// Smallest mean that percentages are given for, in the unit of the variable.
const MIN: f64 = 1e-6;

/// Areas of surfaces by name in small letters, m2.
pub type SurfaceAreas = BTreeMap<String, f64>;

/// Returns the sections of the report: tables of all variables, then pictures.
pub fn compare(runs: &[HourlySeries; 3], areas: &SurfaceAreas) -> Vec<(String, Vec<Block>)> {
    let mut sections = Vec::new();
    for (variable, unit, title) in VARIABLES {
        let rows = rows(runs, variable, areas);
        if rows.is_empty() {
            continue;
        }
        if rows.iter().all(Row::is_zero) {
            sections.push((title.to_owned(), vec![Block::Text(zero_text(variable))]));
            continue;
        }
        let head = ["name", "without", "own", "injected", "without, %", "injected, %", "RMS without", "RMS injected"];
        let last = if is_per_area(variable) {
            "is the mean of the surfaces outdoors by area"
        } else {
            "holds the sums of all rows"
        };
        let text = format!(
            "Means in {unit} of the runs without reflections, with EnergyPlus's own reflections and with injected light. Percentages and \
             RMS of hourly differences ({unit}) are relative to the run with EnergyPlus's own reflections. The last row {last}."
        );
        let mut blocks = vec![
            Block::Text(text),
            Block::Table(head.map(str::to_owned).to_vec(), rows.iter().map(Row::cells).collect()),
        ];
        if !is_per_area(variable) {
            let head = ["month", "without, kWh", "own, kWh", "injected, kWh"].map(str::to_owned).to_vec();
            blocks.push(Block::Text("Sums of all rows by month.".into()));
            blocks.push(Block::Table(head, months(runs, variable)));
        }
        sections.push((title.to_owned(), blocks));
    }
    sections.push(("Pictures".into(), vec![day(runs), surfaces(runs, areas)]));
    sections
}

/// Returns true for a variable of power per area.
fn is_per_area(variable: &str) -> bool {
    VARIABLES.iter().any(|(name, unit, _)| *name == variable && *unit == "W/m2")
}

/// Returns the text in place of a table of zeros.
fn zero_text(variable: &str) -> String {
    let of_zones = VARIABLES[..2].iter().any(|(name, ..)| *name == variable);
    if of_zones {
        "0 in every hour of all runs: no system heats or cools the zones. Give the model ideal loads \
         (`HVACTemplate:Zone:IdealLoadsAirSystem` and a thermostat) to compare loads."
            .into()
    } else {
        "0 in every hour of all runs.".into()
    }
}

/// Returns a row for each month with the sums of all keys in the three runs, kWh, and a row for
/// their sum.
fn months(runs: &[HourlySeries; 3], variable: &str) -> Vec<Vec<String>> {
    let mut sums: BTreeMap<u8, [f64; 3]> = BTreeMap::new();
    for (i, run) in runs.iter().enumerate() {
        for (_, values) in run.values.iter().filter(|((name, _), _)| name == variable) {
            for (value, month) in values.iter().zip(&run.months) {
                sums.entry(*month).or_default()[i] += value / 1000.0;
            }
        }
    }
    let all = sums.values().fold([0.0; 3], |all, of| [all[0] + of[0], all[1] + of[1], all[2] + of[2]]);
    let cells = |name: String, of: [f64; 3]| std::iter::once(name).chain(of.map(|kwh| format!("{kwh:.1}"))).collect();
    let rows = sums.into_iter().map(|(month, of)| cells(month.to_string(), of));
    rows.chain([cells("all".into(), all)]).collect()
}

/// One key of a variable: means of the three runs, and RMS differences of two from the run with
/// EnergyPlus's own reflections.
struct Row {
    name: String,
    means: [f64; 3],
    rms: [f64; 2],
}

impl Row {
    fn new(name: &str, [none, own, ours]: [&[f64]; 3]) -> Row {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let rms = |values: &[f64]| {
            let squares = values.iter().zip(own).map(|(a, b)| (a - b).powi(2));
            (squares.sum::<f64>() / own.len().max(1) as f64).sqrt()
        };
        Row { name: name.to_owned(), means: [mean(none), mean(own), mean(ours)], rms: [rms(none), rms(ours)] }
    }

    fn is_zero(&self) -> bool {
        self.means.iter().all(|mean| mean.abs() <= MIN) && self.rms.iter().all(|rms| *rms <= MIN)
    }

    fn cells(&self) -> Vec<String> {
        let [none, own, ours] = self.means;
        let percent = |value: f64| match own.abs() > MIN {
            true => format!("{:+.2}", 100.0 * (value / own - 1.0)),
            false => "-".into(),
        };
        let mut cells = vec![self.name.clone()];
        cells.extend([none, own, ours].map(|value| format!("{value:.2}")));
        cells.extend([none, ours].map(percent));
        cells.extend(self.rms.map(|value| format!("{value:.3}")));
        cells
    }
}

/// Returns a row for each key that all three runs have, and a row for all of them: their sum, or of
/// a variable of power per area the mean by the areas that are known.
fn rows(runs: &[HourlySeries; 3], variable: &str, areas: &SurfaceAreas) -> Vec<Row> {
    let [none, own, ours] = runs;
    let mut rows = Vec::new();
    let mut sums: [Vec<f64>; 3] = Default::default();
    let weights: BTreeMap<&str, f64> = match is_per_area(variable) {
        true => {
            let all = own.values.keys().filter(|(name, _)| name == variable);
            let known = all.filter_map(|(_, key)| Some((key.as_str(), *areas.get(&key.to_lowercase())?)));
            let known: Vec<(&str, f64)> = known.collect();
            let whole_m2: f64 = known.iter().map(|(_, area_m2)| area_m2).sum();
            known.into_iter().map(|(key, area_m2)| (key, area_m2 / whole_m2)).collect()
        }
        false => own.values.keys().map(|(_, key)| (key.as_str(), 1.0)).collect(),
    };
    for (key, values) in own.values.iter().filter(|((name, _), _)| name == variable) {
        let (Some(none), Some(ours)) = (none.values.get(key), ours.values.get(key)) else { continue };
        if let Some(weight) = weights.get(key.1.as_str()) {
            for (sum, values) in sums.iter_mut().zip([none, values, ours]) {
                sum.resize(values.len().max(sum.len()), 0.0);
                sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
            }
        }
        rows.push(Row::new(&key.1, [none, values, ours]));
    }
    if sums.iter().any(|sum| !sum.is_empty()) {
        rows.push(Row::new(ALL, sums.each_ref().map(Vec::as_slice)));
    }
    rows
}

/// Returns the mean day of the sum of all keys of a variable: hour and thousands of the variable's
/// unit.
fn by_hour(run: &HourlySeries, variable: &str) -> Vec<(f64, f64)> {
    let (mut sums, mut days) = ([0.0; DAY], 1.0_f64);
    for (_, values) in run.values.iter().filter(|((name, _), _)| name == variable) {
        days = days.max(values.len() as f64 / DAY as f64);
        for (hour, value) in values.iter().enumerate() {
            if let Some(sum) = sums.get_mut(hour % DAY) {
                *sum += value;
            }
        }
    }
    sums.iter().enumerate().map(|(hour, sum)| (hour as f64 + 0.5, sum / days / 1000.0)).collect()
}

/// Plots cooling by hour of the day, or the sun that windows transmit if no run has cooling.
fn day(runs: &[HourlySeries; 3]) -> Block {
    let of_cooling = |run: &HourlySeries| {
        run.values.iter().any(|((name, _), values)| name == VARIABLES[1].0 && values.iter().any(|value| *value > MIN))
    };
    let cooled = runs.iter().any(of_cooling);
    let (variable, _, title) = if cooled { VARIABLES[1] } else { VARIABLES[3] };
    let series = |(run, name): (&HourlySeries, &str)| Series::new(name, by_hour(run, variable), Style::Line);
    let plot = Plot {
        title: format!("{title}: mean day"),
        x: Axis { label: "hour of the day".into(), log: false },
        y: Axis { label: "kW".into(), log: false },
        series: runs.iter().zip(["without reflections", "EnergyPlus's own", "injected"]).map(series).collect(),
    };
    Block::Picture("day.svg".into(), plot.svg(SIZE.0, SIZE.1))
}

/// Plots the sun absorbed by each surface against the run with EnergyPlus's own reflections.
fn surfaces(runs: &[HourlySeries; 3], areas: &SurfaceAreas) -> Block {
    let rows = rows(runs, VARIABLES[2].0, areas);
    let each = || rows.iter().filter(|row| row.name != ALL);
    let points = |of: usize| each().map(|row| (row.means[1], row.means[of])).collect();
    let marks = |name: &str, of: usize| Series::new(name, points(of), Style::Marks);
    let plot = Plot {
        title: "Sun absorbed by each opaque surface".into(),
        x: Axis { label: "with EnergyPlus's own reflections, W/m2".into(), log: false },
        y: Axis { label: "W/m2".into(), log: false },
        series: vec![marks("without reflections", 0), marks("injected", 2)],
    };
    Block::Picture("surfaces.svg".into(), plot.svg(SIZE.0, SIZE.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For two hours of one wall, 10 and 20 with EnergyPlus's own reflections and 12 and 22
    /// without, the row states +13.33 % and an RMS of 2; for injected light that is equal it states
    /// 0 and 0.
    #[test]
    fn a_row_states_means_percent_and_rms() {
        let row = Row::new("wall", [&[12.0, 22.0], &[10.0, 20.0], &[10.0, 20.0]]);
        assert_eq!(row.cells(), ["wall", "17.00", "15.00", "15.00", "+13.33", "+0.00", "2.000", "0.000"]);
    }

    fn series(of: &[(&str, &str, [f64; 2])]) -> HourlySeries {
        let key = |variable: &str, key: &str| (variable.to_owned(), key.to_owned());
        let values = of.iter().map(|(variable, name, values)| (key(variable, name), values.to_vec()));
        HourlySeries { values: values.collect(), months: vec![1, 2] }
    }

    /// Walls of 30 and 10 m2 that absorb 100 and 300 W/m2 absorb 150 W/m2 together; a floor
    /// indoors, whose area is not known, does not count. Transmitted sun of 2000 and 500 W in two
    /// months is 2 and 0.5 kWh.
    #[test]
    fn all_surfaces_have_their_mean_by_area() {
        let (sun, through) = (VARIABLES[2].0, VARIABLES[3].0);
        let run = || {
            let walls = [(sun, "A", [100.0, 100.0]), (sun, "B", [300.0, 300.0]), (sun, "FLOOR", [0.0, 0.0])];
            series(&[walls[0], walls[1], walls[2], (through, "W", [2000.0, 500.0])])
        };
        let areas = SurfaceAreas::from([("a".to_owned(), 30.0), ("b".to_owned(), 10.0)]);
        let all = rows(&[run(), run(), run()], sun, &areas).pop().expect("a row");
        assert_eq!((all.name.as_str(), all.means), ("all", [150.0; 3]));
        let by_month = months(&[run(), run(), run()], through);
        assert_eq!(by_month, [["1", "2.0", "2.0", "2.0"], ["2", "0.5", "0.5", "0.5"], ["all", "2.5", "2.5", "2.5"]]);
    }

    /// Zones that no system heats or cools get a sentence in place of a table of zeros, and the
    /// picture shows transmitted sun: 0 tables of loads.
    #[test]
    fn loads_of_zero_are_said_in_words() {
        let run = || series(&[(VARIABLES[1].0, "HALL", [0.0, 0.0]), (VARIABLES[3].0, "W", [1.0, 1.0])]);
        let sections = compare(&[run(), run(), run()], &SurfaceAreas::new());
        let (title, blocks) = &sections[0];
        assert_eq!((title.as_str(), blocks.len()), (VARIABLES[1].2, 1));
        assert!(matches!(&blocks[0], Block::Text(text) if text.contains("no system heats or cools")));
        let picture = sections.last().and_then(|(_, blocks)| blocks.first());
        assert!(matches!(picture, Some(Block::Picture(_, svg)) if svg.contains(VARIABLES[3].2)));
    }
}
