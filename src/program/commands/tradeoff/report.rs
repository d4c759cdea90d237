//! The folder of a report. In: what was measured. Out: its files, name and text: tables for programs, pictures, a page for people.

use std::path::Path;

use super::ladder::{LadderTable, Step};
use super::sources::Point;
use heliotile_core::error::Result;
use heliotile_core::replay::components::Component;
use heliotile_results::outputs::page::{escaped, page};
use heliotile_results::outputs::pictures::plot::{Axis, Plot, Series, Style};
use heliotile_results::outputs::provenance::Provenance;
use heliotile_results::outputs::tables::{column::Column, csvw};

/// The page that shows everything.
pub const PAGE: &str = "index.html";

/// What was looked at.
pub struct SiteSummary<'a> {
    pub scene: &'a Path,
    pub receivers: usize,
    pub sample: usize,
    /// What errors were estimated under.
    pub weather: &'a str,
}

/// Pixels of a picture.
const SIZE: (u32, u32) = (760, 460);

/// All files.
pub fn files(
    site: &SiteSummary,
    ladder: &LadderTable,
    sources: Option<&[Point]>,
    about: &Provenance,
) -> Result<Vec<(&'static str, String)>> {
    let time = picture(ladder, "Error against time", "CPU seconds a receiver: build and a year's replay", |step| {
        step.seconds() / ladder.receivers as f64
    })?;
    let size = picture(ladder, "Error against size", "archive, kB a receiver", |step| {
        step.bytes as f64 / 1e3 / ladder.receivers as f64
    })?;
    let mut pictures = vec![("error_time.svg", time), ("error_bytes.svg", size)];
    let table = ladder_csv(ladder);
    let mut files =
        vec![("tradeoff.csv-metadata.json", columns("tradeoff.csv", &table, about)), ("tradeoff.csv", table)];
    if let Some(points) = sources {
        pictures.push(("sources.svg", sources_picture(points)?));
        let table = sources_csv(points);
        files.push(("sources.csv-metadata.json", columns("sources.csv", &table, about)));
        files.push(("sources.csv", table));
    }
    pictures.iter_mut().for_each(|(_, svg)| *svg = about.in_svg(svg));
    let title = format!("What accuracy costs: {}", site.scene.display());
    files.push((PAGE, page(&title, &words(site, ladder), &pictures, &ladder.table())));
    files.extend(pictures);
    Ok(files)
}

/// What the columns of a table are.
fn columns(name: &str, table: &str, about: &Provenance) -> String {
    let header = table.lines().next().unwrap_or_default().split(',');
    let column = |name: &str| match name {
        "rung" | "setting" | "against" | "frontier" => Column::text(name),
        _ => Column::number(name, 4),
    };
    csvw::text(name, &header.map(column).collect::<Vec<_>>(), about)
}

fn picture(ladder: &LadderTable, title: &str, x: &str, at: impl Fn(&Step) -> f64) -> Result<String> {
    // Rungs that some other one beats in time stand apart.
    let some = |frontier: bool| {
        let mut steps: Vec<&Step> = ladder.steps.iter().filter(|s| s.frontier == frontier).collect();
        steps.sort_by(|a, b| at(a).total_cmp(&at(b)));
        steps
    };
    let series = |name: &str, steps: Vec<&Step>, style: Style| Series {
        name: name.into(),
        points: steps.iter().map(|step| (at(step), step.error)).collect(),
        labels: steps.iter().map(|step| step.name.clone()).collect(),
        style,
    };
    let plot = Plot {
        title: title.into(),
        x: Axis { label: x.into(), log: true },
        y: Axis { label: "RMSE of hourly totals, % of their mean".into(), log: true },
        series: [
            series("the frontier: nothing is faster and better", some(true), Style::Both),
            series("something is", some(false), Style::Marks),
        ]
        .into_iter()
        .filter(|series| !series.points.is_empty())
        .collect(),
    };
    plot.svg(SIZE.0, SIZE.1)
}

