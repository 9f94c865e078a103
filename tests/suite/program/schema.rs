//! The committed JSON Schema is the one that the types give.

use crate::support::program::{printed, read, repository};
use serde_json::Value;
use std::path::Path;

#[test]
fn the_committed_schema_is_current() {
    let committed = read(repository("docs/model.schema.json"));
    let current = committed == printed(Path::new("."), "schema");
    assert!(current, "cargo run -- schema > docs/model.schema.json");
}

#[test]
fn every_key_is_documented_and_none_is_open() {
    let schema: Value = serde_json::from_str(&printed(Path::new("."), "schema")).unwrap();
    let mut objects = 0;
    visit(&schema, "", &mut objects);
    assert!(objects > 15, "{objects} objects");
}

/// Objects with fixed keys must say what each key means and refuse others.
fn visit(schema: &Value, path: &str, objects: &mut usize) {
    if let Some(properties) = schema.get("properties").and_then(Value::as_object) {
        *objects += 1;
        assert_eq!(schema["additionalProperties"], false, "{path} is open");
        // A word with data (`{ ramp = ... }`) is documented at the alternative.
        let alternative = properties.len() == 1 && schema.get("description").is_some();
        for (key, property) in properties {
            let documented = property.get("description").is_some() || alternative;
            assert!(documented, "{path}/{key} has no description");
        }
    }
    for (key, value) in schema.as_object().into_iter().flatten() {
        visit(value, &format!("{path}/{key}"), objects);
    }
    for (k, value) in schema.as_array().into_iter().flatten().enumerate() {
        visit(value, &format!("{path}/{k}"), objects);
    }
}
