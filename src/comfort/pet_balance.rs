//! Heat balance of a person. In: body, clothing, climate. Out: temperatures of core, skin and
//! clothing at which all heat flows cancel.
//!
//! The model has three nodes: MEMI (Höppe 1984) as Walther and Goestchel, 2018, corrected it;
//! sources as in `pet_body`. All flows are per m2 of the naked body, positive into the body. The
//! temperature of the clothing gives that of the skin and then that of the core in closed form, so
//! that one equation with one unknown is left. Its left side falls with the temperature of the
//! clothing for activities up to 3.5 met; up to 6 met it was found to have one root.

use crate::bracketed_root::{Bracket, bracketed_root};
use crate::humidity::ashrae_saturation_pressure_hpa;
use crate::pet_body::{Body, Clothing};
use heliotile_core::weather::emission::ZERO_CELSIUS_K;

/// Stefan-Boltzmann constant as the model has it, W/m2 K4.
const STEFAN_BOLTZMANN: f64 = 5.67e-8;
/// Latent heat of water, J/kg.
const LATENT_HEAT_J_KG: f64 = 2.42e6;
/// Specific heat of air, J/kg K.
const AIR_HEAT_J_KG_K: f64 = 1010.0;
/// Emissivity of the skin.
const SKIN_EMISSIVITY: f64 = 0.99;
/// Emissivity of clothing.
const CLOTHING_EMISSIVITY: f64 = 0.95;
/// Lewis ratio, K/hPa.
const LEWIS_K_HPA: f64 = 1.67;
/// Woodcock's ratio of vapour transfer through clothing.
const WOODCOCK: f64 = 0.38;
/// Core temperature above which the body gives off heat, degrees Celsius.
const CORE_SET_C: f64 = 36.6;
/// Skin temperature below which the body saves heat, degrees Celsius.
const SKIN_SET_C: f64 = 34.0;
/// Heat flow from core to skin per degree without blood, W/m2 K.
const TISSUE_W_M2_K: f64 = 5.28;
/// Heat that 1 kg/m2 h of blood carries per degree, W/m2 K.
const BLOOD_W_H_KG_K: f64 = 3640.0 / 3600.0;
/// Blood flow at the set temperatures, kg/m2 h.
const BLOOD_SET_KG_M2_H: f64 = 6.3;
/// Increase of the blood flow per degree of a warm core, kg/m2 h K.
const BLOOD_GAIN_KG_M2_H_K: f64 = 75.0;
/// Limit of the blood flow, kg/m2 h.
const MAX_BLOOD_KG_M2_H: f64 = 90.0;
/// Sweat per degree of a warm body, g/m2 h K.
const SWEAT_GAIN_G_M2_H_K: f64 = 304.94;
/// Limit of the sweat, g/m2 h.
const MAX_SWEAT_G_M2_H: f64 = 500.0;

/// Range of clothing temperatures in which the balance is looked for, degrees Celsius.
const CLOTHING_BRACKET: Bracket = Bracket { low: -100.0, high: 150.0, tolerance: 1e-9 };
/// Lower limit of the skin temperature, degrees Celsius. It is met during the search only.
const MIN_SKIN_C: f64 = -90.0;
/// Upper limit of the skin temperature, degrees Celsius. It is met during the search only.
const MAX_SKIN_C: f64 = 130.0;

/// Climate at a body.
#[derive(Clone, Copy, Debug)]
pub struct BodyClimate {
    /// Air temperature, degrees Celsius.
    pub air_c: f64,
    /// Mean radiant temperature, degrees Celsius.
    pub radiant_c: f64,
    /// Vapour pressure, hPa.
    pub vapour_hpa: f64,
    /// Air pressure, hPa.
    pub pressure_hpa: f64,
    /// Heat transfer coefficient of convection, W/m2 K.
    pub convection_w_m2_k: f64,
}

/// Temperatures of the three nodes, degrees Celsius.
#[derive(Clone, Copy, Debug)]
pub struct Nodes {
    /// Core of the body.
    pub core_c: f64,
    /// Skin.
    pub skin_c: f64,
    /// Outer surface of the clothing.
    pub clothing_c: f64,
}

