//! EPSG numbers of plane systems by their parameters. In: a projection with its parameters, as
//! well-known text or a PROJ definition states them. Out: the EPSG number of the system with equal
//! parameters.

/// Largest differences between parameters that are still equal: angles in degrees, lengths in
/// metres, and relative differences of factors.
const DEGREES: f64 = 1e-5;
const METRES: f64 = 0.05;
const SHARE: f64 = 1e-7;

/// Range of EPSG numbers that are compared: those whose parameters `crs_definitions` may know.
const NUMBERS: std::ops::Range<u16> = 1024..32_767;

/// A projection with its parameters; a parameter that it does not have is 0, a factor 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Projection {
    /// Name of the projection in PROJ.
    kind: &'static str,
    latitude_deg: f64,
    longitude_deg: f64,
    /// Standard parallels, degrees, the smaller one first.
    parallels_deg: [f64; 2],
    factor: f64,
    easting_m: f64,
    northing_m: f64,
    unit_m: f64,
    /// Semi-major axis of the ellipsoid, metres.
    half_axis_m: f64,
}

/// Hint that tells the systems of a datum from those of other datums with the same ellipsoid.
struct DatumHint {
    /// Parts of the datum's names, in upper case.
    names: &'static [&'static str],
    /// Part of the PROJ definitions of its systems.
    words: &'static str,
    /// Usual range of the EPSG numbers of its systems, such as its UTM zones.
    usual: std::ops::Range<u16>,
}

const HINTS: [DatumHint; 7] = [
    DatumHint {
        names: &["WGS_1984", "WGS 84", "WGS84", "WORLD GEODETIC"],
        words: "+datum=WGS84",
        usual: 32_600..32_800,
    },
    DatumHint { names: &["ETRS", "EUROPEAN TERRESTRIAL"], words: "+ellps=GRS80 +towgs84=0", usual: 25_800..25_900 },
    DatumHint { names: &["2011"], words: "+ellps=GRS80 +units", usual: 6300..6800 },
    DatumHint { names: &["HARN", "HIGH ACCURACY"], words: "+ellps=GRS80 +towgs84=0", usual: 2700..3000 },
    DatumHint {
        names: &["NAD_1983", "NAD83", "NORTH_AMERICAN_1983", "NORTH AMERICAN DATUM 1983"],
        words: "+datum=NAD83",
        usual: 26_900..27_000,
    },
    DatumHint { names: &["GDA2020", "GDA_2020"], words: "+ellps=GRS80", usual: 7800..7900 },
    DatumHint { names: &["GDA"], words: "+ellps=GRS80", usual: 28_300..28_400 },
];

/// PROJ names of the projections that are compared; they name their parameters alike.
const KINDS: [&str; 11] =
    ["tmerc", "lcc", "merc", "aea", "laea", "sterea", "stere", "somerc", "krovak", "cass", "poly"];

/// Names of projections in well-known text, in lower case, and in PROJ.
const METHODS: [(&str, &str); 27] = [
    ("transverse_mercator", "tmerc"),
    ("gauss_kruger", "tmerc"),
    ("lambert_conformal_conic", "lcc"),
    ("lambert_conformal_conic_1sp", "lcc"),
    ("lambert_conformal_conic_2sp", "lcc"),
    ("lambert_conic_conformal_(1sp)", "lcc"),
    ("lambert_conic_conformal_(2sp)", "lcc"),
    ("mercator", "merc"),
    ("mercator_1sp", "merc"),
    ("mercator_2sp", "merc"),
    ("mercator_(variant_a)", "merc"),
    ("albers", "aea"),
    ("albers_conic_equal_area", "aea"),
    ("albers_equal_area", "aea"),
    ("lambert_azimuthal_equal_area", "laea"),
    ("double_stereographic", "sterea"),
    ("oblique_stereographic", "sterea"),
    ("stereographic_north_pole", "stere"),
    ("stereographic_south_pole", "stere"),
    ("polar_stereographic", "stere"),
    ("hotine_oblique_mercator_azimuth_center", "somerc"),
    ("hotine_oblique_mercator", "somerc"),
    ("swiss_oblique_cylindrical", "somerc"),
    ("krovak", "krovak"),
    ("cassini", "cass"),
    ("cassini_soldner", "cass"),
    ("polyconic", "poly"),
];

