//! Errors of an integration in time.

use crate::failure::{FailedStep, names};
use crate::linear_solver::LinearError;
use crate::significant;
use pullback_manifold::system::SystemError;

/// Error of an integration in time.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
#[non_exhaustive]
pub enum DynamicsError {
    /// A parameter of a scheme outside its range.
    #[error(
        "{name} = {value:?} is outside its range [{}, {}]",
        significant(*from), significant(*to)
    )]
    Parameter {
        name: &'static str,
        value: f64,
        from: f64,
        to: f64,
    },
    /// No scheme has this name with these numbers.
    #[error("scheme `{word}`: {problem}")]
    Word { word: String, problem: String },
    /// An invalid table of a scheme.
    #[error("the table of the scheme {name} cannot be used: {problem}")]
    Table {
        name: &'static str,
        problem: &'static str,
    },
    /// A step beyond the stability limit of a scheme.
    #[error(
        "step {step:?} is too large for {scheme}, which is stable for steps of at most \
         {stable:.6e} here: the largest frequency is {frequency:.6e} ({what} is stiffest \
         for its mass); take smaller steps (those of `adaptive` by `max_step`), or a scheme that \
         is stable at every step"
    )]
    StepTooLarge {
        scheme: &'static str,
        step: f64,
        stable: f64,
        /// Largest frequency ω of K and M at the start.
        frequency: f64,
        /// The coordinate with the largest ratio of stiffness to mass.
        what: String,
    },
    /// Coordinates without mass in a scheme with a stability limit.
    #[error(
        "{scheme} needs mass in every coordinate: {source}{}; give these coordinates mass, or take \
         a scheme that is stable at every step",
        names(mechanism)
    )]
    Massless {
        scheme: &'static str,
        source: LinearError,
        /// Coordinates without mass, largest component first.
        mechanism: Vec<(String, f64)>,
    },
    /// An energy-conserving scheme for a system that does not provide its energy.
    #[error(
        "{scheme} keeps the energy, and this system does not know its own: implement \
         `Energetics`, or take another scheme"
    )]
    NoEnergy { scheme: &'static str },
    /// An invalid option.
    #[error("option {name} = {value:?} is not usable: {wanted}")]
    Option {
        name: &'static str,
        value: f64,
        wanted: &'static str,
    },
    /// A scheme without damping at infinite frequencies for a system with multipliers.
    #[error(
        "the scheme {scheme} has the spectral radius {rho:.6} at infinite frequencies: it does not \
         damp the oscillations that constraints enforced by multipliers ({multiplier}) bring in \
         (index 3; Arnold & Brüls 2007). Choose generalised-alpha, HHT or WBZ with a radius below \
         1, such as ga:0.8, or close the loop by a map"
    )]
    Undamped {
        scheme: &'static str,
        rho: f64,
        /// The first multiplier.
        multiplier: String,
    },
    /// Values to begin with, at the start or after an event, of the wrong length, or not finite.
    #[error("{what} to begin with: {problem}")]
    Initial { what: &'static str, problem: String },
    /// There is no linear solver for the pattern.
    #[error("the linear solver cannot take this model: {source}")]
    Analysis { source: LinearError },
    /// The system cannot be evaluated at a converged state.
    #[error("at time {}: {source}", significant(*t))]
    System { t: f64, source: SystemError },
    /// No accelerations satisfy the equations of motion.
    #[error(
        "no consistent accelerations at time {}: {source}{}; give these coordinates mass \
         (rotations: inertia) or stiffness, or hold them",
        significant(*t), names(mechanism)
    )]
    Accelerations {
        t: f64,
        source: LinearError,
        /// Coordinates without mass, largest component first.
        mechanism: Vec<(String, f64)>,
    },
    /// The energy grows without bounds: the step does not resolve what the scheme cannot damp.
    #[error(
        "the motion is unstable: at time {} {}; take smaller steps, or a scheme that damps high frequencies \
         (more). Where that makes no difference the model itself is unstable: see whether a stiffness or a \
         damping is negative, or an element supplies work and is not declared a load", significant(*t), grown(*energy, *known)
    )]
    Unstable {
        t: f64,
        /// Kinetic and stored energy.
        energy: f64,
        /// Energy at the start, and the sum of the magnitudes of the work since.
        known: f64,
    },
    /// A step failed down to the smallest step size.
    #[error("{0}")]
    Step(Box<FailedStep>),
}

impl DynamicsError {
    /// Converts an error of an evaluation at a time.
    pub(super) fn at(t: f64) -> impl Fn(SystemError) -> Self {
        move |source| Self::System { t, source }
    }
}

fn grown(energy: f64, known: f64) -> String {
    if energy.is_finite() && known.is_finite() {
        format!("it has the energy {energy:.3e} where {known:.3e} has ever been there or supplied")
    } else {
        "its energy is beyond all numbers".to_owned()
    }
}
