//! Sums of taken and given light. In: the light of receivers, one after the other, and names of
//! what they see. Out: shares by receiver or group and by what takes light.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use super::{ShadingSummary, Taker};
use crate::outputs::groups::{GroupGeometry, Groups};
use crate::outputs::shading::Share;
use crate::outputs::tables::layout::By;
use crate::stream::TileStream;
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::Use;
use heliotile_core::opened::SeenObject;
use heliotile_core::replay::by_object::{LightByObject, ObjectLight};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::message;

/// Running sums by group and by taker.
pub struct Sums {
    /// Groups; `None` if each receiver is one by itself.
    groups: Option<Groups>,
    /// Name and geometry of each group.
    places: Vec<(String, GroupGeometry)>,
    /// `[group]`: light under a free sky, `[sun, sky][result]`.
    free: Vec<[Vec<f64>; 2]>,
    /// Numbers of the takers.
    numbers: HashMap<Taker, u32>,
    /// By group and number of the taker.
    rows: BTreeMap<(u32, u32), ObjectLight>,
    results: usize,
    memory_bytes: u64,
    /// Number of receivers that were added.
    done: usize,
}

impl Sums {
    /// Returns zero sums of the receivers of a stream.
    pub fn new(by: By, stream: &TileStream, place: &Path) -> Result<Self> {
        let groups = match by {
            By::Receiver => None,
            by => Some(Groups::new(stream.receivers.receivers(), by, place)?),
        };
        let of_group = |(name, extent): (&String, &GroupGeometry)| (name.clone(), *extent);
        let places: Vec<(String, GroupGeometry)> =
            groups.iter().flat_map(|groups| groups.names().iter().zip(groups.extents())).map(of_group).collect();
        let results = stream.series.labels.len();
        let zero = || std::array::from_fn(|_| vec![0.0; results]);
        Ok(Sums {
            groups,
            free: places.iter().map(|_| zero()).collect(),
            places,
            numbers: HashMap::new(),
            rows: BTreeMap::new(),
            results,
            memory_bytes: stream.resources.memory.share(Use::SurfaceSums),
            done: 0,
        })
    }

    /// Adds the light of the next receiver; `taker` names what it sees.
    pub fn add(
        &mut self,
        receiver: &Receiver,
        light: &LightByObject,
        taker: impl Fn(SeenObject) -> Taker,
    ) -> Result<()> {
        let zero = || vec![0.0; self.results];
        let (group, share) = match &self.groups {
            Some(groups) => (groups.place_of(self.done)?, groups.share_of(self.done)?),
            None => {
                let extent = GroupGeometry { area_m2: receiver.area, ..GroupGeometry::default() };
                self.places.push((receiver.id.clone(), extent));
                self.free.push(std::array::from_fn(|_| zero()));
                (self.done as u32, 1.0)
            }
        };
        self.done += 1;
        add_all(&mut self.free[group as usize], &light.free, share);
        for (seen, light) in &light.objects {
            let next = self.numbers.len() as u32;
            let number = *self.numbers.entry(taker(*seen)).or_insert(next);
            let row = self.rows.entry((group, number)).or_insert_with(|| ObjectLight {
                taken: std::array::from_fn(|_| zero()),
                given: std::array::from_fn(|_| zero()),
            });
            add_all(&mut row.taken, &light.taken, share);
            add_all(&mut row.given, &light.given, share);
        }
        let bytes = (self.rows.len() * (6 * self.results * size_of::<f64>() + size_of::<ObjectLight>())) as u64;
        if bytes > self.memory_bytes {
            return Err(Error::Limit {
                what: message!(
                    "the memory of sums, in bytes, for {} pairs of what takes light and what loses it (raise {{memory}}, choose \
                     fewer {{receivers}}, a longer {{every}} or coarser groups with {{by}})",
                    self.rows.len()
                ),
                value: bytes,
                max: self.memory_bytes,
            });
        }
        Ok(())
    }

    /// Returns the rows, by group and then by the direct light that they take, most first.
    pub fn finished(self) -> (ShadingSummary, Vec<Share>) {
        let mut takers: Vec<(u32, Taker)> = self.numbers.into_iter().map(|(taker, number)| (number, taker)).collect();
        takers.sort_unstable_by_key(|(number, _)| *number);
        let taken = |light: &ObjectLight| light.taken.iter().flatten().sum::<f64>();
        let mut of_taker: BTreeMap<&str, f64> = BTreeMap::new();
        let mut shares: Vec<Share> = Vec::with_capacity(self.rows.len());
        for ((group, number), light) in self.rows {
            let (name, extent) = &self.places[group as usize];
            let taker = &takers[number as usize].1;
            *of_taker.entry(&taker.name).or_default() += taken(&light) * extent.area_m2.unwrap_or(1.0);
            shares.push(Share {
                group: group as usize,
                place: name.clone(),
                area_m2: extent.area_m2,
                taker: taker.name.clone(),
                class: taker.class,
                is_own: taker.is_own,
                free: self.free[group as usize].clone(),
                light,
            });
        }
        let order = |a: &Share, b: &Share| {
            let names = || (&a.taker, a.class, a.is_own).cmp(&(&b.taker, b.class, b.is_own));
            a.group.cmp(&b.group).then(taken(&b.light).total_cmp(&taken(&a.light))).then_with(names)
        };
        shares.sort_by(order);
        let all: f64 = of_taker.values().sum();
        let most = of_taker.iter().max_by(|a, b| a.1.total_cmp(b.1)).filter(|_| all > 0.0);
        let summary = ShadingSummary {
            places: self.places.len() as u64,
            takers: of_taker.len() as u64,
            most: most.map(|(name, sum)| ((*name).to_owned(), 100.0 * sum / all)),
        };
        (summary, shares)
    }
}

fn add_all(sums: &mut [Vec<f64>], values: &[Vec<f64>], share: f64) {
    for (sums, values) in sums.iter_mut().zip(values) {
        sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += share * value);
    }
}
