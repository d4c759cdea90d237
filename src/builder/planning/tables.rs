//! Forecast and summary of a build as text tables. In: a forecast, losses, a choice of settings, a
//! report. Out: text.

use std::fmt::Write;
use std::path::Path;

use crate::accuracy::SettingsChoice;
use crate::pipeline::{BuildReport, Forecast, SKY_W_M2, SUN_W_M2};
use crate::planning::losses::YearLosses;
use crate::settings::Effect;
use heliotile_core::archive::accuracy::HoursError;
use heliotile_core::archive::format;
use heliotile_core::archive::settings::Ladder;
use heliotile_core::site::chain::MAX_MIRRORS;
use heliotile_core::text::counted;
use heliotile_scene::Scene;

/// Returns a table of the rays, seconds and bound of every effect.
pub fn forecast(forecast: &Forecast) -> String {
    let mut out =
        format!("{:<22}{:<7}{:>11}{:>10}{:>16}  why\n", "effect", "state", "rays", "seconds", "without: W/m2");
    for line in &forecast.lines {
        let state = if line.on { "on" } else { "off" };
        let (rays, seconds) = match line.on {
            true => (rounded(line.rays), format!("{:.1}", line.seconds)),
            false => (format!("({})", rounded(line.rays)), format!("({:.1})", line.seconds)),
        };
        let bound = line.bound_w_m2.map_or("-".into(), at_most);
        out += &format!("{:<22}{state:<7}{rays:>11}{seconds:>10}{bound:>16}  {}\n", line.name, line.why);
    }
    let (rays, seconds) = (forecast.on().map(|line| line.rays).sum(), forecast.seconds());
    out += &format!(
        "{:<22}{:<7}{:>11}{seconds:>10.1}{:>16}  under {SUN_W_M2:.0} W/m2 of sun and {SKY_W_M2:.0} of uniform sky\n",
        "all",
        "",
        rounded(rays),
        at_most(forecast.loss_w_m2()),
    );
    out
}

/// Returns a table of the losses by effect over a year, by groups of receivers.
pub fn losses(losses: &YearLosses) -> String {
    let mut out = format!("\n{:<13}{:>8}", "sky view", "kWh/m2");
    Effect::ALL.iter().for_each(|effect| out += &format!("{:>24}", format!("without {}", effect.name())));
    out += "\n";
    for (i, group) in losses.groups.iter().enumerate() {
        let [low, high] = group.sky_view;
        let name = if i == 0 { "all".into() } else { format!("{low:.2} to {high:.2}") };
        out += &format!("{name:<13}{:>8.1}", group.total_kwh_m2);
        for effect in Effect::ALL {
            let bound = group.losses[effect as usize].bound_kwh_m2;
            let cell = match bound > 0.0 {
                true => format!("<= {bound:.2} ({:.2} %)", group.percent(effect)),
                false => "0".into(),
            };
            out += &format!("{cell:>24}");
        }
        out += "\n";
    }
    let asked = match losses.sample < losses.receivers {
        true => format!("{} of {} receivers", losses.sample, losses.receivers),
        false => counted(losses.receivers as u64, "receiver"),
    };
    out += &format!(
        "sums over {} of {asked}: means of groups of receivers by sky view, and the most that a group loses\n\
         without an effect (without canopies: gains); diffuse includes bounces; {:.1} s\n",
        losses.weather, losses.seconds
    );
    out
}

/// Formats an upper bound, W/m2. More than twice the sun's irradiance counts as unbounded.
fn at_most(bound: f64) -> String {
    match bound {
        b if b <= 0.0 => "0".into(),
        b if b > 2.0 * SUN_W_M2 => "unbounded".into(),
        b => format!("<= {b:.3}"),
    }
}

/// Formats a number of rays with a prefix: 12.3 M.
fn rounded(rays: f64) -> String {
    match rays {
        r if r >= 1e9 => format!("{:.1} G", r / 1e9),
        r if r >= 1e6 => format!("{:.1} M", r / 1e6),
        r if r >= 1e3 => format!("{:.1} k", r / 1e3),
        r => format!("{r:.0}"),
    }
}

/// Describes the chosen settings and their expected error, before the build.
pub fn choice(choice: &SettingsChoice) -> String {
    let (stated, a, [sky, seen, bounced, patches]) =
        (choice.settings.stated(), &choice.accuracy, choice.sources_percent);
    let missed = match a.predicted_percent > a.target_percent {
        true => " (the finest settings are not enough)",
        false => "",
    };
    let of = |ladder: Ladder| {
        let numbers = stated.numbers().filter(|(setting, _)| setting.ladder == ladder);
        numbers.map(|(setting, number)| format!("{}={number}", setting.name)).collect::<Vec<_>>().join(" ")
    };
    format!(
        "error wanted: at most {} %, expected: {:.2} %{missed}, RMSE of hourly totals in percent of their mean\n  \
         sun and sky, direct   {sky:.2} %  {}\n  \
         one reflection        {seen:.2} %  {}\n  \
         further reflections   {bounced:.2} %  {}\n  \
         sky patches           {patches:.2} %  {}\n",
        a.target_percent,
        a.predicted_percent,
        of(Ladder::Sky),
        of(Ladder::Seen),
        of(Ladder::Bounced),
        of(Ladder::Patches)
    )
}

