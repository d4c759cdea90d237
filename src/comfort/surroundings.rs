//! Longwave radiation on a person from the sky and the surfaces around. In: shares of six
//! hemispheres that are sky, ground and obstructions, shortwave irradiance of the six planes, air.
//! Out: longwave irradiance of the planes.
//!
//! A surface sends epsilon sigma T^4 and reflects the rest of its irradiance. The irradiance of a
//! surface is taken from the planes at the point itself: ground gets that of the plane that faces
//! up, and an obstruction that a side sees gets that of the opposite side. Obstructions that are
//! seen above and below get the mean of the four sides. The temperature of a surface is given, or
//! it is the sol-air temperature, at which a surface without storage is in balance. Where materials
//! differ, emissivity and absorptance of obstructions are means over those that a plane sees, and
//! those of ground are means over what all planes see.
//!
//! Sol-air temperature: ASHRAE Handbook Fundamentals, 2017, chapter 18, equation 29: T = T_air + (a
//! K + e (L - sigma T_air^4)) / h, where K and L are the shortwave and longwave irradiance of the
//! surface, and h includes its own radiation. That is the tangent of the balance that is solved
//! here, h_c (T - T_air) = a K + e (L - sigma T^4) with h_c = h - 4 e sigma T_air^3. By the
//! tangent, sunny walls of a court, which warm each other, would have no finite temperature.

use crate::mean_radiant::DirectionalIrradiance;
use heliotile_core::weather::emission::{ZERO_CELSIUS_K, black_body_w_m2};

/// Heat transfer coefficient between surfaces and air, radiation included, W/m2K: the value of
/// ASHRAE's sol-air temperatures, for a wind of 3.4 m/s.
pub const USUAL_FILM_W_M2_K: f64 = 17.0;

/// Emissivity of ground in SOLWEIG (Lindberg, Holmer and Thorsson 2008).
pub const USUAL_GROUND_EMISSIVITY: f64 = 0.95;

/// Emissivity of walls in SOLWEIG.
pub const USUAL_OBSTRUCTION_EMISSIVITY: f64 = 0.90;

/// Change of a plane, W/m2, below which Newton's method stops. It finds planes and temperatures
/// together. The planes are then within 0.1 of the balance (a test).
const ENOUGH_W_M2: f64 = 0.05;

/// Largest number of steps of Newton's method; three are usual.
const MAX_STEPS: usize = 20;

/// Least share of the radiation between surfaces that is lost. Without it heat would have no way
/// out.
const MIN_LOSS: f64 = 1e-3;

/// Least heat transfer coefficient, W/m2K. It includes the radiation of surfaces, 4 sigma T^3,
/// which is 7 at 40 degrees.
pub const MIN_FILM_W_M2_K: f64 = 10.0;

/// A value for each of the six planes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SixPlanes<T> {
    /// Value of the plane that faces up.
    pub up: T,
    /// Value of the plane that faces down.
    pub down: T,
    /// Values of the planes that face north, east, south and west.
    pub sides: [T; 4],
}

/// Mean emissivity and absorptance over surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceMean {
    /// Longwave emissivity.
    pub emissivity: f64,
    /// Share of shortwave irradiance that is absorbed.
    pub absorptance: f64,
}

/// Means over the surfaces that a plane sees, weighted by the cosine. `None`: the values of the
/// class are used, as where all its materials are equal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeenSurfaces {
    /// Mean over ground.
    pub ground: Option<SurfaceMean>,
    /// Mean over obstructions.
    pub obstruction: Option<SurfaceMean>,
}

/// Shares of a hemisphere, weighted by the cosine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ViewShares {
    /// Share that is sky.
    pub sky: f64,
    /// Share that is obstructions; the rest is ground.
    pub obstruction: f64,
    /// Deficit of the sky's longwave irradiance beside a black sky, as a share of that of an open
    /// horizontal plane ([`crate::clear_sky`]). If it equals the share of the sky, the sky
    /// is isotropic.
    pub missed: f64,
    /// Means over the surfaces that are seen.
    pub surfaces: SeenSurfaces,
}

/// Temperature of the surfaces of a class.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SurfaceHeat {
    /// Given: the exitance of a black surface of their temperature, W/m2.
    Given(f64),
    /// Sol-air temperature, with the share of shortwave irradiance that they absorb.
    SolAir(f64),
}

/// Temperature and emissivity of the surfaces of a class.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClassSurfaces {
    /// Temperature of the surfaces.
    pub heat: SurfaceHeat,
    /// Longwave emissivity.
    pub emissivity: f64,
}

