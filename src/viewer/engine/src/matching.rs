//! Matching of the receivers of two archives. In: ids, positions and normals of both. Out: the
//! partner of each receiver of the second archive, by the rules of the core.

use glam::DVec3;
use heliotile_core::opened::{ReceiverMatching, ReceiverPlace};
use serde::Deserialize;
use serde_json::json;

use crate::answer::{Answer, Numbers};

/// Number that stands for "no partner".
const NONE: u32 = u32::MAX;

/// Properties by which a receiver is recognised.
#[derive(Debug, Deserialize)]
pub struct AskedPlace {
    id: String,
    position: [f64; 3],
    normal: [f64; 3],
}

impl From<AskedPlace> for ReceiverPlace {
    fn from(place: AskedPlace) -> Self {
        let AskedPlace { id, position, normal } = place;
        ReceiverPlace { id, position: DVec3::from(position), normal: DVec3::from(normal) }
    }
}

/// Answers the partners `[receiver after]`, each the receiver before or [`NONE`], and the number of
/// pairs that only the name makes.
pub fn matched(before: Vec<AskedPlace>, after: Vec<AskedPlace>) -> Answer {
    let [before, after] = [before, after].map(|side| side.into_iter().map(ReceiverPlace::from).collect::<Vec<_>>());
    let matching = ReceiverMatching::new(&before, &after);
    let mut partners = vec![NONE; after.len()];
    for pair in &matching.pairs {
        partners[pair.after] = pair.before as u32;
    }
    Answer::of(json!({ "moved": matching.moved() })).with("partners", Numbers::U32(&partners))
}
