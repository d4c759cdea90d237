//! The value columns of results, and which of them are asked for.

use std::str::FromStr;

/// Ending of the value columns of sums over periods.
pub const SUM_SUFFIX: &str = "_kwh_m2";

/// A value column, in the order of [`crate::replay::values::TileValues`]: W/m2 means; sums add [`SUM_SUFFIX`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Component {
    /// The sun's disc, seen directly or through canopies.
    SunDirect,
    /// The sky, seen directly or through canopies.
    SkyDirect,
    /// The sun, by at least one diffuse reflection.
    SunDiffuse,
    /// The sky, by at least one diffuse reflection.
    SkyDiffuse,
    /// The sun, by way of mirrors only.
    SunSpecular,
    /// The sky, by way of mirrors only.
    SkySpecular,
    /// The sum of the six.
    Total,
    /// Of sky, ground and obstructions by their temperatures; no part of the total.
    Longwave,
    /// The part of `sun_diffuse` that comes from ground, as what is seen first; in mirrors, the mirror is.
    SunDiffuseGround,
    /// ... from obstructions: all that is not ground.
    SunDiffuseObstruction,
    /// The part of `sky_diffuse` that comes from ground.
    SkyDiffuseGround,
    /// ... from obstructions.
    SkyDiffuseObstruction,
}

impl Component {
    /// All columns of light: those of results if nothing is chosen.
    pub const ALL: [Component; 7] = [
        Component::SunDirect,
        Component::SkyDirect,
        Component::SunDiffuse,
        Component::SkyDiffuse,
        Component::SunSpecular,
        Component::SkySpecular,
        Component::Total,
    ];

    /// Columns beyond them, for results that name them.
    pub const FURTHER: [Component; 5] = [
        Component::Longwave,
        Component::SunDiffuseGround,
        Component::SunDiffuseObstruction,
        Component::SkyDiffuseGround,
        Component::SkyDiffuseObstruction,
    ];

    /// The two that a component is made of, by what is seen first: ground, obstructions.
    pub fn parts(self) -> Option<[Component; 2]> {
        match self {
            Component::SunDiffuse => Some([Component::SunDiffuseGround, Component::SunDiffuseObstruction]),
            Component::SkyDiffuse => Some([Component::SkyDiffuseGround, Component::SkyDiffuseObstruction]),
            _ => None,
        }
    }

    /// Number of both; components are numbered from 0 in this order.
    pub const COUNT: usize = Component::ALL.len() + Component::FURTHER.len();

    /// Its column in results of means, without unit: `sun_direct`.
    pub fn name(self) -> &'static str {
        match self {
            Component::SunDirect => "sun_direct",
            Component::SkyDirect => "sky_direct",
            Component::SunDiffuse => "sun_diffuse",
            Component::SkyDiffuse => "sky_diffuse",
            Component::SunSpecular => "sun_specular",
            Component::SkySpecular => "sky_specular",
            Component::Total => "total",
            Component::Longwave => "longwave",
            Component::SunDiffuseGround => "sun_diffuse_ground",
            Component::SunDiffuseObstruction => "sun_diffuse_obstruction",
            Component::SkyDiffuseGround => "sky_diffuse_ground",
            Component::SkyDiffuseObstruction => "sky_diffuse_obstruction",
        }
    }

    /// The light path in words.
    pub fn meaning(self) -> &'static str {
        match self {
            Component::SunDirect => "irradiance on the receiver from the sun's disc",
            Component::SkyDirect => "irradiance on the receiver from the sky",
            Component::SunDiffuse => "irradiance on the receiver from the sun by diffuse reflection",
            Component::SkyDiffuse => "irradiance on the receiver from the sky by diffuse reflection",
            Component::SunSpecular => "irradiance on the receiver from the sun by mirrors",
            Component::SkySpecular => "irradiance on the receiver from the sky by mirrors",
            Component::Total => "solar irradiance on the receiver",
            Component::Longwave => "infrared irradiance on the receiver",
            Component::SunDiffuseGround => {
                "irradiance on the receiver from the sun by diffuse reflection, ground seen first"
            }
            Component::SunDiffuseObstruction => {
                "irradiance on the receiver from the sun by diffuse reflection, obstructions seen first"
            }
            Component::SkyDiffuseGround => {
                "irradiance on the receiver from the sky by diffuse reflection, ground seen first"
            }
            Component::SkyDiffuseObstruction => {
                "irradiance on the receiver from the sky by diffuse reflection, obstructions seen first"
            }
        }
    }
}

/// Which components results hold, whatever their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ComponentSet(u16);

impl ComponentSet {
    /// Of [`Component::ALL`].
    pub const ALL: ComponentSet = ComponentSet(0x7f);

