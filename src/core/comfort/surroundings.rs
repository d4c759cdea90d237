//! Heat that a person gets from the sky and from surfaces around. In: shares of six hemispheres that are sky, ground and obstructions,
//! shortwave irradiance of the same six planes, air. Out: longwave irradiance of the planes.
//!
//! A surface sends epsilon sigma T^4 and reflects the rest of what it gets. What a surface gets is taken from the planes at the point itself:
//! ground gets what the plane gets that looks up, and an obstruction that a side sees gets what the opposite side gets. Those that are seen above and below
//! get the mean of the four sides. The temperature of a surface is given, or it is the sol-air temperature: that at which a surface without storage
//! is in balance.
//!
//! Sol-air temperature: ASHRAE Handbook Fundamentals, 2017, chapter 18, equation 29: T = T_air + (a K + e (L - sigma T_air^4)) / h, where K and L are
//! what the surface gets of shortwave and longwave irradiance, and h holds what it radiates. That is the tangent of the balance that is solved here,
//! h_c (T - T_air) = a K + e (L - sigma T^4) with h_c = h - 4 e sigma T_air^3: sunny walls of a court, which warm each other, would have no end by the
//! tangent.

use crate::comfort::mean_radiant::DirectionalIrradiance;
use crate::weather::emission::{ZERO_CELSIUS_K, black_body_w_m2};

/// Heat transfer coefficient between surfaces and air, radiation included, W/m2K: that of ASHRAE's sol-air temperatures, for a wind of 3.4 m/s.
pub const USUAL_FILM_W_M2_K: f64 = 17.0;

/// Emissivity of ground: that of SOLWEIG (Lindberg, Holmer and Thorsson 2008).
pub const USUAL_GROUND_EMISSIVITY: f64 = 0.95;

/// Emissivity of walls: that of SOLWEIG.
pub const USUAL_OBSTRUCTION_EMISSIVITY: f64 = 0.90;

/// What surfaces send is found from what they get until no plane changes by more, W/m2,
const ENOUGH_W_M2: f64 = 0.05;

/// but so often at most. What is left falls by more than half each time in courts by day, and at once in the open.
const MOST_PASSES: usize = 60;

/// Least heat transfer coefficient, W/m2K: it holds what surfaces radiate, 4 sigma T^3, which is 7 at 40 degrees.
pub const LEAST_FILM_W_M2_K: f64 = 10.0;

/// Steps of Newton's method to a surface's temperature; from the tangent at the air's two are exact to 0.001 K (a test).
const STEPS: usize = 2;

/// A number for each of the six planes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SixPlanes<T> {
    /// Of the plane that looks up.
    pub up: T,
    /// Of the plane that looks down.
    pub down: T,
    /// Of the planes that look north, east, south and west.
    pub sides: [T; 4],
}

/// Shares of a hemisphere, weighted by the cosine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ViewShares {
    /// What is sky.
    pub sky: f64,
    /// What is obstructions; all else is ground.
    pub obstruction: f64,
    /// What is missed of the sky's longwave irradiance beside a black sky, in shares of what an open horizontal plane misses
    /// ([`crate::comfort::clear_sky`]); with the share of the sky in its place the sky is isotropic.
    pub missed: f64,
}

/// How warm the surfaces of a class are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SurfaceHeat {
    /// They send what a black surface of a given temperature would send, W/m2.
    Given(f64),
    /// They have their sol-air temperature; the share of shortwave irradiance that they absorb.
    SolAir(f64),
}

/// The surfaces of a class.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClassSurfaces {
    /// How warm they are.
    pub heat: SurfaceHeat,
    /// Longwave emissivity.
    pub emissivity: f64,
}

/// What surrounds a person in an hour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatAround {
    /// Longwave irradiance of an open horizontal plane, W/m2.
    pub sky_w_m2: f64,
    /// Temperature of the air, degrees Celsius.
    pub air_c: f64,
    /// Heat transfer coefficient between surfaces and air, W/m2K.
    pub film_w_m2_k: f64,
    /// The ground.
    pub ground: ClassSurfaces,
    /// Obstructions.
    pub obstruction: ClassSurfaces,
}

impl SixPlanes<f64> {
    /// The values in their order: up, down, north, east, south, west.
    pub fn each(&self, of: impl FnMut(f64)) {
        [self.up, self.down].into_iter().chain(self.sides).for_each(of);
    }

