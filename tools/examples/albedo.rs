//! Replays another albedo without tracing: the same suns and skies over dark and over bright
//! ground, as tables.
//!
//! `cargo run --release --example albedo -- SITE.helio CONDITIONS.csv FOLDER`

use std::path::Path;

use heliotile::{LightRequest, OutputRequest, QueryRequest, Resources, Site};

fn main() -> heliotile::Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match words.as_slice() {
        [archive, conditions, folder] => albedos(archive, conditions, Path::new(folder)),
        _ => Err(heliotile::Error::argument("words", "are not three", "SITE.helio CONDITIONS.csv FOLDER")),
    }
}

fn albedos(archive: &str, conditions: &str, folder: &Path) -> heliotile::Result<()> {
    let site = Site::open(archive)?;
    for albedo in [0.2, 0.6] {
        let mut light = LightRequest::default();
        light.changes.constant.push(("ground".to_owned(), albedo));
        let request = QueryRequest { light, ..QueryRequest::new(conditions) };
        let table = OutputRequest::new(folder.join(format!("albedo-{albedo}.csv")));
        site.query(&request, &table, &Resources::usual())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    /// In each of 18 rows brighter ground gives at least as much light, and over all rows more than
    /// 1 % more.
    #[test]
    fn brighter_ground_gives_more() {
        let folder = tempfile::tempdir().expect("a folder");
        let data = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/archives");
        let [archive, conditions] = ["helio", "conditions.csv"].map(|end| format!("{data}/v1.7-box.{end}"));
        super::albedos(&archive, &conditions, folder.path()).expect("tables");
        let totals = |albedo: &str| -> Vec<f64> {
            let table = std::fs::read_to_string(folder.path().join(format!("albedo-{albedo}.csv"))).expect("a table");
            let mut lines = table.lines();
            let total = lines.next().expect("a header").split(',').position(|name| name == "total").expect("a column");
            lines.map(|line| line.split(',').nth(total).expect("a cell").parse().expect("a number")).collect()
        };
        let (dark, bright) = (totals("0.2"), totals("0.6"));
        assert_eq!((dark.len(), dark.len()), (bright.len(), 18));
        assert!(dark.iter().zip(&bright).all(|(dark, bright)| bright >= dark), "{dark:?} {bright:?}");
        assert!(bright.iter().sum::<f64>() > 1.01 * dark.iter().sum::<f64>());
    }
}
