//! Summary of a comparison. In: variants with their tallies. Out: a row for each variant as a table
//! and in words, and a table of receivers that exist on one side only.

use super::tally::{LOSSES_PERCENT, LossCounts};
use super::variant::{SideName, Variant};
use crate::outputs::pictures::colours::label;
use crate::outputs::quantities::ChangeKind;
use crate::outputs::tables::column::{Column, Digits};
use crate::outputs::tables::layout::Layout;
use crate::outputs::tables::records::Records;
use crate::outputs::tables::table::Cell;
use heliotile_core::replay::components::Component;
use heliotile_core::text::{counted, listed};

/// Archives after in comparison with one before.
#[derive(Clone, Debug)]
pub struct CompareSummary {
    /// Name of the archive before.
    pub before: String,
    /// Suns and skies, in words.
    pub under: String,
    /// Compared quantity, in words.
    pub what: String,
    /// Unit of the means.
    pub unit: &'static str,
    /// Names of the columns of means before and after, of the change, and of the change in percent.
    pub columns: Vec<String>,
    /// Summary of each archive after.
    pub variants: Vec<VariantSummary>,
}

/// Archive after in comparison with the one before.
#[derive(Clone, Debug)]
pub struct VariantSummary {
    /// Name of the archive.
    pub name: String,
    /// Number of receivers that exist on both sides, and how many of them lose light.
    pub receivers: LossCounts,
    /// Number of receivers that are matched by name only, as they moved.
    pub moved: u64,
    /// Number of receivers that exist only before, and only after.
    pub only: [u64; 2],
    /// Names of the first receivers that exist only before, and only after.
    pub named: [Vec<String>; 2],
    /// Area of the receivers that exist on both sides, m2, if all have one.
    pub area_m2: Option<f64>,
    /// Means before and after, by area.
    pub means: [f64; 2],
    /// Losses of windows; a window is a surface.
    pub windows: LossCounts,
    /// Losses of buildings.
    pub buildings: LossCounts,
}

impl CompareSummary {
    /// Returns the summary of variants after their tallies are complete; `layout` is the layout of
    /// the main component's change.
    pub(super) fn new(before: String, under: &str, layout: &Layout, main: Component, variants: &[Variant]) -> Self {
        let summary = |variant: &Variant| {
            let (before, after) = (variant.only(SideName::Before), variant.only(SideName::After));
            VariantSummary {
                name: variant.name.clone(),
                receivers: variant.tally.receivers,
                moved: variant.moved,
                only: [before.0, after.0],
                named: [before.1, after.1],
                area_m2: variant.tally.all.area_m2(),
                means: variant.tally.all.means(),
                windows: variant.tally.windows(),
                buildings: variant.tally.buildings(),
            }
        };
        CompareSummary {
            before,
            under: under.to_owned(),
            what: label(main),
            unit: layout.unit_of(layout.main_quantity()),
            columns: layout.values(),
            variants: variants.iter().map(summary).collect(),
        }
    }

    /// Returns a table with a row for each archive after.
    pub fn table(&self) -> Records {
        let counts = ["receivers", "moved", "only_before", "only_after"].map(Column::count);
        let means = self.columns.iter().map(|name| {
            let column = Column::number_as(name, Digits::Six);
            if name.ends_with("_percent") { column } else { column.with_unit(self.unit) }
        });
        let losses = ["receivers", "windows", "buildings"].into_iter().flat_map(|things| {
            let all = (things != "receivers").then(|| Column::count(things));
            all.into_iter().chain(LOSSES_PERCENT.map(|percent| Column::count(format!("{things}_losing_{percent}"))))
        });
        let columns =
            [Column::text("variant")].into_iter().chain(counts).chain([Column::number_as("area_m2", Digits::Six)]);
        Records {
            columns: columns.chain(means).chain(losses).collect(),
            rows: self.variants.iter().map(VariantSummary::row).collect(),
        }
    }

    /// Returns the summary as lines for people.
    pub fn text(&self) -> String {
        let paragraphs = self.variants.iter().map(|variant| variant.text(self));
        paragraphs.collect::<Vec<_>>().join("\n")
    }
}

impl VariantSummary {
    /// Returns the change of the mean.
    pub fn change(&self) -> f64 {
        self.means[1] - self.means[0]
    }

    /// Returns the change of the mean in percent; `None` if the mean before is 0.
    pub fn change_percent(&self) -> Option<f64> {
        ChangeKind::Percent.of(self.means[0], self.means[1])
    }

    fn row(&self) -> Vec<Cell> {
        let counts = [self.receivers.all, self.moved].into_iter().chain(self.only).map(Cell::Count);
        let means = self.means.into_iter().chain([self.change()]).map(Cell::from);
        let of = |counts: &LossCounts| counts.losing.map(Cell::Count);
        let cells = [Cell::from(&self.name)].into_iter().chain(counts).chain([self.area_m2.into()]);
        let cells = cells.chain(means).chain([self.change_percent().into()]).chain(of(&self.receivers));
        let cells = cells.chain([Cell::Count(self.windows.all)]).chain(of(&self.windows));
        cells.chain([Cell::Count(self.buildings.all)]).chain(of(&self.buildings)).collect()
    }

    fn text(&self, summary: &CompareSummary) -> String {
        let moved = if self.moved > 0 { format!(", {} of them moved", self.moved) } else { String::new() };
        let mut text =
            format!("{} to {}: {} in both{moved}", summary.before, self.name, counted(self.receivers.all, "receiver"));
        for ((side, count), named) in ["before", "after"].into_iter().zip(self.only).zip(&self.named) {
            if count > 0 {
                text += &format!("; {count} only {side}: {}", listed(named, count as usize));
            }
        }
        let percent = self.change_percent().map_or(String::new(), |percent| format!(" ({percent:+.1} %)"));
        let [before, after] = self.means;
        text += &format!(
            "\n  {} under {}: {before:.1} to {after:.1} {}, {:+.1}{percent}\n",
            summary.what,
            summary.under,
            summary.unit,
            self.change()
        );
        let heads = LOSSES_PERCENT.map(|percent| format!("{:>9}", format!("{percent} %")));
        text += &format!("  {:<12}{:>9}{}\n", "loss above", "of", heads.concat());
        for (things, counts) in
            [("receivers", self.receivers), ("windows", self.windows), ("buildings", self.buildings)]
        {
            if counts.all > 0 {
                let losing = counts.losing.map(|count| format!("{count:>9}"));
                text += &format!("  {things:<12}{:>9}{}\n", counts.all, losing.concat());
            }
        }
        text
    }
}

/// Returns the table of receivers that exist on one side only.
pub fn unmatched_table(variants: &[Variant]) -> Records {
    let texts = ["variant", "side", "receiver"].map(Column::text);
    let columns = texts.into_iter().chain(["x", "y", "z"].map(|name| Column::number(name, 3))).collect();
    let rows = variants.iter().flat_map(|variant| {
        variant.unmatched.iter().map(|one| {
            let side = if one.side == SideName::Before { "before" } else { "after" };
            let texts = [variant.name.as_str(), side, one.place.id.as_str()].map(Cell::from);
            texts.into_iter().chain(one.place.position.to_array().map(Cell::from)).collect()
        })
    });
    Records { columns, rows: rows.collect() }
}
