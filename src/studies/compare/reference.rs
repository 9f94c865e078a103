//! The reference solution and its error.

use super::drift::{Conserved, drift};
use super::grid::Grid;
use super::order::NEAR;
use super::run::Task;
use super::sample::{QUANTITIES, Sample, Values, distances, extrapolate, sizes};
use super::{Candidate, ComparisonRow, ErrorQuantity};
use crate::method::Method;
use serde::Serialize;

/// Numbers of steps of the three runs of a reference, over that of the finest run compared.
const REFINED: [usize; 3] = [2, 4, 8];
/// Tolerance of the residual relative to forces in the runs of a reference.
const TIGHT: f64 = 1e-12;
/// Round-off of a quantity over its largest size.
const ROUND_OFF: f64 = 1e-12;
/// Relative change of an energy or momentum beyond which it is not conserved, whatever the error of the reference.
const STEADY: f64 = 1e-3;

/// A reference solution with estimates of its own error.
///
/// Three runs A, B, C of one scheme of an order p ≥ 2 have steps 1/2, 1/4 and 1/8 of the finest
/// step compared. If log₂ |A − B|/|B − C| is close to p for a quantity, the reference is Richardson's extrapolation
/// C + (C − B)/(2ᵖ − 1), and its error estimate twice the distance from the extrapolation of A and B: an upper bound
/// if extrapolations fall to two thirds with every halving of the step. Otherwise C is the reference, with the
/// error that the observed order implies, |B − C| or more. If that order is not positive the runs do
/// not converge, and the quantity has no reference and an infinite error. The order p in theory is that of each
/// quantity ([`Candidate::orders`]).
#[derive(Clone, Debug, Serialize)]
pub struct Reference {
    /// The scheme.
    pub scheme: String,
    /// Step sizes of the three runs.
    pub steps: [f64; 3],
    /// Observed order of the three runs.
    pub order: Values,
    /// Whether a quantity is extrapolated.
    pub extrapolated: Values<bool>,
    /// Estimate of the error of each quantity, root mean square.
    pub error: Values,
    /// Conserved quantities.
    pub conserved: Conserved,
    /// Evaluations of the model in all three runs.
    pub evaluations: usize,
    /// Changes of chart in the finest of them.
    pub chart_changes: usize,
    /// The solution at the common times.
    #[serde(skip)]
    pub samples: Vec<Sample>,
}

impl Reference {
    /// Whether a quantity has a reference.
    pub fn knows(&self, quantity: ErrorQuantity) -> bool {
        self.error.of(quantity).is_finite()
    }
}

/// The three runs of a reference.
pub(super) fn tasks<'a>(method: &Method, grid: &'a Grid) -> [Task<'a>; 3] {
    REFINED.map(|factor| Task {
        name: format!("reference, {method}"),
        candidate: Candidate::Method(*method),
        grid,
        requested: grid.step(factor * grid.finest()),
        steps: factor * grid.finest(),
        relative: TIGHT,
        late_charts: false,
    })
}

/// Constructs the reference from three complete runs.
pub(super) fn judge(
    method: &Method,
    multipliers: bool,
    runs: &[ComparisonRow],
) -> Option<Reference> {
    let [a, b, c] = runs else { return None };
    let theory = Candidate::Method(*method).orders(multipliers)?;
    let theory = theory.0.map(|p| p as f64);
    let pairs = [[&a.samples, &b.samples], [&b.samples, &c.samples]];
    let [first, second] = pairs.map(|[a, b]| distances(a, b));
    let [ab, bc] = pairs.map(|[a, b]| extrapolate(a, b, Values(theory)));
    let between = distances(&ab, &bc);
    let size = sizes(&c.samples);
    let (mut order, mut error) = ([f64::NAN; QUANTITIES], [0.0; QUANTITIES]);
    let mut extrapolated = [false; QUANTITIES];
    for k in 0..QUANTITIES {
        let round_off = ROUND_OFF * size.0[k];
        if second.0[k] <= round_off {
            error[k] = round_off;
            continue;
        }
        order[k] = (first.0[k] / second.0[k]).log2();
        extrapolated[k] = (order[k] - theory[k]).abs() <= NEAR;
        error[k] = if extrapolated[k] {
            2.0 * between.0[k]
        } else if order[k] > 0.0 {
            second.0[k] / (order[k].exp2() - 1.0).min(1.0)
        } else {
            f64::INFINITY
        };
        error[k] = error[k].max(round_off);
    }
    let error = Values(error);
    let used = |k| {
        if extrapolated[k] {
            theory[k]
        } else {
            f64::INFINITY
        }
    };
    let used = Values(std::array::from_fn(used));
    Some(Reference {
        scheme: method.to_string(),
        steps: [a.step, b.step, c.step],
        order: Values(order),
        extrapolated: Values(extrapolated),
        error,
        conserved: conserved(&bc, &c.samples, [&ab, &bc]),
        evaluations: runs.iter().map(|run| run.counts.evaluations).sum(),
        chart_changes: c.counts.chart_changes,
        samples: extrapolate(&b.samples, &c.samples, used),
    })
}

/// The energies and momenta that are constant up to the error of the reference.
fn conserved(best: &[Sample], finest: &[Sample], two: [&[Sample]; 2]) -> Conserved {
    // The difference of the extrapolations of two pairs of runs estimates that error.
    let conserves = |value: &dyn Fn(&Sample) -> f64, size: f64| {
        let error = two[0].iter().zip(two[1]);
        let error = error.map(|(a, b)| (value(a) - value(b)).abs());
        let error = error.fold(ROUND_OFF * size, f64::max);
        drift(best, value).is_some_and(|drift| drift <= (10.0 * error).min(STEADY * size))
    };
    each(finest, &conserves)
}

/// Quantities that an exact motion conserves, up to rounding, among those known.
pub(super) fn exactly_conserved(samples: &[Sample]) -> Conserved {
    let conserves = |value: &dyn Fn(&Sample) -> f64, size: f64| {
        let known = samples.iter().all(|s| value(s).is_finite());
        known && drift(samples, value).is_some_and(|drift| drift <= 10.0 * ROUND_OFF * size)
    };
    each(samples, &conserves)
}

/// Whether a quantity of this size is conserved.
type Criterion<'a> = dyn Fn(&dyn Fn(&Sample) -> f64, f64) -> bool + 'a;

/// The quantities for which `conserves` holds, with their largest sizes in a run.
fn each(samples: &[Sample], conserves: &Criterion<'_>) -> Conserved {
    let largest = |value: &dyn Fn(&Sample) -> f64| samples.iter().map(value).fold(0.0, f64::max);
    let momentum = |k: usize| {
        let size = largest(&|s| s.momenta[k].norm());
        [0, 1, 2].map(|i| conserves(&|s| s.momenta[k][i], size))
    };
    Conserved {
        energy: conserves(&|s| s.energy, largest(&|s| s.gross_energy)),
        momentum: momentum(0),
        angular_momentum: momentum(1),
    }
}
