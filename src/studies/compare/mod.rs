//! Integrators side by side on one model: errors, orders, cost, drift.
//!
//! Every scheme runs at every step size on a model of its own. Errors are root mean squares over
//! common times and all frame nodes, against a [`Reference`] whose own error is estimated; orders
//! are slopes of log error over log step in the asymptotic range, with a confidence interval
//! ([`fit`]). Runs go side by side on threads; nothing but times depends on how many.
//!
//! ```
//! use pullback::studies::compare::{Options, Quantity, Watch, compare};
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

pub use contender::Contender;
pub use drift::{Components, Drift, Kept};
pub use equal_cost::EqualCost;
pub use error::CompareError;
pub use exact::{Exact, read as read_exact};
pub use order::{ABOVE_REFERENCE, NEAR, Order, STRAIGHT, fit};
pub use perform::{compare, looked_at};
pub use reference::Reference;
pub(super) use run::side_by_side;
pub use run::{LATE, Maker, Watch};
pub use sample::{Pose, Quantity, Sample, Values};
pub use tables::{summary, unknown};
pub use write::{FILES, Subject, default_directory, run, run_several};

use crate::method::Method;
use crate::solve::Counts;
use serde::Serialize;
use std::num::NonZeroUsize;

/// What is compared.
#[derive(Clone, Debug)]
pub struct Options {
    /// The schemes, each with its formulation of rotations, and general solvers.
    pub schemes: Vec<Contender>,
    /// Step sizes, from large to small.
    pub steps: Vec<f64>,
    /// Scheme of the reference, in whatever formulation; by default Radau IIA of two stages, of order 3, which
    /// damps what no step resolves, in total rotation vectors.
    pub reference: Option<Method>,
    /// An exact solution in place of the reference.
    pub exact: Option<Exact>,
    /// Runs at a time; as many as the machine has cores by default.
    pub threads: Option<NonZeroUsize>,
    /// Whether each run is made again alone on the machine, to take its time.
    pub timed: bool,
    /// Every scheme runs once more at the largest step, for so many times the duration, to see what
    /// becomes of energies and momenta.
    pub long: Option<f64>,
    /// Whether every scheme runs once more at every step size with charts that are kept longer, to see
    /// what changes of chart cost.
    pub charts: bool,
    /// Residual over forces that runs are converged to, where it is smaller than that of the model
    /// file: what is left of it is an error of no scheme.
    pub residual: Option<f64>,
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
            long: None,
            charts: false,
            residual: None,
        }
    }
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
    /// How often it assembled the model: once per state that was evaluated, and three times for a tangent
    /// where rates are spins. What comes before the first step is apart.
    pub assemblies: usize,
    /// How often it assembled the model to find what the scheme has to know before its first step: what
    /// the motion keeps, or the largest frequency.
    pub searching: usize,
    /// Root mean square errors against the reference.
    pub error: Option<Values>,
    /// Drift of what the motion keeps, and the balance of energy.
    pub drift: Drift,
    /// Wall-clock time in seconds, with the audits at common times, beside other runs.
    pub seconds: f64,
    /// Wall-clock time in seconds of the integration alone on the machine, with what it looks for before its
    /// first step.
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
    pub theory: Option<Values<usize>>,
    /// The order observed in each quantity, where one can be.
    pub observed: Values<Option<Order>>,
}

/// What an observed slope is beside the order in theory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slope {
    /// The order of theory, as far as can be seen: three step sizes at least on a line whose slope is
    /// within [`NEAR`] of it.
    Theory,
    /// Three step sizes at least on a line that is steeper: at these steps the leading term of the
    /// error is smaller than the next one.
    Above,
    /// No order that anybody sees.
    Doubtful,
}

impl SchemeOrders {
    /// The order observed in a quantity.
    pub fn of(&self, quantity: Quantity) -> Option<Order> {
        self.observed.of(quantity)
    }

    /// What is observed in a quantity beside theory.
    pub fn slope(&self, quantity: Quantity) -> Option<Slope> {
        let (observed, theory) = (self.of(quantity)?, self.theory?.of(quantity) as f64);
        Some(match observed.order - theory {
            off if observed.points < 3 || off < -NEAR => Slope::Doubtful,
            off if off > NEAR => Slope::Above,
            _ => Slope::Theory,
        })
    }

    /// Whether what is observed in a quantity is the order of theory ([`Slope::Theory`]).
    pub fn is_asymptotic(&self, quantity: Quantity) -> bool {
        self.slope(quantity) == Some(Slope::Theory)
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
    /// Whether multipliers are among the unknowns: some schemes then have other orders.
    pub multipliers: bool,
    /// Runs at a time.
    pub threads: usize,
    /// The reference.
    pub reference: Option<Reference>,
    /// Why there is none, if there is none.
    pub reference_failure: Option<String>,
    /// Components of momenta that are zero in all runs; no drift is told of them.
    pub zero_momenta: Components,
    /// Observed orders of the schemes.
    pub orders: Vec<SchemeOrders>,
    /// Errors at equal numbers of assemblies.
    pub equal_cost: Option<EqualCost>,
    /// Errors at equal times of the integration alone, where they were taken.
    pub equal_time: Option<EqualCost>,
    /// All runs, scheme by scheme, from large to small steps.
    pub rows: Vec<Row>,
    /// The long runs, one per scheme, if they are asked for; they have no errors.
    pub long: Vec<Row>,
    /// The runs with charts kept until [`LATE`] in place of half a turn, if they are asked for, in the order
    /// of `rows`.
    pub late: Vec<Row>,
}

impl Comparison {
    /// Whether there is a reference, and it knows any quantity.
    pub fn is_known(&self) -> bool {
        let knows = |r: &Reference| Quantity::ALL.into_iter().any(|q| r.knows(q));
        self.reference.as_ref().is_some_and(knows)
    }

    /// The rows of a scheme.
    pub fn of<'a>(&'a self, scheme: &'a str) -> impl Iterator<Item = &'a Row> + 'a {
        self.rows.iter().filter(move |row| row.scheme == scheme)
    }
}
