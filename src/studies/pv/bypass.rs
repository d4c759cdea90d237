//! Power of cells in series. In: the light on each cell of a module, or of modules in series. Out:
//! the largest power of all that carry one current, with a bypass diode at each substring.
//!
//! A cell is a diode without resistances, as in PVWatts: power proportional to light. Its voltage
//! falls with the current and ends at that of its light; a substring with such a cell is bypassed.
//! In a substring of two halves each half carries its share by its darkest cell.

use heliotile_scene::pv::cells::CellGrid;

/// Voltage of an open cell over the thermal voltage of its diode: 0.68 V over 1.05 x 25.7 mV.
const OPEN_VOLTAGE: f64 = 25.0;

/// Current at the point of most power over that of a short circuit: the c for which
/// [`OPEN_VOLTAGE`] + ln(1 - c) is c / (1 - c).
const BEST_CURRENT: f64 = 0.956_28;

/// Forward voltage of a bypass diode over the voltage of a cell at the point of most power: 0.5 V,
/// 0.57 V.
const DIODE_CELLS: f64 = 0.88;

/// Currents that are tried, over that of most power of the darkest cell of a substring.
const TRIED: [f64; 7] = [0.93, 0.97, 1.0, 1.015, 1.03, 1.04, 1.044];
/// Currents closer than this share are one.
const SAME_CURRENT: f64 = 0.002;
/// Share of the brightest cell's light from which all light counts as even.
const EVEN: f32 = 0.995;

/// Module under the light of an hour.
#[derive(Clone, Debug, PartialEq)]
pub struct LitModule {
    /// Power for each W/m2 of even light, kW m2/W.
    pub kw_m2_w: f64,
    /// Light on its cells, W/m2, in the order of [`CellGrid::order`].
    pub light: Vec<f32>,
}

/// Returns the voltage of a cell at a current over its current of most power, over the voltage
/// there; minus infinity if it cannot carry the current.
fn voltage(share: f64) -> f64 {
    let left = 1.0 - BEST_CURRENT * share;
    if left > 0.0 { (OPEN_VOLTAGE + left.ln()) / (OPEN_VOLTAGE + (1.0 - BEST_CURRENT).ln()) } else { f64::NEG_INFINITY }
}

/// Returns the light of the darkest of some cells.
fn darkest(cells: &[f32]) -> f64 {
    cells.iter().copied().fold(f32::INFINITY, f32::min).into()
}

/// Returns the mean voltage of the cells of a substring at a current, which counts as light, W/m2.
fn substring_voltage(halves: &[&[f32]], current: f64) -> f64 {
    let limits: f64 = halves.iter().map(|half| darkest(half)).sum();
    let of_half = |half: &&[f32]| {
        let share = darkest(half) / limits;
        let own = current * halves.len() as f64 * share;
        let sum: f64 = half.iter().map(|light| voltage(own / f64::from(*light))).sum();
        if share > 0.0 { share * sum / half.len() as f64 } else { 0.0 }
    };
    let cells = halves.first().map_or(1, |half| half.len()) as f64;
    let bypassed = -DIODE_CELLS / cells;
    if limits > 0.0 { halves.iter().map(of_half).sum::<f64>().max(bypassed) } else { bypassed }
}

