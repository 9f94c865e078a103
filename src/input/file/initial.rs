//! Initial conditions.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Initial displacement, rotation and velocity of a node, or initial velocity of a line or of the
/// whole model (when neither `node` nor `line` is given). Nodes of a line or model move like a
/// rigid body: with `velocity` + `angular_velocity` × (x − `about`). Later entries overwrite earlier ones.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Initial {
    /// A node.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub node: Option<String>,
    /// A line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<String>,
    /// Displacement of the node.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement: Option<[f64; 3]>,
    /// Rotation vector of the node, in radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<[f64; 3]>,
    /// Velocity; that of the point `about` if it is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<[f64; 3]>,
    /// Angular velocity in global components, in radians per unit of time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angular_velocity: Option<[f64; 3]>,
    /// Instead of `angular_velocity`: components in axes that rotate with the node.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body_angular_velocity: Option<[f64; 3]>,
    /// Point that moves with `velocity`: the origin by default, for a node the node itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub about: Option<[f64; 3]>,
}
