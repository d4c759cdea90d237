//! Values of the library's types by name. In: names on the command line. Out: values.

use heliotile::names::NamedValues;
use heliotile::output::Format;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// Parses one of the names of a type's values.
pub fn choice<T: NamedValues>() -> impl TypedValueParser<Value = T> {
    let values = T::VALUES.iter().map(|(name, meaning, _)| PossibleValue::new(*name).help(*meaning));
    PossibleValuesParser::new(values).try_map(|given| {
        let found = T::VALUES.iter().find(|(name, _, _)| *name == given);
        found.map(|(_, _, value)| value.clone()).ok_or("not one of the names")
    })
}

/// Parses the extension of a table, which chooses its format.
pub fn table_endings() -> PossibleValuesParser {
    PossibleValuesParser::new(Format::ENDINGS.map(|(ending, ..)| ending))
}

/// Returns the help of an option that names a table to write: the subject of the table, and the
/// extensions of its name.
pub fn table_help(table: &str) -> String {
    format!("{table}: {}", Format::described())
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile::Every;
    use heliotile::names::name_of;

    /// The five periods are parsed from their names and print them again; `week` is refused.
    #[test]
    fn five_periods_are_parsed_by_name() {
        let command = clap::Command::new("heliotile").arg(clap::Arg::new("every").value_parser(choice::<Every>()));
        let taken =
            |name: &str| Some(*command.clone().try_get_matches_from(["heliotile", name]).ok()?.get_one("every")?);
        for (name, every) in [
            ("hour", Every::Hour),
            ("day", Every::Day),
            ("month", Every::Month),
            ("year", Every::Year),
            ("total", Every::Total),
        ] {
            assert_eq!((taken(name), name_of(&every)), (Some(every), name));
        }
        assert_eq!(taken("week"), None);
    }
}
