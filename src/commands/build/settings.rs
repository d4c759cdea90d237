//! Settings of a build. In: defaults, and what the user sets by name. Out: numbers in range.

use super::ladder::{PATCHES, Rungs, quality_of};
use crate::cli::{Effects, Quality, Share};
use heliotile_core::archive::manifest::Settings;
use heliotile_core::error::{Error, Result};

/// Everything that decides what an archive of a scene holds. The defaults are the quality `standard`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildSettings {
    /// Side of the receivers' sky texture before and after refinement.
    pub sky_base: usize,
    pub sky_fine: usize,
    /// Side of the hit texture.
    pub hit: usize,
    /// Edge of a fine cell in units of the hit texel's footprint, and its smallest value.
    pub cell_factor: f64,
    pub cell_floor_m: f64,
    /// Side of the probes' sky texture and of the response.
    pub probe: usize,
    /// Rays of a probe to the surfaces around it.
    pub probe_hits: usize,
    /// Edge of the bounce cells at middle distance: the closed system.
    pub closed_m: f64,
    /// Side of the bounce cells' sky texture, and their rays to the surfaces around them.
    pub bounce_sky: usize,
    pub bounce_hits: usize,
    /// Sky patches and sun positions an hour that replay takes if it is not told otherwise.
    pub patches: usize,
    pub steps: u16,
    pub share: Share,
    /// What is not traced although the scene has it.
    pub left_out: Effects,
}

/// Sun positions of an interval: one a minute of an hour.
const MOST_STEPS: u16 = 60;

impl Default for BuildSettings {
    fn default() -> Self {
        Rungs::of(Quality::default()).settings()
    }
}

impl BuildSettings {
    /// Sets one number by `name=value`, named as in the manifest.
    pub fn set(&mut self, text: &str) -> Result<()> {
        let wrong = |what: String, hint: &str| Error::argument("--set", what, hint);
        let Some((name, value)) = text.split_once('=') else {
            return Err(wrong(format!("`{text}` is not NAME=VALUE"), "write it as in --set hit=16"));
        };
        let number = value.trim().parse::<f64>().ok().filter(|v| v.is_finite() && *v >= 0.0);
        let Some(number) = number else {
            return Err(wrong(format!("`{value}` is not a number for {name}"), "give a number above zero"));
        };
        // `as` saturates; `check` refuses what is out of range.
        let whole = number as usize;
        let mut steps = usize::from(self.steps);
        let sizes = [
            ("sky_base", &mut self.sky_base),
            ("sky_fine", &mut self.sky_fine),
            ("hit", &mut self.hit),
            ("probe", &mut self.probe),
            ("probe_hits", &mut self.probe_hits),
            ("bounce_sky", &mut self.bounce_sky),
            ("bounce_hits", &mut self.bounce_hits),
            ("patches", &mut self.patches),
            ("steps", &mut steps),
        ];
        let metres = [
            ("cell_factor", &mut self.cell_factor),
            ("cell_floor_m", &mut self.cell_floor_m),
            ("closed_m", &mut self.closed_m),
        ];
        let mut names: Vec<&str> = sizes.iter().map(|s| s.0).chain(metres.iter().map(|s| s.0)).collect();
        if let Some((_, slot)) = sizes.into_iter().find(|s| s.0 == name.trim()) {
            if whole as f64 != number {
                return Err(wrong(format!("{name} is {value}, not a whole number"), "give a whole number"));
            }
            *slot = whole;
        } else if let Some((_, slot)) = metres.into_iter().find(|s| s.0 == name.trim()) {
            *slot = number;
        } else {
            names.sort_unstable();
            return Err(wrong(format!("there is no setting `{name}`"), &format!("set one of {}", names.join(", "))));
        }
        self.steps = u16::try_from(steps).unwrap_or(u16::MAX);
        Ok(())
    }

