//! Replays over weather that are kept to give tile after tile. In: a query. Out: irradiances of a
//! tile. The last few queries are kept, since a page asks for many tiles of each.

use heliotile_core::error::Result;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::replay::values::TileValues;

use crate::Answered;
use crate::answer::{Answer, Numbers};
use crate::asked::{Changes, Span, SumAsk, columns, sky_of};
use crate::failure::{Failure, Kind};
use crate::light::Forced;
use crate::open::Opened;

/// Number of queries that are kept.
const KEPT: usize = 4;

/// Purpose of a replay.
#[derive(Clone, Debug, PartialEq)]
pub enum Key {
    Sums(SumAsk),
    Months {
        sky: String,
        changes: Changes,
    },
    Day {
        day_of_year: u32,
        sky: String,
        changes: Changes,
    },
    /// Light on people in all hours of a span.
    Hours {
        span: Span,
        sky: String,
        changes: Changes,
    },
}

impl Key {
    fn sky(&self) -> &str {
        match self {
            Key::Sums(SumAsk { sky, .. }) => sky,
            Key::Months { sky, .. } | Key::Day { sky, .. } | Key::Hours { sky, .. } => sky,
        }
    }

    /// Returns the columns of the query; all columns for a single receiver.
    pub fn columns(&self) -> Result<Vec<Component>> {
        match self {
            Key::Sums(SumAsk { components, .. }) => columns(components),
            Key::Months { .. } | Key::Day { .. } => Ok(Component::ALL.to_vec()),
            Key::Hours { .. } => Ok(vec![Component::SunDirect, Component::Total]),
        }
    }
}

/// Last replays, the newest first.
#[derive(Default)]
pub struct Recombinations {
    kept: Vec<(Key, Replay<'static>)>,
}

impl Recombinations {
    /// Forgets the replays, since the weather or the clouds changed.
    pub fn clear(&mut self) {
        self.kept.clear();
    }

    /// Returns the values of a tile for a query. `force` makes the light if no kept replay answers
    /// the query.
    pub fn values(
        &mut self,
        opened: &Opened,
        key: &Key,
        tile: u32,
        force: impl FnOnce() -> Result<Forced>,
    ) -> std::result::Result<TileValues, Failure> {
        let tile = opened.tile(tile)?;
        match self.kept.iter().position(|(other, _)| other == key) {
            Some(place) => self.kept.swap(0, place),
            None => {
                let settings = ReplaySettings {
                    sky: sky_of(key.sky())?,
                    patches: opened.archive.manifest().settings.patches(),
                    components: ComponentSet::new(&key.columns()?),
                    ..ReplaySettings::default()
                };
                let Forced { conditions, bins, schedules } = force()?;
                let replay =
                    Replay::builder(&opened.site, &conditions, settings).summed(&bins).scheduled(&schedules).build()?;
                self.kept.insert(0, (key.clone(), replay));
                self.kept.truncate(KEPT);
            }
        }
        let none = || Failure::new(Kind::Other, "nothing was recombined", "");
        let (_, replay) = self.kept.first().ok_or_else(none)?;
        let (_, values) = replay.run([tile])?.pop().ok_or_else(none)?;
        Ok(values)
    }
}

/// Answers columns of a tile from the values of a replay.
pub fn of_tile(opened: &Opened, tile: u32, columns: &[Component], values: &TileValues) -> Answered {
    let first = opened.first(tile);
    let answer = Answer::of(serde_json::json!({ "tile": tile, "first": first }));
    let with = |answer: Answer, column: &Component| answer.with(column.name(), Numbers::F32(values.component(*column)));
    Ok(columns.iter().fold(answer, with))
}

/// Answers all columns of one receiver.
pub fn of_receiver(labels: &[String], row: usize, values: &TileValues) -> Answered {
    if row >= values.receivers() {
        let what = format!("there is no receiver {row} of {} in the tile", values.receivers());
        return Err(Failure::new(Kind::Other, what, ""));
    }
    let answer = Answer::of(serde_json::json!({ "labels": labels }));
    let with = |answer: Answer, column: Component| answer.with(column.name(), Numbers::F32(values.row(column, row)));
    Ok(Component::ALL.into_iter().fold(answer, with))
}
