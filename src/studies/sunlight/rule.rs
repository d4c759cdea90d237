//! Rule of sunlight or glare: the days and hours that count, the part of a place that must be lit,
//! and the time. In: tables of TOML. Out: rules whose numbers are in range.

use std::fmt;

use serde::Deserialize;
use serde_json::{Value, json};

use super::calendar::DaySpan;
use heliotile_core::named::NamedValues;
use heliotile_core::serde_by_name;
use heliotile_sunlight::GlareAngles;

/// Rule of sunlight or glare.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "StatedRule")]
pub struct Rule {
    /// Name in results.
    pub name: String,
    /// Requirement in words.
    pub title: String,
    /// Source of the requirement.
    pub source: String,
    /// Parts of the rule that could not be confirmed; empty if all were.
    pub unconfirmed: String,
    /// Days that count; empty: the days of the request.
    pub dates: Vec<DaySpan>,
    /// Way in which the days become one number.
    pub days: DaysTogether,
    /// Measure of the rule.
    pub measure: RuleMeasure,
    /// Threshold that values must meet.
    pub threshold: Threshold,
    /// Hours of the clock that count; `None`: all.
    pub hours: Option<ClockHours>,
    /// Least altitude of the sun, degrees, at which it counts.
    pub least_altitude_deg: f64,
    /// Least length of a spell that counts, minutes.
    pub least_spell_min: f64,
    /// Least angle between the sun and the surface, degrees, at which it counts.
    pub least_angle_deg: f64,
    /// Angles of glare that counts, for rules of glare.
    pub angles: GlareAngles,
    /// Kinds of surfaces that the rule applies to; empty: all.
    pub kinds: Vec<String>,
    /// Range of azimuths, clockwise from one to the other, degrees from true north, of surfaces
    /// that the rule applies to; `None`: all.
    pub facing_deg: Option<[f64; 2]>,
    /// Part of a surface that must be lit.
    pub part: LitPart,
    /// Share of the value before a change that is enough even if the value is below the threshold.
    pub former_share: Option<f64>,
}

/// Threshold of a rule: minutes, or percent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Threshold {
    /// Least value that meets the rule.
    AtLeast(f64),
    /// Greatest value that meets the rule.
    AtMost(f64),
}

/// Hours of a day.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockHours {
    /// Beginning, minutes after midnight.
    pub from_min: f64,
    /// End, minutes after midnight.
    pub to_min: f64,
    /// Clock of the hours.
    pub clock: RuleClock,
}

/// Part of a surface, or of another group of receivers, that must be lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LitPart {
    /// Receiver that is nearest to the middle.
    Middle,
    /// Share of the area that must be lit at the same time.
    AtATime(f64),
    /// Share of the area of which each part must be lit for the required time, at any times.
    InTurn(f64),
}

/// Way in which the days of a rule become one number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DaysTogether {
    /// Worst of the days: each day must meet the rule.
    #[default]
    Each,
    /// Best of the days: one day must meet the rule.
    Any,
    /// Mean of the days.
    Mean,
    /// Sum of the days.
    Sum,
}

/// Measure of a rule.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RuleMeasure {
    /// Minutes of sun.
    #[default]
    Minutes,
    /// Longest spell, minutes.
    LongestSpell,
    /// Hours in which the sun shines by the weather file, percent of all such hours on open ground.
    ProbablePercent,
    /// Vertical sky component, percent.
    VscPercent,
    /// Minutes of glare: mirrors reflect the sun to the place.
    GlareMinutes,
}

/// Clock of the hours of a rule.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RuleClock {
    /// Standard time of the zone.
    #[default]
    Standard,
    /// Legal time of the zone, which may be summer time.
    Legal,
    /// True solar time: the sun is highest at 12.
    Solar,
}

impl RuleMeasure {
    /// Returns true if values are percent, not minutes.
    pub fn is_percent(self) -> bool {
        matches!(self, RuleMeasure::ProbablePercent | RuleMeasure::VscPercent)
    }

    /// Returns what is measured, for titles.
    pub fn words(self) -> &'static str {
        match self {
            RuleMeasure::Minutes => "possible sun",
            RuleMeasure::LongestSpell => "longest spell of possible sun",
            RuleMeasure::ProbablePercent => "probable sunlight hours",
            RuleMeasure::VscPercent => "vertical sky component",
            RuleMeasure::GlareMinutes => "sun in mirrors",
        }
    }

    /// Returns true if the measure is of the sun in mirrors, not of the sun itself.
    pub fn is_of_mirrors(self) -> bool {
        self == RuleMeasure::GlareMinutes
    }
}

