//! Search for the best orientation of every point. In: places, a scene. Out: sums over the year of
//! fans of orientations, with all reflections, first coarse over the allowed range, then fine
//! around the best. Receivers of one place share what they see. The peak is that of a fit.

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use super::aside::trace_aside;
use super::light::Light;
use super::open_plain::plain;
use super::request::PvRequest;
use super::spots::{Spot, Spots};
use heliotile_builder::pipeline::PreparedScene;
use heliotile_builder::settings::BuildSettings;
use heliotile_core::error::Result;
use heliotile_core::orientation::best::{OrientationSurface, OrientationValue};
use heliotile_core::orientation::fan::{Orientation, OrientationLimits, Ring, around};
use heliotile_core::site::north::North;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::message;
use heliotile_results::outputs::pv::search::PointSearch;

/// Step between orientations of the first fan, degrees.
const COARSE_DEG: f64 = 10.0;
/// Radius of the second fan in degrees; `FINE_CIRCLES` is the number of its circles.
const FINE_DEG: f64 = 14.0;
const FINE_CIRCLES: usize = 4;
/// Largest loss of a peak of the first fan against the best one, percent, for which a second fan is
/// traced as well.
const NEAR_PERCENT: f64 = 1.0;
/// Largest number of such peaks.
const MAX_PEAKS: usize = 3;

/// Orientations to trace at a place.
struct OrientationTrial {
    place: DVec3,
    turns: Vec<Orientation>,
}

/// Searches the best orientations of all spots.
pub fn run(request: &PvRequest, light: &Light, prepared: &PreparedScene, spots: &Spots) -> Result<Vec<PointSearch>> {
    let (limits, settings) = (request.limits(), request.accuracy.settings()?);
    let within = |turn: &Orientation| limits.allow(*turn);
    let tried = Fans { settings: &settings, folder: &request.folder, light };
    let mut searched = tried.search(prepared, &spots.list, &limits)?;
    // The search is repeated on open plains, one a ground.
    let mut grounds: Vec<Option<u16>> = spots.list.iter().map(|spot| spot.ground).collect();
    grounds.sort_unstable();
    grounds.dedup();
    for ground in grounds {
        let scene = plain(prepared.scene, ground)?;
        let open = PreparedScene::new(&scene)?;
        let spot = Spot::at("open plain", DVec3::Z, ground);
        let Some(best) = tried.search(&open, &[spot], &limits)?.pop() else { continue };
        let same = searched.iter_mut().zip(&spots.list).filter(|(_, spot)| spot.ground == ground);
        same.for_each(|(search, _)| search.open_best = best.best);
    }
    for (search, spot) in searched.iter().zip(&spots.list) {
        if spot.given.is_some_and(|given| !within(&given)) {
            let what = message!("point `{}` has an orientation outside of {{tilts}} or {{azimuths}}", search.point);
            light.observer().warn(&what);
        }
    }
    Ok(searched)
}

/// Settings and resources for tracing fans.
struct Fans<'a, 'l> {
    settings: &'a BuildSettings,
    folder: &'a Path,
    light: &'a Light<'l>,
}

impl Fans<'_, '_> {
    fn search(&self, prepared: &PreparedScene, spots: &[Spot], limits: &OrientationLimits) -> Result<Vec<PointSearch>> {
        let rings = limits.rings(COARSE_DEG);
        let turns: Vec<Orientation> = rings.iter().flat_map(Ring::turns).collect();
        let asked: Vec<OrientationTrial> =
            spots.iter().map(|spot| OrientationTrial { place: spot.position, turns: turns.clone() }).collect();
        let coarse = self.totals(prepared, &asked)?;
        let peaks: Vec<Vec<Orientation>> = coarse.iter().map(|found| peaks_of(found)).collect();
        let asked: Vec<OrientationTrial> = spots
            .iter()
            .zip(&peaks)
            .map(|(spot, peaks)| {
                let fans = peaks.iter().flat_map(|peak| around(*peak, FINE_DEG, FINE_CIRCLES));
                OrientationTrial {
                    place: spot.position,
                    turns: [Orientation::FLAT].into_iter().chain(spot.given).chain(fans).collect(),
                }
            })
            .collect();
        let fine = self.totals(prepared, &asked)?;
        let all = spots.iter().zip(&coarse).zip(peaks.iter().zip(&fine));
        Ok(all.map(|((spot, coarse), (peaks, fine))| joined(spot, &rings, limits, coarse, peaks, fine)).collect())
    }

