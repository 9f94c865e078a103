//! All runs of a comparison and their results.

use super::grid::Grid;
use super::order::orders;
use super::run::{self, Hooks, Maker, RunFailure, RunResult, Task, dynamic, side_by_side};
use super::{
    Candidate, CompareError, Comparison, ComparisonRow, Conserved, Drift, EqualCost, Options,
    Reference,
};
use super::{drift, reference, sample};
use crate::method::Method;
use crate::solve::{Counts, begin};
use pullback_elements::model::Formulation;
use pullback_integrators::dynamics::{DynamicOptions, Progress, Scheme, start};
use std::num::NonZeroUsize;
use std::sync::{Mutex, PoisonError};

/// The validated input of a comparison.
pub(super) struct Prepared {
    grid: Grid,
    /// Grid of the long runs, if requested.
    long: Option<Grid>,
    reference: Method,
    unknowns: usize,
    nodes: usize,
    enforced: bool,
    multipliers: bool,
    title: Option<String>,
    /// Schemes that cannot start, and why.
    refused: Vec<(String, String)>,
}

/// The sampled nodes and times of a comparison: the names of all frame nodes, and the common times of
/// runs with these step sizes, the start first.
///
/// # Errors
/// [`CompareError`].
pub fn looked_at(make: &Maker<'_>, steps: &[f64]) -> Result<(Vec<String>, Vec<f64>), CompareError> {
    let job = make(Formulation::Total)?;
    let plan = dynamic(&job.plan).ok_or(CompareError::Static)?;
    let grid = Grid::new(plan.options.to, steps)?;
    let nodes = job.context.frames().map(|(_, name)| name.to_owned());
    Ok((nodes.collect(), grid.all_times()))
}

pub(super) fn prepare(make: &Maker<'_>, options: &Options) -> Result<Prepared, CompareError> {
    let job = make(Formulation::Total)?;
    let plan = dynamic(&job.plan).ok_or(CompareError::Static)?;
    let grid = Grid::new(plan.options.to, &options.steps)?;
    if let Some(value) = options.residual.filter(|r| !(*r > 0.0 && r.is_finite())) {
        return Err(CompareError::Residual { value });
    }
    if let Some(value) = options.residual.filter(|r| *r < f64::EPSILON) {
        return Err(CompareError::Rounding { value });
    }
    if let Some(value) = options.long.filter(|f| !(*f >= 1.0 && f.is_finite())) {
        return Err(CompareError::Longer { value });
    }
    let long = options.long.map(|factor| grid.longer(factor));
    let long = long.transpose()?;
    if options.schemes.is_empty() {
        return Err(CompareError::NoScheme);
    }
    for (k, scheme) in options.schemes.iter().enumerate() {
        let name = scheme.to_string();
        if options.schemes[..k].iter().any(|s| s.to_string() == name) {
            return Err(CompareError::SchemeTwice { name });
        }
    }
    let begun = options.schemes.iter().filter_map(|scheme| {
        let why = begins(make, scheme).err()?;
        Some((scheme.to_string(), why.to_string()))
    });
    let mut refused: Vec<(String, String)> = begun.collect();
    if refused.len() == options.schemes.len() {
        let (name, why) = refused.swap_remove(0);
        return Err(CompareError::NoneBegins { name, why });
    }
    let reference = options.reference.unwrap_or_else(|| Scheme::radau().into());
    if reference.order() < 2 || reference.scheme().properties().limit.is_some() {
        let name = reference.to_string();
        return Err(CompareError::Reference { name });
    }
    let start = start(&job.context, 0.0, &job.start.q, &job.start.v)?;
    // With the reference's scheme: that of the file may not suit this model.
    begins(make, &reference.into())?;
    Ok(Prepared {
        grid,
        long,
        reference,
        unknowns: start.q.len(),
        nodes: job.context.frames().count(),
        enforced: job.context.is_enforced(),
        multipliers: job.context.has_multipliers(),
        title: job.title,
        refused,
    })
}

