//! Joints, and the springs, actuators and prescribed motions of their coordinates.

use super::Time;
use schemars::JsonSchema;
use serde::de::{Error, IntoDeserializer, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::fmt::{self, Formatter};

/// A joint. It adds a node of its own name that is attached to the parent: lines, bodies, loads and
/// further joints may use that node like any other, but it cannot be supported.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Joint {
    /// Name of the joint and of the node that is attached to it.
    pub name: String,
    /// Type of the joint: a name in the [`Registry`](crate::input::Registry).
    #[serde(rename = "type")]
    pub kind: String,
    /// Node it is attached to; for a slide give `lines` instead.
    pub parent: Option<String>,
    /// Node that is identified with the node of the joint. A node that is still free is then attached to
    /// the joint. One that is attached to something else already, or is supported, closes a
    /// loop: the coordinates of the joints along it then depend on those that it leaves free.
    pub child: Option<String>,
    /// Closure between the node of the joint and the `child`: by a `map` (the default),
    /// by Lagrange `multipliers`, or by a `penalty`.
    #[serde(
        default,
        deserialize_with = "closure",
        skip_serializing_if = "Option::is_none"
    )]
    pub closure: Option<Closure>,
    /// Stiffness of a `penalty`: force over the gap; moment over the turn is this times the square
    /// of the size of the model (the diagonal of the box around its nodes).
    pub penalty: Option<f64>,
    /// Time of dampers in parallel with a `penalty`: damping over stiffness. 0 by default.
    pub penalty_damping: Option<f64>,
    /// Consecutive lines of two-node elements along which a slide moves.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lines: Vec<String>,
    /// Spring and damper on the released coordinate, where there is one.
    pub spring: Option<JointSpring>,
    /// Moment of an actuator on the angle (force along the displacement) as a function of time.
    pub actuator: Option<Time>,
    /// The angle or displacement itself as a function of time.
    pub prescribed: Option<Time>,
    /// Angle or displacement at the start (dynamics); nodes attached to the joint move along, free nodes
    /// do not. In a loop it is kept if the loop closes with it, and is an initial guess otherwise.
    pub value: Option<f64>,
    /// Rate of the angle or displacement at the start (dynamics); the rates of a loop's other joints follow.
    pub rate: Option<f64>,
    /// Springs, actuators and prescribed motions of a joint with several coordinates, by coordinate.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub coordinates: BTreeMap<String, Acts>,
    /// Further keys of this type of joint.
    #[serde(flatten)]
    pub keys: Map<String, Value>,
}

/// Closure between a joint and its child.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Closure {
    /// Coordinates of joints along the loop depend on those that it leaves free.
    Map,
    /// Lagrange multipliers are unknowns: for statics, and schemes that damp infinite frequencies.
    Multipliers,
    /// Stiff springs.
    Penalty,
}

/// Reads the name of a closure; any other lists the names.
fn closure<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Closure>, D::Error> {
    struct Word;
    impl Visitor<'_> for Word {
        type Value = Closure;

        fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
            f.write_str("one of the words \"map\", \"multipliers\" and \"penalty\"")
        }

        fn visit_str<E: Error>(self, word: &str) -> Result<Closure, E> {
            Closure::deserialize(word.into_deserializer())
        }
    }
    from.deserialize_str(Word).map(Some)
}

/// A pair of gears, a rack on a pinion: coordinates of two joints in a fixed ratio.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gear {
    /// The two joints; name one coordinate of a joint with several, as in `"hub angle 2"`.
    pub joints: [String; 2],
    /// Second coordinate over first one: -z1/z2 for gears with z1 and z2 teeth, the radius of the
    /// pinion (or less it) for the displacement of a rack over its angle.
    pub ratio: f64,
}

/// Spring, actuator, prescribed motion and initial values of a released coordinate.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Acts {
    /// Spring and damper.
    pub spring: Option<JointSpring>,
    /// Moment of an actuator on an angle (force along a displacement) as a function of time.
    pub actuator: Option<Time>,
    /// The coordinate itself as a function of time.
    pub prescribed: Option<Time>,
    /// Its value at the start (dynamics).
    pub value: Option<f64>,
    /// Its rate at the start (dynamics).
    pub rate: Option<f64>,
}

impl Acts {
    /// Its keys.
    pub(crate) const KEYS: [&str; 5] = ["spring", "actuator", "prescribed", "value", "rate"];

    /// The keys that are given.
    pub(crate) fn given(&self) -> impl Iterator<Item = &'static str> {
        let given = [
            self.spring.is_some(),
            self.actuator.is_some(),
            self.prescribed.is_some(),
            self.value.is_some(),
            self.rate.is_some(),
        ];
        let keys = Self::KEYS.into_iter().zip(given);
        keys.filter_map(|(key, given)| given.then_some(key))
    }
}

impl Joint {
    /// What acts on the only coordinate.
    pub fn acts(&self) -> Acts {
        Acts {
            spring: self.spring,
            actuator: self.actuator.clone(),
            prescribed: self.prescribed.clone(),
            value: self.value,
            rate: self.rate,
        }
    }

    /// What acts on each coordinate; the name is empty if there is one coordinate only.
    pub fn all_acts(&self) -> impl Iterator<Item = (&str, Acts)> {
        let named = self
            .coordinates
            .iter()
            .map(|(n, a)| (n.as_str(), a.clone()));
        std::iter::once(("", self.acts())).chain(named)
    }

    /// Whether something of a kind acts on any coordinate.
    pub fn acts_any(&self, kind: impl Fn(&Acts) -> bool) -> bool {
        self.all_acts().any(|(_, acts)| kind(&acts))
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
    /// Coordinate at which the force is zero.
    pub x0: f64,
}