fn sources_picture(points: &[Point]) -> Result<String> {
    let mut series: Vec<Series> = Vec::new();
    for point in points {
        if series.last().is_none_or(|last| last.name != point.setting) {
            let name = point.setting.to_string();
            series.push(Series { name, points: Vec::new(), labels: Vec::new(), style: Style::Both });
        }
        if let Some(last) = series.last_mut() {
            last.points.push((point.value, point.mean_absolute));
        }
    }
    let plot = Plot {
        title: "Each setting alone".into(),
        x: Axis { label: "value of the setting".into(), log: true },
        y: Axis { label: "mean absolute error, % of the mean total".into(), log: true },
        series,
    };
    plot.svg(SIZE.0, SIZE.1)
}

fn ladder_csv(ladder: &LadderTable) -> String {
    let mut out = String::from(
        "rung,sky_base,sky_fine,hit,cell_factor,cell_floor_m,probe,probe_hits,closed_m,bounce_sky,bounce_hits,patches,steps,\
         error_percent,bias_percent,yearly_percent,",
    );
    let parts = Component::ALL.into_iter().filter(|component| *component != Component::Total);
    parts.for_each(|component| out += &format!("{}_percent,", component.name()));
    out += "trace_cpu_s,compress_cpu_s,replay_cpu_s,rays,bytes,receivers,frontier\n";
    for step in &ladder.steps {
        let s = &step.settings;
        let components: String = step.components.iter().map(|percent| format!("{percent:.4},")).collect();
        out += &format!(
            "\"{}\",{},{},{},{},{},{},{},{},{},{},{},{},{:.4},{:.4},{:.4},{components}{:.4},{:.4},{:.4},{},{},{},{}\n",
            step.name,
            s.sky_base,
            s.sky_fine,
            s.hit,
            s.cell_factor,
            s.cell_floor_m,
            s.probe,
            s.probe_hits,
            s.closed_m,
            s.bounce_sky,
            s.bounce_hits,
            s.patches,
            s.steps,
            step.error,
            step.bias,
            step.yearly,
            step.trace_s,
            step.compress_s,
            step.replay_s,
            step.rays,
            step.bytes,
            ladder.receivers,
            step.frontier
        );
    }
    out
}

fn sources_csv(points: &[Point]) -> String {
    let mut out =
        String::from("setting,value,against,rmse_percent,mean_absolute_percent,bias_percent,order,rays,build_cpu_s\n");
    for p in points {
        let order = p.order.map_or(String::new(), |order| format!("{order:.3}"));
        out += &format!(
            "{},{},\"{}\",{:.5},{:.5},{:.5},{order},{},{:.4}\n",
            p.setting, p.value, p.truth, p.rmse, p.mean_absolute, p.bias, p.rays, p.build_s
        );
    }
    out
}

/// What a person should know, in words.
fn words(site: &SiteSummary, ladder: &LadderTable) -> String {
    let watts = |step: &Step| step.error / 100.0 * ladder.mean_w_m2;
    let named = |name: &str| ladder.steps.iter().find(|step| step.name == name);
    let mut text = format!(
        "{} of {} places of this site were calculated with {} different settings, from rough to very fine, under the same suns and skies ({}). \
         On average such a place gets {:.0} W/m2. ",
        site.sample,
        site.receivers,
        ladder.steps.len(),
        escaped(site.weather),
        ladder.mean_w_m2
    );
    if let (Some(standard), Some(fine)) = (named("standard"), named("fine")) {
        text += &format!(
            "With the usual setting, <b>standard</b>, a single hour is typically wrong by {:.1} W/m2 ({:.1} % of the average), and the sum over all \
             hours by {:.1} %: too much in one hour makes up for too little in another. With <b>fine</b> it is {:.1} W/m2 ({:.1} %), \
             for {:.1} times the computing time and {:.1} times the file. ",
            watts(standard),
            standard.error,
            standard.yearly,
            watts(fine),
            fine.error,
            fine.seconds() / standard.seconds().max(1e-9),
            fine.bytes as f64 / standard.bytes.max(1) as f64
        );
    }
    if let Some(knee) = ladder.knee() {
        text += &format!(
            "The best bargain here is <b>{}</b> ({:.1} %): finer settings cost more and more time for less and less gain. ",
            escaped(&knee.name),
            knee.error
        );
    }
    text +=
        "To ask for an error instead of a setting, build with <code>--error 2%</code>, or the number that you need.";
    text
}
