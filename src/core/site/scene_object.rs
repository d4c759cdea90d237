//! Objects of a scene: buildings and their parts, trees, terrain, zones. In: names and attributes
//! from files. Out: one noun for scenes and archives.

/// An object of a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneObject {
    /// Name that its surfaces are called after.
    pub name: String,
    /// Further facts about the object.
    pub note: ObjectNote,
}

/// Facts that a file gives about an object; a text that it does not give is empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ObjectNote {
    /// Name of the object in tables, if other than the name that its surfaces are called after.
    pub object: String,
    /// Name of the whole that it is a part of.
    pub building: String,
    /// Type of the object in the file.
    pub object_type: String,
    /// True if it stands beside the buildings of a city model: a bridge, a tree, furniture.
    pub beside: bool,
    /// Attributes of the object in its file, such as a name or a year: a JSON object without nested
    /// values.
    pub attributes: String,
}
