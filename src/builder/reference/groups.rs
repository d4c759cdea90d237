//! Groups of receivers with similar sky views, between which errors and effects differ most. In:
//! sky views. Out: groups.

/// Largest number of groups.
const GROUPS: usize = 10;

/// Smallest number of receivers of a group.
const OF_GROUP: usize = 4;

/// Returns the numbers of receivers by rising sky view, cut into groups of about equal size.
pub fn by_sky_view(views: &[f64]) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..views.len()).collect();
    order.sort_by(|a, b| views[*a].total_cmp(&views[*b]));
    let (count, groups) = (order.len(), (order.len() / OF_GROUP).clamp(1, GROUPS));
    (0..groups).map(|i| order[i * count / groups..(i + 1) * count / groups].to_vec()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 95 receivers make ten groups of 9 or 10, together all, in rising order. 9 receivers make two
    /// groups, and none make one empty group.
    #[test]
    fn groups_are_even() {
        let views: Vec<f64> = (0..95).map(|i| f64::from(i * 37 % 95)).collect();
        let groups = by_sky_view(&views);
        assert!(groups.len() == 10 && groups.iter().all(|group| (9..=10).contains(&group.len())));
        let rising: Vec<f64> = groups.concat().into_iter().map(|i| views[i]).collect();
        assert!(rising.len() == 95 && rising.is_sorted());
        assert_eq!((by_sky_view(&views[..9]).len(), by_sky_view(&[])), (2, vec![vec![]]));
    }
}
