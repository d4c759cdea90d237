//! Geometry that is stored once and used in many places. In: `geometry-templates`. Out: templates
//! with their own few vertices, checked.

use glam::{DMat4, DVec3};

use crate::formats::cityjson::document::{Shape, Templates};
use crate::formats::cityjson::surfaces::depth_of;

/// Most corners that all instances of templates may have: a short file could otherwise ask for all
/// memory. A million trees of a hundred corners fit.
pub(in crate::formats) const MAX_CORNERS: u64 = 1 << 27;

/// Memory that a corner of an instance takes, bytes.
pub(in crate::formats) const CORNER_BYTES: u64 = 80;

/// A template whose boundaries refer to its own `vertices`.
#[derive(Debug)]
pub(in crate::formats) struct Template<'a> {
    pub shape: Shape<'a>,
    /// Vertices that the template uses.
    pub vertices: Vec<DVec3>,
    pub corners: u64,
}

/// Checks all templates of a file; the error says what is wrong.
pub(super) fn prepare(templates: Templates<'_>) -> Result<Vec<Template<'_>>, String> {
    let Templates { templates, vertices } = templates;
    let count = vertices.len();
    let mut prepared = Vec::new();
    for (i, mut shape) in templates.into_iter().enumerate() {
        let name = |what: String| format!("template {i}: {what}");
        if shape.kind.0 == "GeometryInstance" {
            return Err(name("it is an instance of a template itself".into()));
        }
        let mut used: Vec<u32> = Vec::new();
        if depth_of(&shape.kind.0).is_some() {
            let boundaries = shape.boundaries.get_or_insert_default();
            used.extend(boundaries.numbers_mut().map(|number| *number));
        }
        let corners = used.len() as u64;
        // Vertices are renumbered, so that an instance copies only those that its template uses.
        used.sort_unstable();
        used.dedup();
        if let Some(bad) = used.last().filter(|last| **last as usize >= count) {
            return Err(name(format!(
                "its boundaries name vertex {bad} of {count} vertices-templates, counted from 0"
            )));
        }
        for number in shape.boundaries.iter_mut().flat_map(|boundaries| boundaries.numbers_mut()) {
            *number = used.binary_search(number).unwrap_or_default() as u32;
        }
        let vertices =
            used.iter().filter_map(|&number| vertices.get(number as usize).copied().map(DVec3::from)).collect();
        prepared.push(Template { shape, vertices, corners });
    }
    Ok(prepared)
}

/// Returns the transformation of an instance from sixteen numbers, row by row (CityJSON 2.0.1,
/// section 3.4).
pub(in crate::formats) fn matrix(numbers: Option<&[f64]>) -> Result<DMat4, String> {
    let Some(numbers) = numbers else { return Err("its instance of a template has no `transformationMatrix`".into()) };
    let Ok(rows) = <[f64; 16]>::try_from(numbers) else {
        return Err(format!("its `transformationMatrix` has {} numbers, not 16", numbers.len()));
    };
    let matrix = DMat4::from_cols_array(&rows).transpose();
    let last = matrix.row(3).to_array();
    if last != [0.0, 0.0, 0.0, 1.0] {
        return Err(format!("the last row of its `transformationMatrix` is {last:?}, not [0, 0, 0, 1]"));
    }
    Ok(matrix)
}
