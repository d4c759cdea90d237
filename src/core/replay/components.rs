//! Value columns of results, and sets and lists of them.

use std::str::FromStr;

use heliotile_requests::{Problem, Wrong};

/// Ending of the value columns of sums over periods.
pub const SUM_SUFFIX: &str = "_kwh_m2";

/// Value column, in the order of [`crate::replay::values::TileValues`]. Means are in W/m2; the
/// names of sums end with [`SUM_SUFFIX`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Component {
    /// Irradiance from the sun's disc, seen directly or through canopies.
    SunDirect,
    /// Irradiance from the sky, seen directly or through canopies.
    SkyDirect,
    /// Irradiance from the sun by at least one diffuse reflection.
    SunReflected,
    /// Irradiance from the sky by at least one diffuse reflection.
    SkyReflected,
    /// Irradiance from the sun by way of mirrors only.
    SunMirrored,
    /// Irradiance from the sky by way of mirrors only.
    SkyMirrored,
    /// Sum of the six components.
    Total,
    /// Longwave irradiance from sky, ground and obstructions by their temperatures; no part of the
    /// total.
    Longwave,
    /// Part of `sun_reflected` whose first surface seen from the receiver is ground. Where the
    /// receiver sees light in a mirror, the mirror is that surface.
    SunReflectedGround,
    /// Part of `sun_reflected` whose first surface seen is an obstruction: all that is not ground.
    SunReflectedObstruction,
    /// Part of `sky_reflected` whose first surface seen is ground.
    SkyReflectedGround,
    /// Part of `sky_reflected` whose first surface seen is an obstruction.
    SkyReflectedObstruction,
    /// Sum of the six components in ultraviolet light, 280 to 380 nm.
    TotalUv,
    /// Sum of the six components in visible light, 380 to 780 nm.
    TotalVisible,
    /// Sum of the six components in photosynthetically active radiation, 400 to 700 nm.
    TotalPar,
    /// Sum of the six components in near infrared light, 780 to 4000 nm.
    TotalNir,
    /// Photosynthetic photon flux density, 400 to 700 nm.
    Ppfd,
    /// Illuminance.
    Illuminance,
    /// Sum of the six components in the user's first band.
    TotalOwn1,
    /// Sum of the six components in the user's second band.
    TotalOwn2,
    /// Sum of the six components in the user's third band.
    TotalOwn3,
    /// Sum of the six components in the user's fourth band.
    TotalOwn4,
    /// Sum of the six components in the user's fifth band.
    TotalOwn5,
    /// Sum of the six components in the user's sixth band.
    TotalOwn6,
    /// Sum of the six components in the user's seventh band.
    TotalOwn7,
    /// Sum of the six components in the user's eighth band.
    TotalOwn8,
}

/// Quantity that a column measures.
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
    /// Returns the ending of the names of columns of sums.
    pub fn sum_suffix(self) -> &'static str {
        match self {
            LightMeasure::Irradiance => SUM_SUFFIX,
            LightMeasure::PhotonFlux => "_mol_m2",
            LightMeasure::Illuminance => "_klx_h",
        }
    }

    /// Returns the factor that brings sums over hours / 1000 into the unit of the column. It is 3.6
    /// for a photon flux, which counts by the second.
    pub fn sum_factor(self) -> f64 {
        match self {
            LightMeasure::PhotonFlux => 3.6,
            LightMeasure::Irradiance | LightMeasure::Illuminance => 1.0,
        }
    }
}

impl Component {
    /// The six components and their total: the columns of results by default.
    pub const ALL: [Component; 7] = [
        Component::SunDirect,
        Component::SkyDirect,
        Component::SunReflected,
        Component::SkyReflected,
        Component::SunMirrored,
        Component::SkyMirrored,
        Component::Total,
    ];

