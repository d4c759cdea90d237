//! Report of a trade-off for people and programs. In: the measurements. Out: a folder with tables,
//! pictures, and a page for people.

use std::path::Path;

use super::ladder::{LadderStep, LadderTable};
use super::sources::SettingPoint;
use heliotile_core::archive::settings::SETTINGS;
use heliotile_core::observer::Observer;
use heliotile_core::replay::components::Component;
use heliotile_results::outputs::markup::escaped;
use heliotile_results::outputs::page::{CsvTable, PICTURE_PX, ReportFolder};
use heliotile_results::outputs::pictures::plot::{Axis, Plot, Series, Style};

/// Names of columns that hold text, not numbers.
const LABELS: &[&str] = &["rung", "setting", "against", "frontier"];

/// Returns the report with all of its files.
pub(super) fn folder(site: &SiteSummary, ladder: &LadderTable, sources: Option<&[SettingPoint]>) -> ReportFolder {
    let time = picture(ladder, "Error against time", "CPU seconds a receiver: build and a year's replay", |step| {
        step.seconds() / ladder.receivers as f64
    });
    let size = picture(ladder, "Error against size", "archive, kB a receiver", |step| {
        step.bytes as f64 / 1e3 / ladder.receivers as f64
    });
    let mut pictures = vec![("error_time.svg", time), ("error_bytes.svg", size)];
    let mut csv = vec![CsvTable { name: "tradeoff.csv", text: ladder_csv(ladder), labels: LABELS }];
    if let Some(points) = sources {
        pictures.push(("sources.svg", sources_picture(points)));
        csv.push(CsvTable { name: "sources.csv", text: sources_csv(points), labels: LABELS });
    }
    let title = format!("What accuracy costs: {}", site.scene.display());
    ReportFolder { title, words: words(site, ladder), table: ladder.table(), csv, pictures }
}

fn picture(ladder: &LadderTable, title: &str, x: &str, at: impl Fn(&LadderStep) -> f64) -> String {
    // Steps that another one beats in time and error are a series of their own.
    let some = |frontier: bool| {
        let mut steps: Vec<&LadderStep> = ladder.steps.iter().filter(|s| s.frontier == frontier).collect();
        steps.sort_by(|a, b| at(a).total_cmp(&at(b)));
        steps
    };
    let series = |name: &str, steps: Vec<&LadderStep>, style: Style| Series {
        labels: steps.iter().map(|step| step.name.clone()).collect(),
        ..Series::new(name, steps.iter().map(|step| (at(step), step.error_percent)).collect(), style)
    };
    let plot = Plot {
        title: title.into(),
        x: Axis { label: x.into(), log: true },
        y: Axis { label: "RMSE of hourly totals, % of their mean".into(), log: true },
        series: [
            series("the frontier: nothing is faster and better", some(true), Style::Both),
            series("something is faster and better", some(false), Style::Marks),
        ]
        .into_iter()
        .filter(|series| !series.points.is_empty())
        .collect(),
    };
    plot.svg(PICTURE_PX.0, PICTURE_PX.1)
}

fn sources_picture(points: &[SettingPoint]) -> String {
    let mut series: Vec<Series> = Vec::new();
    for point in points {
        if series.last().is_none_or(|last| last.name != point.setting) {
            series.push(Series::new(point.setting, Vec::new(), Style::Both));
        }
        if let Some(last) = series.last_mut() {
            last.points.push((point.value, point.mean_absolute_percent));
        }
    }
    let plot = Plot {
        title: "Each setting alone".into(),
        x: Axis { label: "value of the setting".into(), log: true },
        y: Axis { label: "mean absolute error, % of the mean total".into(), log: true },
        series,
    };
    plot.svg(PICTURE_PX.0, PICTURE_PX.1)
}

fn ladder_csv(ladder: &LadderTable) -> String {
    let parts = Component::ALL.into_iter().filter(|component| *component != Component::Total);
    let names = SETTINGS.iter().map(|setting| setting.name.to_owned());
    let errors = ["error", "bias", "yearly"].into_iter().chain(parts.clone().map(Component::name));
    let errors = errors.map(|name| format!("{name}_percent"));
    let mut out = format!(
        "rung,{},trace_cpu_s,compress_cpu_s,replay_cpu_s,rays,bytes,receivers,frontier\n",
        names.chain(errors).collect::<Vec<_>>().join(",")
    );
    for step in &ladder.steps {
        let number = |number: f64| format!("{number:.4}");
        // The cell of an unknown component is empty.
        let of = |part: Component| step.components_percent.get(part.name()).map_or(String::new(), |v| number(*v));
        let errors = [step.error_percent, step.bias_percent, step.yearly_percent].map(number);
        let seconds = [step.trace_s, step.compress_s, step.replay_s].map(number);
        let settings = step.settings.stated();
        let settings = settings.numbers().map(|(_, number)| number.to_string());
        let numbers = settings.chain(errors).chain(parts.clone().map(of)).chain(seconds).collect::<Vec<_>>();
        let LadderStep { name, rays, bytes, frontier, .. } = step;
        out += &format!("\"{name}\",{},{rays},{bytes},{},{frontier}\n", numbers.join(","), ladder.receivers);
    }
    out
}

fn sources_csv(points: &[SettingPoint]) -> String {
    let mut out =
        String::from("setting,value,against,rmse_percent,mean_absolute_percent,bias_percent,order,rays,build_cpu_s\n");
    for p in points {
        let order = p.order.map_or(String::new(), |order| format!("{order:.3}"));
        out += &format!(
            "{},{},\"{}\",{:.5},{:.5},{:.5},{order},{},{:.4}\n",
            p.setting, p.value, p.truth, p.rmse_percent, p.mean_absolute_percent, p.bias_percent, p.rays, p.build_s
        );
    }
    out
}

/// Returns the summary of the report in words, as HTML.
fn words(site: &SiteSummary, ladder: &LadderTable) -> String {
    let watts = |step: &LadderStep| step.error_percent / 100.0 * ladder.mean_w_m2;
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
            standard.error_percent,
            standard.yearly_percent,
            watts(fine),
            fine.error_percent,
            fine.seconds() / standard.seconds().max(1e-9),
            fine.bytes as f64 / standard.bytes.max(1) as f64
        );
    }
    if let Some(knee) = ladder.knee() {
        text += &format!(
            "The best bargain here is <b>{}</b> ({:.1} %): finer settings cost more and more time for less and less gain. ",
            escaped(&knee.name),
            knee.error_percent
        );
    }
    text + &site.observer.in_words(
        &"To ask for an error instead of a setting, build with <code>{error} 2%</code>, or the number that you need."
            .into(),
    )
}

/// Summary of the site for the report.
pub(super) struct SiteSummary<'a> {
    pub scene: &'a Path,
    pub receivers: usize,
    pub sample: usize,
    /// Suns and skies that errors were estimated under.
    pub weather: &'a str,
    /// Observer, whose words texts use.
    pub observer: &'a dyn Observer,
}