/// Semi-major axes of ellipsoids, and of the ellipsoids of datums, by their PROJ names (its file
/// `ellps.cpp`), metres.
const HALF_AXES: [(&str, f64); 27] = [
    ("WGS84", 6_378_137.0),
    ("GRS80", 6_378_137.0),
    ("WGS72", 6_378_135.0),
    ("bessel", 6_377_397.155),
    ("bess_nam", 6_377_483.865),
    ("intl", 6_378_388.0),
    ("clrk66", 6_378_206.4),
    ("clrk80", 6_378_249.145),
    ("clrk80ign", 6_378_249.2),
    ("airy", 6_377_563.396),
    ("mod_airy", 6_377_340.189),
    ("krass", 6_378_245.0),
    ("aust_SA", 6_378_160.0),
    ("GRS67", 6_378_160.0),
    ("helmert", 6_378_200.0),
    ("evrst30", 6_377_276.345),
    ("evrstSS", 6_377_298.556),
    ("NAD83", 6_378_137.0),
    ("GGRS87", 6_378_137.0),
    ("NAD27", 6_378_206.4),
    ("potsdam", 6_377_397.155),
    ("hermannskogel", 6_377_397.155),
    ("OSGB36", 6_377_563.396),
    ("ire65", 6_377_340.189),
    ("nzgd49", 6_378_388.0),
    ("carthage", 6_378_249.2),
    ("evrst69", 6_377_295.664),
];

/// Returns the semi-major axis, in metres, of the ellipsoid of a geographic system.
pub(super) fn half_axis_of(epsg: u32) -> Option<f64> {
    let definition = crs_definitions::from_code(u16::try_from(epsg).ok()?)?.proj4;
    let mut words = definition.split_whitespace().filter_map(|word| word.strip_prefix('+')?.split_once('='));
    words.find_map(|(key, value)| match key {
        "a" => value.parse().ok(),
        "ellps" | "datum" => HALF_AXES.iter().find(|(name, _)| *name == value).map(|(_, metres)| *metres),
        _ => None,
    })
}

impl Projection {
    /// Returns a projection from the parameters of well-known text, whose lengths are in the unit
    /// of the plane.
    pub(super) fn of_parameters(
        method: &str,
        parameters: &[(String, f64)],
        unit_m: f64,
        half_axis_m: f64,
    ) -> Option<Projection> {
        let method = method.to_lowercase().replace(' ', "_");
        let (_, kind) = METHODS.iter().find(|(name, _)| *name == method)?;
        let get = |names: &[&str]| {
            parameters.iter().find(|(name, _)| names.contains(&name.as_str())).map(|(_, value)| *value)
        };
        // `somerc` of PROJ is this projection with an azimuth of 90 degrees.
        if *kind == "somerc"
            && get(&["azimuth", "azimuth_of_initial_line"]).is_some_and(|azimuth| (azimuth - 90.0).abs() > 1e-6)
        {
            return None;
        }
        let first = get(&["standard_parallel_1", "latitude_of_1st_standard_parallel"]);
        let second = get(&["standard_parallel_2", "latitude_of_2nd_standard_parallel"]);
        let latitude = get(&[
            "latitude_of_origin",
            "latitude_of_center",
            "latitude_of_natural_origin",
            "latitude_of_false_origin",
            "central_parallel",
        ]);
        let longitude = get(&[
            "central_meridian",
            "longitude_of_center",
            "longitude_of_origin",
            "longitude_of_natural_origin",
            "longitude_of_false_origin",
        ]);
        let easting = get(&["false_easting", "easting_at_false_origin", "easting_at_projection_centre"]);
        let northing = get(&["false_northing", "northing_at_false_origin", "northing_at_projection_centre"]);
        let found = Projection {
            kind,
            latitude_deg: latitude.unwrap_or_default(),
            longitude_deg: longitude.unwrap_or_default(),
            parallels_deg: [first, second].map(Option::unwrap_or_default),
            factor: get(&["scale_factor", "scale_factor_at_natural_origin"]).unwrap_or(1.0),
            easting_m: easting.unwrap_or_default() * unit_m,
            northing_m: northing.unwrap_or_default() * unit_m,
            unit_m,
            half_axis_m,
        };
        Some(found.polar(&method).in_order(second.is_some()))
    }

    /// Moves the true parallel of a polar projection to where PROJ has it: well-known text states
    /// it as the latitude, PROJ states the pole there.
    fn polar(mut self, method: &str) -> Projection {
        let pole = match method {
            "stereographic_north_pole" => 90.0,
            "stereographic_south_pole" => -90.0,
            "polar_stereographic" if self.latitude_deg.abs() < 90.0 => {
                self.parallels_deg = [self.latitude_deg, 0.0];
                90.0_f64.copysign(self.latitude_deg)
            }
            _ => return self,
        };
        self.latitude_deg = pole;
        self
    }

