//! The command line as files record it. In: the command line. Out: [`Provenance`]: the command
//! without options that change no values, and every option with its value.

use std::ffi::OsString;

use heliotile::Provenance;
use heliotile::cases::{Command, Given, stated};
use heliotile::requests::{Many, Row};
use heliotile::text::without_secrets;

/// Returns the provenance that files state. Paths stay as they were typed.
pub fn provenance(command: &Command, given: &Given) -> Provenance {
    let rows = (command.rows)();
    let mut words = vec!["heliotile".to_owned(), command.name.to_owned()];
    for row in rows.iter().filter(|row| row.is_stated()) {
        let texts = given.iter().find(|(name, _)| name == row.name).map(|(_, texts)| texts);
        texts.into_iter().for_each(|texts| words.extend(typed_words(row, texts)));
    }
    Provenance::new(words.join(" "), stated(&rows, given))
}

/// Returns the command line that resumes stopped work: the same one, without `--fresh`, which would
/// discard what was kept.
pub fn again(words: &[OsString]) -> String {
    let words = words.iter().map(|word| word.to_string_lossy()).filter(|word| word != "--fresh");
    words.map(|word| quoted(&without_secrets(&word))).collect::<Vec<_>>().join(" ")
}

/// Returns a field as words of a command line.
fn typed_words(row: &Row, texts: &[String]) -> Vec<String> {
    let name = format!("--{}", row.name.replace('_', "-"));
    let values = texts.iter().map(|text| quoted(&without_secrets(text)));
    match (row.many, row.positional) {
        (Many::Flag, _) => vec![name],
        (_, true) => values.collect(),
        _ => values.flat_map(|value| [name.clone(), value]).collect(),
    }
}

/// Quotes a word for a shell, if it needs quotes.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,+%@".contains(c);
    match !word.is_empty() && word.chars().all(plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::{command_line, given};
    use serde_json::Value;

    fn entries(line: &str) -> Vec<(String, String)> {
        let matches = command_line().try_get_matches_from(line.split('|')).expect("a command line");
        let (name, inside) = matches.subcommand().expect("a command");
        let command = Command::by_name(name).expect("a command");
        provenance(command, &given(command, inside)).entries()
    }

    /// The recorded command leaves out the output, the memory and the way of reading, and has one
    /// order whatever was typed, with 1 word quoted. Options have their defaults, numbers are
    /// numbers, repeatable options are lists.
    #[test]
    fn a_recorded_command_has_one_order() {
        let one = "heliotile|replay|a b.helio|--year|2019|-w|x.epw|-o|t.csv|--io|map|--reflectance|roof=0.3";
        let other = "heliotile|replay|--reflectance=roof=0.3|--weather=x.epw|a b.helio|--memory|1GiB|--year|2019";
        let entries_of_one = entries(one);
        assert_eq!(entries_of_one, entries(other));
        assert_eq!(
            entries_of_one[1].1,
            "heliotile replay 'a b.helio' --weather x.epw --reflectance roof=0.3 --year 2019"
        );
        let options: Value = serde_json::from_str(&entries_of_one[2].1).expect("JSON");
        assert_eq!((&options["year"], &options["every"]), (&Value::from(2019), &Value::from("hour")));
        assert_eq!(options["reflectance"], Value::from(vec!["roof=0.3"]));
        assert_eq!(options.get("output"), None);
    }

    /// A flag that was typed is `true`; a flag that was not typed is left out.
    #[test]
    fn only_flags_that_were_typed_are_recorded() {
        let options = |line: &str| serde_json::from_str::<Value>(&entries(line)[2].1).expect("JSON");
        let with = options("heliotile|export|site.helio|--view-factors|-o|v.csv");
        assert_eq!(with["view_factors"], Value::Bool(true));
        assert_eq!(options("heliotile|export|site.helio|-r|a|-o|v.png").get("view_factors"), None);
    }

    /// 2 plain words stay, 3 others get quotes that a shell removes again.
    #[test]
    fn words_with_spaces_are_quoted() {
        for word in ["--output=a/b.helio", "5%"] {
            assert_eq!(quoted(word), word);
        }
        for (word, expected) in [("", "''"), ("my town.obj", "'my town.obj'"), ("it's", r"'it'\''s'")] {
            assert_eq!(quoted(word), expected);
        }
    }
}
