//! Runs a solver of diffsol along a motion, from chart to chart and kink to kink.

use super::equations::Equations;
use super::{General, GeneralError, Rule};
use diffsol::{
    NalgebraLU, NalgebraMat, NalgebraVec, OdeBuilder, OdeEquations, OdeSolverMethod,
    OdeSolverStopReason, Vector,
};
use pullback_integrators::dynamics::{self, DynamicOptions, Progress, State};
use pullback_manifold::system::{ChartChanges, System};
use std::cell::RefCell;
use std::ops::ControlFlow;

/// Callbacks: `seen` at each of the output times, `go` after every step; each may stop the run.
pub struct Observer<'a, Y: ?Sized> {
    /// Called with the system and its state at an output time.
    pub seen: &'a mut dyn FnMut(&mut Y, &State) -> ControlFlow<()>,
    /// Called after every step.
    pub go: &'a dyn Fn() -> ControlFlow<()>,
}

/// Integrates with a general solver from the state of `progress` to the last of some times. Steps, Newton iterations,
/// evaluations and factorisations (of M and of the solver's own matrices) are counted in the progress, steps that it
/// rejects as inaccurate.
///
/// # Errors
/// [`GeneralError`].
pub fn integrate<Y: System>(
    system: &mut Y,
    progress: &mut Progress,
    how: &General,
    times: &[f64],
    observer: &mut Observer<'_, Y>,
) -> Result<(), GeneralError> {
    let n = system.pattern().dim();
    if let Some(i) = (0..n).find(|&i| system.coordinate_info(i).is_multiplier) {
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
    let scale = tolerances(system, &progress.state, end - begun);
    let mut seen = 0;
    while progress.state.t < end {
        let t = progress.state.t;
        let kink = kinks.iter().copied().find(|kink| *kink > t);
        let span = Span {
            to: kink.map_or(end, f64::next_down),
            times,
            scale: &scale,
        };
        let flow = stretch(system, progress, how, &span, &mut seen, observer)?;
        if flow.is_break() {
            return Ok(());
        }
        if let Some(kink) = kink.filter(|kink| progress.state.t >= kink.next_down()) {
            // The jump of velocities and accelerations is that of the schemes.
            progress.state.t = kink;
            progress.at_kink = true;
            settle(system, progress, end - begun)?;
        }
    }
    progress.summary.finished = true;
    Ok(())
}

/// Initialises charts and accelerations at the start of a section between kinks.
fn settle<Y: System>(
    system: &mut Y,
    progress: &mut Progress,
    time: f64,
) -> Result<(), GeneralError> {
    let step = if time > 0.0 { 1e-3 * time } else { 1.0 };
    let options = DynamicOptions {
        energies: false,
        ..DynamicOptions::new(progress.state.t, step)
    };
    let mut onward = |_: &mut Y, _: &dynamics::StepReport<'_>| ControlFlow::Continue(());
    Ok(dynamics::integrate(
        system,
        progress,
        &options,
        &mut onward,
    )?)
}

/// Scale of each entry of y: that of its coordinate, and for velocities the same over the duration, or the
/// largest velocity at the start.
fn tolerances<Y: System>(system: &Y, state: &State, time: f64) -> Vec<f64> {
    let scales = system.scales().coordinate;
    let kind = |i: usize| system.coordinate_info(i).quantity.index();
    let mut rates = scales.map(|scale| scale / time);
    for (i, v) in state.v.iter().enumerate() {
        rates[kind(i)] = rates[kind(i)].max(v.abs());
    }
    let n = state.q.len();
    let positions = (0..n).map(|i| scales[kind(i)]);
    positions.chain((0..n).map(|i| rates[kind(i)])).collect()
}

/// End of the section without kinks, and the output times.
struct Span<'a> {
    to: f64,
    times: &'a [f64],
    scale: &'a [f64],
}

