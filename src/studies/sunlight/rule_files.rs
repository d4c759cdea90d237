//! Rules in files. In: the name of a shipped file, or the path of a user's file. Out: rules.

use std::path::Path;

use serde::Deserialize;

use super::rule::Rule;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_files::input;
use heliotile_scene::materials::select::nearest;
use heliotile_scene::read_toml;

/// Files of rules that come with the program: their names and texts.
const SHIPPED: [(&str, &str); 11] = [
    ("bre-apsh", include_str!("rules/bre-apsh.toml")),
    ("bre-ground", include_str!("rules/bre-ground.toml")),
    ("bre-vsc", include_str!("rules/bre-vsc.toml")),
    ("din-5034", include_str!("rules/din-5034.toml")),
    ("en-17037", include_str!("rules/en-17037.toml")),
    ("gb-50180", include_str!("rules/gb-50180.toml")),
    ("lai", include_str!("rules/lai.toml")),
    ("nsw-adg", include_str!("rules/nsw-adg.toml")),
    ("the-hague", include_str!("rules/the-hague.toml")),
    ("tno-light", include_str!("rules/tno-light.toml")),
    ("tno-strict", include_str!("rules/tno-strict.toml")),
];

/// Hint that says what a file of rules may hold.
const KEYS: &str = "give tables [[rule]] with a name, dates, at_least and other keys as in the shipped rules ({command:info --rule} NAME shows them)";

/// Contents of a file of rules.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RuleFile {
    rule: Vec<Rule>,
}

/// File of rules that comes with the program.
#[derive(Clone, Debug)]
pub struct ShippedRules {
    /// Name of the file in requests.
    pub name: &'static str,
    /// Text of the file, TOML.
    pub text: &'static str,
    /// Rules of the file.
    pub rules: Vec<Rule>,
}

/// Returns the files that come with the program, by name.
pub fn shipped_rules() -> Result<Vec<ShippedRules>> {
    let file = |(name, text): (&'static str, &'static str)| {
        Ok(ShippedRules { name, text, rules: rules_of(Path::new(name), text)? })
    };
    SHIPPED.into_iter().map(file).collect()
}

/// Returns the shipped file of a name, or the one that holds the rule of this name.
pub fn shipped_with(name: &str) -> Result<ShippedRules> {
    let shipped = shipped_rules()?;
    let holds = |file: &ShippedRules| file.name == name || file.rules.iter().any(|rule| rule.name == name);
    let names: Vec<&str> = shipped.iter().map(|file| file.name).collect();
    let near = nearest(name, &names).map_or(String::new(), |near| format!("did you mean {near}? else "));
    let hint = format!("{near}give {}, or a file of your own that ends with .toml", names.join(", "));
    let unknown = Problem::unknown(name, names);
    let found = shipped.into_iter().find(holds);
    found.ok_or_else(|| Error::argument("rule", format!("`{name}` is not a known rule"), hint).because(unknown))
}

/// Returns the files among the names of rules: those that end with .toml.
pub fn own_rules(names: &[String]) -> impl Iterator<Item = &Path> {
    names.iter().filter(|name| name.ends_with(".toml")).map(Path::new)
}

/// Reads the rules of files, given by the names of shipped ones, of single rules in them, or by
/// paths that end with .toml.
pub fn read_rules(names: &[String]) -> Result<Vec<Rule>> {
    let mut all: Vec<Rule> = Vec::new();
    for name in names {
        let (path, text) = match SHIPPED.iter().find(|(shipped, _)| shipped == name) {
            Some((_, text)) => (Path::new(name), (*text).to_owned()),
            None if name.ends_with(".toml") => {
                let path = Path::new(name);
                (path, String::from_utf8_lossy(&input::read(path)?).into_owned())
            }
            None => (Path::new(name), shipped_with(name)?.text.to_owned()),
        };
        let rules = rules_of(path, &text)?;
        // The name of a rule, unless it is that of a file, stands for this rule alone.
        let is_file = SHIPPED.iter().any(|(shipped, _)| shipped == name);
        let is_one = !is_file && rules.iter().any(|rule| rule.name == *name);
        for rule in rules.into_iter().filter(|rule| !is_one || rule.name == *name) {
            if let Some(same) = all.iter().find(|other| other.name == rule.name) {
                let what = format!("two rules are named `{}`", same.name);
                return Err(Error::input(path, None, what, "give each rule a name of its own, and each file once"));
            }
            all.push(rule);
        }
    }
    Ok(all)
}

fn rules_of(path: &Path, text: &str) -> Result<Vec<Rule>> {
    let file: RuleFile = read_toml(path, text, KEYS)?;
    match file.rule.is_empty() {
        true => Err(Error::input(path, None, "holds no rule", KEYS)),
        false => Ok(file.rule),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each of the 11 shipped files can be read, each of its rules states its requirement and
    /// source, and their names differ.
    #[test]
    fn shipped_rules_are_read() {
        let names: Vec<String> = SHIPPED.iter().map(|(name, _)| (*name).to_owned()).collect();
        let rules = read_rules(&names).expect("rules");
        assert!(rules.len() > 12, "{}", rules.len());
        assert!(rules.iter().all(|rule| !rule.title.is_empty() && !rule.source.is_empty()));
    }

    /// Thirteen wrong rules are refused with their line and a message that names the mistake.
    #[test]
    fn wrong_rules_are_refused_with_their_line() {
        for (lines, says) in [
            ("at_least = 120", "missing field `name`"),
            ("name = \"a\"", "give either at_least or at_most"),
            ("name = \"a\"\nat_least = 1\nat_most = 2", "give either at_least or at_most"),
            ("name = \"a\"\nat_most = 1\nview_angle_deg = 20", "apply only to glare_minutes"),
            ("name = \"My rule\"\nat_least = 1", "cannot name a rule"),
            ("name = \"a\"\nat_least = -1", "at_least is -1"),
            ("name = \"a\"\nat_least = 1\nfrom = \"9\"\nto = \"15:00\"", "`9` is not a time of day"),
            ("name = \"a\"\nat_least = 1\nfrom = \"15:00\"\nto = \"09:00\"", "the earlier time first"),
            ("name = \"a\"\nat_least = 1\ndates = [\"03-32\"]", "`03-32` is not a day"),
            ("name = \"a\"\nat_least = 1\nlit_share = 0.5\narea_share = 0.5", "not both"),
            ("name = \"a\"\nat_least = 1\nhours = 2", "unknown field `hours`"),
            ("name = \"a\"\nat_least = 1\nclock = \"summer\"", "give one of standard, legal, solar"),
            ("name = \"a\"\nat_least = 25\nmeasure = \"vsc_percent\"\ndates = [\"03-21\"]", "no dates"),
        ] {
            let text = format!("\n[[rule]]\n{lines}\n");
            let error = rules_of(Path::new("own.toml"), &text).expect_err(says).to_string();
            assert!(error.contains(says) && error.contains("own.toml, line "), "{says}: {error}");
        }
        let one = read_rules(&["en-17037-minimum".into()]).expect("one rule");
        assert!(one.len() == 1 && one[0].name == "en-17037-minimum", "{one:?}");
        let meant = read_rules(&["bre-grond".into()]).expect_err("a misspelt rule").to_string();
        assert!(meant.contains("did you mean bre-ground?"), "{meant}");
        assert!(read_rules(&["tno".into()]).is_err_and(|error| error.to_string().contains("tno-light")));
        let twice = read_rules(&["tno-light".into(), "tno-light".into()]);
        assert!(twice.is_err_and(|error| error.to_string().contains("two rules")));
    }
}
