//! What each receiver sees of the sun. In: receivers, days, what is asked. Out: an answer a receiver, in order.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use super::days::{DayPlan, PlannedRule, RuleDay, SunDays};
use super::exact::{refined, scene_of};
use super::measure::RuleValue;
use super::rule::{LitPart, RuleMeasure};
use crate::outputs::tables::row_labels::RowLabels;
use crate::receivers::{PartReceivers, ReceiverSet, TileReceivers};
use crate::resources::Resources;
use crate::sky_components::SkyComponents;
use heliotile_builder::pipeline::PreparedScene;
use heliotile_builder::siting::Siting;
use heliotile_core::error::Result;
use heliotile_core::memory::Use;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::sunlight::{SeenSky, Spells, SunSeen};
use heliotile_core::units::tilt_and_azimuth;

/// What rows are.
pub enum Asked {
    /// Days, or periods of them.
    Dates(DateRows),
    /// Rules.
    Rules(Vec<PlannedRule>),
}

/// Rows of days.
pub struct DateRows {
    /// Their labels.
    pub labels: RowLabels,
    /// `[date]`: its label.
    pub label_of_date: Vec<usize>,
    /// Whether each is of one day.
    pub is_by_day: bool,
}

/// What a receiver or a group sees.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaceAnswer {
    /// Name of the receiver, or of the group.
    pub name: String,
    /// Where the receiver stands.
    pub position: DVec3,
    /// One a date, or one a rule; none of a rule that is not about it.
    pub items: Vec<Option<AnswerItem>>,
}

/// What is seen on a date, or by a rule.
#[derive(Clone, Debug, PartialEq)]
pub struct AnswerItem {
    /// Minutes of the date, or the value of the rule.
    pub value: RuleValue,
    /// What is seen on the date, or on each day of the rule; none where only the value counts.
    pub days: Vec<SunSeen>,
    /// The value before a change, where there was one.
    pub before: Option<RuleValue>,
}

/// Receivers that are asked, and how.
#[derive(Clone, Copy)]
pub struct PlaceQuestions<'a> {
    /// Which receivers.
    pub receivers: &'a ReceiverSet<'a>,
    /// Days.
    pub plan: &'a DayPlan,
    /// What of them.
    pub asked: &'a Asked,
    /// The sun counts from this height on, degrees; rules have heights of their own.
    pub least_altitude_deg: f64,
    /// Whether edges within texels are found by rays.
    pub exact: bool,
    /// Whether groups will need the spells of rules that count parts of an area at a time.
    pub is_of_groups: bool,
}

/// Surfaces that lean less than this have no side, degrees: roofs that are nearly flat, and ceilings.
const LEVEL_DEG: f64 = 5.0;

/// When surfaces of a normal see the sun's side: by the bits of the normal.
type Fronts = HashMap<[u64; 3], Vec<Spells>>;

/// What a part of the receivers is asked with.
struct PartQuestions<'p> {
    all: &'p PlaceQuestions<'p>,
    part: &'p PartReceivers<'p>,
    suns: SunDays,
    /// `[date]`: when the sun stands high enough, where a height is asked for.
    high: Option<Vec<Spells>>,
    sky: Option<SkyComponents<'p>>,
    rays: Option<Siting<'p>>,
}

impl PlaceQuestions<'_> {
    /// Hands on the answers of all receivers in order, until `take` gives false.
    pub fn each(&self, resources: &Resources, mut take: impl FnMut(PlaceAnswer) -> Result<bool>) -> Result<()> {
        let progress = self.receivers.progress(resources.observer);
        for part in self.receivers.parts().iter().filter(|part| !part.tiles().is_empty()) {
            let scene = self.exact.then(|| scene_of(part.archive)).transpose()?;
            let prepared = scene.as_ref().map(PreparedScene::new).transpose()?;
            let suns = self.plan.suns(part.site.north(), part.site.settings().sides());
            let least_deg = self.least_altitude_deg;
            let high = (least_deg > 0.0).then(|| suns.days.iter().map(|day| day.above(least_deg)).collect());
            let questions = PartQuestions {
                all: self,
                part,
                suns,
                high,
                sky: self.wants_sky().then(|| SkyComponents::of(&part.site)).transpose()?,
                rays: prepared.as_ref().map(Siting::new),
            };
            for tiles in part.tiles().chunks(questions.tiles_at_once(resources)) {
                let answers: Vec<Result<Vec<PlaceAnswer>>> =
                    tiles.par_iter().map(|tile| questions.tile(*tile)).collect();
                for answers in answers {
                    let answers = answers?;
                    progress.advance(answers.len() as u64);
                    for answer in answers {
                        if !take(answer)? {
                            return Ok(());
                        }
                    }
                }
                resources.observer.stop_if_cancelled("before all receivers were looked at")?;
            }
        }
        Ok(())
    }

    /// Items of an answer.
    pub fn items(&self) -> usize {
        match self.asked {
            Asked::Dates(_) => self.plan.dates.len(),
            Asked::Rules(rules) => rules.len(),
        }
    }

    fn wants_sky(&self) -> bool {
        let Asked::Rules(rules) = self.asked else { return false };
        rules.iter().any(|planned| planned.rule.measure == RuleMeasure::VscPercent)
    }
}

