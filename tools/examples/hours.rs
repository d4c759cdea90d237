//! Passes hours to a function of the caller, a tile of receivers at a time: the brightest hour of
//! each receiver.
//!
//! `cargo run --release --example hours -- SITE.helio WEATHER`

use heliotile::{Component, ReplayRequest, Resources, Site};

fn main() -> heliotile::Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match words.as_slice() {
        [archive, weather] => {
            brightest(archive, weather, |id, hour, w_m2| println!("{id}: hour {hour}, {w_m2:.0} W/m2"))
        }
        _ => Err(heliotile::Error::argument("words", "are not two", "SITE.helio WEATHER")),
    }
}

/// Calls `each` for each receiver with the number of its brightest hour and the irradiance then,
/// W/m2.
fn brightest(archive: &str, weather: &str, mut each: impl FnMut(&str, usize, f32)) -> heliotile::Result<()> {
    Site::open(archive)?.each_tile(&ReplayRequest::new(weather), &Resources::usual(), |tile| {
        for (row, id) in tile.ids.iter().enumerate() {
            let hours = tile.values.row(Component::Total, row).iter().copied().enumerate();
            if let Some((hour, w_m2)) = hours.max_by(|a, b| a.1.total_cmp(&b.1)) {
                each(id, hour, w_m2);
            }
        }
        Ok(true)
    })
}

#[cfg(test)]
mod tests {
    /// The brightest hour of each receiver of an archive is one of the 72 of three days, by day and
    /// between 10 and 1,400 W/m2.
    #[test]
    fn brightest_hours() {
        let data = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data");
        let (archive, weather) =
            (format!("{data}/archives/v1.7-box.helio"), format!("{data}/weather/golden_3_days.epw"));
        let mut found = Vec::new();
        super::brightest(&archive, &weather, |id, hour, w_m2| found.push((id.to_owned(), hour, w_m2))).expect("hours");
        assert!(!found.is_empty());
        for (id, hour, w_m2) in found {
            assert!(hour < 72 && (6..20).contains(&(hour % 24)), "{id}: {hour}");
            assert!((10.0..1400.0).contains(&w_m2), "{id}: {w_m2} W/m2");
        }
    }
}
