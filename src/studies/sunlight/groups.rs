//! Answers of surfaces, windows and other groups. In: answers of receivers, their groups and shares
//! of the area. Out: an answer for each group, in the order of names.

use std::path::Path;

use glam::DVec3;

use super::measure::RuleValue;
use super::places::{AnswerItem, PlaceAnswer, RowSubject};
use super::rule::LitPart;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::weather::time::calendar::Date;
use heliotile_files::spill::{Sorter, damaged};
use heliotile_results::outputs::groups::Groups;
use heliotile_results::outputs::tables::layout::By;
use heliotile_sunlight::{HotSpot, Spells, Strongest, SunSeen};

/// Answers of receivers, sorted by group.
pub struct GroupAnswers<'a> {
    groups: &'a Groups,
    sorter: Sorter,
    folder: &'a Path,
    /// Number of receivers that were added.
    count: usize,
}

/// Receiver of a group, with its share of the group.
struct GroupPart {
    /// Share of the area of the group.
    share: f64,
    answer: PlaceAnswer,
}

impl<'a> GroupAnswers<'a> {
    /// Returns an empty collection; `folder` holds what does not fit into memory.
    pub fn new(groups: &'a Groups, folder: &'a Path, memory_bytes: usize) -> Self {
        GroupAnswers { groups, sorter: Sorter::new(folder, memory_bytes), folder, count: 0 }
    }

    /// Adds the answer of the next receiver.
    pub fn push(&mut self, answer: &PlaceAnswer) -> Result<()> {
        let (group, share) = (self.groups.place_of(self.count)?, self.groups.share_of(self.count)?);
        self.count += 1;
        let mut bytes = Vec::new();
        put(&mut bytes, share);
        answer.position.to_array().iter().for_each(|value| put(&mut bytes, *value));
        for item in &answer.items {
            put_item(&mut bytes, item.as_ref());
        }
        self.sorter.push(&group.to_be_bytes(), &bytes)
    }

    /// Hands the answers of groups to `take`, in order, until it returns false.
    pub fn each(
        self,
        asked: &RowSubject,
        lit_share: f64,
        mut take: impl FnMut(PlaceAnswer) -> Result<bool>,
    ) -> Result<()> {
        let GroupAnswers { groups, sorter, folder, .. } = self;
        let mut sorted = sorter.finish()?.peekable();
        for (number, name) in (0_u32..).zip(groups.names()) {
            let mut parts = Vec::new();
            let is_here = |record: &Result<(Vec<u8>, Vec<u8>)>| {
                record.as_ref().map_or(true, |(key, _)| **key == number.to_be_bytes())
            };
            while let Some(record) = sorted.next_if(is_here) {
                parts.push(part_of(&record?.1).ok_or_else(|| damaged(folder))?);
            }
            let items = items_of(&parts, asked, lit_share);
            let (name, position) = (name.clone(), middle(&parts));
            if !take(PlaceAnswer { name, position, items, spells: Vec::new() })? {
                break;
            }
        }
        Ok(())
    }
}

/// Returns the middle of a group, by area.
fn middle(parts: &[GroupPart]) -> DVec3 {
    parts.iter().map(|part| part.share * part.answer.position).sum()
}

fn items_of(parts: &[GroupPart], asked: &RowSubject, lit_share: f64) -> Vec<Option<AnswerItem>> {
    let count = parts.first().map_or(0, |part| part.answer.items.len());
    let of_item = |number: usize| {
        let about: Vec<(&GroupPart, &AnswerItem)> =
            parts.iter().filter_map(|part| Some((part, part.answer.items.get(number)?.as_ref()?))).collect();
        if about.is_empty() {
            return None;
        }
        let area: f64 = about.iter().map(|(part, _)| part.share).sum();
        let shares: Vec<f64> = about.iter().map(|(part, _)| part.share / area).collect();
        let values = || shares.iter().copied().zip(about.iter().map(|(_, item)| item.value));
        let covered = |least: f64| {
            let days = about.first().map_or(0, |(_, item)| item.days.len());
            (0..days).map(|day| covered(day, &about, &shares, least)).collect::<Vec<SunSeen>>()
        };
        Some(match asked {
            RowSubject::Dates(_) => {
                let mean = |of: fn(&RuleValue) -> f64| values().map(|(share, value)| share * of(&value)).sum();
                let value =
                    RuleValue { value: mean(|one| one.value), low: mean(|one| one.low), high: mean(|one| one.high) };
                let strongest = about.iter().filter_map(|(_, item)| item.strongest).reduce(Strongest::and);
                let hot_spot = about.iter().filter_map(|(_, item)| item.hot_spot).reduce(HotSpot::higher);
                AnswerItem { days: covered(lit_share), strongest, hot_spot, ..AnswerItem::new(value) }
            }
            RowSubject::Rules(rules) => {
                let planned = rules.get(number)?;
                let value = match planned.rule.part {
                    LitPart::Middle => nearest_to_middle(&about, &shares)?.value,
                    LitPart::AtATime(least) => planned.value(&covered(least)),
                    LitPart::InTurn(least) => {
                        RuleValue::reached_on(least, planned.rule.threshold, &values().collect::<Vec<_>>())
                    }
                };
                AnswerItem::new(value)
            }
        })
    };
    (0..count).map(of_item).collect()
}

