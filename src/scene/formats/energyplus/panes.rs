//! Reflectance of a stack of panes at normal incidence. In: the layers of a construction, outermost
//! first. Out: its front solar reflectance, if the file states the properties of its panes.

use std::path::Path;

use crate::formats::building::notes::Notes;
use crate::formats::energyplus::model::{Object, share};
use heliotile_core::error::Result;

/// Transmittance and reflectances of a pane at normal incidence.
#[derive(Clone, Copy)]
struct Pane {
    transmittance: f64,
    front: f64,
    back: f64,
}

/// Returns the front reflectance of a construction at normal incidence; `None` if it has no panes,
/// or if one of them states no properties.
pub(super) fn front_reflectance(layers: &[&Object], file: &Path, notes: &mut Notes) -> Result<Option<f64>> {
    let mut panes = Vec::new();
    for layer in layers.iter().filter(|layer| layer.layout.class.starts_with("WindowMaterial:")) {
        match pane(layer, file, notes)? {
            Some(pane) => panes.push(pane),
            None => return Ok(None),
        }
    }
    if panes.is_empty() {
        return Ok(None);
    }
    // Adds pane by pane from the innermost outwards, and sums the light that is reflected to and
    // fro between a pane and the stack behind it (Engineering Reference, "Glass Layer Properties").
    let stack = panes.iter().rev().fold(0.0, |behind, pane| {
        let between = (1.0 - pane.back * behind).max(f64::EPSILON);
        pane.front + pane.transmittance * pane.transmittance * behind / between
    });
    Ok(Some(stack.clamp(0.0, 1.0)))
}

fn pane(layer: &Object, file: &Path, notes: &mut Notes) -> Result<Option<Pane>> {
    match layer.layout.class {
        "WindowMaterial:Glazing" => {
            let key = "front_side_solar_reflectance_at_normal_incidence";
            if layer.number(file, key)?.is_none() {
                return Ok(None);
            }
            let front = share(layer, file, key, 0.0, notes)?;
            let back = share(layer, file, "back_side_solar_reflectance_at_normal_incidence", front, notes)?;
            let transmittance = share(layer, file, "solar_transmittance_at_normal_incidence", 0.0, notes)?;
            Ok(Some(Pane { transmittance: transmittance.min(1.0 - front.max(back)), front, back }))
        }
        "WindowMaterial:Glazing:RefractionExtinctionMethod" => {
            let number = |key| layer.number(file, key);
            let stated =
                (number("thickness")?, number("solar_index_of_refraction")?, number("solar_extinction_coefficient")?);
            let (Some(thickness), Some(index), Some(extinction)) = stated else { return Ok(None) };
            if !(index >= 1.0 && thickness * extinction >= 0.0) {
                return Ok(None);
            }
            // Two surfaces of glass (Fresnel), and the absorption between them.
            let surface = ((index - 1.0) / (index + 1.0)).powi(2);
            let through = (-thickness * extinction).exp();
            let between = (1.0 - (surface * through).powi(2)).max(f64::EPSILON);
            let transmittance = through * (1.0 - surface).powi(2) / between;
            let reflectance = surface * (1.0 + through * transmittance);
            Ok(Some(Pane { transmittance, front: reflectance, back: reflectance }))
        }
        _ => Ok(None),
    }
}
