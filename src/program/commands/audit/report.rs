//! What an audit says. In: pairs of results and judgements. Out: a table for people, a verdict, a folder of files.

use std::fmt::Write;
use std::path::Path;

use heliotile_builder::accuracy::estimate::percent;
use heliotile_builder::judge::comparison::{Deviation, Known, Pair, deviation, mean_w_m2, off};
use heliotile_builder::judge::groups::by_sky_view;
use heliotile_builder::judge::hours::{HourKind, HoursFound, mix_of};
use heliotile_builder::judge::{Audited, PARTS};
use heliotile_core::archive::accuracy::Accuracy;
use heliotile_core::error::Result;
use heliotile_core::replay::components::Component;
use heliotile_core::weather::conditions::Condition;
use heliotile_results::outputs::page::{escaped, page};
use heliotile_results::outputs::pictures::plot::{Axis, Plot, Series, Style};
use heliotile_results::outputs::provenance::Provenance;
use heliotile_results::outputs::tables::{column::Column, csvw};

/// The page that shows everything.
pub const PAGE: &str = "index.html";

const TABLE: &str = "audit.csv";

/// Pixels of a picture.
const SIZE: (u32, u32) = (760, 460);

/// What is stated is an estimate: it is refuted by more than this factor.
const STATED_WITHIN: f64 = 1.5;

/// What came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The archive states no error.
    NothingStated,
    /// The error that was found may be what is stated.
    Holds,
    /// It is larger.
    Refuted,
}

/// All that was found.
pub struct AuditReport<'a> {
    archive: &'a Path,
    audited: &'a Audited,
    conditions: &'a [Condition],
    weather: &'a str,
    stated: Option<&'a Accuracy>,
    mean_w_m2: f64,
    /// `[part]`
    deviations: Vec<Deviation>,
    groups: Vec<Group>,
    hours: Vec<HoursFound>,
}

/// Receivers that see about as much of the sky.
struct Group {
    /// Smallest, mean and largest.
    sky_view: [f64; 3],
    mean_w_m2: f64,
    /// Of the totals, W/m2.
    rmse: Known,
}

impl<'a> AuditReport<'a> {
    pub fn new(
        archive: &'a Path,
        audited: &'a Audited,
        conditions: &'a [Condition],
        weather: &'a str,
        stated: Option<&'a Accuracy>,
    ) -> Self {
        let deviations = (0..PARTS).map(|part| deviation(&audited.pairs, &audited.suns, part)).collect();
        let groups = groups(audited);
        let (mean_w_m2, hours) = (mean_w_m2(&audited.pairs), audited.hours.found());
        AuditReport { archive, audited, conditions, weather, stated, mean_w_m2, deviations, groups, hours }
    }

    /// What is stated of the error of the hours that were looked at, percent of their mean.
    fn stated_percent(&self, stated: &Accuracy) -> f64 {
        percent(stated.expected_w_m2(&mix_of(&self.audited.pairs), self.mean_w_m2), self.mean_w_m2)
    }

    /// What is stated of the error of a kind of hours, percent of their mean.
    fn stated_of(&self, found: &HoursFound) -> Option<f64> {
        let stated = self.stated.filter(|stated| stated.hours.iter().any(|hours| hours.hours == found.kind.name()))?;
        Some(percent(stated.expected_w_m2(&found.mix, found.mean_w_m2), found.mean_w_m2))
    }

    /// The kinds of hours in which the error is larger than what is stated.
    fn refuted_hours(&self) -> Vec<HourKind> {
        let is_refuted = |found: &&HoursFound| {
            let low = percent(found.rmse_w_m2.low, found.mean_w_m2);
            self.stated_of(found).is_some_and(|stated| low > STATED_WITHIN * stated)
        };
        self.hours.iter().filter(is_refuted).map(|found| found.kind).collect()
    }

    /// Of the mean total.
    fn percent(&self, known: Known) -> Known {
        known.times(if self.mean_w_m2 > 0.0 { 100.0 / self.mean_w_m2 } else { 0.0 })
    }

    fn total(&self) -> Known {
        self.percent(self.deviations[PARTS - 1].rmse_w_m2)
    }

    pub fn verdict(&self) -> Verdict {
        match self.stated {
            None => Verdict::NothingStated,
            Some(stated) if self.total().low > STATED_WITHIN * self.stated_percent(stated) => Verdict::Refuted,
            Some(_) if !self.refuted_hours().is_empty() => Verdict::Refuted,
            Some(_) => Verdict::Holds,
        }
    }

