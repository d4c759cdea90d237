//! What a halo costs. In: the plan of an atlas. Out: how much light of some receivers changes if everything within three times the halo
//! counts. Cells lie on an absolute grid, so that builds of one place differ by what they see alone.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::plan::{AtlasPlan, PlannedPart};
use crate::commands::build::settings_of;
use crate::commands::receivers::{cover_quietly, say_of};
use crate::commands::terminal::Terminal;
use heliotile_builder::accuracy::CONDITIONS;
use heliotile_builder::accuracy::conditions::ErrorConditions;
use heliotile_builder::accuracy::judged::rounded;
use heliotile_builder::accuracy::trial::{Bench, Irradiances};
use heliotile_builder::build::{PreparedScene, Workspace};
use heliotile_core::error::Result;
use heliotile_core::replay::components::Component;
use heliotile_core::site::receiver::Receiver;
use heliotile_scene::Scene;
use heliotile_scene::region_part::RegionPart;

/// How much wider the halo is that is compared with.
const WIDER: f64 = 3.0;

/// Parts that are looked at.
const MOST_PARTS: usize = 3;

/// Errors that a halo makes, beside three times as wide a one: RMSE over receivers and suns from all sides, in percent of the mean total.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Seams {
    /// Receivers and parts that they lie in.
    pub receivers: usize,
    pub parts: usize,
    /// Of the total.
    pub rmse_percent: f64,
    /// Mean error of the totals: above 0 if they come out too large.
    pub bias_percent: f64,
    /// By column name.
    pub components_percent: BTreeMap<String, f64>,
}

/// Sums over receivers and conditions.
#[derive(Default)]
struct Differences {
    receivers: usize,
    parts: usize,
    count: f64,
    /// Of the wider halo's totals.
    total: f64,
    difference: f64,
    squares: f64,
    /// By component.
    of_each: [f64; 6],
}

/// Builds about so many receivers with the plan's halo and with a wider one.
pub fn measure(plan: &AtlasPlan, atlas: &Path, sample: usize, workspace: &Workspace) -> Result<Option<Seams>> {
    let mut found = Differences::default();
    for part in spread(&plan.parts) {
        let near = plan.region_part(part);
        let wide = RegionPart { halo_m: WIDER * near.halo_m, skyline_deg: near.skyline_deg / WIDER, ..near };
        let (scene, covered) = cover_quietly(&plan.site(near, atlas)?, &plan.cover)?;
        if found.parts == 0 {
            say_of(&scene);
        }
        let all: Vec<Receiver> = covered
            .free()
            .map(|(name, piece, ..)| {
                Receiver::new(name, piece.position + piece.normal * plan.cover.offset.0, piece.normal)
            })
            .collect();
        let receivers: Vec<Receiver> = every(all, sample.div_ceil(MOST_PARTS));
        if receivers.is_empty() {
            continue;
        }
        let wider = Scene::load_site(&plan.site(wide, atlas)?)?;
        let [near, wide] = [&scene, &wider].map(|scene| light(scene, &receivers, plan, workspace));
        found.add(&near?, &wide?);
        found.parts += 1;
        found.receivers += receivers.len();
    }
    Ok((found.receivers > 0).then(|| found.seams()))
}

/// A few parts from all over the atlas, those with few objects last.
fn spread(parts: &[PlannedPart]) -> Vec<&PlannedPart> {
    let mut usual: Vec<&PlannedPart> = parts.iter().collect();
    let most = parts.iter().map(|part| part.objects).max().unwrap_or_default();
    usual.retain(|part| 4 * part.objects >= most);
    every(usual, MOST_PARTS)
}

/// At most so many of a list, evenly.
fn every<T>(list: Vec<T>, most: usize) -> Vec<T> {
    let (count, taken) = (list.len(), list.len().min(most));
    let is_taken = |i: usize| (i + 1) * taken / count > i * taken / count;
    list.into_iter().enumerate().filter_map(|(i, item)| is_taken(i).then_some(item)).collect()
}

fn light(scene: &Scene, receivers: &[Receiver], plan: &AtlasPlan, workspace: &Workspace) -> Result<Irradiances> {
    let conditions = ErrorConditions::Spread.some(CONDITIONS);
    let (scene, observer) = (&PreparedScene::new(scene)?, &Terminal::default());
    let bench = Bench { scene, receivers, conditions: &conditions, workspace, observer };
    Ok(bench.trial(settings_of(&plan.accuracy()?)?)?.light)
}

impl Differences {
    fn add(&mut self, near: &Irradiances, wide: &Irradiances) {
        for (near, wide) in near.rows.iter().zip(&wide.rows) {
            let mut sum = 0.0;
            for (square, (near, wide)) in self.of_each.iter_mut().zip(near.iter().zip(wide)) {
                let difference = f64::from(*near) - f64::from(*wide);
                *square += difference * difference;
                sum += difference;
                self.total += f64::from(*wide);
            }
            self.squares += sum * sum;
            self.difference += sum;
            self.count += 1.0;
        }
    }

    fn seams(&self) -> Seams {
        let mean = (self.total / self.count).max(f64::MIN_POSITIVE);
        let percent = |squares: f64| rounded(100.0 * (squares / self.count).sqrt() / mean);
        let named = |(component, squares): (&Component, &f64)| (component.name().to_owned(), percent(*squares));
        Seams {
            receivers: self.receivers,
            parts: self.parts,
            rmse_percent: percent(self.squares),
            bias_percent: rounded(100.0 * self.difference / self.count / mean),
            components_percent: Component::ALL.iter().zip(&self.of_each).map(named).collect(),
        }
    }
}
