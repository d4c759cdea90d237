//! Tests of skies and clouds from files: DHI, suns behind clouds, turned axes.

use super::*;
use crate::dome::grid::PatchGrid;
use crate::site::north::North;
use crate::site::place::Place;
use crate::sky::model::SkyModel;
use crate::sky::patches::Patches;
use crate::sky::projection::Projection;
use crate::units::direction_from_degrees;

fn noon(dni_w_m2: f64, dhi_w_m2: f64) -> Condition {
    let sun = direction_from_degrees(180.0, 45.0);
    Condition::new("noon".into(), &[sun], sun, dni_w_m2, dhi_w_m2)
}

fn series(factor: usize, number: impl Fn(usize) -> f32) -> PatchSeries {
    let grid = PatchGrid::of_factor(factor);
    let numbers = (0..grid.len()).map(number).collect();
    PatchSeries::new(grid, numbers).expect("a row")
}

/// Skies of 145, 577 and 2305 patches on replays of each: an open horizontal surface gets DHI
/// (1e-12), or with [`SkyScale::Given`] the integral of the file's sky (1e-12).
#[test]
fn open_ground_gets_dhi_or_the_files_integral() {
    for from in [1, 2, 4] {
        let own = series(from, |i| (1 + i * 7 % 13) as f32);
        let integral = own.horizontal_w_m2(0);
        for count in [145, 577, 2305] {
            let patches = Patches::new(count).expect("known");
            let open_sr = Projection::new(&patches, 64, 8).open_horizontal_sr;
            for (scale, expected) in [(SkyScale::Dhi, 120.0), (SkyScale::Given, integral)] {
                let condition = OwnSky::new(own.clone(), scale).over(noon(0.0, 120.0), 0);
                let radiances = patches.radiances(SkyModel::Perez, &condition, &open_sr);
                let open: f64 = radiances.iter().zip(&open_sr).map(|(l, w)| l * w).sum();
                assert!((open / expected - 1.0).abs() < 1e-12, "{from} {count}: {open} {expected}");
            }
        }
    }
}

/// Clouds over the southern half hide a sun in the south (0), let a sun in the north through (1),
/// and let half of a sun on their edge through, within 2 %. They leave half of a uniform sky.
#[test]
fn clouds_hide_the_sun() {
    let side = 400;
    // East is on the left and north at the top, so the lower half is the south.
    let pixels = (0..side * side).map(|i| if i / side < side / 2 { 1.0 } else { 0.0 }).collect();
    let clouds = DomeImage::new(side, pixels, 0.0).and_then(CloudLayer::of_image).expect("clouds");
    for (azimuth_deg, expected) in [(180.0, 0.0), (90.0, 0.5), (0.0, 1.0)] {
        let sun = direction_from_degrees(azimuth_deg, 40.0);
        let condition = clouds.over(Condition::new("c".into(), &[sun], sun, 800.0, 100.0), 0);
        assert!((condition.suns[0].lit() - expected).abs() < 0.02, "{azimuth_deg}: {}", condition.suns[0].lit());
    }
    let patches = Patches::new(577).expect("known");
    let open_sr = Projection::new(&patches, 64, 8).open_horizontal_sr;
    let radiances = patches.radiances(SkyModel::Uniform, &clouds.over(noon(800.0, 100.0), 0), &open_sr);
    let open: f64 = radiances.iter().zip(&open_sr).map(|(l, w)| l * w).sum();
    assert!((open - 50.0).abs() < 0.05, "{open}");
}

/// In axes 30 degrees clockwise of north, a bright patch in the east stands at 60 degrees from y;
/// the sun is dimmed by 0.25, as in axes along north.
#[test]
fn axes_turn_skies_with_suns() {
    let grid = PatchGrid::of_factor(2);
    let bright = grid.patch_of(direction_from_degrees(90.0, 20.0));
    let own = OwnSky::new(series(2, |i| f32::from(u8::from(i == bright))), SkyScale::Given);
    let clouds = CloudLayer::of_patches(series(2, |_| 0.25));
    let place = Place { latitude_deg: 50.0, longitude_deg: 9.0, convergence_deg: 30.0, epsg: None };
    let condition = clouds.over(own.over(noon(100.0, 10.0), 0), 0).in_axes(North::new(Some(&place)));
    assert_eq!(condition.suns[0].lit(), 0.25);
    let patches = Patches::new(577).expect("known");
    let open_sr = Projection::new(&patches, 64, 8).open_horizontal_sr;
    let radiances = patches.radiances(SkyModel::Perez, &condition, &open_sr);
    let brightest = (0..577).max_by(|a, b| radiances[*a].total_cmp(&radiances[*b])).expect("patches");
    assert_eq!(brightest, patches.patch_of(direction_from_degrees(60.0, 20.0)));
}

/// Skies with four times the light of DHI hold the sun. Skies with the light of DHI do not, and
/// have a ratio of 1. Black skies are counted.
#[test]
fn the_sun_in_skies_is_seen() {
    let own = |level: f32| OwnSky::new(series(1, move |_| level), SkyScale::Given);
    let pi = std::f64::consts::PI;
    let hours = [noon(500.0, 100.0), noon(0.0, 50.0), noon(0.0, 0.0)];
    let balance = |level: f64| own(level as f32).balance(hours.iter().map(|hour| (hour, 0)));
    let fair = balance(75.0 / pi);
    assert!(!fair.holds_sun() && (fair.ratio().expect("DHI") - 1.0).abs() < 1e-6 && fair.black == 0);
    assert!(balance(300.0 / pi).holds_sun());
    assert_eq!(balance(0.0).black, 2);
}
