//! Values of the library's types by their names on the command line.

use heliotile_builder::settings::{Quality, Share};
use heliotile_core::archive::Access;
use heliotile_core::error::Error;
use heliotile_core::replay::reflectances::Snow;
use heliotile_core::weather::options::{DateOrder, StampedAt};

use crate::outputs::periods::Every;
use crate::outputs::tables::format::Format;
use crate::outputs::tables::layout::By;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// A type with a few values that have names.
pub trait NamedValues: Clone + Send + Sync + 'static {
    /// Name on the command line, meaning, value.
    const VALUES: &'static [(&'static str, &'static str, Self)];
}

/// Takes one of the names.
pub fn choice<T: NamedValues>() -> impl TypedValueParser<Value = T> {
    let values = T::VALUES.iter().map(|(name, meaning, _)| PossibleValue::new(*name).help(*meaning));
    PossibleValuesParser::new(values).try_map(|given| {
        let found = T::VALUES.iter().find(|(name, _, _)| *name == given);
        found.map(|(_, _, value)| value.clone()).ok_or("not one of the names")
    })
}

/// The value of a name, for those who have no command line; `argument` is what messages call it.
pub fn by_name<T: NamedValues>(argument: &str, name: &str) -> Result<T, Error> {
    let found = T::VALUES.iter().find(|(known, _, _)| *known == name);
    found.map(|(_, _, value)| value.clone()).ok_or_else(|| {
        let names: Vec<&str> = T::VALUES.iter().map(|(name, ..)| *name).collect();
        Error::argument(argument, format!("`{name}` is none of its values"), format!("give {}", names.join(", ")))
    })
}

/// Name of a value on the command line.
pub fn name_of<T: NamedValues + PartialEq>(value: &T) -> &'static str {
    T::VALUES.iter().find(|(.., other)| other == value).map_or("", |(name, ..)| name)
}

/// Takes the ending of a table, which chooses its format.
pub fn table_endings() -> PossibleValuesParser {
    PossibleValuesParser::new(Format::ENDINGS.map(|(ending, ..)| ending))
}

/// Help of an option that names a table to write: what the table is, and the endings of its name.
pub fn table_help(table: &str) -> String {
    format!("{table}: {}", Format::described())
}

impl NamedValues for Access {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("map", "Through a mapping: fastest once the file is in memory", Access::Mapped),
        ("pread", "By reads at a position: for files that others may shorten, and network file systems", Access::Read),
    ];
}

impl NamedValues for StampedAt {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        (StampedAt::Start.name(), "The interval starts there", StampedAt::Start),
        (StampedAt::Middle.name(), "It is the middle of the interval", StampedAt::Middle),
        (StampedAt::End.name(), "The interval ends there", StampedAt::End),
    ];
}

impl NamedValues for DateOrder {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        (DateOrder::Dmy.name(), "Day, month, year: 31/12/2021", DateOrder::Dmy),
        (DateOrder::Mdy.name(), "Month, day, year: 12/31/2021", DateOrder::Mdy),
        (DateOrder::Ymd.name(), "Year, month, day: 21/12/31", DateOrder::Ymd),
    ];
}

impl NamedValues for Snow {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("depth", "The snow's reflectance wherever the snow depth is 1 cm or more", Snow::Depth),
        ("albedo", "The column `albedo`, wherever it has a value", Snow::Albedo),
    ];
}

impl NamedValues for Quality {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("draft", "A quick look", Quality::Draft),
        ("standard", "Near the knee of error against time", Quality::Standard),
        ("fine", "For publication", Quality::Fine),
        ("reference", "To judge the others by", Quality::Reference),
    ];
}

impl NamedValues for Share {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("cells", "All receivers that see a cell", Share::Cells),
        ("none", "Nobody: a hemisphere of its own for every hit", Share::None),
    ];
}

impl NamedValues for By {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("receiver", "One row for each receiver", By::Receiver),
        (
            "surface",
            "One for each surface: the mean of its receivers, weighted by their areas, or plain if none has an area",
            By::Surface,
        ),
        ("object", "One for each object of the model: city objects, zones and shades", By::Object),
        ("building", "One for each building, with all of its parts", By::Building),
        ("kind", "One for each kind of surface: roof, wall, window, ground, floor, shade", By::Kind),
    ];
}

impl NamedValues for Every {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("hour", "One row per interval of the weather file: means, W/m2", Every::Hour),
        ("day", "Sums, kWh/m2, as the three below", Every::Day),
        ("month", "", Every::Month),
        ("year", "", Every::Year),
        ("total", "One sum over all that is taken of the file", Every::Total),
    ];
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The five periods are taken by their names and called by them again; `week` is refused.
    #[test]
    fn names() {
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
