//! Person, body and clothing of the PET. In: a person. Out: areas, metabolism, insulation.
//!
//! Walther and Goestchel, "The P.E.T. comfort index: Questioning the model", Building and
//! Environment 137, 2018, after Höppe, "The physiological equivalent temperature - a universal
//! index for the biometeorological assessment of the thermal environment", International Journal of
//! Biometeorology 43, 1999, and the Fortran code of VDI 3787 part 2.

/// Activity of 1 met, W.
pub const MET_W: f64 = 58.2;
/// Activity in the reference room of the PET, W.
pub const ROOM_ACTIVITY_W: f64 = 80.0;
/// Clothing in the reference room of the PET, clo.
pub const ROOM_CLOTHING_CLO: f64 = 0.9;

/// Posture of a person whose PET is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PetPosture {
    /// Sitting.
    Sitting,
    /// Standing.
    Standing,
}

/// Sex of a person, which basal metabolism depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sex {
    /// Female.
    Female,
    /// Male.
    Male,
}

/// Person whose PET is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PetPerson {
    /// Activity besides basal metabolism, met: 0.5 to 4. Here, as in pythermalcomfort, 1 met is
    /// 58.2 W of the whole body.
    pub activity_met: f64,
    /// Insulation of the clothing, clo: 0.05 to 2.5. At the upper end the model leaves nothing
    /// bare.
    pub clothing_clo: f64,
    /// Posture.
    pub posture: PetPosture,
    /// Sex.
    pub sex: Sex,
    /// Age, years: 15 to 110.
    pub age_years: f64,
    /// Weight, kg: 35 to 200.
    pub weight_kg: f64,
    /// Height, metres: 1.3 to 2.3.
    pub height_m: f64,
}

impl PetPerson {
    /// The person of VDI 3787 part 2 and of Höppe, 1999: a standing man of 35 years, 75 kg and 1.75
    /// m with 80 W and 0.9 clo.
    pub const VDI_3787: PetPerson = PetPerson {
        activity_met: ROOM_ACTIVITY_W / MET_W,
        clothing_clo: ROOM_CLOTHING_CLO,
        posture: PetPosture::Standing,
        sex: Sex::Male,
        age_years: 35.0,
        weight_kg: 75.0,
        height_m: 1.75,
    };
}

impl Default for PetPerson {
    /// Returns the person that pythermalcomfort assumes: a sitting man of 23 years, 75 kg and 1.8
    /// m, with the 1.37 met and 0.9 clo of the reference room.
    fn default() -> Self {
        PetPerson {
            activity_met: 1.37,
            posture: PetPosture::Sitting,
            age_years: 23.0,
            height_m: 1.8,
            ..PetPerson::VDI_3787
        }
    }
}

/// Properties of a body that metabolism, convection and radiation depend on.
#[derive(Clone, Copy, Debug)]
pub struct Body {
    /// Surface of the naked body, m2 (DuBois and DuBois 1916; the factor 0.202 as in
    /// pythermalcomfort, elsewhere 0.203).
    pub surface_m2: f64,
    /// Basal metabolism, W.
    pub basal_w: f64,
    /// Height, metres.
    pub height_m: f64,
    /// Share of the surface that exchanges radiation with the surroundings, f_eff.
    pub radiant_share: f64,
    /// Posture, which convection depends on.
    pub posture: PetPosture,
}

impl Body {
    /// Returns the body of a person.
    ///
    /// f_eff is 0.725 sitting and 0.696 standing, as in pythermalcomfort, whose table of validation
    /// needs it (0.57 K in its row of -5 and 40 degrees). Fanger and the Fortran code have 0.696
    /// sitting and 0.725 standing.
    pub fn new(person: &PetPerson) -> Self {
        let PetPerson { weight_kg, height_m, age_years, .. } = *person;
        let slenderness_cm_kg = 100.0 * height_m / weight_kg.cbrt();
        let of_age = 1.0 + 0.004 * (30.0 - age_years);
        let of_weight = weight_kg.powf(0.75);
        let basal_w = match person.sex {
            Sex::Female => 3.19 * of_weight * (of_age + 0.018 * (slenderness_cm_kg - 42.1)),
            Sex::Male => 3.45 * of_weight * (of_age + 0.010 * (slenderness_cm_kg - 43.4)),
        };
        let radiant_share = match person.posture {
            PetPosture::Sitting => 0.725,
            PetPosture::Standing => 0.696,
        };
        let surface_m2 = 0.202 * weight_kg.powf(0.425) * height_m.powf(0.725);
        Body { surface_m2, basal_w, height_m, radiant_share, posture: person.posture }
    }

