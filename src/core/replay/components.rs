//! The value columns of results, and which of them are asked for.

use std::str::FromStr;

/// Ending of the value columns of sums over periods.
pub const SUM_SUFFIX: &str = "_kwh_m2";

/// A value column, in the order of [`crate::replay::values::TileValues`]: W/m2 means; sums add
/// [`SUM_SUFFIX`].
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
    /// The part of `sun_diffuse` that comes from ground, as what is seen first; in mirrors, the
    /// mirror is.
    SunDiffuseGround,
    /// ... from obstructions: all that is not ground.
    SunDiffuseObstruction,
    /// The part of `sky_diffuse` that comes from ground.
    SkyDiffuseGround,
    /// ... from obstructions.
    SkyDiffuseObstruction,
    /// The sum of the six in ultraviolet light.
    TotalUv,
    /// ... in what is seen.
    TotalVisible,
    /// ... in what plants live on.
    TotalPar,
    /// ... in near infrared light.
    TotalNir,
    /// Photons of what plants live on.
    Ppfd,
    /// Light as an eye is sensitive to it.
    Illuminance,
    /// The sum of the six in the first band of one's own.
    TotalOwn1,
    /// ... in the second.
    TotalOwn2,
    /// ... in the third.
    TotalOwn3,
    /// ... in the fourth.
    TotalOwn4,
    /// ... in the fifth.
    TotalOwn5,
    /// ... in the sixth.
    TotalOwn6,
    /// ... in the seventh.
    TotalOwn7,
    /// ... in the eighth.
    TotalOwn8,
}

/// What a column measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightMeasure {
    /// W/m2; kWh/m2 in sums.
    Irradiance,
    /// Photons of 400 to 700 nm, umol/(m2 s); mol/m2 in sums.
    PhotonFlux,
    /// Lux; klx h in sums.
    Illuminance,
}

impl LightMeasure {
    /// Ending of columns of sums.
    pub fn sum_suffix(self) -> &'static str {
        match self {
            LightMeasure::Irradiance => SUM_SUFFIX,
            LightMeasure::PhotonFlux => "_mol_m2",
            LightMeasure::Illuminance => "_klx_h",
        }
    }

    /// What sums over hours / 1000 are taken times to be in their unit: a flux of photons counts by
    /// the second.
    pub fn sum_factor(self) -> f64 {
        match self {
            LightMeasure::PhotonFlux => 3.6,
            LightMeasure::Irradiance | LightMeasure::Illuminance => 1.0,
        }
    }
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
    pub const FURTHER: [Component; 11] = [
        Component::Longwave,
        Component::SunDiffuseGround,
        Component::SunDiffuseObstruction,
        Component::SkyDiffuseGround,
        Component::SkyDiffuseObstruction,
        Component::TotalUv,
        Component::TotalVisible,
        Component::TotalPar,
        Component::TotalNir,
        Component::Ppfd,
        Component::Illuminance,
    ];

    /// Columns of bands of one's own, in their order; results name them after the bands.
    pub const OWN: [Component; 8] = [
        Component::TotalOwn1,
        Component::TotalOwn2,
        Component::TotalOwn3,
        Component::TotalOwn4,
        Component::TotalOwn5,
        Component::TotalOwn6,
        Component::TotalOwn7,
        Component::TotalOwn8,
    ];

    /// All columns, in the order of their numbers.
    pub fn every() -> impl Iterator<Item = Component> {
        Component::ALL.into_iter().chain(Component::FURTHER).chain(Component::OWN)
    }

    /// What it measures.
    pub fn measure(self) -> LightMeasure {
        match self {
            Component::Ppfd => LightMeasure::PhotonFlux,
            Component::Illuminance => LightMeasure::Illuminance,
            _ => LightMeasure::Irradiance,
        }
    }

    /// The two that a component is made of, by what is seen first: ground, obstructions.
    pub fn parts(self) -> Option<[Component; 2]> {
        match self {
            Component::SunDiffuse => Some([Component::SunDiffuseGround, Component::SunDiffuseObstruction]),
            Component::SkyDiffuse => Some([Component::SkyDiffuseGround, Component::SkyDiffuseObstruction]),
            _ => None,
        }
    }

    /// Number of all; components are numbered from 0 in this order.
    pub const COUNT: usize = Component::ALL.len() + Component::FURTHER.len() + Component::OWN.len();

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
            Component::TotalUv => "total_uv",
            Component::TotalVisible => "total_visible",
            Component::TotalPar => "total_par",
            Component::TotalNir => "total_nir",
            Component::Ppfd => "ppfd",
            Component::Illuminance => "illuminance",
            Component::TotalOwn1 => "total_own_1",
            Component::TotalOwn2 => "total_own_2",
            Component::TotalOwn3 => "total_own_3",
            Component::TotalOwn4 => "total_own_4",
            Component::TotalOwn5 => "total_own_5",
            Component::TotalOwn6 => "total_own_6",
            Component::TotalOwn7 => "total_own_7",
            Component::TotalOwn8 => "total_own_8",
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
            Component::TotalUv => "solar irradiance on the receiver, 280 to 380 nm",
            Component::TotalVisible => "solar irradiance on the receiver, 380 to 780 nm",
            Component::TotalPar => "solar irradiance on the receiver, 400 to 700 nm",
            Component::TotalNir => "solar irradiance on the receiver, 780 to 4000 nm",
            Component::Ppfd => "photosynthetic photon flux density on the receiver, 400 to 700 nm",
            Component::Illuminance => "illuminance on the receiver",
            Component::TotalOwn1
            | Component::TotalOwn2
            | Component::TotalOwn3
            | Component::TotalOwn4
            | Component::TotalOwn5
            | Component::TotalOwn6
            | Component::TotalOwn7
            | Component::TotalOwn8 => "solar irradiance on the receiver in a band of one's own",
        }
    }
}

