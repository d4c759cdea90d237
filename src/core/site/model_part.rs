//! Part of a model that a receiver stands for. In: names that files give to buildings, objects and
//! faces. Out: five texts, each empty where the file gives none.

/// Part of a model that a receiver was put on. A text is empty where the file gives none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ModelPart {
    /// Name of the object: a city object, a zone or a room, an `o` of OBJ.
    pub object: String,
    /// Name of the whole that the object is a part of: the top of the parents of a city object, the
    /// building of a zone.
    pub building: String,
    /// `roof`, `wall`, `window`, `ground`, `floor` or `shade`; any other word of a table of
    /// receivers is kept.
    pub kind: String,
    /// Type of the object in the file: `BuildingPart`, `Shading:Building:Detailed`.
    pub object_type: String,
    /// Face of the file: its name, or its place in the file.
    pub face: String,
}

impl ModelPart {
    /// Columns of a table of receivers, in the order of [`ModelPart::texts`].
    pub const COLUMNS: [&'static str; 5] = ["object", "building", "kind", "object_type", "face"];

    /// Returns the five texts.
    pub fn texts(&self) -> [&str; 5] {
        [&self.object, &self.building, &self.kind, &self.object_type, &self.face]
    }

    /// Returns the part with these five texts.
    pub fn of_texts([object, building, kind, object_type, face]: [String; 5]) -> Self {
        ModelPart { object, building, kind, object_type, face }
    }

    /// Returns true if all texts are empty.
    pub fn is_empty(&self) -> bool {
        self.texts().iter().all(|text| text.is_empty())
    }
}