    /// Columns that results hold only if they are named, besides the user's bands.
    pub const FURTHER: [Component; 11] = [
        Component::Longwave,
        Component::SunReflectedGround,
        Component::SunReflectedObstruction,
        Component::SkyReflectedGround,
        Component::SkyReflectedObstruction,
        Component::TotalUv,
        Component::TotalVisible,
        Component::TotalPar,
        Component::TotalNir,
        Component::Ppfd,
        Component::Illuminance,
    ];

    /// Columns of the user's bands, in their order. Results name them after the bands.
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

    /// Returns all columns, in the order of their numbers.
    pub fn every() -> impl Iterator<Item = Component> {
        Component::ALL.into_iter().chain(Component::FURTHER).chain(Component::OWN)
    }

    /// Returns the quantity that the column measures.
    pub fn measure(self) -> LightMeasure {
        match self {
            Component::Ppfd => LightMeasure::PhotonFlux,
            Component::Illuminance => LightMeasure::Illuminance,
            _ => LightMeasure::Irradiance,
        }
    }

    /// Returns the two parts that a component is split into by the first surface seen: ground,
    /// obstructions.
    pub fn parts(self) -> Option<[Component; 2]> {
        match self {
            Component::SunReflected => Some([Component::SunReflectedGround, Component::SunReflectedObstruction]),
            Component::SkyReflected => Some([Component::SkyReflectedGround, Component::SkyReflectedObstruction]),
            _ => None,
        }
    }

    /// Number of all components, which are numbered from 0 in the order of [`Component::every`].
    pub const COUNT: usize = Component::ALL.len() + Component::FURTHER.len() + Component::OWN.len();

    /// Returns the name of the column in results of means, without unit: `sun_direct`.
    pub fn name(self) -> &'static str {
        match self {
            Component::SunDirect => "sun_direct",
            Component::SkyDirect => "sky_direct",
            Component::SunReflected => "sun_reflected",
            Component::SkyReflected => "sky_reflected",
            Component::SunMirrored => "sun_mirrored",
            Component::SkyMirrored => "sky_mirrored",
            Component::Total => "total",
            Component::Longwave => "longwave",
            Component::SunReflectedGround => "sun_reflected_ground",
            Component::SunReflectedObstruction => "sun_reflected_obstruction",
            Component::SkyReflectedGround => "sky_reflected_ground",
            Component::SkyReflectedObstruction => "sky_reflected_obstruction",
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

    /// Returns the light path in words.
    pub fn meaning(self) -> &'static str {
        match self {
            Component::SunDirect => "irradiance on the receiver from the sun's disc",
            Component::SkyDirect => "irradiance on the receiver from the sky",
            Component::SunReflected => "irradiance on the receiver from the sun by diffuse reflection",
            Component::SkyReflected => "irradiance on the receiver from the sky by diffuse reflection",
            Component::SunMirrored => "irradiance on the receiver from the sun by mirrors",
            Component::SkyMirrored => "irradiance on the receiver from the sky by mirrors",
            Component::Total => "solar irradiance on the receiver",
            Component::Longwave => "infrared irradiance on the receiver",
            Component::SunReflectedGround => {
                "irradiance on the receiver from the sun by diffuse reflection, ground seen first"
            }
            Component::SunReflectedObstruction => {
                "irradiance on the receiver from the sun by diffuse reflection, obstructions seen first"
            }
            Component::SkyReflectedGround => {
                "irradiance on the receiver from the sky by diffuse reflection, ground seen first"
            }
            Component::SkyReflectedObstruction => {
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
            | Component::TotalOwn8 => "solar irradiance on the receiver in a user-defined band",
        }
    }
}

/// Set of components that results hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ComponentSet(u32);

impl ComponentSet {
    /// Components of [`Component::ALL`].
    pub const ALL: ComponentSet = ComponentSet(0x7f);

    /// Returns the set of the listed components.
    pub fn new(components: &[Component]) -> Self {
        ComponentSet(components.iter().fold(0, |set, component| set | 1 << *component as u32))
    }