    /// Returns the totals of all orientations at all places, in their order.
    fn totals(&self, prepared: &PreparedScene, asked: &[OrientationTrial]) -> Result<Vec<Vec<OrientationValue>>> {
        let north = North::new(prepared.scene.place.as_ref());
        let id = |place: usize, turn: usize| format!("{place}/{turn}");
        let receivers: Vec<Receiver> = asked
            .iter()
            .enumerate()
            .flat_map(|(place, asked)| {
                let receiver = move |(i, turn): (usize, &Orientation)| {
                    Receiver::new(id(place, i), asked.place, north.to_axes(turn.normal()))
                };
                asked.turns.iter().enumerate().map(receiver)
            })
            .collect();
        let traced = trace_aside(prepared, &receivers, self.settings, self.folder, self.light.observer())?;
        let totals: HashMap<String, f64> = self.light.totals(traced.archive())?;
        let found = |(place, asked): (usize, &OrientationTrial)| {
            let value = |i: usize| totals.get(&id(place, i)).copied().unwrap_or_default();
            asked.turns.iter().enumerate().map(|(i, turn)| OrientationValue { turn: *turn, value: value(i) }).collect()
        };
        Ok(asked.iter().enumerate().map(found).collect())
    }
}

/// Returns the result of both fans of a place. `fine` is flat, the given orientation if there is
/// one, and a fan around each peak of the coarse one.
fn joined(
    spot: &Spot,
    rings: &[Ring],
    limits: &OrientationLimits,
    coarse: &[OrientationValue],
    peaks: &[Orientation],
    fine: &[OrientationValue],
) -> PointSearch {
    let flat = fine.first().copied().unwrap_or(OrientationValue { turn: Orientation::FLAT, value: 0.0 });
    let given = spot.given.and_then(|_| fine.get(1).copied());
    let fans = fine.get(1 + usize::from(given.is_some())..).unwrap_or_default();
    let size = fans.len() / peaks.len().max(1);
    let allowed = |found: &&OrientationValue| limits.allow(found.turn);
    let fitted = peaks.iter().zip(fans.chunks(size.max(1))).filter_map(|(peak, fan)| {
        // Orientations of the first fan near the peak count in the fit, too.
        let near = |found: &&OrientationValue| {
            let off = found.turn.normal().angle_between(peak.normal()).to_degrees();
            (1e-6..FINE_DEG).contains(&off)
        };
        let found: Vec<OrientationValue> = fan.iter().chain(coarse.iter().filter(near)).copied().collect();
        let surface = OrientationSurface::fit(*peak, FINE_DEG, &found)?;
        Some((surface.best(limits)?, surface.scatter()))
    });
    let measured = coarse.iter().chain(fans.iter().filter(allowed)).copied();
    let best_fit = fitted.max_by(|a, b| a.0.value.total_cmp(&b.0.value));
    let best_measured = || measured.max_by(|a, b| a.value.total_cmp(&b.value));
    let (best, scatter) = best_fit.unwrap_or_else(|| (best_measured().unwrap_or(flat), 0.0));
    let mut values = coarse.iter().map(|found| found.value);
    let of_ring = |ring: &Ring| (ring.clone(), values.by_ref().take(ring.azimuths_deg.len()).collect());
    PointSearch {
        point: spot.name.clone(),
        rings: rings.iter().map(of_ring).collect(),
        fine: fans.iter().filter(allowed).copied().collect(),
        best,
        scatter_percent: 100.0 * scatter / best.value.max(f64::MIN_POSITIVE),
        flat,
        given,
        open_best: best,
    }
}

/// Returns the best orientations of a fan that are better than those around them.
fn peaks_of(found: &[OrientationValue]) -> Vec<Orientation> {
    let mut sorted: Vec<&OrientationValue> = found.iter().collect();
    sorted.sort_by(|a, b| b.value.total_cmp(&a.value));
    let Some(most) = sorted.first().map(|best| best.value) else { return Vec::new() };
    let mut peaks: Vec<Orientation> = Vec::new();
    for one in sorted.iter().take_while(|one| one.value >= most * (1.0 - NEAR_PERCENT / 100.0)) {
        let off = |turn: &Orientation| turn.normal().angle_between(one.turn.normal()).to_degrees();
        let is_top = found.iter().all(|other| off(&other.turn) > 1.6 * COARSE_DEG || other.value <= one.value);
        if is_top && peaks.iter().all(|peak| off(peak) > FINE_DEG) && peaks.len() < MAX_PEAKS {
            peaks.push(one.turn);
        }
    }
    peaks
}