/// Heat flows of a clothed body in a climate.
#[derive(Clone, Copy, Debug)]
pub struct HeatBalance {
    clothing: Clothing,
    climate: BodyClimate,
    radiant_share: f64,
    /// Heat that the core gives to the skin, W/m2: metabolism less the losses by breathing.
    core_w_m2: f64,
    /// Black radiation of the surroundings, W/m2.
    surroundings_w_m2: f64,
    /// Evaporation of sweat per hPa from wet skin, W/m2 hPa.
    sweat_w_m2_hpa: f64,
    /// Diffusion of vapour from dry skin through clothing, W/m2 hPa.
    diffusion_w_m2_hpa: f64,
}

/// Returns the black-body radiation at a temperature, W/m2.
fn black_w_m2(temperature_c: f64) -> f64 {
    STEFAN_BOLTZMANN * (temperature_c + ZERO_CELSIUS_K).powi(4)
}

impl HeatBalance {
    /// Returns the balance of a body that works at `activity_w`, W, besides its basal metabolism.
    pub fn new(body: &Body, clothing: &Clothing, climate: &BodyClimate, activity_w: f64) -> Self {
        let metabolism_w_m2 = (activity_w + body.basal_w) / body.surface_m2;
        let convection = climate.convection_w_m2_k;
        let Clothing { resistance_m2_k_w, enlargement, .. } = *clothing;
        let vapour_resistance = (1.0 / (enlargement * convection) + resistance_m2_k_w) / (LEWIS_K_HPA * WOODCOCK);
        HeatBalance {
            clothing: *clothing,
            climate: *climate,
            radiant_share: body.radiant_share,
            core_w_m2: metabolism_w_m2 + breathing_w_m2(metabolism_w_m2, climate),
            surroundings_w_m2: black_w_m2(climate.radiant_c),
            sweat_w_m2_hpa: LEWIS_K_HPA * convection / (1.0 + 0.92 * convection * resistance_m2_k_w),
            diffusion_w_m2_hpa: 1.0 / vapour_resistance,
        }
    }

    /// Returns the temperatures at which the balance of each node is 0, or `None` if there are none
    /// in the range of the model.
    ///
    /// Evaporation jumps where the vapour pressure of sweating skin equals that of the air, above
    /// 50 hPa. If the balance changes its sign there, the jump is taken as the balance.
    pub fn nodes(&self) -> Option<Nodes> {
        let clothing_c = bracketed_root(|clothing_c| self.sum_w_m2(&self.nodes_at(clothing_c)), &CLOTHING_BRACKET)?;
        Some(self.nodes_at(clothing_c))
    }

    /// Returns the sum of all heat flows of the body, W/m2.
    pub fn sum_w_m2(&self, nodes: &Nodes) -> f64 {
        let bare = self.exchange_w_m2(nodes.skin_c, SKIN_EMISSIVITY);
        let clothed = self.exchange_w_m2(nodes.clothing_c, CLOTHING_EMISSIVITY);
        let dry = self.clothing.bare_share * bare + self.clothing.outer_share * clothed;
        self.core_w_m2 + dry - self.evaporation_w_m2(nodes)
    }

    /// Returns the radiation and convection of a surface, W/m2 of that surface.
    fn exchange_w_m2(&self, surface_c: f64, emissivity: f64) -> f64 {
        let radiation = self.radiant_share * emissivity * (self.surroundings_w_m2 - black_w_m2(surface_c));
        radiation + self.climate.convection_w_m2_k * (self.climate.air_c - surface_c)
    }

    /// Returns the temperatures of skin and core under clothing of a temperature. The balances of
    /// clothing and core are 0 by construction.
    fn nodes_at(&self, clothing_c: f64) -> Nodes {
        let clothed = self.clothing.outer_share * self.exchange_w_m2(clothing_c, CLOTHING_EMISSIVITY);
        let skin_c = (clothing_c - clothed / self.clothing.conductance_w_m2_k).clamp(MIN_SKIN_C, MAX_SKIN_C);
        Nodes { core_c: self.core_c(skin_c), skin_c, clothing_c }
    }

