//! Distance between a weather file and a scene. In: both. Out: a sentence if they are far apart.

use crate::series::Weather;
use heliotile_core::site::place::Place;
use heliotile_core::text::{Message, message};

/// Largest distance without a warning, km: the distance between stations of a typical-year set.
const FAR_KM: f64 = 100.0;

/// Returns a warning if the weather belongs to another place.
pub fn far_apart(place: &Place, weather: &Weather) -> Option<Message> {
    let (latitude, longitude) = (weather.site.latitude_deg, weather.site.longitude_deg);
    let distance = place.distance_km(latitude, longitude);
    let side = |degrees: f64, positive: &str, negative: &str| {
        format!("{:.2} {}", degrees.abs(), if degrees < 0.0 { negative } else { positive })
    };
    let spelt = |latitude, longitude| format!("{} {}", side(latitude, "N", "S"), side(longitude, "E", "W"));
    (distance > FAR_KM).then(|| {
        message!(
            "the weather is that of {} ({}), {distance:.0} km from the scene at {}: give {{weather}} of a place nearby, or {{crs}}, the coordinate system of the scene",
            weather.place.split_whitespace().collect::<Vec<_>>().join(" "),
            spelt(latitude, longitude),
            spelt(place.latitude_deg, place.longitude_deg)
        )
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::formats::weather_file::parse_weather;

    /// The weather of Golden is 7,750 km from The Hague, which gives a warning with both places,
    /// and 16 km from Denver, which gives none.
    #[test]
    fn distant_weather_gives_a_warning() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/weather/golden_tmy3.epw");
        let weather = parse_weather(&path, &std::fs::read(&path).expect("data")).expect("weather");
        let place =
            |latitude_deg, longitude_deg| Place { latitude_deg, longitude_deg, convergence_deg: 0.0, epsg: None };
        let said = far_apart(&place(52.095, 4.264), &weather).expect("far");
        assert!(said.contains("39.74 N 105.18 W") && said.contains("km from the scene at 52.09 N 4.26 E"), "{said:?}");
        let distance = place(52.095, 4.264).distance_km(39.74, -105.18);
        assert!((distance - 7_750.0).abs() < 20.0, "{distance}");
        assert_eq!(far_apart(&place(39.74, -104.99), &weather), None);
    }
}