impl NamedValues for DaysTogether {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("each", "Each day has to meet the rule", DaysTogether::Each),
        ("any", "At least one day has to meet the rule", DaysTogether::Any),
        ("mean", "The mean of the days counts", DaysTogether::Mean),
        ("sum", "The sum of the days counts", DaysTogether::Sum),
    ];
}

impl NamedValues for RuleMeasure {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("minutes", "Minutes of sun", RuleMeasure::Minutes),
        ("longest_spell", "The longest spell, minutes", RuleMeasure::LongestSpell),
        ("probable_percent", "Percent of the sunny hours of a weather file", RuleMeasure::ProbablePercent),
        ("vsc_percent", "Vertical sky component, percent", RuleMeasure::VscPercent),
        ("glare_minutes", "Minutes in which mirrors reflect the sun onto a place", RuleMeasure::GlareMinutes),
    ];
}

impl NamedValues for RuleClock {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("standard", "The zone's standard time", RuleClock::Standard),
        ("legal", "The zone's legal time", RuleClock::Legal),
        ("solar", "True solar time", RuleClock::Solar),
    ];
}

serde_by_name!(DaysTogether, RuleMeasure, RuleClock);

/// Reading of the clock, written as `09:30`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "String")]
struct ClockTime(f64);

impl TryFrom<String> for ClockTime {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let read = || {
            let (hours, minutes) = text.split_once(':')?;
            let number = |part: &str| part.parse::<u32>().ok().filter(|_| part.bytes().all(|b| b.is_ascii_digit()));
            let (hours, minutes) = (number(hours)?, number(minutes)?);
            (minutes < 60 && 60 * hours + minutes <= 1440).then(|| ClockTime(f64::from(60 * hours + minutes)))
        };
        read().ok_or_else(|| format!("`{text}` is not a time of day: give it as \"09:30\""))
    }
}

/// Rule as a file states it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct StatedRule {
    name: String,
    #[serde(default)]
    title: String,
    #[serde(default)]
    source: String,
    #[serde(default)]
    unconfirmed: String,
    #[serde(default)]
    dates: Vec<DaySpan>,
    #[serde(default)]
    days: DaysTogether,
    #[serde(default)]
    measure: RuleMeasure,
    at_least: Option<f64>,
    at_most: Option<f64>,
    from: Option<ClockTime>,
    to: Option<ClockTime>,
    #[serde(default)]
    clock: RuleClock,
    #[serde(default)]
    least_altitude_deg: f64,
    #[serde(default)]
    least_spell_minutes: f64,
    #[serde(default)]
    least_angle_deg: f64,
    least_deflection_deg: Option<f64>,
    view_angle_deg: Option<f64>,
    #[serde(default)]
    kinds: Vec<String>,
    facing_deg: Option<[f64; 2]>,
    lit_share: Option<f64>,
    area_share: Option<f64>,
    former_share: Option<f64>,
}

/// Longest name of a rule: names of columns of maps begin with it.
const MAX_LETTERS: usize = 40;

impl TryFrom<StatedRule> for Rule {
    type Error = String;

