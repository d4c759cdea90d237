//! What `pv` found, as a table for people.

use std::path::Path;

use crate::outputs::pv::search::PointSearch;
use crate::outputs::pv::sums::SideSums;

/// Rows at most: the rest stands in the files.
const MOST_ROWS: usize = 20;

/// Sums of sides, and the best turns if there was a search.
pub fn table(sides: &[SideSums], searched: &[PointSearch], weather: &Path) -> String {
    let mut out = format!(
        "\nIrradiation through {}, kWh/m2:\n{:<20}{:>6}{:>7}{:>8}{:>9}{:>10}{:>10}{:>8}{:>9}\n",
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
    for side in sides.iter().take(MOST_ROWS) {
        let [sun, sky, sun_diffuse, sky_diffuse, sun_mirrored, sky_mirrored] = side.months.parts();
        let name = [side.point.as_str(), side.side].join(" ");
        let loss = side.loss_percent().map_or_else(|| "-".to_owned(), |loss| format!("{loss:.2}"));
        out += &format!(
            "{:<20}{:>6.1}{:>7.1}{sun:>8.1}{sky:>9.1}{:>10.1}{:>10.1}{loss:>8}{:>9.3}\n",
            name.trim_end(),
            side.turn.tilt_deg,
            side.turn.azimuth_deg,
            sun_diffuse + sky_diffuse + sun_mirrored + sky_mirrored,
            side.months.total(),
            side.sky_view
        );
    }
    out += &rest(sides.len());
    if !searched.is_empty() {
        out += &format!(
            "\n{:<20}{:>6}{:>7}{:>10}{:>14}{:>15}{:>20}\n",
            "best turn of", "tilt", "azim.", "total", "flat loses %", "given loses %", "on an open plain"
        );
    }
    for search in searched.iter().take(MOST_ROWS) {
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

fn rest(count: usize) -> String {
    let more = count.saturating_sub(MOST_ROWS);
    if more > 0 { format!("... and {more} more, in the files\n") } else { String::new() }
}
