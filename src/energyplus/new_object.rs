//! An object to be added to a model. In: a class, fields by key, a list. Out: an object that either
//! form of model can write.

/// A value of a field.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldValue {
    Text(String),
    /// A number, written as it stands: its digits are already rounded.
    Number(String),
    /// A blank field in IDF; left out in epJSON.
    Nothing,
}

impl FieldValue {
    /// Returns a number with at most `decimals` decimals.
    pub fn number(value: f64, decimals: usize) -> FieldValue {
        let text = format!("{value:.decimals$}");
        let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
        FieldValue::Number(if short.is_empty() || short == "-0" { "0".into() } else { short.into() })
    }
}

/// An object with the keys of epJSON in the order of IDF.
#[derive(Clone, Debug, PartialEq)]
pub struct NewObject {
    pub class: &'static str,
    pub name: String,
    pub fields: Vec<(&'static str, FieldValue)>,
    /// Key of the list at the end, keys of the parts of its items, and the parts of all items one
    /// after the other.
    pub list: Option<(&'static str, &'static [&'static str], Vec<FieldValue>)>,
    /// True if the name is a field of IDF.
    pub is_named: bool,
}

impl NewObject {
    /// Returns an object without a list; empty texts become blank fields.
    pub fn new(class: &'static str, name: impl Into<String>, fields: &[(&'static str, &str)]) -> NewObject {
        let value = |text: &str| if text.is_empty() { FieldValue::Nothing } else { FieldValue::Text(text.to_owned()) };
        let fields = fields.iter().map(|(key, text)| (*key, value(text))).collect();
        NewObject { class, name: name.into(), fields, list: None, is_named: true }
    }

    /// Returns a sensor of an output of EnergyPlus.
    pub fn sensor(name: String, key: &str, output: &str) -> NewObject {
        let fields =
            [("output_variable_or_output_meter_index_key_name", key), ("output_variable_or_output_meter_name", output)];
        NewObject::new("EnergyManagementSystem:Sensor", name, &fields)
    }

    /// Returns an actuator of a component.
    pub fn actuator(name: String, component: &str, sort: &str, control: &str) -> NewObject {
        let fields = [
            ("actuated_component_unique_name", component),
            ("actuated_component_type", sort),
            ("actuated_component_control_type", control),
        ];
        NewObject::new("EnergyManagementSystem:Actuator", name, &fields)
    }

    /// Returns the object with a list at its end.
    pub fn with_list(mut self, list: &'static str, item: &'static [&'static str], items: Vec<FieldValue>) -> NewObject {
        self.list = Some((list, item, items));
        self
    }

    /// Returns the object with vertices at its end, metres.
    pub fn with_vertices(self, vertices: Vec<[f64; 3]>, decimals: usize) -> NewObject {
        let keys = &["vertex_x_coordinate", "vertex_y_coordinate", "vertex_z_coordinate"];
        self.with_list("vertices", keys, vertices.iter().flatten().map(|m| FieldValue::number(*m, decimals)).collect())
    }

    /// Returns the object as one of a class whose objects have no name in IDF.
    pub fn nameless(mut self) -> NewObject {
        self.is_named = false;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four numbers keep the digits that count: 12.5, 0, 1 and 100.
    #[test]
    fn numbers_keep_their_significant_digits() {
        let text = |value| FieldValue::number(value, 3);
        let of = |text: &str| FieldValue::Number(text.into());
        assert_eq!([12.5, -0.0001, 0.9999, 100.0].map(text), ["12.5", "0", "1", "100"].map(of));
    }
}
