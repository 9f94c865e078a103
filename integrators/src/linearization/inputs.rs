//! Derivatives of the residual by the inputs of a system.

use super::events;
use pullback_manifold::system::{Evaluation, Point, System, SystemError};

/// Steps of differences by an input, relative to it and at least to one: rounding errors and those of the fourth
/// order are then alike.
const STEP: f64 = 1e-3;

/// ∂r/∂u of each input.
pub(super) fn input_columns(
    system: &mut dyn System,
    at: Point<'_>,
) -> Result<Vec<Vec<f64>>, SystemError> {
    let inputs = events(system).inputs().to_vec();
    let columns = inputs.iter().enumerate();
    columns
        .map(|(k, &u)| derivative(system, at, k, u))
        .collect()
}

/// ∂r/∂u at the value `u` of an input, by central differences of order four; exact but for rounding where the residual
/// is a polynomial of this degree, as for loads and speeds.
pub(super) fn derivative(
    system: &mut dyn System,
    at: Point<'_>,
    input: usize,
    u: f64,
) -> Result<Vec<f64>, SystemError> {
    let n = system.pattern().dim();
    let h = STEP * u.abs().max(1.0);
    let set = |system: &mut dyn System, u: f64| {
        if let Some(input) = events(system).inputs().get_mut(input) {
            *input = u;
        }
    };
    let mut sum = vec![0.0; n];
    let mut outcome = Ok(());
    for (s, weight) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
        let mut r = vec![0.0; n];
        set(system, u + s * h);
        outcome = outcome.and(system.evaluate(at, Evaluation::residual(&mut r)));
        for (sum, r) in sum.iter_mut().zip(r) {
            *sum += weight / (12.0 * h) * r;
        }
    }
    set(system, u);
    outcome.map(|()| sum)
}
