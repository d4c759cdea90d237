//! Light on trackers. In: archives of the modules at some angles, one of their middles without
//! them, weather. Out: hours of each side at the angles of each hour.
//!
//! All light but the beam changes smoothly with the angle: it is interpolated between the traced
//! angles. The beam does not, because backtracking keeps modules at the edge of their neighbours'
//! shade: its shade among modules is computed at the angle of each sun, by [`RowShade`]; the share
//! that reaches the middle of a module through the surroundings is replayed.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use super::aside::trace_aside;
use super::energy::mean_cover;
use super::light::Light;
use super::modules::LaidRows;
use super::open_plain::OpenPlain;
use super::spots::{Spot, Spots};
use heliotile_archives::transfer::ArchiveReceivers;
use heliotile_builder::pipeline::PreparedScene;
use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Result};
use heliotile_core::opened::OpenSite;
use heliotile_core::orientation::fan::Orientation;
use heliotile_core::site::north::North;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::message;
use heliotile_core::weather::conditions::{Condition, Instant};
use heliotile_results::Every;
use heliotile_results::outputs::pv::hourly::SideHours;
use heliotile_results::outputs::pv::sums::MonthlySums;
use heliotile_scene::Scene;
use heliotile_scene::pv::row_shade::RowShade;
use heliotile_scene::pv::tracker::Tracker;

/// Largest memory of the hours of all modules, bytes.
const MAX_BYTES: u64 = 2 << 30;

/// Sides of a module: the front and the rear, with the sign of their normals.
const SIDES: [f64; 2] = [1.0, -1.0];

/// Angles of trackers over the hours of a weather file.
pub struct Tracking {
    tracker: Tracker,
    shade: RowShade,
    /// Suns and skies of the hours.
    conditions: Arc<Vec<Condition>>,
    /// `[hour][instant]`: angles at the positions of the sun, degrees.
    of_suns: Vec<Vec<f64>>,
    /// `[traced angle][hour]`: weights of light at the traced angles; those of an hour add up to 1.
    weights: Vec<Vec<f32>>,
}

impl Tracking {
    /// Returns the angles of level modules over the hours of a replay.
    pub fn new(laid: &LaidRows, tracker: Tracker, conditions: Arc<Vec<Condition>>) -> Self {
        let cover = laid.modules().next().map_or(1.0, |(_, rows)| rows.cover());
        let north = laid.fields().first().map_or(North::default(), |field| field.north);
        let shade = RowShade::new(tracker, north, laid.modules().map(|(module, _)| module));
        let angle = |instant: &Instant| tracker.angle_deg(instant.sun, cover);
        let of_suns: Vec<Vec<f64>> =
            conditions.iter().map(|condition| condition.suns.iter().map(angle).collect()).collect();
        let traced = tracker.angles_deg();
        let mut weights = vec![vec![0.0; of_suns.len()]; traced.len()];
        for (hour, (condition, angles)) in conditions.iter().zip(&of_suns).enumerate() {
            // Trackers lie level in the dark.
            let level = [(0.0, 1.0)];
            let suns = angles.iter().copied().zip(condition.suns.iter().map(|instant| instant.weight));
            let all: Vec<(f64, f64)> = if angles.is_empty() { level.to_vec() } else { suns.collect() };
            for (angle_deg, weight) in all {
                let upper = traced.partition_point(|traced| *traced < angle_deg).clamp(1, traced.len() - 1);
                let (low, high) = (traced[upper - 1], traced[upper]);
                let share = ((angle_deg - low) / (high - low)).clamp(0.0, 1.0);
                weights[upper - 1][hour] += (weight * (1.0 - share)) as f32;
                weights[upper][hour] += (weight * share) as f32;
            }
        }
        Tracking { tracker, shade, conditions, of_suns, weights }
    }

    /// Returns the mean angle of each hour while the sun is up, degrees; 0 in the dark.
    pub fn angles_deg(&self) -> Vec<f32> {
        let mean = |(condition, angles): (&Condition, &Vec<f64>)| {
            // An empty sum is -0.
            condition.suns.iter().zip(angles).fold(0.0, |sum, (instant, angle)| sum + instant.weight * angle) as f32
        };
        self.conditions.iter().zip(&self.of_suns).map(mean).collect()
    }

    /// Returns the transmittance of the cover of a side for the sun of each hour.
    pub fn covers(&self, side: usize) -> Vec<f64> {
        let normal = |angle_deg: &f64| SIDES[side] * self.shade.normal(*angle_deg);
        let hours = self.conditions.iter().zip(&self.of_suns);
        hours.map(|(condition, angles)| mean_cover(condition, angles.iter().map(normal))).collect()
    }

