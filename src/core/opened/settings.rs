//! Settings of a site. In: the settings of a manifest. Out: numbers in range.

use std::path::Path;

use crate::archive::manifest::Settings;
use crate::error::{Error, Result};
use crate::layers::canopy::{RayLists, sky_side};
use crate::layers::cells::CHUNK_SEEN;
use crate::layers::sides::TextureSides;
use crate::site::cells::level_of;

/// Largest sides of textures: of a receiver's sky before refinement and its hits, of the refined
/// sky, of cells' skies.
const MAX_SIDES: [u32; 3] = [1024, 4096, 256];

/// Settings that do not shape a layer: defaults of a replay.
const OF_REPLAY: [&str; 2] = ["patches", "steps"];

/// Settings that give the layers of a site their shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SiteSettings {
    /// Side of the receivers' sky texture before it is refined.
    pub sky_base: usize,
    /// Side of the finest level of the receivers' sky texture: the base doubled some times.
    pub sky_fine: usize,
    /// Side of the hit texture.
    pub hit: usize,
    /// Side of the probes' sky texture, and of the response.
    pub probe: usize,
    /// Number of rays from a probe to its surroundings.
    pub probe_hits: usize,
    /// Side of the bounce cells' sky texture.
    pub bounce_sky: usize,
    /// Number of rays from a bounce cell to its surroundings.
    pub bounce_hits: usize,
    /// Level of the bounce cells at middle distance: from this level up cells see each other in
    /// circles.
    pub closed_level: i8,
    /// True if diffuse reflections were traced.
    pub diffuse: bool,
}

impl SiteSettings {
    /// Returns the settings if textures and rays can have them; errors name the archive by `path`.
    pub fn new(stated: &Settings, path: &Path) -> Result<Self> {
        let refuse = |found: String, supported: String| {
            let what = format!("{}: settings in the manifest", path.display());
            Err(Error::Unsupported { what: what.into(), found, supported: supported.into() })
        };
        let [plain, fine, cell] = MAX_SIDES;
        for (name, number, most) in [
            ("sky_base", stated.sky_base, plain),
            ("sky_fine", stated.sky_fine, fine),
            ("hit", stated.hit, plain),
            ("probe", stated.probe, cell),
            ("bounce_sky", stated.bounce_sky, cell),
            ("probe_hits", stated.probe_hits, CHUNK_SEEN as u32),
            ("bounce_hits", stated.bounce_hits, CHUNK_SEEN as u32),
        ] {
            if number == 0 || number > most {
                return refuse(format!("{name} {number}"), format!("1 to {most}"));
            }
        }
        let (base, fine) = (stated.sky_base, stated.sky_fine);
        if fine % base != 0 || !(fine / base).is_power_of_two() {
            return refuse(format!("sky_fine {fine}"), format!("sky_base {base} times a power of two"));
        }
        for (setting, number) in stated.numbers().filter(|(setting, _)| OF_REPLAY.contains(&setting.name)) {
            if !setting.range.contains(number) {
                return refuse(format!("{} {number}", setting.name), setting.range.to_string());
            }
        }
        if !(stated.closed_m.is_finite() && stated.closed_m > 0.0) {
            return refuse(format!("closed_m {}", stated.closed_m), "a size above 0 m".to_string());
        }
        Ok(SiteSettings {
            sky_base: base as usize,
            sky_fine: fine as usize,
            hit: stated.hit as usize,
            probe: stated.probe as usize,
            probe_hits: stated.probe_hits as usize,
            bounce_sky: stated.bounce_sky as usize,
            bounce_hits: stated.bounce_hits as usize,
            closed_level: level_of(stated.closed_m),
            diffuse: !stated.left_out.iter().any(|effect| effect == "diffuse"),
        })
    }

    /// Returns the sides of the textures that skies and suns are looked up in.
    pub fn sides(&self) -> TextureSides {
        TextureSides { sky_base: self.sky_base, sky_fine: self.sky_fine, response: self.probe }
    }

    /// Returns the rays of a receiver that may cross canopies: to the texels of its sky, and to its
    /// hits.
    pub fn receiver_rays(&self) -> RayLists {
        RayLists::of_receiver(sky_side(self.sky_base, self.sky_fine), self.hit * self.hit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The settings of `standard` are taken as they are. Eleven bad numbers and sizes are refused
    /// by name.
    #[test]
    fn settings_out_of_range_are_refused_by_name() {
        let good = Settings {
            sky_base: 128,
            sky_fine: 1024,
            hit: 32,
            probe: 32,
            probe_hits: 64,
            closed_m: 8.0,
            bounce_sky: 16,
            bounce_hits: 64,
            patches: 577,
            steps: 12,
            ..Settings::default()
        };
        let of = |settings: &Settings| SiteSettings::new(settings, Path::new("a.helio"));
        let taken = of(&good).expect("settings");
        assert_eq!((taken.sky_fine, taken.closed_level, taken.diffuse), (1024, level_of(8.0), true));
        assert_eq!(taken.receiver_rays(), RayLists::of_receiver(512, 1024));
        let lies = [
            ("sky_base 0", Settings { sky_base: 0, ..good.clone() }),
            ("sky_base 1025", Settings { sky_base: 1025, ..good.clone() }),
            ("sky_fine 384", Settings { sky_fine: 384, ..good.clone() }),
            ("hit 0", Settings { hit: 0, ..good.clone() }),
            ("probe 257", Settings { probe: 257, ..good.clone() }),
            ("bounce_sky 4294967295", Settings { bounce_sky: u32::MAX, ..good.clone() }),
            ("probe_hits 0", Settings { probe_hits: 0, ..good.clone() }),
            ("bounce_hits 32768", Settings { bounce_hits: 32768, ..good.clone() }),
            ("patches 0", Settings { patches: 0, ..good.clone() }),
            ("steps 0", Settings { steps: 0, ..good.clone() }),
            ("closed_m -1", Settings { closed_m: -1.0, ..good.clone() }),
        ];
        for (named, lie) in lies {
            let text = of(&lie).expect_err(named).to_string();
            assert!(text.contains(named) && text.starts_with("a.helio"), "{text}");
        }
        assert!(!of(&Settings { left_out: vec!["diffuse".into()], ..good }).expect("settings").diffuse);
    }
}
