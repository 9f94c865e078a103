//! The JSON Schema of the model file, derived from the types that parse it.

use super::file::ModelFile;
use super::joints::{JointType, Registry};
use schemars::SchemaGenerator;
use serde_json::{Map, Value, json};

impl Registry {
    /// The JSON Schema of model files with these types of joints.
    pub fn schema(&self) -> Value {
        let mut generator = SchemaGenerator::default();
        let types: Vec<(&String, &JointType, Value)> = self
            .types()
            .map(|(name, made)| (name, made, (made.schema)(&mut generator).to_value()))
            .collect();
        let mut root = generator.into_root_schema_for::<ModelFile>().to_value();
        let joint = &mut root["$defs"]["Joint"];
        let all: Vec<Value> = types
            .into_iter()
            .map(|(name, made, keys)| alternative(joint, name, made, &keys))
            .collect();
        *joint = json!({ "description": joint["description"], "oneOf": all });
        root["$id"] = json!("urn:pullback:model");
        root
    }
}

/// A joint of one type: the keys of every joint, and its own.
fn alternative(joint: &Value, name: &str, made: &JointType, keys: &Value) -> Value {
    let unused = if made.along { "parent" } else { "lines" };
    let mut properties: Map<String, Value> = members(&joint["properties"]).collect();
    properties.remove(unused);
    properties.insert(
        "type".to_owned(),
        json!({ "description": keys["description"], "const": name }),
    );
    properties.extend(members(&keys["properties"]));
    let needed = keys["required"].as_array().into_iter().flatten().cloned();
    let base = if made.along { "lines" } else { "parent" };
    let mut required = vec![json!("name"), json!("type"), json!(base)];
    required.extend(needed);
    json!({
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}

fn members(object: &Value) -> impl Iterator<Item = (String, Value)> {
    let members = object.as_object().into_iter().flatten();
    members.map(|(key, value)| (key.clone(), value.clone()))
}
