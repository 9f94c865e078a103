//! Options of a run, and their validation.

use super::{DynamicsError, NewtonOptions, Progress, Scheme, State};
use crate::statics::refused;
use pullback_manifold::system::System;

/// Options of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DynamicOptions {
    /// Time at the end.
    pub to: f64,
    /// Step size. Between kinks steps are equal and at most this large.
    pub step: f64,
    /// Steps also end exactly at the multiples of this time, for output.
    pub interval: Option<f64>,
    /// A failed step is halved down to this size; then the run fails.
    pub min_step: f64,
    /// A halved step is doubled again after this many converged steps in a row.
    pub easy: usize,
    /// The scheme.
    pub scheme: Scheme,
    /// Newton's method inside a step.
    pub newton: NewtonOptions,
    /// Adaptive steps by an estimate of the local error; for schemes of order 2, or with an embedded
    /// method.
    pub adaptivity: Option<Adaptivity>,
    /// Whether energies are evaluated after each step, if the system provides them.
    pub energies: bool,
}

impl DynamicOptions {
    /// Equal steps of size `step` until `to` by the trapezoidal rule.
    pub fn new(to: f64, step: f64) -> Self {
        Self {
            to,
            step,
            interval: None,
            min_step: 1e-6 * step,
            easy: 4,
            scheme: Scheme::default(),
            newton: NewtonOptions::default(),
            adaptivity: None,
            energies: true,
        }
    }

    /// Number of whole intervals before a time.
    pub fn intervals(&self, t: f64) -> Option<f64> {
        self.interval.map(|interval| (t / interval + 1e-6).floor())
    }
}

/// Step sizes by an estimate of the local error: that of Zienkiewicz & Xie (1991), or the difference to
/// an embedded method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptivity {
    /// Tolerance of the local error of a step, relative to the scales of the coordinates (the size
    /// of the model, one radian).
    pub tolerance: f64,
    /// Largest step.
    pub max_step: f64,
}

/// Schemes whose spectral radius at infinity is closer to 1 than this are rejected for multipliers:
/// a disturbance of λ would persist.
const UNDAMPED: f64 = 1e-6;

/// Rejects invalid options and initial states.
pub(super) fn check(
    options: &DynamicOptions,
    progress: &Progress,
    system: &dyn System,
) -> Result<(), DynamicsError> {
    let positive = "it must be positive and finite";
    let mut sizes = vec![("step", options.step), ("min_step", options.min_step)];
    if let Some(Adaptivity {
        tolerance,
        max_step,
    }) = options.adaptivity
    {
        sizes.extend([("tolerance", tolerance), ("max_step", max_step)]);
    }
    sizes.extend(options.interval.map(|interval| ("interval", interval)));
    for (name, value) in sizes {
        if !(value > 0.0 && value.is_finite()) {
            return Err(DynamicsError::Option {
                name,
                value,
                wanted: positive,
            });
        }
    }
    if let Some((name, value)) = refused(options.newton.relative, options.newton.absolute) {
        return Err(DynamicsError::Option {
            name,
            value,
            wanted: "it must be finite, and a tolerance at most 0.1",
        });
    }
    if options.adaptivity.is_some() && !options.scheme.estimates_error() {
        return Err(DynamicsError::Option {
            name: "adaptivity",
            value: options.scheme.order() as f64,
            wanted: "the estimate of the local error is for schemes of order 2 and those with an \
                     embedded method (tsitouras); take equal steps",
        });
    }
    let rho = options.scheme.spectral_radius();
    let multiplier = (0..system.pattern().dim()).find(|&i| system.coordinate_info(i).is_multiplier);
    if let Some(i) = multiplier.filter(|_| rho > 1.0 - UNDAMPED) {
        return Err(DynamicsError::Undamped {
            scheme: options.scheme.name,
            rho,
            multiplier: system.name(i),
        });
    }
    if !(options.to >= progress.state.t && options.to.is_finite()) {
        return Err(DynamicsError::Option {
            name: "to",
            value: options.to,
            wanted: "it must be finite and not before the time of the state",
        });
    }
    let n = system.pattern().dim();
    let State {
        q,
        v,
        a,
        algorithmic,
        ..
    } = &progress.state;
    let fresh = a.is_empty() && algorithmic.is_empty();
    for (what, x) in [
        ("coordinates", q),
        ("velocities", v),
        ("accelerations", a),
        ("algorithmic accelerations", algorithmic),
    ] {
        let empty = fresh && what.ends_with("accelerations");
        if x.len() != n && !empty {
            return Err(DynamicsError::Initial {
                what,
                problem: format!("{} given where the system has {n} coordinates", x.len()),
            });
        }
    }
    Ok(())
}
