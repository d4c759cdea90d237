//! Settings of a build as native numbers. In: a rung of each ladder, the settings that an archive
//! states, numbers that the user sets by name. Out: numbers in range.

use heliotile_core::archive::settings::{Ladder, SETTINGS, Settings};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::for_each_setting;
use heliotile_core::named::NamedValues;
use heliotile_core::text::Message;

use super::effects::Effects;
use super::ladder::{PATCH_RUNGS, Rungs};
use super::quality::Quality;

/// Sharing of probes among receivers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Share {
    /// All receivers that see a cell share its probe.
    #[default]
    Cells,
    /// No sharing: every hit has a hemisphere of its own, the slow reference.
    None,
}

impl Share {
    /// Returns the name of the choice in the manifest.
    pub fn name(self) -> &'static str {
        match self {
            Share::Cells => "cells",
            Share::None => "none",
        }
    }
}

/// Version of the tracing. It goes up with every change that makes the same scene and settings give
/// other receivers or cells, so that stores, interrupted builds and merges do not mix old and new
/// ones.
///
/// - 1: points hidden in solids do not count, and receivers that no light reaches see nothing.
/// - 2: the lit side of a sheet hides nothing.
/// - 3: fewer paths decide if a side is lit.
/// - 4: receivers look for mirrors in parts of base texels.
/// - 5: points of cells count by how far nearby surfaces leave them open, cells near each other are
///   finer, fine probes are refined.
/// - 6: rays of hit and probe textures go near the middles of texels, points of neighbouring texels
///   lie far apart.
const TRACING: u32 = 7;

macro_rules! declare {
    ($($name:ident: $stored:ty as $native:ty, $range:ident($($bound:expr),*), $ladder:ident $rungs:tt, $meaning:literal;)*) => {
        /// Settings that decide what an archive of a scene holds. The defaults are the quality
        /// `standard`.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct BuildSettings {
            $(#[doc = $meaning] pub $name: $native,)*
            /// Sharing of cells among receivers.
            pub share: Share,
            /// Effects that are not traced although the scene has them.
            pub left_out: Effects,
        }

        impl BuildSettings {
            /// Returns the settings of a rung of each ladder, which share probes and leave nothing
            /// out.
            pub fn of_rungs(rungs: Rungs) -> Self {
                let settings = BuildSettings {
                    $($name: pick!($rungs, $native, rungs.at(Ladder::$ladder)),)*
                    share: Share::Cells,
                    left_out: Effects::NONE,
                };
                // The sky of a bounce cell needs no finer texture than that of the probes that see
                // it.
                BuildSettings { bounce_sky: settings.bounce_sky.min(settings.probe), ..settings }
            }

            /// Returns the settings that an archive states.
            pub fn of(stated: &Settings) -> Self {
                BuildSettings {
                    $($name: stated.$name as $native,)*
                    share: if stated.share == Share::None.name() { Share::None } else { Share::Cells },
                    left_out: Effects::of_names(&stated.left_out),
                }
            }

            /// Returns the settings as an archive states them.
            pub fn stated(&self) -> Settings {
                Settings {
                    quality: quality_of(self).map_or("", Quality::name).into(),
                    $($name: self.$name as $stored,)*
                    share: self.share.name().into(),
                    bounces: "all".into(),
                    left_out: self.left_out.names(),
                    tracing: TRACING,
                    ..Settings::default()
                }
            }

            /// Sets a number by name. `as` saturates, and [`BuildSettings::check`] refuses numbers
            /// out of range.
            fn set_number(&mut self, name: &str, number: f64) {
                match name {
                    $(stringify!($name) => self.$name = number as $native,)*
                    _ => {}
                }
            }

            /// Returns the numbers in the order of [`SETTINGS`].
            fn numbers(&self) -> [f64; SETTINGS.len()] {
                [$(self.$name as f64),*]
            }
        }
    };
}

/// Returns the number at place `$at` of a list.
macro_rules! pick {
    ([$($number:literal),*], $native:ty, $at:expr) => {{
        const RUNGS: &[$native] = &[$($number),*];
        RUNGS[$at]
    }};
}

for_each_setting!(declare);

impl Default for BuildSettings {
    fn default() -> Self {
        BuildSettings::of_rungs(Rungs::new(Quality::default()))
    }
}

impl Rungs {
    /// Returns the settings of the rungs, which share probes and leave nothing out.
    pub fn settings(self) -> BuildSettings {
        BuildSettings::of_rungs(self)
    }
}

/// Returns the number of sky patches of each rung.
pub fn patches() -> [usize; PATCH_RUNGS] {
    std::array::from_fn(|patches| Rungs { patches, ..Rungs::FINEST }.settings().patches)
}

