//! In: the bytes of a PLY file, text or binary of either byte order. Out: its polygons; colours and
//! all other properties are skipped.
//!
//! The crate `ply-rs-bw` 4.0.1 is not used: it refuses files that other programs write (line ends
//! of one CR, `.5`, Latin-1 in comments), misreads two properties of one name, and needs a guard of
//! its own against elements without properties. Source: G. Turk, The PLY Polygon File Format, 1994.

use std::path::Path;

use glam::DVec3;

use crate::coordinate::is_position;
use crate::formats::obj::DEFAULT_MATERIAL;
use crate::formats::ply_body::Body;
use crate::formats::ply_header::{Element, Header, Property};
use crate::formats::stem;
use crate::geometry::Geometry;
use heliotile_core::error::{Error, Result};

pub(super) fn parse(bytes: &[u8], file: &Path) -> Result<Geometry> {
    let (header, body) = Header::read(bytes, file)?;
    let mut body = Body::new(&header, body, file);
    let mut geometry = Geometry::default();
    // Faces may precede the vertices, so that their number comes from the header.
    let vertices = header.elements.iter().filter(|element| element.name == "vertex").map(|element| element.count).sum();
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => read_vertices(element, &mut body, &mut geometry)?,
            "face" => read_faces(element, vertices, &mut body, &mut geometry)?,
            _ => skip(element, &mut body)?,
        }
    }
    if geometry.face_count() == 0 {
        let other: Vec<&str> = header.elements.iter().map(|element| element.name.as_str()).collect();
        return Err(if other.contains(&"tristrips") {
            Error::Unsupported {
                what: format!("the scene {}", file.display()).into(),
                found: "triangle strips".into(),
                supported: "`element face`: export polygons".into(),
            }
        } else {
            let what = format!("the file holds no faces ({} vertices were read)", geometry.vertices.len());
            Error::input(file, None, what, "export a surface (`element face`): points cast no shadow")
        });
    }
    let left = body.left();
    if left > 0 {
        let text = format!("{}: {left} bytes after the last element are ignored", file.display());
        geometry.warnings.push(text.into());
    }
    Ok(geometry)
}

fn read_vertices<'b>(element: &'b Element, body: &mut Body<'b>, geometry: &mut Geometry) -> Result<()> {
    let mut axes = Vec::with_capacity(3);
    for axis in ["x", "y", "z"] {
        let found = element.properties.iter().position(|property| property.name == axis && property.list.is_none());
        axes.push(found.ok_or_else(|| {
            let what = format!("`element vertex` has no property `{axis}` that is a number");
            Error::input(body.file, element.line, what, "export positions as x, y and z")
        })?);
    }
    for i in 0..element.count {
        body.begin(element, i)?;
        let mut position = [f64::NAN; 3];
        for (place, property) in element.properties.iter().enumerate() {
            if property.list.is_some() {
                pass_over(property, body)?;
                continue;
            }
            let value = body.number(property.kind)?;
            for (axis, coordinate) in axes.iter().zip(&mut position) {
                if *axis == place {
                    *coordinate = value;
                }
            }
        }
        let position = DVec3::from(position);
        if !is_position(position) {
            return Err(body.error(&format!("lies at {position}; positions are metres, at most 1e9 in size")));
        }
        geometry.push_vertex(body.file, position)?;
    }
    Ok(())
}

fn read_faces<'b>(element: &'b Element, vertices: u64, body: &mut Body<'b>, geometry: &mut Geometry) -> Result<()> {
    let is_corners = |property: &Property| ["vertex_indices", "vertex_index"].contains(&property.name.as_str());
    let corners = element.properties.iter().position(|property| is_corners(property) && property.list.is_some());
    if corners.is_none() && element.count > 0 {
        let what = "`element face` has no list `vertex_indices`";
        return Err(Error::input(body.file, element.line, what, "export polygons, not strips or edges"));
    }
    let (material, object) = (geometry.materials.id(DEFAULT_MATERIAL), geometry.objects.id(&stem(body.file)));
    for i in 0..element.count {
        body.begin(element, i)?;
        for (place, property) in element.properties.iter().enumerate() {
            if Some(place) != corners {
                pass_over(property, body)?;
                continue;
            }
            let count = body.count(property)?;
            for _ in 0..count {
                let corner = body.number(property.kind)?;
                // An f64 holds every index below 2^32 exactly.
                if !(corner >= 0.0 && corner < vertices.min(1 << 32) as f64 && corner.fract() == 0.0) {
                    return Err(body.error(&format!(
                        "names vertex {corner}, but vertices are numbered 0 to {}",
                        vertices as f64 - 1.0
                    )));
                }
                geometry.push_corner(corner as u32);
            }
        }
        geometry.end_face(material, object, body.line());
    }
    Ok(())
}

fn skip<'b>(element: &'b Element, body: &mut Body<'b>) -> Result<()> {
    // An item without properties takes no byte of a binary file, and a hostile file claims
    // billions.
    if element.properties.is_empty() && body.is_binary() {
        return Ok(());
    }
    for i in 0..element.count {
        body.begin(element, i)?;
        for property in &element.properties {
            pass_over(property, body)?;
        }
    }
    Ok(())
}

fn pass_over(property: &Property, body: &mut Body) -> Result<()> {
    let count = if property.list.is_some() { body.count(property)? } else { 1 };
    body.skip(property.kind, count)
}

#[cfg(test)]
#[path = "ply_tests.rs"]
mod tests;
