//! Colours of numbers. In: a share from 0 to 1. Out: red, green, blue.

use std::sync::LazyLock;

use super::canvas::Rgb;
use heliotile_core::replay::components::Component;

/// Colours of the map `viridis`.
pub const STEPS: usize = 256;

/// Where the page has them from: one definition for both.
const PAGE: &str = include_str!("../../../viewer/source/colour/viridis.ts");

static VIRIDIS: LazyLock<Vec<Rgb>> = LazyLock::new(|| {
    // The only quoted words of the file that are digits throughout.
    let rows = PAGE.split('"').filter(|row| row.len() >= 6 && row.bytes().all(|digit| digit.is_ascii_hexdigit()));
    let digits: String = rows.collect();
    let colour = |six: &[u8; 6]| {
        let part = |two: &[u8]| std::str::from_utf8(two).ok().and_then(|two| u8::from_str_radix(two, 16).ok());
        [0, 2, 4].map(|at| part(&six[at..at + 2]).unwrap_or_default())
    };
    digits.as_bytes().as_chunks().0.iter().map(colour).collect()
});

/// Number of the colour of a share from 0 to 1 in the map `viridis`, as the page takes it.
pub fn viridis_step(share: f32) -> u8 {
    (share.clamp(0.0, 1.0) * (STEPS - 1) as f32).round() as u8
}

/// One of the 256 colours of the map `viridis` (van der Walt, Smith and Firing 2015), from dark blue to yellow.
pub fn viridis(step: u8) -> Rgb {
    VIRIDIS.get(usize::from(step)).copied().unwrap_or_default()
}

/// The components that add up to the total, in the order that they are stacked, in the page's colours and words.
pub const COMPONENTS: [(Component, Rgb, &str); 6] = [
    (Component::SunDirect, [0xe6, 0x9f, 0x00], "sun, direct"),
    (Component::SkyDirect, [0x56, 0xb4, 0xe9], "sky, direct"),
    (Component::SunDiffuse, [0xd5, 0x5e, 0x00], "sun, reflected"),
    (Component::SkyDiffuse, [0x00, 0x72, 0xb2], "sky, reflected"),
    (Component::SunSpecular, [0xcc, 0x79, 0xa7], "sun, mirrored"),
    (Component::SkySpecular, [0x00, 0x9e, 0x73], "sky, mirrored"),
];

/// Six stops of the map `inferno` (Smith and van der Walt 2015), from black to pale yellow, linear between them.
pub fn inferno(share: f32) -> Rgb {
    const STOPS: [[f32; 3]; 6] =
        [[0., 0., 4.], [66., 10., 104.], [147., 38., 103.], [221., 81., 58.], [252., 165., 10.], [252., 255., 164.]];
    let place = share.clamp(0.0, 1.0) * (STOPS.len() - 1) as f32;
    let low = (place as usize).min(STOPS.len() - 2);
    let part = place - low as f32;
    let (a, b) = (STOPS[low], STOPS[low + 1]);
    [0, 1, 2].map(|i| (a[i] + (b[i] - a[i]) * part).round() as u8)
}

/// A component in words.
pub fn label(component: Component) -> String {
    let found = COMPONENTS.iter().find(|(one, ..)| *one == component);
    found.map_or_else(|| component.name().replace('_', " "), |(.., words)| (*words).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 0 is dark, 1 is pale, and what is no number is no panic: 3 of 3.
    #[test]
    fn ends() {
        assert_eq!((inferno(0.0), inferno(1.0), inferno(f32::NAN)[0] < 255), ([0, 0, 4], [252, 255, 164], true));
    }

    /// The page's map has 256 colours, of which 0, 128 and 255 are those of matplotlib; 254 of them differ.
    #[test]
    fn the_map_of_the_page() {
        assert_eq!(VIRIDIS.len(), STEPS);
        assert_eq!([0, 128, 255].map(viridis), [[68, 1, 84], [33, 145, 140], [253, 231, 37]]);
        assert_eq!(VIRIDIS.iter().collect::<std::collections::BTreeSet<_>>().len(), 254);
        assert_eq!([0.0, 0.5, 2.0, f32::NAN].map(viridis_step), [0, 128, 255, 0]);
    }

    /// The 6 components have the page's colours and words.
    #[test]
    fn the_components_of_the_page() {
        let words = include_str!("../../../viewer/source/words.ts");
        for (component, [r, g, b], word) in COMPONENTS {
            let colour = format!("  {}: \"#{r:02x}{g:02x}{b:02x}\",\n", component.name());
            let word = format!("  {}: \"{}\",\n", component.name(), word.replacen('s', "S", 1));
            assert!(words.contains(&colour) && words.contains(&word), "{colour} {word}");
        }
        assert_eq!(label(Component::SunDiffuseGround), "sun diffuse ground");
    }
}
