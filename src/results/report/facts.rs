//! Facts about a table, in words. In: its provenance and the summary of its rows. Out: the question
//! that it answers, and lines about site, weather, rules, uncertainty and doubts.

use serde::Deserialize;
use serde_json::{Map, Value};

use super::digest::TableDigest;
use crate::outputs::provenance::PREFIX;
use crate::outputs::tables::csvw::DescribedTable;

/// Questions by the command of the program, or the function in Python, that wrote a table.
const QUESTIONS: [(&[&str], &str); 16] = [
    (&["sunlight"], "How long can the sun shine on these places?"),
    (&["glare"], "When do mirrors and glass reflect the sun to these places?"),
    (&["shading"], "Who takes the sun from these places?"),
    (&["replay", "write", "query"], "How much light do these places get?"),
    (&["compare"], "What does the change take from these places, and what does it give them?"),
    (&["comfort"], "How warm is it for people at these places?"),
    (&["buildings"], "Which roofs can be used, and how much sun do they get?"),
    (&["places"], "Where are the best places for solar modules?"),
    (&["pv"], "How much light and energy do these modules get?"),
    (&["run"], "How much sun do these surfaces get in a year?"),
    (&["energyplus factors", "factors"], "How much light do the surroundings reflect to these places?"),
    (&["energyplus"], "How much sun do the surroundings reflect to this model?"),
    (&["export"], "How much sky and ground do these places see?"),
    (&["archive audit", "audit"], "Is the error of the archive as it states?"),
    (&["tradeoff"], "What does accuracy cost on this site?"),
    (&["receivers", "cover"], "Where are the points that get results?"),
];

/// Columns that state how far the values of a row may be off.
const UNCERTAIN: [&str; 2] = ["uncertain", "uncertain_minutes"];

/// Options that choose days and times.
const TIMES: [&str; 5] = ["dates", "from", "to", "year", "every"];

/// Fact: its subject, and what holds.
pub struct Fact {
    /// Subject, such as `Weather`.
    pub subject: &'static str,
    /// Statement about it.
    pub text: String,
}

/// Rule as a table states it.
#[derive(Deserialize)]
struct StatedRule {
    name: String,
    title: String,
    source: String,
    unconfirmed: String,
}

/// Returns a value of the provenance by its name without the prefix.
pub fn value<'a>(table: &'a DescribedTable, name: &str) -> Option<&'a str> {
    let known = table.about.iter().find(|(known, _)| known.strip_prefix(PREFIX) == Some(name));
    known.map(|(_, value)| value.as_str())
}

/// Returns a value of the provenance that is a JSON object; empty if there is none.
pub fn object(table: &DescribedTable, name: &str) -> Map<String, Value> {
    value(table, name).and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default()
}

/// Returns a JSON value in words: lists with commas, texts without quotes.
pub fn words(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(all) => all.iter().map(words).collect::<Vec<_>>().join(", "),
        other => other.to_string(),
    }
}

/// Returns the question that a table answers.
pub fn question(table: &DescribedTable, digest: &TableDigest) -> &'static str {
    if !digest.rules.is_empty() {
        return "Is the rule met?";
    }
    let command = value(table, "command").unwrap_or_default();
    let name = command.trim_start_matches("heliotile").trim_start_matches([' ', '.']).trim_start_matches("Archive.");
    let is_of = |known: &str| name.strip_prefix(known).is_some_and(|rest| rest.is_empty() || rest.starts_with(' '));
    let found = QUESTIONS.iter().find(|(names, _)| names.iter().any(|known| is_of(known)));
    found.map_or("What was computed?", |(_, question)| question)
}