impl PartQuestions<'_> {
    /// Tiles whose bits fit into memory together.
    fn tiles_at_once(&self, resources: &Resources) -> usize {
        let fine = self.part.site.settings().sky_fine as u64;
        let rows = self.part.tiles().iter().map(|tile| self.part.site.tile_rows(tile.number)).max().unwrap_or(1);
        let bytes = (rows as u64 * fine * fine / 8).max(1);
        let fit = resources.memory.share(Use::TileGroup) / bytes;
        usize::try_from(fit).unwrap_or(1).clamp(1, rayon::current_num_threads())
    }

    fn tile(&self, tile: TileReceivers) -> Result<Vec<PlaceAnswer>> {
        let site = &self.part.site;
        let table = site.tile_receivers(tile.number)?;
        let receivers = site.tile_parts(tile.number, &table)?;
        let skies = site.tile_sky(tile.number, receivers.len())?;
        let vsc = self.sky.as_ref().and_then(|sky| sky.tiles([tile.number]).next()).transpose()?;
        let mut fronts = Fronts::new();
        let mut answers = Vec::new();
        for (row, (receiver, sky)) in receivers.iter().zip(&skies).enumerate() {
            if !self.part.is_chosen(tile, row) {
                continue;
            }
            let front = fronts.entry(receiver.normal.to_array().map(f64::to_bits)).or_insert_with(|| {
                let days = self.suns.days.iter();
                days.map(|day| day.before(receiver.normal, 0.0).within(&day.up)).collect()
            });
            let mut sky = SeenSky::new(sky);
            let rays = self.rays.as_ref().map(|siting| siting.sun_rays(receiver.position, receiver.normal));
            let days = self.suns.passes.iter().zip(&self.suns.days).zip(front.iter());
            let seen: Vec<SunSeen> = days
                .map(|((passes, day), front)| {
                    let seen = sky.sun(passes, front);
                    match &rays {
                        Some(rays) => refined(&seen, day, rays),
                        None => seen,
                    }
                })
                .collect();
            let vsc = vsc.as_ref().and_then(|vsc| vsc.get(row)).copied();
            let items = self.items(receiver, seen, vsc);
            answers.push(PlaceAnswer { name: receiver.id.clone(), position: receiver.position, items });
        }
        Ok(answers)
    }

    fn items(&self, receiver: &Receiver, seen: Vec<SunSeen>, vsc_percent: Option<f64>) -> Vec<Option<AnswerItem>> {
        match self.all.asked {
            Asked::Dates(_) => {
                let of_date = |(number, seen): (usize, SunSeen)| {
                    let high = self.high.as_ref().and_then(|high| high.get(number));
                    let seen = match high {
                        Some(high) => seen.within(high),
                        None => seen,
                    };
                    let of = |spells: &Spells| spells.minutes();
                    let value = RuleValue { value: of(&seen.seen), low: of(&seen.sure), high: of(&seen.possible) };
                    Some(AnswerItem { value, days: vec![seen], before: None })
                };
                seen.into_iter().enumerate().map(of_date).collect()
            }
            Asked::Rules(rules) => {
                let (tilt, azimuth) = tilt_and_azimuth(self.part.site.north().to_true(receiver.normal));
                let azimuth = (LEVEL_DEG..180.0 - LEVEL_DEG).contains(&tilt).then_some(azimuth);
                let of_rule = |planned: &PlannedRule| {
                    let is_about = planned.rule.is_about(&receiver.part.kind, azimuth);
                    is_about.then(|| self.of_rule(planned, receiver, &seen, vsc_percent))
                };
                rules.iter().map(of_rule).collect()
            }
        }
    }

    fn of_rule(
        &self,
        planned: &PlannedRule,
        receiver: &Receiver,
        seen: &[SunSeen],
        vsc_percent: Option<f64>,
    ) -> AnswerItem {
        if planned.rule.measure == RuleMeasure::VscPercent {
            return AnswerItem {
                value: RuleValue::certain(vsc_percent.unwrap_or_default()),
                days: Vec::new(),
                before: None,
            };
        }
        let least_deg = planned.rule.least_angle_deg;
        let of_day = |day: &RuleDay| {
            let seen = seen.get(day.number).cloned().unwrap_or_default().within(&day.counts);
            match self.suns.days.get(day.number).filter(|_| least_deg > 0.0) {
                Some(sun) => seen.within(&sun.before(receiver.normal, least_deg)),
                None => seen,
            }
        };
        let days: Vec<SunSeen> = planned.days.iter().map(of_day).collect();
        let value = planned.value(&days);
        let is_wanted = self.all.is_of_groups && matches!(planned.rule.part, LitPart::AtATime(_));
        AnswerItem { value, days: if is_wanted { days } else { Vec::new() }, before: None }
    }
}
