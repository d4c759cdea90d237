//! Colours of numbers. In: a share from 0 to 1. Out: red, green, blue.

use std::sync::LazyLock;

use super::drawing::Rgb;
use super::scale::round_steps;
use heliotile_core::replay::components::Component;

/// Number of colours of the map `viridis`.
pub const STEPS: usize = 256;

/// Source files of the page's colour maps: one definition for both.
const PAGE: [&str; 2] = [include_str!("../../page/viridis.ts"), include_str!("../../page/puor.ts")];

static VIRIDIS: LazyLock<Vec<Rgb>> = LazyLock::new(|| stops(PAGE[0]));

/// Map `PuOr` of 11 classes of ColorBrewer (C. Brewer, M. Harrower, Pennsylvania State University
/// 2002, Apache-style licence), from violet over near white to orange. Colour-blind people can read
/// it, too.
static PUOR: LazyLock<Vec<[f32; 3]>> =
    LazyLock::new(|| stops(PAGE[1]).iter().map(|stop| stop.map(f32::from)).collect());

/// Returns the colours of a map in a source file of the page.
fn stops(file: &str) -> Vec<Rgb> {
    // Colours are the only quoted words of the file that consist of hexadecimal digits.
    let rows = file.split('"').filter(|row| row.len() >= 6 && row.bytes().all(|digit| digit.is_ascii_hexdigit()));
    let digits: String = rows.collect();
    let colour = |six: &[u8; 6]| {
        let part = |two: &[u8]| std::str::from_utf8(two).ok().and_then(|two| u8::from_str_radix(two, 16).ok());
        [0, 2, 4].map(|at| part(&six[at..at + 2]).unwrap_or_default())
    };
    digits.as_bytes().as_chunks().0.iter().map(colour).collect()
}

/// Returns the index of the colour of a share from 0 to 1 in the map `viridis`, rounded as in the
/// page.
pub fn viridis_step(share: f32) -> u8 {
    (share.clamp(0.0, 1.0) * (STEPS - 1) as f32).round() as u8
}

/// Returns one of the 256 colours of the map `viridis` (van der Walt, Smith and Firing 2015), from
/// dark blue to yellow.
pub fn viridis(step: u8) -> Rgb {
    VIRIDIS.get(usize::from(step)).copied().unwrap_or_default()
}

/// Components that add up to the total, in the order of stacking, with the page's colours and
/// words.
pub const COMPONENTS: [(Component, Rgb, &str); 6] = [
    (Component::SunDirect, [0xe6, 0x9f, 0x00], "sun, direct"),
    (Component::SkyDirect, [0x56, 0xb4, 0xe9], "sky, direct"),
    (Component::SunReflected, [0xd5, 0x5e, 0x00], "sun, reflected"),
    (Component::SkyReflected, [0x00, 0x72, 0xb2], "sky, reflected"),
    (Component::SunMirrored, [0xcc, 0x79, 0xa7], "sun, mirrored"),
    (Component::SkyMirrored, [0x00, 0x9e, 0x73], "sky, mirrored"),
];

/// Returns a colour of six stops of the map `inferno` (Smith and van der Walt 2015), from black to
/// pale yellow, linear between them.
pub fn inferno(share: f32) -> Rgb {
    const STOPS: [[f32; 3]; 6] =
        [[0., 0., 4.], [66., 10., 104.], [147., 38., 103.], [221., 81., 58.], [252., 165., 10.], [252., 255., 164.]];
    between(&STOPS, share)
}

/// Returns the colour at a share from 0 to 1 of the way along `stops`, linear between them.
pub fn between(stops: &[[f32; 3]], share: f32) -> Rgb {
    let place = share.clamp(0.0, 1.0) * (stops.len() - 1) as f32;
    let low = (place as usize).min(stops.len() - 2);
    let part = place - low as f32;
    let (a, b) = (stops[low], stops[low + 1]);
    [0, 1, 2].map(|i| (a[i] + (b[i] - a[i]) * part).round() as u8)
}

/// Mapping of numbers to colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColourScale {
    /// Scale from zero to the largest number.
    FromZero,
    /// Scale as far below zero as above it: losses are violet, gains orange.
    AroundZero,
}

impl ColourScale {
    /// Returns the distance from zero that the scale must cover to show a number.
    pub fn reach(self, value: f32) -> f32 {
        if self == ColourScale::AroundZero { value.abs() } else { value }
    }

    /// Returns the lowest number of a scale whose largest is `largest`.
    pub fn least(self, largest: f64) -> f64 {
        if self == ColourScale::AroundZero { -largest } else { 0.0 }
    }