/// Returns the quality with these settings, whatever they leave out.
fn quality_of(settings: &BuildSettings) -> Option<Quality> {
    let traced = BuildSettings { left_out: Effects::NONE, ..*settings };
    Quality::ALL.into_iter().find(|quality| Rungs::new(*quality).settings() == traced)
}

/// Returns the error for a wrong value of a setting.
fn wrong(what: String, hint: impl Into<Message>) -> Error {
    Error::argument("set", what, hint)
}

impl BuildSettings {
    /// Sets one number by `name=value`, with the name that the manifest uses.
    pub fn set(&mut self, text: &str) -> Result<()> {
        let Some((name, value)) = text.split_once('=') else {
            return Err(wrong(format!("`{text}` is not NAME=VALUE"), "write it as in {set} hit=16"));
        };
        let name = name.trim();
        let number = value.trim().parse::<f64>().ok().filter(|v| v.is_finite() && *v >= 0.0);
        let Some(number) = number else {
            return Err(wrong(format!("`{value}` is not a number for {name}"), "give a number from 0"));
        };
        let Some(setting) = SETTINGS.iter().find(|setting| setting.name == name) else {
            let mut names: Vec<&str> = SETTINGS.iter().map(|setting| setting.name).collect();
            names.sort_unstable();
            let unknown = Problem::unknown(name, names.iter().copied());
            return Err(wrong(format!("there is no setting `{name}`"), format!("set one of {}", names.join(", ")))
                .because(unknown));
        };
        if setting.range.is_whole() && number.fract() != 0.0 {
            return Err(wrong(format!("{name} is {value}, not a whole number"), "give a whole number"));
        }
        self.set_number(name, number);
        Ok(())
    }

    /// Checks that every number is in range and that the numbers fit each other.
    pub fn check(&self) -> Result<()> {
        for (setting, number) in SETTINGS.iter().zip(self.numbers()) {
            if !setting.range.contains(number) {
                return Err(wrong(format!("{} is {number}", setting.name), format!("give {}", setting.range)));
            }
        }
        if self.sky_fine < self.sky_base {
            return Err(wrong(format!("sky_fine is {}", self.sky_fine), "give at least sky_base"));
        }
        if self.bounce_sky > self.probe {
            return Err(wrong(format!("bounce_sky is {}", self.bounce_sky), "give at most probe"));
        }
        Ok(())
    }

    /// Returns the edge of a fine cell in footprints, or 0 if every hit has a probe of its own.
    pub(crate) fn cell_factor(&self) -> f64 {
        if self.share == Share::None { 0.0 } else { self.cell_factor }
    }

    /// Returns the hash of the settings. Builds with other settings have other hashes.
    pub fn hash(&self) -> Result<[u8; 32]> {
        self.stated().hash()
    }
}

impl NamedValues for Share {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("cells", "Receivers that see the same cell of a surface share its probe", Share::Cells),
        ("none", "No sharing: a hemisphere of its own for every hit, a slow reference", Share::None),
    ];
}

heliotile_core::parse_by_name!(Share);

#[cfg(test)]
mod tests {
    use super::*;

    /// All 4 named rungs are in range, are recognised from their settings, and are finer than the
    /// one before in every ladder. Settings with 1 changed number are no named rung.
    #[test]
    fn each_rung_is_finer_than_the_one_before() {
        for quality in Quality::ALL {
            let settings = Rungs::new(quality).settings();
            settings.check().expect("in range");
            assert_eq!(quality_of(&settings), Some(quality));
            assert_eq!(quality_of(&BuildSettings { probe_hits: 15, ..settings }), None);
        }
        for pair in Quality::ALL.windows(2) {
            let [coarse, fine] = [pair[0], pair[1]].map(Rungs::new);
            assert!(coarse.sky < fine.sky && coarse.seen < fine.seen && coarse.bounced < fine.bounced);
            assert!(coarse.patches <= fine.patches);
        }
        Rungs::FINEST.settings().check().expect("the finest");
        Rungs { sky: 0, seen: 0, bounced: 5, patches: 0 }.settings().check().expect("a coarse probe, fine bounces");
    }

    /// Settings of another tracing version have another hash: 2 hashes of 2 versions, 1 hash of
    /// equal settings.
    #[test]
    fn another_tracing_version_has_another_hash() {
        let now = BuildSettings::default().stated();
        let before = Settings { tracing: now.tracing - 1, ..now.clone() };
        assert_eq!(now.hash().expect("a hash"), BuildSettings::default().hash().expect("a hash"));
        assert_ne!(now.hash().expect("a hash"), before.hash().expect("a hash"));
    }

    /// Twelve settings can be set by name. 12 wrong texts are refused by name, and the defaults are
    /// in range.
    #[test]
    fn wrong_settings_are_refused_by_name() {
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
            assert!(error.starts_with("set: "), "{text}: {error}");
        }
    }
}