    /// Returns a projection from a PROJ definition.
    fn of_proj(definition: &str) -> Option<Projection> {
        let get = |key: &str| {
            let mut words = definition.split_whitespace().filter_map(|word| word.strip_prefix('+')?.split_once('='));
            words.find(|(name, _)| *name == key).map(|(_, value)| value)
        };
        let number = |key: &str| get(key).and_then(|text| text.parse::<f64>().ok());
        // Heights with a unit of their own make it a compound system; another prime meridian is not
        // compared.
        if get("vunits").is_some() || get("pm").is_some() {
            return None;
        }
        let ellipsoid =
            |key: &str| HALF_AXES.iter().find(|(name, _)| Some(*name) == get(key)).map(|(_, metres)| *metres);
        let half_axis_m = number("a").or_else(|| ellipsoid("ellps")).or_else(|| ellipsoid("datum"))?;
        let unit_m = match get("units") {
            Some("us-ft") => heliotile_place::epsg_numbers::US_FOOT_M,
            Some("ft") => heliotile_place::epsg_numbers::FOOT_M,
            _ => number("to_meter").unwrap_or(1.0),
        };
        if get("proj") == Some("utm") {
            // UTM: zones of 6 degrees from 180 degrees west on, each about its middle. Factor and
            // false origin are the same in all of them.
            let zone = number("zone")?;
            return Some(Projection {
                kind: "tmerc",
                longitude_deg: 6.0 * zone - 183.0,
                factor: 0.9996,
                easting_m: 500_000.0,
                northing_m: if definition.contains("+south") { 1e7 } else { 0.0 },
                unit_m,
                half_axis_m,
                ..Projection::default()
            });
        }
        let kind = KINDS.iter().find(|kind| Some(**kind) == get("proj"))?;
        let second = number("lat_2");
        let found = Projection {
            kind,
            latitude_deg: number("lat_0").unwrap_or_default(),
            longitude_deg: number("lon_0").or_else(|| number("lonc")).unwrap_or_default(),
            parallels_deg: [
                number("lat_1").or_else(|| number("lat_ts")).unwrap_or_default(),
                second.unwrap_or_default(),
            ],
            factor: number("k").or_else(|| number("k_0")).unwrap_or(1.0),
            easting_m: number("x_0").unwrap_or_default(),
            northing_m: number("y_0").unwrap_or_default(),
            unit_m,
            half_axis_m,
        };
        Some(found.in_order(second.is_some()))
    }

    /// Puts the parallels of a cone in order; a cone of one parallel touches the ellipsoid at its
    /// origin.
    fn in_order(mut self, two: bool) -> Projection {
        let [first, second] = self.parallels_deg;
        self.parallels_deg = match self.kind {
            "lcc" if !two => [self.latitude_deg; 2],
            "lcc" | "aea" => [first.min(second), first.max(second)],
            "merc" | "stere" => [first, 0.0],
            _ => [0.0; 2],
        };
        self
    }

    fn is_same(&self, other: &Projection) -> bool {
        let near = |a: f64, b: f64, most: f64| (a - b).abs() < most;
        let [first, second] = self.parallels_deg;
        let [other_first, other_second] = other.parallels_deg;
        self.kind == other.kind
            && near(self.latitude_deg, other.latitude_deg, DEGREES)
            && near(self.longitude_deg, other.longitude_deg, DEGREES)
            && near(first, other_first, DEGREES)
            && near(second, other_second, DEGREES)
            && near(self.factor, other.factor, SHARE)
            && near(self.easting_m, other.easting_m, METRES)
            && near(self.northing_m, other.northing_m, METRES)
            && near(self.unit_m, other.unit_m, SHARE)
            && near(self.half_axis_m, other.half_axis_m, 1.0)
    }

    /// Returns the EPSG number of the system with these parameters. Of several, the systems of the
    /// datum come first, which `datum` names in upper case; then the datum's usual range; then the
    /// lowest number.
    pub(super) fn epsg(&self, datum: &str) -> Option<u32> {
        let alike = NUMBERS.filter_map(crs_definitions::from_code).filter(|definition| {
            // Most definitions are of other projections; parsing one is slow.
            Projection::of_proj(definition.proj4).is_some_and(|other| other.is_same(self))
        });
        let hint = HINTS.iter().find(|hint| hint.names.iter().any(|name| datum.contains(name)));
        let rank = |code: u16, proj: &str| {
            let (words, usual) =
                hint.map_or((true, true), |hint| (proj.contains(hint.words), hint.usual.contains(&code)));
            (!words, !usual, code)
        };
        alike.min_by_key(|definition| rank(definition.code, definition.proj4)).map(|found| found.code.into())
    }
}
