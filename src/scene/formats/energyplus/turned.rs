//! Surfaces that are wound the wrong way. In: the surfaces of a model. Out: the same surfaces;
//! those of closed zones look outwards, and openings look as their walls do.
//!
//! EnergyPlus 25.2 itself turns floors and roofs. It lights a wall that looks into its zone as if
//! the zone were outdoors, without a message. A window that looks the other way than its wall is a
//! fatal error there.

use std::collections::{BTreeMap, HashSet};

use glam::DVec3;

use crate::formats::building::frame::{Frame, area_vector};
use crate::formats::building::notes::Notes;
use crate::formats::building::notes::TURNED_OPENINGS;
use crate::formats::building::outwards::facing_inwards;
use crate::formats::energyplus::model::Surface;
use crate::formats::energyplus::model::same;

const INWARDS: &str = "surfaces look into their zone and are turned round; reverse their vertices, because EnergyPlus lights their inner side";

/// Turns surfaces that look into their zone, and openings that look the other way than their wall.
pub(super) fn turn_outwards(list: &mut [Surface], notes: &mut Notes) {
    let mut turned: HashSet<usize> = HashSet::new();
    let mut zones: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (i, surface) in list.iter().enumerate().filter(|(i, surface)| surface.base == *i) {
        zones.entry(same(surface.object.text("zone_name"))).or_default().push(i);
    }
    for members in zones.values() {
        let faces: Vec<Vec<&[DVec3]>> =
            members.iter().filter_map(|&i| list.get(i)).map(|surface| vec![surface.vertices.as_slice()]).collect();
        turned.extend(facing_inwards(&faces).into_iter().filter_map(|i| members.get(i)));
    }
    for (i, wall) in list.iter_mut().enumerate().filter(|(i, _)| turned.contains(i)) {
        debug_assert_eq!(wall.base, i);
        notes.add(INWARDS, &wall.object.name);
        turn(wall);
    }
    for i in 0..list.len() {
        let Some(surface) = list.get(i).filter(|surface| surface.base != i) else { continue };
        let Some(wall) = list.get(surface.base) else { continue };
        let is_contrary = area_vector(&wall.vertices).dot(area_vector(&surface.vertices)) < 0.0;
        // An opening of a turned wall turns with it, without a note.
        let is_odd = !turned.contains(&surface.base);
        if is_contrary && let Some(opening) = list.get_mut(i) {
            if is_odd {
                notes.add(TURNED_OPENINGS, &opening.object.name);
            }
            turn(opening);
        }
    }
}

fn turn(surface: &mut Surface) {
    surface.vertices.reverse();
    if let Some(frame) = Frame::new(&surface.vertices) {
        surface.frame = frame;
    }
}
