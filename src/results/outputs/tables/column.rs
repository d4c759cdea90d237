//! Columns of a table. In: names, types of values. Out: the header that every format writes before
//! the first row.
//!
//! Rows come place by place; a place is a receiver, a group or a point. A table may have steps,
//! such as hours or positions of the sun. Each place then has a row for each step, and the columns
//! of the steps are the same for all places.

use crate::outputs::tables::bin_labels::{BinLabels, Instants};

/// Column of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    pub name: String,
    pub unit: Option<&'static str>,
    pub kind: Kind,
    pub along: Along,
}

/// Type of the values of a column, and their form in files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Text,
    /// Text with few distinct values, all known before the first row: some formats keep it as a
    /// dictionary.
    Category,
    Count,
    /// Number of 64 bits; a cell may be empty.
    Number(Digits),
    /// Number of 32 bits; no cell is empty.
    Float(Digits),
}

/// Digits of a number in text formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Digits {
    /// Fixed number of decimals.
    Decimals(usize),
    /// Three decimals; zero is `0`.
    Thousandths,
    /// Six significant digits in plain notation down to 1e-9; zero is `0`.
    Six,
    /// Fewest digits that distinguish the number from all others.
    Fewest,
}

/// Largest number of decimals of [`Digits::Six`].
const MAX_DECIMALS: f64 = 14.0;

impl Digits {
    /// Returns the decimals of a number in text formats; `None` if it has as many as it needs.
    pub fn decimals(self, value: f64) -> Option<usize> {
        match self {
            Digits::Decimals(count) => Some(count),
            Digits::Thousandths => Some(3),
            Digits::Six if value == 0.0 => Some(0),
            Digits::Six => Some((5.0 - value.abs().log10().floor()).clamp(0.0, MAX_DECIMALS) as usize),
            Digits::Fewest => None,
        }
    }
}

/// Dimension along which the values of a column change.
#[derive(Clone, Debug, PartialEq)]
pub enum Along {
    /// Rows: each row has a value of its own.
    Rows,
    /// Places: each place has one text, which stands in all of its rows.
    Places,
    /// Steps: each step has one value for all places, known before the first row.
    Bins(BinValues),
}

/// Values of a column along the steps.
#[derive(Clone, Debug, PartialEq)]
pub enum BinValues {
    /// Times, or text.
    Labels(BinLabels),
    Numbers(Vec<f64>),
}

impl Column {
    fn new(name: impl Into<String>, unit: Option<&'static str>, kind: Kind) -> Self {
        Column { name: name.into(), unit, kind, along: Along::Rows }
    }

    /// Returns a column with a text in each row.
    pub fn text(name: impl Into<String>) -> Self {
        Column::new(name, None, Kind::Text)
    }

    /// Returns a column with an integer in each row; the unit follows from its name.
    pub fn count(name: impl Into<String>) -> Self {
        Column::counted(name.into(), Kind::Count)
    }

    /// Returns a column with a number in each row, which may be missing; the unit follows from its
    /// name.
    pub fn number(name: impl Into<String>, decimals: usize) -> Self {
        Column::number_as(name, Digits::Decimals(decimals))
    }

    /// Returns a column with a number of these digits in each row; the unit follows from its name.
    pub fn number_as(name: impl Into<String>, digits: Digits) -> Self {
        Column::counted(name.into(), Kind::Number(digits))
    }

    /// Returns a column with a number of 32 bits in each row; the unit follows from its name.
    pub fn float(name: impl Into<String>, digits: Digits) -> Self {
        Column::counted(name.into(), Kind::Float(digits))
    }

    fn counted(name: String, kind: Kind) -> Self {
        let unit = unit_of(&name);
        Column::new(name, unit, kind)
    }

    /// Returns the column of the names of places; `kind` is text or categories.
    pub fn of_places(name: impl Into<String>, kind: Kind) -> Self {
        Column { along: Along::Places, ..Column::new(name, None, kind) }
    }

    /// Returns a column of the labels of steps; `kind`, text or categories, applies to labels that
    /// are no times.
    pub fn of_bins(name: impl Into<String>, kind: Kind, labels: &BinLabels) -> Self {
        Column { along: Along::Bins(BinValues::Labels(labels.clone())), ..Column::new(name, None, kind) }
    }

    /// Returns a column of 32-bit numbers that identify the steps; the unit follows from its name.
    pub fn numbers_of_bins(name: impl Into<String>, numbers: Vec<f64>) -> Self {
        let column = Column::counted(name.into(), Kind::Float(Digits::Fewest));
        Column { along: Along::Bins(BinValues::Numbers(numbers)), ..column }
    }

    /// Returns the column with a unit that does not follow from its name.
    pub fn with_unit(self, unit: &'static str) -> Self {
        Column { unit: Some(unit), ..self }
    }

    /// Returns the labels of steps.
    pub fn bin_labels(&self) -> Option<&BinLabels> {
        match &self.along {
            Along::Bins(BinValues::Labels(labels)) => Some(labels),
            _ => None,
        }
    }

