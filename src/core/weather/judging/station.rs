//! Where a weather file is from, and what its clock shows. In: what the file says, what the user says, where the scene lies. Out: a
//! checked [`Location`].

use std::path::Path;

use crate::error::{Error, Result};
use crate::site::place::Place;
use crate::weather::options::WeatherOptions;
use crate::weather::time::sun::Location;

/// Where the scene lies, asked for only where a weather file does not say where it is from.
pub type ScenePlace<'p> = &'p mut dyn FnMut() -> Result<Option<Place>>;

/// What a file says of its station; `None` where it is silent.
#[derive(Clone, Debug)]
pub struct Station {
    pub name: String,
    pub latitude_deg: Option<f64>,
    pub longitude_deg: Option<f64>,
    pub zone_hours: Option<f64>,
    /// Whether the time stamps themselves say their zone, so that `zone_hours` cannot be wrong.
    pub zone_is_certain: bool,
    /// 0 where the file is silent: it moves the sun by less than a thousandth of a degree.
    pub elevation_m: f64,
}

impl Station {
    /// A station that the file knows all of.
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

    /// The place, with what the user says before what the file says, and a sentence if it is that of the scene.
    pub fn location(
        &self,
        path: &Path,
        options: &WeatherOptions,
        scene: ScenePlace,
    ) -> Result<(Location, Option<String>)> {
        let mut latitude = options.latitude_deg.or(self.latitude_deg);
        let mut longitude = options.longitude_deg.or(self.longitude_deg);
        let mut note = None;
        if latitude.is_none()
            && longitude.is_none()
            && let Some(Place { latitude_deg, longitude_deg, .. }) = scene()?
        {
            (latitude, longitude) = (Some(latitude_deg), Some(longitude_deg));
            note = Some(format!(
                "{}: does not say where it is from; the place of the scene is taken, latitude {latitude_deg:.4}, longitude \
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
            let what = format!("does not say where it is from: {missing} unknown");
            let hint = "give {latitude} and {longitude} in degrees, north and east positive";
            return Err(Error::input(path, None, what, hint));
        };
        let Some(zone) = options.zone_hours.or(self.zone_hours) else {
            let hint = format!(
                "give {{time_zone}}, hours ahead of UTC in standard time, such as {{time_zone}} {:+03.0}:00, or {{time_zone}} UTC",
                longitude / 15.0
            );
            return Err(Error::input(path, None, "does not say what time zone its time stamps are in", hint));
        };
        let site = Location::new(latitude, longitude, zone, self.elevation_m).map_err(|what| {
            Error::input(path, None, what, "correct {latitude}, {longitude} or {time_zone}, or what the file says")
        })?;
        Ok((site, note))
    }
}
