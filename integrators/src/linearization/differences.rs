//! Central differences, and derivatives by the inputs of a system.

use pullback_manifold::system::{Evaluation, Point, System, SystemError};

/// Largest step of differences at a value with a unit.
pub(super) fn step(value: f64, unit: f64) -> f64 {
    1e-3 * value.abs().max(unit)
}

/// Factor between steps, far from fractions of small numbers: periods of a function would agree.
const FINER: f64 = 0.118_034;
/// Number of steps that are tried.
const STEPS: usize = 8;
/// Largest relative difference of derivatives with two steps that agree.
const AGREE: f64 = 1e-7;
/// The same for rounding errors, in units of those of the finer step.
const ROUNDING: f64 = 4.0;

/// The derivative of a function at zero, by central differences with the step `h` and smaller ones, until those of two agree in
/// each component: the size of the argument that matters need not be known (cf. Ridders 1982).
///
/// # Errors
/// Those of the function at all steps.
pub(super) fn derivative_of(
    mut h: f64,
    mut f: impl FnMut(f64) -> Result<Vec<f64>, SystemError>,
) -> Result<Vec<f64>, SystemError> {
    let mut before = central(h, &mut f);
    if let Ok(change) = &before
        && change.iter().all(|x| x[0] == 0.0)
    {
        return before.map(values_of);
    }
    // The best derivatives, with their errors.
    let mut best: Vec<[f64; 2]> = Vec::new();
    for _ in 1..STEPS {
        h *= FINER;
        let now = central(h, &mut f);
        if let (Ok(coarse), Ok(fine)) = (&before, &now) {
            best.resize(fine.len(), [f64::NAN, f64::INFINITY]);
            let mut agree = true;
            for ((best, coarse), fine) in best.iter_mut().zip(coarse).zip(fine) {
                let error = (fine[0] - coarse[0]).abs();
                let rounding = ROUNDING * fine[1];
                if error < best[1] {
                    let exact = if error <= rounding { coarse } else { fine };
                    *best = [exact[0], error];
                }
                agree &= best[1] <= rounding.max(AGREE * fine[0].abs());
            }
            if agree {
                break;
            }
        }
        before = now;
    }
    match best.is_empty() {
        true => before.map(values_of),
        false => Ok(values_of(best)),
    }
}

fn values_of(derivatives: Vec<[f64; 2]>) -> Vec<f64> {
    derivatives.into_iter().map(|[x, _]| x).collect()
}

/// The derivative of a function by central differences of order four with steps `h`, each with its rounding error; exact but for
/// that where the function is a polynomial of this degree, as of loads and speeds.
pub(super) fn central(
    h: f64,
    mut f: impl FnMut(f64) -> Result<Vec<f64>, SystemError>,
) -> Result<Vec<[f64; 2]>, SystemError> {
    let mut sum: Vec<[f64; 2]> = Vec::new();
    // Of a constant the sum is zero exactly.
    for (s, weight) in [(-2.0, 1.0), (2.0, -1.0), (-1.0, -8.0), (1.0, 8.0)] {
        let value = f(s * h)?;
        sum.resize(value.len(), [0.0; 2]);
        for (sum, x) in sum.iter_mut().zip(value) {
            let part = weight / (12.0 * h) * x;
            sum[0] += part;
            sum[1] += f64::EPSILON * part.abs();
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
    let found = derivative_of(step(u, 1.0), |du| {
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
