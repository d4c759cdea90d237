//! What of a model a receiver stands for. In: names that files give to buildings, objects and faces. Out: five texts, each empty where
//! nobody says.

/// What a receiver stands for in the model that it was put on; a text is empty where nobody says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ModelPart {
    /// The object: a city object, a zone or a room, an `o` of OBJ.
    pub object: String,
    /// The whole that the object is a part of: the top of the parents of a city object, the building of a zone.
    pub building: String,
    /// `roof`, `wall`, `window`, `ground`, `floor` or `shade`; any other word of a table of receivers is kept.
    pub kind: String,
    /// What the file calls things of this sort: `BuildingPart`, `Shading:Building:Detailed`.
    pub object_type: String,
    /// The face of the file: its name, or where it stands.
    pub face: String,
}

impl ModelPart {
    /// Columns of a table of receivers, in the order of [`ModelPart::texts`].
    pub const COLUMNS: [&'static str; 5] = ["object", "building", "kind", "object_type", "face"];

    /// The five texts.
    pub fn texts(&self) -> [&str; 5] {
        [&self.object, &self.building, &self.kind, &self.object_type, &self.face]
    }

    /// Of five texts.
    pub fn of_texts([object, building, kind, object_type, face]: [String; 5]) -> Self {
        ModelPart { object, building, kind, object_type, face }
    }

    /// Whether nobody said anything.
    pub fn is_empty(&self) -> bool {
        self.texts().iter().all(|text| text.is_empty())
    }
}