    /// Returns the heat transfer coefficient of convection, W/m2 K, in wind at the body in m/s and
    /// at a pressure relative to 1013.25 hPa.
    pub fn convection_w_m2_k(&self, wind_m_s: f64, relative_pressure: f64) -> f64 {
        let forced = match self.posture {
            PetPosture::Sitting => 2.67 + 6.5 * wind_m_s.powf(0.67),
            PetPosture::Standing => 2.26 + 7.42 * wind_m_s.powf(0.67),
        };
        let natural = 3.0 * relative_pressure.powf(0.53);
        forced.max(natural) * relative_pressure.powf(0.55)
    }
}

/// Clothing on a body. Areas are shares of the naked body's surface.
#[derive(Clone, Copy, Debug)]
pub struct Clothing {
    /// Naked share of the body, 1 - f_acl, not below 0.
    pub bare_share: f64,
    /// Outer surface of the clothing, a_clo.
    pub outer_share: f64,
    /// Surface of the clothed body over that of the naked one, f_cl (Burton's factor, 0.31 by
    /// Höppe).
    pub enlargement: f64,
    /// Thermal resistance of the clothing, m2 K/W.
    pub resistance_m2_k_w: f64,
    /// Conductance from skin to the outer surface, W/m2 K, h_tcl: that of a hollow cylinder.
    pub conductance_w_m2_k: f64,
}

impl Clothing {
    /// Returns the clothing of an insulation, clo, on a body.
    pub fn new(clo: f64, body: &Body) -> Self {
        /// Two pi as the model has it.
        #[allow(clippy::approx_constant)]
        const TURN: f64 = 6.28;
        let enlargement = 1.0 + 0.31 * clo;
        let covered_share = (-2.36 + clo * (173.51 + clo * (-100.76 + clo * 19.28))) / 100.0;
        let outer_share = covered_share + enlargement - 1.0;
        let covered_share = covered_share.min(1.0);
        let resistance_m2_k_w = clo / 6.45;
        let cylinder_m = TURN * body.height_m * covered_height_share(clo, body.height_m);
        let outer_radius_m = body.surface_m2 * (enlargement - 1.0 + covered_share) / cylinder_m;
        let inner_radius_m = body.surface_m2 * covered_share / cylinder_m;
        let thickness_m = outer_radius_m - inner_radius_m;
        let conductance_w_m2_k = cylinder_m * thickness_m
            / (resistance_m2_k_w * (outer_radius_m / inner_radius_m).ln() * outer_share * body.surface_m2);
        Clothing { bare_share: 1.0 - covered_share, outer_share, enlargement, resistance_m2_k_w, conductance_w_m2_k }
    }
}

/// Returns the share of the body's height that clothing of an insulation covers.
fn covered_height_share(clo: f64, height_m: f64) -> f64 {
    match clo {
        _ if clo >= 2.0 => 1.0,
        _ if clo > 0.6 => (height_m - 0.2) / height_m,
        _ if clo > 0.3 => 0.5,
        _ => 0.1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A man of 75 kg, 1.80 m and 23 years has 1.94 m2 and 89.8 W of basal metabolism, a woman 84.4
    /// W, by hand within 0.1.
    #[test]
    fn bodies_have_the_area_and_metabolism_by_hand() {
        let man = Body::new(&PetPerson::default());
        let woman = Body::new(&PetPerson { sex: Sex::Female, ..PetPerson::default() });
        assert!((man.surface_m2 - 1.94).abs() < 0.01, "{man:?}");
        assert!((man.basal_w - 89.8).abs() < 0.1 && (woman.basal_w - 84.4).abs() < 0.1, "{man:?} {woman:?}");
    }

    /// Convection of a sitting person is 3 W/m2 K in still air and 2.67 + 6.5 = 9.17 at 1 m/s at
    /// sea level, and less in thin air.
    #[test]
    fn convection_grows_with_wind_and_air_density() {
        let body = Body::new(&PetPerson::default());
        assert_eq!(body.convection_w_m2_k(0.0, 1.0), 3.0);
        assert!((body.convection_w_m2_k(1.0, 1.0) - 9.17).abs() < 1e-12);
        assert!(body.convection_w_m2_k(1.0, 0.7) < 9.17);
    }

    /// Clothing of 0.9 clo covers 86.24 % of the body, and its conductance is within 30 % of the
    /// inverse of its resistance, 0.9 / 6.45. At 2.5 clo nothing is bare.
    #[test]
    fn clothing_covers_and_insulates_as_stated() {
        let body = Body::new(&PetPerson::default());
        let clothing = Clothing::new(0.9, &body);
        assert!((clothing.bare_share - 0.1376).abs() < 1e-4, "{clothing:?}");
        let product = clothing.conductance_w_m2_k * clothing.resistance_m2_k_w;
        assert!((0.7..1.3).contains(&product), "{product}");
        assert!(Clothing::new(2.5, &body).bare_share == 0.0);
    }
}
