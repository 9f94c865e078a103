//! The scheme of a dynamic analysis, by its name in the list of schemes.

use crate::method::{Method, PREFIXES};
use pullback_integrators::dynamics::DynamicsError;
use pullback_integrators::dynamics::scheme::{Family, SCHEMES};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Value, json};
use std::borrow::Cow;
use std::fmt;

/// A scheme by its name, `"bathe"` or `"ga:0.8"`, or as `{ generalised-alpha = 0.8 }`, with the prefix
/// of a formulation of rotations ([`PREFIXES`]) unless that is the total one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SchemeName(String);

impl Default for SchemeName {
    /// Some damping of the highest frequencies, which no step resolves.
    fn default() -> Self {
        Self::from("generalised-alpha:0.9")
    }
}

impl From<&str> for SchemeName {
    fn from(word: &str) -> Self {
        Self(word.to_owned())
    }
}

impl SchemeName {
    /// The scheme and the formulation.
    ///
    /// # Errors
    /// [`DynamicsError`] for an unknown name, or a parameter outside its range.
    pub fn method(&self) -> Result<Method, DynamicsError> {
        self.0.parse()
    }
}

/// Parameters of a scheme: one, or a list.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected the numbers of the scheme, such as { generalised-alpha = 0.9 } or \
                 { newmark = [0.25, 0.5] }"
)]
enum Numbers {
    One(f64),
    Many(Vec<f64>),
}

struct Words;

impl<'de> Visitor<'de> for Words {
    type Value = SchemeName;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a scheme, such as \"bathe\" or { generalised-alpha = 0.8 }")
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<SchemeName, E> {
        Ok(SchemeName::from(word))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<SchemeName, A::Error> {
        let Some(mut word) = map.next_key::<String>()? else {
            return Err(A::Error::custom("no scheme is named"));
        };
        let numbers = match map.next_value()? {
            Numbers::One(number) => vec![number],
            Numbers::Many(numbers) => numbers,
        };
        for number in numbers {
            word += &format!(":{number}");
        }
        match map.next_key::<String>()? {
            None => Ok(SchemeName(word)),
            Some(other) => Err(A::Error::custom(format!(
                "one scheme is enough, and `{other}` is a second one"
            ))),
        }
    }
}

impl<'de> Deserialize<'de> for SchemeName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Words)
    }
}

/// `{ name = parameters }`, for a scheme with parameters.
fn table(family: &Family) -> Option<Value> {
    let takes = |n: usize| (family.make)(&[0.25, 0.5][..n]).is_some();
    let one = takes(1).then(|| json!({ "type": "number" }));
    let several = takes(2).then(
        || json!({ "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 2 }),
    );
    let forms: Vec<Value> = one.into_iter().chain(several).collect();
    (!forms.is_empty()).then(|| {
        json!({
            "description": family.usage,
            "type": "object",
            "properties": { family.long: { "anyOf": forms } },
            "required": [family.long],
            "additionalProperties": false,
        })
    })
}

impl JsonSchema for SchemeName {
    fn schema_name() -> Cow<'static, str> {
        "Scheme".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let words: Vec<&str> = SCHEMES.iter().flat_map(|f| [f.word, f.long]).collect();
        let prefixes: Vec<&str> = PREFIXES.iter().map(|p| p.word).collect();
        let usages: Vec<&str> = SCHEMES.iter().map(|f| f.usage).collect();
        let prefixed = PREFIXES.iter().filter(|p| !p.word.is_empty());
        let formulations: Vec<String> = prefixed
            .map(|p| format!("{}, {}", p.word, p.about))
            .collect();
        let word = json!({
            "description": format!("{}; with a prefix: {}", usages.join("; "), formulations.join("; ")),
            "type": "string",
            "pattern": format!("^({})({})(:-?[0-9.eE+-]+)*$", prefixes.join("|"), words.join("|")),
        });
        let all: Vec<Value> = [word]
            .into_iter()
            .chain(SCHEMES.iter().filter_map(table))
            .collect();
        let mut schema = Schema::default();
        let about = "A scheme of time integration, by its word or as a table of its numbers.";
        schema.insert("description".to_owned(), json!(about));
        schema.insert("oneOf".to_owned(), Value::Array(all));
        schema
    }
}
