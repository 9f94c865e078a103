//! Modes, critical loads, and Campbell diagrams.

use super::Analysis;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Modes of the linear equations of motion about a state of equilibrium or of motion.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ModalAnalysis {
    /// Number of modes; 10 by default.
    #[schemars(range(min = 1))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
    /// The modes nearest to this frequency, in cycles per unit of time; by default the lowest ones.
    #[schemars(range(min = 0.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub near: Option<f64>,
    /// Instead of `count` and `near`: all modes with a natural frequency |λ|/2π in this range, in cycles per unit of time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Leaves out C: damping and gyroscopic terms.
    pub undamped: bool,
    /// The analysis at whose end the modes are found; by default none: the modes are those at load parameter 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after: Option<Box<Analysis>>,
}

/// Critical loads and shapes of buckling: the static stiffness at an equilibrium, extrapolated linearly in the load
/// parameter, is singular.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BucklingAnalysis {
    /// Number of critical loads, nearest to that of the equilibrium, in both directions.
    #[schemars(range(min = 1))]
    pub count: usize,
    /// The static analysis at whose end the equilibrium is; by default none: it is that at load parameter 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after: Option<Box<Analysis>>,
}

impl Default for BucklingAnalysis {
    fn default() -> Self {
        Self {
            count: 4,
            after: None,
        }
    }
}

/// Modes over the speed of a steady rotation: a revolute joint rotates with a constant speed, and everything else is at
/// rest in its coordinates.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CampbellAnalysis {
    /// Revolute joint that rotates.
    pub joint: String,
    /// First speed, in radians per unit of time.
    #[serde(default)]
    pub from: f64,
    /// Last speed; the modes there are written as well.
    pub to: f64,
    /// Number of steps between them.
    #[serde(default = "super::count::<20>")]
    #[schemars(range(min = 1))]
    pub steps: usize,
    /// Number of modes, from the lowest one at the first speed on.
    #[serde(default = "super::count::<6>")]
    #[schemars(range(min = 1))]
    pub count: usize,
}
