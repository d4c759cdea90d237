//! Output of an audit for people and programs. In: a report. Out: a table as text, a table of all
//! pairs, pictures, and a folder of these.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::report::{AuditReport, WorstPair, in_percent};
use heliotile_builder::accuracy::reference_sample::percent;
use heliotile_builder::reference::PARTS;
use heliotile_builder::reference::comparison::{ConfidenceInterval, Pair, off};
use heliotile_core::error::Result;
use heliotile_core::replay::components::Component;
use heliotile_results::outputs::markup::escaped;
use heliotile_results::outputs::page::{CsvTable, PICTURE_PX, ReportFolder};
use heliotile_results::outputs::pictures::plot::{Axis, Plot, Series, Style};
use heliotile_results::outputs::provenance::Provenance;
use heliotile_results::outputs::tables::quoted;

impl AuditReport {
    /// Returns the report as text for the terminal.
    pub fn text(&self) -> String {
        let mut out = format!(
            "{}: {} receivers, {} hours of {} in all, mean total {:.1} W/m2\n\
             {:13} {:>28} {:>26}   worst: difference and reference in W/m2, receiver, hour\n",
            self.archive.display(),
            self.receivers,
            self.hours,
            self.weather,
            self.mean_w_m2,
            "% of mean",
            "bias (95 %)",
            "RMSE (95 %)"
        );
        for found in &self.components {
            let (bias, rmse) = (found.bias_percent, found.rmse_percent);
            let worst = found.worst.as_ref().map_or(String::new(), worst);
            // Writing to a string cannot fail.
            let _ = writeln!(
                out,
                "{:13} {:>+8.3} ({:>+7.3} to {:>+7.3}) {:>7.3} ({:>5.3} to {:>6.3})   {worst}",
                found.component, bias.value, bias.low, bias.high, rmse.value, rmse.low, rmse.high
            );
        }
        let _ = writeln!(out, "sky view        mean W/m2        RMSE, W/m2 (95 %)     % of its mean");
        for group in &self.sky_views {
            let ([low, _, high], mean, rmse) = (group.sky_view, group.mean_w_m2, group.rmse_w_m2);
            let percent = percent(rmse.value, mean);
            let (value, from, to) = (rmse.value, rmse.low, rmse.high);
            let _ =
                writeln!(out, "{low:.2} to {high:.2} {mean:>12.1} {value:>9.2} ({from:.2} to {to:.2}) {percent:>13.2}");
        }
        if !self.hour_kinds.is_empty() {
            let _ = writeln!(
                out,
                "hours             share % mean W/m2        RMSE, W/m2 (95 %)     % of its mean  stated %"
            );
        }
        for found in &self.hour_kinds {
            let (rmse, mean) = (found.rmse_w_m2, found.mean_w_m2);
            let stated = found.stated_percent.map_or("-".into(), |stated| format!("{stated:.2}"));
            let _ = writeln!(
                out,
                "{:16} {:>8.1} {mean:>9.1} {:>9.2} ({:.2} to {:.2}) {:>13.2} {stated:>9}",
                found.kind,
                100.0 * found.share,
                rmse.value,
                rmse.low,
                rmse.high,
                percent(rmse.value, mean)
            );
        }
        let rmse = self.total().rmse_w_m2;
        let rmse = match rmse.value {
            0.0 if rmse.high > 0.0 => format!("below {:.2} W/m2, the noise of the reference", rmse.high),
            value => format!("{value:.2} W/m2"),
        };
        let _ = writeln!(out, "RMSE of totals: {rmse}; {}", self.sentence);
        out
    }

    /// Writes audit.csv, pictures and a page into a folder, and returns the path of the page;
    /// `about` is the provenance that files state.
    pub fn write(&self, folder: &Path, about: Provenance) -> Result<PathBuf> {
        let report = ReportFolder {
            title: format!("Audit of {}", self.archive.display()),
            words: self.words(),
            table: self.text(),
            csv: vec![CsvTable { name: "audit.csv", text: self.csv(), labels: &["receiver", "condition"] }],
            pictures: vec![("totals.svg", self.totals_picture()), ("sky_view.svg", self.sky_views_picture())],
        };
        report.write(folder, &about.with("weather", &self.weather))
    }

