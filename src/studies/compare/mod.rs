//! Integrators side by side on one model: errors, orders, cost, drift.
//!
//! Every scheme runs at every step size on a model of its own. Errors are root mean squares over
//! common times and all frame nodes, against a [`Reference`] with an estimate of its own error; orders
//! are slopes of log error over log step in the asymptotic range, with a confidence interval
//! ([`fit`]). Runs are distributed over threads, whose number affects only the times.
//!
//! ```
//! use pullback::studies::compare::{ComparisonOptions, ErrorQuantity, Hooks, compare};
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
//! let options = ComparisonOptions::new(schemes, vec![0.04, 0.02, 0.01]);
//! let make = |formulation| input::job("body.toml", &file, Some(formulation));
//! let comparison = compare(&make, "body.toml", &options, &Hooks::NONE)?;
//! for scheme in &comparison.orders {
//!     let order = scheme.of(ErrorQuantity::Rotation).ok_or("no order")?;
//!     assert!((order.order - 2.0).abs() < 0.1);
//! }
//! # Ok(())
//! # }
//! ```

mod candidate;
mod drift;
mod equal_cost;
mod error;
mod exact;
mod figures;
mod grid;
mod order;
mod over_time;
mod page;
mod perform;
mod reference;
mod run;
mod sample;
mod tables;
mod write;

pub use candidate::Candidate;
pub use drift::{Components, Conserved, Drift};
pub use equal_cost::EqualCost;
pub use error::CompareError;
pub use exact::{Exact, read as read_exact};
pub use figures::{Figure, figures};
pub use order::{ABOVE_REFERENCE, NEAR, Order, STRAIGHT, fit};
pub use perform::{compare, sampling};
pub use reference::Reference;
pub(super) use run::side_by_side;
pub use run::{Hooks, LATE_CHARTS, Maker};
pub use sample::{ErrorQuantity, FrameSample, Sample, Values};
pub use tables::{summary, unknown};
pub use write::{FILES, Subject, run, run_several};

use crate::method::Method;
use crate::solve::Counts;
use serde::Serialize;
use std::num::NonZeroUsize;

/// Options of a comparison.
#[derive(Clone, Debug, Default)]
pub struct ComparisonOptions {
    /// The schemes, each with its formulation of rotations, and general solvers.
    pub schemes: Vec<Candidate>,
    /// Step sizes, from large to small.
    pub steps: Vec<f64>,
    /// Scheme of the reference, in any formulation; by default Radau IIA of two stages, of order 3, which
    /// damps unresolved frequencies, in total rotation vectors.
    pub reference: Option<Method>,
    /// An exact solution instead of the reference.
    pub exact: Option<Exact>,
    /// Runs at a time; one per core by default.
    pub threads: Option<NonZeroUsize>,
    /// Whether each run is repeated alone on the machine to measure its time.
    pub timed: bool,
    /// Every scheme also runs at the largest step for this multiple of the duration, to show
    /// the drift of energies and momenta.
    pub long: Option<f64>,
    /// Whether every scheme also runs at every step size with charts that change at [`LATE_CHARTS`], to show
    /// the cost of changes of chart.
    pub charts: bool,
    /// Tolerance of the residual relative to forces, if it is smaller than that of the model file.
    pub residual: Option<f64>,
}

impl ComparisonOptions {
    /// Options with these schemes and step sizes, and defaults otherwise.
    pub fn new(schemes: Vec<Candidate>, steps: Vec<f64>) -> Self {
        Self {
            schemes,
            steps,
            ..Self::default()
        }
    }
}

/// One scheme at one step size.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ComparisonRow {
    /// The scheme.
    pub scheme: String,
    /// Requested step size.
    pub requested_step: f64,
    /// Step size of the equal steps made.
    pub step: f64,
    /// Reason of its failure, if any.
    pub failure: Option<String>,
    /// Its statistics.
    pub counts: Counts,
    /// Assemblies of the model: one per evaluated state, and three for a tangent in formulations with
    /// spins. Assemblies before the first step are not counted.
    pub assemblies: usize,
    /// Assemblies of the model before the first step, to find invariants of the motion or the largest frequency.
    pub searching: usize,
    /// Root mean square errors against the reference.
    pub error: Option<Values>,
    /// Drift of conserved quantities, and the balance of energy.
    pub drift: Drift,
    /// Wall time in seconds, with energy balances at common times and other runs at the same time.
    pub seconds: f64,
    /// Wall time in seconds of the integration alone on the machine, with the search before its first step.
    pub seconds_alone: Option<f64>,
    /// The states at the common times reached, the start first.
    #[serde(skip)]
    pub samples: Vec<Sample>,
}