    /// The verdict in words.
    fn sentence(&self) -> String {
        let stated = self.stated.map_or(0.0, |stated| self.stated_percent(stated));
        let hours: Vec<&str> = self.refuted_hours().into_iter().map(HourKind::name).collect();
        match self.verdict() {
            Verdict::NothingStated => "nothing is stated: `build --error 2%` would state an error".into(),
            Verdict::Holds => format!("stated: {stated:.2} %: not refuted"),
            Verdict::Refuted if !hours.is_empty() => {
                let hours = hours.join(", ");
                format!(
                    "stated: {stated:.2} %: REFUTED, the error is more than {STATED_WITHIN} times as large in hours of: {hours}"
                )
            }
            Verdict::Refuted => {
                format!("stated: {stated:.2} %: REFUTED, the error is more than {STATED_WITHIN} times as large")
            }
        }
    }

    /// For the terminal.
    pub fn text(&self) -> String {
        let mut out = format!(
            "{}: {} receivers, {} hours of {} in all, mean total {:.1} W/m2\n\
             {:13} {:>28} {:>26}   worst: W/m2 off, of, receiver, hour\n",
            self.archive.display(),
            self.audited.receivers.len(),
            self.audited.pairs.len(),
            self.weather,
            self.mean_w_m2,
            "% of mean",
            "bias (95 %)",
            "RMSE (95 %)"
        );
        for (part, found) in Component::ALL.iter().zip(&self.deviations) {
            let (bias, rmse) = (self.percent(found.bias_w_m2), self.percent(found.rmse_w_m2));
            let worst = found.worst.map_or(String::new(), |pair| self.worst(&pair, *part as usize));
            // Writing to a string cannot fail.
            let _ = writeln!(
                out,
                "{:13} {:>+8.3} ({:>+7.3} to {:>+7.3}) {:>7.3} ({:>5.3} to {:>6.3})   {worst}",
                part.name(),
                bias.value,
                bias.low,
                bias.high,
                rmse.value,
                rmse.low,
                rmse.high
            );
        }
        let _ = writeln!(out, "sky view        mean W/m2        RMSE, W/m2 (95 %)     % of its mean");
        for group in &self.groups {
            let ([low, _, high], mean, rmse) = (group.sky_view, group.mean_w_m2, group.rmse);
            let percent = if mean > 0.0 { rmse.value / mean * 100.0 } else { 0.0 };
            let (value, from, to) = (rmse.value, rmse.low, rmse.high);
            let _ =
                writeln!(out, "{low:.2} to {high:.2} {mean:>12.1} {value:>9.2} ({from:.2} to {to:.2}) {percent:>13.2}");
        }
        if !self.hours.is_empty() {
            let _ = writeln!(
                out,
                "hours             share % mean W/m2        RMSE, W/m2 (95 %)     % of its mean  stated %"
            );
        }
        for found in &self.hours {
            let (rmse, mean) = (found.rmse_w_m2, found.mean_w_m2);
            let stated = self.stated_of(found).map_or("-".into(), |stated| format!("{stated:.2}"));
            let _ = writeln!(
                out,
                "{:16} {:>8.1} {mean:>9.1} {:>9.2} ({:.2} to {:.2}) {:>13.2} {stated:>9}",
                found.kind.name(),
                100.0 * found.share,
                rmse.value,
                rmse.low,
                rmse.high,
                percent(rmse.value, mean)
            );
        }
        let total = self.deviations[PARTS - 1].rmse_w_m2;
        let _ = writeln!(out, "RMSE of totals: {:.2} W/m2; {}", total.value, self.sentence());
        out
    }

    fn worst(&self, pair: &Pair, part: usize) -> String {
        let difference = off(pair, part);
        if difference == 0.0 {
            return "-".into();
        }
        format!(
            "{difference:+.1} +- {:.1}, {:.0}, {}, {}",
            pair.judged.error[part],
            pair.judged.mean[part],
            self.audited.receivers[pair.receiver].0.id,
            self.conditions[pair.condition].label
        )
    }

    /// The files of a folder, name and text.
    pub fn files(&self, about: &Provenance) -> Result<Vec<(&'static str, String)>> {
        let mut pictures = vec![("totals.svg", self.totals_picture()?), ("sky_view.svg", self.groups_picture()?)];
        pictures.iter_mut().for_each(|(_, svg)| *svg = about.in_svg(svg));
        let table = self.csv();
        let header = table.lines().next().unwrap_or_default().split(',');
        let column = |name: &str| match name {
            "receiver" | "condition" => Column::text(name),
            _ => Column::number(name, 4),
        };
        let columns = csvw::text(TABLE, &header.map(column).collect::<Vec<_>>(), about);
        let title = format!("Audit of {}", self.archive.display());
        let mut files = vec![("audit.csv-metadata.json", columns), (TABLE, table)];
        files.push((PAGE, page(&title, &self.words(), &pictures, &self.text())));
        files.extend(pictures);
        Ok(files)
    }

