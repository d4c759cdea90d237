//! The value columns of results, and which of them are asked for.

use std::str::FromStr;

/// Ending of the value columns of sums over periods.
pub const SUM_SUFFIX: &str = "_kwh_m2";

/// A value column, in the order of [`super::values::TileValues`]: W/m2 means; sums add [`SUM_SUFFIX`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    SunDirect,
    SkyDirect,
    SunDiffuse,
    SkyDiffuse,
    SunSpecular,
    SkySpecular,
    /// The sum of the six.
    Total,
}

impl Component {
    pub const ALL: [Component; 7] = [
        Component::SunDirect,
        Component::SkyDirect,
        Component::SunDiffuse,
        Component::SkyDiffuse,
        Component::SunSpecular,
        Component::SkySpecular,
        Component::Total,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Component::SunDirect => "sun_direct",
            Component::SkyDirect => "sky_direct",
            Component::SunDiffuse => "sun_diffuse",
            Component::SkyDiffuse => "sky_diffuse",
            Component::SunSpecular => "sun_specular",
            Component::SkySpecular => "sky_specular",
            Component::Total => "total",
        }
    }
}

/// Which components results hold, whatever their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ComponentSet(u8);

impl ComponentSet {
    pub const ALL: ComponentSet = ComponentSet(0x7f);

    pub fn of(components: &[Component]) -> Self {
        ComponentSet(components.iter().fold(0, |set, component| set | 1 << *component as u8))
    }

    pub fn contains(self, component: Component) -> bool {
        self.0 & 1 << component as u8 != 0
    }

    /// Whether a component must be computed: it is asked for, or a part of the total that is.
    pub fn needs(self, component: Component) -> bool {
        self.contains(component) || self.contains(Component::Total)
    }
}

/// Components in the order asked for: at least one, none twice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ComponentList(Vec<Component>);

impl ComponentList {
    pub fn all() -> Self {
        ComponentList(Component::ALL.to_vec())
    }

    pub fn as_slice(&self) -> &[Component] {
        &self.0
    }

    pub fn set(&self) -> ComponentSet {
        ComponentSet::of(&self.0)
    }
}

/// `total,sun_direct`: names with or without [`SUM_SUFFIX`].
impl FromStr for ComponentList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut list = Vec::new();
        for part in text.split(',').map(str::trim) {
            let name = part.strip_suffix(SUM_SUFFIX).unwrap_or(part);
            let Some(component) = Component::ALL.into_iter().find(|c| c.name() == name) else {
                let names = Component::ALL.map(Component::name).join(", ");
                return Err(format!("`{part}` is no column, name some of {names}"));
            };
            if list.contains(&component) {
                return Err(format!("`{name}` stands there twice"));
            }
            list.push(component);
        }
        Ok(ComponentList(list))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two names, one with the ending of sums, come in the order asked; the set holds 2 and needs all 7 for the total, and 1
    /// without it.
    #[test]
    fn lists_and_sets() {
        let list: ComponentList = "total_kwh_m2, sky_direct".parse().expect("names");
        assert_eq!(list.as_slice(), [Component::Total, Component::SkyDirect]);
        let count = |with: &dyn Fn(Component) -> bool| Component::ALL.into_iter().filter(|c| with(*c)).count();
        assert_eq!((count(&|c| list.set().contains(c)), count(&|c| list.set().needs(c))), (2, 7));
        let one = ComponentSet::of(&[Component::SunDiffuse]);
        assert_eq!(count(&|c| one.needs(c)), 1);
        assert_eq!(ComponentList::all().set(), ComponentSet::ALL);
    }

    /// An unknown name is refused with all 7 names, an empty one and a repeated one too: 3 of 3.
    #[test]
    fn refusals() {
        let refused = |text: &str| text.parse::<ComponentList>().expect_err(text);
        let unknown = refused("sun");
        assert!(
            Component::ALL.into_iter().all(|c| unknown.contains(c.name())) && unknown.contains("`sun`"),
            "{unknown}"
        );
        assert!(refused("total,").contains("`` is no column"));
        assert!(refused("total,total_kwh_m2").contains("`total` stands there twice"));
    }
}
