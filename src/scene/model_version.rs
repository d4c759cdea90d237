//! Versions of EnergyPlus. In: the version that a model states, or one that is assumed. Out: a
//! number that decides the meaning of its fields.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

/// A version of EnergyPlus, such as 25.2.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ModelVersion {
    /// Year of the version since 22.1, 8 or 9 before.
    pub major: u16,
    /// Release within the year.
    pub minor: u16,
}

/// Oldest version whose fields are known: in older versions fields may stand elsewhere.
const OLDEST: ModelVersion = ModelVersion { major: 8, minor: 0 };

impl ModelVersion {
    /// Newest version whose fields are known.
    pub const KNOWN: ModelVersion = ModelVersion { major: 25, minor: 2 };

    /// Reads "25.2", "9.6.0" or "8".
    pub fn parse(text: &str) -> Option<ModelVersion> {
        let mut parts = text.trim().split('.');
        let major = parts.next()?.trim().parse().ok()?;
        let minor = parts.next().map_or(Some(0), |part| part.trim().parse().ok())?;
        Some(ModelVersion { major, minor })
    }
}

impl fmt::Display for ModelVersion {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}.{}", self.major, self.minor)
    }
}

impl FromStr for ModelVersion {
    type Err = String;

    fn from_str(text: &str) -> Result<ModelVersion, String> {
        let known = ModelVersion::parse(text).filter(|version| *version <= ModelVersion::KNOWN);
        known.ok_or_else(|| format!("give a version of EnergyPlus up to {}, such as 9.6", ModelVersion::KNOWN))
    }
}

/// Returns a warning about the version that a model states, if one is needed.
pub(crate) fn doubt(stated: Option<ModelVersion>, file: &Path) -> Option<String> {
    let file = file.display();
    match stated {
        None => Some(format!("{file}: states no version of EnergyPlus; the newest one is assumed")),
        Some(version) if version < OLDEST => Some(format!(
            "{file}: was written for EnergyPlus {version}; fields of versions before {OLDEST} may be misread: upgrade it with the \
             Transition tool"
        )),
        Some(version) if version > ModelVersion::KNOWN => Some(format!(
            "{file}: was written for EnergyPlus {version}, but fields are read as in {}, the newest known version: compare its areas with \
             those of EnergyPlus",
            ModelVersion::KNOWN
        )),
        Some(_) => None,
    }
}

heliotile_requests::parse_by_text!(ModelVersion: heliotile_requests::Form::TEXT);

heliotile_core::serde_by_text!(ModelVersion);

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// Versions 7.2, 26.1 and a missing one, 3 of 6, get a warning; 4 of 7 texts are a version that
    /// may be assumed.
    #[test]
    fn unknown_versions_get_a_warning() {
        let doubted = |text: &str| doubt(ModelVersion::parse(text), Path::new("m.idf"));
        for (text, word) in
            [("7.2", "before 8.0"), ("26.1", "was written for EnergyPlus 26.1"), ("", "states no version")]
        {
            assert!(doubted(text).is_some_and(|said| said.contains(word)), "{text}: {:?}", doubted(text));
        }
        for text in ["8.0", "24.2.0", "25.2"] {
            assert_eq!(doubted(text), None);
        }
        let texts = ["25.2", "9.6.0", "8", " 24.1 ", "26.1", "x", "25,2"];
        assert_eq!(texts.iter().filter(|text| text.parse::<ModelVersion>().is_ok()).count(), 4);
    }
}
