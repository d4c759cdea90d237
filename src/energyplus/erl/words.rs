//! Words of the EnergyPlus runtime language. In: names of a model, numbers. Out: free names, and
//! numbers without a minus sign.

/// Prefix of the names of all added objects.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Names(String);

impl Names {
    /// Returns the first prefix of `HT1_`, `HT2_` ... that no name in `taken` begins with, in any
    /// case of letters.
    pub fn free<'a>(taken: impl Iterator<Item = &'a str>) -> Names {
        let taken: Vec<String> = taken.map(str::to_uppercase).collect();
        let free = (1_u32..).map(|number| format!("HT{number}_"));
        Names(free.into_iter().find(|prefix| !taken.iter().any(|name| name.starts_with(prefix))).unwrap_or_default())
    }

    /// Returns the name `what` with the prefix.
    pub fn of(&self, what: &str) -> String {
        format!("{}{what}", self.0)
    }
}

/// Writes a number in the runtime language, which takes no minus sign behind an operator.
pub(super) fn signed(value: f64) -> String {
    let digits = format!("{:.6}", value.abs());
    let digits = digits.trim_end_matches('0').trim_end_matches('.');
    if value < 0.0 && digits != "0" { format!("(0 - {digits})") } else { digits.into() }
}
