//! Joints, and what acts on the coordinates they release.

use super::Time;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A joint. It makes a node of its own name that hangs on the master: lines, bodies, loads and
/// further joints may use that node like any other, but it cannot be supported.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Joint {
    /// Name of the joint and of the node that hangs on it.
    pub name: String,
    /// What it releases.
    #[serde(rename = "type")]
    pub kind: JointKind,
    /// Node it hangs on; for a slide give `lines` instead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub master: Option<String>,
    /// Node that is one with the node that hangs on the joint. A node that is still free hangs on
    /// the joint from now on. One that hangs on something else already, or is supported, closes a
    /// loop: the coordinates of the joints along it then follow from those that it leaves free.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub child: Option<String>,
    /// Axis of a revolute joint, in global components of the reference configuration; the master
    /// carries it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<[f64; 3]>,
    /// Place of the node that hangs on an offset.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<[f64; 3]>,
    /// Lines of two-node elements, one after the other, that a slide runs along.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lines: Vec<String>,
    /// Where a slide starts: arc length from the beginning of the first line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<f64>,
    /// Second axis of a universal joint, second shaft of a constant-velocity one; direction of the
    /// first way of a planar one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_axis: Option<[f64; 3]>,
    /// Way of a helical joint in one turn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pitch: Option<f64>,
    /// Spring and damper on the released coordinate, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spring: Option<JointSpring>,
    /// Moment of a motor on the angle (force on the way) as a function of time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motor: Option<Time>,
    /// The angle or way itself as a function of time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub driven: Option<Time>,
    /// Angle or way at the start (dynamics); what hangs on the joint moves along, but not nodes of
    /// their own. In a loop it is kept where the loop closes with it, and a first guess where not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// Rate of the angle or way at the start (dynamics); the rates of a loop's other joints follow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// What acts on the coordinates of a joint that releases several, by their names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub coordinates: BTreeMap<String, Acts>,
}

/// What acts on a released coordinate.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Acts {
    /// Spring and damper.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spring: Option<JointSpring>,
    /// Moment of a motor on an angle (force on a way) as a function of time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motor: Option<Time>,
    /// The coordinate itself as a function of time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub driven: Option<Time>,
    /// Its value at the start (dynamics).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// Its rate at the start (dynamics).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
}

impl Joint {
    /// What acts on its one coordinate.
    pub fn acts(&self) -> Acts {
        Acts {
            spring: self.spring,
            motor: self.motor.clone(),
            driven: self.driven.clone(),
            value: self.value,
            rate: self.rate,
        }
    }

    /// All that acts on its coordinates; the name is empty where there is but one.
    pub fn all_acts(&self) -> impl Iterator<Item = (&str, Acts)> {
        let named = self
            .coordinates
            .iter()
            .map(|(n, a)| (n.as_str(), a.clone()));
        std::iter::once(("", self.acts())).chain(named)
    }
}

/// What a joint releases.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum JointKind {
    /// Nothing: a rigid link to a node at another `place`.
    Offset,
    /// Nothing: a frame at the same place.
    Weld,
    /// The angle about an `axis`, any number of turns.
    Revolute,
    /// All rotations.
    Spherical,
    /// The place along `lines`.
    Slide,
    /// The angles about two crossed axes.
    Universal,
    /// The tilt of shafts along `axis` and `second_axis` that turn equally fast.
    ConstantVelocity,
    /// Way and angle along and about an `axis`.
    Cylindrical,
    /// The way along an `axis`.
    Prismatic,
    /// Two ways in the plane with the normal `axis`, and the angle about it.
    Planar,
    /// The angle about an `axis`, along which it moves by `pitch` in a turn.
    Helical,
}

impl JointKind {
    /// As it is written in the file.
    pub fn key(self) -> &'static str {
        match self {
            Self::Offset => "offset",
            Self::Weld => "weld",
            Self::Revolute => "revolute",
            Self::Spherical => "spherical",
            Self::Slide => "slide",
            Self::Universal => "universal",
            Self::ConstantVelocity => "constant-velocity",
            Self::Cylindrical => "cylindrical",
            Self::Prismatic => "prismatic",
            Self::Planar => "planar",
            Self::Helical => "helical",
        }
    }
}

/// A spring and damper on one coordinate x: force −k (x − x0) − k3 (x − x0)³ − c ẋ.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct JointSpring {
    /// Stiffness.
    pub k: f64,
    /// Cubic stiffness.
    pub k3: f64,
    /// Damping.
    pub c: f64,
    /// Coordinate without force.
    pub x0: f64,
}
