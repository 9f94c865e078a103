//! Initial conditions.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Initial displacement, rotation and velocity of a node, or initial velocity of a line or of the
/// whole model (when neither `node` nor `line` is given). Nodes of a line or model move like a
/// rigid body: with `velocity` + `angular_velocity` × (x − `about`). Later entries overwrite earlier ones.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Initial {
    /// A node.
    pub node: Option<String>,
    /// A line.
    pub line: Option<String>,
    /// Displacement of the node.
    pub displacement: Option<[f64; 3]>,
    /// Rotation vector of the node, in radians.
    pub rotation: Option<[f64; 3]>,
    /// Velocity; that of the point `about` if it is given.
    pub velocity: Option<[f64; 3]>,
    /// Angular velocity in global components, in radians per unit of time.
    pub angular_velocity: Option<[f64; 3]>,
    /// Instead of `angular_velocity`: components in axes that rotate with the node.
    pub body_angular_velocity: Option<[f64; 3]>,
    /// Point that moves with `velocity`: the origin by default, for a node the node itself.
    pub about: Option<[f64; 3]>,
}
