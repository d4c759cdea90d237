//! Union of two sorted sequences. In: two sequences. Out: their items in one sequence.

use std::cmp::Ordering;
use std::path::Path;

use heliotile_core::error::{Error, Result};
use heliotile_core::text::{FirstNames, counted};

/// Item of a union, by the sequences that hold it.
pub enum Side<T> {
    Left(T),
    Right(T),
    /// Items of equal order, the left one first.
    Both(T, T),
}

impl<T> Side<T> {
    /// Returns the left item, or the only one.
    pub fn first(self) -> T {
        match self {
            Side::Left(item) | Side::Right(item) | Side::Both(item, _) => item,
        }
    }

    /// Returns all items.
    pub fn items(&self) -> impl Iterator<Item = &T> {
        let (one, other) = match self {
            Side::Left(item) | Side::Right(item) => (item, None),
            Side::Both(left, right) => (left, Some(right)),
        };
        std::iter::once(one).chain(other)
    }

    /// Returns both items, if there are two.
    pub fn both(&self) -> Option<(&T, &T)> {
        if let Side::Both(left, right) = self { Some((left, right)) } else { None }
    }
}

/// Returns the union of two sequences that ascend by `order`. An error is passed on as soon as it
/// occurs.
pub fn union<T>(
    left: impl Iterator<Item = Result<T>>,
    right: impl Iterator<Item = Result<T>>,
    order: impl Fn(&T, &T) -> Ordering,
) -> impl Iterator<Item = Result<Side<T>>> {
    let (mut left, mut right) = (left.peekable(), right.peekable());
    std::iter::from_fn(move || {
        let order = match (left.peek(), right.peek()) {
            (None, None) => return None,
            (Some(Err(_)), _) | (Some(Ok(_)), None) => Ordering::Less,
            (_, Some(Err(_))) | (None, Some(Ok(_))) => Ordering::Greater,
            (Some(Ok(a)), Some(Ok(b))) => order(a, b),
        };
        match order {
            Ordering::Less => left.next().map(|item| item.map(Side::Left)),
            Ordering::Greater => right.next().map(|item| item.map(Side::Right)),
            Ordering::Equal => left.next().zip(right.next()).map(|(a, b)| Ok(Side::Both(a?, b?))),
        }
    })
}

/// Conflicts of a merge.
#[derive(Debug, Default)]
pub struct Conflicts(FirstNames<10>);

impl Conflicts {
    pub fn add(&mut self, name: impl FnOnce() -> String) {
        self.0.add(name);
    }

    /// Returns an error that lists the conflicts, if there are any.
    pub fn check(&self, first: &Path, second: &Path) -> Result<()> {
        if self.0.count == 0 {
            return Ok(());
        }
        let count = counted(self.0.count, "conflict");
        let what = format!("cannot be merged with {}: {count}: {}", first.display(), self.0.listed());
        let hint = "see `{command:archive diff}`; build one of the two again, or leave receivers out with `{command:archive extract}`";
        Err(Error::input(second, None, what, hint))
    }
}