    /// Refuses numbers that cannot work.
    pub fn check(&self) -> Result<()> {
        let wrong = |name: &str, value: f64, right: &str| {
            Err(Error::argument("--set", format!("{name} is {value}"), format!("give {right}")))
        };
        for (name, side, largest) in [
            ("sky_base", self.sky_base, 1024),
            ("sky_fine", self.sky_fine, 4096),
            ("hit", self.hit, 256),
            ("probe", self.probe, 128),
            ("bounce_sky", self.bounce_sky, 64),
        ] {
            if !side.is_power_of_two() || !(8..=largest).contains(&side) {
                return wrong(name, side as f64, &format!("a power of two from 8 to {largest}"));
            }
        }
        if self.sky_fine < self.sky_base {
            return wrong("sky_fine", self.sky_fine as f64, "at least sky_base");
        }
        if self.bounce_sky > self.probe {
            return wrong("bounce_sky", self.bounce_sky as f64, "at most probe");
        }
        for (name, rays) in [("probe_hits", self.probe_hits), ("bounce_hits", self.bounce_hits)] {
            if !(1..=4096).contains(&rays) {
                return wrong(name, rays as f64, "1 to 4096");
            }
        }
        if !PATCHES.contains(&self.patches) {
            return wrong("patches", self.patches as f64, "145, 577 or 2305");
        }
        if !(1..=MOST_STEPS).contains(&self.steps) {
            return wrong("steps", f64::from(self.steps), &format!("1 to {MOST_STEPS}"));
        }
        for (name, size, low, high) in [
            ("cell_factor", self.cell_factor, 0.25, 64.0),
            ("cell_floor_m", self.cell_floor_m, 0.01, 256.0),
            ("closed_m", self.closed_m, 0.5, 1024.0),
        ] {
            if !(low..=high).contains(&size) {
                return wrong(name, size, &format!("{low} to {high}"));
            }
        }
        Ok(())
    }

    /// Edge of a fine cell in footprints; 0 when every hit has a probe of its own.
    pub(super) fn cell_factor(&self) -> f64 {
        if self.share == Share::None { 0.0 } else { self.cell_factor }
    }

    /// The settings as the archive states them.
    pub fn stated(&self) -> Settings {
        let s = self;
        Settings {
            quality: quality_of(s).map_or("", Quality::name).into(),
            sky_base: s.sky_base as u32,
            sky_fine: s.sky_fine as u32,
            hit: s.hit as u32,
            cell_factor: s.cell_factor,
            cell_floor_m: s.cell_floor_m,
            probe: s.probe as u32,
            probe_hits: s.probe_hits as u32,
            closed_m: s.closed_m,
            bounce_sky: s.bounce_sky as u32,
            bounce_hits: s.bounce_hits as u32,
            share: if s.share == Share::None { "none" } else { "cells" }.into(),
            bounces: "all".into(),
            patches: s.patches as u32,
            steps: s.steps,
            left_out: s.left_out.names(),
            ..Settings::default()
        }
    }
    /// The settings that an archive states.
    pub fn of(stated: &Settings) -> Self {
        BuildSettings {
            sky_base: stated.sky_base as usize,
            sky_fine: stated.sky_fine as usize,
            hit: stated.hit as usize,
            cell_factor: stated.cell_factor,
            cell_floor_m: stated.cell_floor_m,
            probe: stated.probe as usize,
            probe_hits: stated.probe_hits as usize,
            closed_m: stated.closed_m,
            bounce_sky: stated.bounce_sky as usize,
            bounce_hits: stated.bounce_hits as usize,
            patches: stated.patches as usize,
            steps: stated.steps,
            share: if stated.share == "none" { Share::None } else { Share::Cells },
            left_out: Effects::of_names(&stated.left_out),
        }
    }

    /// Names the settings: builds with other ones have other hashes.
    pub fn hash(&self) -> Result<[u8; 32]> {
        self.stated().hash()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twelve settings can be set by name; 12 wrong texts are refused by name, and the defaults are in range.
    #[test]
    fn settings_by_name() {
        let mut settings = BuildSettings::default();
        settings.check().expect("the defaults");
        assert_eq!(BuildSettings::of(&settings.stated()), settings);
        for text in
            ["sky_base=64", "sky_fine=512", "hit=16", "probe=16", "probe_hits=8", "bounce_sky=8", "bounce_hits=9"]
        {
            settings.set(text).expect(text);
        }
        for text in ["cell_factor=2", "cell_floor_m = 0.25", "closed_m=16", "patches=145", "steps=3"] {
            settings.set(text).expect(text);
        }
        settings.check().expect("good ones");
        assert_eq!((settings.hit, settings.bounce_hits, settings.cell_floor_m), (16, 9, 0.25));
        for text in [
            "hit",
            "hit=x",
            "hit=1.5",
            "hit=-8",
            "hit=inf",
            "sky=3",
            "hit=12",
            "bounce_sky=32",
            "closed_m=0",
            "patches=100",
            "steps=0",
            "steps=61",
        ] {
            let mut wrong = settings;
            let error = wrong.set(text).and_then(|()| wrong.check()).expect_err(text).to_string();
            assert!(error.starts_with("--set: "), "{text}: {error}");
        }
    }
}