    /// Returns the core temperature at which blood and tissue carry the core's heat to the skin.
    /// The blood flow has three cases.
    fn core_c(&self, skin_c: f64) -> f64 {
        let narrowing = narrowing(skin_c);
        let cool_core_c = skin_c + self.core_w_m2 / (BLOOD_SET_KG_M2_H * narrowing * BLOOD_W_H_KG_K + TISSUE_W_M2_K);
        if cool_core_c <= CORE_SET_C {
            return cool_core_c;
        }
        // (per_degree x + at_set) (x + below) = core_w_m2, where x is the excess of the core above
        // its set temperature.
        let per_degree = BLOOD_GAIN_KG_M2_H_K * narrowing * BLOOD_W_H_KG_K;
        let at_set = BLOOD_SET_KG_M2_H * narrowing * BLOOD_W_H_KG_K + TISSUE_W_M2_K;
        let below = CORE_SET_C - skin_c;
        let linear = at_set + per_degree * below;
        let constant = at_set * below - self.core_w_m2;
        let root = (linear * linear - 4.0 * per_degree * constant).max(0.0).sqrt();
        let excess_k = (root - linear) / (2.0 * per_degree);
        if blood_kg_m2_h(excess_k, narrowing) < MAX_BLOOD_KG_M2_H {
            return CORE_SET_C + excess_k;
        }
        skin_c + self.core_w_m2 / (MAX_BLOOD_KG_M2_H * BLOOD_W_H_KG_K + TISSUE_W_M2_K)
    }

    /// Returns the heat that diffusion and sweat take from the skin, W/m2.
    ///
    /// As in the published code, all sweat evaporates, even where the air takes less: the
    /// comparison that should limit it to E_max never holds there. Only the wettedness of the skin,
    /// which reduces diffusion, is at most 1.
    fn evaporation_w_m2(&self, nodes: &Nodes) -> f64 {
        let deficit_hpa = ashrae_saturation_pressure_hpa(nodes.skin_c) - self.climate.vapour_hpa;
        let sweat_w_m2 = sweat_w_m2(nodes);
        let most_w_m2 = self.sweat_w_m2_hpa * deficit_hpa;
        let wettedness = if most_w_m2 == 0.0 { 1.0 } else { (sweat_w_m2 / most_w_m2).min(1.0) };
        (1.0 - wettedness) * deficit_hpa * self.diffusion_w_m2_hpa + sweat_w_m2
    }
}

/// Returns the heat that breathing adds to the body, W/m2; negative in all but hot and humid air.
fn breathing_w_m2(metabolism_w_m2: f64, climate: &BodyClimate) -> f64 {
    let expired_c = 0.47 * climate.air_c + 21.0;
    let flow_kg_m2_s = 1.44e-6 * metabolism_w_m2;
    let sensible = AIR_HEAT_J_KG_K * (climate.air_c - expired_c);
    let deficit_hpa = climate.vapour_hpa - ashrae_saturation_pressure_hpa(expired_c);
    let latent = 0.623 * LATENT_HEAT_J_KG / climate.pressure_hpa * deficit_hpa;
    flow_kg_m2_s * (sensible + latent)
}

/// Returns the factor by which cold skin narrows its vessels: 1 from the set temperature on, less
/// below.
fn narrowing(skin_c: f64) -> f64 {
    1.0 / (1.0 + 0.5 * (SKIN_SET_C - skin_c).max(0.0))
}

/// Returns the blood flow from core to skin, kg/m2 h.
fn blood_kg_m2_h(core_excess_k: f64, narrowing: f64) -> f64 {
    let flow = (BLOOD_SET_KG_M2_H + BLOOD_GAIN_KG_M2_H_K * core_excess_k.max(0.0)) * narrowing;
    flow.min(MAX_BLOOD_KG_M2_H)
}

/// Returns the heat that would evaporate the sweat, W/m2.
fn sweat_w_m2(nodes: &Nodes) -> f64 {
    let blood = blood_kg_m2_h(nodes.core_c - CORE_SET_C, narrowing(nodes.skin_c));
    let skin_share = 0.0417737 + 0.7451833 / (blood + 0.585417);
    let body_c = skin_share * nodes.skin_c + (1.0 - skin_share) * nodes.core_c;
    let set_c = 0.1 * SKIN_SET_C + 0.9 * CORE_SET_C;
    let sweat_g_m2_h = (SWEAT_GAIN_G_M2_H_K * (body_c - set_c).max(0.0)).min(MAX_SWEAT_G_M2_H);
    LATENT_HEAT_J_KG / 1000.0 * sweat_g_m2_h / 3600.0
}
