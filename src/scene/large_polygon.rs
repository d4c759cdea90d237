//! Triangulation of a ring of thousands of corners, which ear clipping would take minutes for. In:
//! an outline and its holes in a plane. Out: triangles of their corners in n log n, or `None` if
//! sides cross.

use spade::handles::FixedFaceHandle;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

/// A corner with its place in the list.
struct Corner {
    position: Point2<f64>,
    place: u32,
}

impl HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.position
    }
}

/// Returns three places in `corners` for each triangle. `starts` are the places where holes begin.
pub(super) fn cut(corners: &[[f64; 2]], starts: &[usize]) -> Option<Vec<u32>> {
    let places = (0..).zip(corners);
    let points = places.map(|(place, &[x, y])| Corner { position: Point2::new(x, y), place }).collect();
    let mut sides: Vec<[usize; 2]> = Vec::with_capacity(corners.len());
    for (i, &start) in [0].iter().chain(starts).enumerate() {
        let end = starts.get(i).copied().unwrap_or(corners.len());
        sides.extend((start..end).map(|from| [from, if from + 1 == end { start } else { from + 1 }]));
    }
    // Corners at one place are one vertex, so sides are compared by their ends.
    let ends = |side: &[usize; 2]| {
        let mut ends = side.map(|end| corners.get(end).copied().unwrap_or_default().map(|x| (x + 0.0).to_bits()));
        ends.sort_unstable();
        ends
    };
    sides.sort_by_cached_key(ends);
    // A side that is passed twice, there and back, bounds nothing.
    let sides = sides.chunk_by(|a, b| ends(a) == ends(b)).filter(|equal| equal.len() % 2 == 1);
    let sides: Vec<[usize; 2]> = sides.filter_map(|equal| equal.first().copied()).collect();
    let mut crosses = false;
    let cut = ConstrainedDelaunayTriangulation::<Corner>::try_bulk_load_cdt(points, sides, |_| crosses = true);
    let cut = cut.ok().filter(|_| !crosses)?;

    // A face beyond a side is inside if this one is outside, and the reverse.
    let mut inside: Vec<Option<bool>> = vec![None; cut.num_all_faces()];
    let outer = cut.outer_face().fix();
    let mut next: Vec<(FixedFaceHandle<_>, bool)> = vec![(outer, false)];
    *inside.get_mut(outer.index())? = Some(false);
    let border: Vec<_> = cut.convex_hull().map(|edge| edge.rev()).collect();
    for edge in border {
        let is_inside = edge.is_constraint_edge();
        if let Some(face) = inside.get_mut(edge.face().index())
            && face.is_none()
        {
            *face = Some(is_inside);
            next.push((edge.face().fix(), is_inside));
        }
    }
    let mut triangles = Vec::new();
    while let Some((face, is_inside)) = next.pop() {
        let Some(face) = cut.face(face).as_inner() else { continue };
        if is_inside {
            triangles.push(face.vertices().map(|corner| corner.data().place));
        }
        for edge in face.adjacent_edges() {
            let is_inside = is_inside != edge.is_constraint_edge();
            let beyond = edge.rev().face();
            if let Some(known) = inside.get_mut(beyond.index())
                && known.is_none()
            {
                *known = Some(is_inside);
                next.push((beyond.fix(), is_inside));
            }
        }
    }
    triangles.sort_unstable();
    Some(triangles.into_iter().flatten().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[[f64; 2]], triangles: &[u32]) -> f64 {
        let at = |place: u32| corners[place as usize];
        let each = triangles.chunks_exact(3).map(|t| {
            let [[ax, ay], [bx, by], [cx, cy]] = [at(t[0]), at(t[1]), at(t[2])];
            0.5 * ((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)).abs()
        });
        each.sum()
    }

    /// A comb of 40,002 corners has n - 2 triangles and its area, 100 m2 of 10,000 teeth; a square
    /// of 4 x 4 m with a hole of 2 x 2 m and a slit keeps 12 m2; a bow tie crosses itself and gets
    /// none.
    #[test]
    fn many_corners_and_holes_keep_their_area() {
        let teeth = (0..20_000).map(|i| [f64::from(i), if i % 2 == 0 { 0.01 } else { 0.02 }]);
        let comb: Vec<[f64; 2]> =
            teeth.chain((0..20_000).rev().map(|i| [f64::from(i), 0.0])).chain([[-1.0, 0.0], [-1.0, 0.01]]).collect();
        let cut_comb = cut(&comb, &[]).expect("no crossing");
        assert_eq!(cut_comb.len(), 3 * 40_000);
        let right = 0.015 * 19_999.0 + 0.01;
        assert!((area(&comb, &cut_comb) / right - 1.0).abs() < 1e-9, "{}", area(&comb, &cut_comb));

        let ring = [[0., 0.], [4., 0.], [4., 4.], [0., 4.], [1., 1.], [1., 3.], [3., 3.], [3., 1.]];
        assert!((area(&ring, &cut(&ring, &[4]).expect("no crossing")) - 12.0).abs() < 1e-12);
        let slit = [[0., 0.], [4., 0.], [4., 2.], [3., 2.], [4., 2.], [4., 4.], [0., 4.]];
        assert!((area(&slit, &cut(&slit, &[]).expect("no crossing")) - 16.0).abs() < 1e-12);
        assert_eq!(cut(&[[0., 0.], [2., 2.], [2., 0.], [0., 2.]], &[]), None);
    }
}
