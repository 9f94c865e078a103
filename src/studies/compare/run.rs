//! One run of a comparison, and runs in parallel.

use super::Candidate;
use super::grid::Grid;
use super::sample::Sample;
use crate::input::{DynamicPlan, InputError, Job, Plan};
use crate::method::Method;
use crate::solve::point;
use pullback_elements::model::Formulation;
use pullback_integrators::dynamics::{
    DynamicOptions, DynamicsError, NewtonOptions, Progress, Summary, integrate, start,
};
use pullback_manifold::system::SystemError;
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Builds the model of a comparison in a formulation of rotations, anew for each run.
pub type Maker<'a> = dyn Fn(Formulation) -> Result<Job, InputError> + Sync + 'a;

/// Callbacks of a comparison, from any thread.
pub struct Hooks<'a> {
    /// Called after every step; a break ends the comparison.
    pub flow: &'a (dyn Fn() -> ControlFlow<()> + Sync),
    /// Called at the end of every run with the number of finished runs, of all runs, and the name of the scheme.
    pub ended: &'a (dyn Fn(usize, usize, &str) + Sync),
    /// Called before the first run, for every scheme that cannot start this motion, with the reason, which its rows
    /// repeat.
    pub refused: &'a (dyn Fn(&str, &str) + Sync),
}

impl Hooks<'_> {
    /// No callbacks.
    pub const NONE: Hooks<'static> = Hooks {
        flow: &|| ControlFlow::Continue(()),
        ended: &|_, _, _| {},
        refused: &|_, _| {},
    };
}

/// Input of one run.
#[derive(Clone, Debug)]
pub(super) struct Task {
    pub name: String,
    pub candidate: Candidate,
    pub steps: usize,
    /// Tolerance of the residual relative to forces, if it is smaller than that of the model file.
    pub relative: f64,
    /// Whether charts of rotations are kept until [`LATE_CHARTS`].
    pub late_charts: bool,
}

/// The length of a rotation vector, in radians, at which charts that are kept change: three quarters of a
/// turn, as far from half a turn as from the end of the chart.
pub const LATE_CHARTS: f64 = 1.5 * PI;

/// Results of one run.
#[derive(Clone, Debug, Default)]
pub(super) struct RunResult {
    /// Samples at the common times reached.
    pub samples: Vec<Sample>,
    pub summary: Summary,
    /// Assemblies of the model, without those before the first step.
    pub assemblies: usize,
    /// Assemblies before the first step, to find what the scheme requires.
    pub searching: usize,
    /// Reason of its failure.
    pub failure: Option<RunFailure>,
    /// Wall time of the integration.
    pub time: Duration,
}

/// RunFailure of a run.
#[derive(Debug, thiserror::Error, Clone)]
pub(super) enum RunFailure {
    #[error("interrupted")]
    Interrupted,
    #[error("{0}")]
    Failed(String),
}

