//! The types of joints in model files: those of the library, and a program's own.

use super::types;
use nalgebra::Vector3;
use pullback_elements::beam::Interpolation;
use pullback_elements::joint::{Joint, JointNodes};
use pullback_elements::model::{ModelBuilder, NodeId};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use serde_path_to_error::Segment;
use std::collections::BTreeMap;

/// An error of any type, returned by the constructor of a joint.
pub type BoxedError = Box<dyn std::error::Error + Send + Sync>;

/// The context in which a joint of a model file is constructed.
pub struct Site<'a> {
    /// Builder to which the nodes of joint and coordinates are added.
    pub builder: &'a mut ModelBuilder,
    /// Name of the joint and of its node.
    pub name: &'a str,
    /// Node it is attached to; the first one of `chain`.
    pub parent: NodeId,
    /// Nodes it is attached to: the parent alone, or all nodes of `lines`.
    pub chain: &'a [NodeId],
    /// Interpolation of rotations between those nodes in the beams of `lines`.
    pub interpolation: Interpolation,
    /// Displacement of the node by imperfections.
    pub(super) moved: Vector3<f64>,
}

impl Site<'_> {
    /// A position of the node in the file, displaced by imperfections.
    pub fn displaced(&self, position: [f64; 3]) -> [f64; 3] {
        (Vector3::from(position) + self.moved).into()
    }

    /// Adds a joint to the parent: [`ModelBuilder::attach`].
    ///
    /// # Errors
    /// As [`ModelBuilder::mapped_node`].
    pub fn join<J, const D: usize>(&mut self, joint: J) -> Result<JointNodes, BoxedError>
    where
        J: Joint<D> + Clone + 'static,
    {
        Ok(self.builder.attach(self.name, self.parent, joint)?)
    }

    /// Adds a joint to the parent whose child turns freely: [`ModelBuilder::attach_free`].
    ///
    /// # Errors
    /// As [`ModelBuilder::mapped_node`].
    pub fn join_free<J, const D: usize>(&mut self, joint: J) -> Result<JointNodes, BoxedError>
    where
        J: Joint<D> + Clone + 'static,
    {
        Ok(self.builder.attach_free(self.name, self.parent, joint)?)
    }
}

/// Types of joints by name.
///
/// A program adds its own types to those of [`Registry::standard`]; with
/// [`cli::main`](crate::cli::main) it has all commands of `pullback` for model files with
/// `type = "..."` of its own:
///
/// ```no_run
/// use pullback::elements::joint::Helical;
/// use pullback::input::Registry;
/// use pullback::prelude::*;
///
/// /// A frame that slides along an axis and turns about it.
/// #[derive(Clone, serde::Deserialize, schemars::JsonSchema)]
/// struct Screw {
///     /// Axis, global components of the reference configuration.
///     axis: [f64; 3],
///     /// Displacement per turn.
///     pitch: f64,
/// }
///
/// fn main() -> std::process::ExitCode {
///     let registry = Registry::standard().joint("screw", |at, keys: Screw| {
///         at.join(Helical::new(keys.axis, keys.pitch)?)
///     });
///     pullback::cli::main(&registry)
/// }
/// ```
#[derive(Default)]
pub struct Registry {
    types: BTreeMap<String, JointType>,
}

impl Registry {
    /// The joints of the library.
    pub fn standard() -> Self {
        types::add_to(Self::default())
    }