/// Describes the expected and measured error, after the build.
pub fn outcome(choice: &SettingsChoice) -> String {
    let a = &choice.accuracy;
    let above = match a.rmse_percent > a.target_percent {
        true => format!(": more than the {} % wanted", a.target_percent),
        false => String::new(),
    };
    let mut out = format!(
        "error: {:.2} % expected, {:.2} % ({:.2} W/m2) found on {} (bias {:.2} %, means over all hours {:.2} %){above}\n",
        a.predicted_percent,
        a.rmse_percent,
        a.rmse_w_m2(),
        counted(a.sample, "receiver"),
        a.bias_percent,
        a.yearly_percent,
    );
    for hours in &a.hours {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "  {}", in_hours(hours));
    }
    out
}

/// Describes the expected time of a build and the time that it took.
pub fn time(choice: &SettingsChoice, expected_s: f64, report: &BuildReport) -> String {
    let taken_s: f64 = report.seconds.iter().map(|stage| stage.1).sum();
    format!(
        "time: {expected_s:.1} s expected, {taken_s:.1} s taken, after {:.1} s to choose the settings\n",
        choice.pilot_s
    )
}

/// Describes the error in one kind of hours.
pub fn in_hours(hours: &HoursError) -> String {
    format!(
        "in hours with {} ({:.0} % of all): {:.2} % of their mean ({:.2} of {:.1} W/m2), reflected light {:.2} % ({:.2} of {:.1} W/m2)",
        hours_in_words(&hours.hours),
        hours.share_percent,
        hours.rmse_percent(),
        hours.rmse_w_m2,
        hours.mean_w_m2,
        hours.reflected_percent(),
        hours.reflected_w_m2,
        hours.reflected_mean_w_m2
    )
}

/// Returns the words for a kind of hours, to follow "hours with".
fn hours_in_words(kind: &str) -> String {
    match kind {
        "mostly reflected" => "mostly reflected light".into(),
        other => other.into(),
    }
}

/// Returns the summary of a finished build.
pub fn summary(report: &BuildReport, output: &Path) -> String {
    format!(
        "{}: {}, {:.2} MB, root {}\n",
        output.display(),
        counted(report.counts.receivers, "receiver"),
        report.bytes as f64 / 1e6,
        format::hex(&report.root)
    )
}

/// Returns the counts, rays and seconds of a finished build.
pub fn work(report: &BuildReport, scene: &Scene) -> String {
    let counts = &report.counts;
    let total: f64 = report.seconds.iter().map(|s| s.1).sum();
    let rays = report.rays.total();
    let each = |x: f64| x / counts.receivers.max(1) as f64;
    let stages: Vec<String> = report.seconds.iter().map(|(name, s)| format!("{name} {s:.2}")).collect();
    let kept = report.kept.map_or_else(String::new, |kept| {
        let share = |count: u64, all: u64| format!("{:.1} %", 100.0 * count as f64 / all.max(1) as f64);
        format!(
            "  reused: {} of the receivers, {} of the probes, {} of the bounce cells\n",
            share(kept.receivers, counts.receivers),
            share(kept.probes, counts.probes),
            share(kept.bounce_cells, counts.bounce_cells)
        )
    });
    format!(
        "  {} probes, {} bounce cells, {} triangles\n  {:.1} Mray ({:.0} a receiver), {:.0} bytes a receiver\n{kept}  {total:.2} s: \
         {}\n",
        counts.probes,
        counts.bounce_cells,
        scene.mesh.triangles.len(),
        rays as f64 / 1e6,
        each(rays as f64),
        each(report.bytes as f64),
        stages.join(", "),
    )
}

/// Returns a note on light that is not followed because it meets too many mirrors, if there is any.
pub fn lost_in_mirrors(report: &BuildReport) -> Option<String> {
    let [receivers, cells] = report.lost_in_mirrors.map(|share| share * 100.0);
    let lost = format!(
        "light is not followed beyond {MAX_MIRRORS} mirrors: at most {receivers:.1} % of the view of a receiver, {cells:.1} % of \
         the view of a cell"
    );
    (report.lost_in_mirrors != [0.0, 0.0]).then_some(lost)
}
