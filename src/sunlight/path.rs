//! The path of the sun over a day. In: a site, a date, the direction of true north. Out: the sun at
//! any moment, times of its positions, and the texels of a sky texture that it passes.

use std::ops::Range;

use glam::DVec3;

use crate::spells::{Spell, Spells};
use heliotile_core::hemisphere::texel_of;
use heliotile_core::layers::sides::TextureSides;
use heliotile_core::site::north::North;
use heliotile_core::weather::clear::clear_sky;
use heliotile_core::weather::time::calendar::Date;
use heliotile_core::weather::time::sun::Location;

/// Minutes between computed positions. In between, a cubic through the four nearest is right to
/// 1e-7 rad (test).
const KNOT_MIN: f64 = 4.0;

/// Minutes of a day.
const DAY_MIN: f64 = 1440.0;

/// Minutes between looks at the texel of the sun. A texel that the sun passes faster is cut at a
/// corner, and is negligible.
const LOOK_MIN: f64 = 0.1;

/// Number of knots between looks at the side of a plane on which the sun stands: 16 minutes.
const PLANE_STRIDE: usize = 4;

/// Number of steps of a search between two moments; halvings of 0.1 minutes find the moment to 1
/// ms.
const BISECTIONS: usize = 18;

/// Moments closer than this are one, minutes.
const CLOSE_MIN: f64 = 1e-9;

/// The sun on a day of local standard time.
#[derive(Clone, Debug)]
pub struct SunDay {
    /// Date of the day.
    pub date: Date,
    /// Unit vectors to the sun in the axes of a site, [`KNOT_MIN`] apart; the first is [`KNOT_MIN`]
    /// before midnight.
    knots: Vec<DVec3>,
    /// Time in which the sun's centre is above the horizon.
    pub up: Spells,
    /// DNI of the day's weather; `None` for a clear sky.
    weather: Option<Vec<DniSpell>>,
}

/// Interval of weather, with its direct normal irradiance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DniSpell {
    /// Interval of the day.
    pub spell: Spell,
    /// Mean direct normal irradiance of the interval, W/m2.
    pub dni_w_m2: f64,
}

/// Texels of a sky texture that the sun passes on a day.
#[derive(Clone, Debug, Default)]
pub struct SunPasses {
    /// Ways through base texels, in order of time.
    pub(super) bases: Vec<BasePass>,
    /// `[fine texel]`: its number within its base texel, row by row.
    pub(super) places: Vec<u16>,
    /// `[fine texel]`: when the sun leaves it; the sun enters it when it leaves the one before.
    ends_min: Vec<f32>,
    /// `[way through a base texel][word]`: the passed fine texels, as bits of the base texel.
    passed: Vec<u64>,
    /// Number of words of a base texel.
    words: usize,
}

/// Way of the sun through a base texel.
#[derive(Clone, Debug)]
pub(super) struct BasePass {
    /// Column of the base texel.
    pub column: u16,
    pub row: u16,
    pub start_min: f64,
    pub end_min: f64,
    /// Fine texels on the way.
    pub fine: Range<u32>,
}

/// Way through fine texels, while the sun is followed.
struct FineWay<'p> {
    passes: &'p mut SunPasses,
    block: usize,
    /// True at the start of a spell of sun: it starts a new way, even in the base texel of the last
    /// one.
    is_new: bool,
}

impl SunDay {
    /// Returns the sun over a site, in axes with this true north.
    pub fn new(site: &Location, date: Date, north: North) -> Self {
        let count = (DAY_MIN / KNOT_MIN) as usize + 3;
        let at = |knot: usize| north.to_axes(site.sun(date, (knot as f64 - 1.0) * KNOT_MIN));
        let mut day = SunDay { date, knots: (0..count).map(at).collect(), up: Spells::default(), weather: None };
        day.up = day.when(|sun| sun.z);
        day
    }

    /// Returns the day under weather, or under a clear sky for `None`.
    #[must_use]
    pub fn under(self, weather: Option<Vec<DniSpell>>) -> Self {
        SunDay { weather, ..self }
    }