/// Sky, air and surfaces around a person in an hour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatAround {
    /// Longwave irradiance of an open horizontal plane, W/m2.
    pub sky_w_m2: f64,
    /// Temperature of the air, degrees Celsius.
    pub air_c: f64,
    /// Heat transfer coefficient between surfaces and air, W/m2K.
    pub film_w_m2_k: f64,
    /// Ground.
    pub ground: ClassSurfaces,
    /// Obstructions.
    pub obstruction: ClassSurfaces,
}

impl SurfaceMean {
    /// Returns the weighted mean of some means, or `None` without any.
    pub fn new(parts: impl IntoIterator<Item = (f64, Option<SurfaceMean>)>) -> Option<Self> {
        let (mut weight, mut emissivity, mut absorptance) = (0.0, 0.0, 0.0);
        for (of_part, mean) in parts {
            let Some(mean) = mean else { continue };
            weight += of_part;
            emissivity += of_part * mean.emissivity;
            absorptance += of_part * mean.absorptance;
        }
        (weight > 0.0).then(|| SurfaceMean { emissivity: emissivity / weight, absorptance: absorptance / weight })
    }
}

impl ViewShares {
    /// Returns the share that is ground.
    pub fn ground(&self) -> f64 {
        (1.0 - self.sky - self.obstruction).max(0.0)
    }

    /// Returns the share of obstructions and their mean.
    fn obstructions(&self) -> (f64, Option<SurfaceMean>) {
        (self.obstruction, self.surfaces.obstruction)
    }
}

impl ClassSurfaces {
    /// Returns the surfaces with the values of materials of this mean.
    fn of_mean(self, mean: Option<SurfaceMean>) -> Self {
        let Some(SurfaceMean { emissivity, absorptance }) = mean else { return self };
        let heat = match self.heat {
            SurfaceHeat::SolAir(_) => SurfaceHeat::SolAir(absorptance),
            given @ SurfaceHeat::Given(_) => given,
        };
        ClassSurfaces { heat, emissivity }
    }
}

impl<T> SixPlanes<T> {
    fn map<U>(self, of: impl Fn(T) -> U) -> SixPlanes<U> {
        SixPlanes { up: of(self.up), down: of(self.down), sides: self.sides.map(of) }
    }
}

impl SixPlanes<f64> {
    /// Calls `of` with each value in the order up, down, north, east, south, west.
    pub fn each(&self, of: impl FnMut(f64)) {
        [self.up, self.down].into_iter().chain(self.sides).for_each(of);
    }

    /// Returns the values less those of `part`.
    pub fn less(&self, part: &SixPlanes<f64>) -> SixPlanes<f64> {
        let mut sides = self.sides;
        sides.iter_mut().zip(part.sides).for_each(|(side, part)| *side -= part);
        SixPlanes { up: self.up - part.up, down: self.down - part.down, sides }
    }

