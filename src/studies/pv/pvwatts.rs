//! Power of solar modules by PVWatts version 5: Dobos, "PVWatts Version 5 Manual", 2014,
//! NREL/TP-6A20-62641. In: irradiance on a module, air, the plant. Out: DC and AC power. All
//! formulas of electricity stand here.

use heliotile_core::light::fresnel::surface;

/// Irradiance at standard test conditions (IEC 60904-3), W/m2.
const STC_W_M2: f64 = 1000.0;
/// Cell temperature at standard test conditions, degrees Celsius.
const STC_CELL_C: f64 = 25.0;

/// Refractive index, extinction coefficient (1/m) and thickness (m) of the cover: clear glass of
/// De Soto, Klein and Beckman, "Improvement and validation of a model for photovoltaic array
/// performance", Solar Energy 80, 2006, which PVWatts and `pvlib.iam.physical` take.
const COVER: (f64, f64, f64) = (1.526, 4.0, 0.002);

/// Efficiency of the reference inverter at full load, and its curve over the load: Dobos 2014,
/// section 10 (mean of measured inverters of the California Energy Commission).
const REFERENCE_EFFICIENCY: f64 = 0.9637;
const CURVE: [f64; 3] = [-0.0162, -0.0059, 0.9858];

/// Coefficients of the temperature model of King, Boyson and Kratochvil, "Photovoltaic Array
/// Performance Model", 2004, SAND2004-3535, table 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermal {
    pub a: f64,
    /// Per m/s of wind at 10 m above the ground.
    pub b: f64,
    /// Excess of the cell over the back of its module at 1000 W/m2, K.
    pub cell_k: f64,
}

impl Thermal {
    /// Glass and polymer on an open rack.
    pub const OPEN: Thermal = Thermal { a: -3.56, b: -0.0750, cell_k: 3.0 };
    /// Glass and glass close to a roof.
    pub const ROOF: Thermal = Thermal { a: -2.98, b: -0.0471, cell_k: 1.0 };

    /// Returns the excess of cells over the air for each W/m2 on the module, K m2/W (equations 11
    /// and 12).
    pub fn excess_k_m2_w(&self, wind_m_s: f64) -> f64 {
        (self.a + self.b * wind_m_s).exp() + self.cell_k / STC_W_M2
    }
}

/// Returns the transmittance of the cover for beam light at an angle of incidence, relative to
/// that at normal incidence (De Soto 2006, equations 6 and 7; Dobos 2014, section 8).
pub fn cover(cos: f64) -> f64 {
    let (index, extinction, thick) = COVER;
    let through = |cos: f64| {
        let refracted = (1.0 - (1.0 - cos * cos) / (index * index)).sqrt();
        let [s, p] = surface(index, cos);
        (1.0 - 0.5 * (s + p)) * (-extinction * thick / refracted).exp()
    };
    through(cos.clamp(0.0, 1.0)) / through(1.0)
}

/// Returns DC power per rated power and W/m2 of the light that passes the cover, m2/W (Dobos 2014,
/// section 9).
pub fn dc_m2_w(cell_c: f64, per_k: f64) -> f64 {
    // Beyond some 300 degrees Celsius the line would fall below 0.
    ((1.0 + per_k * (cell_c - STC_CELL_C)) / STC_W_M2).max(0.0)
}

/// Inverter of a plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inverter {
    /// AC rating, kW.
    pub rated_kw: f64,
    /// Nominal efficiency.
    pub efficiency: f64,
}

impl Inverter {
    /// Returns AC power, kW, and that lost by clipping at the rating (Dobos 2014, section 10).
    pub fn ac_kw(&self, dc_kw: f64) -> [f64; 2] {
        let load = dc_kw * self.efficiency / self.rated_kw;
        if load <= 0.0 {
            return [0.0, 0.0];
        }
        let [slope, tare, level] = CURVE;
        // efficiency x load, so that no load divides by 0; the inverter's own use is no output.
        let curve = ((slope * load + level) * load + tare) / REFERENCE_EFFICIENCY;
        let unclipped_kw = (curve * self.rated_kw).max(0.0);
        // At full load the curve is 1 x the rating, and beyond it the manual gives the rating.
        if load < 1.0 {
            [unclipped_kw.min(self.rated_kw), 0.0]
        } else {
            [self.rated_kw, self.efficiency * dc_kw - self.rated_kw]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of pvlib 0.16.1, computed by `tools/peers/power.py formulas`: `iam.physical`,
    /// `temperature.sapm_cell`, `pvsystem.pvwatts_dc`, `inverter.pvwatts`, all to 1e-9.
    #[test]
    fn formulas_have_the_values_of_pvlib() {
        let near = |found: f64, right: f64| assert!((found - right).abs() < 1e-9, "{found}, not {right}");
        for (degrees, right) in [
            (0.0_f64, 1.0),
            (50.0, 0.9798419516784942),
            (70.0, 0.8597201902165214),
            (85.0, 0.40087915031774435),
            (89.0, 0.09922519330755941),
        ] {
            near(cover(degrees.to_radians().cos()), right);
        }
        assert_eq!(cover(-0.1), 0.0);
        for (thermal, irradiance, air_c, wind, right) in [
            (Thermal::OPEN, 800.0, 20.0, 1.0, 43.50714750993931),
            (Thermal::OPEN, 1000.0, -5.0, 6.0, 16.133395236801075),
            (Thermal::ROOF, 800.0, 20.0, 1.0, 59.564765472343346),
            (Thermal::ROOF, 1000.0, -5.0, 6.0, 34.28871782311238),
        ] {
            near(air_c + irradiance * thermal.excess_k_m2_w(wind), right);
        }
        near(700.0 * dc_m2_w(45.0, -0.0035), 0.651);
        assert_eq!(dc_m2_w(500.0, -0.0035), 0.0);
        let inverter = Inverter { rated_kw: 4.0, efficiency: 0.96 };
        for (dc_kw, right) in [
            (0.0, 0.0),
            (0.02, 0.0),
            (0.1, 0.07367383542596244),
            (1.0, 0.9536531285669815),
            (3.9, 3.7464607027083114),
            (4.1, 3.9366668166441836),
            (5.0, 4.0),
        ] {
            near(inverter.ac_kw(dc_kw)[0], right);
        }
        near(inverter.ac_kw(5.0)[1], 0.8);
        assert_eq!(inverter.ac_kw(4.1)[1], 0.0);
    }
}
