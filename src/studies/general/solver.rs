//! Runs a solver of diffsol along a motion, restarted at changes of chart and at kinks.

use super::equations::FirstOrderSystem;
use super::{General, GeneralError, Rule};
use crate::solve::begin;
use diffsol::{
    DiffsolError, NalgebraLU, NalgebraMat, NalgebraVec, OdeBuilder, OdeEquations, OdeSolverMethod,
    OdeSolverStopReason, Vector,
};
use pullback_elements::model::Context;
use pullback_integrators::dynamics::{DynamicOptions, Progress, State};
use pullback_manifold::system::{Point, System};
use std::cell::RefCell;
use std::ops::ControlFlow;

/// Callbacks at each of the output times and after every step; each may stop the run.
pub struct Observer<'a> {
    /// Called with the system and its state at an output time.
    pub seen: &'a mut dyn FnMut(&mut Context, Point<'_>) -> ControlFlow<()>,
    /// Called after every step.
    pub go: &'a dyn Fn() -> ControlFlow<()>,
}

/// Integrates with a general solver from the state of `progress` to the last of some times. Steps, Newton iterations,
/// evaluations and factorisations (of M and of the solver's own matrices) are counted in the progress, steps that it
/// rejects as inaccurate.
///
/// # Errors
/// [`GeneralError`].
pub fn integrate(
    system: &mut Context,
    progress: &mut Progress,
    how: &General,
    times: &[f64],
    observer: &mut Observer<'_>,
) -> Result<(), GeneralError> {
    let n = system.pattern().dim();
    if let Some(i) = (0..n).find(|&i| system.pattern().coordinates()[i].is_multiplier) {
        return Err(GeneralError::Multiplier {
            solver: how.to_string(),
            multiplier: system.name(i),
        });
    }
    let Some(&end) = times.last() else {
        return Ok(());
    };
    let begun = progress.state.t;
    settle(system, progress, end - begun)?;
    let mut kinks = (system.events()).map_or_else(Vec::new, |events| events.kinks());
    kinks.retain(|&kink| kink > begun && kink < end);
    kinks.sort_by(f64::total_cmp);
    kinks.dedup();
    let mut run = Run {
        how,
        scale: tolerances(system, &progress.state, end - begun),
        times: times.iter(),
        observer,
    };
    while progress.state.t < end {
        let t = progress.state.t;
        let kink = kinks.iter().copied().find(|kink| *kink > t);
        let to = kink.map_or(end, f64::next_down);
        if run.stretch(system, progress, to)?.is_break() {
            return Ok(());
        }
        if let Some(kink) = kink.filter(|kink| progress.state.t >= kink.next_down()) {
            // The jump of velocities and accelerations is that of the schemes.
            progress.state.t = kink;
            progress.state.a.clear();
            settle(system, progress, end - begun)?;
        }
    }
    progress.summary.finished = true;
    Ok(())
}

/// Initialises charts and accelerations at the start of a section between kinks.
fn settle(context: &mut Context, progress: &mut Progress, time: f64) -> Result<(), GeneralError> {
    let step = if time > 0.0 { 1e-3 * time } else { 1.0 };
    let options = DynamicOptions {
        energies: false,
        ..DynamicOptions::new(progress.state.t, step)
    };
    Ok(begin(context, &options, progress)?)
}

/// Scale of each entry of y: that of its coordinate, and for velocities the same over the duration, or the
/// largest velocity at the start.
fn tolerances(system: &Context, state: &State, time: f64) -> Vec<f64> {
    let all = system.pattern().coordinates();
    let mut fastest = [0.0_f64; 3];
    for (info, v) in all.iter().zip(&state.v) {
        let rate = &mut fastest[info.quantity.index()];
        *rate = rate.max(v.abs()).max(info.size / time);
    }
    let rates = all.iter().map(|info| fastest[info.quantity.index()]);
    all.iter().map(|info| info.size).chain(rates).collect()
}

/// A run from chart to chart and kink to kink.
struct Run<'a, 'b> {
    how: &'a General,
    /// Scales of the entries of y.
    scale: Vec<f64>,
    /// The output times ahead.
    times: std::slice::Iter<'a, f64>,
    observer: &'a mut Observer<'b>,
}

/// Time and reason of a failure.
type SolverFailure = (f64, String);

fn failed(t: f64) -> impl Fn(DiffsolError) -> SolverFailure {
    move |error| (t, error.to_string())
}

