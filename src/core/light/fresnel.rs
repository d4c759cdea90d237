//! Specular reflectance of mirrors and of clear glass. In: a material and the cosine of the angle
//! of incidence. Out: the share of unpolarised light that is reflected.

use crate::light::reflector::Reflector;
use crate::site::material::Material;

/// Refractive index of window glass.
pub const GLASS: f64 = 1.52;

/// Returns the reflectances of one surface between air and a dielectric of index `n` for light
/// polarised perpendicular and parallel to the plane of incidence (Fresnel's equations, as in Born
/// and Wolf 1999, 1.5.2 (21) and (21a), squared).
pub fn surface(n: f64, cos: f64) -> [f64; 2] {
    let cos = cos.clamp(0.0, 1.0);
    // At least n^2 - 1, so above 0 for n > 1.
    let refracted = (n * n - 1.0 + cos * cos).max(0.0).sqrt();
    let across = |a: f64, b: f64| if a + b > 0.0 { ((a - b) / (a + b)).powi(2) } else { 1.0 };
    [across(cos, refracted), across(n * n * cos, refracted)]
}

/// Returns the reflectance of panes of clear glass that absorb nothing. A pane has 2 surfaces, and
/// light goes to and fro between all of them (Stokes 1862, "On the intensity of the light reflected
/// from or transmitted through a pile of plates": m r / (1 + (m - 1) r) for m surfaces).
pub fn panes(count: u8, cos: f64) -> f64 {
    let surfaces = 2.0 * f64::from(count);
    let pile = |r: f64| surfaces * r / (1.0 + (surfaces - 1.0) * r);
    let [s, p] = surface(GLASS, cos);
    if count == 0 { 0.0 } else { 0.5 * (pile(s) + pile(p)) }
}

/// Returns the mean of [`panes`] for uniform diffuse light.
pub fn panes_mean(count: u8) -> f64 {
    const STEPS: u32 = 1024;
    // Light from a uniform hemisphere is uniform in cos^2 (Lambert's cosine law), so midpoints of
    // cos^2 need no weights.
    let at = |i: u32| panes(count, ((f64::from(i) + 0.5) / f64::from(STEPS)).sqrt());
    (0..STEPS).map(at).sum::<f64>() / f64::from(STEPS)
}

/// Returns the share of uniform diffuse light that a material reflects like a mirror.
pub fn specular_mean(material: &Material) -> f64 {
    material.glass.map_or(material.specular, |glass| panes_mean(glass.panes()))
}

/// Returns the specular reflectance of a material, limited so that it and the diffuse reflectance
/// add up to at most 1.
pub fn specular(material: &Reflector, cos: f64) -> f64 {
    let reflected = if material.panes > 0 { panes(material.panes, cos) } else { material.specular };
    reflected.min(1.0 - material.diffuse).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At 45, 60, 75, 85 and 89.9 degrees one surface of n = 1.52 reflects what Fresnel's sines and
    /// tangents give, to 1e-12, and at 0 degrees what the refractive index gives, to 1e-15. A
    /// single pane reflects 8.17 % and two 15.10 % at normal incidence, and one pane more than 98 %
    /// at 89.9 degrees.
    #[test]
    fn glass_reflects_as_fresnel_states_at_each_angle() {
        for degrees in [45.0_f64, 60.0, 75.0, 85.0, 89.9] {
            let i = degrees.to_radians();
            let t = (i.sin() / GLASS).asin();
            let s = ((i - t).sin() / (i + t).sin()).powi(2);
            let p = ((i - t).tan() / (i + t).tan()).powi(2);
            let found = surface(GLASS, i.cos());
            assert!((found[0] - s).abs() < 1e-12 && (found[1] - p).abs() < 1e-12, "{degrees}: {found:?} {s} {p}");
        }
        let normal = (0.52_f64 / 2.52).powi(2);
        assert!(surface(GLASS, 1.0).iter().all(|r| (r - normal).abs() < 1e-15));
        assert!((panes(1, 1.0) - 2.0 * normal / (1.0 + normal)).abs() < 1e-15);
        assert!((panes(1, 1.0) - 0.0817).abs() < 1e-4 && (panes(2, 1.0) - 0.1510).abs() < 1e-4);
        assert!(panes(1, 89.9_f64.to_radians().cos()) > 0.98 && panes(2, 0.0) == 1.0);
    }

    /// The mean over the hemisphere of one surface agrees with Walsh's closed formula (1926), to
    /// 1e-6, for n = 1.52 (9.47 %) and 1.33.
    #[test]
    fn the_mean_over_the_hemisphere_agrees_with_walsh() {
        for n in [1.52_f64, 1.33] {
            let steps = 200_000;
            let mean = |i: i32| {
                let cos = ((f64::from(i) + 0.5) / f64::from(steps)).sqrt();
                surface(n, cos).iter().sum::<f64>() / 2.0
            };
            let integral = (0..steps).map(mean).sum::<f64>() / f64::from(steps);
            let n2 = n * n;
            let walsh = 0.5
                + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0).powi(2))
                + n2 * (n2 - 1.0).powi(2) / (n2 + 1.0).powi(3) * ((n - 1.0) / (n + 1.0)).ln()
                - 2.0 * n2 * n * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n2 * n2 - 1.0))
                + 8.0 * n2 * n2 * (n2 * n2 + 1.0) / ((n2 + 1.0) * (n2 * n2 - 1.0).powi(2)) * n.ln();
            assert!((integral - walsh).abs() < 1e-6, "{n}: {integral} {walsh}");
            assert!(n != 1.52 || (walsh - 0.0947).abs() < 1e-4, "{walsh}");
        }
    }

    /// One pane and two panes reflect 15.4 % and 23.5 % of uniform diffuse light, to 0.1 %, and no
    /// pane reflects nothing.
    #[test]
    fn panes_reflect_known_shares_of_diffuse_light() {
        let means = [panes_mean(0), panes_mean(1), panes_mean(2)];
        assert!((means[1] - 0.1536).abs() < 1e-3 && (means[2] - 0.2354).abs() < 1e-3 && means[0] == 0.0, "{means:?}");
    }

    /// Glass with a diffuse reflectance of 0.3 reflects at most 0.7 like a mirror: together all
    /// that arrives.
    #[test]
    fn diffuse_glass_reflects_no_more_than_arrives() {
        let class = crate::site::material::Class::Obstruction;
        let glass = Reflector { diffuse: 0.3, class, specular: 0.0, panes: 2, transmittance: None, volume: false };
        assert_eq!(specular(&glass, 0.0), 0.7);
        assert_eq!(specular(&Reflector { panes: 0, specular: 0.4, ..glass }, 0.3), 0.4);
    }
}
