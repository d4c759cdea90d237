//! Audit: results of an archive beside those of the reference path tracer. In: an archive, its
//! scene, conditions. Out: pairs of random receivers and random conditions, and errors of the sun
//! alone under many more conditions.

use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::comparison::{Pair, SunErrors};
use super::estimate::{PARTS, ReferenceLight};
use super::hours::HourSample;
use super::random::{Random, spread};
use super::sky::ReferenceSky;
use super::tracer::PathTracer;
use crate::pipeline::PreparedScene;
use crate::settings::Effects;
use heliotile_core::archive::{Archive, format};
use heliotile_core::error::{Error, Result};
use heliotile_core::hemisphere::mix;
use heliotile_core::light::scratch::ScratchSpace;
use heliotile_core::memory::MemoryBudget;
use heliotile_core::observer::{Observer, Stage};
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::Component;
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::conditions::{Condition, in_axes};

/// Number of receivers that are evaluated between two looks at the clock.
const AT_ONCE: usize = 64;

/// Smallest number of receivers times conditions for errors of the sun; [`SUN_CONDITIONS`] is the
/// smallest number of conditions of each receiver. Fewer receivers get more conditions, because few
/// conditions have a shadow's edge at any of few receivers.
const SUN_PAIRS: usize = 32_768;
const SUN_CONDITIONS: usize = 256;

/// Inputs and limits of an audit.
pub struct AuditInputs<'a> {
    /// Archive to audit.
    pub archive: &'a Archive,
    /// Scene that the archive was built from.
    pub scene: &'a PreparedScene<'a>,
    /// Suns and skies to choose from, with suns by true north.
    pub conditions: &'a [Condition],
    /// Distribution of the sky's radiance.
    pub sky: SkyModel,
    /// Largest number of conditions for each receiver.
    pub hours: usize,
    /// Largest number of receivers.
    pub samples: usize,
    /// Time limit; receivers under way are finished.
    pub time: Option<Duration>,
    /// Number of paths of a receiver.
    pub paths: usize,
    /// Seed. Another one chooses other receivers, hours and paths.
    pub seed: u64,
    /// Memory budget for replay.
    pub memory: MemoryBudget,
    /// Temporary storage for replay.
    pub storage: &'a dyn ScratchSpace,
    /// Gets progress, and can stop the audit.
    pub observer: &'a dyn Observer,
}

/// Results of an audit.
pub struct Audited {
    /// Receivers of the audit, with their sky views.
    pub receivers: Vec<(Receiver, f64)>,
    /// Pairs, in the order of the receivers.
    pub pairs: Vec<Pair>,
    /// Errors of the sun, for each receiver under far more conditions than there are pairs.
    pub suns: Vec<SunErrors>,
    /// Pairs of the same receivers in hours when the sun lights what they see.
    pub hours: HourSample,
}

