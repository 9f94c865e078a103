//! Probes: quantities recorded at each step.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A quantity recorded at each step.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// Name: the head of its column. Without `component` there is a column for each of the three,
    /// `name.x`, `name.y`, `name.z` (`name.1` ... for section quantities).
    pub name: String,
    /// What is recorded.
    pub quantity: ProbeQuantity,
    /// Node, for displacement, position, rotation, chart_rotation, velocity, angular_velocity,
    /// acceleration, reaction_force, reaction_moment, joint_force and joint_moment.
    pub node: Option<String>,
    /// Joint, for joint_coordinate, joint_rate, joint_acceleration and joint_effort, joint_force and joint_moment.
    pub joint: Option<String>,
    /// Element such as "line:3", for N, M, Gamma and K (the mean over its integration points).
    pub element: Option<String>,
    /// "x", "y", "z" (global), "1", "2", "3" (section axes, for N, M, Gamma, K), or "norm".
    pub component: Option<String>,
}

/// What a probe records.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[allow(non_camel_case_types, reason = "names of quantities as in the file")]
#[non_exhaustive]
pub enum ProbeQuantity {
    /// Displacement d of a node.
    displacement,
    /// Current position of a node.
    position,
    /// Rotation vector Ψ of a node in radians, continued over changes of chart. About a fixed axis
    /// it counts turns; about a moving axis use joint_coordinate.
    rotation,
    /// Rotation vector Ψ of a node in the chart in use; jumps by a turn where the chart changes.
    chart_rotation,
    /// Velocity of a node.
    velocity,
    /// Angular velocity of a node, global components.
    angular_velocity,
    /// Acceleration of a node.
    acceleration,
    /// Rate of the angular velocity of a node, global components.
    angular_acceleration,
    /// Coordinate of a joint: an angle (radians, any number of turns), displacement or arc length.
    joint_coordinate,
    /// Rate of the joint coordinate.
    joint_rate,
    /// Acceleration of the joint coordinate.
    joint_acceleration,
    /// Moment about the axis (force along it) of a joint that its prescribed coordinate requires.
    joint_effort,
    /// Force with which a joint acts on the node that is attached to it.
    joint_force,
    /// Moment with which a joint acts on the node that is attached to it.
    joint_moment,
    /// Force with which the support of a node acts on the structure.
    reaction_force,
    /// Moment with which the support of a node acts on the structure.
    reaction_moment,
    /// Normal force and two shear forces of an element.
    N,
    /// Torque and two bending moments of an element.
    M,
    /// Elongation and two shears of an element.
    Gamma,
    /// Twist and two bendings of an element.
    K,
    /// Strain energy of the structure.
    strain_energy,
    /// Kinetic energy.
    kinetic_energy,
    /// Kinetic energy, strain energy and potential of the loads that have one.
    total_energy,
    /// Defect of the energy balance: energy not supplied by loads and supports, the error of the integration.
    energy_defect,
    /// Linear momentum of everything that has mass.
    momentum,
    /// Angular momentum about the origin of everything that has mass.
    angular_momentum,
}