    /// Returns the beam on both sides of a module in each hour, W/m2, at the share of it that the
    /// surroundings let pass; without a module that of a single one on an open plain.
    fn beams(&self, spot: Option<usize>, passed: impl Fn(usize) -> f64) -> [Vec<f32>; 2] {
        let mut beams = [vec![0.0; self.of_suns.len()], vec![0.0; self.of_suns.len()]];
        for (hour, (condition, angles)) in self.conditions.iter().zip(&self.of_suns).enumerate() {
            let beam = condition.dni_w_m2 * passed(hour);
            if beam <= 0.0 {
                continue;
            }
            for (instant, angle_deg) in condition.suns.iter().zip(angles) {
                let cos = self.shade.normal(*angle_deg).dot(instant.sun);
                let lit = spot.map_or(1.0, |spot| self.shade.lit(spot, *angle_deg, instant.sun));
                let side = usize::from(cos < 0.0);
                beams[side][hour] += (beam * instant.lit() * cos.abs() * lit) as f32;
            }
        }
        beams
    }

    /// Adds the light of a side at a traced angle to that of all angles.
    fn mix(&self, sum: &mut SideHours, traced: usize, hours: &SideHours, share: f32) {
        sum.add(hours, self.weights[traced].iter().map(|weight| share * weight));
    }
}

/// Refuses more modules than the memory for their hours holds.
pub fn check_size(modules: usize, hours: usize) -> Result<()> {
    // Six parts of the light on two sides, 4 bytes each.
    let bytes = modules as u64 * hours as u64 * 2 * 6 * 4;
    if bytes > MAX_BYTES {
        let what = message!("the memory of the hours of {modules} trackers, bytes");
        return Err(Error::Limit { what, value: bytes, max: MAX_BYTES });
    }
    Ok(())
}

/// Light on all modules of trackers.
pub struct TrackedLight {
    pub tracking: Tracking,
    /// `[spot][side]`
    sides: Vec<[TrackedSide; 2]>,
    /// Sums of the sides of a single tracker above an open plain of each ground.
    open: HashMap<Option<u16>, [MonthlySums; 2]>,
}

/// Light on a side of a module, and the mean over the hours of the sun of the cosine-weighted share
/// of its hemisphere that is sky.
#[derive(Clone, Debug, Default)]
pub struct TrackedSide {
    pub hours: SideHours,
    pub sky_view: f64,
}

impl TrackedLight {
    /// Replays `archives`, one for each traced angle, of which `level` is one, and traces the
    /// middles of modules in the scene without them; `folder` holds temporary files.
    pub fn new(
        tracking: Tracking,
        light: &Light,
        archives: &[Archive],
        level: &Archive,
        spots: &Spots,
        prepared: &PreparedScene,
        folder: &Path,
    ) -> Result<Self> {
        let mut sides: Vec<[TrackedSide; 2]> = vec![Default::default(); spots.list.len()];
        for (traced, archive) in archives.iter().enumerate() {
            let sunny = tracking.share_of_sun(traced);
            light.hourly(archive, |id, hours| {
                if let Some((side, share)) = side_of(&mut sides, spots, id) {
                    tracking.mix(&mut side.hours, traced, &hours, share as f32);
                }
                Ok(())
            })?;
            for row in ArchiveReceivers::<()>::new(&OpenSite::open(archive)?) {
                let receiver = row?;
                if let Some((side, share)) = side_of(&mut sides, spots, &receiver.receiver.id) {
                    side.sky_view += share * sunny * f64::from(receiver.views[0]);
                }
            }
        }
        let settings = BuildSettings::of(&level.manifest().settings);
        let passed = passed(&tracking.conditions, light, spots, prepared, &settings, folder)?;
        let beams: Vec<[Vec<f32>; 2]> = (passed.par_iter().enumerate())
            .map(|(spot, passed)| tracking.beams(Some(spot), |hour| passed.get(hour).copied().unwrap_or(1.0)))
            .collect();
        for (sides, beams) in sides.iter_mut().zip(beams) {
            for (side, beam) in sides.iter_mut().zip(beams) {
                side.hours.0[0] = beam;
            }
        }
        let open = tracking.open(light, level, spots, prepared.scene, folder)?;
        Ok(TrackedLight { tracking, sides, open })
    }

    /// Returns the sides of a spot, front and rear.
    pub fn sides(&self, spot: usize) -> &[TrackedSide] {
        self.sides.get(spot).map_or(&[], |sides| sides)
    }