impl From<DynamicsError> for RunFailure {
    fn from(error: DynamicsError) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<SystemError> for RunFailure {
    fn from(error: SystemError) -> Self {
        Self::Failed(format!("a converged state cannot be evaluated: {error}"))
    }
}

#[cfg(feature = "diffsol")]
impl From<crate::studies::general::GeneralError> for RunFailure {
    fn from(error: crate::studies::general::GeneralError) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<InputError> for RunFailure {
    fn from(error: InputError) -> Self {
        Self::Failed(error.to_string())
    }
}

/// The dynamic plan of a job.
pub(super) fn dynamic(plan: &Plan) -> Option<&DynamicPlan> {
    match plan {
        Plan::Dynamic(plan) => Some(plan),
        _ => None,
    }
}

fn options(task: &Task, method: &Method, grid: &Grid, plan: &DynamicPlan) -> DynamicOptions {
    let step = grid.step(task.steps);
    let newton = plan.options.newton;
    DynamicOptions {
        scheme: method.scheme(),
        step,
        min_step: 1e-6 * step,
        adaptivity: None,
        interval: None,
        newton: NewtonOptions {
            relative: newton.relative.min(task.relative),
            ..newton
        },
        ..plan.options
    }
}

/// Integrates from common time to common time, and samples the model at each.
pub(super) fn drive(make: &Maker<'_>, task: &Task, grid: &Grid, hooks: &Hooks<'_>) -> RunResult {
    let mut ran = RunResult {
        samples: Vec::with_capacity(grid.times + 1),
        ..RunResult::default()
    };
    ran.failure = advance(make, task, grid, hooks, &mut ran).err();
    ran
}

fn advance(
    make: &Maker<'_>,
    task: &Task,
    grid: &Grid,
    hooks: &Hooks<'_>,
    ran: &mut RunResult,
) -> Result<(), RunFailure> {
    let mut job = make(task.candidate.formulation())?;
    if task.late_charts {
        job.context.keep_charts_until(LATE_CHARTS);
    }
    let Some(plan) = dynamic(&job.plan) else {
        return Err(RunFailure::Failed("the analysis is not dynamic".to_owned()));
    };
    let options = match &task.candidate {
        Candidate::Method(method) => options(task, method, grid, plan),
        Candidate::General(general) => {
            let general = general.at(grid.step(task.steps), grid.step(grid.counts[0]));
            return in_general(&mut job, &general, grid, hooks, ran);
        }
    };
    let model = &mut job.context;
    let mut progress = Progress::new(start(model, 0.0, &job.start.q, &job.start.v)?);
    let before = model.assemblies();
    let clock = Instant::now();
    let mut searches = 0;
    for k in 0..=grid.times {
        let to = if k == 0 { 0.0 } else { grid.time(k) };
        let part = DynamicOptions { to, ..options };
        // Every part begins with a search for invariants or the largest frequency, which an undivided run makes
        // once: an empty part measures its cost.
        let here = DynamicOptions {
            to: progress.state.t,
            ..options
        };
        if k == 0 {
            integrate(model, &mut progress, &here, &mut |_, _| (hooks.flow)())?;
            // The same search once more, by a new run.
            let mut anew = Progress {
                invariants: None,
                ..progress.clone()
            };
            let so_far = model.assemblies();
            integrate(model, &mut anew, &here, &mut |_, _| (hooks.flow)())?;
            ran.searching = model.assemblies() - so_far;
            searches += 2 * ran.searching;
        }
        let so_far = model.assemblies();
        integrate(model, &mut progress, &here, &mut |_, _| (hooks.flow)())?;
        // The empty part, and the part itself.
        searches += 2 * (model.assemblies() - so_far);
        let mut stopped = false;
        let integrated = integrate(model, &mut progress, &part, &mut |_, _| {
            let flow = (hooks.flow)();
            stopped = flow.is_break();
            flow
        });
        ran.summary = progress.summary;
        ran.assemblies = match options.scheme.stages() {
            [_] => (model.assemblies() - before).saturating_sub(searches),
            // Several tangents of a state count once; rates are not spins here.
            _ => progress.summary.evaluations,
        };
        ran.time = clock.elapsed();
        integrated?;
        if stopped {
            return Err(RunFailure::Interrupted);
        }
        let defect = progress.summary.energy.map(|e| e.defect());
        ran.samples
            .push(Sample::of(model, point(&progress), defect)?);
    }
    Ok(())
}

/// A run with a general solver, sampled at the common times.
#[cfg(feature = "diffsol")]
fn in_general(
    job: &mut Job,
    general: &crate::studies::general::General,
    grid: &Grid,
    hooks: &Hooks<'_>,
    ran: &mut RunResult,
) -> Result<(), RunFailure> {
    use crate::studies::general::Observer;
    use pullback_elements::model::Context;
    use pullback_integrators::dynamics::State;
    use pullback_manifold::system::Point;
    let model = &mut job.context;
    let mut progress = Progress::new(start(model, 0.0, &job.start.q, &job.start.v)?);
    let clock = Instant::now();
    let before = model.assemblies();
    let times = grid.all_times();
    let mut failed = None;
    let samples = &mut ran.samples;
    let mut observer = Observer {
        seen: &mut |model: &mut Context, state: &State| {
            let at = Point {
                t: state.t,
                q: &state.q,
                v: &state.v,
                a: &state.a,
            };
            match Sample::of(model, at, None) {
                Ok(sample) => samples.push(sample),
                Err(error) => {
                    failed = Some(RunFailure::from(error));
                    return ControlFlow::Break(());
                }
            }
            ControlFlow::Continue(())
        },
        go: hooks.flow,
    };
    let ended =
        crate::studies::general::integrate(model, &mut progress, general, &times, &mut observer);
    ran.summary = progress.summary;
    ran.assemblies = model.assemblies() - before;
    ran.time = clock.elapsed();
    ended?;
    match failed {
        Some(failure) => Err(failure),
        None if !progress.summary.finished => Err(RunFailure::Interrupted),
        None => Ok(()),
    }
}

/// General solvers are refused by programs built without them.
#[cfg(not(feature = "diffsol"))]
fn in_general(
    _: &mut Job,
    general: &crate::studies::general::General,
    _: &Grid,
    _: &Hooks<'_>,
    _: &mut RunResult,
) -> Result<(), RunFailure> {
    let why = format!("{general}: this program is built without the feature `diffsol`");
    Err(RunFailure::Failed(why))
}

/// Most repetitions of a timed run, and the total time after which there are no more.
const REPETITIONS: usize = 5;
const ENOUGH: Duration = Duration::from_millis(500);

/// Wall time of the integration alone, the minimum of some repetitions;
/// `None` if it fails or is stopped.
pub(super) fn clock(
    make: &Maker<'_>,
    task: &Task,
    grid: &Grid,
    hooks: &Hooks<'_>,
) -> Option<Duration> {
    let mut least: Option<Duration> = None;
    let mut spent = Duration::ZERO;
    for _ in 0..REPETITIONS {
        let mut job = make(task.candidate.formulation()).ok()?;
        let time = match &task.candidate {
            Candidate::Method(method) => {
                let options = DynamicOptions {
                    energies: false,
                    ..options(task, method, grid, dynamic(&job.plan)?)
                };
                let model = &mut job.context;
                let from = start(model, 0.0, &job.start.q, &job.start.v).ok()?;
                let mut progress = Progress::new(from);
                let begin = Instant::now();
                integrate(model, &mut progress, &options, &mut |_, _| (hooks.flow)()).ok()?;
                let time = begin.elapsed();
                progress.summary.finished.then_some(time)?
            }
            Candidate::General(general) => {
                let general = general.at(grid.step(task.steps), grid.step(grid.counts[0]));
                let mut ran = RunResult::default();
                in_general(&mut job, &general, grid, hooks, &mut ran).ok()?;
                ran.time
            }
        };
        if (hooks.flow)().is_break() {
            return None;
        }
        least = Some(least.map_or(time, |least| least.min(time)));
        spent += time;
        if spent > ENOUGH {
            break;
        }
    }
    least
}

/// Does `count` pieces of work on this number of threads; results are in the order of the pieces.
pub(in crate::studies) fn side_by_side<T: Send>(
    count: usize,
    threads: usize,
    work: &(dyn Fn(usize) -> T + Sync),
) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::with_capacity(count));
    std::thread::scope(|scope| {
        for _ in 0..threads.clamp(1, count.max(1)) {
            scope.spawn(|| {
                loop {
                    let k = next.fetch_add(1, Ordering::Relaxed);
                    if k >= count {
                        break;
                    }
                    let out = work(k);
                    let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
                    done.push((k, out));
                }
            });
        }
    });
    let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.sort_by_key(|(k, _)| *k);
    done.into_iter().map(|(_, out)| out).collect()
}
