//! Requests of the worker, as they stand in JSON.

use serde::Deserialize;

use crate::asked::{AirAsk, Changes, MinutesAsk, MomentAsk, SumAsk, WeatherTexts};
use crate::comfort::ComfortAsk;
use crate::matching::AskedPlace;
use crate::site::Beside;

/// Request to the engine. The names of its fields are those of the worker.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", rename_all_fields = "camelCase", tag = "request")]
pub enum Request {
    /// Opens the archive of the host, `bytes` long. `beside` is the archive that the page shows it
    /// with.
    Open {
        name: String,
        bytes: u64,
        #[serde(default)]
        beside: Option<Beside>,
    },
    /// Divides the memory for tiles among `workers` engines.
    Share { workers: usize },
    /// Finds the receivers that two archives have in common.
    Match { before: Vec<AskedPlace>, after: Vec<AskedPlace> },
    /// Asks for a chunk of the scene's triangles.
    Scene { chunk: u32 },
    /// Asks for the places and patches of a tile's receivers.
    Overview { tile: u32 },
    /// Asks for the rows of a tile's receivers.
    Receivers { tile: u32 },
    /// Reads the weather file whose bytes go with the request.
    LoadWeather {
        name: String,
        #[serde(default)]
        options: WeatherTexts,
    },
    /// Takes a picture of clouds, whose levels of red, green, blue and opacity go with the request.
    /// A picture of 0 pixels a side removes it. `map` is the number of points a side of the map
    /// that is answered.
    Clouds {
        side: usize,
        #[serde(default)]
        map: usize,
    },
    /// Puts the picture of clouds before the sky, with its top at an azimuth, or removes it from
    /// there.
    TurnClouds { top: Option<f64> },
    /// Asks for the position of the sun.
    Sun { day_of_year: u32, minutes: f64 },
    /// Asks for DNI and DHI under a clear sky.
    Clear { day_of_year: u32, minutes: f64 },
    /// Asks for a tile at one moment. `next` names the tiles that follow.
    Moment {
        ask: MomentAsk,
        tile: u32,
        #[serde(default)]
        next: Vec<u32>,
    },
    /// Asks for the light of a moment, for a graphics card.
    Light { ask: MomentAsk },
    /// Asks for a tile for a graphics card, for moments of a sun with these changes. `next` names
    /// the tiles that follow.
    Textures {
        changes: Changes,
        tile: u32,
        #[serde(default)]
        next: Vec<u32>,
    },
    /// Asks for a tile's sums over weather.
    Sums { ask: SumAsk, tile: u32 },
    /// Asks for a tile's minutes of sun on a day, or of sun in mirrors.
    SunMinutes { ask: MinutesAsk, tile: u32 },
    /// Asks if the receivers are people, and which numbers people have.
    People,
    /// Asks for the known values of the air of a moment.
    Air { air: AirAsk },
    /// Asks for the comfort of people of a tile.
    Comfort {
        ask: ComfortAsk,
        tile: u32,
        #[serde(default)]
        next: Vec<u32>,
    },
    /// Asks for sums of one receiver by month.
    Months { tile: u32, row: usize, sky: String, changes: Changes },
    /// Asks for the hours of a day of one receiver.
    Day { tile: u32, row: usize, day_of_year: u32, sky: String, changes: Changes },
    /// Asks for the view of a receiver as a disc.
    Fisheye { tile: u32, row: usize, side: usize },
}