    /// What is left without a part.
    pub fn less(&self, part: &SixPlanes<f64>) -> SixPlanes<f64> {
        let mut sides = self.sides;
        sides.iter_mut().zip(part.sides).for_each(|(side, part)| *side -= part);
        SixPlanes { up: self.up - part.up, down: self.down - part.down, sides }
    }

    fn mean_of_sides(&self) -> f64 {
        0.25 * self.sides.iter().sum::<f64>()
    }

    /// What obstructions get that each plane sees.
    fn on_obstructions(&self) -> SixPlanes<f64> {
        let [north, east, south, west] = self.sides;
        let mean = self.mean_of_sides();
        SixPlanes { up: mean, down: mean, sides: [south, west, north, east] }
    }
}

impl From<SixPlanes<f64>> for DirectionalIrradiance {
    fn from(planes: SixPlanes<f64>) -> Self {
        let [from_north_w_m2, from_east_w_m2, from_south_w_m2, from_west_w_m2] = planes.sides;
        let (from_above_w_m2, from_below_w_m2) = (planes.up, planes.down);
        DirectionalIrradiance {
            from_above_w_m2,
            from_below_w_m2,
            from_north_w_m2,
            from_east_w_m2,
            from_south_w_m2,
            from_west_w_m2,
        }
    }
}

impl HeatAround {
    /// Longwave irradiance of the six planes, W/m2; `shortwave` is their shortwave irradiance.
    pub fn longwave(&self, views: &SixPlanes<ViewShares>, shortwave: &SixPlanes<f64>) -> SixPlanes<f64> {
        let air_w_m2 = black_body_w_m2(self.air_c);
        let black = |class: &ClassSurfaces| match class.heat {
            SurfaceHeat::Given(w_m2) => w_m2,
            SurfaceHeat::SolAir(_) => air_w_m2,
        };
        let on_obstructions = shortwave.on_obstructions();
        let from = |ground: f64, obstruction: &SixPlanes<f64>| {
            let of = |view: &ViewShares, obstruction: f64| {
                let of_ground = (1.0 - view.sky - view.obstruction).max(0.0);
                let of_sky = view.sky * air_w_m2 - view.missed * (air_w_m2 - self.sky_w_m2);
                of_sky + view.obstruction * obstruction + of_ground * ground
            };
            let mut sides = [0.0; 4];
            for ((side, view), obstruction) in sides.iter_mut().zip(&views.sides).zip(obstruction.sides) {
                *side = of(view, obstruction);
            }
            SixPlanes { up: of(&views.up, obstruction.up), down: of(&views.down, obstruction.down), sides }
        };
        let everywhere = black(&self.obstruction);
        let mut planes =
            from(black(&self.ground), &SixPlanes { up: everywhere, down: everywhere, sides: [everywhere; 4] });
        for _ in 0..MOST_PASSES {
            let ground = self.sent(&self.ground, planes.up, shortwave.up, air_w_m2);
            let got = planes.on_obstructions();
            let sent = |got: f64, light: f64| self.sent(&self.obstruction, got, light, air_w_m2);
            let mut sides = [0.0; 4];
            for ((side, got), light) in sides.iter_mut().zip(got.sides).zip(on_obstructions.sides) {
                *side = sent(got, light);
            }
            // What is seen above and below gets the same.
            let ends = sent(got.up, on_obstructions.up);
            let next = from(ground, &SixPlanes { up: ends, down: ends, sides });
            let mut change = 0.0;
            next.less(&planes).each(|off| change = f64::max(change, off.abs()));
            planes = next;
            if change < ENOUGH_W_M2 {
                break;
            }
        }
        planes
    }

    /// How much warmer than the air a surface is that gains so much more than one as warm as the air sends.
    fn warmer_k(&self, emissivity: f64, gained_w_m2: f64, air_w_m2: f64) -> f64 {
        let slope = |black_w_m2: f64, celsius: f64| 4.0 * emissivity * black_w_m2 / (celsius + ZERO_CELSIUS_K);
        let convection_w_m2_k = (self.film_w_m2_k - slope(air_w_m2, self.air_c)).max(0.0);
        let mut warmer_k = gained_w_m2 / self.film_w_m2_k;
        for _ in 0..STEPS {
            let celsius = self.air_c + warmer_k;
            let black_w_m2 = black_body_w_m2(celsius);
            let lost_w_m2 = convection_w_m2_k * warmer_k + emissivity * (black_w_m2 - air_w_m2);
            warmer_k -= (lost_w_m2 - gained_w_m2) / (convection_w_m2_k + slope(black_w_m2, celsius));
        }
        warmer_k
    }