    /// The set of those listed.
    pub fn of(components: &[Component]) -> Self {
        ComponentSet(components.iter().fold(0, |set, component| set | 1 << *component as u16))
    }

    /// The components that are listed in one of both sets.
    #[must_use]
    pub fn union(self, other: ComponentSet) -> Self {
        ComponentSet(self.0 | other.0)
    }

    /// The components that are listed, in the order of their numbers.
    pub fn iter(self) -> impl Iterator<Item = Component> {
        Component::ALL.into_iter().chain(Component::FURTHER).filter(move |component| self.contains(*component))
    }

    /// Whether a component is listed in the set.
    pub fn contains(self, component: Component) -> bool {
        self.0 & 1 << component as u16 != 0
    }

    /// Whether a component must be computed: it is asked for, or a part of the total that is, or one of its parts.
    pub fn needs(self, component: Component) -> bool {
        self.contains(component)
            || self.contains(Component::Total) && !Component::FURTHER.contains(&component)
            || self.needs_parts(component)
    }

    /// Whether a component must be split by what is seen first.
    pub fn needs_parts(self, component: Component) -> bool {
        component.parts().is_some_and(|parts| parts.iter().any(|part| self.contains(*part)))
    }

    /// Number of components that values of the set are written for at most.
    pub fn places(self) -> usize {
        let further = Component::FURTHER.iter().filter(|component| self.contains(**component)).count();
        Component::ALL.len() + further
    }
}

/// Components in the order asked for: at least one, none twice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ComponentList(Vec<Component>);

impl ComponentList {
    /// The six components and their total, in the order of their numbers.
    pub fn all() -> Self {
        ComponentList(Component::ALL.to_vec())
    }

    /// One column.
    pub fn of(component: Component) -> Self {
        ComponentList(vec![component])
    }

    /// The columns, in the order that they are asked for.
    pub fn as_slice(&self) -> &[Component] {
        &self.0
    }

    /// Place of the one that stands for all: the total, or else the first.
    pub fn main_place(&self) -> usize {
        self.0.iter().position(|one| *one == Component::Total).unwrap_or_default()
    }

    /// The one that stands for all.
    pub fn main(&self) -> Component {
        self.0.get(self.main_place()).copied().unwrap_or(Component::Total)
    }

    /// The same without order.
    pub fn set(&self) -> ComponentSet {
        ComponentSet::of(&self.0)
    }
}

/// `total,sun_direct`: names with or without [`SUM_SUFFIX`].
impl FromStr for ComponentList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = || Component::ALL.into_iter().chain(Component::FURTHER);
        let mut list = Vec::new();
        for part in text.split(',').map(str::trim) {
            let name = part.strip_suffix(SUM_SUFFIX).unwrap_or(part);
            let Some(component) = known().find(|c| c.name() == name) else {
                let names: Vec<&str> = known().map(Component::name).collect();
                return Err(format!("`{part}` is no column, name some of {}", names.join(", ")));
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

    /// A part of sun_diffuse needs it, 1 of 1, and is no part of the total; both its parts take 2 places beside the 7.
    #[test]
    fn parts() {
        let list: ComponentList = "sun_diffuse_ground,sun_diffuse_obstruction_kwh_m2".parse().expect("names");
        assert_eq!(list.as_slice(), Component::SunDiffuse.parts().expect("two parts"));
        assert_eq!(list.set().places(), 9);
        assert!(list.set().needs(Component::SunDiffuse) && list.set().needs_parts(Component::SunDiffuse));
        assert!(!list.set().needs(Component::SkyDiffuse) && !ComponentSet::ALL.needs_parts(Component::SunDiffuse));
    }

    /// Longwave irradiance is asked for by name, 1 of 1, is no part of the total, and takes an eighth place.
    #[test]
    fn longwave() {
        let list: ComponentList = "longwave_kwh_m2".parse().expect("a name");
        assert_eq!(list.as_slice(), [Component::Longwave]);
        assert_eq!((list.set().places(), ComponentSet::ALL.places()), (8, 7));
        assert!(list.set().needs(Component::Longwave) && !ComponentSet::ALL.needs(Component::Longwave));
        assert!(!list.set().needs(Component::SunDirect));
    }

    /// An unknown name is refused with all 12 names, an empty one and a repeated one too: 3 of 3.
    #[test]
    fn refusals() {
        let refused = |text: &str| text.parse::<ComponentList>().expect_err(text);
        let unknown = refused("sun");
        assert!(
            Component::ALL.into_iter().chain(Component::FURTHER).all(|c| unknown.contains(c.name()))
                && unknown.contains("`sun`"),
            "{unknown}"
        );
        assert!(refused("total,").contains("`` is no column"));
        assert!(refused("total,total_kwh_m2").contains("`total` stands there twice"));
    }
}
