//! Tests of [`super`].

use super::*;
use heliotile_core::hemisphere::{mix, unit};

/// A plane among surfaces whose materials are equal.
const VIEW: ViewShares =
    ViewShares { sky: 0.0, obstruction: 0.0, missed: 0.0, surfaces: SeenSurfaces { ground: None, obstruction: None } };

const OPEN: SixPlanes<ViewShares> = SixPlanes {
    up: ViewShares { sky: 1.0, obstruction: 0.0, missed: 1.0, ..VIEW },
    down: ViewShares { sky: 0.0, obstruction: 0.0, missed: 0.0, ..VIEW },
    sides: [ViewShares { sky: 0.5, obstruction: 0.0, missed: 0.5, ..VIEW }; 4],
};

const UNDER_ROOF: SixPlanes<ViewShares> = SixPlanes {
    up: ViewShares { sky: 0.0, obstruction: 1.0, missed: 0.0, ..VIEW },
    down: ViewShares { sky: 0.0, obstruction: 0.0, missed: 0.0, ..VIEW },
    sides: [ViewShares { sky: 0.0, obstruction: 0.5, missed: 0.0, ..VIEW }; 4],
};

fn given(celsius: f64, emissivity: f64) -> ClassSurfaces {
    ClassSurfaces { heat: SurfaceHeat::Given(black_body_w_m2(celsius)), emissivity }
}

fn around(ground: ClassSurfaces, obstruction: ClassSurfaces) -> HeatAround {
    HeatAround { sky_w_m2: 300.0, air_c: 20.0, film_w_m2_k: USUAL_FILM_W_M2_K, ground, obstruction }
}

/// On an open plain of 40 degrees and emissivity 0.95 below a sky of 300 W/m2, a plane gets 300
/// from above, 0.95 sigma 313.15^4 + 0.05 x 300 = 533.0 from below, and the mean of the two on the
/// sides, within 1e-9.
#[test]
fn planes_on_an_open_plain_agree_with_hand_computation() {
    let found = around(given(40.0, 0.95), given(0.0, 0.9)).longwave(&OPEN, &SixPlanes::default());
    let below = 0.95 * black_body_w_m2(40.0) + 0.05 * 300.0;
    assert!((found.up - 300.0).abs() < 1e-9 && (found.down - below).abs() < 1e-9, "{found:?}");
    assert!(found.sides.iter().all(|side| (side - 0.5 * (300.0 + below)).abs() < 1e-9), "{found:?}");
}

/// Between an endless gray roof and gray ground, the exitances are those of two endless plates, J1
/// = e1 B1 + (1 - e1) J2 and so on, within 5 W/m2 from above and 0.5 from below. Where the two are
/// equally warm the exitance is sigma T^4 within 1e-9.
#[test]
fn a_roof_and_ground_exchange_heat_as_two_plates() {
    let (ground, roof) = (given(30.0, 0.95), given(12.0, 0.9));
    let found = around(ground, roof).longwave(&UNDER_ROOF, &SixPlanes::default());
    let (warm, cold) = (black_body_w_m2(30.0), black_body_w_m2(12.0));
    let of_roof = (0.9 * cold + 0.1 * 0.95 * warm) / (1.0 - 0.1 * 0.05);
    let of_ground = 0.95 * warm + 0.05 * of_roof;
    // The irradiance of the roof is taken as the mean of the sides, half of it from the roof
    // itself: a tenth of half the difference is lost.
    assert!((found.up - of_roof).abs() < 5.0 && (found.down - of_ground).abs() < 0.5, "{found:?} {of_roof}");
    let even = around(given(20.0, 0.95), given(20.0, 0.9)).longwave(&UNDER_ROOF, &SixPlanes::default());
    assert!((even.up - black_body_w_m2(20.0)).abs() < 1e-9, "{even:?}");
}

/// By hand: ground that absorbs 0.8 of 850 W/m2 below a sky as warm as the air is 37.5 K warmer
/// than the air: 11.57 x 37.5 = 434 W/m2 go to the air, 0.95 sigma (330.65^4 - 293.15^4) = 246 are
/// radiated, 680 in all. By the tangent it would be 40 K.
#[test]
fn sunlit_ground_is_as_warm_as_by_hand() {
    let ground = ClassSurfaces { heat: SurfaceHeat::SolAir(0.8), emissivity: 0.95 };
    let sky_w_m2 = black_body_w_m2(20.0);
    let sunny = SixPlanes { up: 850.0, down: 100.0, sides: [200.0; 4] };
    let found = HeatAround { sky_w_m2, ..around(ground, given(20.0, 0.9)) }.longwave(&OPEN, &sunny);
    let expected = 0.95 * black_body_w_m2(57.5) + 0.05 * sky_w_m2;
    assert!((found.down - expected).abs() < 0.2, "{found:?} {expected}");
}