    /// Returns the colour on surfaces in 3D of a share of the largest number: -1 to 1 around zero.
    pub fn on_surfaces(self, share: f32) -> Rgb {
        match self {
            ColourScale::FromZero => inferno(share),
            ColourScale::AroundZero => between(&PUOR, 0.5 * (share.clamp(-1.0, 1.0) + 1.0)),
        }
    }

    /// Returns the colour in charts, as in the page, of a share of the largest number: -1 to 1
    /// around zero.
    pub fn on_paper(self, share: f32) -> Rgb {
        match self {
            ColourScale::FromZero => viridis(viridis_step(share)),
            ColourScale::AroundZero => self.on_surfaces(share),
        }
    }

    /// Returns one of [`STEPS`] colours of a legend, from the lowest number to the largest.
    pub fn of_legend(self, step: usize) -> Rgb {
        match self {
            ColourScale::FromZero => viridis(step as u8),
            ColourScale::AroundZero => self.on_surfaces(2.0 * (step as f32 + 0.5) / STEPS as f32 - 1.0),
        }
    }

    /// Returns the name of the colour map on surfaces.
    pub fn name_on_surfaces(self) -> &'static str {
        if self == ColourScale::AroundZero { "PuOr" } else { "inferno" }
    }

    /// Returns the name of the colour map in charts.
    pub fn name_on_paper(self) -> &'static str {
        if self == ColourScale::AroundZero { "PuOr" } else { "viridis" }
    }

    /// Returns the words at the ends of a legend.
    pub fn ends(self) -> Option<[&'static str; 2]> {
        (self == ColourScale::AroundZero).then_some(["loss", "gain"])
    }

    /// Returns round numbers for a legend, from the lowest to the largest, that enclose a number of
    /// this size.
    pub fn ticks(self, largest: f64) -> Vec<f64> {
        match self {
            ColourScale::FromZero => round_steps(largest, 5),
            ColourScale::AroundZero => {
                let above = round_steps(largest, 3);
                above.iter().skip(1).rev().map(|tick| -tick).chain(above.iter().copied()).collect()
            }
        }
    }
}

/// Returns the words for a component.
pub fn label(component: Component) -> String {
    let found = COMPONENTS.iter().find(|(one, ..)| *one == component);
    found.map_or_else(|| component.name().replace('_', " "), |(.., words)| (*words).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The map is dark at 0 and pale at 1, and NaN does not panic: 3 of 3.
    #[test]
    fn the_map_is_dark_at_0_and_pale_at_1() {
        assert_eq!((inferno(0.0), inferno(1.0), inferno(f32::NAN)[0] < 255), ([0, 0, 4], [252, 255, 164], true));
    }

    /// Around zero, equal losses and gains are equally far from the middle, violet and orange.
    /// Ticks are round on both sides, and NaN does not panic: 6 of 6.
    #[test]
    fn equal_losses_and_gains_are_equally_strong() {
        let scale = ColourScale::AroundZero;
        assert_eq!([-1.0, 0.0, 1.0].map(|share| scale.on_paper(share)), [[45, 0, 75], [247; 3], [127, 59, 8]]);
        assert_eq!([scale.on_surfaces(-0.6), scale.on_surfaces(0.6)], [[128, 115, 172], [224, 130, 20]]);
        assert_eq!(scale.ticks(123.0), [-150.0, -100.0, -50.0, 0.0, 50.0, 100.0, 150.0]);
        assert!(scale.on_paper(f32::NAN)[0] < 255 && scale.reach(-3.0) == 3.0);
    }

    /// The page's map has 256 colours, of which 0, 128 and 255 equal matplotlib's; 254 of them are
    /// distinct.
    #[test]
    fn the_map_of_the_page_is_that_of_matplotlib() {
        assert_eq!(VIRIDIS.len(), STEPS);
        assert_eq!([0, 128, 255].map(viridis), [[68, 1, 84], [33, 145, 140], [253, 231, 37]]);
        assert_eq!(VIRIDIS.iter().collect::<std::collections::BTreeSet<_>>().len(), 254);
        assert_eq!([0.0, 0.5, 2.0, f32::NAN].map(viridis_step), [0, 128, 255, 0]);
    }

    /// The 6 components have the page's colours and words.
    #[test]
    fn components_have_the_colours_of_the_page() {
        let words = include_str!("../../../viewer/source/words.ts");
        for (component, [r, g, b], word) in COMPONENTS {
            let colour = format!("  {}: \"#{r:02x}{g:02x}{b:02x}\",\n", component.name());
            let word = format!("  {}: \"{}\",\n", component.name(), word.replacen('s', "S", 1));
            assert!(words.contains(&colour) && words.contains(&word), "{colour} {word}");
        }
        assert_eq!(label(Component::SunReflectedGround), "sun reflected ground");
    }
}