    /// Adds a type of joint that is attached to one node, the `parent`; one of the same name is replaced.
    ///
    /// `make` takes the keys of the file that are not those of every joint (`name`, `type`, `parent`, springs,
    /// actuators and prescribed motions). `K` is a struct with these keys, whose documentation goes into the
    /// JSON Schema; unknown keys are refused. Springs, actuators, prescribed motions and probes act on the
    /// nodes with one coordinate that `make` returns; their names begin with that of the joint and a blank, as
    /// [`ModelBuilder::attach`] names them.
    #[must_use]
    pub fn joint<K, N, E>(
        mut self,
        name: &str,
        make: impl Fn(&mut Site<'_>, K) -> Result<N, E> + Send + Sync + 'static,
    ) -> Self
    where
        K: DeserializeOwned + JsonSchema,
        N: Into<JointNodes>,
        E: Into<BoxedError>,
    {
        let made = JointType {
            along: false,
            schema: K::json_schema,
            make: Box::new(move |keys, site| {
                let keys = read(keys)?;
                let made = make(site, keys).map_err(|error| Refusal::Joint(error.into()))?;
                Ok(made.into())
            }),
        };
        self.types.insert(name.to_owned(), made);
        self
    }

    /// Like [`Registry::joint`], for a type of joint that is attached to `lines` instead of a
    /// `parent`.
    #[must_use]
    pub fn joint_along<K, N, E>(
        self,
        name: &str,
        make: impl Fn(&mut Site<'_>, K) -> Result<N, E> + Send + Sync + 'static,
    ) -> Self
    where
        K: DeserializeOwned + JsonSchema,
        N: Into<JointNodes>,
        E: Into<BoxedError>,
    {
        let mut registry = self.joint(name, make);
        if let Some(made) = registry.types.get_mut(name) {
            made.along = true;
        }
        registry
    }

    /// The type of a name.
    pub(super) fn get(&self, name: &str) -> Option<&JointType> {
        self.types.get(name)
    }

    /// All types with their names, in alphabetical order.
    pub(in crate::input) fn types(&self) -> impl Iterator<Item = (&String, &JointType)> {
        self.types.iter()
    }
}

type Make = dyn Fn(&Map<String, Value>, &mut Site<'_>) -> Result<JointNodes, Refusal> + Send + Sync;

/// A type of joint.
pub(in crate::input) struct JointType {
    /// Whether it is attached to lines instead of a parent.
    pub along: bool,
    /// Schema of its own keys.
    pub schema: fn(&mut SchemaGenerator) -> Schema,
    /// Constructs a joint from its own keys.
    pub(super) make: Box<Make>,
}

impl JointType {
    /// Names of its own keys.
    pub fn keys(&self) -> Vec<String> {
        let schema = (self.schema)(&mut SchemaGenerator::default());
        let keys = schema.get("properties").and_then(Value::as_object);
        keys.map_or_else(Vec::new, |keys| keys.keys().cloned().collect())
    }
}

/// Why a joint cannot be constructed.
pub(super) enum Refusal {
    /// A missing key.
    Missing(String),
    /// An inapplicable key, by its path.
    Unknown(Vec<String>),
    /// A value of the wrong form, by its path.
    Value(Vec<String>, String),
    /// An error of the constructor.
    Joint(BoxedError),
}

/// Parses the keys of a joint as the struct of its type; all of them must be used.
fn read<K: DeserializeOwned>(keys: &Map<String, Value>) -> Result<K, Refusal> {
    let value = Value::Object(keys.clone());
    let mut unknown = None;
    let mut track = serde_path_to_error::Track::new();
    let source = serde_path_to_error::Deserializer::new(&value, &mut track);
    let taken = serde_ignored::deserialize(source, |path: serde_ignored::Path<'_>| {
        let path = path.to_string();
        unknown.get_or_insert(path.split('.').map(str::to_owned).collect());
    });
    if let Some(path) = unknown {
        return Err(Refusal::Unknown(path));
    }
    taken.map_err(|error| {
        let path = track.path();
        let mut path: Vec<String> = path
            .iter()
            .map(|segment| match segment {
                Segment::Seq { index } => index.to_string(),
                other => other.to_string(),
            })
            .collect();
        let message = error.to_string();
        let named = message.split('`').nth(1).unwrap_or_default().to_owned();
        if message.starts_with("missing field") && path.is_empty() {
            return Refusal::Missing(named);
        }
        if message.starts_with("unknown field") {
            if path.last() != Some(&named) {
                path.push(named);
            }
            return Refusal::Unknown(path);
        }
        Refusal::Value(path, message)
    })
}