/// A wall in the sun is warmer than one in shade. With walls all around and 400 W/m2 on planes that
/// face south, the side that faces north sees a wall that is some 16 K warmer (400 x 0.7 / 17 by
/// the tangent): it gets more than 80 W/m2 more than the side that faces east. The side that faces
/// south gets less than 60 W/m2 more, because the warm wall heats the wall across from it.
#[test]
fn a_plane_gets_more_from_a_sunlit_wall() {
    let wall = ClassSurfaces { heat: SurfaceHeat::SolAir(0.7), emissivity: 1.0 };
    let walls = ViewShares { sky: 0.0, obstruction: 1.0, missed: 0.0, ..VIEW };
    let views = SixPlanes {
        up: ViewShares { sky: 1.0, obstruction: 0.0, missed: 1.0, ..VIEW },
        down: ViewShares::default(),
        sides: [walls; 4],
    };
    let light = SixPlanes { up: 0.0, down: 0.0, sides: [0.0, 0.0, 400.0, 0.0] };
    let found = around(given(20.0, 1.0), wall).longwave(&views, &light);
    let [north, _, south, _] = found.sides;
    let colder = found.sides[1];
    assert!(north > colder + 80.0 && south - colder < 60.0, "{found:?}");
}

/// A street has a metal wall of emissivity 0.2 in the north and one of 0.9 in the south, both of 40
/// degrees. Over black ground of 40 degrees and below a sky of as much, all planes get sigma T^4.
/// Below a cold sky, the plane that faces north gets from the metal 0.2 of that and 0.8 of the
/// irradiance of the plane that faces south, within 1e-9.
#[test]
fn a_metal_wall_reflects_the_opposite_irradiance() {
    let mean =
        |emissivity| SeenSurfaces { ground: None, obstruction: Some(SurfaceMean { emissivity, absorptance: 0.5 }) };
    let wall = |emissivity| ViewShares { obstruction: 0.5, surfaces: mean(emissivity), ..VIEW };
    let [metal, brick, ends] = [0.2, 0.9, 0.9].map(wall);
    let open = ViewShares { sky: 1.0, missed: 1.0, ..VIEW };
    let views = SixPlanes { up: open, down: VIEW, sides: [metal, ends, brick, ends] };
    let black = black_body_w_m2(40.0);
    let even = HeatAround { sky_w_m2: black, air_c: 40.0, ..around(given(40.0, 1.0), given(40.0, 0.5)) };
    let found = even.longwave(&views, &SixPlanes::default());
    found.each(|plane| assert!((plane - black).abs() < 1e-9, "{found:?}"));
    let found = HeatAround { air_c: 20.0, ..around(given(10.0, 1.0), given(40.0, 0.5)) }
        .longwave(&views, &SixPlanes::default());
    let ground = black_body_w_m2(10.0);
    let [north, _, south, _] = found.sides;
    assert!((north - 0.5 * (0.2 * black + 0.8 * south) - 0.5 * ground).abs() < 1e-9, "{found:?}");
    assert!((south - 0.5 * (0.9 * black + 0.1 * north) - 0.5 * ground).abs() < 1e-9, "{found:?}");
}

