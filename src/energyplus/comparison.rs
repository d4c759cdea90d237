//! Comparison of three runs of one model. In: hourly series without reflections, with EnergyPlus's
//! own, and with injected light. Out: tables and pictures of loads and of the sun on surfaces.

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

/// Hours in a day.
const DAY: usize = 24;

/// Smallest mean that percentages are given for, in the unit of the variable.
const LEAST: f64 = 1e-6;

/// Returns the sections of the report: tables of all variables, then pictures.
pub fn compare(runs: &[HourlySeries; 3]) -> Vec<(String, Vec<Block>)> {
    let mut sections = Vec::new();
    for (variable, unit, title) in VARIABLES {
        let rows = rows(runs, variable);
        if rows.is_empty() {
            continue;
        }
        let head = ["name", "without", "own", "injected", "without, %", "injected, %", "RMS without", "RMS injected"];
        let text = format!(
            "Means in {unit} of the runs without reflections, with EnergyPlus's own reflections and with injected light. Percentages and \
             RMS of hourly differences ({unit}) are relative to the run with EnergyPlus's own reflections. The last row holds the sums of \
             all rows."
        );
        sections.push((
            title.to_owned(),
            vec![
                Block::Text(text),
                Block::Table(head.map(str::to_owned).to_vec(), rows.iter().map(Row::cells).collect()),
            ],
        ));
    }
    sections.push(("Pictures".into(), vec![day(runs), surfaces(runs)]));
    sections
}

/// One key of a variable: means of the three runs, and RMS differences of two from the run with
/// EnergyPlus's own reflections.
struct Row {
    name: String,
    means: [f64; 3],
    rms: [f64; 2],
}

impl Row {
    fn of(name: &str, [none, own, ours]: [&[f64]; 3]) -> Row {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let rms = |values: &[f64]| {
            let squares = values.iter().zip(own).map(|(a, b)| (a - b).powi(2));
            (squares.sum::<f64>() / own.len().max(1) as f64).sqrt()
        };
        Row { name: name.to_owned(), means: [mean(none), mean(own), mean(ours)], rms: [rms(none), rms(ours)] }
    }

    fn cells(&self) -> Vec<String> {
        let [none, own, ours] = self.means;
        let percent = |value: f64| match own.abs() > LEAST {
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

/// Returns a row for each key that all three runs have, and a row for their sum.
fn rows(runs: &[HourlySeries; 3], variable: &str) -> Vec<Row> {
    let [none, own, ours] = runs;
    let mut rows = Vec::new();
    let mut sums: [Vec<f64>; 3] = Default::default();
    for (key, values) in own.0.iter().filter(|((name, _), _)| name == variable) {
        let (Some(none), Some(ours)) = (none.0.get(key), ours.0.get(key)) else { continue };
        for (sum, values) in sums.iter_mut().zip([none, values, ours]) {
            sum.resize(values.len().max(sum.len()), 0.0);
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        }
        rows.push(Row::of(&key.1, [none, values, ours]));
    }
    if !rows.is_empty() {
        rows.push(Row::of("all", sums.each_ref().map(Vec::as_slice)));
    }
    rows
}

/// Returns the mean day of the sum of all keys of a variable: hour and thousands of the variable's
/// unit.
fn by_hour(run: &HourlySeries, variable: &str) -> Vec<(f64, f64)> {
    let (mut sums, mut days) = ([0.0; DAY], 1.0_f64);
    for (_, values) in run.0.iter().filter(|((name, _), _)| name == variable) {
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
    let cooled = runs.iter().any(|run| run.0.keys().any(|(name, _)| name == VARIABLES[1].0));
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
fn surfaces(runs: &[HourlySeries; 3]) -> Block {
    let rows = rows(runs, VARIABLES[2].0);
    let each = rows.split_last().map_or(&[][..], |(_, each)| each);
    let points = |of: usize| each.iter().map(|row| (row.means[1], row.means[of])).collect();
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
        let row = Row::of("wall", [&[12.0, 22.0], &[10.0, 20.0], &[10.0, 20.0]]);
        assert_eq!(row.cells(), ["wall", "17.00", "15.00", "15.00", "+13.33", "+0.00", "2.000", "0.000"]);
    }
}
