//! Requests of the worker, as they stand in JSON.

use serde::Deserialize;

use crate::asked::{AirAsk, Changes, Clock, MinutesAsk, MomentAsk, SumAsk};
use crate::comfort::ComfortAsk;
use crate::matching::AskedPlace;
use crate::site::Beside;

/// A request; names of fields are those of the worker.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", rename_all_fields = "camelCase", tag = "request")]
pub enum Request {
    /// Opens the archive of the host, `bytes` long; `beside`: the archive that it is shown with.
    Open {
        name: String,
        bytes: u64,
        #[serde(default)]
        beside: Option<Beside>,
    },
    /// Keeps tiles in a share of the memory that one engine alone has, where there are so many.
    Share { workers: usize },
    /// Which receivers of two archives are the same ones.
    Match { before: Vec<AskedPlace>, after: Vec<AskedPlace> },
    /// A chunk of the scene's triangles.
    Scene { chunk: u32 },
    /// Places and patches of a tile's receivers.
    Overview { tile: u32 },
    /// What a tile's receivers are.
    Receivers { tile: u32 },
    /// Reads the weather file whose bytes go with the request.
    LoadWeather {
        name: String,
        #[serde(default)]
        clock: Clock,
    },
    /// Takes a picture of clouds, whose levels of red, green, blue and opacity go with the request;
    /// of 0 pixels a side, takes it away. `map`: points a side of the map that is answered.
    Clouds {
        side: usize,
        #[serde(default)]
        map: usize,
    },
    /// Puts the picture of clouds before the sky, with its top at an azimuth, or takes it away from
    /// there.
    TurnClouds { top: Option<f64> },
    /// Where the sun stands.
    Sun { day_of_year: u32, minutes: f64 },
    /// DNI and DHI under a clear sky.
    Clear { day_of_year: u32, minutes: f64 },
    /// A tile at one moment; `next` will be asked for after it.
    Moment {
        ask: MomentAsk,
        tile: u32,
        #[serde(default)]
        next: Vec<u32>,
    },
    /// The light of a moment for a graphics card.
    Light { ask: MomentAsk },
    /// A tile for a graphics card, for moments of a sun with these changes; `next` as of a moment.
    Textures {
        changes: Changes,
        tile: u32,
        #[serde(default)]
        next: Vec<u32>,
    },
    /// A tile's sums over weather.
    Sums { ask: SumAsk, tile: u32 },
    /// A tile's minutes of sun on a day, or of sun in mirrors.
    SunMinutes { ask: MinutesAsk, tile: u32 },
    /// Whether the receivers are people, and what can be asked of them.
    People,
    /// What is known of the air of a moment.
    Air { air: AirAsk },
    /// What people of a tile feel.
    Comfort {
        ask: ComfortAsk,
        tile: u32,
        #[serde(default)]
        next: Vec<u32>,
    },
    /// Sums of one receiver by month.
    Months { tile: u32, row: usize, sky: String, changes: Changes },
    /// The hours of a day of one receiver.
    Day { tile: u32, row: usize, day_of_year: u32, sky: String, changes: Changes },
    /// What a receiver sees.
    Fisheye { tile: u32, row: usize, side: usize },
}