/// In a sunny court with gray walls of sol-air temperature the exitances of surfaces agree with
/// their irradiance, within 0.01 W/m2. With the least coefficient the plane that faces up gets
/// more, and less than from a black body of 120 degrees.
#[test]
fn exitances_of_a_court_agree_with_its_irradiance() {
    let views = SixPlanes {
        up: ViewShares { sky: 0.1, obstruction: 0.9, missed: 0.12, ..VIEW },
        down: ViewShares { sky: 0.0, obstruction: 0.05, missed: 0.0, ..VIEW },
        sides: [ViewShares { sky: 0.0, obstruction: 0.6, missed: 0.0, ..VIEW }; 4],
    };
    let light = SixPlanes { up: 600.0, down: 150.0, sides: [200.0, 200.0, 600.0, 200.0] };
    let class = |absorbed, emissivity| ClassSurfaces { heat: SurfaceHeat::SolAir(absorbed), emissivity };
    let court = around(class(0.8, 0.95), class(0.7, 0.9));
    let found = court.longwave(&views, &light);
    // The balance itself: the exitances of ground and walls follow from their irradiance.
    let balances = court.balances(&views);
    let air_w_m2 = balances.air_w_m2;
    let settled = |of: &Balance, got: f64, lit: f64| {
        let first = balances.at_first().ground;
        let first = Exitance { radiation_w_m2_k: of.radiation_w_m2_k, ..first };
        (0..9).fold(first, |before, _| balances.exitance(of, &before, got, lit))
    };
    let ground = settled(&balances.ground, found.up, light.up).w_m2;
    let (got, lit) = (found.on_obstructions(), light.on_obstructions());
    let wall = |got: f64, lit: f64| settled(&balances.sides[0], got, lit).w_m2;
    let up = 0.1 * air_w_m2 - 0.12 * (air_w_m2 - court.sky_w_m2) + 0.9 * wall(got.up, lit.up);
    let south = 0.6 * wall(got.sides[2], lit.sides[2]) + 0.4 * ground;
    assert!((found.up - up).abs() < 0.01 && (found.sides[2] - south).abs() < 0.01, "{found:?} {up} {south}");
    for gained_w_m2 in [-150.0, 10.0, 700.0] {
        let warm = settled(&balances.sides[0], air_w_m2, gained_w_m2 / 0.7);
        let convection = court.film_w_m2_k - 4.0 * 0.9 * air_w_m2 / (court.air_c + ZERO_CELSIUS_K);
        let black_w_m2 = black_body_w_m2(court.air_c + warm.warmer_k);
        let lost = convection * warm.warmer_k + 0.9 * (black_w_m2 - air_w_m2);
        assert!((lost - gained_w_m2).abs() < 1e-6, "{gained_w_m2}: {warm:?}");
    }
    let calm = HeatAround { film_w_m2_k: MIN_FILM_W_M2_K, ..court }.longwave(&views, &light);
    assert!(calm.up > found.up && calm.up < black_body_w_m2(120.0), "{calm:?}");
}

/// In 3,000 places with any shares of sky, obstructions and ground, from calm air to wind, half of
/// them with materials that differ, planes are within 0.1 W/m2 of the result of 400 passes from
/// surface to surface.
#[test]
fn the_solution_equals_400_passes_between_surfaces() {
    let mut state = 7;
    let mut random = |low: f64, high: f64| {
        state = mix(state, 11);
        low + (high - low) * unit(state)
    };
    for place in 0..3000 {
        let mut view = || {
            let (sky, seen) = (random(0.0, 1.0), random(0.0, 1.0));
            let mut mean = || {
                let mean = SurfaceMean { emissivity: random(0.3, 1.0), absorptance: random(0.0, 1.0) };
                (place % 2 == 0).then_some(mean)
            };
            let surfaces = SeenSurfaces { ground: mean(), obstruction: mean() };
            let sky = sky * (1.0 - seen);
            ViewShares { sky, obstruction: seen, missed: 1.1 * sky, surfaces }
        };
        let views = SixPlanes { up: view(), down: view(), sides: [view(), view(), view(), view()] };
        let light = SixPlanes {
            up: random(0.0, 1000.0),
            down: random(0.0, 300.0),
            sides: [random(0.0, 900.0), random(0.0, 900.0), random(0.0, 900.0), random(0.0, 900.0)],
        };
        let mut class = || ClassSurfaces { heat: SurfaceHeat::SolAir(random(0.0, 1.0)), emissivity: random(0.3, 1.0) };
        let (ground, obstruction) = (class(), class());
        let (air_c, film_w_m2_k) = (random(-20.0, 40.0), random(MIN_FILM_W_M2_K, 30.0));
        let sky_w_m2 = black_body_w_m2(air_c) * random(0.6, 1.0);
        let around = HeatAround { sky_w_m2, air_c, film_w_m2_k, ground, obstruction };
        let found = around.longwave(&views, &light);
        let balances = around.balances(&views);
        let mut sent = balances.at_first();
        let mut plain = SixPlanes::default();
        for _ in 0..400 {
            plain = balances.on_planes(&views, &sent).map(|plane| plane.w_m2);
            sent = balances.sent_back(&sent, &light, &plain);
        }
        let mut off: f64 = 0.0;
        found.less(&plain).each(|of_plane| off = off.max(of_plane.abs()));
        assert!(off < 0.1, "{place}: off by {off} W/m2: {found:?} {plain:?}");
    }
}
