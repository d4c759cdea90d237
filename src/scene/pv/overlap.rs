//! Modules that pass through each other. In: modules of several tables of rows. Out: the pairs of
//! different tables that share space.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use super::layout::Module;

/// Depth to which modules may reach into each other: corners of areas are rounded, metres.
const TOUCHING_M: f64 = 0.002;

/// Returns the modules that pass through one of an earlier table, each with the first of those.
/// Modules of one table never meet, since rows are at least a module's depth apart.
pub fn crossing<'m>(tables: &[&'m [Module]]) -> Vec<(&'m Module, &'m Module)> {
    let all = || tables.iter().enumerate().flat_map(|(table, modules)| modules.iter().map(move |m| (table, m)));
    // Modules whose middles are further apart than the longest one cannot meet.
    let reach_m = all().fold(TOUCHING_M, |reach, (_, m)| reach.max(2.0 * sides(m).iter().sum::<DVec3>().length()));
    let cell = |m: &Module| (m.middle().truncate() / reach_m).floor();
    let mut earlier: HashMap<[i64; 2], Vec<(usize, &Module)>> = HashMap::new();
    let mut found = Vec::new();
    for (table, module) in all() {
        let at = cell(module);
        let near = |dx: i64, dy: i64| earlier.get(&[at.x as i64 + dx, at.y as i64 + dy]).into_iter().flatten();
        let around = (-1..=1).flat_map(|dx| (-1..=1).flat_map(move |dy| near(dx, dy)));
        let met = around.filter(|(of, other)| *of != table && meet(module, other)).map(|(_, other)| *other).next();
        found.extend(met.map(|other| (module, other)));
        let DVec2 { x, y } = at;
        earlier.entry([x as i64, y as i64]).or_default().push((table, module));
    }
    found
}

/// Returns half of a module's sides: along its row, up its slope, through it.
fn sides(module: &Module) -> [DVec3; 3] {
    let [a, b, _, d] = module.front;
    [(b - a) / 2.0, (d - a) / 2.0, module.normal * (module.thickness_m / 2.0)]
}

/// Returns true if two boxes share space: no plane lies between them (separating axes of the sides
/// and of their products; Gottschalk, Lin and Manocha, "OBBTree", SIGGRAPH 1996).
fn meet(one: &Module, other: &Module) -> bool {
    let halves = [sides(one), sides(other)];
    let middle = |m: &Module, [.., through]: [DVec3; 3]| m.middle() - through;
    let between = middle(other, halves[1]) - middle(one, halves[0]);
    let products = halves[0].iter().flat_map(|a| halves[1].iter().map(move |b| a.cross(*b)));
    let axes = halves.iter().flatten().copied().chain(products).filter_map(DVec3::try_normalize);
    let reach = |axis: DVec3| halves.iter().flatten().map(|half| half.dot(axis).abs()).sum::<f64>();
    axes.into_iter().all(|axis| between.dot(axis).abs() < reach(axis) - TOUCHING_M)
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_core::site::north::North;

    use crate::pv::layout::tests::rows;
    use crate::pv::layout::{Outline, lay};

    fn laid(azimuth_deg: f64, left: f64, low: f64) -> Vec<Module> {
        let corners = [(left, low), (left + 10.0, low), (left + 10.0, low + 10.0), (left, low + 10.0)];
        let outline = Outline::of_polygon(&corners.map(DVec2::from));
        lay(&rows(10.0, azimuth_deg, 0.0), North::default(), &outline, |_| Some(0.0)).modules
    }

    /// Rows that face east and west on one area pass through each other, as do equal rows; rows
    /// beside each other, touching ones and rows of one table do not.
    #[test]
    fn only_rows_on_one_place_cross() {
        let (east, west) = (laid(90.0, 0.0, 0.0), laid(270.0, 0.0, 0.0));
        assert!(crossing(&[&east, &west]).len() >= 10);
        assert_eq!(crossing(&[&east, &east]).len(), east.len());
        assert_eq!(crossing(&[&east]), []);
        for (left, low) in [(10.0, 0.0), (0.0, 10.0), (30.0, -20.0), (-10.0, 10.0)] {
            assert_eq!(crossing(&[&east, &laid(90.0, left, low)]), [], "{left} {low}");
        }
        // A module above another one, 5 cm apart, and one that is pushed through it.
        let lifted = |by_m: f64| {
            let lift = |m: &Module| Module { front: m.front.map(|p| p + DVec3::Z * by_m), ..m.clone() };
            east.iter().map(lift).collect::<Vec<_>>()
        };
        assert_eq!(crossing(&[&east, &lifted(0.05)]), []);
        assert_eq!(crossing(&[&east, &lifted(0.02)]).len(), east.len());
    }
}