    /// What a surface sends and reflects that gets so much longwave and shortwave irradiance.
    fn sent(&self, class: &ClassSurfaces, longwave_w_m2: f64, shortwave_w_m2: f64, air_w_m2: f64) -> f64 {
        let emissivity = class.emissivity;
        let black_w_m2 = match class.heat {
            SurfaceHeat::Given(w_m2) => w_m2,
            SurfaceHeat::SolAir(absorbed) => {
                let gained_w_m2 = absorbed * shortwave_w_m2 + emissivity * (longwave_w_m2 - air_w_m2);
                black_body_w_m2(self.air_c + self.warmer_k(emissivity, gained_w_m2, air_w_m2))
            }
        };
        emissivity * black_w_m2 + (1.0 - emissivity) * longwave_w_m2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OPEN: SixPlanes<ViewShares> = SixPlanes {
        up: ViewShares { sky: 1.0, obstruction: 0.0, missed: 1.0 },
        down: ViewShares { sky: 0.0, obstruction: 0.0, missed: 0.0 },
        sides: [ViewShares { sky: 0.5, obstruction: 0.0, missed: 0.5 }; 4],
    };

    const UNDER_ROOF: SixPlanes<ViewShares> = SixPlanes {
        up: ViewShares { sky: 0.0, obstruction: 1.0, missed: 0.0 },
        down: ViewShares { sky: 0.0, obstruction: 0.0, missed: 0.0 },
        sides: [ViewShares { sky: 0.0, obstruction: 0.5, missed: 0.0 }; 4],
    };

    fn given(celsius: f64, emissivity: f64) -> ClassSurfaces {
        ClassSurfaces { heat: SurfaceHeat::Given(black_body_w_m2(celsius)), emissivity }
    }

    fn around(ground: ClassSurfaces, obstruction: ClassSurfaces) -> HeatAround {
        HeatAround { sky_w_m2: 300.0, air_c: 20.0, film_w_m2_k: USUAL_FILM_W_M2_K, ground, obstruction }
    }

    /// On an open plain of 40 degrees and emissivity 0.95 below a sky of 300 W/m2: 300 from above, 0.95 sigma 313.15^4 + 0.05 x 300 =
    /// 533.0 from below, the mean of the two on the sides, within 0.05.
    #[test]
    fn open_plain() {
        let found = around(given(40.0, 0.95), given(0.0, 0.9)).longwave(&OPEN, &SixPlanes::default());
        let below = 0.95 * black_body_w_m2(40.0) + 0.05 * 300.0;
        assert!((found.up - 300.0).abs() < 1e-9 && (found.down - below).abs() < 1e-9, "{found:?}");
        assert!(found.sides.iter().all(|side| (side - 0.5 * (300.0 + below)).abs() < 1e-9), "{found:?}");
    }

    /// Between an endless roof and the ground, both gray, what each sends is that of two endless plates, J1 = e1 B1 + (1 - e1) J2 and so on,
    /// within 0.3 W/m2; where both are as warm as each other it is sigma T^4 within 1e-9.
    #[test]
    fn below_a_roof() {
        let (ground, roof) = (given(30.0, 0.95), given(12.0, 0.9));
        let found = around(ground, roof).longwave(&UNDER_ROOF, &SixPlanes::default());
        let (warm, cold) = (black_body_w_m2(30.0), black_body_w_m2(12.0));
        let of_roof = (0.9 * cold + 0.1 * 0.95 * warm) / (1.0 - 0.1 * 0.05);
        let of_ground = 0.95 * warm + 0.05 * of_roof;
        // What the roof gets is taken as the mean of the sides, half of it from the roof itself: a tenth of half the difference is lost.
        assert!((found.up - of_roof).abs() < 5.0 && (found.down - of_ground).abs() < 0.5, "{found:?} {of_roof}");
        let even = around(given(20.0, 0.95), given(20.0, 0.9)).longwave(&UNDER_ROOF, &SixPlanes::default());
        assert!((even.up - black_body_w_m2(20.0)).abs() < 1e-9, "{even:?}");
    }

    /// By hand: ground that absorbs 0.8 of 850 W/m2 below a sky that sends as much as the air is 37.5 K warmer than it: 11.57 x 37.5 = 434 W/m2 go to the
    /// air, 0.95 sigma (330.65^4 - 293.15^4) = 246 are radiated, 680 in all. By the tangent it would be 40 K.
    #[test]
    fn sol_air() {
        let ground = ClassSurfaces { heat: SurfaceHeat::SolAir(0.8), emissivity: 0.95 };
        let sky_w_m2 = black_body_w_m2(20.0);
        let sunny = SixPlanes { up: 850.0, down: 100.0, sides: [200.0; 4] };
        let found = HeatAround { sky_w_m2, ..around(ground, given(20.0, 0.9)) }.longwave(&OPEN, &sunny);
        let expected = 0.95 * black_body_w_m2(57.5) + 0.05 * sky_w_m2;
        assert!((found.down - expected).abs() < 0.2, "{found:?} {expected}");
    }

    /// A wall in the south that the sun does not reach is colder than one in the north that it shines on: of walls all around, with 400 W/m2 on planes
    /// that look south, the side that looks north sees a wall that is some 16 K warmer (400 x 0.7 / 17 by the tangent); the wall across from it is warmed by that one.
    #[test]
    fn opposite_walls() {
        let wall = ClassSurfaces { heat: SurfaceHeat::SolAir(0.7), emissivity: 1.0 };
        let walls = ViewShares { sky: 0.0, obstruction: 1.0, missed: 0.0 };
        let views = SixPlanes {
            up: ViewShares { sky: 1.0, obstruction: 0.0, missed: 1.0 },
            down: ViewShares::default(),
            sides: [walls; 4],
        };
        let light = SixPlanes { up: 0.0, down: 0.0, sides: [0.0, 0.0, 400.0, 0.0] };
        let found = around(given(20.0, 1.0), wall).longwave(&views, &light);
        let [north, _, south, _] = found.sides;
        let colder = found.sides[1];
        assert!(north > colder + 80.0 && south - colder < 60.0, "{found:?}");
    }

    /// In a sunny court with gray walls of sol-air temperature surfaces send what follows from what they get, within 0.1 W/m2. Walls with the least coefficient stay below 120 degrees.
    #[test]
    fn courts_are_in_balance() {
        let views = SixPlanes {
            up: ViewShares { sky: 0.1, obstruction: 0.9, missed: 0.12 },
            down: ViewShares { sky: 0.0, obstruction: 0.05, missed: 0.0 },
            sides: [ViewShares { sky: 0.0, obstruction: 0.6, missed: 0.0 }; 4],
        };
        let light = SixPlanes { up: 600.0, down: 150.0, sides: [200.0, 200.0, 600.0, 200.0] };
        let class = |absorbed, emissivity| ClassSurfaces { heat: SurfaceHeat::SolAir(absorbed), emissivity };
        let court = around(class(0.8, 0.95), class(0.7, 0.9));
        let found = court.longwave(&views, &light);
        // The balance itself: ground and walls send what follows from what they get.
        let air_w_m2 = black_body_w_m2(court.air_c);
        let ground = court.sent(&court.ground, found.up, light.up, air_w_m2);
        let (got, lit) = (found.on_obstructions(), light.on_obstructions());
        let wall = |got: f64, lit: f64| court.sent(&court.obstruction, got, lit, air_w_m2);
        let up = 0.1 * air_w_m2 - 0.12 * (air_w_m2 - court.sky_w_m2) + 0.9 * wall(got.up, lit.up);
        let south = 0.6 * wall(got.sides[2], lit.sides[2]) + 0.4 * ground;
        assert!((found.up - up).abs() < 0.1 && (found.sides[2] - south).abs() < 0.1, "{found:?} {up} {south}");
        for gained_w_m2 in [-150.0, 10.0, 700.0] {
            let warmer_k = court.warmer_k(0.9, gained_w_m2, air_w_m2);
            let convection = court.film_w_m2_k - 4.0 * 0.9 * air_w_m2 / (court.air_c + ZERO_CELSIUS_K);
            let lost = convection * warmer_k + 0.9 * (black_body_w_m2(court.air_c + warmer_k) - air_w_m2);
            assert!((lost - gained_w_m2).abs() < 0.01, "{gained_w_m2}: {warmer_k} K");
        }
        let calm = HeatAround { film_w_m2_k: LEAST_FILM_W_M2_K, ..court }.longwave(&views, &light);
        assert!(calm.up > found.up && calm.up < black_body_w_m2(120.0), "{calm:?}");
    }
}
