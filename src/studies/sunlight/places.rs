//! Sun on receivers, direct and by mirrors. In: receivers, days, a request. Out: an answer for each
//! receiver, in order.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use super::days::{DayPlan, PlannedRule, RuleDay, SunDays};
use super::exact::{EDGE_STEP_MIN, MIRROR_STEP_MIN, refined, scene_of};
use super::glare::{GlareSpell, SpellTeller};
use super::measure::RuleValue;
use super::panes::{PaneList, ScenePanes};
use super::rule::{LitPart, RuleMeasure};
use super::trees::TreeShade;
use heliotile_builder::pipeline::PreparedScene;
use heliotile_builder::siting::{MirrorObserver, MirrorRays, Siting};
use heliotile_core::error::{Error, Result};
use heliotile_core::hemisphere::HEMISPHERE_SR;
use heliotile_core::layers::canopy::Powers;
use heliotile_core::light::canopies::stored;
use heliotile_core::light::mirrors::MirrorTable;
use heliotile_core::memory::Use;
use heliotile_core::site::chain::Chain;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::units::tilt_and_azimuth;
use heliotile_results::outputs::tables::bin_labels::BinLabels;
use heliotile_results::receivers::{PartReceivers, ReceiverSet, TileReceivers};
use heliotile_results::resources::Resources;
use heliotile_results::sky_components::SkyComponents;
use heliotile_sunlight::{
    GlareAngles, HotSpot, MirrorSpells, SeenSky, Spells, Strongest, SunSeen, TileMirrors, in_any,
};

/// Subject of the rows of a request.
pub enum RowSubject {
    /// Days, or periods of days.
    Dates(DateRows),
    /// Rules.
    Rules(Vec<PlannedRule>),
}

/// Rows of days.
pub struct DateRows {
    /// Labels of the rows.
    pub labels: BinLabels,
    /// `[date]`: index of its label.
    pub bin_of_date: Vec<usize>,
    /// True if each row is of one day.
    pub is_by_day: bool,
}

/// Answer of a receiver or a group.
#[derive(Clone, Debug)]
pub struct PlaceAnswer {
    /// Name of the receiver, or of the group.
    pub name: String,
    /// Position of the receiver, or the middle of the group.
    pub position: DVec3,
    /// Items, one a date or one a rule; `None` for a rule that does not apply to the place.
    pub items: Vec<Option<AnswerItem>>,
    /// Spells of glare, if requested; empty for groups.
    pub spells: Vec<GlareSpell>,
}

/// Result for a date or a rule.
#[derive(Clone, Debug, PartialEq)]
pub struct AnswerItem {
    /// Minutes of the date, or the value of the rule.
    pub value: RuleValue,
    /// Spells on the date, or on each day of the rule; empty if only the value is needed.
    pub days: Vec<SunSeen>,
    /// Strongest image of the sun, on dates with glare.
    pub strongest: Option<Strongest>,
    /// Largest irradiance by all images of the sun together, on dates with glare.
    pub hot_spot: Option<HotSpot>,
    /// Value before a change, if there was one.
    pub before: Option<RuleValue>,
}

/// Rules whose answers keep the spells of their days, besides the value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeptSpells {
    /// None of them.
    None,
    /// Those about parts of an area at the same time, for groups.
    OfParts,
    /// All of them.
    All,
}

/// Receivers and the computation that is requested for them.
#[derive(Clone, Copy)]
pub struct PlaceQuestions<'a> {
    /// Receivers to compute.
    pub receivers: &'a ReceiverSet<'a>,
    /// Days to compute.
    pub plan: &'a DayPlan,
    /// Subject of the rows: dates or rules.
    pub asked: &'a RowSubject,
    /// Least altitude of the sun, degrees, at which it counts. Rules have altitudes of their own.
    pub least_altitude_deg: f64,
    /// Shade of trees and screens.
    pub trees: TreeShade,
    /// Angles of glare that counts, if rows of days are about glare instead of the sun itself.
    pub glare: Option<GlareAngles>,
    /// Collector of the panes, if spells of glare are requested.
    pub panes: Option<&'a PaneList>,
    /// True if edges within texels are decided by rays.
    pub exact: bool,
    /// Rules whose answers keep the spells of their days.
    pub kept: KeptSpells,
}

/// Tilt below which surfaces have no side, degrees: roofs that are nearly flat, and ceilings.
const LEVEL_DEG: f64 = 5.0;

/// Spells in which surfaces of a normal face the sun, by the bits of the normal.
type Fronts = HashMap<[u64; 3], Vec<Spells>>;

