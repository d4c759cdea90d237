//! Values of places before a change. In: answers of the site before, places of both sites. Out:
//! values by the names of places after.

use std::collections::HashMap;

use super::measure::RuleValue;
use super::places::PlaceAnswer;
use super::request::SunlightSite;
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::Use;
use heliotile_core::opened::{ReceiverMatching, ReceiverPlace};
use heliotile_core::text::message;
use heliotile_results::compare::check_memory;
use heliotile_results::receivers::ReceiverSet;
use heliotile_results::resources::Resources;

/// Memory of a value, bytes.
const BYTES_OF_VALUE: u64 = size_of::<Option<RuleValue>>() as u64;

/// Values of places before a change.
#[derive(Default)]
pub struct FormerValues {
    /// Values by the name of the place after: one a date, or one a rule.
    values: HashMap<String, Vec<Option<RuleValue>>>,
}

/// Names after a change for places before: the name of the same receiver, or the same name of a
/// group.
pub enum NamesAfter {
    /// Names of matched receivers after, by their names before.
    Matched(HashMap<String, String>),
    /// Groups, which keep their names.
    Same,
}

impl NamesAfter {
    /// Matches the receivers of both sides. Fails if no receiver exists on both.
    pub fn new(before: &SunlightSite, after: &ReceiverSet, resources: &Resources) -> Result<Self> {
        check_memory(before.receivers.count().saturating_add(after.count()), resources.memory)?;
        let places = |set: &ReceiverSet| -> Result<Vec<ReceiverPlace>> {
            set.receivers().map(|one| Ok((&one?).into())).collect()
        };
        let (had, has) = (places(before.receivers)?, places(after)?);
        let matching = ReceiverMatching::new(&had, &has);
        if matching.pairs.is_empty() {
            let what = format!("has none of the {} receivers of the archive after", has.len());
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
    /// Returns room for the values of `places` places with `items` items each. Fails if they do not
    /// fit into memory.
    pub fn with_room(places: u64, items: u64, resources: &Resources) -> Result<Self> {
        let bytes = places.saturating_mul(items).saturating_mul(BYTES_OF_VALUE);
        let most = resources.memory.share(Use::ReceiverList);
        if bytes > most {
            let what = message!(
                "the memory for the values of {places} places before, in bytes (raise {{memory}}, or give fewer {{dates}})"
            );
            return Err(Error::Limit { what, value: bytes, max: most });
        }
        Ok(FormerValues::default())
    }

    /// Adds the values of the next place before.
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