    /// Returns the components that at least one of the two sets contains.
    #[must_use]
    pub fn union(self, other: ComponentSet) -> Self {
        ComponentSet(self.0 | other.0)
    }

    /// Returns the components of the set, in the order of their numbers.
    pub fn iter(self) -> impl Iterator<Item = Component> {
        Component::every().filter(move |component| self.contains(*component))
    }

    /// Returns true if the set contains a component.
    pub fn contains(self, component: Component) -> bool {
        self.0 & 1 << component as u32 != 0
    }

    /// Returns true if a component must be computed: the set contains the component, one of its
    /// parts, or the total while the component is part of it.
    pub fn needs(self, component: Component) -> bool {
        self.contains(component)
            || self.contains(Component::Total) && Component::ALL.contains(&component)
            || self.needs_parts(component)
    }

    /// Returns true if a component must be split by the first surface seen.
    pub fn needs_parts(self, component: Component) -> bool {
        component.parts().is_some_and(|parts| parts.iter().any(|part| self.contains(*part)))
    }

    /// Returns the largest number of components for which values of the set are written.
    pub fn places(self) -> usize {
        Component::ALL.len() + self.iter().filter(|component| !Component::ALL.contains(component)).count()
    }
}

/// Components in the order of the request: at least one, each once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ComponentList {
    list: Vec<Component>,
    /// Names of the columns of [`Component::OWN`] in these results.
    own: Vec<String>,
}

impl ComponentList {
    /// Returns the six components and their total, in the order of their numbers.
    pub fn all() -> Self {
        ComponentList::listed(Component::ALL.to_vec())
    }

    /// Returns the list of one column.
    pub fn new(component: Component) -> Self {
        ComponentList::listed(vec![component])
    }

    fn listed(list: Vec<Component>) -> Self {
        ComponentList { list, own: Vec::new() }
    }

    /// Appends the `further` columns that the list does not have yet. `own` holds the names of the
    /// first columns of [`Component::OWN`].
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

    /// Returns the name of a column in these results, without unit.
    pub fn name_of(&self, component: Component) -> &str {
        let own = Component::OWN.iter().position(|one| *one == component).and_then(|place| self.own.get(place));
        own.map_or(component.name(), String::as_str)
    }

    /// Returns the columns in the order of the request.
    pub fn as_slice(&self) -> &[Component] {
        &self.list
    }

    /// Returns the place of the main column: the total, or else the first.
    pub fn main_place(&self) -> usize {
        self.list.iter().position(|one| *one == Component::Total).unwrap_or_default()
    }

    /// Returns the main column: the total, or else the first.
    pub fn main(&self) -> Component {
        self.list.get(self.main_place()).copied().unwrap_or(Component::Total)
    }

    /// Returns the columns as a set, without order.
    pub fn set(&self) -> ComponentSet {
        ComponentSet::new(&self.list)
    }
}

/// Returns the name that a column has now, for a name of earlier versions, with its ending.
fn renamed(name: &str) -> Option<String> {
    let now = name.replacen("_diffuse", "_reflected", 1).replacen("_specular", "_mirrored", 1);
    let known = || Component::every().any(|c| now.strip_suffix(c.measure().sum_suffix()).unwrap_or(&now) == c.name());
    (now != name && known()).then_some(now)
}

/// Parses `total,sun_direct`: names with or without the ending of sums.
impl FromStr for ComponentList {
    type Err = Wrong;