    /// Returns the direct normal irradiance at a moment, W/m2: that of a clear sky, or the mean of
    /// the interval of the weather. Of weather of several years the highest counts; without an
    /// interval it is 0, as it is at night.
    pub fn dni_w_m2(&self, minutes: f64) -> f64 {
        let sine = self.sun(minutes).z;
        match &self.weather {
            _ if sine <= 0.0 => 0.0,
            None => clear_sky(sine).0,
            Some(intervals) => {
                let is_now = |one: &&DniSpell| (one.spell.start_min..one.spell.end_min).contains(&minutes);
                intervals.iter().filter(is_now).map(|one| one.dni_w_m2).fold(0.0, f64::max)
            }
        }
    }

    /// Iterates over the intervals of the weather; there are none under a clear sky.
    pub fn intervals(&self) -> impl Iterator<Item = &Spell> {
        self.weather.iter().flatten().map(|one| &one.spell)
    }

    /// Returns the unit vector to the sun's centre, `minutes` after midnight, 0 to 1440.
    pub fn sun(&self, minutes: f64) -> DVec3 {
        let at = (minutes / KNOT_MIN).clamp(0.0, (self.knots.len() - 4) as f64 + 1.0);
        // The first knot lies one step before midnight, so the four knots around a moment begin
        // with the number of steps before it.
        let knot = (at as usize).min(self.knots.len() - 4);
        let four = self.knots.iter().skip(knot).zip(cubic(at - knot as f64));
        four.map(|(direction, weight)| weight * *direction).sum::<DVec3>().normalize_or_zero()
    }

    /// Returns the time in which a function of the sun's direction is above 0; changes that last
    /// less than four minutes may be missed.
    pub fn when(&self, function: impl Fn(DVec3) -> f64) -> Spells {
        let at = |knot: usize| self.knots.get(knot).map_or(f64::NAN, |sun| function(*sun));
        self.looked_at(1, at, |knot| {
            let (start_min, next) = ((knot - 1) as f64 * KNOT_MIN, knot + 1);
            zero(start_min, at(knot), start_min + KNOT_MIN, at(next), |minutes| function(self.sun(minutes)))
        })
    }

    /// Returns the time in which values at knots are above 0, from a look at every `stride` knots.
    /// Two changes between two looks are missed. `change` finds the moment between a knot and the
    /// next one.
    fn looked_at(&self, stride: usize, at: impl Fn(usize) -> f64, change: impl Fn(usize) -> f64) -> Spells {
        // The first knot and the last one lie outside of the day.
        let last = self.knots.len().saturating_sub(2);
        let (mut spells, mut since_min, mut was) = (Spells::default(), 0.0, at(1) > 0.0);
        let mut from = 1;
        while from < last {
            let to = (from + stride).min(last);
            let is = at(to) > 0.0;
            if is != was {
                let knot = (from..to).find(|knot| (at(knot + 1) > 0.0) != was).unwrap_or(from);
                let change_min = change(knot);
                if was {
                    spells.push(since_min, change_min);
                }
                (since_min, was) = (change_min, is);
            }
            from = to;
        }
        if was {
            spells.push(since_min, DAY_MIN);
        }
        spells
    }

    /// Returns the time in which the sun's centre is at least at an altitude.
    pub fn above(&self, altitude_deg: f64) -> Spells {
        let sine = altitude_deg.to_radians().sin();
        self.when(|sun| sun.z - sine)
    }

    /// Returns the time in which the sun's centre is in front of a surface, at an angle of at least
    /// `angle_deg` to it: within a cone around the normal. For an angle of 0, visits of less than
    /// 16 minutes are missed, which stay within 0.04 degrees of the plane; for other angles, visits
    /// of less than four.
    pub fn before(&self, normal: DVec3, angle_deg: f64) -> Spells {
        let sine = angle_deg.to_radians().sin();
        let at = |knot: usize| self.knots.get(knot).map_or(f64::NAN, |sun| normal.dot(*sun) - sine);
        // The dot product of a cubic is the cubic of dot products. The sun passes the rim of a
        // narrow cone quickly, so a cone needs a look at every knot.
        let stride = if angle_deg > 0.0 { 1 } else { PLANE_STRIDE };
        self.looked_at(stride, at, |knot| {
            let four = [at(knot - 1), at(knot), at(knot + 1), at(knot + 2)];
            let start_min = (knot - 1) as f64 * KNOT_MIN;
            let of = |minutes: f64| {
                let weights = cubic((minutes - start_min) / KNOT_MIN);
                four.iter().zip(weights).map(|(value, weight)| value * weight).sum()
            };
            zero(start_min, four[1], start_min + KNOT_MIN, four[2], of)
        })
    }

