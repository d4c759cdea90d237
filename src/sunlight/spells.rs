//! Spells: time intervals of a day. In: starts and ends. Out: unions, intersections, lengths.

use std::cmp::Ordering;

/// A time interval, minutes after the midnight that starts a day.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spell {
    /// Start, minutes after midnight.
    pub start_min: f64,
    /// End, minutes after midnight, later than the start.
    pub end_min: f64,
}

/// Spells in order of time, with gaps between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spells(Vec<Spell>);

impl Spell {
    /// Returns the length, minutes.
    pub fn minutes(&self) -> f64 {
        self.end_min - self.start_min
    }
}

impl Spells {
    /// Returns a single spell, or none if it does not end after its start.
    pub fn one(start_min: f64, end_min: f64) -> Self {
        let mut spells = Spells::default();
        spells.push(start_min, end_min);
        spells
    }

    /// Appends a spell that starts at or after the end of the last one; the two become one if they
    /// touch.
    pub fn push(&mut self, start_min: f64, end_min: f64) {
        // A NaN end is no end.
        if end_min.partial_cmp(&start_min) != Some(Ordering::Greater) {
            return;
        }
        match self.0.last_mut().filter(|last| last.end_min >= start_min) {
            Some(last) => last.end_min = last.end_min.max(end_min),
            None => self.0.push(Spell { start_min, end_min }),
        }
    }

    /// Iterates over the spells in order of time.
    pub fn iter(&self) -> impl Iterator<Item = &Spell> {
        self.0.iter()
    }

    /// Returns true if there are no spells.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the sum of the lengths, minutes.
    pub fn minutes(&self) -> f64 {
        // `sum` of nothing would be -0.
        self.0.iter().map(Spell::minutes).fold(0.0, |sum, minutes| sum + minutes)
    }

    /// Returns the length of the longest spell, minutes; 0 without spells.
    pub fn longest_min(&self) -> f64 {
        self.0.iter().map(Spell::minutes).fold(0.0, f64::max)
    }

    /// Returns the start of the first spell.
    pub fn first_min(&self) -> Option<f64> {
        self.0.first().map(|spell| spell.start_min)
    }

    /// Returns the end of the last spell.
    pub fn last_min(&self) -> Option<f64> {
        self.0.last().map(|spell| spell.end_min)
    }

    /// Returns true if a single spell covers all of `others`.
    pub fn hold(&self, others: &Spells) -> bool {
        let Some((first, last)) = others.first_min().zip(others.last_min()) else { return true };
        self.0.iter().any(|spell| spell.start_min <= first && spell.end_min >= last)
    }

    /// Returns the time that lies in both sets.
    #[must_use]
    pub fn within(&self, other: &Spells) -> Spells {
        let (mut ours, mut theirs) = (self.0.iter().peekable(), other.0.iter().peekable());
        let mut both = Spells::default();
        while let (Some(a), Some(b)) = (ours.peek(), theirs.peek()) {
            both.push(a.start_min.max(b.start_min), a.end_min.min(b.end_min));
            let is_first = a.end_min <= b.end_min;
            if is_first {
                ours.next().map(drop)
            } else {
                theirs.next().map(drop)
            };
        }
        both
    }

    /// Returns the time that lies in these spells but not in `other`.
    #[must_use]
    pub fn without(&self, other: &Spells) -> Spells {
        let mut rest = Spells::default();
        let mut others = other.0.iter().peekable();
        for spell in &self.0 {
            let mut start_min = spell.start_min;
            while let Some(cut) = others.next_if(|cut| cut.end_min <= spell.end_min) {
                rest.push(start_min, cut.start_min.min(spell.end_min));
                start_min = start_min.max(cut.end_min);
            }
            // A cut that lasts beyond this spell may cut the next one, too.
            let end_min = others.peek().map_or(spell.end_min, |cut| cut.start_min.min(spell.end_min));
            rest.push(start_min, end_min);
        }
        rest
    }

    /// Returns the time that lies in these spells, in `other`, or in both.
    #[must_use]
    pub fn and(&self, other: &Spells) -> Spells {
        let mut all: Vec<Spell> = self.0.iter().chain(&other.0).copied().collect();
        all.sort_by(|a, b| a.start_min.total_cmp(&b.start_min));
        let mut joined = Spells::default();
        all.iter().for_each(|spell| joined.push(spell.start_min, spell.end_min));
        joined
    }

    /// Returns the spells that last at least `least_min` minutes.
    #[must_use]
    pub fn lasting(&self, least_min: f64) -> Spells {
        Spells(self.0.iter().filter(|spell| spell.minutes() >= least_min).copied().collect())
    }

