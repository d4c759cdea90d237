//! Place and clock of a weather file. In: the statements of the file and of the user, the place of
//! the scene. Out: a checked [`Location`].

use std::path::Path;

use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::site::place::Place;
use heliotile_core::text::message;
use heliotile_core::weather::options::WeatherOptions;
use heliotile_core::weather::time::sun::Location;

/// Function that returns the place of the scene. It is called only if a weather file does not state
/// its own.
pub type ScenePlace<'p> = &'p mut dyn FnMut() -> Result<Option<Place>>;

/// Statements of a file about its station; `None` where it makes none.
#[derive(Clone, Debug)]
pub struct Station {
    pub name: String,
    pub latitude_deg: Option<f64>,
    pub longitude_deg: Option<f64>,
    pub zone_hours: Option<f64>,
    /// True if the time stamps themselves state their zone, so that `zone_hours` cannot be wrong.
    pub zone_is_certain: bool,
    /// Elevation, metres; 0 if the file states none. It moves the sun by less than a thousandth of
    /// a degree.
    pub elevation_m: f64,
}

impl Station {
    /// Returns a station about which the file states everything.
    pub fn known(name: String, site: Location) -> Self {
        Station {
            name,
            latitude_deg: Some(site.latitude_deg),
            longitude_deg: Some(site.longitude_deg),
            zone_hours: Some(site.zone_hours),
            zone_is_certain: false,
            elevation_m: site.elevation_m,
        }
    }

    /// Returns the place and the standard time of `year`, where the user's statements override
    /// those of the file, and a sentence if it is the place of the scene.
    pub fn location(
        &self,
        path: &Path,
        options: &WeatherOptions,
        year: i32,
        scene: ScenePlace,
    ) -> Result<(Location, Option<String>)> {
        let mut latitude = options.latitude_deg.or(self.latitude_deg);
        let mut longitude = options.longitude_deg.or(self.longitude_deg);
        let mut note = None;
        // A latitude of the file with a longitude of the scene would be a third place.
        if latitude.is_none()
            && longitude.is_none()
            && let Some(Place { latitude_deg, longitude_deg, .. }) = scene()?
        {
            (latitude, longitude) = (Some(latitude_deg), Some(longitude_deg));
            note = Some(format!(
                "{}: states no place; the place of the scene is used: latitude {latitude_deg:.4}, longitude \
                 {longitude_deg:.4}",
                path.display()
            ));
        }
        let (Some(latitude), Some(longitude)) = (latitude, longitude) else {
            let missing = match (latitude, longitude) {
                (None, Some(_)) => "latitude",
                (Some(_), None) => "longitude",
                _ => "latitude and longitude",
            };
            let what = format!("does not state its {missing}");
            let hint = "give {latitude} and {longitude} in degrees, north and east positive";
            return Err(Error::input(path, None, what, hint));
        };
        let Some(zone) = options.zone.map(|zone| zone.standard_hours(year)).or(self.zone_hours) else {
            let hint = message!(
                "give {{time_zone}}, hours ahead of UTC in standard time, such as {{time_zone}} {:+03.0}:00, or {{time_zone}} UTC",
                longitude / 15.0
            );
            return Err(Error::input(path, None, "does not state the time zone of its time stamps", hint)
                .because(Problem::Lacks("time zone")));
        };
        let site = Location::new(latitude, longitude, zone, self.elevation_m).map_err(|what| {
            Error::input(path, None, what, "correct {latitude}, {longitude} or {time_zone}, or the values in the file")
        })?;
        Ok((site, note))
    }
}
