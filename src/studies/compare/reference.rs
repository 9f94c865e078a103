//! The reference solution, and how far it can be trusted.

use super::Contender;
use super::Quantity;
use super::drift::{Kept, drift};
use super::grid::Grid;
use super::order::NEAR;
use super::run::{Ran, Task};
use super::sample::{QUANTITIES, Sample, Values, choose, distances, extrapolate, sizes};
use crate::method::Method;
use serde::Serialize;

/// Steps of the three runs behind a reference, over those of the finest run compared.
pub(super) const REFINED: [usize; 3] = [2, 4, 8];
/// Residual over forces that the runs behind a reference are converged to.
pub(super) const TIGHT: f64 = 1e-12;
/// Round-off of a quantity over its largest size.
const ROUND_OFF: f64 = 1e-12;
/// Change of an energy or momentum over its largest size beyond which it is not kept, however
/// doubtful the reference is.
const STEADY: f64 = 1e-3;

/// What a reference solution is, and the estimates of its own error.
///
/// Three runs A, B, C of one scheme of an order p ≥ 2, their steps 1/2, 1/4 and 1/8 of the finest
/// step compared. Where log₂ |A − B|/|B − C| is close to p for a quantity, Richardson's extrapolation
/// C + (C − B)/(2ᵖ − 1) is the reference and twice its distance from the one of A and B the estimate of its
/// error: an upper bound where extrapolations fall to two thirds with every halving of the step. Where it is not, C is the reference, with the
/// error that the observed order leaves, |B − C| or more; where that order is not positive, the runs do
/// not come closer, there is none, and its error is infinite. The order p in theory is that of each
/// quantity ([`Contender::orders`]).
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
    /// What the motion keeps.
    pub kept: Kept,
    /// Evaluations of the model in all three runs.
    pub evaluations: usize,
    /// Changes of chart in the finest of them.
    pub chart_changes: usize,
    /// The solution at the common times.
    #[serde(skip)]
    pub samples: Vec<Sample>,
}

impl Reference {
    /// Whether a quantity is known.
    pub fn knows(&self, quantity: Quantity) -> bool {
        self.error.of(quantity).is_finite()
    }
}

/// The three runs of a reference.
pub(super) fn tasks(method: &Method, grid: &Grid) -> [Task; 3] {
    REFINED.map(|factor| Task {
        name: format!("reference, {method}"),
        contender: Contender::Method(*method),
        steps: factor * grid.finest(),
        relative: TIGHT,
        late: false,
    })
}

/// Judges three runs that have come to their ends.
pub(super) fn judge(
    method: &Method,
    multipliers: bool,
    grid: &Grid,
    runs: &[Ran],
) -> Option<Reference> {
    let [a, b, c] = runs else { return None };
    let theory = Contender::Method(*method).orders(multipliers)?;
    let (first, second) = (
        distances(&a.samples, &b.samples),
        distances(&b.samples, &c.samples),
    );
    let (ab, bc) = (
        extrapolate(&a.samples, &b.samples, theory),
        extrapolate(&b.samples, &c.samples, theory),
    );
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
        extrapolated[k] = (order[k] - theory.0[k] as f64).abs() <= NEAR;
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
    Some(Reference {
        scheme: method.to_string(),
        steps: REFINED.map(|factor| grid.step(factor * grid.finest())),
        order: Values(order),
        extrapolated: Values(extrapolated),
        error,
        kept: kept(&bc, &c.samples, [&ab, &bc]),
        evaluations: runs.iter().map(|r| r.summary.evaluations).sum(),
        chart_changes: c.summary.chart_changes,
        samples: choose(&bc, &c.samples, extrapolated),
    })
}

/// Which energies and momenta stay as they are, but for the error of the reference itself.
fn kept(best: &[Sample], finest: &[Sample], two: [&[Sample]; 2]) -> Kept {
    // The extrapolations of two pairs of runs tell how far their differences are to be believed.
    let keeps = |value: &dyn Fn(&Sample) -> f64, size: f64| {
        let doubt = two[0].iter().zip(two[1]);
        let doubt = doubt.map(|(a, b)| (value(a) - value(b)).abs());
        let doubt = doubt.fold(ROUND_OFF * size, f64::max);
        drift(best, value) <= (10.0 * doubt).min(STEADY * size)
    };
    let largest = |value: &dyn Fn(&Sample) -> f64| finest.iter().map(value).fold(0.0, f64::max);
    let energy = largest(&|s| s.gross_energy);
    let momentum = |k: usize| {
        let size = largest(&|s| s.momenta[k].norm());
        [0, 1, 2].map(|i| keeps(&|s| s.momenta[k][i], size))
    };
    Kept {
        energy: keeps(&|s| s.energy, energy),
        momentum: momentum(0),
        angular_momentum: momentum(1),
    }
}

/// What an exact motion keeps, to rounding; nothing of what it does not know.
pub(super) fn kept_by(samples: &[Sample]) -> Kept {
    let largest = |value: &dyn Fn(&Sample) -> f64| samples.iter().map(value).fold(0.0, f64::max);
    let keeps = |value: &dyn Fn(&Sample) -> f64, size: f64| {
        let known = samples.iter().all(|s| value(s).is_finite());
        known && drift(samples, value) <= 10.0 * ROUND_OFF * size
    };
    let momentum = |k: usize| {
        let size = largest(&|s| s.momenta[k].norm());
        [0, 1, 2].map(|i| keeps(&|s| s.momenta[k][i], size))
    };
    Kept {
        energy: keeps(&|s| s.energy, largest(&|s| s.gross_energy)),
        momentum: momentum(0),
        angular_momentum: momentum(1),
    }
}