    /// Returns the summary of the report in words, as HTML.
    fn words(&self) -> String {
        let total = self.total();
        let percent = total.rmse_percent;
        format!(
            "The archive was compared with a reference path tracer at {} places of this site, each under some hours of {}. The \
             reference follows single paths of light and uses no textures of the archive. Over all hours the RMSE of the archive is \
             <b>{:.2} %</b> of the mean ({:.2} to {:.2} %, 95 % confidence), which is {:.1} W/m2. {}. The noise of the reference itself \
             is subtracted.",
            self.receivers,
            escaped(&self.weather),
            percent.value,
            percent.low,
            percent.high,
            total.rmse_w_m2.value,
            escaped(&self.sentence)
        )
    }

    /// Returns every pair with its results and the reference values, as CSV.
    pub fn csv(&self) -> String {
        let mut out = String::from("receiver,condition,sky_view");
        for part in Component::ALL {
            let name = part.name();
            let _ = write!(out, ",{name}_w_m2,{name}_reference_w_m2,{name}_standard_error_w_m2");
        }
        out.push('\n');
        for pair in &self.audited.pairs {
            let (receiver, sky_view) = &self.audited.receivers[pair.receiver];
            let label = &self.conditions[pair.condition].label;
            let _ = write!(out, "{},{},{sky_view:.4}", quoted(&receiver.id), quoted(label));
            for part in 0..PARTS {
                let (result, reference) = (pair.result[part], pair.reference);
                let _ = write!(out, ",{result:.4},{:.4},{:.4}", reference.mean[part], reference.error[part]);
            }
            out.push('\n');
        }
        out
    }

    fn totals_picture(&self) -> String {
        let at = |pair: &Pair| (pair.reference.mean[PARTS - 1], off(pair, PARTS - 1));
        let most = self.audited.pairs.iter().map(|pair| at(pair).0).fold(1.0, f64::max);
        let plot = Plot {
            title: "How far the archive is off".into(),
            x: Axis { label: "total by the reference path tracer, W/m2".into(), log: false },
            y: Axis { label: "archive minus reference, W/m2".into(), log: false },
            series: vec![
                Series::new("a receiver in an hour", self.audited.pairs.iter().map(at).collect(), Style::Marks),
                Series::new("no difference", vec![(0.0, 0.0), (most, 0.0)], Style::Line),
            ],
        };
        plot.svg(PICTURE_PX.0, PICTURE_PX.1)
    }

    fn sky_views_picture(&self) -> String {
        let points = |end: fn(&ConfidenceInterval) -> f64| -> Vec<(f64, f64)> {
            let of_mean = |rmse: ConfidenceInterval| end(&in_percent(rmse, self.mean_w_m2));
            self.sky_views.iter().map(|group| (100.0 * group.sky_view[1], of_mean(group.rmse_w_m2))).collect()
        };
        let plot = Plot {
            title: "Error by sky view of receivers".into(),
            x: Axis { label: "sky view of a tenth of the receivers, %".into(), log: false },
            y: Axis { label: "RMSE of totals, % of the mean of all".into(), log: false },
            series: vec![
                Series::new("found", points(|rmse| rmse.value), Style::Both),
                Series::new("95 % confidence: lower end", points(|rmse| rmse.low), Style::Line),
                Series::new("upper end", points(|rmse| rmse.high), Style::Line),
            ],
        };
        plot.svg(PICTURE_PX.0, PICTURE_PX.1)
    }
}

/// Returns the largest difference of a component in words.
fn worst(pair: &WorstPair) -> String {
    let WorstPair { receiver, condition, off_w_m2, reference_w_m2, standard_error_w_m2 } = pair;
    match *off_w_m2 == 0.0 {
        true => "-".into(),
        false => format!("{off_w_m2:+.1} +- {standard_error_w_m2:.1}, {reference_w_m2:.0}, {receiver}, {condition}"),
    }
}