    fn try_from(stated: StatedRule) -> Result<Self, String> {
        let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        let name = stated.name;
        if name.is_empty() || name.len() > MAX_LETTERS || !name.chars().all(is_plain) {
            return Err(format!(
                "`{name}` cannot name a rule: use lowercase letters, digits and -, {MAX_LETTERS} at most"
            ));
        }
        let is_percent = stated.measure.is_percent();
        let most = if is_percent { 100.0 } else { 1e6 };
        let numbers = [
            ("at_least", stated.at_least.unwrap_or_default(), most),
            ("at_most", stated.at_most.unwrap_or_default(), most),
            ("least_altitude_deg", stated.least_altitude_deg, 90.0),
            ("least_spell_minutes", stated.least_spell_minutes, 1440.0),
            ("least_angle_deg", stated.least_angle_deg, 90.0),
            ("least_deflection_deg", stated.least_deflection_deg.unwrap_or_default(), 180.0),
            ("view_angle_deg", stated.view_angle_deg.unwrap_or_default(), 90.0),
            ("lit_share", stated.lit_share.unwrap_or(1.0), 1.0),
            ("area_share", stated.area_share.unwrap_or(1.0), 1.0),
            ("former_share", stated.former_share.unwrap_or(1.0), 1.0),
        ];
        for (field, number, most) in numbers {
            if !(0.0..=most).contains(&number) {
                return Err(format!("the rule {name}: {field} is {number}, it must be from 0 to {most}"));
            }
        }
        if stated.facing_deg.is_some_and(|facing| facing.iter().any(|azimuth| !(0.0..=360.0).contains(azimuth))) {
            return Err(format!("the rule {name}: facing_deg must hold two azimuths from 0 to 360"));
        }
        let threshold = match (stated.at_least, stated.at_most) {
            (Some(least), None) => Threshold::AtLeast(least),
            (None, Some(most)) => Threshold::AtMost(most),
            _ => return Err(format!("the rule {name}: give either at_least or at_most")),
        };
        if matches!(threshold, Threshold::AtMost(_)) && stated.former_share.is_some() {
            return Err(format!("the rule {name}: former_share applies to at_least, not to at_most"));
        }
        let has_angles = stated.least_deflection_deg.is_some() || stated.view_angle_deg.is_some();
        if has_angles && !stated.measure.is_of_mirrors() {
            return Err(format!(
                "the rule {name}: least_deflection_deg and view_angle_deg apply only to glare_minutes"
            ));
        }
        if stated.least_angle_deg > 0.0 && stated.measure.is_of_mirrors() {
            return Err(format!(
                "the rule {name}: least_angle_deg does not apply to glare_minutes, give view_angle_deg"
            ));
        }
        let angles = GlareAngles {
            least_deflection_deg: stated.least_deflection_deg.unwrap_or(GlareAngles::ALL.least_deflection_deg),
            view_angle_deg: stated.view_angle_deg.unwrap_or(GlareAngles::ALL.view_angle_deg),
        };
        let part = match (stated.lit_share, stated.area_share) {
            (Some(_), Some(_)) => return Err(format!("the rule {name}: give lit_share or area_share, not both")),
            (Some(share), None) => LitPart::AtATime(share),
            (None, Some(share)) => LitPart::InTurn(share),
            (None, None) => LitPart::Middle,
        };
        let hours = match (stated.from, stated.to) {
            (None, None) => None,
            (Some(from), Some(to)) if from.0 < to.0 => {
                Some(ClockHours { from_min: from.0, to_min: to.0, clock: stated.clock })
            }
            _ => return Err(format!("the rule {name}: give from and to, the earlier time first")),
        };
        if stated.measure == RuleMeasure::VscPercent && !(stated.dates.is_empty() && hours.is_none()) {
            return Err(format!("the rule {name}: vsc_percent has no dates and no hours, leave them out"));
        }
        if stated.measure == RuleMeasure::VscPercent && matches!(part, LitPart::AtATime(_)) {
            return Err(format!("the rule {name}: vsc_percent has no lit_share, give area_share"));
        }
        if stated.measure == RuleMeasure::ProbablePercent && stated.days != DaysTogether::Sum {
            return Err(format!("the rule {name}: probable_percent counts all days together: give days = \"sum\""));
        }
        Ok(Rule {
            name,
            title: stated.title,
            source: stated.source,
            unconfirmed: stated.unconfirmed,
            dates: stated.dates,
            days: stated.days,
            measure: stated.measure,
            threshold,
            hours,
            least_altitude_deg: stated.least_altitude_deg,
            least_spell_min: stated.least_spell_minutes,
            least_angle_deg: stated.least_angle_deg,
            angles,
            kinds: stated.kinds,
            facing_deg: stated.facing_deg,
            part,
            former_share: stated.former_share,
        })
    }
}

impl Rule {
    /// Returns what results state of the rule: its name, its requirement, where that is written,
    /// and what could not be confirmed.
    pub fn stated(&self) -> Value {
        let Rule { name, title, source, unconfirmed, .. } = self;
        json!({ "name": name, "title": title, "source": source, "unconfirmed": unconfirmed })
    }

    /// Returns true if the rule needs days of sun, its own or those of the request.
    pub fn needs_days(&self) -> bool {
        self.measure != RuleMeasure::VscPercent
    }

    /// Returns true if the rule applies to surfaces of a kind that face an azimuth. A receiver
    /// without a kind passes any list of kinds; a level roof has no azimuth and passes no range of
    /// azimuths.
    pub fn is_about(&self, kind: &str, azimuth_deg: Option<f64>) -> bool {
        let is_kind = self.kinds.is_empty() || kind.is_empty() || self.kinds.iter().any(|one| one == kind);
        let faces = |[from, to]: [f64; 2], azimuth: f64| match from <= to {
            true => (from..=to).contains(&azimuth),
            false => azimuth >= from || azimuth <= to,
        };
        is_kind && self.facing_deg.is_none_or(|facing| azimuth_deg.is_some_and(|azimuth| faces(facing, azimuth)))
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", if self.title.is_empty() { &self.name } else { &self.title })
    }
}
