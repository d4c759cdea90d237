//! Colours of a city model. In: the largest sum of a face. Out: classes of equal width with a
//! colour each, as materials of CityJSON.

use serde_json::{Value, json};

use crate::outputs::pictures::colours::inferno;

/// Largest number of classes that can be told apart.
const MAX_CLASSES: f64 = 20.0;

/// Beginning and end of the names of materials.
const NAME: [&str; 2] = ["irradiation ", " kWh/m2"];

/// Classes of irradiation, from 0 to the largest sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Theme {
    /// Width of a class, kWh/m2.
    width_kwh_m2: f64,
    classes: u32,
}

impl Theme {
    /// Name of the theme in geometries.
    pub const NAME: &'static str = "irradiation";

    /// Returns at most 20 classes; their width is 1, 2 or 5 times a power of ten.
    pub fn up_to(largest_kwh_m2: f64) -> Self {
        let least = (largest_kwh_m2 / MAX_CLASSES).max(1e-6);
        let power = 10_f64.powf(least.log10().floor());
        let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= least * (1.0 - 1e-12));
        let width_kwh_m2 = factor.unwrap_or(10.0) * power;
        // Rounding may make this a little more than 20.
        let classes = ((largest_kwh_m2 / width_kwh_m2).ceil() as u32).max(1);
        Theme { width_kwh_m2, classes }
    }

    /// Returns the class of a sum, counted from 0; a sum on a border belongs to the class above it.
    pub fn class_of(&self, kwh_m2: f64) -> u32 {
        // The cast `as` saturates at 0 and at the largest number.
        ((kwh_m2 / self.width_kwh_m2) as u32).min(self.classes - 1)
    }

    /// Returns a material for each class.
    pub fn materials(&self) -> Vec<Value> {
        let [before, behind] = NAME;
        // Widths below 1 are written with their decimals.
        let border = |class: u32| format!("{}", (f64::from(class) * self.width_kwh_m2 * 1e6).round() / 1e6);
        let colour = |class: u32| {
            let share = (f64::from(class) + 0.5) / f64::from(self.classes);
            inferno(share as f32).map(|part| (f64::from(part) / 255.0 * 1e3).round() / 1e3)
        };
        let material = |class| {
            json!({
                "name": format!("{before}{} to {}{behind}", border(class), border(class + 1)),
                "diffuseColor": colour(class),
            })
        };
        (0..self.classes).map(material).collect()
    }

    /// Returns true if `name` is the name of a material of such a theme.
    pub fn has_made(name: &str) -> bool {
        let [before, behind] = NAME;
        name.starts_with(before) && name.ends_with(behind)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A largest sum of 1,650 gives 17 classes of 100, 1,000 gives 20 of 50, and 0 gives 1. A sum
    /// of 100 is in the second class, the largest in the last. Names of materials are recognised.
    #[test]
    fn the_largest_sum_sets_the_number_of_classes() {
        for (largest, width, classes) in [(1650.0, 100.0, 17), (1000.0, 50.0, 20), (0.3, 0.02, 15), (999.0, 50.0, 20)] {
            let theme = Theme::up_to(largest);
            assert_eq!(theme.classes, classes, "{largest}");
            assert!((theme.width_kwh_m2 / width - 1.0).abs() < 1e-9, "{largest}");
            assert_eq!(theme.class_of(largest), classes - 1);
        }
        let theme = Theme::up_to(1650.0);
        assert_eq!((theme.class_of(99.9), theme.class_of(100.0), Theme::up_to(0.0).classes), (0, 1, 1));
        let materials = theme.materials();
        assert_eq!(materials[16]["name"], "irradiation 1600 to 1700 kWh/m2");
        assert!(materials.iter().all(|material| Theme::has_made(material["name"].as_str().unwrap_or_default())));
        assert!(!Theme::has_made("brick"));
    }
}
