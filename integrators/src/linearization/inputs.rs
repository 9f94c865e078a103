//! Derivatives by the inputs of a system.

use pullback_manifold::system::{Evaluation, Point, System, SystemError};

/// Step of differences at a value with a unit: rounding errors and those of the fourth order are then alike.
pub(super) fn step(value: f64, unit: f64) -> f64 {
    1e-3 * value.abs().max(unit)
}

/// The derivative of a function by central differences of order four with steps `h`; exact but for rounding where it
/// is a polynomial of this degree, as of loads and speeds.
pub(super) fn central(
    h: f64,
    mut f: impl FnMut(f64) -> Result<Vec<f64>, SystemError>,
) -> Result<Vec<f64>, SystemError> {
    let mut sum: Vec<f64> = Vec::new();
    // Of a constant the sum is zero exactly.
    for (s, weight) in [(-2.0, 1.0), (2.0, -1.0), (-1.0, -8.0), (1.0, 8.0)] {
        let value = f(s * h)?;
        sum.resize(value.len(), 0.0);
        for (sum, x) in sum.iter_mut().zip(value) {
            *sum += weight / (12.0 * h) * x;
        }
    }
    Ok(sum)
}

/// The values of the inputs of a system.
pub(super) fn values(system: &mut (impl System + ?Sized)) -> Vec<f64> {
    let events = system.events();
    events.map_or_else(Vec::new, |events| events.inputs().to_vec())
}

/// The derivative of a function of a system by an input at the value `u`, which it has afterwards.
pub(super) fn by_input<Y: System + ?Sized>(
    system: &mut Y,
    (input, u): (usize, f64),
    f: &mut dyn FnMut(&mut Y) -> Result<Vec<f64>, SystemError>,
) -> Result<Vec<f64>, SystemError> {
    let set = |system: &mut Y, u: f64| {
        if let Some(events) = system.events() {
            events.inputs()[input] = u;
        }
    };
    let found = central(step(u, 1.0), |du| {
        set(system, u + du);
        f(system)
    });
    set(system, u);
    found
}

/// ∂r/∂u of an input at the value `u`.
pub(super) fn derivative(
    system: &mut dyn System,
    at: Point<'_>,
    input: (usize, f64),
) -> Result<Vec<f64>, SystemError> {
    let n = system.pattern().dim();
    by_input(system, input, &mut |system| {
        let mut r = vec![0.0; n];
        system.evaluate(at, Evaluation::residual(&mut r))?;
        Ok(r)
    })
}

/// ∂r/∂u of each input.
pub(super) fn input_columns(
    system: &mut dyn System,
    at: Point<'_>,
) -> Result<Vec<Vec<f64>>, SystemError> {
    let inputs = values(system).into_iter().enumerate();
    inputs.map(|input| derivative(system, at, input)).collect()
}