    /// Returns the sums of the sides of a single tracker on an open plain of a ground.
    pub fn open(&self, ground: Option<u16>) -> &[MonthlySums] {
        self.open.get(&ground).map_or(&[], |sides| sides)
    }
}

/// Returns the side that a receiver lies on, and the share of its light there.
fn side_of<'s>(sides: &'s mut [[TrackedSide; 2]], spots: &Spots, id: &str) -> Option<(&'s mut TrackedSide, f64)> {
    let [spot, side, _] = spots.of_receiver(id)?;
    let receivers = spots.list.get(spot)?.sides.get(side)?.receivers.len();
    Some((sides.get_mut(spot)?.get_mut(side)?, 1.0 / receivers as f64))
}

impl Tracking {
    /// Returns the share of the hours of the sun at a traced angle.
    fn share_of_sun(&self, traced: usize) -> f64 {
        let up = self.of_suns.iter().zip(&self.weights[traced]).filter(|(angles, _)| !angles.is_empty());
        let (count, sum) = up.fold((0.0, 0.0), |(count, sum), (_, weight)| (count + 1.0, sum + f64::from(*weight)));
        sum / f64::max(count, 1.0)
    }

    /// Returns the sums of a single tracker above an open plain of each ground of the spots.
    fn open(
        &self,
        light: &Light,
        level: &Archive,
        spots: &Spots,
        scene: &Scene,
        folder: &Path,
    ) -> Result<HashMap<Option<u16>, [MonthlySums; 2]>> {
        let fronts: Vec<Orientation> =
            self.tracker.angles_deg().iter().map(|angle| self.tracker.turn(*angle)).collect();
        let turn = |front: &Orientation, side: usize| Orientation::new(SIDES[side] * front.normal());
        let grounds: HashSet<Option<u16>> = spots.list.iter().map(|spot| spot.ground).collect();
        let on =
            |ground: Option<u16>| fronts.iter().flat_map(move |front| [0, 1].map(|side| (ground, turn(front, side))));
        let replayed = |archive: &Archive| {
            let mut all = HashMap::new();
            light.hourly(archive, |id, hours| {
                all.insert(id.to_owned(), hours);
                Ok(())
            })?;
            Ok(all)
        };
        let mut plain: OpenPlain<SideHours> = OpenPlain::new(scene, level, folder);
        plain.learn(grounds.iter().flat_map(|ground| on(*ground)), replayed, light.observer())?;
        let (beams, months) = (self.beams(None, |_| 1.0), light.hours(level)?.by(Every::Month));
        let of_ground = |ground: Option<u16>| {
            std::array::from_fn(|side| {
                let mut hours = SideHours::default();
                for (traced, front) in fronts.iter().enumerate() {
                    self.mix(&mut hours, traced, &plain.sums(ground, turn(front, side)), 1.0);
                }
                hours.0[0].clone_from(&beams[side]);
                MonthlySums::new(&hours, &months.bins)
            })
        };
        Ok(grounds.into_iter().map(|ground| (ground, of_ground(ground))).collect())
    }
}

/// Returns the share of the beam that reaches the middle of each module through the surroundings,
/// `[spot][hour]`, from level receivers in a scene without the modules.
fn passed(
    conditions: &[Condition],
    light: &Light,
    spots: &Spots,
    prepared: &PreparedScene,
    settings: &BuildSettings,
    folder: &Path,
) -> Result<Vec<Vec<f64>>> {
    let receiver = |(i, spot): (usize, &Spot)| Receiver::new(i.to_string(), spot.position, glam::DVec3::Z);
    let receivers: Vec<Receiver> = spots.list.iter().enumerate().map(receiver).collect();
    let traced = trace_aside(prepared, &receivers, settings, folder, light.observer())?;
    let level: Vec<f64> = conditions
        .iter()
        .map(|of| of.dni_w_m2 * of.suns.iter().map(|instant| instant.lit() * instant.sun.z).sum::<f64>())
        .collect();
    let mut all = vec![Vec::new(); spots.list.len()];
    light.hourly(traced.archive(), |id, hours| {
        let share = |(hour, open): (usize, &f64)| match *open {
            open if open > 0.0 => (hours.sun_and_rest(hour)[0] / open).clamp(0.0, 1.0),
            _ => 1.0,
        };
        let shares = level.iter().enumerate().map(share).collect();
        if let Some(of) = id.parse::<usize>().ok().and_then(|spot| all.get_mut(spot)) {
            *of = shares;
        }
        Ok(())
    })?;
    Ok(all)
}
