//! `result.json`: settings, summary and the final state.

use crate::input::ModelFile;
use crate::probe::Answers;
use crate::solve::Counts;
use pullback_elements::model::Context;
use serde::Serialize;
use serde_json::Value;
use std::collections::{BTreeMap, HashSet};
use std::path::Path;

/// Program and version.
pub(crate) const PROGRAM: &str = concat!("pullback ", env!("CARGO_PKG_VERSION"));

/// Name of the file.
pub(super) const NAME: &str = "result.json";

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[non_exhaustive]
pub enum Ending {
    /// The run has not ended, or the program was killed.
    Running,
    /// The end of the load or of time, or a stop on the path.
    Complete,
    /// Stopped by the user or an observer.
    Interrupted {
        /// Load parameter or time of the last converged step.
        t: f64,
    },
    /// The path reached the limit of steps before any stop.
    StepLimit {
        /// The limit.
        max_steps: usize,
        /// Load parameter or time of the last converged step.
        t: f64,
    },
    /// The solver failed.
    Failed {
        /// Its whole message.
        message: String,
    },
}

impl Ending {
    /// Its kind, as in `result.json`.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Running => "running",
            Self::Complete => "complete",
            Self::Interrupted { .. } => "interrupted",
            Self::StepLimit { .. } => "step_limit",
            Self::Failed { .. } => "failed",
        }
    }

    /// Why the analysis is not complete, if it failed or reached the limit of steps.
    pub fn problem(&self) -> Option<String> {
        match self {
            Self::StepLimit { max_steps, .. } => Some(format!(
                "no stop was reached within max_steps = {max_steps}"
            )),
            Self::Failed { message } => Some(message.clone()),
            Self::Running | Self::Complete | Self::Interrupted { .. } => None,
        }
    }
}

/// The content of `result.json`.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Results<'a> {
    /// Program and version.
    pub program: &'static str,
    /// The model file.
    pub model: &'a str,
    /// Title of the model.
    pub title: Option<&'a str>,
    /// Whether the analysis came to its end.
    pub complete: bool,
    /// How it ended.
    pub ending: &'a Ending,
    /// The model file with all defaults filled in.
    pub settings: toml::Table,
    /// Counts.
    pub statistics: Statistics,
    /// Notes on the model, as on the terminal.
    pub notes: &'a [String],
    /// Warnings about the model or its results.
    pub warnings: &'a [String],
    /// The last converged state.
    pub last: Option<&'a FinalState>,
    /// Names of the other files.
    pub files: &'a [String],
}

/// Counts of a run.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct Statistics {
    /// Frame nodes.
    pub nodes: usize,
    /// Elements, loads not counted.
    pub elements: usize,
    pub unknowns: usize,
    /// Whether the tangent is symmetric: all loads are conservative.
    pub symmetric: bool,
    /// Statistics of the analysis.
    #[serde(flatten)]
    pub counts: Counts,
    /// Largest rotation angle ψ of any node in its chart, in radians.
    pub largest_rotation: f64,
    /// Wall-clock time in seconds, output included.
    pub seconds: f64,
}

/// A converged state.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct FinalState {
    /// Load parameter or time.
    pub t: f64,
    /// All frame nodes by name.
    pub nodes: BTreeMap<String, NodeResult>,
    /// Supported nodes by name.
    pub reactions: BTreeMap<String, ReactionResult>,
    /// Beam elements by name.
    pub elements: BTreeMap<String, ElementResult>,
    pub strain_energy: f64,
    /// Potential of the loads that have one.
    pub load_potential: f64,
    /// Number of unstable directions of the equilibrium, in statics where known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unstable: Option<usize>,
    /// Energy and momentum, in dynamics.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionResult>,
}

/// A node.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct NodeResult {
    /// Displacement d, global components.
    pub displacement: [f64; 3],
    /// Rotation vector Ψ in the chart in use, global components.
    pub rotation: [f64; 3],
    /// Current position.
    pub position: [f64; 3],
    /// Velocity, global components; in dynamics.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<[f64; 3]>,
    /// Angular velocity, global components; in dynamics.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angular_velocity: Option<[f64; 3]>,
}

/// Energy and momentum of everything that has mass.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct MotionResult {
    pub kinetic_energy: f64,
    /// Linear momentum, global components.
    pub momentum: [f64; 3],
    /// Angular momentum about the origin, global components.
    pub angular_momentum: [f64; 3],
}

/// Force and moment with which a support acts on the structure, global components.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct ReactionResult {
    pub force: [f64; 3],
    /// Moment; a covector for Ψ where not all three rotations are prescribed.
    pub moment: [f64; 3],
}

/// Stress resultants of a beam element in section axes, mean over its integration points.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct ElementResult {
    /// Normal and shear forces N₁, N₂, N₃.
    pub N: [f64; 3],
    /// Torque and bending moments M₁, M₂, M₃.
    pub M: [f64; 3],
}

/// Whether the results in a directory are those of a complete run.
pub(crate) fn is_complete(directory: &Path) -> bool {
    let text = super::directory::read(&directory.join(NAME));
    let read = text.map(|text| serde_json::from_slice::<Value>(&text));
    matches!(read, Ok(Ok(read)) if read["complete"] == true)
}

/// The present state of a model.
pub(super) fn final_state(
    context: &Context,
    answers: &Answers,
    t: f64,
    unstable: Option<usize>,
    file: &ModelFile,
) -> FinalState {
    let moving = answers.motion.is_some();
    let nodes = context.frames().map(|(id, name)| {
        let state = context.node_state(id);
        let result = NodeResult {
            displacement: state.d.into(),
            rotation: state.psi.into(),
            position: state.position.into(),
            velocity: moving.then(|| state.velocity.into()),
            angular_velocity: moving.then(|| state.omega.into()),
        };
        (name.to_owned(), result)
    });
    let supported: HashSet<&String> = file.supports.iter().map(|s| &s.node).collect();
    let reactions = (answers.reactions.iter()).filter(|r| supported.contains(&r.node));
    let reactions = reactions.map(|r| {
        let result = ReactionResult {
            force: r.force.into(),
            moment: r.moment.into(),
        };
        (r.node.clone(), result)
    });
    let mut elements = BTreeMap::new();
    for (id, _) in &answers.sections {
        let result = || ElementResult {
            N: answers.mean(*id, |s| s.N).into(),
            M: answers.mean(*id, |s| s.M).into(),
        };
        let name = context.element(*id).0.to_owned();
        elements.entry(name).or_insert_with(result);
    }
    FinalState {
        t,
        nodes: nodes.collect(),
        reactions: reactions.collect(),
        elements,
        strain_energy: answers.strain_energy,
        load_potential: answers.load_potential,
        unstable,
        motion: answers.motion.map(|(balance, _)| MotionResult {
            kinetic_energy: balance.energies.kinetic,
            momentum: balance.momentum.linear.into(),
            angular_momentum: balance.momentum.angular.into(),
        }),
    }
}
