//! Central differences, and derivatives by the inputs of a system.

use super::events;
use pullback_manifold::system::{Evaluation, Point, System, SystemError};

/// Largest step of differences at a value with a unit.
pub(super) fn step(value: f64, unit: f64) -> f64 {
    1e-3 * value.abs().max(unit)
}

/// Ratio of the two steps of a difference, far from fractions of small numbers: periods of a function would agree.
const RATIO: f64 = 1.618_034;
/// Factor between the steps of successive differences.
const FINER: f64 = 0.118_034;
/// Number of differences that are tried.
const TRIALS: usize = 8;
/// Largest relative difference of derivatives with two steps that agree.
const AGREE: f64 = 1e-7;
/// The same for rounding errors, in units of those of the component, and of terms that cancel, relative to the largest derivative.
const ROUNDING: f64 = 4.0;
const NOTHING: f64 = 1e-12;

/// One component of a derivative by central differences with two steps.
#[derive(Clone, Copy, Default)]
pub(super) struct Difference {
    /// The derivative, of order four.
    pub value: f64,
    /// Difference of the derivatives of order two with the two steps, or from that with larger ones, if it is smaller.
    change: f64,
    /// Rounding errors.
    rounding: f64,
}

/// The components whose derivatives with both steps do not agree.
fn open(all: &[Difference]) -> Vec<usize> {
    let largest = all.iter().fold(0.0, |most, x| x.value.abs().max(most));
    let agrees = |x: &Difference| {
        let rounding = (ROUNDING * x.rounding).max(NOTHING * largest);
        x.change.abs() <= rounding.max(AGREE * x.value.abs())
    };
    (0..all.len()).filter(|&i| !agrees(&all[i])).collect()
}

/// The derivative of a function at zero, by central differences with the steps `h` and smaller ones, until those of two steps,
/// or of successive pairs, agree in each component: the size of the argument that matters need not be known (cf. Ridders 1982).
///
/// # Errors
/// That of the function at the first step, if it has no value at smaller ones either.
pub(super) fn derivative_of(
    mut h: f64,
    mut f: impl FnMut(f64) -> Result<Vec<f64>, SystemError>,
) -> Result<Vec<f64>, SystemError> {
    let mut best: Vec<Difference> = Vec::new();
    let mut before = Vec::new();
    let mut failed = None;
    for _ in 0..TRIALS {
        match central(h, &mut f) {
            Err(error) => failed = failed.or(Some(error)),
            Ok(now) if before.is_empty() => {
                best.clone_from(&now);
                before = now;
            }
            Ok(now) => {
                for i in open(&best) {
                    let change = (now[i].value - before[i].value).abs();
                    let change = now[i].change.abs().min(change);
                    // Less than one that is not a number, too.
                    if change.total_cmp(&best[i].change.abs()).is_lt() {
                        best[i] = Difference { change, ..now[i] };
                    }
                }
                before = now;
            }
        }
        if !before.is_empty() && open(&best).is_empty() {
            break;
        }
        h *= FINER;
    }
    match failed {
        Some(error) if before.is_empty() => Err(error),
        _ => Ok(best.iter().map(|x| x.value).collect()),
    }
}

/// The derivative of a function at zero by central differences of order four, with steps `h` and [`RATIO`] `h`: exact but for
/// rounding errors where it is a polynomial of this degree, as of loads and speeds.
pub(super) fn central(
    h: f64,
    mut f: impl FnMut(f64) -> Result<Vec<f64>, SystemError>,
) -> Result<Vec<Difference>, SystemError> {
    let mut sums: Vec<Difference> = Vec::new();
    // The error of a slope is in proportion to the square of its step. Of a constant all is zero exactly.
    let others = (RATIO * RATIO - 1.0).recip();
    for (h, weight) in [(h, 1.0 + others), (RATIO * h, -others)] {
        let (before, after) = (f(-h)?, f(h)?);
        sums.resize(after.len(), Difference::default());
        for (sum, (a, b)) in sums.iter_mut().zip(before.iter().zip(&after)) {
            let slope = (b - a) / (2.0 * h);
            sum.value += weight * slope;
            sum.change += weight.signum() * slope;
            sum.rounding += f64::EPSILON * (a.abs() + b.abs()) / (2.0 * h);
        }
    }
    Ok(sums)
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

/// ∂r/∂u of each input.
pub(super) fn input_columns(
    system: &mut dyn System,
    at: Point<'_>,
) -> Result<Vec<Vec<f64>>, SystemError> {
    let n = system.pattern().dim();
    let inputs = events(system).inputs().to_vec().into_iter().enumerate();
    let column = |input| {
        by_input(system, input, &mut |system| {
            let mut r = vec![0.0; n];
            system.evaluate(at, Evaluation::residual(&mut r))?;
            Ok(r)
        })
    };
    inputs.map(column).collect()
}