    /// Returns the irradiance of the obstructions that each plane sees.
    fn on_obstructions(&self) -> SixPlanes<f64> {
        let [north, east, south, west] = self.sides;
        let mean = 0.25 * self.sides.iter().sum::<f64>();
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
    /// Returns the longwave irradiance of the six planes, W/m2; `shortwave` is their shortwave
    /// irradiance.
    pub fn longwave(&self, views: &SixPlanes<ViewShares>, shortwave: &SixPlanes<f64>) -> SixPlanes<f64> {
        let balances = self.balances(views);
        let mut sent = balances.at_first();
        let mut planes = balances.on_planes(views, &sent).map(|plane| plane.w_m2);
        for _ in 0..MAX_STEPS {
            sent = balances.sent_back(&sent, shortwave, &planes);
            let next = balances.on_planes(views, &sent).solved_about(&planes);
            let mut change = 0.0;
            next.less(&planes).each(|off| change = f64::max(change, off.abs()));
            planes = next;
            if change < ENOUGH_W_M2 {
                break;
            }
        }
        planes
    }

    fn balances(&self, views: &SixPlanes<ViewShares>) -> Balances {
        let air_w_m2 = black_body_w_m2(self.air_c);
        let of = |class: ClassSurfaces, mean: Option<SurfaceMean>| {
            let class = class.of_mean(mean);
            let radiation_w_m2_k = radiation_w_m2_k(class.emissivity, air_w_m2, self.air_c);
            Balance { class, convection_w_m2_k: (self.film_w_m2_k - radiation_w_m2_k).max(0.0), radiation_w_m2_k }
        };
        let ends = [&views.up, &views.down];
        let seen = ends.into_iter().chain(&views.sides);
        Balances {
            air_c: self.air_c,
            air_w_m2,
            sky_w_m2: self.sky_w_m2,
            ground: of(self.ground, SurfaceMean::new(seen.map(|view| (view.ground(), view.surfaces.ground)))),
            ends: of(self.obstruction, SurfaceMean::new(ends.map(ViewShares::obstructions))),
            sides: views.sides.map(|view| of(self.obstruction, view.surfaces.obstruction)),
        }
    }
}

/// Balances of all surfaces, with the values that they share.
struct Balances {
    air_c: f64,
    /// Exitance of a black surface as warm as the air, W/m2.
    air_w_m2: f64,
    sky_w_m2: f64,
    ground: Balance,
    /// Balance of the obstructions that are seen above and below.
    ends: Balance,
    /// Balances of the obstructions that each side sees.
    sides: [Balance; 4],
}

/// Balance of the surfaces of a class.
struct Balance {
    class: ClassSurfaces,
    /// Heat transfer coefficient of the surface without its radiation at the air's temperature.
    convection_w_m2_k: f64,
    /// Radiative coefficient at the air's temperature.
    radiation_w_m2_k: f64,
}

/// Exitances of ground and obstructions.
#[derive(Clone, Copy)]
struct Exitances {
    ground: Exitance,
    /// Exitances of the obstructions that each plane sees.
    obstructions: SixPlanes<Exitance>,
}

/// Radiation that leaves a surface.
#[derive(Clone, Copy, Debug, Default)]
struct Exitance {
    w_m2: f64,
    /// Its derivative by the longwave irradiance of the surface.
    by_irradiance: f64,
    /// Temperature of the surface above that of the air, K.
    warmer_k: f64,
    /// Exitance of a black surface of that temperature, W/m2.
    black_w_m2: f64,
    /// Derivative of the surface's own radiation by temperature.
    radiation_w_m2_k: f64,
}

impl Balances {
    /// Returns the exitances before any irradiance is known: black surfaces, as warm as the air or
    /// as given.
    fn at_first(&self) -> Exitances {
        let first = |of: &Balance| {
            let w_m2 = match of.class.heat {
                SurfaceHeat::Given(w_m2) => w_m2,
                SurfaceHeat::SolAir(_) => self.air_w_m2,
            };
            let (black_w_m2, radiation_w_m2_k) = (self.air_w_m2, of.radiation_w_m2_k);
            Exitance { w_m2, black_w_m2, radiation_w_m2_k, ..Exitance::default() }
        };
        let (ends, sides) = (first(&self.ends), self.sides.each_ref().map(first));
        Exitances { ground: first(&self.ground), obstructions: SixPlanes { up: ends, down: ends, sides } }
    }

    /// Returns the exitances of surfaces whose irradiance follows from `planes`; `before` are those
    /// of the step before.
    fn sent_back(&self, before: &Exitances, shortwave: &SixPlanes<f64>, planes: &SixPlanes<f64>) -> Exitances {
        let (got, light) = (planes.on_obstructions(), shortwave.on_obstructions());
        // Obstructions seen above and below have one irradiance.
        let ends = self.exitance(&self.ends, &before.obstructions.up, got.up, light.up);
        let mut sides = before.obstructions.sides;
        for ((side, of), (got, light)) in sides.iter_mut().zip(&self.sides).zip(got.sides.into_iter().zip(light.sides))
        {
            *side = self.exitance(of, side, got, light);
        }
        Exitances {
            ground: self.exitance(&self.ground, &before.ground, planes.up, shortwave.up),
            obstructions: SixPlanes { up: ends, down: ends, sides },
        }
    }

    /// Returns the exitance of a surface of this longwave and shortwave irradiance: a step of
    /// Newton's method from the temperature that it had.
    fn exitance(&self, of: &Balance, before: &Exitance, longwave_w_m2: f64, shortwave_w_m2: f64) -> Exitance {
        let emissivity = of.class.emissivity;
        let reflected_w_m2 = (1.0 - emissivity) * longwave_w_m2;
        match of.class.heat {
            SurfaceHeat::Given(black_w_m2) => {
                Exitance { w_m2: emissivity * black_w_m2 + reflected_w_m2, by_irradiance: 1.0 - emissivity, ..*before }
            }
            SurfaceHeat::SolAir(absorbed) => {
                let gained_w_m2 = absorbed * shortwave_w_m2 + emissivity * (longwave_w_m2 - self.air_w_m2);
                let lost_w_m2 =
                    of.convection_w_m2_k * before.warmer_k + emissivity * (before.black_w_m2 - self.air_w_m2);
                let slope_w_m2_k = of.convection_w_m2_k + before.radiation_w_m2_k;
                let warmer_k = before.warmer_k + (gained_w_m2 - lost_w_m2) / slope_w_m2_k;
                let celsius = self.air_c + warmer_k;
                let black_w_m2 = black_body_w_m2(celsius);
                let radiation_w_m2_k = radiation_w_m2_k(emissivity, black_w_m2, celsius);
                let by_irradiance = emissivity * radiation_w_m2_k / (of.convection_w_m2_k + radiation_w_m2_k);
                Exitance {
                    w_m2: emissivity * black_w_m2 + reflected_w_m2,
                    by_irradiance: by_irradiance + (1.0 - emissivity),
                    warmer_k,
                    black_w_m2,
                    radiation_w_m2_k,
                }
            }
        }
    }