    /// Returns the time in which the weights of the sets that cover a moment add up to at least
    /// `least`; with 0, the time that any set covers.
    pub fn covered<'s>(sets: impl Iterator<Item = (&'s Spells, f64)>, least: f64) -> Spells {
        let mut changes: Vec<(f64, f64, i32)> = Vec::new();
        for (spells, weight) in sets {
            for spell in &spells.0 {
                changes.extend([(spell.start_min, weight, 1), (spell.end_min, -weight, -1)]);
            }
        }
        changes.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Rounding may keep sums of shares below a whole.
        let enough = least - 1e-9;
        let (mut covered, mut sum, mut count, mut since) = (Spells::default(), 0.0, 0, None);
        for at_once in changes.chunk_by(|a, b| a.0 == b.0) {
            sum += at_once.iter().map(|change| change.1).sum::<f64>();
            count += at_once.iter().map(|change| change.2).sum::<i32>();
            let (at, is_covered) = (at_once[0].0, count > 0 && sum >= enough);
            match since {
                None if is_covered => since = Some(at),
                Some(start) if !is_covered => {
                    covered.push(start, at);
                    since = None;
                }
                _ => {}
            }
        }
        covered
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spells(all: &[(f64, f64)]) -> Spells {
        let mut spells = Spells::default();
        all.iter().for_each(|(start, end)| spells.push(*start, *end));
        spells
    }

    /// 9 to 10 and 10 to 11 are one spell of 120 minutes; with 13:00 to 13:20 the sum is 140. From
    /// 10:30 to 13:10 there are 40 minutes of it; the spells of at least half an hour last 120. A
    /// spell whose end is before its start, or NaN, is none.
    #[test]
    fn spells_that_touch_are_one() {
        let day = spells(&[(540.0, 600.0), (600.0, 660.0), (780.0, 800.0), (900.0, 890.0), (950.0, f64::NAN)]);
        assert_eq!((day.iter().count(), day.minutes(), day.longest_min()), (2, 140.0, 120.0));
        assert_eq!((day.first_min(), day.last_min()), (Some(540.0), Some(800.0)));
        assert_eq!(day.within(&Spells::one(630.0, 790.0)).minutes(), 40.0);
        assert_eq!(day.lasting(30.0).minutes(), 120.0);
        assert_eq!((Spells::default().first_min(), Spells::default().longest_min()), (None, 0.0));
    }

    /// 0 to 100 and 200 to 300 without 10 to 20, 90 to 210 and 280 to 400 leaves three spells of
    /// 150 minutes; the reverse leaves two of 200. The union is one spell of 400 minutes.
    #[test]
    fn differences_of_spells_leave_the_rest() {
        let (a, b) = (spells(&[(0.0, 100.0), (200.0, 300.0)]), spells(&[(10.0, 20.0), (90.0, 210.0), (280.0, 400.0)]));
        assert_eq!(a.without(&b), spells(&[(0.0, 10.0), (20.0, 90.0), (210.0, 280.0)]));
        assert_eq!(b.without(&a), spells(&[(100.0, 200.0), (300.0, 400.0)]));
        assert_eq!(a.and(&b), Spells::one(0.0, 400.0));
        assert_eq!((a.without(&Spells::default()), a.without(&a)), (a.clone(), Spells::default()));
    }

    /// Three parts of a window with 50, 30 and 20 % of its area are lit one after the other. Any of
    /// them, or a fifth of the area, is lit from 0 to 40, half from 0 to 20, 80 % from 5 to 10, and
    /// all of it never.
    #[test]
    fn parts_of_an_area_add_up_to_its_lit_share() {
        let parts = [spells(&[(0.0, 10.0)]), spells(&[(5.0, 20.0)]), spells(&[(10.0, 40.0)])];
        let covered = |least| Spells::covered(parts.iter().zip([0.5, 0.3, 0.2]), least);
        assert_eq!(covered(0.0), spells(&[(0.0, 40.0)]));
        assert_eq!(covered(0.2), spells(&[(0.0, 40.0)]));
        assert_eq!(covered(0.5), spells(&[(0.0, 20.0)]));
        assert_eq!(covered(0.8), spells(&[(5.0, 10.0)]));
        assert_eq!(covered(1.0), Spells::default());
        assert_eq!(Spells::covered([(&parts[0], 0.5), (&parts[0], 0.5)].into_iter(), 1.0), parts[0]);
    }
}