/// Inputs for the receivers of one archive.
struct PartQuestions<'p> {
    all: &'p PlaceQuestions<'p>,
    part: &'p PartReceivers<'p>,
    suns: SunDays,
    /// `[date]`: spells with the sun high enough, if an altitude is requested.
    high: Option<Vec<Spells>>,
    sky: Option<SkyComponents<'p>>,
    /// True if the sun itself is needed.
    wants_sun: bool,
    /// Shares of light that canopies let through.
    powers: Powers,
    rays: Option<Siting<'p>>,
    mirrors: Option<PartMirrors<'p>>,
}

/// Mirrors of one archive.
struct PartMirrors<'p> {
    table: MirrorTable,
    rays: Option<PartRays<'p>>,
}

/// Rays by way of mirrors.
struct PartRays<'p> {
    rays: MirrorRays<'p>,
    /// `[number in the archive]`: number of the mirror in the scene.
    numbers: Vec<u16>,
    /// Panes, if spells are requested.
    panes: Option<ScenePanes>,
}

/// Spells that a receiver sees, `[date]`; empty for what is not requested.
struct ReceiverSees<'m> {
    sun: Vec<SunSeen>,
    /// Spells by chain of mirrors.
    mirrors: Vec<Vec<MirrorSpells<'m>>>,
}

impl AnswerItem {
    /// Returns an item with a value only.
    pub fn new(value: RuleValue) -> Self {
        AnswerItem { value, days: Vec::new(), strongest: None, hot_spot: None, before: None }
    }
}

