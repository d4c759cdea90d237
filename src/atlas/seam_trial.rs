//! Error that a halo makes. In: the plan of an atlas. Out: how much the light of some receivers
//! changes if everything within three times the halo counts. Cells lie on an absolute grid, so that
//! two builds of one place differ only by the surroundings that they see.

use std::path::Path;

use crate::plan::{AtlasPlan, PlannedPart};
use crate::seams::Seams;
use heliotile_archives::Workspace;
use heliotile_builder::accuracy::CONDITIONS;
use heliotile_builder::accuracy::conditions::ErrorConditions;
use heliotile_builder::accuracy::reference_sample::{TOTAL, percent, rounded, with_total};
use heliotile_builder::accuracy::trial::{Bench, Irradiances};
use heliotile_builder::pipeline::PreparedScene;
use heliotile_builder::reference::comparison::{Deviation, Pair, deviation, mean_w_m2};
use heliotile_builder::reference::{PARTS, ReferenceLight};
use heliotile_core::error::Result;
use heliotile_core::observer::{Observer, Silent};
use heliotile_core::replay::components::Component;
use heliotile_core::site::receiver::Receiver;
use heliotile_scene::Scene;
use heliotile_scene::region_part::RegionPart;
use heliotile_studies::covering::cover_site;

/// Factor by which the halo of the comparison is wider.
const WIDER: f64 = 3.0;

/// Most parts that are compared.
const MAX_PARTS: usize = 8;

/// Differences between the two halos, receiver by receiver.
#[derive(Default)]
struct Differences {
    pairs: Vec<Pair>,
    /// Part of each receiver, `[receiver]`, numbered among the parts with receivers.
    part_of: Vec<usize>,
    parts: usize,
}

/// Builds about `sample` receivers with the plan's halo and with a wider one, and returns the
/// errors between them; `None` if no receiver was found.
pub fn measure(
    plan: &AtlasPlan,
    atlas: &Path,
    sample: usize,
    workspace: &Workspace,
    observer: &dyn Observer,
) -> Result<Option<Seams>> {
    let mut found = Differences::default();
    for (part, wanted) in drawn(&plan.parts, sample) {
        let near = plan.region_part(part);
        // Lower objects count, too, as the angle shrinks with the wider halo.
        let wide = RegionPart { halo_m: WIDER * near.halo_m, skyline_deg: near.skyline_deg / WIDER, ..near };
        let (scene, covered) = cover_site(&plan.site(near, atlas)?, &plan.cut.cover, &Silent)?;
        if found.parts == 0 {
            scene.report.tell(observer);
        }
        let all: Vec<Receiver> = covered
            .free()
            .map(|(name, piece, ..)| {
                Receiver::new(name, piece.position + piece.normal * plan.cut.cover.offset_m, piece.normal)
            })
            .collect();
        let receivers: Vec<Receiver> = every(all, wanted);
        if receivers.is_empty() {
            continue;
        }
        let wider = Scene::load_site(&plan.site(wide, atlas)?)?;
        let [near, wide] = [&scene, &wider].map(|scene| light(scene, &receivers, plan, workspace, observer));
        found.add(&near?, &wide?, receivers.len());
    }
    Ok((found.parts > 0).then(|| found.seams()))
}

/// Draws parts to compare and the number of receivers in each. Each object of the atlas has the
/// same chance (systematic sampling with probability proportional to size, Madow 1949); without
/// objects each part has.
fn drawn(parts: &[PlannedPart], sample: usize) -> Vec<(&PlannedPart, usize)> {
    let any = usize::from(parts.iter().all(|part| part.objects == 0));
    let objects: usize = parts.iter().map(|part| part.objects + any).sum();
    let draws = MAX_PARTS.min(sample);
    let mut taken = Vec::new();
    let (mut before, mut draw) = (0, 0);
    for part in parts {
        let end = before + part.objects + any;
        let first = draw;
        // Draw `k` picks the object at (k + 1/2) / draws of the way through all objects.
        while draw < draws && (2 * draw + 1) * objects < 2 * draws * end {
            draw += 1;
        }
        if draw > first {
            taken.push((part, draw * sample / draws - first * sample / draws));
        }
        before = end;
    }
    taken
}

