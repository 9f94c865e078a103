//! The committed JSON Schema is the one that the types give.
#![allow(clippy::unwrap_used)]

use serde_json::Value;
use std::process::Command;

fn printed() -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_pullback"))
        .arg("schema")
        .output()
        .unwrap();
    assert!(output.status.success());
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn the_committed_schema_is_current() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/model.schema.json");
    let committed = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        committed == printed(),
        "write it anew: cargo run -- schema > docs/model.schema.json"
    );
}

#[test]
fn every_key_is_documented_and_none_is_open() {
    let schema: Value = serde_json::from_str(&printed()).unwrap();
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
    match schema {
        Value::Object(map) => {
            for (key, value) in map {
                visit(value, &format!("{path}/{key}"), objects);
            }
        }
        Value::Array(list) => {
            for (k, value) in list.iter().enumerate() {
                visit(value, &format!("{path}/{k}"), objects);
            }
        }
        _ => {}
    }
}
