//! Free parts of walls. In: sides of footprints on common nodes, and the heights between which each
//! footprint stands. Out: for each side the heights between which its wall is outdoors.

/// Least height of a wall, metres: heights are stated in centimetres.
const MIN_M: f64 = 0.01;

/// A side of a footprint, anticlockwise: the building is on its left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Side {
    pub from: u32,
    pub to: u32,
    pub footprint: u32,
}

/// Heights between which a building stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Standing {
    pub foot_m: f64,
    pub roof_m: f64,
    /// True if the building stands on the ground, so that no part of a neighbour is free below it.
    pub on_ground: bool,
}

/// A part of a wall that is outdoors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FreeWall {
    pub side: Side,
    pub foot_m: f64,
    pub roof_m: f64,
}

/// Free parts of all walls, and the number of sides that neighbours cover.
#[derive(Debug, Default)]
pub(super) struct FreeWalls {
    pub walls: Vec<FreeWall>,
    /// Number of sides that are not wholly free.
    pub shared_sides: usize,
}

/// Returns the free parts of all sides of all footprints; `standing` holds the heights of each
/// footprint.
pub(super) fn free_walls(mut sides: Vec<Side>, standing: &[Standing]) -> FreeWalls {
    sides.sort_unstable();
    let of = |side: &Side| standing.get(side.footprint as usize).copied();
    let mut found = FreeWalls::default();
    for side in &sides {
        let Some(own) = of(side) else { continue };
        let back = (side.to, side.from);
        let first = sides.partition_point(|other| (other.from, other.to) < back);
        let beside = sides.get(first..).unwrap_or_default().iter().take_while(|other| (other.from, other.to) == back);
        let mut covered: Vec<[f64; 2]> = beside
            .filter_map(of)
            .map(|other| [if other.on_ground { f64::NEG_INFINITY } else { other.foot_m }, other.roof_m])
            .collect();
        covered.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
        let before = found.walls.len();
        let mut foot_m = own.foot_m;
        for [from, to] in covered.iter().copied().chain([[f64::INFINITY; 2]]) {
            let roof_m = own.roof_m.min(from);
            if roof_m - foot_m >= MIN_M {
                found.walls.push(FreeWall { side: *side, foot_m, roof_m });
            }
            foot_m = foot_m.max(to);
        }
        let whole = FreeWall { side: *side, foot_m: own.foot_m, roof_m: own.roof_m };
        found.shared_sides += usize::from(found.walls.get(before..) != Some(&[whole]));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A neighbour of 6 m leaves 4 m of a wall of 10 m free, one that stands from 3 to 6 m leaves 3
    /// and 4 m, and one of 12 m nothing; that neighbour's own wall is free above 10 m.
    #[test]
    fn a_neighbour_leaves_the_wall_above_it_free() {
        let stands = |foot_m: f64, roof_m: f64| Standing { foot_m, roof_m, on_ground: foot_m <= 0.0 };
        let free = |other: Standing| {
            let sides = vec![Side { from: 1, to: 2, footprint: 0 }, Side { from: 2, to: 1, footprint: 1 }];
            let found = free_walls(sides, &[stands(0.0, 10.0), other]);
            let of = |footprint: u32| -> Vec<[f64; 2]> {
                let own = found.walls.iter().filter(|wall| wall.side.footprint == footprint);
                own.map(|wall| [wall.foot_m, wall.roof_m]).collect()
            };
            (of(0), of(1))
        };
        assert_eq!(free(stands(-1.0, 6.0)), (vec![[6.0, 10.0]], vec![]));
        assert_eq!(free(stands(3.0, 6.0)), (vec![[0.0, 3.0], [6.0, 10.0]], vec![]));
        assert_eq!(free(stands(0.0, 12.0)), (vec![], vec![[10.0, 12.0]]));
        assert_eq!(free(stands(20.0, 22.0)), (vec![[0.0, 10.0]], vec![[20.0, 22.0]]));
    }
}