/// Returns the spells of a day in which at least the share `least` of a group is lit at the same
/// time.
fn covered(day: usize, about: &[(&GroupPart, &AnswerItem)], shares: &[f64], least: f64) -> SunSeen {
    let of = |set: fn(&SunSeen) -> &Spells| {
        let sets = about.iter().zip(shares).filter_map(|((_, item), share)| Some((set(item.days.get(day)?), *share)));
        Spells::covered(sets, least)
    };
    SunSeen { seen: of(|day| &day.seen), sure: of(|day| &day.sure), possible: of(|day| &day.possible) }
}

/// Returns the item of the receiver nearest to the middle of those with an item; of equally near
/// ones, the first.
fn nearest_to_middle<'p>(about: &[(&GroupPart, &'p AnswerItem)], shares: &[f64]) -> Option<&'p AnswerItem> {
    let middle: DVec3 = about.iter().zip(shares).map(|((part, _), share)| *share * part.answer.position).sum();
    let distance = |part: &GroupPart| part.answer.position.distance_squared(middle);
    about.iter().min_by(|a, b| distance(a.0).total_cmp(&distance(b.0))).map(|(_, item)| *item)
}

fn put(bytes: &mut Vec<u8>, value: f64) {
    bytes.extend(value.to_le_bytes());
}

/// Writes an item: its number of days, its value and the spells of its days. A missing item is
/// written as NaN.
fn put_item(bytes: &mut Vec<u8>, item: Option<&AnswerItem>) {
    let Some(AnswerItem { value, days, strongest, hot_spot, .. }) = item else { return put(bytes, f64::NAN) };
    put(bytes, days.len() as f64);
    let strongest = strongest.map_or([f64::NAN; 2], |one| [one.irradiance_w_m2, one.deflection_deg]);
    let hot_spot =
        hot_spot.map_or([f64::NAN; 3], |one| [one.irradiance_w_m2, one.date.day_number().into(), one.at_min]);
    let values = [value.value, value.low, value.high];
    values.iter().chain(&strongest).chain(&hot_spot).for_each(|value| put(bytes, *value));
    for spells in days.iter().flat_map(|day| [&day.seen, &day.sure, &day.possible]) {
        put(bytes, spells.iter().count() as f64);
        spells.iter().for_each(|spell| [spell.start_min, spell.end_min].iter().for_each(|value| put(bytes, *value)));
    }
}

/// Reads a part from the bytes that were pushed; `None` for bytes that are no such record.
fn part_of(bytes: &[u8]) -> Option<GroupPart> {
    let (values, rest) = bytes.as_chunks::<8>();
    let mut values = values.iter().map(|bytes| f64::from_le_bytes(*bytes));
    let mut next = || values.next();
    let share = next()?;
    let position = DVec3::new(next()?, next()?, next()?);
    let mut items = Vec::new();
    while let Some(days) = next() {
        if days.is_nan() {
            items.push(None);
            continue;
        }
        let value = RuleValue { value: next()?, low: next()?, high: next()? };
        let strongest = Strongest { irradiance_w_m2: next()?, deflection_deg: next()? };
        let strongest = Some(strongest).filter(|one| one.irradiance_w_m2.is_finite());
        let (irradiance_w_m2, date) = (next()?, Date::of_day_number(next()? as i32)?);
        let hot_spot = HotSpot { irradiance_w_m2, date, at_min: next()? };
        let hot_spot = Some(hot_spot).filter(|one| one.irradiance_w_m2.is_finite());
        let mut spells = || {
            let mut spells = Spells::default();
            for _ in 0..next()? as usize {
                spells.push(next()?, next()?);
            }
            Some(spells)
        };
        let mut of_days = Vec::new();
        for _ in 0..days as usize {
            of_days.push(SunSeen { seen: spells()?, sure: spells()?, possible: spells()? });
        }
        items.push(Some(AnswerItem { days: of_days, strongest, hot_spot, ..AnswerItem::new(value) }));
    }
    rest.is_empty().then_some(GroupPart {
        share,
        answer: PlaceAnswer { name: String::new(), position, items, spells: Vec::new() },
    })
}

/// Refuses rules about the middle of a group that has none.
pub fn check_middles(asked: &RowSubject, by: By) -> Result<()> {
    let RowSubject::Rules(rules) = asked else { return Ok(()) };
    if matches!(by, By::Receiver | By::Surface | By::Window) {
        return Ok(());
    }
    match rules.iter().find(|planned| planned.rule.part == LitPart::Middle) {
        None => Ok(()),
        Some(planned) => {
            let what =
                format!("the rule `{}` needs the middle of a surface, which no {} has", planned.rule.name, by.name());
            let hint = "give {by} surface or window, or a rule with lit_share or area_share";
            Err(Error::argument("by, rule", what, hint).because(Problem::excludes("rule")))
        }
    }
}
