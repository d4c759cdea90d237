//! Rows of buildings and of roof faces. In: a cadastre. Out: records with their columns.

use std::collections::BTreeMap;

use super::cadastre::{Cadastre, SIDES};
use super::face::{AreaSum, RoofFace};
use crate::outputs::tables::column::Column;
use crate::outputs::tables::records::Records;
use crate::outputs::tables::table::Cell;

/// Returns a row for each building, by name.
pub fn building_rows(cadastre: &Cadastre) -> Records {
    let mut columns = vec![Column::text("building"), Column::count("roof_faces")];
    columns.extend(numbers(["roof_area_m2", "roof_kwh", "roof_kwh_m2", "above_threshold_m2", "usable_area_m2"]));
    columns.extend(numbers(["usable_kwh", "usable_kwh_m2", "share_of_best"]));
    columns.extend(numbers(SIDES.map(|side| format!("roof_{side}_kwh"))));
    columns.extend(numbers(["facade_area_m2", "facade_kwh", "facade_kwh_m2"]));
    columns.extend(numbers(SIDES.iter().skip(1).map(|side| format!("facade_{side}_kwh"))));
    columns.push(Column::text("best_face"));
    columns.extend(numbers(["best_region_m2", "best_region_kwh_m2"]));
    let mut of_building: BTreeMap<u32, Vec<&RoofFace>> = BTreeMap::new();
    cadastre.faces.iter().for_each(|face| of_building.entry(face.building).or_default().push(face));
    let rows = (0..).zip(cadastre.names.iter().zip(&cadastre.buildings)).map(|(number, (name, sums))| {
        let faces = of_building.get(&number).map_or(&[][..], Vec::as_slice);
        let sum = |of: fn(&RoofFace) -> AreaSum| {
            faces.iter().fold(AreaSum::default(), |mut sum, face| {
                sum.add(of(face));
                sum
            })
        };
        let (above, usable) = (sum(|face| face.above), sum(|face| face.usable));
        // Of faces with equal sums, the first by name counts.
        let better = |a: &&&RoofFace, b: &&&RoofFace| a.best.kwh.total_cmp(&b.best.kwh).then(b.name.cmp(&a.name));
        let best = faces.iter().filter(|face| face.best.kwh > 0.0).max_by(better);
        let mut row = vec![Cell::Text(name.clone()), Cell::Count(faces.len() as u64)];
        row.extend([Some(sums.roof.area_m2), Some(sums.roof.kwh), sums.roof.kwh_m2()].map(Cell::Number));
        row.extend([above.area_m2, usable.area_m2, usable.kwh].map(|number| Cell::Number(Some(number))));
        row.extend([usable.kwh_m2(), share(cadastre, usable)].map(Cell::Number));
        row.extend(sums.roof_sides.map(|kwh| Cell::Number(Some(kwh))));
        row.extend([Some(sums.facade.area_m2), Some(sums.facade.kwh), sums.facade.kwh_m2()].map(Cell::Number));
        row.extend(sums.facade_sides.iter().skip(1).map(|kwh| Cell::Number(Some(*kwh))));
        row.push(Cell::Text(best.map_or(String::new(), |face| face.name.clone())));
        row.extend([best.map(|face| face.best.area_m2), best.and_then(|face| face.best.kwh_m2())].map(Cell::Number));
        row
    });
    let rows = rows.collect();
    Records { columns, rows }
}

/// Returns a row for each roof face, by building and name.
pub fn face_rows(cadastre: &Cadastre) -> Records {
    let mut columns = vec![Column::text("building"), Column::text("face"), Column::count("receivers")];
    columns.extend(numbers(["area_m2", "tilt_deg", "azimuth_deg", "total_kwh_m2", "total_kwh", "share_of_best"]));
    columns.extend(numbers(["sky_view", "above_threshold_m2", "usable_area_m2", "usable_kwh"]));
    columns.push(Column::count("regions"));
    columns.extend(numbers(["largest_region_m2", "best_region_m2", "best_region_kwh_m2"]));
    let mut faces: Vec<&RoofFace> = cadastre.faces.iter().collect();
    faces.sort_by(|a, b| (a.building, &a.name).cmp(&(b.building, &b.name)));
    let row = |face: &RoofFace| {
        let building = cadastre.names.get(face.building as usize).cloned().unwrap_or_default();
        let (tilt, azimuth) = cadastre.direction(face);
        let best = face.best.kwh_m2().map(|_| face.best.area_m2);
        vec![
            Cell::Text(building),
            Cell::Text(face.name.clone()),
            Cell::Count(face.receivers.into()),
            Cell::Number(Some(face.all.area_m2)),
            Cell::Number(Some(tilt)),
            Cell::Number(Some(azimuth)),
            Cell::Number(face.all.kwh_m2()),
            Cell::Number(Some(face.all.kwh)),
            Cell::Number(share(cadastre, face.all)),
            Cell::Number(face.sky_view()),
            Cell::Number(Some(face.above.area_m2)),
            Cell::Number(Some(face.usable.area_m2)),
            Cell::Number(Some(face.usable.kwh)),
            Cell::Count(face.regions.into()),
            Cell::Number(Some(face.largest_m2)),
            Cell::Number(best),
            Cell::Number(face.best.kwh_m2()),
        ]
    };
    Records { columns, rows: faces.into_iter().map(row).collect() }
}

/// Returns columns of numbers, with three decimals in CSV.
fn numbers(names: impl IntoIterator<Item = impl Into<String>>) -> impl Iterator<Item = Column> {
    names.into_iter().map(|name| Column::number(name, 3))
}

/// Returns the mean as a share of the brightest receiver of all roofs.
fn share(cadastre: &Cadastre, lit: AreaSum) -> Option<f64> {
    lit.kwh_m2().map(|mean| mean / cadastre.best_kwh_m2).filter(|share| share.is_finite())
}