/// Runs one solver from the state to the end of the span, or to the next change of charts.
fn stretch<Y: System>(
    system: &mut Y,
    progress: &mut Progress,
    how: &General,
    span: &Span<'_>,
    seen: &mut usize,
    observer: &mut Observer<'_, Y>,
) -> Result<ControlFlow<()>, GeneralError> {
    let State { t, q, v, .. } = &progress.state;
    let begin: Vec<f64> = q.iter().chain(v).copied().collect();
    let t = *t;
    let dim = begin.len();
    let equations = RefCell::new(Equations::new(system)?);
    let refused = |reason: String, t: f64| GeneralError::Solver {
        solver: how.to_string(),
        t,
        reason,
    };
    let problem = OdeBuilder::<NalgebraMat<f64>>::new()
        .t0(t)
        .rtol(how.tolerance)
        .atol(span.scale.iter().map(|scale| how.tolerance * scale))
        .rhs_implicit(
            |y: &[f64], _: &[f64], t: f64, out: &mut [f64]| equations.borrow_mut().rate(t, y, out),
            |y: &[f64], _: &[f64], t: f64, dy: &[f64], out: &mut [f64]| {
                equations.borrow_mut().derivative(t, y, dy, out);
            },
        )
        .init(
            |_: &[f64], _: f64, y: &mut [f64]| y.copy_from_slice(&begin),
            dim,
        )
        .build()
        .map_err(|error| refused(error.to_string(), t))?;
    let along = Along {
        equations: &equations,
        span,
    };
    let ended = match how.rule {
        Rule::Bdf => {
            let solver = problem.bdf::<NalgebraLU<f64>>();
            let solver = solver.map_err(|error| refused(error.to_string(), t))?;
            along.drive(solver, progress, seen, observer)
        }
        Rule::Esdirk => {
            let solver = problem.esdirk34::<NalgebraLU<f64>>();
            let solver = solver.map_err(|error| refused(error.to_string(), t))?;
            along.drive(solver, progress, seen, observer)
        }
    };
    let equations = equations.borrow();
    progress.summary.evaluations += equations.evaluations;
    progress.summary.factorisations += equations.factorisations;
    ended.map_err(|(t, reason)| {
        let known = equations.failure.clone();
        refused(
            known.map_or(reason.clone(), |why| format!("{reason}; last, {why}")),
            t,
        )
    })
}

struct Along<'a, 'b, Y: ?Sized> {
    equations: &'a RefCell<Equations<'b, Y>>,
    span: &'a Span<'a>,
}

impl<Y: System> Along<'_, '_, Y> {
    fn drive<'p, E, S>(
        &self,
        mut solver: S,
        progress: &mut Progress,
        seen: &mut usize,
        observer: &mut Observer<'_, Y>,
    ) -> Result<ControlFlow<()>, (f64, String)>
    where
        E: OdeEquations<T = f64, V = NalgebraVec<f64>, M = NalgebraMat<f64>> + 'p,
        S: OdeSolverMethod<'p, E>,
    {
        let start = progress.state.t;
        let failed = |t: f64| move |error: diffsol::DiffsolError| (t, error.to_string());
        solver.set_stop_time(self.span.to).map_err(failed(start))?;
        let mut flow = ControlFlow::Continue(());
        loop {
            let before = solver.state().t;
            let reason = solver.step().map_err(failed(before))?;
            let t = solver.state().t;
            if t.is_nan() || t <= before {
                return Err((before, "its step makes no headway".to_owned()));
            }
            // Output times in this step, in its charts.
            while let Some(&time) = self.span.times.get(*seen).filter(|time| **time <= t) {
                let y = solver.interpolate(time).map_err(failed(time))?;
                self.look(&mut progress.state, time, &y.clone_as_vec())?;
                *seen += 1;
                flow = (observer.seen)(self.equations.borrow_mut().system, &progress.state);
                if flow.is_break() {
                    break;
                }
            }
            let (y, dy) = (
                solver.state().y.clone_as_vec(),
                solver.state().dy.clone_as_vec(),
            );
            let state = &mut progress.state;
            put(state, t, &y, &dy);
            state.algorithmic.copy_from_slice(&state.a);
            let State {
                q,
                v,
                a,
                algorithmic,
                ..
            } = state;
            let system = &mut self.equations.borrow_mut().system;
            let changes = match system.charts() {
                Some(charts) => charts.change_charts(t, q, v, &mut [a, algorithmic]),
                None => ChartChanges::default(),
            };
            progress.summary.chart_changes += changes.charts;
            if flow.is_continue() {
                flow = (observer.go)();
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

    /// A state with its accelerations, not counted as cost.
    fn look(&self, state: &mut State, t: f64, y: &[f64]) -> Result<(), (f64, String)> {
        let mut equations = self.equations.borrow_mut();
        let before = (equations.evaluations, equations.factorisations);
        let mut rate = vec![0.0; y.len()];
        equations.rate(t, y, &mut rate);
        (equations.evaluations, equations.factorisations) = before;
        if rate.iter().any(|x| x.is_nan()) {
            let reason = equations.failure.clone().unwrap_or_default();
            return Err((t, reason));
        }
        put(state, t, y, &rate);
        Ok(())
    }
}

/// Sets a state from y = (q, q̇) and its rate.
fn put(state: &mut State, t: f64, y: &[f64], rate: &[f64]) {
    let n = state.q.len();
    state.t = t;
    state.q.copy_from_slice(&y[..n]);
    state.v.copy_from_slice(&y[n..]);
    state.a.copy_from_slice(&rate[n..]);
}
