//! Objects of a scene: buildings and their parts, trees, terrain, zones. In: what files say of them. Out: one noun for scenes and archives.

/// An object of a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneObject {
    /// What its surfaces are called after.
    pub name: String,
    /// What is known of it besides.
    pub note: ObjectNote,
}

/// What a file says of an object; a text that it does not give is empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ObjectNote {
    /// What tables call the object, if not by the name that its surfaces are called after.
    pub object: String,
    /// The whole that it is a part of.
    pub building: String,
    /// What the file calls things of this sort.
    pub object_type: String,
    /// Whether it stands beside the buildings of a city model: a bridge, a tree, furniture.
    pub beside: bool,
    /// What its file states of it, such as a name or a year: a JSON object without nested values.
    pub attributes: String,
}