impl PlaceQuestions<'_> {
    /// Hands the answers of all receivers to `take`, in order, until it returns false.
    pub fn each(&self, resources: &Resources, mut take: impl FnMut(PlaceAnswer) -> Result<bool>) -> Result<()> {
        let progress = self.receivers.progress(resources.observer);
        for part in self.receivers.parts().iter().filter(|part| !part.tiles().is_empty()) {
            let needs_scene = self.exact || self.panes.is_some();
            let scene = needs_scene.then(|| scene_of(part.archive)).transpose()?;
            let prepared = scene.as_ref().map(PreparedScene::new).transpose()?;
            let suns = self.plan.suns(part.site.north(), part.site.settings().sides());
            let least_deg = self.least_altitude_deg;
            let high = (least_deg > 0.0).then(|| suns.days.iter().map(|day| day.above(least_deg)).collect());
            let questions = PartQuestions {
                all: self,
                part,
                suns,
                high,
                sky: self.wants_sky().then(|| SkyComponents::overcast(&part.site)).transpose()?,
                wants_sun: self.wants(false),
                powers: stored(part.site.materials()),
                rays: prepared.as_ref().filter(|_| self.exact).map(Siting::new),
                mirrors: self.wants(true).then(|| self.mirrors(part, prepared.as_ref())).transpose()?,
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

    /// Returns the number of items of an answer.
    pub fn items(&self) -> usize {
        match self.asked {
            RowSubject::Dates(_) => self.plan.dates.len(),
            RowSubject::Rules(rules) => rules.len(),
        }
    }

    /// Returns true if the sun in mirrors is needed, or the sun itself if `in_mirrors` is false.
    fn wants(&self, in_mirrors: bool) -> bool {
        match self.asked {
            RowSubject::Dates(_) => self.glare.is_some() == in_mirrors,
            RowSubject::Rules(rules) => {
                rules.iter().any(|rule| rule.rule.needs_days() && rule.rule.measure.is_of_mirrors() == in_mirrors)
            }
        }
    }

    /// Returns the mirrors of one archive, with its scene if rays are cast.
    fn mirrors<'p>(&self, part: &PartReceivers, prepared: Option<&'p PreparedScene<'p>>) -> Result<PartMirrors<'p>> {
        let table = MirrorTable::new(&part.site);
        let rays = match prepared {
            None => None,
            Some(prepared) => {
                let rays = MirrorRays::new(prepared);
                let numbers = rays.numbers_of(&table.orientations).ok_or_else(|| {
                    let what = "its scene lacks a mirror that its receivers see";
                    Error::input(part.archive.path(), None, what, "build the archive again")
                })?;
                let panes = self.panes.map(|list| {
                    let panes = ScenePanes::new(prepared.scene);
                    list.add(&panes);
                    panes
                });
                Some(PartRays { rays, numbers, panes })
            }
        };
        Ok(PartMirrors { table, rays })
    }

    fn wants_sky(&self) -> bool {
        let RowSubject::Rules(rules) = self.asked else { return false };
        rules.iter().any(|planned| planned.rule.measure == RuleMeasure::VscPercent)
    }
}

impl PartQuestions<'_> {
    /// Returns the number of tiles whose bitmaps fit into memory together.
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
        let mut skies = if self.wants_sun { site.tile_sky(tile.number, receivers.len())? } else { Vec::new() };
        if self.all.trees != TreeShade::Ignore {
            let canopies = site.tile_canopies(tile.number, receivers.len())?;
            for (sky, canopy) in skies.iter_mut().zip(&canopies) {
                let hidden = self.all.trees.hide(sky, canopy, &self.powers);
                hidden.into_iter().for_each(|left| *sky = left);
            }
        }
        let mirrors = self.mirrors.as_ref();
        let mirrors = mirrors.map(|of| TileMirrors::read(site, tile.number, receivers.len(), &of.table)).transpose()?;
        let vsc = self.sky.as_ref().and_then(|sky| sky.tiles([tile.number]).next()).transpose()?;
        let mut fronts = Fronts::new();
        let mut answers = Vec::new();
        for (row, receiver) in receivers.iter().enumerate() {
            if !self.part.is_chosen(tile, row) {
                continue;
            }
            let sun = match skies.get(row) {
                None => Vec::new(),
                Some(sky) => {
                    // Many receivers share a normal, so the spells in front of it are computed
                    // once.
                    let front = fronts.entry(receiver.normal.to_array().map(f64::to_bits)).or_insert_with(|| {
                        let days = self.suns.days.iter();
                        days.map(|day| day.before(receiver.normal, 0.0).within(&day.up)).collect()
                    });
                    self.sun(receiver, SeenSky::new(sky), front)
                }
            };
            let of_mirrors = mirrors.as_ref().map(|mirrors| self.mirrored(receiver, mirrors, row));
            let sees = ReceiverSees { sun, mirrors: of_mirrors.unwrap_or_default() };
            let vsc = vsc.as_ref().and_then(|vsc| vsc.get(row)).copied();
            let (items, spells) = (self.items(receiver, &sees, vsc), self.spells(receiver, &sees));
            answers.push(PlaceAnswer { name: receiver.id.clone(), position: receiver.position, items, spells });
        }
        Ok(answers)
    }

    /// Returns the spells in which a receiver sees the sun itself.
    fn sun(&self, receiver: &Receiver, mut sky: SeenSky, front: &[Spells]) -> Vec<SunSeen> {
        let rays = self.rays.as_ref().map(|siting| siting.sun_rays(receiver.position, receiver.normal));
        let days = self.suns.passes.iter().zip(&self.suns.days).zip(front);
        let of_day = |((passes, day), front)| {
            let seen = sky.sun(passes, front);
            match &rays {
                Some(rays) => refined(&seen, day, EDGE_STEP_MIN, |suns| rays.sees(suns)),
                None => seen,
            }
        };
        days.map(of_day).collect()
    }

    /// Returns the spells in which a receiver sees the sun in mirrors.
    fn mirrored<'m>(&self, receiver: &Receiver, mirrors: &'m TileMirrors, row: usize) -> Vec<Vec<MirrorSpells<'m>>> {
        let mut suns = mirrors.of_receiver(row, receiver.normal);
        let rays = self.mirrors.as_ref().and_then(|mirrors| mirrors.rays.as_ref()).filter(|_| self.all.exact);
        let observer = rays.map(|of| (of, of.rays.observer(receiver.position, receiver.normal)));
        let days = self.suns.passes.iter().zip(&self.suns.days);
        let of_day = |(passes, day)| {
            let found = suns.on(day, passes, observer.is_some());
            let Some((of, observer)) = &observer else { return found };
            let refine = |mirror: MirrorSpells<'m>| {
                let number = |number: u16| of.numbers.get(usize::from(number)).copied().unwrap_or(number);
                let chain = Chain::new(&mirror.chain.numbers().map(number).collect::<Vec<u16>>());
                mirror.with_seen(refined(&mirror.seen, day, MIRROR_STEP_MIN, |suns| observer.sees(chain, suns)))
            };
            found.into_iter().map(refine).collect()
        };
        days.map(of_day).collect()
    }

    /// Returns the spells of glare, if they are requested.
    fn spells(&self, receiver: &Receiver, sees: &ReceiverSees) -> Vec<GlareSpell> {
        let rays = self.mirrors.as_ref().and_then(|mirrors| mirrors.rays.as_ref());
        let Some((of, panes)) = rays.and_then(|of| of.panes.as_ref().map(|panes| (of, panes))) else {
            return Vec::new();
        };
        let observer: MirrorObserver = of.rays.observer(receiver.position, receiver.normal);
        let texel_rad = HEMISPHERE_SR.sqrt() / self.part.site.settings().sky_fine as f64;
        let teller = SpellTeller { panes, observer, north: self.part.site.north(), texel_rad };
        let angles = self.all.glare.unwrap_or(GlareAngles::ALL);
        let mut all = Vec::new();
        for (number, (mirrors, day)) in sees.mirrors.iter().zip(&self.suns.days).enumerate() {
            let counted = mirrors.iter().map(|one| one.with_seen(self.high(number, one.within(day, angles))));
            let mut of_day: Vec<GlareSpell> = counted.flat_map(|one| teller.spells(&one, day)).collect();
            of_day.sort_by(|a, b| a.spell.start_min.total_cmp(&b.spell.start_min));
            all.append(&mut of_day);
        }
        all
    }

    /// Returns the part of the spells in which the sun is high enough.
    fn high(&self, number: usize, seen: SunSeen) -> SunSeen {
        match self.high.as_ref().and_then(|high| high.get(number)) {
            Some(high) => seen.within(high),
            None => seen,
        }
    }

    fn items(&self, receiver: &Receiver, sees: &ReceiverSees, vsc_percent: Option<f64>) -> Vec<Option<AnswerItem>> {
        match self.all.asked {
            RowSubject::Dates(_) => {
                let of = |spells: &Spells| spells.minutes();
                let item = |seen: SunSeen| {
                    let value = RuleValue { value: of(&seen.seen), low: of(&seen.sure), high: of(&seen.possible) };
                    AnswerItem { days: vec![seen], ..AnswerItem::new(value) }
                };
                match self.all.glare {
                    None => {
                        let days = sees.sun.iter().cloned().enumerate();
                        days.map(|(number, seen)| Some(item(self.high(number, seen)))).collect()
                    }
                    Some(angles) => {
                        let days = sees.mirrors.iter().zip(&self.suns.days).enumerate();
                        let of_date = |(number, (mirrors, day))| {
                            let mirrors: &Vec<MirrorSpells> = mirrors;
                            let counted: Vec<(SunSeen, &MirrorSpells)> =
                                mirrors.iter().map(|one| (self.high(number, one.within(day, angles)), one)).collect();
                            let strongest =
                                counted.iter().filter_map(|(seen, mirror)| Strongest::new(mirror, day, &seen.seen));
                            let shown: Vec<(&Spells, &MirrorSpells)> =
                                counted.iter().map(|(seen, mirror)| (&seen.seen, *mirror)).collect();
                            Some(AnswerItem {
                                strongest: strongest.reduce(Strongest::and),
                                hot_spot: HotSpot::new(&shown, day),
                                ..item(in_any(counted.iter().map(|(seen, _)| seen)))
                            })
                        };
                        days.map(of_date).collect()
                    }
                }
            }
            RowSubject::Rules(rules) => {
                let (tilt, azimuth) = tilt_and_azimuth(self.part.site.north().to_true(receiver.normal));
                let azimuth = (LEVEL_DEG..180.0 - LEVEL_DEG).contains(&tilt).then_some(azimuth);
                let of_rule = |planned: &PlannedRule| {
                    let is_about = planned.rule.is_about(&receiver.part.kind, azimuth);
                    is_about.then(|| self.of_rule(planned, receiver, sees, vsc_percent))
                };
                rules.iter().map(of_rule).collect()
            }
        }
    }

    fn of_rule(
        &self,
        planned: &PlannedRule,
        receiver: &Receiver,
        sees: &ReceiverSees,
        vsc_percent: Option<f64>,
    ) -> AnswerItem {
        let rule = &planned.rule;
        if rule.measure == RuleMeasure::VscPercent {
            return AnswerItem::new(RuleValue::certain(vsc_percent.unwrap_or_default()));
        }
        let least_deg = rule.least_angle_deg;
        let angles = self.all.glare.map_or(rule.angles, |asked| rule.angles.and(asked));
        let of_day = |day: &RuleDay| {
            let sun = self.suns.days.get(day.number);
            let seen = match sun.filter(|_| rule.measure.is_of_mirrors()) {
                Some(sun) => {
                    let mirrors = sees.mirrors.get(day.number).map_or(&[][..], Vec::as_slice);
                    let counted: Vec<SunSeen> = mirrors.iter().map(|one| one.within(sun, angles)).collect();
                    in_any(counted.iter())
                }
                None => sees.sun.get(day.number).cloned().unwrap_or_default(),
            };
            let seen = seen.within(&day.counts);
            match sun.filter(|_| least_deg > 0.0) {
                Some(sun) => seen.within(&sun.before(receiver.normal, least_deg)),
                None => seen,
            }
        };
        let days: Vec<SunSeen> = planned.days.iter().map(of_day).collect();
        let value = planned.value(&days);
        let is_wanted = match self.all.kept {
            KeptSpells::None => false,
            KeptSpells::OfParts => matches!(rule.part, LitPart::AtATime(_)),
            KeptSpells::All => true,
        };
        AnswerItem { days: if is_wanted { days } else { Vec::new() }, ..AnswerItem::new(value) }
    }
}
