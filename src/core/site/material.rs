//! A surface's optical properties. In: shares of the light. Out: one checked material.

/// Which of the two first-hit classes a surface counts for (the five EnergyPlus factors need them apart).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Ground: terrain, streets, water.
    Ground,
    /// Whatever stands on it: buildings, trees.
    Obstruction,
}

impl Class {
    /// The classes in the order of their codes.
    pub const ALL: [Class; 2] = [Class::Ground, Class::Obstruction];

    /// The class as a number: in archives, in hashes, and as the place in arrays that have one value a class.
    pub const fn code(self) -> u8 {
        match self {
            Class::Ground => 0,
            Class::Obstruction => 1,
        }
    }

    /// The class of a [`Class::code`]; `None` for any other number.
    pub fn of_code(code: u8) -> Option<Self> {
        Class::ALL.get(usize::from(code)).copied()
    }

    /// Its name, wherever users give one.
    pub const fn name(self) -> &'static str {
        match self {
            Class::Ground => "ground",
            Class::Obstruction => "obstruction",
        }
    }

    /// The class of a name.
    pub fn of_name(name: &str) -> Option<Self> {
        Class::ALL.into_iter().find(|class| class.name() == name)
    }

    /// Place in arrays that have one value a class.
    pub const fn index(self) -> usize {
        self.code() as usize
    }
}

/// Panes of clear glass, whose specular reflectance follows from the angle of incidence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Glass {
    /// One pane: two surfaces of glass.
    Single,
    /// Two panes: four surfaces of glass.
    Double,
}

impl Glass {
    /// Of a number of panes; `None` for no glass.
    pub fn of_panes(panes: u8) -> Option<Self> {
        match panes {
            1 => Some(Glass::Single),
            2 => Some(Glass::Double),
            _ => None,
        }
    }

    /// Number of panes.
    pub fn panes(self) -> u8 {
        match self {
            Glass::Single => 1,
            Glass::Double => 2,
        }
    }
}

/// Checked optical properties of one material; `diffuse + specular <= 1`, `diffuse + transmittance <= 1`, each in 0..=1.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the files of the scene.
    pub name: String,
    /// Diffuse reflectance of both sides, 0 to 1. Of a canopy the share of the light that its leaves scatter, half of it to each side.
    pub diffuse: f64,
    /// Specular reflectance at any angle; 0 for glass.
    pub specular: f64,
    /// Clear glass, whose specular reflectance follows from the angle; `None` for all else.
    pub glass: Option<Glass>,
    /// Share of the light that goes straight on at each crossing of a canopy or a screen. `None` is opaque.
    pub transmittance: Option<f64>,
    /// First-hit class that its light counts for.
    pub class: Class,
    /// Materials of one group may follow a schedule at replay.
    pub group: Option<String>,
}

impl Material {
    /// A material without mirrors, panes or gaps.
    pub fn matt(name: impl Into<String>, diffuse: f64, class: Class) -> Self {
        Material { name: name.into(), diffuse, specular: 0.0, glass: None, transmittance: None, class, group: None }
    }

    /// Whether rays that meet it go on as from a mirror.
    pub fn mirrors(&self) -> bool {
        self.specular > 0.0 || self.glass.is_some()
    }

    /// Whether it is a canopy whose leaves scatter light.
    pub fn scatters(&self) -> bool {
        self.transmittance.is_some() && self.diffuse > 0.0
    }

    /// What it does with light, in words.
    pub fn optics(&self) -> String {
        let diffuse = rounded(self.diffuse);
        match (self.transmittance, self.glass) {
            (Some(transmittance), _) if self.diffuse > 0.0 => {
                format!("transmittance {}, diffuse {diffuse}", rounded(transmittance))
            }
            (Some(transmittance), _) => format!("transmittance {}", rounded(transmittance)),
            (None, Some(Glass::Single)) => format!("diffuse {diffuse}, glass"),
            (None, Some(Glass::Double)) => format!("diffuse {diffuse}, double glass"),
            (None, None) if self.specular > 0.0 => format!("diffuse {diffuse}, specular {}", rounded(self.specular)),
            (None, None) => format!("diffuse {diffuse}"),
        }
    }

    /// Says what is wrong with properties that this type must not hold.
    pub fn check(&self) -> std::result::Result<(), String> {
        let Material { diffuse, specular, .. } = *self;
        let transmittance = self.transmittance.unwrap_or(0.0);
        for (key, value) in [("diffuse", diffuse), ("specular", specular), ("transmittance", transmittance)] {
            if !(0.0..=1.0).contains(&value) {
                return Err(format!("`{key}` is {value}, not from 0 to 1"));
            }
        }
        if self.glass.is_some() && specular > 0.0 {
            return Err(format!("`glass` has the reflectance of its panes, not a `specular` of {specular}"));
        }
        if self.transmittance.is_some() && self.mirrors() {
            return Err("a material with `transmittance` is no mirror: `specular` is 0 and `glass` is false".into());
        }
        if diffuse + transmittance > 1.0 + 1e-12 {
            return Err(format!(
                "`diffuse` {diffuse} and `transmittance` {transmittance} add up to more than 1: more light than arrives"
            ));
        }
        // 0.7 + 0.3 may be the next number after 1.
        if diffuse + specular > 1.0 + 1e-12 {
            return Err(format!(
                "`diffuse` {diffuse} and `specular` {specular} add up to more than 1: more light than arrives"
            ));
        }
        Ok(())
    }
}

/// A share of light with at most four digits behind the point, as people read it.
pub fn rounded(share: f64) -> f64 {
    (share * 1e4).round() / 1e4
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 0.2, 0.0625 and 0.12345678 are shown as 0.2, 0.0625 and 0.1235.
    #[test]
    fn shown() {
        let shown = [0.2, 0.0625, 0.123_456_78].map(|diffuse| Material::matt("m", diffuse, Class::Ground).optics());
        assert_eq!(shown, ["diffuse 0.2", "diffuse 0.0625", "diffuse 0.1235"]);
    }

    /// Both classes come back from their codes 0 and 1, which are their places in arrays; the other 254 numbers are none.
    #[test]
    fn codes() {
        assert_eq!([Class::Ground, Class::Obstruction].map(Class::code), [0, 1]);
        for (i, class) in Class::ALL.into_iter().enumerate() {
            assert_eq!((Class::of_code(class.code()), class.index()), (Some(class), i));
        }
        assert_eq!((0..=u8::MAX).filter(|&code| Class::of_code(code).is_none()).count(), 254);
    }
}