    /// Returns the irradiance of planes from the sky, from ground and from the obstructions that
    /// each of them sees.
    fn on_planes(&self, views: &SixPlanes<ViewShares>, sent: &Exitances) -> SixPlanes<OnPlane> {
        let Exitances { ground, obstructions } = sent;
        let on_plane = |view: &ViewShares, obstruction: &Exitance| {
            let of_ground = view.ground();
            let of_sky = view.sky * self.air_w_m2 - view.missed * (self.air_w_m2 - self.sky_w_m2);
            OnPlane {
                w_m2: of_sky + view.obstruction * obstruction.w_m2 + of_ground * ground.w_m2,
                by_obstruction: view.obstruction * obstruction.by_irradiance,
                by_ground: of_ground * ground.by_irradiance,
            }
        };
        let mut sides = [OnPlane::default(); 4];
        for ((side, view), obstruction) in sides.iter_mut().zip(&views.sides).zip(&obstructions.sides) {
            *side = on_plane(view, obstruction);
        }
        SixPlanes { up: on_plane(&views.up, &obstructions.up), down: on_plane(&views.down, &obstructions.down), sides }
    }
}

/// Returns the derivative of a surface's radiation by its temperature, W/m2K: 4 epsilon sigma T^3.
fn radiation_w_m2_k(emissivity: f64, black_w_m2: f64, celsius: f64) -> f64 {
    4.0 * emissivity * black_w_m2 / (celsius + ZERO_CELSIUS_K)
}

/// Longwave irradiance of a plane.
#[derive(Clone, Copy, Debug, Default)]
struct OnPlane {
    w_m2: f64,
    /// Its derivative by the longwave irradiance of the obstructions that it sees.
    by_obstruction: f64,
    /// Its derivative by the longwave irradiance of the ground.
    by_ground: f64,
}

/// Change of an irradiance as a linear function of the change of that of the plane that faces up.
#[derive(Clone, Copy)]
struct Change {
    constant: f64,
    by_up: f64,
}

impl SixPlanes<OnPlane> {
    /// Returns irradiances that agree with the exitances that they cause, linearised about
    /// `planes`, from which the exitances follow: one step of Newton's method.
    fn solved_about(&self, planes: &SixPlanes<f64>) -> SixPlanes<f64> {
        let [north, east, south, west] = &self.sides;
        let [at_north, at_east, at_south, at_west] = planes.sides;
        let of_sides = [
            north.facing(at_north, south, at_south),
            east.facing(at_east, west, at_west),
            south.facing(at_south, north, at_north),
            west.facing(at_west, east, at_east),
        ];
        let constant = 0.25 * of_sides.iter().map(|side| side.constant).sum::<f64>();
        let by_up = 0.25 * of_sides.iter().map(|side| side.by_up).sum::<f64>();
        let up = &self.up;
        // Share of a change of the upper plane that returns to it by ground and obstructions.
        let kept = up.by_ground + up.by_obstruction * by_up;
        let up_changes = (up.w_m2 - planes.up + up.by_obstruction * constant) / (1.0 - kept).max(MIN_LOSS);
        let sides_change = constant + by_up * up_changes;
        let mut solved = SixPlanes {
            up: planes.up + up_changes,
            down: self.down.w_m2 + self.down.by_obstruction * sides_change + self.down.by_ground * up_changes,
            sides: planes.sides,
        };
        for (side, change) in solved.sides.iter_mut().zip(of_sides) {
            *side += change.constant + change.by_up * up_changes;
        }
        solved
    }
}

impl OnPlane {
    /// Returns the change of a side at `at` together with the opposite side. The light on each
    /// falls on the obstructions that the other one sees.
    fn facing(&self, at: f64, opposite: &OnPlane, opposite_at: f64) -> Change {
        let gain = 1.0 / (1.0 - self.by_obstruction * opposite.by_obstruction).max(MIN_LOSS);
        let solve = |own: f64, other: f64| (own + self.by_obstruction * other) * gain;
        Change {
            constant: solve(self.w_m2 - at, opposite.w_m2 - opposite_at),
            by_up: solve(self.by_ground, opposite.by_ground),
        }
    }
}

#[cfg(test)]
#[path = "surroundings_tests.rs"]
mod tests;
