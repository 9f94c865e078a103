//! One run of a comparison, and runs in parallel.

use super::grid::Grid;
use super::sample::Sample;
use super::{Candidate, CompareError, ComparisonRow};
use crate::input::{DynamicPlan, InputError, Job, Plan};
use crate::method::Method;
use crate::solve::{Counts, begin};
use crate::studies::general::General;
use pullback_elements::model::{Context, Formulation};
use pullback_integrators::dynamics::{
    DynamicOptions, DynamicsError, NewtonOptions, Progress, StepReport, integrate,
};
use pullback_manifold::system::Point;
use std::error::Error;
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

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
pub(super) struct Task<'a> {
    pub name: String,
    pub candidate: Candidate,
    pub grid: &'a Grid,
    /// Requested step size.
    pub requested: f64,
    /// Number of steps.
    pub steps: usize,
    /// Tolerance of the residual relative to forces, if it is smaller than that of the model file.
    pub relative: f64,
    /// Whether charts of rotations change at [`LATE_CHARTS`].
    pub late_charts: bool,
}

/// The length of a rotation vector, in radians, at which late changes of chart occur: three quarters of a turn, in the
/// middle between half a turn and the boundary of the chart.
pub const LATE_CHARTS: f64 = 1.5 * PI;

impl Task<'_> {
    fn step(&self) -> f64 {
        self.grid.step(self.steps)
    }

    fn options(&self, method: &Method, plan: &DynamicPlan) -> DynamicOptions {
        let newton = plan.options.newton;
        DynamicOptions {
            scheme: method.scheme(),
            to: self.grid.to,
            step: self.step(),
            min_step: 1e-6 * self.step(),
            adaptivity: None,
            interval: None,
            newton: NewtonOptions {
                relative: newton.relative.min(self.relative),
                ..newton
            },
            ..plan.options
        }
    }

    /// A general solver with the tolerance of this run.
    fn solver(&self, general: &General) -> General {
        general.at(self.step(), self.grid.step(self.grid.counts[0]))
    }

    /// The row of a run that has not begun.
    fn row(&self) -> ComparisonRow {
        ComparisonRow {
            scheme: self.name.clone(),
            requested_step: self.requested,
            step: self.step(),
            samples: Vec::with_capacity(self.grid.times + 1),
            ..ComparisonRow::default()
        }
    }
}

/// Reason of a run that was interrupted.
pub(super) const INTERRUPTED: &str = "interrupted";

impl ComparisonRow {
    /// Adds the sample of a converged state; one that cannot be evaluated ends the run.
    fn sample(
        &mut self,
        model: &mut Context,
        at: Point<'_>,
        defect: Option<f64>,
    ) -> ControlFlow<()> {
        match Sample::of(model, at, defect) {
            Ok(sample) => {
                self.samples.push(sample);
                ControlFlow::Continue(())
            }
            Err(error) => {
                let why = format!("a converged state cannot be evaluated: {error}");
                self.failure = Some(why);
                ControlFlow::Break(())
            }
        }
    }
}

/// The dynamic plan of a job.
pub(super) fn dynamic(plan: &Plan) -> Option<&DynamicPlan> {
    match plan {
        Plan::Dynamic(plan) => Some(plan),
        _ => None,
    }
}

/// Runs a task, and samples the model at the common times. The row has neither errors nor drift.
pub(super) fn drive(make: &Maker<'_>, task: &Task<'_>, hooks: &Hooks<'_>) -> ComparisonRow {
    let mut row = task.row();
    match advance(make, task, hooks, &mut row) {
        Err(why) => row.failure = Some(why.to_string()),
        Ok(false) if row.failure.is_none() => row.failure = Some(INTERRUPTED.to_owned()),
        Ok(_) => {}
    }
    row
}

/// Runs a task; whether it came to its end.
fn advance(
    make: &Maker<'_>,
    task: &Task<'_>,
    hooks: &Hooks<'_>,
    row: &mut ComparisonRow,
) -> Result<bool, Box<dyn Error>> {
    let grid = task.grid;
    let mut job = make(task.candidate.formulation())?;
    if task.late_charts {
        job.context.keep_charts_until(LATE_CHARTS);
    }
    let plan = dynamic(&job.plan).ok_or(CompareError::Static)?;
    match &task.candidate {
        Candidate::General(general) => {
            in_general(&mut job, &task.solver(general), grid, hooks, row)
        }
        Candidate::Method(method) => {
            let options = DynamicOptions {
                interval: Some(grid.to / grid.times as f64),
                ..task.options(method, plan)
            };
            by_scheme(&mut job, &options, hooks, row)
        }
    }
}

