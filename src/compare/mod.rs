//! Integrators side by side on one model: errors, orders, cost, drift.
//!
//! Every scheme runs at every step size on a model of its own. Errors are root mean squares over
//! common times and all frame nodes, against a [`Reference`] whose own error is estimated; orders
//! are slopes of log error over log step in the asymptotic range, with a confidence interval
//! ([`fit`]). Runs go side by side on threads; nothing but times depends on how many.
//!
//! ```
//! use pullback::compare::{Options, Quantity, Watch, compare};
//! use pullback::input;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let text = r#"
//! [nodes]
//! O = [0, 0, 0]
//! [[bodies]]
//! name = "body"
//! node = "O"
//! mass = 1
//! inertia = [1, 2, 3]
//! [[initial]]
//! node = "O"
//! angular_velocity = [0.1, 2, 0.1]
//! [analysis.dynamic]
//! to = 1
//! step = 0.01
//! "#;
//! let file = input::parse("body.toml", text)?;
//! let schemes = vec!["newmark".parse()?, "lie-ga:0.8".parse()?];
//! let options = Options::new(schemes, vec![0.04, 0.02, 0.01]);
//! let make = |formulation| input::job_in("body.toml", &file, formulation);
//! let comparison = compare(&make, "body.toml", &options, &Watch::NOBODY)?;
//! for scheme in &comparison.orders {
//!     let order = scheme.of(Quantity::Rotation).ok_or("no order")?;
//!     assert!((order.order - 2.0).abs() < 0.1);
//! }
//! # Ok(())
//! # }
//! ```

mod contender;
mod error;
mod exact;
mod figures;
mod grid;
mod order;
mod page;
mod reference;
mod run;
mod sample;
mod tables;
mod write;

pub use contender::Contender;
pub use error::CompareError;
pub use exact::{Exact, read as read_exact};
use order::orders;
pub use order::{ABOVE_REFERENCE, Order, STRAIGHT, fit};
pub use reference::Reference;
pub use run::{Maker, Watch};
pub use sample::{Pose, Quantity, Sample, Values};
pub use tables::summary;
pub use write::{FILES, default_directory, run};

use crate::solve::{Counts, begin};
use grid::Grid;
use pullback_elements::model::Formulation;
use pullback_integrators::dynamics::{Progress, Scheme, start};
use run::{Failure, Ran, Task, dynamic, side_by_side};
use serde::Serialize;
use std::num::NonZeroUsize;
use std::sync::Mutex;
use std::sync::PoisonError;

/// What is compared.
#[derive(Clone, Debug)]
pub struct Options {
    /// The schemes, each with its formulation of rotations, and general solvers.
    pub schemes: Vec<Contender>,
    /// Step sizes, from large to small.
    pub steps: Vec<f64>,
    /// Scheme of the reference; by default Radau IIA of two stages, of order 3, which damps what no
    /// step resolves.
    pub reference: Option<Scheme>,
    /// An exact solution in place of the reference.
    pub exact: Option<Exact>,
    /// Runs at a time; as many as the machine has cores by default.
    pub threads: Option<NonZeroUsize>,
    /// Whether each run is made again alone on the machine, to take its time.
    pub timed: bool,
}

impl Options {
    /// Schemes at step sizes, everything else by default.
    pub fn new(schemes: Vec<Contender>, steps: Vec<f64>) -> Self {
        Self {
            schemes,
            steps,
            reference: None,
            exact: None,
            threads: None,
            timed: false,
        }
    }
}

/// Energies and momenta that the motion keeps, as the reference shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Kept {
    /// The energy: kinetic, stored, and the potential of loads.
    pub energy: bool,
    /// Components of the linear momentum.
    pub momentum: [bool; 3],
    /// Components of the angular momentum about the origin.
    pub angular_momentum: [bool; 3],
}

/// The largest changes since the start, at the common times, of what the motion keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Drift {
    /// Of the energy, where it is kept.
    pub energy: Option<f64>,
    /// Of those components of the linear momentum that are kept.
    pub momentum: Option<f64>,
    /// Of those components of the angular momentum that are kept.
    pub angular_momentum: Option<f64>,
    /// The largest |h| of the equations with which loops close, each over its size.
    pub violation: Option<f64>,
}

/// One scheme at one step size.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The scheme.
    pub scheme: String,
    /// Step size asked for.
    pub asked: f64,
    /// Step size of the equal steps made.
    pub step: f64,
    /// Why it did not come to its end, if it did not.
    pub failure: Option<String>,
    /// What it did.
    pub counts: Counts,
    /// Root mean square errors against the reference.
    pub error: Option<Values>,
    /// Drift of what the motion keeps.
    pub drift: Drift,
    /// Wall-clock time in seconds, with the audits at common times, beside other runs.
    pub seconds: f64,
    /// Wall-clock time in seconds of the integration alone on the machine.
    pub seconds_alone: Option<f64>,
    /// The states at the common times that it reached, the start first.
    #[serde(skip)]
    pub samples: Vec<Sample>,
}