impl Run<'_, '_> {
    /// Runs one solver from the state to a time, or to the next change of charts.
    fn stretch(
        &mut self,
        system: &mut Context,
        progress: &mut Progress,
        to: f64,
    ) -> Result<ControlFlow<()>, GeneralError> {
        let State { t, q, v, .. } = &progress.state;
        let begin: Vec<f64> = q.iter().chain(v).copied().collect();
        let (t, dim) = (*t, begin.len());
        let equations = RefCell::new(FirstOrderSystem::new(system)?);
        let tolerance = self.how.tolerance;
        let problem = OdeBuilder::<NalgebraMat<f64>>::new()
            .t0(t)
            .rtol(tolerance)
            .atol(self.scale.iter().map(|scale| tolerance * scale))
            .rhs_implicit(
                |y: &[f64], _: &[f64], t: f64, out: &mut [f64]| {
                    equations.borrow_mut().rate(t, y, out)
                },
                |y: &[f64], _: &[f64], t: f64, dy: &[f64], out: &mut [f64]| {
                    equations.borrow_mut().derivative(t, y, dy, out);
                },
            )
            .init(
                |_: &[f64], _: f64, y: &mut [f64]| y.copy_from_slice(&begin),
                dim,
            )
            .build();
        let ended = problem
            .map_err(failed(t))
            .and_then(|problem| match self.how.rule {
                Rule::Bdf => {
                    let solver = problem.bdf::<NalgebraLU<f64>>().map_err(failed(t))?;
                    self.drive(solver, &equations, progress, to)
                }
                Rule::Esdirk => {
                    let solver = problem.esdirk34::<NalgebraLU<f64>>().map_err(failed(t))?;
                    self.drive(solver, &equations, progress, to)
                }
            });
        let equations = equations.borrow();
        progress.summary.evaluations += equations.evaluations;
        progress.summary.factorisations += equations.factorisations;
        ended.map_err(|(t, reason)| GeneralError::Solver {
            solver: self.how.to_string(),
            t,
            reason: match &equations.failure {
                Some(why) => format!("{reason}; last, {why}"),
                None => reason,
            },
        })
    }

    fn drive<'p, E, S>(
        &mut self,
        mut solver: S,
        equations: &RefCell<FirstOrderSystem<'_>>,
        progress: &mut Progress,
        to: f64,
    ) -> Result<ControlFlow<()>, SolverFailure>
    where
        E: OdeEquations<T = f64, V = NalgebraVec<f64>, M = NalgebraMat<f64>> + 'p,
        S: OdeSolverMethod<'p, E>,
    {
        let start = progress.state.t;
        solver.set_stop_time(to).map_err(failed(start))?;
        let mut flow = ControlFlow::Continue(());
        loop {
            let before = solver.state().t;
            let reason = solver.step().map_err(failed(before))?;
            let t = solver.state().t;
            if t.is_nan() || t <= before {
                return Err((before, "its step makes no headway".to_owned()));
            }
            // Output times in this step, in its charts.
            while let Some(&time) = self.times.as_slice().first().filter(|time| **time <= t) {
                let y = solver.interpolate(time).map_err(failed(time))?;
                let equations = &mut equations.borrow_mut();
                look(equations, &mut progress.state, time, &y.clone_as_vec())?;
                self.times.next();
                flow = (self.observer.seen)(equations.system, progress.state.point());
                if flow.is_break() {
                    break;
                }
            }
            let [y, dy] = [solver.state().y, solver.state().dy].map(|y| y.clone_as_vec());
            let state = &mut progress.state;
            put(state, t, &y, &dy);
            state.algorithmic.copy_from_slice(&state.a);
            state.filtered.copy_from_slice(&state.a);
            let changes = state.change_charts(equations.borrow_mut().system);
            progress.summary.chart_changes += changes.charts;
            if flow.is_continue() {
                flow = (self.observer.go)();
            }
            let ended = flow.is_break() || matches!(reason, OdeSolverStopReason::TstopReached);
            if ended || changes.charts > 0 || changes.residual {
                break;
            }
        }
        let spent = solver.get_statistics();
        let summary = &mut progress.summary;
        summary.steps += spent.number_of_steps;
        summary.iterations += spent.number_of_nonlinear_solver_iterations;
        summary.inaccurate += spent.number_of_error_test_failures;
        summary.factorisations += spent.number_of_linear_solver_setups;
        Ok(flow)
    }
}

/// Sets a state with its accelerations; the evaluation is not counted.
fn look(
    equations: &mut FirstOrderSystem<'_>,
    state: &mut State,
    t: f64,
    y: &[f64],
) -> Result<(), SolverFailure> {
    let before = (equations.evaluations, equations.factorisations);
    let mut rate = vec![0.0; y.len()];
    equations.rate(t, y, &mut rate);
    (equations.evaluations, equations.factorisations) = before;
    if rate.iter().any(|x| x.is_nan()) {
        return Err((t, equations.failure.clone().unwrap_or_default()));
    }
    put(state, t, y, &rate);
    Ok(())
}

/// Sets a state from y = (q, q̇) and its rate.
fn put(state: &mut State, t: f64, y: &[f64], rate: &[f64]) {
    let n = state.q.len();
    state.t = t;
    state.q.copy_from_slice(&y[..n]);
    state.v.copy_from_slice(&y[n..]);
    state.a.copy_from_slice(&rate[n..]);
}
