//! Rigid bodies and point masses, springs and dampers.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A rigid body fixed to a node, or a point mass where no `inertia` is given.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Name.
    pub name: String,
    /// Node that moves with it.
    pub node: String,
    /// Mass.
    pub mass: f64,
    /// Moments of inertia about the centre of mass, in global axes of the reference
    /// configuration: three principal ones, or a symmetric 3×3 tensor row by row.
    pub inertia: Option<Tensor>,
    /// Position of the centre of mass as seen from the node, in global components of the reference
    /// configuration; the node itself by default.
    pub center: Option<[f64; 3]>,
}

/// A tensor of inertia.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected three numbers, or three rows of three numbers"
)]
pub enum Tensor {
    /// Three principal moments about the global axes.
    Diagonal([f64; 3]),
    /// The whole symmetric tensor.
    Full([[f64; 3]; 3]),
}

/// A spring and damper between two nodes: along the line between them (`stiffness`, `damping`,
/// `rest_length`), or a `bushing` that resists all six relative motions.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spring {
    /// Name.
    pub name: String,
    /// The two nodes.
    pub nodes: [String; 2],
    /// Stiffness along the line.
    pub stiffness: Option<f64>,
    /// Damping along the line: force per velocity.
    pub damping: Option<f64>,
    /// Free length; that of the reference configuration by default.
    pub rest_length: Option<f64>,
    /// Six stiffnesses and dampings instead.
    pub bushing: Option<Bushing>,
}

/// Stiffness and damping of the relative displacement (three) and rotation (three) of two nodes,
/// about the global axes, carried by the first node.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bushing {
    /// Six stiffnesses, or a symmetric 6×6 matrix row by row.
    pub stiffness: Six,
    /// Six dampings, or a symmetric 6×6 matrix row by row; none by default.
    pub damping: Option<Six>,
}

/// A symmetric matrix over three displacements and three rotations.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected six numbers, or six rows of six numbers"
)]
#[allow(clippy::large_enum_variant, reason = "there are few of them")]
pub enum Six {
    /// Its diagonal.
    Diagonal([f64; 6]),
    /// All of it.
    Full([[f64; 6]; 6]),
}