/// Returns what the provenance and the columns say of a table.
pub fn facts(table: &DescribedTable, digest: &TableDigest) -> Vec<Fact> {
    let mut all = Vec::new();
    let mut add = |subject, text: Option<String>| all.extend(text.map(|text| Fact { subject, text }));
    let said = |name: &str| value(table, name).map(str::to_owned);
    let options = object(table, "options");
    add("Site", said("place"));
    add("Archive", said("archive").or(said("atlas")));
    add("Weather", weather(table));
    // Rules have days and periods of their own.
    let times = TIMES.iter().filter(|name| **name != "every" || value(table, "rules").is_none());
    let of_name = |name: &str| if name == "every" { "by".to_owned() } else { name.to_owned() };
    let times = times.filter_map(|name| Some(format!("{} {}", of_name(name), words(options.get(*name)?))));
    add("Time", Some(times.collect::<Vec<_>>().join(", ")).filter(|text| !text.is_empty()));
    add("Clock", said("clock").or(said("utc_offset")).map(|clock| clock_words(&clock)));
    let rules: Vec<StatedRule> =
        value(table, "rules").and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default();
    for rule in &rules {
        let source = if rule.source.is_empty() { String::new() } else { format!(" Source: {}.", rule.source) };
        add("Rule", Some(format!("{}: {}.{source}", rule.name, rule.title)));
    }
    add("Uncertainty", Some(uncertainty(table, digest)));
    add("Assumed", options.contains_key("trees").then(|| clear_sky(&options)));
    add("Doubt", said("left_out").map(|text| format!("The archive leaves out {text}.")));
    for rule in rules.iter().filter(|rule| !rule.unconfirmed.is_empty()) {
        add("Doubt", Some(format!("Not confirmed of {}: {}", rule.name, rule.unconfirmed)));
    }
    all
}

/// Returns a zone in words: hours ahead of UTC get that name in front.
fn clock_words(zone: &str) -> String {
    if zone.starts_with(['+', '-']) { format!("UTC{zone}") } else { zone.to_owned() }
}

fn weather(table: &DescribedTable) -> Option<String> {
    let place = value(table, "weather_place").filter(|place| !place.is_empty());
    let place = place.map_or(String::new(), |place| format!(", {place}"));
    let [latitude, longitude] = ["weather_latitude_deg", "weather_longitude_deg"].map(|name| value(table, name));
    let at = latitude.zip(longitude);
    let at = at.map_or(String::new(), |(latitude, longitude)| format!(", latitude {latitude}, longitude {longitude}"));
    value(table, "weather").map(|file| format!("{file}{place}{at}"))
}

/// Returns how far values may be off, or that nothing states it.
fn uncertainty(table: &DescribedTable, digest: &TableDigest) -> String {
    let stated =
        table.columns.iter().zip(&digest.columns).filter(|(column, _)| UNCERTAIN.contains(&column.name.as_str()));
    let most: Vec<String> = stated
        .map(|(column, found)| {
            let most = match &found.range {
                Some([_, greatest]) => format!(": at most {greatest} {}", column.unit),
                None => ", in the unit of its rule".to_owned(),
            };
            format!("The column {} says how far each value may be off{most}", column.name)
        })
        .collect();
    match value(table, "stated_error") {
        _ if !most.is_empty() => {
            let close = " A verdict is close if the threshold lies within that.";
            let close = if digest.rules.is_empty() { "" } else { close };
            let most: Vec<String> = most.iter().map(|text| format!("{}.", text.trim_end())).collect();
            most.join(" ") + close
        }
        Some(error) => format!("Error that the archive states of irradiance: {error}."),
        None => "Neither the table nor the archive states one. An archive that is built for an error states it.".into(),
    }
}

/// Returns the assumptions of hours of possible sun.
fn clear_sky(options: &Map<String, Value>) -> String {
    let trees = options.get("trees").map(words).unwrap_or_default();
    let trees = match trees.as_str() {
        "ignore" => "Trees and screens do not hide the sun.".to_owned(),
        other => format!("Trees and screens: {other}."),
    };
    format!("Possible sun: no clouds, unless a rule counts sunny hours of a weather file. {trees}")
}