    fn from_str(text: &str) -> Result<Self, Wrong> {
        let known = || Component::ALL.into_iter().chain(Component::FURTHER);
        let mut list = Vec::new();
        for part in text.split(',').map(str::trim) {
            let is_named = |c: &Component| part.strip_suffix(c.measure().sum_suffix()).unwrap_or(part) == c.name();
            let Some(component) = known().find(is_named) else {
                if let Some(now) = renamed(part) {
                    return Err(format!("the column `{part}` is now called `{now}`").into());
                }
                let names: Vec<&str> = known().map(Component::name).collect();
                let what = format!("`{part}` is not a known column; known columns: {}", names.join(", "));
                return Err(Wrong { problem: Problem::unknown(part, names), ..what.into() });
            };
            if list.contains(&component) {
                let what = format!("`{}` is named twice", component.name());
                return Err(Wrong { problem: Problem::duplicate(component.name()), ..what.into() });
            }
            list.push(component);
        }
        Ok(ComponentList::listed(list))
    }
}

heliotile_requests::parse_by_text!(ComponentList: heliotile_requests::Form::TEXT);

#[cfg(test)]
mod tests {
    use super::*;

    /// Two names, one with the ending of sums, keep the order of the request. The set holds 2
    /// components; it needs all 7 for the total, and 1 without it.
    #[test]
    fn lists_keep_the_order_of_the_request() {
        let list: ComponentList = "total_kwh_m2, sky_direct".parse().expect("names");
        assert_eq!(list.as_slice(), [Component::Total, Component::SkyDirect]);
        let count = |with: &dyn Fn(Component) -> bool| Component::ALL.into_iter().filter(|c| with(*c)).count();
        assert_eq!((count(&|c| list.set().contains(c)), count(&|c| list.set().needs(c))), (2, 7));
        let one = ComponentSet::new(&[Component::SunReflected]);
        assert_eq!(count(&|c| one.needs(c)), 1);
        assert_eq!(ComponentList::all().set(), ComponentSet::ALL);
    }

    /// A part of `sun_reflected` needs that component, 1 of 1, and is no part of the total. Its two
    /// parts take 2 places beside the 7.
    #[test]
    fn parts_of_a_component_are_no_part_of_the_total() {
        let list: ComponentList = "sun_reflected_ground,sun_reflected_obstruction_kwh_m2".parse().expect("names");
        assert_eq!(list.as_slice(), Component::SunReflected.parts().expect("two parts"));
        assert_eq!(list.set().places(), 9);
        assert!(list.set().needs(Component::SunReflected) && list.set().needs_parts(Component::SunReflected));
        assert!(!list.set().needs(Component::SkyReflected) && !ComponentSet::ALL.needs_parts(Component::SunReflected));
    }

    /// Longwave irradiance is requested by name, 1 of 1, is no part of the total, and takes an
    /// eighth place.
    #[test]
    fn longwave_is_no_part_of_the_total() {
        let list: ComponentList = "longwave_kwh_m2".parse().expect("a name");
        assert_eq!(list.as_slice(), [Component::Longwave]);
        assert_eq!((list.set().places(), ComponentSet::ALL.places()), (8, 7));
        assert!(list.set().needs(Component::Longwave) && !ComponentSet::ALL.needs(Component::Longwave));
        assert!(!list.set().needs(Component::SunDirect));
    }

    /// An unknown name is refused with all 18 names, an empty one and a repeated one too: 3 of 3. 2
    /// of 2 names of earlier versions are refused with the name of today.
    #[test]
    fn unknown_empty_and_repeated_names_are_refused() {
        let refused = |text: &str| text.parse::<ComponentList>().expect_err(text);
        let earlier = refused("total,sky_diffuse_ground_kwh_m2");
        assert!(earlier.what.ends_with("is now called `sky_reflected_ground_kwh_m2`"), "{earlier}");
        assert!(refused("sun_specular").what.ends_with("is now called `sun_mirrored`"));
        let unknown = refused("sun");
        assert!(
            Component::ALL.into_iter().chain(Component::FURTHER).all(|c| unknown.what.contains(c.name()))
                && unknown.what.contains("`sun`"),
            "{unknown}"
        );
        assert!(refused("total,").what.contains("`` is not a known column"));
        assert!(refused("total,total_kwh_m2").what.contains("`total` is named twice"));
    }
}
