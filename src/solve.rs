//! Runs the analysis of a job; the only caller of the solvers.

use crate::input::Plan;
use crate::output::Ending;
use crate::terminal::plural;
use pullback_elements::model::Context;
use pullback_elements::time::Input;
use pullback_integrators::dynamics::{
    self, DynamicOptions, DynamicsError, EnergyBalance, Progress, State, StepReport,
};
use pullback_integrators::linearization::{CampbellError, SteadyMotion};
use pullback_integrators::significant;
use pullback_integrators::statics::{
    Iteration, StaticOptions, StaticSummary, StaticsError, Step, StepParameter, solve_statics,
    trace_path,
};
use serde::ser::{SerializeMap, Serializer};
use std::error::Error;
use std::ops::ControlFlow;

/// A converged step of any analysis.
#[derive(Clone, Copy, Debug, Default)]
pub struct Advance<'a> {
    /// Number of the step, from 1; located events repeat the number of the step they lie in.
    pub number: usize,
    /// Load parameter or time.
    pub t: f64,
    /// Step in it, or along the path.
    pub step_size: f64,
    /// Linear solutions of this step.
    pub iterations: usize,
    /// History of the iterations; the last entry is the converged state.
    pub residuals: &'a [Iteration],
    /// Charts changed by this step.
    pub chart_changes: usize,
    /// Index of the event located here, if it is one.
    pub event: Option<usize>,
    /// Number of unstable directions of an equilibrium, where known.
    pub unstable: Option<usize>,
    /// State of a motion.
    pub progress: Option<&'a Progress>,
}

impl<'a> Advance<'a> {
    /// A step of the search for modes at the end of an analysis.
    pub(crate) fn search(progress: &'a Progress, dimension: usize) -> Self {
        Self {
            number: progress.summary.steps,
            t: progress.state.t,
            iterations: dimension,
            // Equilibria have no velocities.
            progress: Some(progress).filter(|progress| !progress.state.v.is_empty()),
            ..Self::default()
        }
    }

    /// Its number, time or load parameter, size and iterations in words.
    pub fn describe(&self) -> String {
        let parameter = match self.progress {
            Some(_) => "time",
            None => "load parameter",
        };
        format!(
            "step {}  {parameter} {}  step size {:.3e}  {}",
            self.number,
            significant(self.t),
            self.step_size,
            plural(self.iterations, "iteration")
        )
    }

    /// The completed part of a motion from 0 to `to`, at most 1.
    pub fn part(&self, to: f64) -> f64 {
        match to > 0.0 {
            true => (self.t / to).clamp(0.0, 1.0),
            false => 1.0,
        }
    }
}

impl<'a> From<&Step<'a>> for Advance<'a> {
    fn from(step: &Step<'a>) -> Self {
        Self {
            number: step.number,
            t: step.t,
            step_size: step.step_size,
            iterations: step.iterations,
            residuals: step.residuals,
            // A located event repeats the changes of the step it lies in.
            chart_changes: match step.event {
                Some(_) => 0,
                None => step.chart_changes,
            },
            event: step.event,
            unstable: step.unstable,
            progress: None,
        }
    }
}

impl<'a> From<&StepReport<'a>> for Advance<'a> {
    fn from(step: &StepReport<'a>) -> Self {
        Self {
            number: step.progress.summary.steps,
            t: step.progress.state.t,
            step_size: step.step_size,
            iterations: step.iterations,
            residuals: step.residuals,
            chart_changes: step.chart_changes,
            progress: Some(step.progress),
            ..Self::default()
        }
    }
}

/// Statistics of an analysis, complete or not.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Counts {
    /// Converged steps.
    pub steps: usize,
    /// Attempts that did not converge.
    pub rejected: usize,
    /// Attempts rejected by the estimate of the local error.
    pub inaccurate: usize,
    /// Linear solutions in converged steps.
    pub iterations: usize,
    /// Evaluations of the model.
    pub evaluations: usize,
    /// Factorisations.
    pub factorisations: usize,
    /// Changes of chart.
    pub chart_changes: usize,
    /// Energies, in dynamics.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "energies")]
    pub energy: Option<EnergyBalance>,
    /// The largest stable step, if the scheme has a limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stable_step: Option<f64>,
}

/// The energies in `result.json`, without those needed to resume only.
fn energies<S: Serializer>(energy: &Option<EnergyBalance>, to: S) -> Result<S::Ok, S::Error> {
    let Some(energy) = energy else {
        return to.serialize_none();
    };
    let mut map = to.serialize_map(Some(5))?;
    map.serialize_entry("start", &energy.start)?;
    map.serialize_entry("now", &energy.now)?;
    map.serialize_entry("work", &energy.work)?;
    map.serialize_entry("gross", &energy.gross)?;
    map.serialize_entry("largest_defect", &energy.largest_defect)?;
    map.end()
}

impl Counts {
    fn of_statics(s: &StaticSummary) -> Self {
        Self {
            steps: s.steps,
            rejected: s.rejected,
            iterations: s.iterations,
            evaluations: s.evaluations,
            factorisations: s.factorisations,
            chart_changes: s.chart_changes,
            ..Self::default()
        }
    }