    /// What a person should know, in words.
    fn words(&self) -> String {
        let total = self.total();
        format!(
            "{} places of this site were looked at, each under some hours of {}. For each, an independent calculation that follows single paths \
             of light, and has nothing of the archive's textures, was compared with the archive. Over all hours the archive is off by \
             <b>{:.2} %</b> of the mean ({:.2} to {:.2} %, 95 % confidence), which is {:.1} W/m2. {}. What is not yet settled of the judge's \
             own paths is taken off.",
            self.audited.receivers.len(),
            escaped(self.weather),
            total.value,
            total.low,
            total.high,
            self.deviations[PARTS - 1].rmse_w_m2.value,
            escaped(&self.sentence())
        )
    }

    fn csv(&self) -> String {
        let mut out = String::from("receiver,condition,sky_view");
        for part in Component::ALL {
            let name = part.name();
            let _ = write!(out, ",{name}_w_m2,{name}_judged_w_m2,{name}_standard_error_w_m2");
        }
        out.push('\n');
        for pair in &self.audited.pairs {
            let (receiver, sky_view) = &self.audited.receivers[pair.receiver];
            let label = &self.conditions[pair.condition].label;
            let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
            let _ = write!(out, "{},{},{sky_view:.4}", quoted(&receiver.id), quoted(label));
            for part in 0..PARTS {
                let (result, judged) = (pair.result[part], pair.judged);
                let _ = write!(out, ",{result:.4},{:.4},{:.4}", judged.mean[part], judged.error[part]);
            }
            out.push('\n');
        }
        out
    }

    fn totals_picture(&self) -> Result<String> {
        let at = |pair: &Pair| (pair.judged.mean[PARTS - 1], off(pair, PARTS - 1));
        let most = self.audited.pairs.iter().map(|pair| at(pair).0).fold(1.0, f64::max);
        let series = |name: &str, points, style| Series { name: name.into(), points, labels: Vec::new(), style };
        let plot = Plot {
            title: "How far the archive is off".into(),
            x: Axis { label: "total by the judge, W/m2".into(), log: false },
            y: Axis { label: "archive less judge, W/m2".into(), log: false },
            series: vec![
                series("a receiver in an hour", self.audited.pairs.iter().map(at).collect(), Style::Marks),
                series("no difference", vec![(0.0, 0.0), (most, 0.0)], Style::Line),
            ],
        };
        plot.svg(SIZE.0, SIZE.1)
    }

    fn groups_picture(&self) -> Result<String> {
        let points = |end: fn(&Known) -> f64| -> Vec<(f64, f64)> {
            self.groups.iter().map(|group| (100.0 * group.sky_view[1], end(&self.percent(group.rmse)))).collect()
        };
        let series = |name: &str, points, style| Series { name: name.into(), points, labels: Vec::new(), style };
        let plot = Plot {
            title: "Error by what receivers see of the sky".into(),
            x: Axis { label: "sky view of a tenth of the receivers, %".into(), log: false },
            y: Axis { label: "RMSE of totals, % of the mean of all".into(), log: false },
            series: vec![
                series("found", points(|rmse| rmse.value), Style::Both),
                series("95 % of cases lie above", points(|rmse| rmse.low), Style::Line),
                series("and below", points(|rmse| rmse.high), Style::Line),
            ],
        };
        plot.svg(SIZE.0, SIZE.1)
    }
}

/// Errors of the totals of groups of receivers that see about as much of the sky.
fn groups(audited: &Audited) -> Vec<Group> {
    let views: Vec<f64> = audited.receivers.iter().map(|receiver| receiver.1).collect();
    let of_group = |group: &Vec<usize>| {
        let [low, high] = [group.first()?, group.last()?].map(|&i| views[i]);
        let middle = group.iter().map(|&i| views[i]).sum::<f64>() / group.len() as f64;
        let inside: Vec<Pair> = audited.pairs.iter().filter(|pair| group.contains(&pair.receiver)).copied().collect();
        let rmse = deviation(&inside, &audited.suns, PARTS - 1).rmse_w_m2;
        Some(Group { sky_view: [low, middle, high], mean_w_m2: mean_w_m2(&inside), rmse })
    };
    by_sky_view(&views).iter().filter_map(of_group).collect()
}
