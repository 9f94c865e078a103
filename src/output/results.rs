//! `result.json`: settings, summary and the final state.

use crate::input::ModelFile;
use serde::Serialize;
use std::collections::BTreeMap;

/// Name of the file.
pub(super) const NAME: &str = "result.json";

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Ending {
    /// It has not ended (or the program was killed).
    Running,
    /// The end of the load, or a stop on the path, was reached.
    Complete,
    /// The user or an observer stopped it.
    Interrupted {
        /// Load parameter of the last converged step.
        t: f64,
    },
    /// The path had its most steps before any stop was reached.
    StepLimit {
        /// The limit.
        max_steps: usize,
        /// Load parameter of the last converged step.
        t: f64,
    },
    /// The solver failed.
    Failed {
        /// Its whole message.
        message: String,
    },
}

/// The content of `result.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Results<'a> {
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
    pub settings: &'a ModelFile,
    /// Counts.
    pub statistics: Statistics,
    /// The last converged state.
    pub last: Option<&'a FinalState>,
    /// Names of the other files.
    pub files: &'a [String],
}

/// Counts of a run.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Statistics {
    /// Frame nodes.
    pub nodes: usize,
    /// Elements, loads not counted.
    pub elements: usize,
    /// Unknowns.
    pub unknowns: usize,
    /// Whether the tangent is symmetric: all loads are conservative.
    pub symmetric: bool,
    /// Converged steps.
    pub steps: usize,
    /// Failed attempts, where the solver says so.
    pub rejected: Option<usize>,
    /// Linear solutions in converged steps.
    pub iterations: usize,
    /// Factorisations, where the solver says so.
    pub factorisations: Option<usize>,
    /// Evaluations of the model, where the solver says so.
    pub evaluations: Option<usize>,
    /// Changes of chart.
    pub chart_changes: usize,
    /// Wall-clock time in seconds, output included.
    pub seconds: f64,
}

/// A converged state.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FinalState {
    /// Load parameter.
    pub t: f64,
    /// All frame nodes by name.
    pub nodes: BTreeMap<String, NodeResult>,
    /// Supported nodes by name.
    pub reactions: BTreeMap<String, ReactionResult>,
    /// Strain energy.
    pub strain_energy: f64,
    /// Potential of the loads that have one.
    pub load_potential: f64,
}

/// A node.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct NodeResult {
    /// Displacement d, global components.
    pub displacement: [f64; 3],
    /// Rotation vector Ψ in the chart in use, global components.
    pub rotation: [f64; 3],
    /// Current place.
    pub place: [f64; 3],
}

/// Force and moment with which a support acts on the structure, global components.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ReactionResult {
    /// Force.
    pub force: [f64; 3],
    /// Moment; a covector for Ψ where not all three rotations are prescribed.
    pub moment: [f64; 3],
}