/// Returns the largest power of modules in series, kW.
pub fn best_kw(grid: &CellGrid, modules: &[LitModule]) -> f64 {
    let lights = || modules.iter().flat_map(|module| module.light.iter().copied());
    let [least, most] = lights().fold([f32::INFINITY, 0.0], |[least, most], light| [least.min(light), most.max(light)]);
    if least >= EVEN * most {
        let mean =
            |module: &LitModule| module.light.iter().map(|light| f64::from(*light)).sum::<f64>() / grid.count() as f64;
        return modules.iter().map(|module| module.kw_m2_w * mean(module)).sum();
    }
    let halves = if grid.is_half_cut { 2 } else { 1 };
    let substrings: Vec<(f64, Vec<&[f32]>)> = modules
        .iter()
        .flat_map(|module| {
            let parts: Vec<&[f32]> = module.light.chunks_exact(grid.in_series()).collect();
            let kw_m2_w = module.kw_m2_w / grid.substrings as f64;
            parts.chunks_exact(halves).map(|part| (kw_m2_w, part.to_vec())).collect::<Vec<_>>()
        })
        .collect();
    let limit = |halves: &[&[f32]]| halves.iter().map(|half| darkest(half)).sum::<f64>() / halves.len() as f64;
    let limits = substrings.iter().map(|(_, halves)| limit(halves)).filter(|limit| *limit > 0.0);
    let mut currents: Vec<f64> = limits.flat_map(|limit| TRIED.map(|share| share * limit)).collect();
    currents.sort_unstable_by(f64::total_cmp);
    currents.dedup_by(|next, kept| *next < *kept * (1.0 + SAME_CURRENT));
    let power = |current: &f64| {
        let of = |(kw_m2_w, halves): &(f64, Vec<&[f32]>)| kw_m2_w * substring_voltage(halves, *current);
        current * substrings.iter().map(of).sum::<f64>()
    };
    currents.iter().map(power).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(is_half_cut: bool, series: usize) -> CellGrid {
        CellGrid { cells: [6, 20], substrings: 3, is_half_cut, series }
    }

    /// Returns the power of modules over that of one with full light; `dim` gives the light of the
    /// cells in order, 40 of a substring, of 1000 W/m2.
    fn power(grid: CellGrid, modules: usize, dim: impl Fn(usize) -> f32) -> f64 {
        let module =
            |m: usize| LitModule { kw_m2_w: 1e-3, light: (0..120).map(|cell| 1000.0 * dim(120 * m + cell)).collect() };
        best_kw(&grid, &(0..modules).map(module).collect::<Vec<_>>())
    }

    fn near(found: f64, right: f64) {
        assert!((found - right).abs() < 2e-3, "{found}, not {right}");
    }

    /// Even light gives all power, and no current gives more. A dark substring of three costs a
    /// third and the voltage of its diode, of 40 cells; dark upper halves of all substrings cost
    /// half, which is all of their light; a dark module of four costs a quarter and three diodes.
    /// Darkness gives nothing.
    #[test]
    fn a_diode_bypasses_what_is_dark() {
        let [whole, halves, chain] = [grid(false, 1), grid(true, 1), grid(false, 4)];
        near(power(whole, 1, |_| 0.8), 0.8);
        near(power(whole, 1, |cell| if cell == 0 { 0.99 } else { 1.0 }), 1.0);
        near(power(whole, 1, |cell| if cell == 50 { 0.02 } else { 1.0 }), (2.0 - 0.022) / 3.0);
        near(power(halves, 1, |cell| if cell / 20 % 2 == 1 { 0.0 } else { 1.0 }), 0.5);
        near(power(chain, 4, |cell| if cell < 120 { 0.0 } else { 1.0 }), 3.0 - 0.022);
        assert_eq!(power(whole, 1, |_| 0.0), 0.0);
    }

    /// One cell of 40 at 90 % lets its substring carry more than its own current of most power: the
    /// whole module gives what no current of a fine grid exceeds by 0.2 %, and more than 91 %.
    #[test]
    fn a_dim_cell_costs_less_than_its_light() {
        let light: Vec<f32> = (0..120).map(|cell| if cell == 0 { 900.0 } else { 1000.0 }).collect();
        let of = |current: f64| {
            let parts: Vec<&[f32]> = light.chunks_exact(40).collect();
            current * parts.iter().map(|part| substring_voltage(&[*part], current)).sum::<f64>() / 3000.0
        };
        let fine = (1..2000).map(|i| of(f64::from(i) * 0.6)).fold(0.0, f64::max);
        let found = best_kw(&grid(false, 1), &[LitModule { kw_m2_w: 1e-3, light: light.clone() }]);
        assert!(found > 0.91 && found <= fine && found > 0.998 * fine, "{found} of {fine}");
    }
}
