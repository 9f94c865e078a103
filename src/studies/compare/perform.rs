//! All runs of a comparison and their results.

use super::grid::Grid;
use super::order::orders;
use super::run::{self, Hooks, INTERRUPTED, Maker, Task, dynamic, side_by_side};
use super::{
    Candidate, CompareError, Comparison, ComparisonOptions, ComparisonRow, Drift, EqualCost,
    Reference, drift, reference, sample,
};
use crate::input::Job;
use crate::method::Method;
use crate::output::PROGRAM;
use crate::solve::begin;
use pullback_elements::model::Formulation;
use pullback_integrators::dynamics::{DynamicOptions, Scheme};
use pullback_manifold::system::System;
use std::num::NonZeroUsize;
use std::sync::{Mutex, PoisonError};

/// The validated input of a comparison.
pub(super) struct Prepared {
    grid: Grid,
    /// Grid of the long runs, if requested.
    long: Option<Grid>,
    reference: Method,
    /// The model in total rotation vectors.
    job: Job,
    /// Schemes that cannot start, and why.
    refused: Vec<(String, String)>,
}

/// The sampled nodes and times of a comparison: the names of all frame nodes, and the common times of
/// runs with these step sizes, the start first.
///
/// # Errors
/// [`CompareError`].
pub fn sampling(make: &Maker<'_>, steps: &[f64]) -> Result<(Vec<String>, Vec<f64>), CompareError> {
    let (job, grid) = begun(make, steps)?;
    let nodes = job.context.frames().map(|(_, name)| name.to_owned());
    Ok((nodes.collect(), grid.all_times()))
}

/// The model in total rotation vectors, and the grid of the compared runs.
fn begun(make: &Maker<'_>, steps: &[f64]) -> Result<(Job, Grid), CompareError> {
    let job = make(Formulation::Total)?;
    let plan = dynamic(&job.plan).ok_or(CompareError::Static)?;
    let grid = Grid::new(plan.options.to, steps)?;
    Ok((job, grid))
}