    /// Returns the texels of a texture that the sun passes while it is up.
    pub fn passes(&self, sides: TextureSides) -> SunPasses {
        let block = (sides.sky_fine / sides.sky_base.max(1)).max(1);
        let mut passes = SunPasses { words: (block * block).div_ceil(64), ..SunPasses::default() };
        let texel = |minutes: f64| texel_of(self.sun(minutes), sides.sky_fine);
        for spell in self.up.iter() {
            let (mut place, mut start_min, mut last) = (texel(spell.start_min), spell.start_min, spell.start_min);
            let mut way = FineWay { passes: &mut passes, block, is_new: true };
            while last < spell.end_min {
                let at = (last + LOOK_MIN).min(spell.end_min);
                let next = texel(at);
                if next != place {
                    let change = bisect(last, at, |minutes| texel(minutes) == place);
                    way.leave(place.0, place.1, start_min, change);
                    (place, start_min) = (next, change);
                }
                last = at;
            }
            way.leave(place.0, place.1, start_min, spell.end_min);
        }
        passes
    }
}

impl FineWay<'_> {
    /// Appends a fine texel that the sun has passed.
    fn leave(&mut self, column: usize, row: usize, start_min: f64, end_min: f64) {
        let (block, passes) = (self.block, &mut *self.passes);
        let (base_column, base_row) = ((column / block) as u16, (row / block) as u16);
        let is_here = |last: &BasePass| (last.column, last.row) == (base_column, base_row);
        let count = passes.places.len() as u32;
        match passes.bases.last_mut().filter(|last| !self.is_new && is_here(last)) {
            Some(last) => (last.end_min, last.fine.end) = (end_min, count + 1),
            None => {
                let (column, row, fine) = (base_column, base_row, count..count + 1);
                passes.bases.push(BasePass { column, row, start_min, end_min, fine });
                passes.passed.resize(passes.passed.len() + passes.words, 0);
            }
        }
        self.is_new = false;
        let place = row % block * block + column % block;
        let last = passes.passed.len() - passes.words;
        if let Some(word) = passes.passed.get_mut(last + place / 64) {
            *word |= 1 << (place % 64);
        }
        passes.places.push(place as u16);
        passes.ends_min.push(end_min as f32);
    }
}

impl SunPasses {
    /// Returns the fine texels of a way through a base texel: their numbers within it, and when the
    /// sun leaves each.
    pub(super) fn fine_of(&self, pass: &BasePass) -> (&[u16], &[f32]) {
        let range = pass.fine.start as usize..pass.fine.end as usize;
        (self.places.get(range.clone()).unwrap_or_default(), self.ends_min.get(range).unwrap_or_default())
    }

    /// Iterates over the ways through base texels that reach into an interval, each with the bits
    /// of the fine texels that it passes.
    pub(super) fn bases_in(&self, start_min: f64, end_min: f64) -> impl Iterator<Item = (&BasePass, &[u64])> {
        let first = self.bases.partition_point(|base| base.end_min <= start_min);
        let last = self.bases.partition_point(|base| base.start_min < end_min);
        let bases = self.bases.get(first..last).unwrap_or_default();
        bases.iter().zip(self.passed.chunks_exact(self.words.max(1)).skip(first))
    }
}

