//! Options of a run, and their validation.

use super::scheme::Stage;
use super::stops::slack;
use super::{DynamicsError, Scheme, State};
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
    /// The scheme.
    pub scheme: Scheme,
    /// Newton's method inside a step.
    pub newton: NewtonOptions,
    /// Adaptive steps by an estimate of the local error; for schemes of order 1 or 2, or with an embedded
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

/// Options of Newton's method within a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonOptions {
    /// Residual relative to applied and reaction forces (moments) at convergence; without any
    /// forces, only rounding errors are allowed, and of [`Quantity::Other`](pullback_manifold::system::Quantity::Other)
    /// this part of the first residual.
    pub relative: f64,
    /// Absolute tolerance of the same test, in units of force (moment); 0 allows only rounding errors.
    pub absolute: f64,
    /// Largest number of iterations per step.
    pub max_iterations: usize,
    /// When the tangent is factorised.
    pub tangent: TangentUpdate,
    /// The start of the iteration.
    pub predictor: Predictor,
}

impl Default for NewtonOptions {
    fn default() -> Self {
        Self {
            relative: 1e-9,
            absolute: 0.0,
            max_iterations: 15,
            tangent: TangentUpdate::default(),
            predictor: Predictor::default(),
        }
    }
}

/// Start of Newton's iteration of a step; velocities and accelerations follow by the scheme.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Predictor {
    /// Coordinates extrapolated by the velocities, qₙ + h q̇ₙ; in smooth motion by the accelerations as well,
    /// + ½ h² q̈ₙ, which saves one of two iterations of rigid mechanisms.
    ///
    /// Motion counts as smooth if the accelerations change the velocities by at most 2 % in a step, in the largest
    /// coordinates. In beams with larger steps they oscillate with the trapezoidal rule, and fail as a predictor:
    /// the arms of \[M04\] 4.2 reject 143 of 729 steps with them, and none without.
    #[default]
    Velocity,
    /// Constant coordinates: the iteration starts from the last configuration.
    Keep,
}

/// Frequency of factorisations in a step.
///
/// Measured (benches/runs), `Once` against `Every`: the right-angle cantilever of \[M04\] 4.2 takes
/// 2349 iterations for 598, 366 factorisations for 507, 71 failed steps for none, and twice the
/// time; at a quarter of the step 2568 for 1691 and 603 for 1203 in 0.85 of the time. `Once` pays
/// off at small steps only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum TangentUpdate {
    /// In every iteration: quadratic convergence.
    #[default]
    Every,
    /// Once at the beginning of a step: more iterations, each cheaper.
    Once,
}

/// Schemes whose spectral radius at infinity is closer to 1 than this are rejected for multipliers:
/// a disturbance of λ would persist.
const UNDAMPED: f64 = 1e-6;

/// Rejects invalid options and initial states.
pub(super) fn check(
    options: &DynamicOptions,
    state: &State,
    system: &dyn System,
) -> Result<(), DynamicsError> {
    check_numbers(options)?;
    if let Some(adaptivity) = options.adaptivity
        && !options.scheme.estimates_error()
    {
        let wanted = "the estimate of the local error is for schemes of order 1 or 2 and those with an \
                      embedded method (tsitouras); take equal steps";
        return refuse("tolerance", adaptivity.tolerance, wanted);
    }
    let rho = options.scheme.spectral_radius();
    let multiplier =
        (0..system.pattern().dim()).find(|&i| system.pattern().coordinates()[i].is_multiplier);
    if let Some(i) = multiplier.filter(|_| rho > 1.0 - UNDAMPED) {
        return Err(DynamicsError::Undamped {
            scheme: options.scheme.name,
            rho,
            multiplier: system.name(i),
        });
    }
    // A run that ended at a kink is there, but for rounding errors.
    let last = options.to + slack(options.to, options.step);
    if !(last >= state.t && (options.to / options.step).is_finite()) {
        let wanted = "it must be a finite number of steps, and not before the time of the state";
        return refuse("to", options.to, wanted);
    }
    check_state(state, system)
}

fn refuse(name: &'static str, value: f64, wanted: &'static str) -> Result<(), DynamicsError> {
    Err(DynamicsError::Option {
        name,
        value,
        wanted,
    })
}

/// Rejects sizes that are not positive, and invalid tolerances of Newton's method.
fn check_numbers(options: &DynamicOptions) -> Result<(), DynamicsError> {
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
            return refuse(name, value, "it must be positive and finite");
        }
    }
    if let Some(Adaptivity { max_step, .. }) = options.adaptivity {
        if max_step < options.min_step {
            return refuse("max_step", max_step, "it must be at least `min_step`");
        }
        let scheme = &options.scheme;
        let stages = 1 + scheme.stages().len();
        let useless = |row: &Stage| {
            let mut weights = row.q.iter().chain(&row.v);
            let mut beyond = row.q[stages..].iter().chain(&row.v[stages..]);
            Some(row) == scheme.stages().last()
                || row.c != 1.0
                || !weights.all(|w| w.is_finite())
                || beyond.any(|w| *w != 0.0)
        };
        if scheme.embedded().is_some_and(useless) {
            return Err(DynamicsError::Table {
                name: scheme.name,
                problem: "its embedded row must end at c = 1 with finite weights of its stages, and differ from that of the scheme",
            });
        }
    }
    match refused(options.newton.relative, options.newton.absolute) {
        Some((name, value)) => refuse(
            name,
            value,
            "it must be finite, and a relative tolerance positive and at most 0.1",
        ),
        None => Ok(()),
    }
}

/// Rejects vectors of the wrong length and numbers that are not finite; accelerations may be missing.
pub(super) fn check_state(state: &State, system: &dyn System) -> Result<(), DynamicsError> {
    let n = system.pattern().dim();
    let refuse = |what, problem| Err(DynamicsError::Initial { what, problem });
    if !state.t.is_finite() {
        return refuse("time", format!("it is {}", state.t));
    }
    if n == 0 {
        return refuse("coordinates", "the system has none".to_owned());
    }
    for (i, info) in system.pattern().coordinates().iter().enumerate() {
        if !(info.is_multiplier || (info.size > 0.0 && info.size.is_finite())) {
            let problem = format!("the size of {} is {}", system.name(i), info.size);
            return refuse("coordinates", format!("{problem}: give its positive unit"));
        }
    }
    let fresh = state.a.is_empty();
    for (what, x) in [
        ("coordinates", &state.q),
        ("velocities", &state.v),
        ("accelerations", &state.a),
        ("algorithmic accelerations", &state.algorithmic),
        ("filtered accelerations", &state.filtered),
    ] {
        let empty = fresh && what.ends_with("accelerations");
        if x.len() != n && !empty {
            let problem = format!("{} given where the system has {n} coordinates", x.len());
            return refuse(what, problem);
        }
        if let Some(i) = x.iter().position(|x| !x.is_finite()) {
            return refuse(what, format!("{} is {}", system.name(i), x[i]));
        }
    }
    Ok(())
}