impl ComparisonRow {
    /// Whether the run is complete with equal steps, so that its error belongs to its step size.
    pub fn is_regular(&self) -> bool {
        self.failure.is_none() && self.counts.rejected == 0
    }

    /// The error in a quantity that belongs to the step size of the run.
    fn regular_error(&self, quantity: ErrorQuantity) -> Option<f64> {
        Some(self.error.filter(|_| self.is_regular())?.of(quantity))
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
    /// Description of its formulation of rotations.
    pub formulation: &'static str,
    /// Its order in theory; none for a general solver, for which h is a tolerance.
    pub theory: Option<Values<usize>>,
    /// The observed order of each quantity, if any.
    pub observed: Values<Option<Order>>,
}

/// Comparison of an observed slope with the order in theory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slope {
    /// The order in theory: at least three step sizes on a line whose slope is within [`NEAR`] of it.
    Theory,
    /// At least three step sizes on a steeper line: at these steps the leading term of the
    /// error is smaller than the next one.
    Above,
    /// No order is observed.
    Doubtful,
}

impl SchemeOrders {
    /// The observed order of a quantity.
    pub fn of(&self, quantity: ErrorQuantity) -> Option<Order> {
        self.observed.of(quantity)
    }

    /// Comparison of the observed order of a quantity with theory.
    pub fn slope(&self, quantity: ErrorQuantity) -> Option<Slope> {
        let (observed, theory) = (self.of(quantity)?, self.theory?.of(quantity) as f64);
        Some(match observed.order - theory {
            off if observed.points < 3 || off < -NEAR => Slope::Doubtful,
            off if off > NEAR => Slope::Above,
            _ => Slope::Theory,
        })
    }
}

/// Results of a comparison.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// Program and version.
    pub program: &'static str,
    /// The model file.
    pub model: String,
    /// Its title.
    pub title: Option<String>,
    /// The command line, if any.
    pub command: Option<String>,
    /// Whether it was not interrupted.
    pub complete: bool,
    /// Duration of the motion.
    pub to: f64,
    /// Number of common times, equally spaced, the start not counted.
    pub times: usize,
    /// Number of unknowns.
    pub unknowns: usize,
    /// Whether a loop is closed by multipliers or a penalty.
    pub enforced: bool,
    /// Whether multipliers are among the unknowns, for which some schemes have other orders.
    pub multipliers: bool,
    /// Runs at a time.
    pub threads: usize,
    /// The reference.
    pub reference: Option<Reference>,
    /// Reason of its failure, if any.
    pub reference_failure: Option<String>,
    /// Components of momenta that are zero in all runs, whose drift is not reported.
    pub zero_momenta: Components,
    /// Observed orders of the schemes.
    pub orders: Vec<SchemeOrders>,
    /// Errors at equal numbers of assemblies.
    pub equal_cost: Option<EqualCost>,
    /// Errors at equal times of the integration alone, if measured.
    pub equal_time: Option<EqualCost>,
    /// All runs, scheme by scheme, from large to small steps.
    pub rows: Vec<ComparisonRow>,
    /// The long runs, one per scheme, if requested; they have no errors.
    pub long: Vec<ComparisonRow>,
    /// The runs with charts that change at [`LATE_CHARTS`] instead of half a turn, if requested, in the order of `rows`.
    pub charts: Vec<ComparisonRow>,
}

impl Comparison {
    /// Whether there is a reference for any quantity.
    pub fn is_known(&self) -> bool {
        let knows = |r: &Reference| ErrorQuantity::ALL.into_iter().any(|q| r.knows(q));
        self.reference.as_ref().is_some_and(knows)
    }

    /// The error of the reference in a quantity; zero without a reference.
    fn reference_error(&self, quantity: ErrorQuantity) -> f64 {
        self.reference
            .as_ref()
            .map_or(0.0, |r| r.error.of(quantity))
    }

    /// The conserved quantities of the motion, without momenta that are zero.
    fn conserved(&self) -> Conserved {
        let conserved = self.reference.as_ref().map(|r| r.conserved);
        conserved.unwrap_or_default().without(self.zero_momenta)
    }

    /// The rows of a scheme.
    pub fn of<'a>(&'a self, scheme: &'a str) -> impl Iterator<Item = &'a ComparisonRow> + 'a {
        self.rows.iter().filter(move |row| row.scheme == scheme)
    }
}