/// A run with a scheme, sampled where its intervals end.
fn by_scheme(
    job: &mut Job,
    options: &DynamicOptions,
    hooks: &Hooks<'_>,
    row: &mut ComparisonRow,
) -> Result<bool, Box<dyn Error>> {
    let model = &mut job.context;
    let mut progress = job.start.motion(model)?;
    let accelerations = assemblies(model, options, &mut progress)?;
    // The search of a new run, and that of one which goes on.
    let mut anew = Progress {
        invariants: None,
        ..progress.clone()
    };
    anew.summary.stable_step = None;
    row.searching = assemblies(model, options, &mut anew)?;
    let again = assemblies(model, options, &mut progress)?;
    let before = model.assemblies();
    let mut seen = |model: &mut Context, progress: &Progress| {
        let defect = progress.summary.energy.map(|e| e.defect());
        row.sample(model, progress.state.point(), defect)
    };
    let begun = seen(model, &progress);
    let clock = Instant::now();
    let mut observer = |model: &mut Context, step: &StepReport<'_>| {
        let t = step.progress.state.t;
        let is_common = options.intervals(t) > options.intervals(t - step.step_size);
        if is_common || t >= options.to {
            seen(model, step.progress)?;
        }
        (hooks.flow)()
    };
    let integrated = match begun {
        ControlFlow::Continue(()) => integrate(model, &mut progress, options, &mut observer),
        ControlFlow::Break(()) => Ok(()),
    };
    row.seconds = clock.elapsed().as_secs_f64();
    row.counts = Counts::of_motion(&progress.summary);
    row.assemblies = match options.scheme.stages() {
        [_] => (accelerations + model.assemblies() - before).saturating_sub(row.searching + again),
        // Several tangents of a state count once; rates are not spins here.
        _ => progress.summary.evaluations,
    };
    integrated?;
    Ok(progress.summary.finished)
}

/// The number of assemblies before the first step. They include a search for invariants, which a run that goes on makes
/// again, or the largest frequency.
fn assemblies(
    model: &mut Context,
    options: &DynamicOptions,
    progress: &mut Progress,
) -> Result<usize, DynamicsError> {
    let before = model.assemblies();
    begin(model, options, progress)?;
    Ok(model.assemblies() - before)
}

/// A run with a general solver, sampled at the common times.
#[cfg(feature = "diffsol")]
fn in_general(
    job: &mut Job,
    general: &General,
    grid: &Grid,
    hooks: &Hooks<'_>,
    row: &mut ComparisonRow,
) -> Result<bool, Box<dyn Error>> {
    use crate::studies::general;
    let model = &mut job.context;
    let mut progress = job.start.motion(model)?;
    let clock = Instant::now();
    let before = model.assemblies();
    let mut observer = general::Observer {
        seen: &mut |model, at| row.sample(model, at, None),
        go: hooks.flow,
    };
    let times = grid.all_times();
    let ended = general::integrate(model, &mut progress, general, &times, &mut observer);
    row.counts = Counts::of_motion(&progress.summary);
    row.assemblies = model.assemblies() - before;
    row.seconds = clock.elapsed().as_secs_f64();
    ended?;
    Ok(progress.summary.finished)
}

/// General solvers are refused by programs built without them.
#[cfg(not(feature = "diffsol"))]
fn in_general(
    _: &mut Job,
    general: &General,
    _: &Grid,
    _: &Hooks<'_>,
    _: &mut ComparisonRow,
) -> Result<bool, Box<dyn Error>> {
    let why = format!("{general}: this program is built without the feature `diffsol`");
    Err(why.into())
}

/// Most repetitions of a timed run, and the total time in seconds after which there are no more.
const REPETITIONS: usize = 5;
const ENOUGH: f64 = 0.5;

/// Wall time of the integration alone in seconds, the minimum of some repetitions; `None` if it fails or is stopped.
pub(super) fn clock(make: &Maker<'_>, task: &Task<'_>, hooks: &Hooks<'_>) -> Option<f64> {
    let (mut least, mut spent) = (f64::INFINITY, 0.0);
    for _ in 0..REPETITIONS {
        let mut job = make(task.candidate.formulation()).ok()?;
        let time = match &task.candidate {
            Candidate::Method(method) => {
                let options = DynamicOptions {
                    energies: false,
                    ..task.options(method, dynamic(&job.plan)?)
                };
                let model = &mut job.context;
                let mut progress = job.start.motion(model).ok()?;
                let begin = Instant::now();
                integrate(model, &mut progress, &options, &mut |_, _| (hooks.flow)()).ok()?;
                let time = begin.elapsed().as_secs_f64();
                progress.summary.finished.then_some(time)?
            }
            Candidate::General(general) => {
                let mut row = task.row();
                let solver = task.solver(general);
                let finished = in_general(&mut job, &solver, task.grid, hooks, &mut row).ok()?;
                finished.then_some(row.seconds)?
            }
        };
        if (hooks.flow)().is_break() {
            return None;
        }
        (least, spent) = (time.min(least), spent + time);
        if spent > ENOUGH {
            break;
        }
    }
    Some(least)
}

/// Calls `work` with each of the numbers 0 to n − 1, begun in an `order`, on several threads; the results by number.
pub(in crate::studies) fn side_by_side<T: Send>(
    order: &[usize],
    threads: usize,
    work: &(dyn Fn(usize) -> T + Sync),
) -> Vec<T> {
    let begun = AtomicUsize::new(0);
    let next = || order.get(begun.fetch_add(1, Ordering::Relaxed)).copied();
    let worker = || std::iter::from_fn(|| next().map(|k| (k, work(k)))).collect::<Vec<_>>();
    let mut done = std::thread::scope(|scope| {
        let threads = threads.clamp(1, order.len().max(1));
        let threads: Vec<_> = (0..threads).map(|_| scope.spawn(worker)).collect();
        let done = threads.into_iter().map(|thread| thread.join());
        done.flat_map(|done| done.unwrap_or_else(|panic| resume_unwind(panic)))
            .collect::<Vec<_>>()
    });
    done.sort_by_key(|(k, _)| *k);
    done.into_iter().map(|(_, out)| out).collect()
}