impl Row {
    /// Whether the run came to its end in equal steps, so that its error belongs to its step size.
    pub fn is_regular(&self) -> bool {
        self.failure.is_none() && self.counts.rejected == 0
    }

    /// Linear solutions per step.
    pub fn iterations_per_step(&self) -> f64 {
        self.counts.iterations as f64 / self.counts.steps as f64
    }
}

/// The observed orders of a scheme.
#[derive(Clone, Debug, Serialize)]
pub struct SchemeOrders {
    /// The scheme.
    pub scheme: String,
    /// What its formulation of rotations is.
    pub formulation: &'static str,
    /// Its order in theory; none for a general solver, of which h is a tolerance.
    pub theory: Option<usize>,
    /// The order observed in each quantity, where one can be, in the order of [`Quantity::ALL`].
    pub observed: [Option<Order>; 6],
}

impl SchemeOrders {
    /// The order observed in a quantity.
    pub fn of(&self, quantity: Quantity) -> Option<Order> {
        self.observed[quantity as usize]
    }
}

/// What a comparison gave.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// Program and version.
    pub program: &'static str,
    /// The model file.
    pub model: String,
    /// Its title.
    pub title: Option<String>,
    /// The command that made it, if one has.
    pub command: Option<String>,
    /// Whether nobody stopped it.
    pub complete: bool,
    /// Duration of the motion.
    pub to: f64,
    /// Number of common times, equally spaced, the start not counted.
    pub times: usize,
    /// Number of unknowns.
    pub unknowns: usize,
    /// Whether a loop is closed by multipliers or a penalty.
    pub enforced: bool,
    /// Runs at a time.
    pub threads: usize,
    /// The reference.
    pub reference: Option<Reference>,
    /// Why there is none, if there is none.
    pub reference_failure: Option<String>,
    /// Observed orders of the schemes.
    pub orders: Vec<SchemeOrders>,
    /// All runs, scheme by scheme, from large to small steps.
    pub rows: Vec<Row>,
}

impl Comparison {
    /// The rows of a scheme.
    pub fn of<'a>(&'a self, scheme: &'a str) -> impl Iterator<Item = &'a Row> + 'a {
        self.rows.iter().filter(move |row| row.scheme == scheme)
    }
}

/// What has been checked before anything runs.
struct Prepared {
    grid: Grid,
    reference: Scheme,
    unknowns: usize,
    nodes: usize,
    enforced: bool,
    title: Option<String>,
}

/// What a comparison looks at: the names of all frame nodes, and the common times of runs with these
/// step sizes, the start first.
///
/// # Errors
/// [`CompareError`].
pub fn looked_at(
    make: &Maker<'_>,
    steps: &[f64],
) -> Result<(Vec<String>, Vec<f64>), CompareError> {
    let job = make(Formulation::Total)?;
    let plan = dynamic(&job.plan).ok_or(CompareError::Static)?;
    let grid = Grid::new(plan.options.to, steps)?;
    let nodes = job.model.frames().map(|(_, name)| name.to_owned());
    Ok((nodes.collect(), grid.all_times()))
}

fn prepare(make: &Maker<'_>, options: &Options) -> Result<Prepared, CompareError> {
    let mut job = make(Formulation::Total)?;
    let plan = dynamic(&job.plan).ok_or(CompareError::Static)?;
    let grid = Grid::new(plan.options.to, &options.steps)?;
    if options.schemes.is_empty() {
        return Err(CompareError::NoScheme);
    }
    for (k, scheme) in options.schemes.iter().enumerate() {
        let name = scheme.to_string();
        if options.schemes[..k].iter().any(|s| s.to_string() == name) {
            return Err(CompareError::SchemeTwice { name });
        }
    }
    for method in &options.schemes {
        // A formulation that the model does not take is refused before anything runs.
        make(method.formulation())?;
    }
    let usable = |scheme: &Scheme| scheme.order() >= 2 && scheme.claims().limit.is_none();
    let reference = options.reference.unwrap_or_else(Scheme::radau);
    if !usable(&reference) {
        let name = reference.to_string();
        return Err(CompareError::Reference { name });
    }
    let start = start(&job.model, 0.0, &job.start.q, &job.start.v)?;
    let (unknowns, enforced) = (start.q.len(), job.model.is_enforced());
    begin(&mut job.model, &plan.options, &mut Progress::new(start))?;
    Ok(Prepared {
        grid,
        reference,
        unknowns,
        nodes: job.model.frames().count(),
        enforced,
        title: job.title,
    })
}

/// Compares schemes on the model that `make` makes; `model` is what results call it.
///
/// # Errors
/// [`CompareError`] for what no run can begin with. A run that fails is a row with the reason, and
/// so is the reference.
pub fn compare(
    make: &Maker<'_>,
    model: &str,
    options: &Options,
    watch: &Watch<'_>,
) -> Result<Comparison, CompareError> {
    let prepared = prepare(make, options)?;
    Ok(carry_out(make, model, options, watch, prepared))
}