/// Builds the model in the formulation of a scheme, which not every model supports, and starts its motion.
fn begins(make: &Maker<'_>, candidate: &Candidate) -> Result<(), CompareError> {
    let mut job = make(candidate.formulation())?;
    let (Candidate::Method(method), Some(plan)) = (candidate, dynamic(&job.plan)) else {
        return Ok(());
    };
    let options = DynamicOptions {
        scheme: method.scheme(),
        adaptivity: None,
        interval: None,
        ..plan.options
    };
    let start = start(&job.context, 0.0, &job.start.q, &job.start.v)?;
    begin(&mut job.context, &options, &mut Progress::new(start))?;
    Ok(())
}

/// Compares schemes on the model that `make` builds; `model` is its name in the results.
///
/// # Errors
/// [`CompareError`] for input with which no run can start. A failed run, also of the reference, is a row
/// with the reason.
pub fn compare(
    make: &Maker<'_>,
    model: &str,
    options: &Options,
    hooks: &Hooks<'_>,
) -> Result<Comparison, CompareError> {
    let prepared = prepare(make, options)?;
    Ok(run(make, model, options, hooks, prepared))
}

pub(super) fn run(
    make: &Maker<'_>,
    model: &str,
    options: &Options,
    hooks: &Hooks<'_>,
    prepared: Prepared,
) -> Comparison {
    let Prepared {
        grid,
        long,
        reference,
        multipliers,
        ..
    } = &prepared;
    for (name, why) in &prepared.refused {
        (hooks.refused)(name, why);
    }
    let relative = options.residual.unwrap_or(f64::INFINITY);
    let reference_tasks = match options.exact {
        Some(_) => Vec::new(),
        None => reference::tasks(reference, grid).to_vec(),
    };
    let tasks = |counts: &[usize], late_charts: bool| -> Vec<Task> {
        let schemes = options.schemes.iter();
        let task = schemes.flat_map(|&candidate| {
            counts.iter().map(move |&steps| Task {
                name: candidate.to_string(),
                candidate,
                steps,
                relative,
                late_charts,
            })
        });
        task.collect()
    };
    let own_tasks = tasks(&grid.counts, false);
    let late_tasks = match options.charts {
        true => tasks(&grid.counts, true),
        false => Vec::new(),
    };
    let long_tasks = long
        .as_ref()
        .map_or_else(Vec::new, |g| tasks(&g.counts, false));
    let long = long.as_ref().unwrap_or(grid);
    let parts: [(&[Task], &Grid); 4] = [
        (&reference_tasks, grid),
        (&own_tasks, grid),
        (&late_tasks, grid),
        (&long_tasks, long),
    ];
    let all = parts
        .iter()
        .flat_map(|(tasks, grid)| tasks.iter().map(move |task| (task, *grid)));
    let all: Vec<(&Task, &Grid)> = all.collect();
    let cores = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let threads = options.threads.map_or(cores, NonZeroUsize::get);
    let threads = threads.min(all.len() - long_tasks.len());
    let mut results = run_all(make, &all, threads, hooks).into_iter();
    let [ran, own, late, lasting] =
        parts.map(|(tasks, _)| results.by_ref().take(tasks.len()).collect::<Vec<_>>());
    let judged = match &options.exact {
        Some(exact) => Some(exact.reference(&grid.all_times(), prepared.nodes)),
        None if ran.iter().any(|r| r.failure.is_some()) => None,
        None => reference::judge(reference, *multipliers, grid, &ran),
    };
    let failure = ran.iter().find_map(|r| r.failure.as_ref());
    let every = || own.iter().chain(&late).chain(&lasting).chain(&ran);
    let interrupted = |r: &RunResult| matches!(r.failure, Some(RunFailure::Interrupted));
    let mut complete = !every().any(interrupted);
    let zero_momenta = drift::zeros(every().map(|ran| &ran.samples[..]));
    let conserved = judged.as_ref().map(|r| r.conserved).unwrap_or_default();
    let conserved = conserved.without(zero_momenta);
    let rows = |ran: Vec<RunResult>, tasks: &[Task]| -> Vec<ComparisonRow> {
        let steps = options.steps.iter().cycle();
        (ran.into_iter().zip(tasks).zip(steps))
            .map(|((ran, task), &step)| row(ran, task, step, grid, judged.as_ref(), conserved))
            .collect()
    };
    let charts = rows(late, &late_tasks);
    let mut rows = rows(own, &own_tasks);
    for (row, task) in rows.iter_mut().zip(&own_tasks) {
        if options.timed && complete && row.failure.is_none() {
            let time = run::clock(make, task, grid, hooks);
            row.seconds_alone = time.map(|t| t.as_secs_f64());
            complete = (hooks.flow)().is_continue();
        }
    }
    let lasting = (lasting.into_iter().zip(&long_tasks))
        .map(|(ran, task)| row(ran, task, options.steps[0], long, None, conserved));
    let lasting = lasting.collect();
    let names: Vec<String> = options.schemes.iter().map(Candidate::to_string).collect();
    Comparison {
        program: concat!("pullback ", env!("CARGO_PKG_VERSION")),
        model: model.to_owned(),
        title: prepared.title.clone(),
        command: None,
        complete,
        to: grid.to,
        times: grid.times,
        unknowns: prepared.unknowns,
        enforced: prepared.enforced,
        multipliers: *multipliers,
        threads,
        orders: orders(&options.schemes, *multipliers, &rows, judged.as_ref()),
        reference_failure: failure.map(|f| format!("{reference}: {f}")),
        equal_cost: EqualCost::find(&names, &rows, judged.as_ref(), false),
        equal_time: EqualCost::find(&names, &rows, judged.as_ref(), true),
        reference: judged,
        zero_momenta,
        rows,
        long: lasting,
        charts,
    }
}

