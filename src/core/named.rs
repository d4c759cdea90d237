//! Values by their names, which are equal on the command line, in Python and on the page. In: a
//! type with a few values. Out: their names and meanings, the value of a name.

use crate::error::{Error, Result};

pub use heliotile_requests::{Form, Parse, Problem, Wrong};

/// A type with a few values that have names.
pub trait NamedValues: Clone + Send + Sync + 'static {
    /// Name, meaning and value of each.
    const VALUES: &'static [(&'static str, &'static str, Self)];
}

/// Returns the value of a name; `argument` is the field that an error names.
pub fn by_name<T: NamedValues>(argument: &str, name: &str) -> Result<T> {
    of_name(name).map_err(|wrong: Wrong| Error::argument(argument, wrong.what, wrong.hint).because(wrong.problem))
}

/// Returns the value of a name, or a sentence that lists the known names.
pub fn of_name<T: NamedValues>(name: &str) -> std::result::Result<T, Wrong> {
    let found = T::VALUES.iter().find(|(known, _, _)| *known == name);
    found
        .map(|(_, _, value)| value.clone())
        .ok_or_else(|| Wrong::unknown(name, T::VALUES.iter().map(|(name, ..)| *name)))
}

/// Returns the name of a value.
pub fn name_of<T: NamedValues + PartialEq>(value: &T) -> &'static str {
    T::VALUES.iter().find(|(.., other)| other == value).map_or("", |(name, ..)| name)
}

/// Implements [`Parse`] for a type with [`NamedValues`].
#[macro_export]
macro_rules! parse_by_name {
    ($($type:ty),+ $(,)?) => {$(
        impl $crate::named::Parse for $type {
            fn form() -> $crate::named::Form {
                $crate::named::Form { choices: $crate::named::choices::<$type>, ..$crate::named::Form::TEXT }
            }

            fn parse(text: &str) -> ::std::result::Result<Self, $crate::named::Wrong> {
                $crate::named::of_name(text)
            }
        }
    )+};
}

/// Returns names and meanings of the values of a type.
pub fn choices<T: NamedValues>() -> Vec<(&'static str, &'static str)> {
    T::VALUES.iter().map(|(name, meaning, _)| (*name, *meaning)).collect()
}

/// Implements serde for a type with [`NamedValues`]: a value is its name.
#[macro_export]
macro_rules! serde_by_name {
    ($($type:ty),+) => {$(
        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
                serializer.serialize_str($crate::named::name_of(self))
            }
        }

        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
                let name = <String as serde::Deserialize>::deserialize(deserializer)?;
                $crate::named::of_name(&name).map_err(serde::de::Error::custom)
            }
        }
    )+};
}

/// Implements serde for a type that is written and read as text, by `Display` and `FromStr`.
#[macro_export]
macro_rules! serde_by_text {
    ($($type:ty),+) => {$(
        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }

        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
                let text = <String as serde::Deserialize>::deserialize(deserializer)?;
                text.parse().map_err(serde::de::Error::custom)
            }
        }
    )+};
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::weather::options::StampedAt;

    /// The three places of a time stamp come back from their names. The error for `noon` lists all
    /// three.
    #[test]
    fn values_come_back_from_their_names() {
        for at in [StampedAt::Start, StampedAt::Middle, StampedAt::End] {
            assert_eq!(by_name::<StampedAt>("weather_stamp", name_of(&at)).ok(), Some(at));
        }
        let refused = by_name::<StampedAt>("weather_stamp", "noon").expect_err("no such place").to_string();
        assert!(refused.contains("`noon`") && refused.contains("give one of start, middle, end"), "{refused}");
    }
}
