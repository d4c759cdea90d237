//! Root of a function of one variable. In: a function and two points where its signs differ. Out:
//! the point where the sign changes.
//!
//! Chandrupatla, "A new hybrid quadratic/bisection algorithm for finding the zero of a nonlinear
//! function without using derivatives", Advances in Engineering Software 28(3), 1997: inverse
//! quadratic interpolation where that is safe, else bisection. A jump over zero is found as well as
//! a root: the point of the jump is returned.

/// Largest number of steps; bisection of doubles needs fewer.
const MAX_STEPS: usize = 200;

/// A point of the function's graph.
#[derive(Clone, Copy)]
struct Point {
    x: f64,
    y: f64,
}

/// Interval in which a root is looked for.
#[derive(Clone, Copy, Debug)]
pub struct Bracket {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Width of the bracket at which the search ends.
    pub tolerance: f64,
}

/// Returns the point inside `bracket` where `function` changes its sign; `None` if the signs at its
/// ends are equal or a value is not a number.
pub fn bracketed_root(function: impl Fn(f64) -> f64, bracket: &Bracket) -> Option<f64> {
    let point = |x: f64| Some(Point { x, y: function(x) }).filter(|point| point.y.is_finite());
    let (mut newest, mut opposite) = (point(bracket.high)?, point(bracket.low)?);
    if newest.y == 0.0 || opposite.y == 0.0 {
        return Some(if newest.y == 0.0 { newest.x } else { opposite.x });
    }
    if (newest.y > 0.0) == (opposite.y > 0.0) {
        return None;
    }
    let mut share = 0.5;
    for _ in 0..MAX_STEPS {
        let next = point(newest.x + share * (opposite.x - newest.x))?;
        let former = if (next.y > 0.0) == (newest.y > 0.0) { newest } else { std::mem::replace(&mut opposite, newest) };
        newest = next;
        let best = if newest.y.abs() < opposite.y.abs() { newest } else { opposite };
        let width = (opposite.x - newest.x).abs();
        if best.y == 0.0 || width <= bracket.tolerance {
            return Some(best.x);
        }
        // Half a tolerance from either end at least, so that the bracket shrinks to it.
        let least = (0.5 * bracket.tolerance / width).min(0.5);
        share = next_share(newest, opposite, former).clamp(least, 1.0 - least);
    }
    None
}

/// Returns the share of the way from the newest point to the opposite one at which the function is
/// evaluated next.
fn next_share(a: Point, b: Point, c: Point) -> f64 {
    let xi = (a.x - b.x) / (c.x - b.x);
    let phi = (a.y - b.y) / (c.y - b.y);
    if phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi {
        let near = a.y / (b.y - a.y) * c.y / (b.y - c.y);
        let far = (c.x - a.x) / (b.x - a.x) * a.y / (c.y - a.y) * b.y / (c.y - b.y);
        near + far
    } else {
        0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn root(function: impl Fn(f64) -> f64) -> Option<f64> {
        bracketed_root(function, &Bracket { low: -10.0, high: 20.0, tolerance: 1e-10 })
    }

    /// The roots of a cubic, of an exponential and at either end, and a jump from 1 to -1 are found
    /// within 1e-10.
    #[test]
    fn roots_and_jumps_are_found() {
        let jump = |x: f64| if x < 4.5 { 1.0 } else { -1.0 };
        for (got, expected) in [
            (root(|x| x * x * x - 8.0), 2.0),
            (root(|x| 1.0 - (x - 3.0).exp()), 3.0),
            (root(|x| x + 10.0), -10.0),
            (root(|x| x - 20.0), 20.0),
            (root(jump), 4.5),
        ] {
            let got = got.expect("the signs differ");
            assert!((got - expected).abs() <= 1e-10, "{expected}: {got}");
        }
    }

    /// Without a change of sign there is no root, and a function that gives NaN has none.
    #[test]
    fn without_a_change_of_sign_there_is_no_root() {
        assert_eq!(root(|x| x * x + 1.0), None);
        assert_eq!(root(|_| f64::NAN), None);
        assert_eq!(root(|x| if x.abs() < 9.0 { f64::NAN } else { x }), None);
    }

    /// A smooth function takes at most 15 evaluations to 1e-10, where bisection takes 38.
    #[test]
    fn a_smooth_root_takes_at_most_15_evaluations() {
        let count = std::cell::Cell::new(0);
        let got = root(|x| {
            count.set(count.get() + 1);
            (x / 10.0).exp() - 2.0
        });
        assert!((got.expect("a root") - 10.0 * 2.0_f64.ln()).abs() < 1e-9);
        assert!(count.get() <= 15, "{}", count.get());
    }
}
