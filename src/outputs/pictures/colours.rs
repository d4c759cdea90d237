//! Colours of numbers. In: a share from 0 to 1. Out: red, green, blue.

use super::canvas::Rgb;

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

#[cfg(test)]
mod tests {
    use super::*;

    /// 0 is dark, 1 is pale, and what is no number is no panic: 3 of 3.
    #[test]
    fn ends() {
        assert_eq!((inferno(0.0), inferno(1.0), inferno(f32::NAN)[0] < 255), ([0, 0, 4], [252, 255, 164], true));
    }
}
