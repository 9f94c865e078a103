//! The types of the model file.
//!
//! Their documentation becomes the descriptions of the JSON Schema, so it addresses the user.
//!
//! [`Section`], [`Material`], [`Damping`], [`Interpolation`], [`Bushing`], [`Joint`], [`Closure`], [`Probe`],
//! [`Predictor`], [`Pulse`], [`Sine`] and [`SpinUp`] have the names of the library types that they become: the schema takes
//! their keys and descriptions from here, the model takes the others.

mod analysis;
mod body;
mod eigenvalues;
mod initial;
mod joint;
mod line;
mod load;
mod probe;
mod scheme;
mod section;
mod time;
mod units;

pub use analysis::{
    Adaptive, Analysis, ArcLength, Branch, Coordinate, Direction, Dynamic, DynamicNewton,
    FigureFormat, Figures, NewtonSettings, Output, Predictor, Static, Stop, TangentRule,
};
pub use body::{Body, Bushing, Six, Spring, Tensor};
pub use eigenvalues::{BucklingAnalysis, CampbellAnalysis, ModalAnalysis};
pub use initial::Initial;
pub use joint::{Acts, Closure, Gear, Joint, JointSpring};
pub use line::{Arc, Imperfection, Interpolation, Line};
pub use load::{DofName, Fix, Group, Load, PrescribedMotion, Support};
pub use probe::{Probe, ProbeQuantity};
pub use scheme::SchemeName;
pub use section::{Circle, Damping, Mass, Material, Rectangle, Section, Stiffness, Tube};
pub use time::{Pulse, Ramp, Sine, SpinUp, Time, Triangle};
pub use units::{Dimension, Units};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A model for `pullback run`: nodes, lines of beam elements between them, bodies, joints, springs,
/// supports, loads, the analysis and what to record. Units are consistent ones of the user's choice; vectors are in global
/// components (e1, e2, e3), angles in radians unless a key ends in `_deg`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "pullback model file")]
pub struct ModelFile {
    /// Title for plots and results.
    pub title: Option<String>,
    /// Names of units, for the axes of figures.
    #[serde(default, skip_serializing_if = "Units::is_empty")]
    pub units: Units,
    /// Cross-sections by name.
    #[serde(default)]
    pub sections: BTreeMap<String, Section>,
    /// Nodes by name: reference position [X, Y, Z]. Names may not contain `/`, which marks the inner
    /// nodes of lines (`line/1`, `line/2`, ...).
    #[serde(default)]
    pub nodes: BTreeMap<String, [f64; 3]>,
    /// Geometric imperfections: the reference configuration is displaced by shapes of an earlier run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub imperfections: Vec<Imperfection>,
    /// Lines of beam elements between nodes.
    #[serde(default)]
    pub lines: Vec<Line>,
    /// Rigid bodies and point masses.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bodies: Vec<Body>,
    /// Joints, and rigid links.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<Joint>,
    /// Gears between joints.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gears: Vec<Gear>,
    /// Springs and dampers between nodes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub springs: Vec<Spring>,
    /// Supports: coordinates of nodes that are held or prescribed.
    #[serde(default)]
    pub supports: Vec<Support>,
    /// Loads on nodes and lines.
    #[serde(default)]
    pub loads: Vec<Load>,
    /// Values by name that loads, actuators and prescribed coordinates read; a program that embeds the library may
    /// change them.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub inputs: BTreeMap<String, f64>,
    /// Initial conditions of a dynamic analysis; at rest in the reference configuration by default.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub initial: Vec<Initial>,
    /// What to compute; load stepping from 0 to 1 with automatic steps when absent.
    #[serde(default)]
    pub analysis: Analysis,
    /// What to record at each step, as columns of `history.csv` and curves of `history.svg`.
    #[serde(default)]
    pub probes: Vec<Probe>,
    /// What to write.
    #[serde(default)]
    pub output: Output,
}

/// A count by default.
fn count<const N: usize>() -> usize {
    N
}