pub(super) fn prepare(
    make: &Maker<'_>,
    options: &ComparisonOptions,
) -> Result<Prepared, CompareError> {
    let (job, grid) = begun(make, &options.steps)?;
    if let Some(value) = options.residual.filter(|r| !(*r > 0.0 && r.is_finite())) {
        return Err(CompareError::Residual { value });
    }
    if let Some(value) = options.residual.filter(|r| *r < f64::EPSILON) {
        return Err(CompareError::Rounding { value });
    }
    if let Some(value) = options.long.filter(|f| !(*f >= 1.0 && f.is_finite())) {
        return Err(CompareError::Longer { value });
    }
    let long = options.long.map(|factor| grid.longer(factor)).transpose()?;
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
    job.start.motion(&job.context)?;
    // With the reference's scheme: that of the file may not suit this model.
    begins(make, &reference.into())?;
    Ok(Prepared {
        grid,
        long,
        reference,
        job,
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
    let mut progress = job.start.motion(&job.context)?;
    begin(&mut job.context, &options, &mut progress)?;
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
    options: &ComparisonOptions,
    hooks: &Hooks<'_>,
) -> Result<Comparison, CompareError> {
    let prepared = prepare(make, options)?;
    Ok(run(make, model, options, hooks, prepared))
}

pub(super) fn run(
    make: &Maker<'_>,
    model: &str,
    options: &ComparisonOptions,
    hooks: &Hooks<'_>,
    prepared: Prepared,
) -> Comparison {
    let (grid, context) = (&prepared.grid, &prepared.job.context);
    let multipliers = context.has_multipliers();
    for (name, why) in &prepared.refused {
        (hooks.refused)(name, why);
    }
    let tasks = prepared.tasks(options);
    let all: Vec<&Task<'_>> = tasks.iter().flatten().collect();
    let cores = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let threads = options.threads.map_or(cores, NonZeroUsize::get);
    let threads = threads.min(all.len() - tasks[3].len());
    let mut ran = run_all(make, &all, threads, hooks).into_iter();
    let rows: [Vec<ComparisonRow>; 4] = tasks
        .each_ref()
        .map(|tasks| ran.by_ref().take(tasks.len()).collect());
    let interrupted = |row: &ComparisonRow| row.failure.as_deref() == Some(INTERRUPTED);
    let complete = !rows.iter().flatten().any(interrupted);
    let zero_momenta = drift::zeros(rows.iter().flatten().map(|row| &row.samples[..]));
    let [reference_rows, mut rows, mut charts, mut lasting] = rows;
    let failure = reference_rows.iter().find_map(|row| row.failure.as_ref());
    let reference_failure = failure.map(|why| format!("{}: {why}", prepared.reference));
    let reference = prepared.judge(options, &reference_rows);
    let conserved = reference.as_ref().map(|r| r.conserved).unwrap_or_default();
    let conserved = conserved.without(zero_momenta);
    for row in rows.iter_mut().chain(&mut charts).chain(&mut lasting) {
        row.drift = Drift::of(&row.samples, conserved, row.counts.energy);
    }
    for row in rows.iter_mut().chain(&mut charts) {
        let known = reference.as_ref().filter(|_| row.failure.is_none());
        row.error = known.map(|r| sample::distances(&row.samples, &r.samples));
    }
    let names: Vec<String> = options.schemes.iter().map(Candidate::to_string).collect();
    let mut comparison = Comparison {
        program: PROGRAM,
        model: model.to_owned(),
        title: prepared.job.file.title.clone(),
        command: None,
        complete,
        to: grid.to,
        times: grid.times,
        unknowns: context.pattern().dim(),
        enforced: context.is_enforced(),
        multipliers,
        threads,
        orders: orders(&options.schemes, multipliers, &rows, reference.as_ref()),
        reference_failure,
        equal_cost: EqualCost::find(&names, &rows, reference.as_ref(), false),
        equal_time: None,
        reference,
        zero_momenta,
        rows,
        long: lasting,
        charts,
    };
    if options.timed {
        time(&mut comparison, make, &tasks[1], hooks);
    }
    let (rows, reference) = (&comparison.rows, comparison.reference.as_ref());
    comparison.equal_time = EqualCost::find(&names, rows, reference, true);
    comparison
}

/// Runs each of the compared tasks alone on the machine.
fn time(comparison: &mut Comparison, make: &Maker<'_>, tasks: &[Task<'_>], hooks: &Hooks<'_>) {
    for (row, task) in comparison.rows.iter_mut().zip(tasks) {
        if comparison.complete && row.failure.is_none() {
            row.seconds_alone = run::clock(make, task, hooks);
            comparison.complete = (hooks.flow)().is_continue();
        }
    }
}

impl Prepared {
    /// The exact solution as a reference, or that of its runs if all are complete.
    fn judge(&self, options: &ComparisonOptions, runs: &[ComparisonRow]) -> Option<Reference> {
        let (grid, context) = (&self.grid, &self.job.context);
        match &options.exact {
            Some(exact) => Some(exact.reference(&grid.all_times(), context.frames().count())),
            None if runs.iter().any(|row| row.failure.is_some()) => None,
            None => reference::judge(&self.reference, context.has_multipliers(), runs),
        }
    }

    /// The runs of the reference, those compared, those with late changes of chart, and the long ones.
    fn tasks(&self, options: &ComparisonOptions) -> [Vec<Task<'_>>; 4] {
        let reference = match options.exact {
            Some(_) => Vec::new(),
            None => reference::tasks(&self.reference, &self.grid).to_vec(),
        };
        let charts = options
            .charts
            .then(|| scheme_tasks(options, &self.grid, true));
        let long = (self.long.as_ref()).map(|long| scheme_tasks(options, long, false));
        [
            reference,
            scheme_tasks(options, &self.grid, false),
            charts.unwrap_or_default(),
            long.unwrap_or_default(),
        ]
    }
}

/// Every scheme at every step size of a grid.
fn scheme_tasks<'a>(
    options: &ComparisonOptions,
    grid: &'a Grid,
    late_charts: bool,
) -> Vec<Task<'a>> {
    let mut tasks = Vec::new();
    for &candidate in &options.schemes {
        for (&steps, &requested) in grid.counts.iter().zip(&options.steps) {
            tasks.push(Task {
                name: candidate.to_string(),
                candidate,
                grid,
                requested,
                steps,
                relative: options.residual.unwrap_or(f64::INFINITY),
                late_charts,
            });
        }
    }
    tasks
}

/// Runs all tasks, those with the most steps first.
fn run_all(
    make: &Maker<'_>,
    tasks: &[&Task<'_>],
    threads: usize,
    hooks: &Hooks<'_>,
) -> Vec<ComparisonRow> {
    let mut order: Vec<usize> = (0..tasks.len()).collect();
    order.sort_by_key(|&k| std::cmp::Reverse(tasks[k].steps));
    let ended = Mutex::new(0);
    side_by_side(&order, threads, &|k| {
        let row = run::drive(make, tasks[k], hooks);
        let mut ended = ended.lock().unwrap_or_else(PoisonError::into_inner);
        *ended += 1;
        (hooks.ended)(*ended, tasks.len(), &tasks[k].name);
        row
    })
}
