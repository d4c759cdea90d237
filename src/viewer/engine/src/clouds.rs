//! Clouds before the sky and the sun. In: the pixels of a picture, and the azimuth of its top. Out:
//! the light that passes.

use heliotile_core::dome::image::DomeImage;
use heliotile_core::replay::seen::SkyDisc;
use heliotile_core::sky::own_skies::{CloudLayer, no_parts};
use heliotile_weather::skies::luminance;
use serde_json::json;

use crate::Answered;
use crate::answer::{Answer, Numbers};
use crate::asked::sky_of;
use crate::failure::{Failure, Kind};
use crate::light::Forced;

/// Number of levels of a pixel: red, green, blue, and opacity, which is ignored.
const CHANNELS: usize = 4;

/// Largest number of points to a side of a map.
const MAX: usize = 2048;

/// Picture of the shares of light that pass, and its layer if it stands before the sky.
#[derive(Default)]
pub struct Clouds {
    picture: Option<DomeImage>,
    layer: Option<CloudLayer>,
}

impl Clouds {
    /// Replaces the picture by one of `side` x `side` pixels, or removes it if `side` is 0. The new
    /// picture does not stand before the sky yet. Answers a map of `map` points a side, by rows
    /// from the top, whose top is the top of the picture: the hidden share, 0 to 255; 0 beyond the
    /// horizon.
    pub fn take(&mut self, side: usize, levels: &[u8], map: usize) -> Answered {
        *self = Clouds::default();
        if map > MAX || side.checked_mul(side).and_then(|all| all.checked_mul(CHANNELS)) != Some(levels.len()) {
            let what = format!("{} levels for {side} x {side} pixels, a map of {map}", levels.len());
            return Err(Failure::new(Kind::Other, what, ""));
        }
        let share = |pixel: &[u8]| match pixel {
            [red, green, blue, ..] => luminance([*red, *green, *blue].map(|level| f64::from(level) / 255.0)) as f32,
            _ => 0.0,
        };
        self.picture = DomeImage::new(side, levels.chunks_exact(CHANNELS).map(share).collect(), 0.0);
        let at = |i: usize| (i as f64 + 0.5) / map as f64 * 2.0 - 1.0;
        let hidden = |i: usize| {
            let share = self.picture.as_ref().zip(SkyDisc::direction_at(at(i % map), -at(i / map)));
            share.map_or(0, |(picture, direction)| (255.0 * (1.0 - picture.at(direction))).round() as u8)
        };
        let hidden: Vec<u8> = (0..map * map).map(hidden).collect();
        Ok(Answer::of(json!({ "side": map })).with("hidden", Numbers::U8(&hidden)))
    }

    /// Puts the picture before the sky, with its top at an azimuth, degrees clockwise from true
    /// north. Removes it from there if `top` is `None`.
    pub fn turn(&mut self, top: Option<f64>) {
        let turned = self.picture.as_ref().zip(top).map(|(picture, top)| picture.turned(top));
        self.layer = turned.and_then(CloudLayer::of_image);
    }

    /// Returns the light of a sky behind the clouds, which are equal at all hours. Returns an error
    /// for a sky that no clouds can stand before.
    pub fn over(&self, sky: &str, light: Forced) -> heliotile_core::error::Result<Forced> {
        let Some(layer) = &self.layer else { return Ok(light) };
        if sky_of(sky)?.brightens() {
            return Err(no_parts());
        }
        let conditions = light.conditions.into_iter().map(|condition| layer.over(condition, 0)).collect();
        Ok(Forced { conditions, ..light })
    }
}