/// Keeps at most `most` items of a list, evenly spaced.
fn every<T>(list: Vec<T>, most: usize) -> Vec<T> {
    let (count, taken) = (list.len(), list.len().min(most));
    let is_taken = |i: usize| (i + 1) * taken / count > i * taken / count;
    list.into_iter().enumerate().filter_map(|(i, item)| is_taken(i).then_some(item)).collect()
}

fn light(
    scene: &Scene,
    receivers: &[Receiver],
    plan: &AtlasPlan,
    workspace: &Workspace,
    observer: &dyn Observer,
) -> Result<Irradiances> {
    let conditions = ErrorConditions::Spread.some(CONDITIONS);
    let scene = &PreparedScene::new(scene)?;
    let bench = Bench { scene, receivers, conditions: &conditions, workspace, observer };
    Ok(bench.trial(plan.cut.accuracy.settings()?)?.light)
}

impl Differences {
    /// Adds the results of the receivers of another part, `[receiver * condition]`.
    fn add(&mut self, near: &Irradiances, wide: &Irradiances, receivers: usize) {
        let first = self.part_of.len();
        let conditions = (near.rows.len() / receivers.max(1)).max(1);
        for (i, (near, wide)) in near.rows.iter().zip(&wide.rows).enumerate() {
            let [result, mean] = [near, wide].map(with_total);
            let reference = ReferenceLight { mean, ..ReferenceLight::default() };
            self.pairs.push(Pair { receiver: first + i / conditions, condition: i % conditions, result, reference });
        }
        self.part_of.resize(first + receivers, self.parts);
        self.parts += 1;
    }

    fn seams(&self) -> Seams {
        let mean = mean_w_m2(&self.pairs);
        let in_percent = |w_m2: f64| rounded(percent(w_m2, mean));
        let found: [Deviation; PARTS] = std::array::from_fn(|part| deviation(&self.pairs, &[], part));
        let of_part = |pair: &Pair| Pair { receiver: self.part_of[pair.receiver], ..*pair };
        let by_part: Vec<Pair> = self.pairs.iter().map(of_part).collect();
        let total = &found[TOTAL];
        let at_most = total.rmse_w_m2.high.max(deviation(&by_part, &[], TOTAL).rmse_w_m2.high);
        let named = |(component, found): (Component, &Deviation)| {
            (component.name().to_owned(), in_percent(found.rmse_w_m2.value))
        };
        Seams {
            receivers: self.part_of.len(),
            parts: self.parts,
            rmse_percent: in_percent(total.rmse_w_m2.value),
            at_most_percent: in_percent(at_most),
            bias_percent: in_percent(total.bias_w_m2.value),
            components_percent: Component::ALL.into_iter().zip(&found).take(TOTAL).map(named).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Among 100 parts, one with half of the 198 objects gets 4 of 8 draws and half of 250
    /// receivers, four others get the rest. Three parts with one object each, or none, are all
    /// taken with 32 receivers in all; of 2 receivers each lies in another part.
    #[test]
    fn objects_have_equal_chances() {
        let part = |(i, objects): (usize, usize)| PlannedPart { name: format!("x{i}_y0"), low: [0.0; 2], objects };
        let parts = |objects: &[usize]| objects.iter().copied().enumerate().map(part).collect::<Vec<_>>();
        let mut many = [1; 100];
        many[40] = 99;
        let many = parts(&many);
        let taken = drawn(&many, 250);
        let wanted: Vec<usize> = taken.iter().map(|(_, receivers)| *receivers).collect();
        assert_eq!((taken.len(), wanted.iter().sum::<usize>()), (5, 250));
        assert_eq!(taken.iter().find(|(part, _)| part.objects == 99).map(|taken| taken.1), Some(125));
        for few in [parts(&[1; 3]), parts(&[0; 3])] {
            let receivers = |sample| drawn(&few, sample).iter().map(|taken| taken.1).collect::<Vec<_>>();
            assert_eq!((receivers(32).len(), receivers(32).iter().sum::<usize>()), (3, 32));
            assert_eq!((receivers(2), receivers(0)), (vec![1, 1], vec![]));
        }
    }
}
