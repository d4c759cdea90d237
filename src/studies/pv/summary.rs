//! Summary of `pv` as a table for people.

use std::path::Path;

use heliotile_results::outputs::pv::energy::years_in;
use heliotile_results::outputs::pv::ground::{GroundSums, SumsOnGround};
use heliotile_results::outputs::pv::search::PointSearch;
use heliotile_results::outputs::pv::sums::SideSums;

/// Largest number of rows; the rest is in the files.
const MAX_ROWS: usize = 20;

/// Returns the sums of sides, means and extremes on the ground if it has receivers, and the best
/// orientations if there was a search. `hours` is the length of the weather.
pub fn table(
    sides: &[SideSums],
    searched: &[PointSearch],
    ground: &SumsOnGround,
    weather: &Path,
    hours: f64,
) -> String {
    let years = years_in(hours).filter(|years| *years > 1.0);
    let period = years.map_or(String::new(), |years| format!(" in {years} years"));
    let mut out = format!(
        "\nIrradiation through {}, kWh/m2{period}:\n{:<20}{:>6}{:>7}{:>8}{:>9}{:>10}{:>10}{:>8}{:>9}\n",
        weather.display(),
        "point",
        "tilt",
        "azim.",
        "sun",
        "sky",
        "reflected",
        "total",
        "loss %",
        "sky view"
    );
    for side in sides.iter().take(MAX_ROWS) {
        let [sun, sky, sun_reflected, sky_reflected, sun_mirrored, sky_mirrored] = side.months.parts();
        let name = [side.point.as_str(), side.side].join(" ");
        let loss = side.loss_percent().map_or_else(|| "-".to_owned(), |loss| format!("{loss:.2}"));
        let turn = side.turn.map(|turn| [turn.tilt_deg, turn.azimuth_deg].map(|degrees| format!("{degrees:.1}")));
        let [tilt, azimuth] = turn.unwrap_or_else(|| ["turns", "-"].map(str::to_owned));
        out += &format!(
            "{:<20}{tilt:>6}{azimuth:>7}{sun:>8.1}{sky:>9.1}{:>10.1}{:>10.1}{loss:>8}{:>9.3}\n",
            name.trim_end(),
            sun_reflected + sky_reflected + sun_mirrored + sky_mirrored,
            side.months.total(),
            side.sky_view
        );
    }
    out += &rest(sides.len());
    out += &on_ground(ground);
    if !searched.is_empty() {
        out += &format!(
            "\n{:<20}{:>6}{:>7}{:>10}{:>14}{:>15}{:>20}\n",
            "best orientation of", "tilt", "azim.", "total", "flat loses %", "given loses %", "on an open plain"
        );
    }
    for search in searched.iter().take(MAX_ROWS) {
        let (best, open) = (search.best, search.open_best);
        let given =
            search.given.map_or_else(|| "-".to_owned(), |given| format!("{:.2}", search.loss_percent(given.value)));
        out += &format!(
            "{:<20}{:>6.1}{:>7.1}{:>10.1}{:>14.2}{given:>15}{:>20}\n",
            search.point,
            best.turn.tilt_deg,
            best.turn.azimuth_deg,
            best.value,
            search.loss_percent(search.flat.value),
            format!("{:.1} / {:.1}", open.turn.tilt_deg, open.turn.azimuth_deg)
        );
    }
    out + &rest(searched.len())
}

/// Returns a line for the ground of each set of rows.
fn on_ground(ground: &SumsOnGround) -> String {
    if ground.places.is_empty() {
        return String::new();
    }
    let mut out = format!(
        "\n{:<20}{:>7}{:>10}{:>14}{:>21}{:>8}{:>8}\n",
        "ground among", "places", "total", "PAR mol/m2 d", "PAR of open %: mean", "least", "most"
    );
    for places in ground.places.chunk_by(|a, b| a.rows == b.rows) {
        let mean = |value: &dyn Fn(&GroundSums) -> f64| places.iter().map(value).sum::<f64>() / places.len() as f64;
        let shares: Vec<f64> = places.iter().filter_map(GroundSums::par_of_open_percent).collect();
        // An open plain without light gives no shares.
        let of_shares = |value: f64| if shares.is_empty() { "-".to_owned() } else { format!("{value:.1}") };
        out += &format!(
            "{:<20}{:>7}{:>10.1}{:>14.2}{:>21}{:>8}{:>8}\n",
            places.first().map_or("", |place| place.rows.as_str()),
            places.len(),
            mean(&|place| place.months.total()),
            mean(&|place| place.daily_photons(&ground.days).unwrap_or_default()),
            of_shares(shares.iter().sum::<f64>() / shares.len() as f64),
            of_shares(shares.iter().copied().fold(f64::INFINITY, f64::min)),
            of_shares(shares.iter().copied().fold(0.0, f64::max))
        );
    }
    out
}

fn rest(count: usize) -> String {
    let more = count.saturating_sub(MAX_ROWS);
    if more > 0 { format!("... and {more} more, in the files\n") } else { String::new() }
}
