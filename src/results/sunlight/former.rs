//! What places had before a change. In: answers of the site before, places of both sites. Out: values by the names of places after.

use std::collections::HashMap;

use super::measure::RuleValue;
use super::pass::SunlightSite;
use super::places::PlaceAnswer;
use crate::compare::check_memory;
use crate::receivers::ReceiverSet;
use crate::resources::Resources;
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::Use;
use heliotile_core::opened::{ReceiverMatching, ReceiverPlace};

/// Bytes of a value, and of what names it.
const BYTES_OF_VALUE: u64 = size_of::<Option<RuleValue>>() as u64;

/// Values before.
#[derive(Default)]
pub struct FormerValues {
    /// By the name of the place after: one a date, or one a rule.
    values: HashMap<String, Vec<Option<RuleValue>>>,
}

/// Names after of what was there before: that of the same receiver, or of a group the same name.
pub enum NamesAfter {
    /// Of receivers.
    Matched(HashMap<String, String>),
    /// Of groups.
    Same,
}

impl NamesAfter {
    /// Of receivers that are the same on both sides. An error: none is.
    pub fn of(before: &SunlightSite, after: &ReceiverSet, resources: &Resources) -> Result<Self> {
        check_memory(before.receivers.count().saturating_add(after.count()), resources.memory)?;
        let places = |set: &ReceiverSet| -> Result<Vec<ReceiverPlace>> {
            set.receivers().map(|one| Ok((&one?).into())).collect()
        };
        let (had, has) = (places(before.receivers)?, places(after)?);
        let matching = ReceiverMatching::of(&had, &has);
        if matching.pairs.is_empty() {
            let what = format!("has none of the {} receivers after", has.len());
            let hint = "give an archive of the site before: receivers are matched by place and normal, or by name";
            return Err(Error::input(before.place, None, what, hint));
        }
        let name =
            |of: &[ReceiverPlace], number: usize| of.get(number).map(|place| place.id.clone()).unwrap_or_default();
        let pairs = matching.pairs.iter().map(|pair| (name(&had, pair.before), name(&has, pair.after)));
        Ok(NamesAfter::Matched(pairs.collect()))
    }

    fn of_place(&self, before: &str) -> Option<String> {
        match self {
            NamesAfter::Matched(names) => names.get(before).cloned(),
            NamesAfter::Same => Some(before.to_owned()),
        }
    }
}

impl FormerValues {
    /// Room for the values of so many places with so many items. An error: they do not fit into memory.
    pub fn with_room(places: u64, items: u64, resources: &Resources) -> Result<Self> {
        let bytes = places.saturating_mul(items).saturating_mul(BYTES_OF_VALUE);
        let most = resources.memory.share(Use::ReceiverList);
        if bytes > most {
            let what = format!(
                "bytes for the values of {places} places before (raise {{memory}}, or ask for fewer {{dates}})"
            );
            return Err(Error::Limit { what, value: bytes, max: most });
        }
        Ok(FormerValues::default())
    }

    /// The values of the next place before.
    pub fn add(&mut self, answer: &PlaceAnswer, names: &NamesAfter) {
        if let Some(name) = names.of_place(&answer.name) {
            let values = answer.items.iter().map(|item| item.as_ref().map(|item| item.value));
            self.values.insert(name, values.collect());
        }
    }

    /// Puts the values before into an answer after.
    pub fn join(&self, answer: &mut PlaceAnswer) {
        let Some(values) = self.values.get(&answer.name) else { return };
        for (item, before) in answer.items.iter_mut().zip(values) {
            if let Some(item) = item {
                item.before = *before;
            }
        }
    }
}