    /// Returns the labels of steps as instants, if they are times.
    pub fn instants(&self) -> Option<&Instants> {
        self.bin_labels().and_then(|labels| labels.instants.as_ref())
    }

    /// Returns true if the values belong to steps.
    pub fn is_of_bins(&self) -> bool {
        matches!(self.along, Along::Bins(_))
    }

    /// Returns true if the values are texts, not times.
    pub fn is_text(&self) -> bool {
        matches!(self.kind, Kind::Text | Kind::Category) && self.instants().is_none()
    }

    /// Returns true if each row has a number of its own.
    pub fn is_value(&self) -> bool {
        self.along == Along::Rows && !self.is_text()
    }
}

/// Columns of a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TableColumns {
    all: Vec<Column>,
    steps: Option<usize>,
}

impl TableColumns {
    /// Returns columns in the order of the file. All columns along steps must have as many values
    /// as the first of them.
    pub fn new(all: Vec<Column>) -> Self {
        let steps = all.iter().find_map(|column| match &column.along {
            Along::Bins(BinValues::Labels(labels)) => Some(labels.len()),
            Along::Bins(BinValues::Numbers(numbers)) => Some(numbers.len()),
            Along::Rows | Along::Places => None,
        });
        TableColumns { all, steps }
    }

    /// Returns the columns in order.
    pub fn all(&self) -> &[Column] {
        &self.all
    }

    /// Returns the number of rows of a place.
    pub fn rows_of_place(&self) -> usize {
        self.steps.unwrap_or(1)
    }

    /// Returns true if places have steps, even a single one.
    pub fn has_steps(&self) -> bool {
        self.steps.is_some()
    }

    /// Returns the columns whose values come in batches: all but those along steps.
    pub fn in_batches(&self) -> impl Iterator<Item = &Column> + '_ {
        self.all.iter().filter(|column| !column.is_of_bins())
    }

    /// Returns the column of the names of places: the first text column along places or rows.
    pub fn of_places(&self) -> Option<&Column> {
        self.in_batches().find(|column| column.is_text())
    }
}

/// Units by the ending of a column's name, or by the whole name; longer endings first.
const UNITS: [(&str, &str); 17] = [
    ("_minutes", "min"),
    ("_kwh_m2", "kWh/m2"),
    ("_kwh", "kWh"),
    ("_w_m2", "W/m2"),
    ("_mwh", "MWh"),
    ("_percent", "%"),
    ("_cpu_s", "s"),
    ("_deg", "deg"),
    ("_mol_m2_d", "mol/(m2 d)"),
    ("_mol_m2", "mol/m2"),
    ("_m2", "m2"),
    ("_m", "m"),
    ("_view", "1"),
    ("leaf_area_index", "1"),
    ("area", "m2"),
    ("bytes", "byte"),
    ("receivers", "1"),
];

/// Units of columns with positions in metres, and with normals.
const PLACES: [(&str, &str); 6] = [("x", "m"), ("y", "m"), ("z", "m"), ("nx", "1"), ("ny", "1"), ("nz", "1")];

/// Returns the unit that follows from a column's name.
fn unit_of(name: &str) -> Option<&'static str> {
    let place = PLACES.iter().find(|(place, _)| *place == name);
    place.or_else(|| UNITS.iter().find(|(ending, _)| name.ends_with(ending))).map(|(_, unit)| *unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twelve names of columns give their units.
    #[test]
    fn names_of_columns_give_their_units() {
        for (name, unit) in [
            ("total_kwh_m2", Some("kWh/m2")),
            ("dni_w_m2", Some("W/m2")),
            ("ppfd_mol_m2", Some("mol/m2")),
            ("dli_mol_m2_d", Some("mol/(m2 d)")),
            ("error_percent", Some("%")),
            ("area", Some("m2")),
            ("x", Some("m")),
            ("nz", Some("1")),
            ("sky_view", Some("1")),
            ("distance_m", Some("m")),
            ("receiver", None),
            ("index", None),
        ] {
            assert_eq!(Column::number(name, 3).unit, unit, "{name}");
        }
    }

    /// A table of 3 positions of the sun has 3 rows a place and one column of names in its batches;
    /// a table without steps has 1 row a place.
    #[test]
    fn a_table_of_3_suns_has_3_rows_a_place() {
        let suns = Column::numbers_of_bins("sun_altitude_deg", vec![0.0, 45.0, 90.0]);
        let columns = TableColumns::new(vec![Column::of_places("receiver", Kind::Text), suns]);
        assert_eq!((columns.rows_of_place(), columns.has_steps(), columns.in_batches().count()), (3, true, 1));
        let columns = TableColumns::new(vec![Column::number("x", 3), Column::text("face")]);
        assert_eq!((columns.rows_of_place(), columns.has_steps()), (1, false));
        assert_eq!(columns.of_places().map(|column| column.name.as_str()), Some("face"));
    }
}
