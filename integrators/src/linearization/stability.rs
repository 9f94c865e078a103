//! The load at which a mode begins to grow: flutter and divergence.

use super::modes::{Mode, ModeOptions, ModesError, modes};
use super::{LinearizationError, Linearized, is_balanced, linearize};
use crate::significant;
use crate::statics::{StaticOptions, StaticsError, equilibrium_from};
use pullback_manifold::system::{Point, System};
use thiserror::Error;

/// An equilibrium at which a mode begins to grow.
#[derive(Clone, Debug, PartialEq)]
pub struct StabilityLimit {
    /// Load parameter.
    pub t: f64,
    /// Coordinates.
    pub q: Vec<f64>,
    /// The mode, where it just grows: flutter if it oscillates, divergence otherwise.
    pub mode: Mode,
}

/// Error of [`stability_limit`].
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StabilityError {
    /// There is no equilibrium at a load.
    #[error(transparent)]
    Equilibrium(#[from] StaticsError),
    /// An equilibrium cannot be linearised.
    #[error(transparent)]
    Linearization(#[from] LinearizationError),
    /// The search for modes failed.
    #[error(transparent)]
    Modes(#[from] ModesError),
    /// A mode grows at the start.
    #[error("a mode grows at load parameter {} already; begin at a smaller load", significant(*.0))]
    Unstable(f64),
    /// No mode grows at the end.
    #[error("none of the modes found grows at load parameter {}", significant(*.0))]
    Stable(f64),
}

/// Damping ratio by the damping of a system that counts as none.
const UNDAMPED: f64 = 1e-9;
/// Negative damping ratio by which modes grow after two frequencies of an undamped system have met. It begins like
/// the root of the load beyond that, so that the error of the load is the square of this.
const COALESCED: f64 = 1e-6;

/// The load between two at which one of the lowest `count` modes of a conservative or other system begins to grow, by
/// bisection to round-off, from the coordinates `q` of an equilibrium at the first load.
///
/// The system must be stable at the first load and unstable at the second one. Modes of an undamped system grow from
/// where two of its frequencies meet.
///
/// # Errors
/// [`StabilityError`].
pub fn stability_limit(
    system: &mut dyn System,
    q: &[f64],
    [mut from, mut to]: [f64; 2],
    count: usize,
    options: &StaticOptions,
) -> Result<StabilityLimit, StabilityError> {
    let mut modes_at = |t0: f64, q: &[f64], t: f64| -> Result<_, StabilityError> {
        let step = (t - t0).abs().max(f64::MIN_POSITIVE);
        let options = StaticOptions {
            from: t0,
            to: t,
            first_step: step.min(options.first_step),
            min_step: step.min(options.min_step),
            ..*options
        };
        let mut q = q.to_vec();
        // At a critical load the stiffness is singular.
        if !is_balanced(system, Point::statics(t, &q)) {
            q = equilibrium_from(system, q, &options)?;
        }
        let lin = linearize(system, Point::statics(t, &q))?;
        let all = modes(&lin, &ModeOptions::lowest(count))?.modes;
        let growing = all.into_iter().filter(|mode| grows(&lin, mode));
        let fastest = growing.max_by(|a, b| b.damping_ratio().total_cmp(&a.damping_ratio()));
        Ok((q, fastest))
    };
    let (mut stable, growing) = modes_at(from, q, from)?;
    if growing.is_some() {
        return Err(StabilityError::Unstable(from));
    }
    let (_, growing) = modes_at(from, &stable, to)?;
    let mut mode = growing.ok_or(StabilityError::Stable(to))?;
    let rounding = f64::EPSILON * from.abs().max(to.abs());
    loop {
        let middle = 0.5 * (from + to);
        if (middle - from).abs() <= rounding {
            return Ok(StabilityLimit {
                t: middle,
                q: stable,
                mode,
            });
        }
        let (q, growing) = modes_at(from, &stable, middle)?;
        match growing {
            Some(found) => (to, mode) = (middle, found),
            None => (from, stable) = (middle, q),
        }
    }
}

/// Whether a mode grows: at all if dampers act on it, beyond rounding errors otherwise.
fn grows(lin: &Linearized, mode: &Mode) -> bool {
    // Of φᴴ A φ, the part of the symmetric part of A.
    let form = |values: &[f64]| {
        let image = lin.product(values, &mode.shape);
        let products = mode.shape.iter().zip(&image);
        products.map(|(x, y)| (x.conj() * y).re).sum::<f64>()
    };
    let damped = form(&lin.C).abs() >= 2.0 * UNDAMPED * mode.omega() * form(&lin.M);
    mode.damping_ratio() < if damped { 0.0 } else { -COALESCED }
}