    /// Counts a converged step of statics, or takes over those of a motion so far.
    pub(crate) fn add(&mut self, step: &Advance<'_>) {
        if let Some(progress) = step.progress {
            *self = Self::of_motion(&progress.summary);
            return;
        }
        self.iterations += step.iterations;
        if step.event.is_none() {
            self.steps = step.number;
            self.chart_changes += step.chart_changes;
        }
    }

    /// Counts of a motion so far.
    pub fn of_motion(s: &dynamics::Summary) -> Self {
        Self {
            steps: s.steps,
            rejected: s.failed,
            inaccurate: s.inaccurate,
            iterations: s.iterations,
            evaluations: s.evaluations,
            factorisations: s.factorisations,
            chart_changes: s.chart_changes,
            energy: s.energy,
            stable_step: s.stable_step,
        }
    }
}

/// End of an analysis, and its reason.
#[derive(Debug)]
pub struct Ended {
    /// Its statistics.
    pub counts: Counts,
    /// How it ended.
    pub ending: Ending,
}

impl Ended {
    /// The end at `t` of an analysis that came to its end, or did not, in at most so many steps; or its failure.
    fn new<E: Error>(counts: Counts, t: f64, most: Option<usize>, solved: Result<bool, E>) -> Self {
        let ending = match (solved, most) {
            (Err(failure), _) => Ending::Failed {
                message: failure.to_string(),
            },
            (Ok(true), _) => Ending::Complete,
            (Ok(false), Some(max_steps)) if counts.steps >= max_steps => {
                Ending::StepLimit { max_steps, t }
            }
            (Ok(false), _) => Ending::Interrupted { t },
        };
        Self { counts, ending }
    }
}

/// Initialises charts, consistent accelerations and energies at the start of a motion; of a resumed one
/// only the charts.
///
/// # Errors
/// [`DynamicsError`].
pub fn begin(
    context: &mut Context,
    options: &DynamicOptions,
    progress: &mut Progress,
) -> Result<(), DynamicsError> {
    let options = DynamicOptions {
        to: progress.state.t,
        ..*options
    };
    dynamics::integrate(context, progress, &options, &mut |_, _| {
        ControlFlow::Continue(())
    })
}

/// Finds the equilibrium in a steady rotation from `q`; the state of `progress` is then at rest in these coordinates.
fn relative_equilibrium(
    context: &mut Context,
    (speed, options): (Input, &StaticOptions),
    mut q: Vec<f64>,
    progress: &mut Progress,
) -> Result<StaticSummary, CampbellError> {
    let mut steady = SteadyMotion::new(context, 0.0, speed);
    let mut go_on = |_: &mut _, _: &Step<'_>| ControlFlow::Continue(());
    let solved = solve_statics(&mut steady, &mut q, options, &mut go_on);
    let zeros = vec![0.0; q.len()];
    progress.state = State {
        q,
        v: zeros.clone(),
        a: zeros,
        ..State::default()
    };
    solved.map_err(|source| CampbellError::Equilibrium {
        speed: options.to,
        source: source.of(StepParameter::Speed),
    })
}

/// Runs the analysis of the plan, a motion from the state of `progress`, and leaves the state reached there;
/// `observer` is called at every
/// converged step, with the model in its configuration, and may stop the analysis.
pub fn solve(
    context: &mut Context,
    plan: &Plan,
    progress: &mut Progress,
    observer: &mut dyn FnMut(&mut Context, &Advance<'_>) -> ControlFlow<()>,
) -> Ended {
    let mut q = context.initial().to_vec();
    let (mut counts, mut t, mut most) = (Counts::default(), plan.start(), None);
    let mut seen = |context: &mut Context, step: &Step<'_>| {
        let advance = Advance::from(step);
        counts.add(&advance);
        t = step.t;
        observer(context, &advance)
    };
    let statics = match plan {
        Plan::Static(options) => solve_statics(context, &mut q, options, &mut seen),
        Plan::Path(options, _) => {
            most = Some(options.max_steps);
            trace_path(context, &mut q, options, &mut seen)
        }
        Plan::Steady(speed, options) => {
            let solved = relative_equilibrium(context, (*speed, options), q, progress);
            let solved = solved.map(|summary| {
                counts = Counts::of_statics(&summary);
                let advance = Advance {
                    iterations: summary.iterations,
                    chart_changes: summary.chart_changes,
                    ..Advance::default()
                };
                observer(context, &advance).is_continue()
            });
            return Ended::new(counts, 0.0, None, solved);
        }
        Plan::Dynamic(plan) => {
            let solved =
                dynamics::integrate(context, progress, &plan.options, &mut |context, step| {
                    observer(context, &Advance::from(step))
                });
            let (counts, t) = (Counts::of_motion(&progress.summary), progress.state.t);
            let solved = solved.map(|()| progress.summary.finished);
            return Ended::new(counts, t, None, solved);
        }
    };
    progress.state.q = q;
    match &statics {
        Ok(summary) => {
            progress.state.t = summary.t;
            counts = Counts::of_statics(summary);
        }
        Err(StaticsError::Step(step)) => {
            counts.rejected = step.rejected;
            counts.evaluations = step.evaluations;
            counts.factorisations = step.factorisations;
        }
        Err(_) => {}
    }
    Ended::new(counts, t, most, statics.map(|summary| summary.finished))
}
