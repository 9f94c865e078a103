//! The analysis and its output.

use super::{BucklingAnalysis, CampbellAnalysis, DofName, ModalAnalysis, SchemeName};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What to compute.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Analysis {
    /// Load stepping: equilibrium at growing values of the load parameter.
    Static(Static),
    /// Path following with control of the arc length, through limit points of the load.
    ArcLength(ArcLength),
    /// Motion in time.
    Dynamic(Dynamic),
    /// Frequencies, damping and shapes of small vibrations about a state.
    Modes(ModalAnalysis),
    /// Critical loads and shapes of buckling, extrapolated linearly from an equilibrium.
    Buckling(BucklingAnalysis),
    /// Modes over the speed of a steady rotation.
    Campbell(CampbellAnalysis),
}

impl Analysis {
    /// The analysis that is solved step by step: for modes and buckling, that which leads to their state, if any.
    pub fn stepwise(&self) -> Option<&Self> {
        match self {
            Self::Modes(modes) => modes.after.as_deref(),
            Self::Buckling(buckling) => buckling.after.as_deref(),
            Self::Campbell(_) => None,
            own => Some(own),
        }
    }

    /// Whether it is, or begins with, a motion in time.
    pub fn is_dynamic(&self) -> bool {
        matches!(self.stepwise(), Some(Self::Dynamic(_)))
    }

    /// Whether it is, or begins with, a motion from equilibrium.
    pub(crate) fn begins_in_equilibrium(&self) -> bool {
        matches!(self.stepwise(), Some(Self::Dynamic(d)) if d.from_equilibrium)
    }
}

impl Default for Analysis {
    fn default() -> Self {
        Self::Static(Static::default())
    }
}

/// Load stepping. A step that fails is halved; steps grow when they converge fast.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Static {
    /// Load parameter at the start.
    pub from: f64,
    /// Load parameter at the end.
    pub to: f64,
    /// This many equal steps (halved only where one fails); excludes `first_step` and `max_step`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub steps: Option<usize>,
    /// First step of the load parameter; a tenth of the range by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_step: Option<f64>,
    /// Largest step; a quarter of the range by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_step: Option<f64>,
    /// Smallest step: the analysis fails when a smaller one would be needed; a millionth of the range by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_step: Option<f64>,
    /// Newton's method.
    pub newton: NewtonSettings,
}

impl Default for Static {
    fn default() -> Self {
        Self {
            from: 0.0,
            to: 1.0,
            steps: None,
            first_step: None,
            max_step: None,
            min_step: None,
            newton: NewtonSettings::default(),
        }
    }
}

/// Path following. Arc length is measured in coordinates over the size of the model (one radian)
/// and in the load parameter over `load_scale`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ArcLength {
    /// Load parameter at the start.
    pub from: f64,
    /// First step along the path.
    pub first_step: f64,
    /// Largest step along the path.
    pub max_step: f64,
    /// Smallest step along the path.
    pub min_step: f64,
    /// Most steps.
    #[schemars(range(min = 1))]
    pub max_steps: usize,
    /// Change of the load parameter that counts as much as a change of the coordinates by the size of the model.
    pub load_scale: f64,
    /// Target number of iterations per step.
    #[schemars(range(min = 1))]
    pub target_iterations: usize,
    /// Whether the load increases or decreases at the start.
    pub direction: Direction,
    /// The analysis is complete when one of these is met.
    #[schemars(length(min = 1))]
    pub stop: Vec<Stop>,
    /// These are located and recorded without stopping.
    pub record: Vec<Stop>,
    /// The path beyond the first bifurcation.
    pub branch: Branch,
    /// Newton's method.
    pub newton: NewtonSettings,
}

impl Default for ArcLength {
    fn default() -> Self {
        Self {
            from: 0.0,
            first_step: 0.05,
            max_step: 0.1,
            min_step: 1e-7,
            max_steps: 500,
            load_scale: 1.0,
            target_iterations: 5,
            direction: Direction::Forward,
            stop: vec![Stop::Load(1.0)],
            record: Vec::new(),
            branch: Branch::Keep,
            newton: NewtonSettings::default(),
        }
    }
}

/// Direction in which the load parameter changes at the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// It increases.
    Forward,
    /// It decreases.
    Backward,
}

/// The path beyond a bifurcation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Branch {
    /// The same path.
    Keep,
    /// The one that crosses it.
    Switch,
}

/// An event on the path, located to round-off.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Stop {
    /// The load has a maximum or minimum.
    TurningPoint,
    /// Another path crosses.
    Bifurcation,
    /// The load parameter crosses this value.
    Load(f64),
    /// A coordinate crosses a value.
    Coordinate(Coordinate),
}

/// A coordinate of a node and a value of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Coordinate {
    /// Name of the node.
    pub node: String,
    /// Coordinate; it must be free.
    pub dof: DofName,
    /// The value.
    pub value: f64,
}

