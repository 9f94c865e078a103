//! A case and its rows.

use super::models::model;
use super::motion::History;
use crate::input::{self, Analysis, Dynamic, InputError, ModelFile, with_parameters};
use crate::output::plot::{AxisScale, Graph, PlotCurve, panels};
use pullback_elements::model::{Context, Dof, NodeId, NodeState};
use pullback_integrators::dynamics::DynamicsError;
use pullback_integrators::linearization::CampbellError;
use pullback_integrators::statics::{
    ArcLengthOptions, Event, StaticOptions, StaticsError, Step, solve_statics, trace_path,
};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Computes a case and adds its rows.
pub(super) type Run = fn(&mut CaseReport) -> Result<(), CaseProblem>;

/// Errors of the gallery.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "each message says what its variant is")]
#[non_exhaustive]
pub enum CaseError {
    #[error("there is no case {name}; known cases: {known}")]
    Unknown { name: String, known: String },
    #[error("gallery case {case}: {problem}")]
    Case { case: String, problem: CaseProblem },
}

/// Why a case cannot be computed.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "each message says what its variant is")]
#[non_exhaustive]
pub enum CaseProblem {
    #[error("its model file is not usable: {0}")]
    Model(#[from] Box<InputError>),
    #[error(transparent)]
    Solve(#[from] StaticsError),
    #[error(transparent)]
    Motion(#[from] DynamicsError),
    #[error(transparent)]
    Campbell(#[from] CampbellError),
    #[error("{0}")]
    Setup(&'static str),
    #[error("there is no node {0}")]
    Node(String),
    #[error("no step at load parameter {0}")]
    NoStep(f64),
    #[error("cannot write {}: {reason}", path.display())]
    Plot { path: PathBuf, reason: String },
}

/// One compared quantity.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct CaseRow {
    /// Name of the case.
    pub case: String,
    /// Name of the compared quantity.
    pub quantity: String,
    /// Value computed by this program.
    pub computed: f64,
    /// The published or exact value.
    pub published: f64,
    /// Their difference.
    pub difference: f64,
    /// Largest difference accepted.
    pub tolerance: f64,
    /// Source of the value.
    pub source: String,
    /// Wall time of the whole case.
    pub seconds: f64,
}

impl CaseRow {
    /// Whether the difference is within the tolerance; never for NaN.
    pub fn passed(&self) -> bool {
        self.difference.abs() <= self.tolerance
    }
}

/// Report of a case: its rows and plots.
pub(super) struct CaseReport {
    pub(super) case: &'static str,
    out: Option<PathBuf>,
    rows: Vec<CaseRow>,
}

impl CaseReport {
    pub(super) fn new(case: &'static str, out: Option<&Path>) -> Self {
        Self {
            case,
            out: out.map(Path::to_path_buf),
            rows: Vec::new(),
        }
    }

    pub(super) fn finish(self, seconds: f64) -> Vec<CaseRow> {
        let mut rows = self.rows;
        for row in &mut rows {
            row.seconds = seconds;
        }
        rows
    }

    /// Adds a row.
    pub fn compare(
        &mut self,
        quantity: impl Into<String>,
        computed: f64,
        published: f64,
        tolerance: f64,
        source: &str,
    ) {
        self.rows.push(CaseRow {
            case: self.case.to_owned(),
            quantity: quantity.into(),
            computed,
            published,
            difference: computed - published,
            tolerance,
            source: source.to_owned(),
            seconds: 0.0,
        });
    }

    /// Adds a row for each component of a vector: "`what` along e1" and so on.
    pub fn compare_vector(
        &mut self,
        what: &str,
        computed: impl Into<[f64; 3]>,
        published: [f64; 3],
        tolerance: f64,
        source: &str,
    ) {
        self.compare_parts(what, &computed.into(), &published, tolerance, source);
    }

    /// The same for the first components of a vector.
    pub(super) fn compare_parts(
        &mut self,
        what: &str,
        computed: &[f64],
        published: &[f64],
        tolerance: f64,
        source: &str,
    ) {
        for (k, (computed, published)) in computed.iter().zip(published).enumerate() {
            let quantity = format!("{what} along e{}", k + 1);
            self.compare(quantity, *computed, *published, tolerance, source);
        }
    }

    /// Adds a row for the largest gap of a loop.
    pub(super) fn compare_gap(&mut self, what: &str, gap: f64, tolerance: f64) {
        let source = "exact: the loop is closed at all times";
        self.compare(what, gap, 0.0, tolerance, source);
    }

    /// Adds a row for the energy of a conservative motion.
    pub(super) fn compare_energy(&mut self, run: &History, tolerance: f64) {
        let what = "largest relative change of energy";
        let source = "exact: energy is constant";
        self.compare(what, run.energy_error(), 0.0, tolerance, source);
    }

    /// Adds a row for an order of the trapezoidal rule.
    pub(super) fn compare_order(&mut self, what: impl Into<String>, order: f64, tolerance: f64) {
        self.compare(what, order, 2.0, tolerance, "theory: the trapezoidal rule");
    }

    /// Draws curves over one x axis into `case.svg`, if plots are requested.
    pub(super) fn figure(
        &self,
        title: &str,
        axes: [&str; 2],
        curves: Vec<PlotCurve>,
    ) -> Result<(), CaseProblem> {
        let Some(out) = &self.out else {
            return Ok(());
        };
        let path = out.join(format!("{}.svg", self.case));
        let axes = axes.map(str::to_owned);
        let graph = Graph::new(axes, [AxisScale::Linear; 2], curves);
        let fail = |reason: String| CaseProblem::Plot {
            path: path.clone(),
            reason,
        };
        let svg = panels(Some(title), &[graph]).map_err(|e| fail(e.to_string()))?;
        std::fs::create_dir_all(out).map_err(|e| fail(e.to_string()))?;
        std::fs::write(&path, svg).map_err(|e| fail(e.to_string()))
    }

    /// A model file of the gallery.
    pub(super) fn model(&self, name: &str) -> Result<ModelFile, CaseProblem> {
        self.model_with(name, &[])
    }

    /// A model file of the gallery with other values of parameters, each with its path.
    pub(super) fn model_with(
        &self,
        name: &str,
        values: &[(&str, &str)],
    ) -> Result<ModelFile, CaseProblem> {
        let text = model(Path::new(name)).ok_or(CaseProblem::Setup("it has no model file"))?;
        let text = with_parameters(text, values.iter().copied()).map_err(Box::new)?;
        Ok(input::parse(self.case, &text).map_err(Box::new)?)
    }

    /// Builds a model file and finds the watched node.
    pub(super) fn build(&self, file: &ModelFile, node: &str) -> Result<Watched, CaseProblem> {
        let model = input::job(self.case, file, None).map_err(Box::new)?.context;
        let node = find(&model, node)?;
        Ok(Watched { model, node })
    }

    /// The end of load stepping from 0 to 1, watched at the tip.
    pub(super) fn tip(&self, file: &ModelFile) -> Result<StepRecord, CaseProblem> {
        self.build(file, "tip")?.end(&StaticOptions::default())
    }
}

pub(super) fn find(model: &Context, node: &str) -> Result<NodeId, CaseProblem> {
    let found = model.find(node);
    found.ok_or_else(|| CaseProblem::Node(node.to_owned()))
}

/// A model and the node whose motion is compared.
pub(super) struct Watched {
    pub model: Context,
    pub node: NodeId,
}

/// The watched node at a step or located event.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepRecord {
    pub t: f64,
    pub event: Option<usize>,
    pub iterations: usize,
    pub state: NodeState,
}

impl Watched {
    /// Load steps from the reference state; the records of all steps.
    pub(super) fn solve(
        &mut self,
        options: &StaticOptions,
    ) -> Result<Vec<StepRecord>, CaseProblem> {
        self.solve_from(&mut Vec::new(), options)
    }

    /// Load steps from a state.
    fn solve_from(
        &mut self,
        q: &mut Vec<f64>,
        options: &StaticOptions,
    ) -> Result<Vec<StepRecord>, CaseProblem> {
        let (mut records, node) = (Vec::new(), self.node);
        solve_statics(&mut self.model, q, options, &mut |model, step| {
            records.push(record(model, node, step));
            ControlFlow::Continue(())
        })?;
        Ok(records)
    }

    /// The last record of [`Watched::solve`].
    pub(super) fn end(&mut self, options: &StaticOptions) -> Result<StepRecord, CaseProblem> {
        last(&self.solve(options)?, options.to)
    }

    /// The equilibria at growing load parameters, from the reference state.
    pub(super) fn at_loads(&mut self, loads: &[f64]) -> Result<Vec<StepRecord>, CaseProblem> {
        let mut q = Vec::new();
        let mut from = 0.0;
        let records = loads.iter().map(|&to| {
            let options = StaticOptions {
                from,
                to,
                first_step: to - from,
                max_step: to - from,
                ..StaticOptions::default()
            };
            from = to;
            last(&self.solve_from(&mut q, &options)?, to)
        });
        records.collect()
    }

    /// Follows a path; the records of all steps and events.
    pub(super) fn trace(
        &mut self,
        options: &ArcLengthOptions,
    ) -> Result<Vec<StepRecord>, CaseProblem> {
        let (mut records, node) = (Vec::new(), self.node);
        trace_path(
            &mut self.model,
            &mut Vec::new(),
            options,
            &mut |model, step| {
                records.push(record(model, node, step));
                ControlFlow::Continue(())
            },
        )?;
        Ok(records)
    }

    /// The event that a coordinate of the watched node crosses a value.
    pub(super) fn passes(&self, dof: Dof, value: f64) -> Result<Event, CaseProblem> {
        let unknown = self.model.unknown(self.node, dof);
        let unknown = unknown.ok_or_else(|| CaseProblem::Node(format!("with a free {dof:?}")))?;
        Ok(Event::Coordinate { unknown, value })
    }
}

fn last(records: &[StepRecord], t: f64) -> Result<StepRecord, CaseProblem> {
    records.last().copied().ok_or(CaseProblem::NoStep(t))
}

fn record(context: &Context, node: NodeId, step: &Step<'_>) -> StepRecord {
    StepRecord {
        t: step.t,
        event: step.event,
        iterations: step.iterations,
        state: context.node_state(node),
    }
}

/// A file with this mesh on all lines.
pub(super) fn meshed(file: &ModelFile, elements: usize, order: usize) -> ModelFile {
    let mut file = file.clone();
    for line in &mut file.lines {
        (line.elements, line.order) = (elements, order);
    }
    file
}

/// A file with changes to its dynamic analysis.
fn paced(file: &ModelFile, change: impl FnOnce(&mut Dynamic)) -> ModelFile {
    let mut file = file.clone();
    if let Analysis::Dynamic(analysis) = &mut file.analysis {
        change(analysis);
    }
    file
}

/// A dynamic analysis by another scheme.
pub(super) fn with_scheme(file: &ModelFile, scheme: &str) -> ModelFile {
    paced(file, |analysis| analysis.scheme = scheme.into())
}

/// A dynamic analysis with another step.
pub(super) fn with_step(file: &ModelFile, step: f64) -> ModelFile {
    paced(file, |analysis| analysis.step = step)
}

/// A dynamic analysis with another step and another end.
pub(super) fn until(file: &ModelFile, step: f64, to: f64) -> ModelFile {
    paced(file, |analysis| (analysis.step, analysis.to) = (step, to))
}

/// Observed order of convergence from errors at two meshes, the second twice as fine.
pub(super) fn order(coarse: f64, fine: f64) -> f64 {
    (coarse / fine).abs().log2()
}

/// The largest of some magnitudes.
pub(super) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |most, x| most.max(x.abs()))
}

/// Vertex of the parabola through a point of a curve and its two neighbours.
pub(super) fn peak(curve: &[(f64, f64)], k: usize) -> (f64, f64) {
    let k = k.clamp(1, curve.len().saturating_sub(2).max(1));
    let Some(&[(x0, y0), (x1, y1), (x2, y2)]) = curve.get(k - 1..k + 2) else {
        return (f64::NAN, f64::NAN);
    };
    let (a, b) = ((y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1));
    let bend = (b - a) / (x2 - x0);
    let x = 0.5 * (x0 + x1) - a / (2.0 * bend);
    (x, y1 + (x - x1) * (a + bend * (x - x0)))
}
