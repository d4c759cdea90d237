//! Summary of a table. In: its rows, one by one. Out: verdicts by rule, the range of each column,
//! and the rows that a page shows. Only these rows are kept in memory.

use std::collections::BTreeMap;

use crate::outputs::quantities::Verdict;
use crate::outputs::tables::csvw::{DescribedColumn, DescribedTable};
use heliotile_core::error::{Problem, Result};
use heliotile_files::csv_rows::CsvRows;

/// Columns that name no place, so that rows are not sorted by them.
const NO_PLACES: [&str; 6] = ["rule", "date", "time", "condition", "verdict", "verdict_before"];

/// Summary of a table.
pub struct TableDigest {
    /// Number of rows.
    pub rows: u64,
    /// Verdicts on each rule, in the order of the table; empty if it has none.
    pub rules: Vec<RuleVerdicts>,
    /// Summaries of columns, in order.
    pub columns: Vec<ColumnDigest>,
    /// Rows to show, sorted.
    pub shown: Vec<Vec<String>>,
}

/// Numbers of places by the verdict of a rule.
pub struct RuleVerdicts {
    /// Name of the rule.
    pub rule: String,
    /// `[verdict]`, as in [`Verdict::ALL`], and last the number of places without one.
    counts: [u64; Verdict::ALL.len() + 1],
    /// Number of places that break the rule, and did not before a change.
    newly_broken: u64,
}

/// Summary of a column.
#[derive(Default)]
pub struct ColumnDigest {
    /// First cell that is not empty.
    pub first: String,
    /// True if another cell is neither equal nor empty.
    pub varies: bool,
    /// True if each cell is the beginning of the name of its place, as that of a building is.
    pub is_in_name: bool,
    /// Least and greatest number, as the table writes them; `None` if there is no number.
    pub range: Option<[String; 2]>,
    limits: [f64; 2],
    sum: f64,
    count: u64,
}

impl TableDigest {
    /// Reads a table and keeps at most `most` rows: newly broken rules first, then those that
    /// were broken before, then by the name of the place.
    pub fn of(table: &DescribedTable, most: usize) -> Result<Self> {
        let columns = &table.columns;
        let place_of = |name: &str| columns.iter().position(|column| column.name == name);
        let [rule, verdict, before] = ["rule", "verdict", "verdict_before"].map(place_of);
        let names_place =
            |column: &DescribedColumn| column.datatype == "string" && !NO_PLACES.contains(&column.name.as_str());
        let place = columns.iter().position(names_place);
        let mut csv = CsvRows::open(&table.file)?;
        let has_header = csv.advance()? && csv.record.iter().eq(columns.iter().map(|column| column.name.as_str()));
        if !has_header {
            let what = "the columns are not those that its metadata file describes";
            return Err(csv.error(what, "write the table again").because(Problem::Damaged));
        }
        let summaries = columns.iter().map(|_| ColumnDigest { is_in_name: true, ..ColumnDigest::default() }).collect();
        let mut digest = TableDigest { rows: 0, rules: Vec::new(), columns: summaries, shown: Vec::new() };
        let mut kept = BTreeMap::new();
        while csv.advance()? {
            let cells: Vec<String> = (0..columns.len()).map(|place| csv.cell(place).to_owned()).collect();
            let cell = |place: Option<usize>| place.and_then(|place| cells.get(place)).map_or("", String::as_str);
            let name = cell(place);
            let rank_of = |place: Option<usize>| place.map_or(0, |_| rank(cell(place)));
            let (rank, rank_before) = (rank_of(verdict), rank_of(before));
            let is_newly_broken = rank == 0 && (1..Verdict::ALL.len()).contains(&rank_before);
            if verdict.is_some() {
                let of_rule = digest.rule(cell(rule));
                of_rule.counts[rank] += 1;
                of_rule.newly_broken += u64::from(is_newly_broken);
            }
            for (i, (summary, cell)) in digest.columns.iter_mut().zip(&cells).enumerate() {
                let is_number = columns[i].datatype == "number";
                summary.add(cell, is_number);
                summary.is_in_name &= !is_number && Some(i) != place && name.starts_with(cell.as_str());
            }
            kept.insert((rank, !is_newly_broken, natural(name), digest.rows), cells);
            if kept.len() > most {
                kept.pop_last();
            }
            digest.rows += 1;
        }
        digest.shown = kept.into_values().collect();
        if digest.rules.len() > 1 {
            // Values of rules that count minutes and percent have no common range.
            let without_unit = digest.columns.iter_mut().zip(columns).filter(|(_, column)| column.unit.is_empty());
            without_unit.for_each(|(summary, _)| summary.range = None);
        }
        Ok(digest)
    }