/// Motion in time from the initial conditions. Steps are equal between kinks of prescribed
/// functions, where they end exactly; a step that fails is halved, and the size grows back.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Dynamic {
    /// Time at the end; it starts at 0.
    pub to: f64,
    /// Step size.
    pub step: f64,
    /// Smallest step: the analysis fails when a smaller one would be needed; a millionth of `step` by default.
    pub min_step: Option<f64>,
    /// Whether it begins in the static equilibrium of the forces at t = 0, found from the initial configuration, instead
    /// of in this.
    #[serde(default)]
    pub from_equilibrium: bool,
    /// Integration scheme.
    #[serde(default)]
    pub scheme: SchemeName,
    /// Step sizes by an estimate of the local error.
    pub adaptive: Option<Adaptive>,
    /// A row of the history every this many steps.
    #[serde(default = "super::count::<1>")]
    #[schemars(range(min = 1))]
    pub record_every: usize,
    /// Instead of `record_every`: a row at every multiple of this time, where steps end exactly.
    pub record_interval: Option<f64>,
    /// A checkpoint to resume from every this many steps; 0 writes one at the end only.
    #[serde(default)]
    pub checkpoint_every: usize,
    /// Newton's method.
    #[serde(default)]
    pub newton: DynamicNewton,
}

/// Adaptive step sizes.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Adaptive {
    /// Local error of a step allowed, relative to the size of the model (and to one radian).
    pub tolerance: f64,
    /// Largest step; a hundred times `step` by default.
    pub max_step: Option<f64>,
}

/// Newton's method inside a time step.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DynamicNewton {
    /// Residual relative to the largest forces (moments) of the step.
    pub relative: f64,
    /// Absolute floor of the same test, in units of force (moment); with 0 only rounding errors are left.
    #[schemars(range(min = 0.0))]
    pub absolute: f64,
    /// Most iterations per step.
    #[schemars(range(min = 1))]
    pub max_iterations: usize,
    /// How often the tangent is factorised.
    pub tangent: TangentRule,
    /// Initial guess of the iteration.
    pub predictor: Predictor,
}

impl Default for DynamicNewton {
    fn default() -> Self {
        let d = pullback_integrators::dynamics::NewtonOptions::default();
        Self {
            relative: d.relative,
            absolute: d.absolute,
            max_iterations: d.max_iterations,
            tangent: TangentRule::Every,
            predictor: Predictor::Velocity,
        }
    }
}

/// How often the tangent is factorised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum TangentRule {
    /// In every iteration.
    Every,
    /// Once in each step.
    Once,
}

/// Initial guess of Newton's method in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Predictor {
    /// Coordinates extrapolated with the velocities.
    Velocity,
    /// Coordinates of the last step.
    Keep,
}

/// Criteria of convergence and failure of Newton's method.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct NewtonSettings {
    /// Residual relative to the applied and reaction forces (moments).
    pub relative: f64,
    /// Absolute floor of the same test, in units of force (moment); with 0 only rounding errors are left.
    #[schemars(range(min = 0.0))]
    pub absolute: f64,
    /// Most linear solutions per step.
    #[schemars(range(min = 1))]
    pub max_iterations: usize,
}

impl Default for NewtonSettings {
    fn default() -> Self {
        let d = pullback_integrators::statics::StaticNewtonOptions::default();
        Self {
            relative: d.relative,
            absolute: d.absolute,
            max_iterations: d.max_iterations,
        }
    }
}

/// What to write.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// A ParaView file every this many rows of the history, and always at the last; 0 writes none.
    /// By default every row in statics, and about 200 files in dynamics.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paraview_every: Option<usize>,
    /// Figures: true for SVG and `deformed.html`, which plays the run in a browser; false for none; or a list of
    /// formats.
    pub figures: Figures,
    /// Scale factor of the displacements in `deformed.svg` and `deformed.html`, stated in them.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub deformation_scale: f64,
}

impl Default for Output {
    fn default() -> Self {
        Self {
            paraview_every: None,
            figures: Figures::All(true),
            deformation_scale: 1.0,
        }
    }
}

/// Which figures to write.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected true, false, or a list of \"svg\", \"png\", \"pdf\", \"html\""
)]
pub enum Figures {
    /// Those that need no choice, or none.
    All(bool),
    /// Those of these formats.
    Of(Vec<FigureFormat>),
}

/// Format of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum FigureFormat {
    /// Scalable vector graphics.
    Svg,
    /// Pixels, two for each unit of the SVG.
    Png,
    /// A page.
    Pdf,
    /// `deformed.html`.
    Html,
}

impl Figures {
    /// Whether there are none.
    pub fn is_none(&self) -> bool {
        match self {
            Self::All(all) => !all,
            Self::Of(formats) => formats.is_empty(),
        }
    }

    /// Whether figures of a format are written.
    pub fn include(&self, format: FigureFormat) -> bool {
        match self {
            Self::All(all) => *all && matches!(format, FigureFormat::Svg | FigureFormat::Html),
            Self::Of(formats) => formats.contains(&format),
        }
    }
}