/// Compares results of an archive with the reference path tracer. Fails for blocks that cannot be
/// read and for a sky model that the path tracer does not support.
pub fn audit(request: &AuditInputs) -> Result<Audited> {
    let started = Instant::now();
    let site = OpenSite::open(request.archive)?;
    let all: Vec<(u32, usize)> = request
        .archive
        .entries_of(format::RECEIVERS)
        .iter()
        .flat_map(|entry| (0..entry.items as usize).map(move |row| (entry.tile.0, row)))
        .collect();
    let turned = in_axes(request.conditions, site.north());
    let skies: Vec<ReferenceSky> =
        turned.iter().map(|condition| ReferenceSky::new(condition, request.sky)).collect::<Result<_>>()?;
    let settings = ReplaySettings {
        sky: request.sky,
        patches: request.archive.manifest().settings.patches as usize,
        memory: request.memory,
        storage: request.storage,
        ..ReplaySettings::default()
    };
    let replay = Replay::new(&site, request.conditions, settings)?;
    let tracer = PathTracer::new(request.scene, Effects::of_names(&request.archive.manifest().settings.left_out));
    let progress = Stage::begin(request.observer, "audit", Some(request.samples.min(all.len()) as u64));
    let mut audited =
        Audited { receivers: Vec::new(), pairs: Vec::new(), suns: Vec::new(), hours: HourSample::default() };
    let mut chosen = spread(all.len(), request.samples, request.seed);
    // Random order, so that the receivers are spread over the site whenever the time is up.
    shuffle(&mut chosen, request.seed);
    // Not fewer than pairs, or these would tell more of the sun.
    let sun_conditions = (SUN_PAIRS / chosen.len().max(1)).max(SUN_CONDITIONS).max(request.hours);
    for some in chosen.chunks(AT_ONCE) {
        if request.observer.cancelled() {
            return Err(Error::Stopped { what: format!("after {} receivers", audited.receivers.len()) });
        }
        if request.time.is_some_and(|time| started.elapsed() > time) {
            break;
        }
        let mut some: Vec<(u32, usize)> = some.iter().map(|&i| all[i]).collect();
        some.sort_unstable();
        let first = audited.receivers.len();
        // `[receiver of this batch][condition]`: the six components and the total.
        let mut results: Vec<Vec<[f32; PARTS]>> = Vec::new();
        site.expect(&[format::RECEIVERS, format::PARTS], some.iter().map(|of| of.0));
        for of_tile in some.chunk_by(|a, b| a.0 == b.0) {
            let tile = of_tile[0].0;
            let table = site.tile_receivers(tile)?;
            let (receivers, views) = (site.tile_parts(tile, &table)?, table.views().collect::<Vec<_>>());
            let values = replay.run([tile])?.remove(0).1;
            for &(_, row) in of_tile {
                let receiver = audited.receivers.len();
                audited.receivers.push((receivers[row].clone(), f64::from(views[row][0])));
                let of = |condition| std::array::from_fn(|part| values.row(Component::ALL[part], row)[condition]);
                results.push((0..skies.len()).map(of).collect());
                for condition in spread(skies.len(), request.hours, mix(request.seed, receiver as u64)) {
                    let result = results[receiver - first][condition].map(f64::from);
                    audited.pairs.push(Pair { receiver, condition, result, reference: Default::default() });
                }
            }
        }
        let all = first..audited.receivers.len();
        let result = |receiver: usize, condition: usize| results[receiver - first][condition].map(f64::from);
        audited.hours.choose(all, skies.len(), result, mix(request.seed, first as u64));
        let sun = |receiver: usize| {
            let (of, seed) = (&audited.receivers[receiver].0, mix(mix(request.seed, 0x73_756e), receiver as u64));
            let under = spread(skies.len(), sun_conditions, seed);
            // Some conditions at a time, because chains of mirrors take memory.
            let reference = under.chunks(SUN_CONDITIONS).flat_map(|some| {
                let skies: Vec<&ReferenceSky> = some.iter().map(|&condition| &skies[condition]).collect();
                tracer.sun(of.position, of.normal, &skies, request.paths, seed)
            });
            let results = under.iter().map(|&condition| results[receiver - first][condition].map(f64::from));
            SunErrors::new(receiver, results.zip(reference))
        };
        let suns: Vec<SunErrors> = (first..audited.receivers.len()).into_par_iter().map(sun).collect();
        audited.suns.extend(suns);
        let (receivers, hours) = (&audited.receivers, &mut audited.hours.pairs);
        for (pairs, name, progress) in
            [(&mut audited.pairs, 0x0061_7564_6974, Some(&progress)), (hours, 0x686f_7572, None)]
        {
            let start = pairs.partition_point(|pair| pair.receiver < first);
            let of_receiver = |number: usize, under: &[&ReferenceSky]| {
                let (receiver, seed) = (&receivers[number].0, mix(mix(request.seed, name), number as u64));
                progress.inspect(|progress| progress.advance(1));
                tracer.irradiance(receiver.position, receiver.normal, under, request.paths, seed)
            };
            reference_pairs(&mut pairs[start..], &skies, of_receiver);
        }
    }
    Ok(audited)
}

/// Evaluates pairs, which are in the order of their receivers, all conditions of a receiver at
/// once.
pub fn reference_pairs(
    pairs: &mut [Pair],
    skies: &[ReferenceSky],
    irradiance: impl Fn(usize, &[&ReferenceSky]) -> Vec<ReferenceLight> + Sync,
) {
    let mut of_receivers: Vec<&mut [Pair]> = pairs.chunk_by_mut(|a, b| a.receiver == b.receiver).collect();
    of_receivers.par_iter_mut().for_each(|pairs| {
        let Some(number) = pairs.first().map(|pair| pair.receiver) else { return };
        let under: Vec<&ReferenceSky> = pairs.iter().map(|pair| &skies[pair.condition]).collect();
        let found = irradiance(number, &under);
        pairs.iter_mut().zip(found).for_each(|(pair, reference)| pair.reference = reference);
    });
}

/// Shuffles numbers (Fisher and Yates 1938, as by Durstenfeld 1964).
fn shuffle(numbers: &mut [usize], seed: u64) {
    let mut random = Random::new(mix(seed, 1));
    for i in (1..numbers.len()).rev() {
        numbers.swap(i, ((random.next() * (i + 1) as f64) as usize).min(i));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 10 of 1,000 numbers are one of each hundred, 5 of 5 are each once, and shuffling keeps them:
    /// 15 of 15.
    #[test]
    fn chosen_are_spread() {
        let mut some = spread(1000, 10, 3);
        assert!(some.iter().enumerate().all(|(i, number)| number / 100 == i), "{some:?}");
        assert_eq!(spread(5, 10, 3), [0, 1, 2, 3, 4]);
        let before = some.clone();
        shuffle(&mut some, 3);
        assert_ne!(some, before);
        some.sort_unstable();
        assert_eq!(some, before);
    }
}