/// Runs all tasks, those with the most steps first.
fn run_all(
    make: &Maker<'_>,
    tasks: &[(&Task, &Grid)],
    threads: usize,
    hooks: &Hooks<'_>,
) -> Vec<RunResult> {
    let mut turn: Vec<usize> = (0..tasks.len()).collect();
    turn.sort_by_key(|&k| std::cmp::Reverse(tasks[k].0.steps));
    let ended = Mutex::new(0);
    let ran = side_by_side(tasks.len(), threads, &|k| {
        let (task, grid) = tasks[turn[k]];
        let ran = run::drive(make, task, grid, hooks);
        let mut ended = ended.lock().unwrap_or_else(PoisonError::into_inner);
        *ended += 1;
        (hooks.ended)(*ended, tasks.len(), &task.name);
        ran
    });
    let mut ran: Vec<(usize, RunResult)> = turn.into_iter().zip(ran).collect();
    ran.sort_by_key(|(k, _)| *k);
    ran.into_iter().map(|(_, ran)| ran).collect()
}

fn row(
    ran: RunResult,
    task: &Task,
    requested: f64,
    grid: &Grid,
    reference: Option<&Reference>,
    conserved: Conserved,
) -> ComparisonRow {
    let reference = reference.filter(|_| ran.failure.is_none());
    let counts = Counts::of_motion(&ran.summary);
    ComparisonRow {
        scheme: task.name.clone(),
        requested_step: requested,
        step: grid.step(task.steps),
        failure: ran.failure.as_ref().map(ToString::to_string),
        drift: Drift::of(&ran.samples, conserved, counts.energy),
        counts,
        assemblies: ran.assemblies,
        searching: ran.searching,
        error: reference.map(|r| sample::distances(&ran.samples, &r.samples)),
        seconds: ran.time.as_secs_f64(),
        seconds_alone: None,
        samples: ran.samples,
    }
}