/// Returns the weights of four neighbouring values in the cubic through them, at the share `t` of
/// the way from the second to the third: Lagrange's polynomials of -1, 0, 1 and 2.
fn cubic(t: f64) -> [f64; 4] {
    [
        -t * (t - 1.0) * (t - 2.0) / 6.0,
        (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
        -(t + 1.0) * t * (t - 2.0) / 2.0,
        (t + 1.0) * t * (t - 1.0) / 6.0,
    ]
}

/// Returns the zero of a smooth function between two moments with values of different signs, to
/// 1e-9 minutes: regula falsi in the Illinois variant.
fn zero(mut low: f64, mut of_low: f64, mut high: f64, mut of_high: f64, function: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..BISECTIONS {
        let at = (low * of_high - high * of_low) / (of_high - of_low);
        if !(at > low && at < high) || high - low < CLOSE_MIN {
            break;
        }
        let now = function(at);
        if (now > 0.0) == (of_high > 0.0) {
            // Halving the value at the end that stays makes this end move soon, too. On a curve,
            // plain regula falsi never moves one of the ends.
            (high, of_high, of_low) = (at, now, 0.5 * of_low);
        } else {
            (low, of_low, of_high) = (at, now, 0.5 * of_high);
        }
        if now.abs() < 1e-12 {
            return at;
        }
    }
    0.5 * (low + high)
}

/// Returns the moment at which `is_so` turns from true, as at `low`, to false.
fn bisect(mut low: f64, mut high: f64, is_so: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if is_so(middle) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_core::units::direction_from_degrees;

    fn day(latitude_deg: f64, month: u32) -> (Location, SunDay) {
        let site = Location::new(latitude_deg, 5.0, 1.0, 0.0).expect("a site");
        let date = Date::new(2017, month, 21).expect("a date");
        (site, SunDay::new(&site, date, North::default()))
    }

    /// Interpolated suns lie within 1e-7 rad of computed ones: 51 moments of each of 6 days, from
    /// midnight to midnight.
    #[test]
    fn interpolated_suns_equal_computed_ones() {
        for (latitude_deg, month) in [(52.0, 6), (52.0, 12), (0.0, 3), (-34.0, 9), (78.0, 6), (89.0, 4)] {
            let (site, day) = day(latitude_deg, month);
            for i in 0..=50 {
                let minutes = f64::from(i) * 28.8;
                let off = day.sun(minutes).angle_between(site.sun(day.date, minutes));
                assert!(off < 1e-7, "{latitude_deg} {month} {minutes} {off}");
            }
        }
    }

    /// On 21 March at 52 N, 5 E the sun is up for 12 hours within 6 minutes (its declination
    /// changes). Its middle is solar noon: 47 minutes after that of the clock, 40 for the longitude
    /// and 7 for the equation of time. At 78 N it stays up in June and down in December.
    #[test]
    fn days_have_known_lengths_and_solar_noon() {
        let (_, march) = day(52.0, 3);
        assert!((march.up.minutes() - 720.0).abs() < 6.0, "{}", march.up.minutes());
        let middle = march.up.first_min().zip(march.up.last_min()).map(|(a, b)| 0.5 * (a + b)).unwrap_or_default();
        assert!((middle - 767.0).abs() < 1.0, "{middle}");
        let height = |minutes| march.sun(minutes).z.asin().to_degrees();
        let above = march.above(10.0);
        for moment in [above.first_min(), above.last_min()] {
            assert!((height(moment.unwrap_or_default()) - 10.0).abs() < 1e-5);
        }
        let south = march.before(direction_from_degrees(180.0, 0.0), 0.0).within(&march.up);
        // A day after the equinox the sun rises half a degree north of east.
        assert!((0.0..10.0).contains(&(march.up.minutes() - south.minutes())), "{}", south.minutes());
        assert_eq!((day(78.0, 6).1.up.minutes(), day(78.0, 12).1.up.minutes()), (1440.0, 0.0));
    }

    /// The ways through texels of a day follow each other without a gap from sunrise to sunset,
    /// each in the texel of the sun at its middle. 1,024 texels a side are 0.14 degrees apart: the
    /// sun passes 900 to 2,000 of them in twelve hours.
    #[test]
    fn passes_follow_each_other() {
        let (_, march) = day(52.0, 3);
        let sides = TextureSides { sky_base: 128, sky_fine: 1024, response: 1 };
        let passes = march.passes(sides);
        let mut at = march.up.first_min().unwrap_or_default();
        for base in &passes.bases {
            assert_eq!(base.start_min, at);
            let (places, ends_min) = passes.fine_of(base);
            for (place, end_min) in places.iter().zip(ends_min) {
                let (column, row) = texel_of(march.sun(0.5 * (at + f64::from(*end_min))), 1024);
                assert_eq!((usize::from(base.column), usize::from(base.row)), (column / 8, row / 8));
                assert_eq!(usize::from(*place), row % 8 * 8 + column % 8);
                at = f64::from(*end_min);
            }
            assert!((at - base.end_min).abs() < 1e-4);
            at = base.end_min;
        }
        assert_eq!(Some(at), march.up.last_min());
        assert!((900..2000).contains(&passes.places.len()), "{}", passes.places.len());
    }
}
