//! Supports and loads.

use super::Time;
use pullback_elements::model::Dof;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A coordinate of a node, in global components.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum DofName {
    /// Displacement along e1.
    X,
    /// Displacement along e2.
    Y,
    /// Displacement along e3.
    Z,
    /// Rotation vector component about e1.
    RX,
    /// Rotation vector component about e2.
    RY,
    /// Rotation vector component about e3.
    RZ,
}

impl DofName {
    /// All six.
    pub const ALL: [Self; 6] = [Self::X, Self::Y, Self::Z, Self::RX, Self::RY, Self::RZ];

    /// The coordinate of the model.
    pub fn dof(self) -> Dof {
        Dof::ALL[self as usize]
    }

    /// Its name in the file.
    pub fn key(self) -> &'static str {
        ["x", "y", "z", "rx", "ry", "rz"][self as usize]
    }
}

/// A support of one node.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Support {
    /// Name of the node.
    pub node: String,
    /// Coordinates held at zero: a list of "x", "y", "z", "rx", "ry", "rz", or "all", or "position"
    /// (x, y, z), or "rotation" (rx, ry, rz).
    pub fix: Option<Fix>,
    /// Coordinates prescribed as functions of the load parameter, or of time.
    pub prescribed: Option<PrescribedMotion>,
}

/// Which coordinates are held.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected \"all\", \"position\", \"rotation\", or a list of \"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\" (`place` is now `position`)"
)]
#[non_exhaustive]
pub enum Fix {
    /// A named group.
    Group(Group),
    /// A list.
    List(Vec<DofName>),
}

/// A group of coordinates.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Group {
    /// All six.
    All,
    /// The three displacements: a spherical joint.
    Position,
    /// The three rotations.
    Rotation,
}

impl Fix {
    /// The coordinates.
    pub fn dofs(&self) -> &[DofName] {
        match self {
            Self::Group(Group::All) => &DofName::ALL,
            Self::Group(Group::Position) => &DofName::ALL[..3],
            Self::Group(Group::Rotation) => &DofName::ALL[3..],
            Self::List(list) => list,
        }
    }
}

/// Coordinates of a node as functions of the load parameter, or of time. The rotation is a rotation
/// vector: with one component prescribed and the other two fixed it is an angle, any number of turns.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PrescribedMotion {
    /// Displacement along e1.
    pub x: Option<Time>,
    /// Displacement along e2.
    pub y: Option<Time>,
    /// Displacement along e3.
    pub z: Option<Time>,
    /// Rotation vector component about e1, in radians.
    pub rx: Option<Time>,
    /// Rotation vector component about e2, in radians.
    pub ry: Option<Time>,
    /// Rotation vector component about e3, in radians.
    pub rz: Option<Time>,
}

impl PrescribedMotion {
    /// The coordinates given, with their functions.
    pub fn given(&self) -> impl Iterator<Item = (DofName, &Time)> {
        let all = [&self.x, &self.y, &self.z, &self.rx, &self.ry, &self.rz];
        DofName::ALL
            .into_iter()
            .zip(all)
            .filter_map(|(dof, time)| Some((dof, time.as_ref()?)))
    }
}

/// A load: exactly one of `force` or `moment` on a `node`, `force_per_length` on a `line`, or
/// `gravity` on all lines and bodies (or on one `line`).
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Load {
    /// Name of the loaded node.
    pub node: Option<String>,
    /// Name of the loaded line.
    pub line: Option<String>,
    /// Force on the node.
    pub force: Option<[f64; 3]>,
    /// Moment on the node.
    pub moment: Option<[f64; 3]>,
    /// Force per reference length of the line.
    pub force_per_length: Option<[f64; 3]>,
    /// Acceleration of gravity: a force per length of Aρ times it on lines, and the weight of bodies.
    pub gravity: Option<[f64; 3]>,
    /// Whether the load rotates with the node or the cross-sections (follower load); otherwise its direction
    /// is fixed in space.
    #[serde(default)]
    pub follower: bool,
    /// Factor as a function of the load parameter or time; by default it grows in proportion to
    /// the load parameter in statics and buckling (`{ proportional = 1 }`), and is constant in dynamics, and for modes
    /// and Campbell diagrams that follow no statics (`{ constant = 1 }`).
    pub time: Option<Time>,
}
