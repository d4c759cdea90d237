//! Ground reflectance of an EnergyPlus model, month by month and under snow. In: twelve numbers and
//! a factor. Out: the reflectance of an hour.

use serde::{Deserialize, Serialize};

/// Reflectances of a material by month, as `Site:GroundReflectance` and
/// `Site:GroundReflectance:SnowModifier` state them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Stated")]
pub struct MonthlyGround {
    /// Name of the material that has these reflectances.
    pub material: String,
    /// Reflectances of January to December, each 0 to 1.
    pub reflectance: [f64; 12],
    /// Factor of the reflectance while snow lies, 0 or more; a product above 1 counts as 1.
    pub snow_modifier: f64,
}

/// The record as archives hold it, before it is checked.
#[derive(Deserialize)]
struct Stated {
    material: String,
    reflectance: [f64; 12],
    snow_modifier: f64,
}

impl TryFrom<Stated> for MonthlyGround {
    type Error = String;

    fn try_from(stated: Stated) -> Result<Self, String> {
        let Stated { material, reflectance, snow_modifier } = stated;
        if let Some(bad) = reflectance.iter().find(|value| !(0.0..=1.0).contains(*value)) {
            return Err(format!("a monthly reflectance of the ground is {bad}, not from 0 to 1"));
        }
        if !(snow_modifier.is_finite() && snow_modifier >= 0.0) {
            return Err(format!("the snow modifier of the ground is {snow_modifier}, not 0 or more"));
        }
        Ok(MonthlyGround { material, reflectance, snow_modifier })
    }
}

impl MonthlyGround {
    /// Returns the mean of the twelve months without snow, used where there is no date.
    pub fn mean(&self) -> f64 {
        let [first, ..] = self.reflectance;
        // The sum of differences is exact for equal months: 12 x 0.2 / 12 is not 0.2.
        first + self.reflectance.iter().map(|value| value - first).sum::<f64>() / 12.0
    }

    /// Returns the reflectance in a month from 1 to 12, held within 0 and 1 (Engineering Reference
    /// of EnergyPlus, "Ground Reflectances (Snow)"). Snow lies where the weather file's snow depth
    /// is above 0, as in EnergyPlus.
    pub fn of(&self, month: u32, snow_depth_cm: Option<f64>) -> f64 {
        let bare = self.reflectance.get(month.saturating_sub(1) as usize).copied().unwrap_or_else(|| self.mean());
        match snow_depth_cm {
            Some(depth) if depth > 0.0 => (bare * self.snow_modifier).clamp(0.0, 1.0),
            _ => bare,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The third month's 0.3 becomes 0.45 under 0.2 cm of snow, the twelfth's 0.8 no more than 1.
    /// Without a depth they stay. The mean of the year is 0.25.
    #[test]
    fn monthly_reflectances_grow_under_snow() {
        let mut reflectance = [0.19; 12];
        (reflectance[2], reflectance[11]) = (0.3, 0.8);
        let ground = MonthlyGround { material: "endless_ground".into(), reflectance, snow_modifier: 1.5 };
        let found = [(3, Some(0.2)), (3, Some(0.0)), (3, None), (12, Some(9.0)), (12, None)];
        let expected = [0.3 * 1.5, 0.3, 0.3, 1.0, 0.8];
        assert_eq!(found.map(|(month, depth)| ground.of(month, depth)), expected);
        assert!((ground.mean() - 0.25).abs() < 1e-12);
    }

    /// A reflectance of 1.2, a modifier of -1 and eleven months are refused, 3 of 3. Twelve good
    /// months come back unchanged.
    #[test]
    fn impossible_monthly_grounds_are_refused() {
        let json = |first: &str, modifier: &str, months: usize| {
            let list = vec![first; months].join(",");
            format!("{{\"material\":\"g\",\"reflectance\":[{list}],\"snow_modifier\":{modifier}}}")
        };
        let bad = [json("1.2", "1.0", 12), json("0.2", "-1.0", 12), json("0.2", "1.0", 11)];
        assert_eq!(bad.iter().filter(|text| serde_json::from_str::<MonthlyGround>(text).is_err()).count(), 3);
        let good = json("0.2", "1.5", 12);
        let read: MonthlyGround = serde_json::from_str(&good).expect("checked");
        assert_eq!(serde_json::to_string(&read).expect("JSON"), good);
    }
}