    /// Returns the counts of a rule.
    fn rule(&mut self, rule: &str) -> &mut RuleVerdicts {
        let known = self.rules.iter().position(|one| one.rule == rule).unwrap_or(self.rules.len());
        if known == self.rules.len() {
            self.rules.push(RuleVerdicts { rule: rule.to_owned(), counts: Default::default(), newly_broken: 0 });
        }
        &mut self.rules[known]
    }
}

impl RuleVerdicts {
    /// Returns the counts in words, with those of broken and met rules even if they are 0.
    pub fn text(&self) -> String {
        let names = Verdict::ALL.map(|(verdict, name, _)| (name, verdict != Verdict::Close));
        let names = names.into_iter().chain([("not applicable", false)]);
        let counts = names.zip(self.counts).filter(|((_, is_always), count)| *is_always || *count > 0);
        let counts = counts.map(|((name, _), count)| (name, count));
        let newly = [("newly broken", self.newly_broken)].into_iter().filter(|(_, count)| *count > 0);
        let counts: Vec<String> = counts.chain(newly).map(|(name, count)| format!("{count} {name}")).collect();
        format!("{}: {}", self.rule, counts.join(", "))
    }
}

impl ColumnDigest {
    fn add(&mut self, cell: &str, is_number: bool) {
        if self.first.is_empty() {
            cell.clone_into(&mut self.first);
        }
        self.varies |= !cell.is_empty() && cell != self.first;
        let Some(number) = cell.parse().ok().filter(|number: &f64| is_number && number.is_finite()) else { return };
        let range = self.range.get_or_insert_with(|| {
            self.limits = [number; 2];
            [cell.to_owned(), cell.to_owned()]
        });
        if number < self.limits[0] {
            self.limits[0] = number;
            cell.clone_into(&mut range[0]);
        }
        if number > self.limits[1] {
            self.limits[1] = number;
            cell.clone_into(&mut range[1]);
        }
        self.sum += number;
        self.count += 1;
    }

    /// Returns the plain mean of the numbers, with the decimals of the greatest.
    pub fn mean(&self) -> Option<String> {
        let decimals = |text: &String| text.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        let most = self.range.as_ref().map(|[_, greatest]| decimals(greatest))?;
        Some(format!("{:.most$}", self.sum / self.count as f64))
    }
}

/// Returns the place of a verdict in [`Verdict::ALL`].
fn rank(verdict: &str) -> usize {
    Verdict::ALL.iter().position(|(_, name, _)| *name == verdict).unwrap_or(Verdict::ALL.len())
}

/// Returns a key that sorts names as people do: `wall 9` before `wall 10`.
fn natural(name: &str) -> String {
    let mut key = String::new();
    let mut rest = name;
    while let Some(at) = rest.find(|c: char| c.is_ascii_digit()) {
        let (before, number) = rest.split_at(at);
        let end = number.find(|c: char| !c.is_ascii_digit()).unwrap_or(number.len());
        let (digits, after) = number.split_at(end);
        key += before;
        key += &format!("{digits:0>20}");
        rest = after;
    }
    key + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Among 4 names with numbers, 9 comes before 10, whatever stands around them.
    #[test]
    fn names_are_sorted_by_their_numbers() {
        let mut names = ["w 10/b", "w 9", "a", "w 10/a 2"];
        names.sort_by_key(|name| natural(name));
        assert_eq!(names, ["a", "w 9", "w 10/a 2", "w 10/b"]);
    }

    /// Three numbers and an empty cell have a range as written, and a mean with its decimals: 2.0.
    #[test]
    fn ranges_stay_as_the_table_writes_them() {
        let mut column = ColumnDigest::default();
        ["1.50", "", "3.5", "1"].iter().for_each(|cell| column.add(cell, true));
        assert_eq!(column.range, Some(["1".into(), "3.5".into()]));
        assert_eq!((column.mean().as_deref(), column.varies), (Some("2.0"), true));
    }
}
