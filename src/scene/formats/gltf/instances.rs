//! Instances of a mesh in one node (Khronos, vendor extension EXT_mesh_gpu_instancing). In: the
//! accessors of the extension. Out: placements in the node, each checked.

use std::path::Path;

use glam::{DAffine3, DQuat, DVec3};

use crate::formats::gltf::buffers::{Buffers, Values};
use crate::formats::gltf::json::InstanceAttributes;
use heliotile_core::error::{Error, Result};

/// Returns the placements of the instances of node `index`.
pub(super) fn placements(
    attributes: &InstanceAttributes,
    buffers: &Buffers,
    file: &Path,
    index: usize,
) -> Result<Vec<DAffine3>> {
    let refuse = |what: String| {
        let what = format!("the instances of node {index} {what}");
        Error::input(file, None, what, "export it again, or check it with a glTF validator")
    };
    let read = |accessor: Option<usize>| accessor.map(|accessor| buffers.values(accessor)).transpose();
    let (translation, rotation, scale) =
        (read(attributes.translation)?, read(attributes.rotation)?, read(attributes.scale)?);
    let vectors = [&translation, &scale].into_iter().flatten().all(|values| values.is_positions());
    if !vectors || rotation.as_ref().is_some_and(|values| !values.is_rotations()) {
        return Err(refuse("have attributes of a type that the extension does not allow".into()));
    }
    let counts: Vec<usize> =
        [&translation, &rotation, &scale].into_iter().flatten().map(|values| values.count).collect();
    let Some(&count) = counts.first() else {
        return Err(refuse("have neither TRANSLATION nor ROTATION nor SCALE".into()));
    };
    if counts.iter().any(|other| *other != count) {
        return Err(refuse(format!("have attributes of {counts:?} values; the counts must be equal")));
    }
    let vector = |values: &Option<Values>, i: usize, usual: DVec3| match values {
        Some(values) => values.vector(i).filter(|vector| vector.is_finite()),
        None => Some(usual),
    };
    let mut found = Vec::new();
    for i in 0..count {
        let turn = match &rotation {
            Some(values) => values.four(i).map(DQuat::from_vec4).filter(|turn| (0.5..2.0).contains(&turn.length())),
            None => Some(DQuat::IDENTITY),
        };
        let (at, size) = (vector(&translation, i, DVec3::ZERO), vector(&scale, i, DVec3::ONE));
        let (Some(turn), Some(at), Some(size)) = (turn, at, size) else {
            return Err(refuse(format!(
                "have an invalid placement, number {i}: a number is not finite, or its rotation is not a unit quaternion"
            )));
        };
        found.push(DAffine3::from_scale_rotation_translation(size, turn.normalize(), at));
    }
    Ok(found)
}