fn carry_out(
    make: &Maker<'_>,
    model: &str,
    options: &Options,
    watch: &Watch<'_>,
    prepared: Prepared,
) -> Comparison {
    let Prepared {
        grid,
        reference,
        unknowns,
        nodes,
        enforced,
        title,
    } = prepared;
    let mut tasks = match options.exact {
        Some(_) => Vec::new(),
        None => reference::tasks(&reference, &grid).to_vec(),
    };
    let behind = tasks.len();
    let own = options.schemes.iter().flat_map(|&method| {
        grid.counts.iter().map(move |&steps| Task {
            name: method.to_string(),
            contender: method,
            steps,
            relative: f64::INFINITY,
        })
    });
    tasks.extend(own);
    let cores = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let threads = options.threads.map_or(cores, NonZeroUsize::get);
    let threads = threads.min(tasks.len());
    let mut ran = run_all(make, &tasks, &grid, threads, watch);
    let own = ran.split_off(behind);
    let judged = match &options.exact {
        Some(exact) => Some(exact.reference(&grid.all_times(), nodes)),
        None if ran.iter().any(|r| r.failure.is_some()) => None,
        None => reference::judge(&reference, &grid, &ran),
    };
    let failure = ran.iter().find_map(|r| r.failure.as_ref());
    let interrupted = |r: &Ran| matches!(r.failure, Some(Failure::Interrupted));
    let mut complete = !ran.iter().chain(&own).any(interrupted);
    let mut rows = Vec::with_capacity(own.len());
    for (k, (ran, task)) in own.into_iter().zip(&tasks[behind..]).enumerate() {
        let asked = options.steps[k % options.steps.len()];
        let mut row = row(ran, task, asked, &grid, judged.as_ref());
        if options.timed && complete && row.failure.is_none() {
            let time = run::clock(make, task, &grid, watch);
            row.seconds_alone = time.map(|t| t.as_secs_f64());
            complete = (watch.flow)().is_continue();
        }
        rows.push(row);
    }
    Comparison {
        program: concat!("pullback ", env!("CARGO_PKG_VERSION")),
        model: model.to_owned(),
        title,
        command: None,
        complete,
        to: grid.to,
        times: grid.times,
        unknowns,
        enforced,
        threads,
        orders: orders(&options.schemes, &rows, judged.as_ref()),
        reference_failure: failure.map(|f| format!("{reference}: {f}")),
        reference: judged,
        rows,
    }
}

/// Runs all tasks, those with most steps first.
fn run_all(
    make: &Maker<'_>,
    tasks: &[Task],
    grid: &Grid,
    threads: usize,
    watch: &Watch<'_>,
) -> Vec<Ran> {
    let mut turn: Vec<usize> = (0..tasks.len()).collect();
    turn.sort_by_key(|&k| std::cmp::Reverse(tasks[k].steps));
    let ended = Mutex::new(0);
    let ran = side_by_side(tasks.len(), threads, &|k| {
        let task = &tasks[turn[k]];
        let ran = run::drive(make, task, grid, watch);
        let mut ended = ended.lock().unwrap_or_else(PoisonError::into_inner);
        *ended += 1;
        (watch.ended)(*ended, tasks.len(), &task.name);
        ran
    });
    let mut ran: Vec<(usize, Ran)> = turn.into_iter().zip(ran).collect();
    ran.sort_by_key(|(k, _)| *k);
    ran.into_iter().map(|(_, ran)| ran).collect()
}

fn row(ran: Ran, task: &Task, asked: f64, grid: &Grid, reference: Option<&Reference>) -> Row {
    let reference = reference.filter(|_| ran.failure.is_none());
    let drift = reference.map(|r| Drift {
        energy: (r.kept.energy).then(|| reference::drift(&ran.samples, &|s| s.energy)),
        momentum: reference::drift_of(&ran.samples, r.kept.momentum, &|s| s.momenta[0]),
        angular_momentum: reference::drift_of(&ran.samples, r.kept.angular_momentum, &|s| {
            s.momenta[1]
        }),
        violation: None,
    });
    let violations = ran.samples.iter().filter_map(|s| s.violation);
    let violation = violations.reduce(|a, b| if b > a || b.is_nan() { b } else { a });
    Row {
        scheme: task.name.clone(),
        asked,
        step: grid.step(task.steps),
        failure: ran.failure.as_ref().map(ToString::to_string),
        counts: Counts::of_motion(&ran.summary),
        error: reference.map(|r| sample::distances(&ran.samples, &r.samples)),
        drift: Drift {
            violation,
            ..drift.unwrap_or_default()
        },
        seconds: ran.time.as_secs_f64(),
        seconds_alone: None,
        samples: ran.samples,
    }
}