/// Which components results hold, whatever their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ComponentSet(u32);

impl ComponentSet {
    /// Of [`Component::ALL`].
    pub const ALL: ComponentSet = ComponentSet(0x7f);

    /// The set of those listed.
    pub fn of(components: &[Component]) -> Self {
        ComponentSet(components.iter().fold(0, |set, component| set | 1 << *component as u32))
    }

    /// The components that are listed in one of both sets.
    #[must_use]
    pub fn union(self, other: ComponentSet) -> Self {
        ComponentSet(self.0 | other.0)
    }

    /// The components that are listed, in the order of their numbers.
    pub fn iter(self) -> impl Iterator<Item = Component> {
        Component::every().filter(move |component| self.contains(*component))
    }

    /// Whether a component is listed in the set.
    pub fn contains(self, component: Component) -> bool {
        self.0 & 1 << component as u32 != 0
    }

    /// Whether a component must be computed: it is asked for, or a part of the total that is, or
    /// one of its parts.
    pub fn needs(self, component: Component) -> bool {
        self.contains(component)
            || self.contains(Component::Total) && Component::ALL.contains(&component)
            || self.needs_parts(component)
    }

    /// Whether a component must be split by what is seen first.
    pub fn needs_parts(self, component: Component) -> bool {
        component.parts().is_some_and(|parts| parts.iter().any(|part| self.contains(*part)))
    }

    /// Number of components that values of the set are written for at most.
    pub fn places(self) -> usize {
        Component::ALL.len() + self.iter().filter(|component| !Component::ALL.contains(component)).count()
    }
}

/// Components in the order asked for: at least one, none twice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ComponentList {
    list: Vec<Component>,
    /// Columns of [`Component::OWN`], as they are called in these results.
    own: Vec<String>,
}

impl ComponentList {
    /// The six components and their total, in the order of their numbers.
    pub fn all() -> Self {
        ComponentList::listed(Component::ALL.to_vec())
    }

    /// One column.
    pub fn of(component: Component) -> Self {
        ComponentList::listed(vec![component])
    }

    fn listed(list: Vec<Component>) -> Self {
        ComponentList { list, own: Vec::new() }
    }

    /// The list with `further` columns behind those that it has; a column that it has already is
    /// not added. `own` names the first of [`Component::OWN`].
    #[must_use]
    pub fn with(mut self, further: &[Component], own: Vec<String>) -> Self {
        for component in further {
            if !self.list.contains(component) {
                self.list.push(*component);
            }
        }
        self.own = own;
        self
    }

    /// What a column is called in these results, without unit.
    pub fn name_of(&self, component: Component) -> &str {
        let own = Component::OWN.iter().position(|one| *one == component).and_then(|place| self.own.get(place));
        own.map_or(component.name(), String::as_str)
    }

    /// The columns, in the order that they are asked for.
    pub fn as_slice(&self) -> &[Component] {
        &self.list
    }

    /// Place of the one that stands for all: the total, or else the first.
    pub fn main_place(&self) -> usize {
        self.list.iter().position(|one| *one == Component::Total).unwrap_or_default()
    }

    /// The one that stands for all.
    pub fn main(&self) -> Component {
        self.list.get(self.main_place()).copied().unwrap_or(Component::Total)
    }

    /// The same without order.
    pub fn set(&self) -> ComponentSet {
        ComponentSet::of(&self.list)
    }
}

/// `total,sun_direct`: names with or without the ending of sums.
impl FromStr for ComponentList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = || Component::ALL.into_iter().chain(Component::FURTHER);
        let mut list = Vec::new();
        for part in text.split(',').map(str::trim) {
            let is_named = |c: &Component| part.strip_suffix(c.measure().sum_suffix()).unwrap_or(part) == c.name();
            let Some(component) = known().find(is_named) else {
                let names: Vec<&str> = known().map(Component::name).collect();
                return Err(format!("`{part}` is no column, name some of {}", names.join(", ")));
            };
            if list.contains(&component) {
                return Err(format!("`{}` stands there twice", component.name()));
            }
            list.push(component);
        }
        Ok(ComponentList::listed(list))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two names, one with the ending of sums, come in the order asked; the set holds 2 and needs
    /// all 7 for the total, and 1 without it.
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

    /// A part of sun_diffuse needs it, 1 of 1, and is no part of the total; both its parts take 2
    /// places beside the 7.
    #[test]
    fn parts() {
        let list: ComponentList = "sun_diffuse_ground,sun_diffuse_obstruction_kwh_m2".parse().expect("names");
        assert_eq!(list.as_slice(), Component::SunDiffuse.parts().expect("two parts"));
        assert_eq!(list.set().places(), 9);
        assert!(list.set().needs(Component::SunDiffuse) && list.set().needs_parts(Component::SunDiffuse));
        assert!(!list.set().needs(Component::SkyDiffuse) && !ComponentSet::ALL.needs_parts(Component::SunDiffuse));
    }

    /// Longwave irradiance is asked for by name, 1 of 1, is no part of the total, and takes an
    /// eighth place.
    #[test]
    fn longwave() {
        let list: ComponentList = "longwave_kwh_m2".parse().expect("a name");
        assert_eq!(list.as_slice(), [Component::Longwave]);
        assert_eq!((list.set().places(), ComponentSet::ALL.places()), (8, 7));
        assert!(list.set().needs(Component::Longwave) && !ComponentSet::ALL.needs(Component::Longwave));
        assert!(!list.set().needs(Component::SunDirect));
    }

    /// An unknown name is refused with all 18 names, an empty one and a repeated one too: 3 of 3.
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
