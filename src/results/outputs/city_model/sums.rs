//! Sums of objects and faces of a city model. In: receivers with their sums, kWh/m2. Out: means by
//! area of each object, with all its parts, and of each face, as attributes. Memory holds numbers
//! of each object and face, not of receivers.

use std::collections::HashMap;

use heliotile_core::replay::components::{Component, ComponentList, SUM_SUFFIX};
use heliotile_core::replay::values::TileValues;
use heliotile_core::site::receiver::Receiver;

/// Prefix of all attributes that are added.
pub(super) const PREFIX: &str = "heliotile_";

/// Running means of the receivers of an object or face.
#[derive(Clone, Debug, Default)]
pub(super) struct Means {
    receivers: u64,
    with_area: u64,
    area_m2: f64,
    /// Sums by quantity, `[quantity]`, of values times areas; `plain` are sums of values.
    weighted: Vec<f64>,
    plain: Vec<f64>,
}

impl Means {
    fn add(&mut self, area_m2: Option<f64>, values: &[f64]) {
        self.receivers += 1;
        self.with_area += u64::from(area_m2.is_some());
        let area = area_m2.unwrap_or_default();
        self.area_m2 += area;
        self.weighted.resize(values.len(), 0.0);
        self.plain.resize(values.len(), 0.0);
        for ((weighted, plain), value) in self.weighted.iter_mut().zip(&mut self.plain).zip(values) {
            *weighted += area * value;
            *plain += value;
        }
    }

    /// Adds the sums of another mean.
    pub fn join(&mut self, other: &Means) {
        self.receivers += other.receivers;
        self.with_area += other.with_area;
        self.area_m2 += other.area_m2;
        for (own, others) in [(&mut self.weighted, &other.weighted), (&mut self.plain, &other.plain)] {
            own.resize(others.len(), 0.0);
            own.iter_mut().zip(others).for_each(|(own, other)| *own += other);
        }
    }

    /// Returns the area of all receivers; `None` if one has none.
    fn area_m2(&self) -> Option<f64> {
        (self.with_area == self.receivers && self.area_m2 > 0.0).then_some(self.area_m2)
    }

    /// Returns the mean by area, or a plain mean if a receiver has no area.
    pub fn mean(&self, quantity: usize) -> f64 {
        match self.area_m2() {
            Some(area_m2) => self.weighted.get(quantity).copied().unwrap_or_default() / area_m2,
            None => self.plain.get(quantity).copied().unwrap_or_default() / self.receivers.max(1) as f64,
        }
    }
}

/// City object, and its faces by the names that receivers have for them.
#[derive(Clone, Debug, Default)]
pub(super) struct ObjectSums {
    /// Means of the object with all its parts.
    pub all: Means,
    pub faces: HashMap<String, Means>,
}

/// Sums of all objects and faces.
#[derive(Clone, Debug)]
pub struct ModelSums {
    /// Requested components; the total follows them if it was not requested.
    components: Vec<Component>,
    /// Keys of the requested components.
    names: Vec<String>,
    /// Endings of the keys of single periods; empty if there is one period only.
    periods: Vec<String>,
    objects: HashMap<String, ObjectSums>,
    /// Number of receivers without an object.
    homeless: u64,
    /// Quantities of one receiver.
    values: Vec<f64>,
}

impl ModelSums {
    /// Returns zero sums. `labels` are the periods of which totals are written as well; they must
    /// be all periods of the values, or none.
    pub fn new(asked: &ComponentList, labels: &[String]) -> Self {
        let name = |component: &Component| {
            format!("{PREFIX}{}{}", asked.name_of(*component), component.measure().sum_suffix())
        };
        let names = asked.as_slice().iter().map(name).collect();
        let mut components = asked.as_slice().to_vec();
        if !components.contains(&Component::Total) {
            components.push(Component::Total);
        }
        let plain = |label: &String| label.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        let has_total = asked.as_slice().len() == components.len();
        let periods = if has_total { labels.iter().map(plain).collect() } else { Vec::new() };
        let (objects, values) = (HashMap::new(), Vec::new());
        ModelSums { components, names, periods, objects, homeless: 0, values }
    }

    /// Returns the components that must be computed.
    pub fn components(&self) -> &[Component] {
        &self.components
    }

    /// Adds the receiver in row `row` of a tile's values.
    pub fn add(&mut self, receiver: &Receiver, values: &TileValues, row: usize) {
        let part = &receiver.part;
        if part.object.is_empty() {
            self.homeless += 1;
            return;
        }
        self.values.clear();
        let whole =
            |component: &Component| values.row(*component, row).iter().map(|value| f64::from(*value)).sum::<f64>();
        self.values.extend(self.components.iter().map(whole));
        if !self.periods.is_empty() {
            self.values.extend(values.row(Component::Total, row).iter().map(|value| f64::from(*value)));
        }
        let object = entry(&mut self.objects, &part.object);
        object.all.add(receiver.area, &self.values);
        entry(&mut object.faces, &part.face).add(receiver.area, &self.values);
        if !part.building.is_empty() && part.building != part.object {
            entry(&mut self.objects, &part.building).all.add(receiver.area, &self.values);
        }
    }

    /// Returns the number of receivers on no object.
    pub fn homeless(&self) -> u64 {
        self.homeless
    }

    /// Returns the number of objects with receivers, on themselves or on their parts.
    pub fn object_count(&self) -> usize {
        self.objects.len()
    }

    /// Returns the number of faces with receivers.
    pub fn face_count(&self) -> usize {
        self.objects.values().map(|object| object.faces.len()).sum()
    }

    /// Returns the first object by name.
    pub fn example(&self) -> Option<&str> {
        self.objects.keys().map(String::as_str).min()
    }

    pub(super) fn object(&self, id: &str) -> Option<&ObjectSums> {
        self.objects.get(id)
    }

    /// Returns the total of all periods, kWh/m2.
    pub(super) fn total(&self, means: &Means) -> f64 {
        let place = self.components.iter().position(|component| *component == Component::Total);
        means.mean(place.unwrap_or_default())
    }

    /// Returns the total of the brightest face, kWh/m2.
    pub(super) fn largest(&self) -> f64 {
        let faces = self.objects.values().flat_map(|object| object.faces.values());
        faces.map(|face| self.total(face)).fold(0.0, f64::max)
    }

    /// Returns the keys and numbers of attributes, each as JSON text.
    pub(super) fn attributes(&self, means: &Means) -> Vec<(String, String)> {
        let number = |value: f64| format!("{value:.3}");
        let asked = self.names.iter().enumerate();
        let mut all: Vec<(String, String)> = asked.map(|(i, name)| (name.clone(), number(means.mean(i)))).collect();
        let total = format!("{PREFIX}{}{SUM_SUFFIX}", Component::Total.name());
        for (i, period) in self.periods.iter().enumerate() {
            all.push((format!("{total}_{period}"), number(means.mean(self.components.len() + i))));
        }
        if let Some(area_m2) = means.area_m2() {
            all.push((format!("{PREFIX}area_m2"), number(area_m2)));
            all.push((format!("{PREFIX}total_kwh"), number(area_m2 * self.total(means))));
        }
        all
    }
}

/// Returns the entry of a key, which is copied only if it is new.
fn entry<'m, T: Default>(map: &'m mut HashMap<String, T>, key: &str) -> &'m mut T {
    if !map.contains_key(key) {
        map.insert(key.to_owned(), T::default());
    }
    map.entry(key.to_owned()).or_default()
}
