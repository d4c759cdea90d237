//! Building part of a receiver. In: its kind, normal and names. Out: roof, facade or neither.

use heliotile_core::site::receiver::Receiver;

/// Cosine of the tilt that separates roofs from facades if no kind is stated: 60 degrees, and 120
/// at the lower end. Surfaces without semantics are classified alike.
const ROOF_BELOW_Z: f64 = 0.5;

/// Building part that a receiver stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Envelope {
    Roof,
    Facade,
    /// Ground, undersides, shades, windows in roofs, and unknown kinds.
    Neither,
}

impl Envelope {
    /// Classifies a receiver by its kind, or by its tilt if no kind is stated.
    pub fn new(receiver: &Receiver) -> Self {
        let up = receiver.normal.z;
        let upright = up.abs() <= ROOF_BELOW_Z;
        match receiver.part.kind.as_str() {
            "roof" => Envelope::Roof,
            "wall" => Envelope::Facade,
            "window" | "" if upright => Envelope::Facade,
            "" if up > ROOF_BELOW_Z => Envelope::Roof,
            _ => Envelope::Neither,
        }
    }
}

/// Returns the building that a receiver belongs to, or its object if no building is stated.
pub fn building_of(receiver: &Receiver) -> Option<&str> {
    let part = &receiver.part;
    [&part.building, &part.object].into_iter().find(|name| !name.is_empty()).map(String::as_str)
}

/// Returns the face that a receiver lies on, named as in its table: its surface, the face of its
/// file, or its object.
pub fn face_of(receiver: &Receiver) -> &str {
    let part = &receiver.part;
    let names = [receiver.surface.as_deref().unwrap_or_default(), &part.face, &part.object];
    names.into_iter().find(|name| !name.is_empty()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// The kind decides, then the tilt; windows count if they are upright: 8 of 8.
    #[test]
    fn the_kind_decides_before_the_tilt() {
        for (kind, up, expected) in [
            ("roof", 0.1, Envelope::Roof),
            ("wall", 0.9, Envelope::Facade),
            ("window", 0.0, Envelope::Facade),
            ("window", 0.9, Envelope::Neither),
            ("ground", 1.0, Envelope::Neither),
            ("", 0.6, Envelope::Roof),
            ("", 0.4, Envelope::Facade),
            ("", -0.9, Envelope::Neither),
        ] {
            let normal = DVec3::new(f64::sqrt(1.0 - up * up), 0.0, up);
            let mut receiver = Receiver::new("r".into(), DVec3::ZERO, normal);
            receiver.part.kind = kind.into();
            assert_eq!(Envelope::new(&receiver), expected, "{kind} {up}");
        }
    }
}
