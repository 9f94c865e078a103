//! The interface between models and integrators: a second-order equation of motion in charts.
//!
//! ```text
//! r(t, q, q̇, q̈) = f_ext − f_int − f_acc = 0,      K = −∂r/∂q,  C = −∂r/∂q̇,  M = −∂r/∂q̈
//! ```
//!
//! Integrators see only [`System`], never the elements behind it.

mod abilities;

pub use crate::coordinate::{CoordinateInfo, Quantity};
pub use abilities::{Charts, Energetics, Events};

use crate::domain::DomainError;
use crate::sparse::BlockPattern;
use std::ops::Range;

/// Time and state at which a system is evaluated. In statics, t is the load parameter, and v and a
/// are empty.
#[derive(Clone, Copy, Debug)]
pub struct Point<'a> {
    /// Time, or load parameter.
    pub t: f64,
    /// Coordinates in their charts.
    pub q: &'a [f64],
    /// Velocities q̇.
    pub v: &'a [f64],
    /// Accelerations q̈.
    pub a: &'a [f64],
}

impl<'a> Point<'a> {
    /// A static point, without velocities and accelerations.
    pub fn statics(t: f64, q: &'a [f64]) -> Self {
        let none = &[];
        Self {
            t,
            q,
            v: none,
            a: none,
        }
    }

    /// Whether this is a static point, without velocities and accelerations. A system has at least
    /// one unknown, so a state of motion is never empty.
    pub fn is_static(&self) -> bool {
        self.v.is_empty()
    }
}

/// A turn by 2π/`order`, about their common axis, that maps rotating parts of a system on themselves, such as each of N
/// blades on the next one.
#[derive(Clone, Debug, PartialEq)]
pub struct CyclicSymmetry {
    /// Number of such turns in a full one.
    pub order: usize,
    /// The turn of small motions, δq ↦ P δq, of the coordinates of these parts: row, column and value of the entries of P.
    pub turn: Vec<(usize, usize, f64)>,
}

/// Factors c_K, c_C and c_M of the combined tangent S = c_K K + c_C C + c_M M.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// Factor of K = −∂r/∂q.
    pub K: f64,
    /// Factor of C = −∂r/∂q̇.
    pub C: f64,
    /// Factor of M = −∂r/∂q̈.
    pub M: f64,
}

impl Weights {
    /// The static tangent: K alone.
    pub const STATIC: Self = Self {
        K: 1.0,
        C: 0.0,
        M: 0.0,
    };
    /// The damping matrix alone.
    pub const DAMPING: Self = Self {
        K: 0.0,
        C: 1.0,
        M: 0.0,
    };
    /// The mass matrix alone.
    pub const MASS: Self = Self {
        K: 0.0,
        C: 0.0,
        M: 1.0,
    };
    /// K, C and M one by one.
    pub const PARTS: [Self; 3] = [Self::STATIC, Self::DAMPING, Self::MASS];

    /// Which of K, C and M are needed: K alone at rest, M alone, C and M without K, or all.
    pub fn needed(&self, at_rest: bool) -> Range<usize> {
        match at_rest {
            true => 0..1,
            false if self.K != 0.0 => 0..3,
            false if self.C != 0.0 => 1..3,
            false => 2..3,
        }
    }

    /// Whether only the stiffness K is needed.
    pub fn is_static(&self) -> bool {
        self.C == 0.0 && self.M == 0.0
    }
}

/// Output of an evaluation; all of it is overwritten.
pub struct Evaluation<'a> {
    /// Residual covector r.
    pub r: &'a mut [f64],
    /// Combined tangent c_K K + c_C C + c_M M, values in the system's [`BlockPattern`].
    pub S: Option<(Weights, &'a mut [f64])>,
    /// Partial derivative ∂r/∂t at fixed q, where t is the load parameter; statics only.
    pub r_t: Option<&'a mut [f64]>,
    /// The state at which a Newton iteration started. The tangent may use it to converge better; it
    /// then differs by second order in the step.
    pub previous: Option<Point<'a>>,
    /// For consistent accelerations and multipliers, the size h of the next step, zero for impulses:
    /// rows of multipliers hold the second time derivatives −ḧ of their equations instead of −h, and
    /// the matrix of M alone is [M h_xᵀ; h_x 0]. Springs p that are too stiff for such a step may add
    /// their inertia p h², which removes vibrations that the step cannot resolve.
    pub accelerations: Option<f64>,
}

impl<'a> Evaluation<'a> {
    /// The residual alone.
    pub fn residual(r: &'a mut [f64]) -> Self {
        Self {
            r,
            S: None,
            r_t: None,
            previous: None,
            accelerations: None,
        }
    }

    /// The residual and a combined tangent. At a [static point](Point::statics) C and M are those of rest, where t is a mere
    /// parameter: what is prescribed has no rates.
    pub fn with_tangent(r: &'a mut [f64], weights: Weights, S: &'a mut [f64]) -> Self {
        Self {
            S: Some((weights, S)),
            ..Self::residual(r)
        }
    }
}

/// Result of [`Charts::change_charts`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ChartChanges {
    /// Number of coordinate charts that changed.
    pub charts: usize,
    /// Whether the residual may have changed as well, by the chart dependence of the discretisation.
    pub residual: bool,
}

impl ChartChanges {
    /// Changes of this number of charts that keep the residual.
    pub fn of(charts: usize) -> Self {
        let residual = false;
        Self { charts, residual }
    }
}

/// Typical magnitudes per [`Quantity`] (by [`Quantity::index`]), for scale-aware norms and tests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// Magnitude of applied and reaction forces, moments, others at the last evaluation.
    pub force: [f64; 3],
    /// A length of the model.
    pub length: f64,
    /// Shortest and longest lever by which forces and moments are compared; zero and infinity if
    /// there is none.
    pub levers: [f64; 2],
}

impl Scales {
    /// Reference magnitudes of the residuals per [`Quantity`].
    ///
    /// A force counts as a moment over the shortest lever, a moment as a force over the longest. A
    /// pure moment has no force as a reference, and a distant or much larger part must not make a
    /// test coarser.
    pub fn measures(&self) -> [f64; 3] {
        let ([force, moment, other], [shortest, longest]) = (self.force, self.levers);
        let worth_a_force = force.max(moment / longest);
        [worth_a_force, moment.max(force * shortest), other]
    }
}

impl Default for Scales {
    fn default() -> Self {
        Self {
            force: [0.0; 3],
            length: 1.0,
            levers: [0.0, f64::INFINITY],
        }
    }
}

/// Energies and powers of a system at a point. They balance: d/dt (kinetic + stored) = supplied −
/// dissipated.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// Kinetic energy.
    pub kinetic: f64,
    /// Energy stored in elements (strain energy), loads excluded.
    pub stored: f64,
    /// Power of all loads, supports and prescribed coordinates.
    pub supplied: f64,
    /// Power lost in damping, ≥ 0.
    pub dissipated: f64,
    /// Potential of the loads that have one and do not depend on time. Their power is also part of
    /// `supplied`.
    pub potential: f64,
    /// Power of these loads, −d/dt of `potential`; part of `supplied`.
    pub drawn: f64,
}

impl Energies {
    /// Kinetic energy, stored energy and potential: constant if nothing else does work.
    pub fn total(&self) -> f64 {
        self.kinetic + self.stored + self.potential
    }

    /// Rate of [`Energies::total`].
    pub fn power(&self) -> f64 {
        self.supplied - self.drawn - self.dissipated
    }
}

/// A rigid motion of the whole system: velocity of the point at the origin and angular velocity,
/// global components.
pub type RigidRates = [f64; 6];

/// A rigid motion of the whole system along which the momentum changes at a constant rate.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Symmetry {
    /// The motion.
    pub motion: RigidRates,
    /// Power of the constant forces along it, the rate of the momentum; zero if it is conserved.
    pub force: f64,
}

/// Error of an evaluation. An integrator treats it as a failed trial step.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SystemError {
    /// The coordinates are outside the domain of a chart, map or element.
    #[error("{}", why.of(what))]
    Domain {
        /// The node, joint or element.
        what: String,
        /// The limit, or why there is no value.
        why: DomainError,
    },
    /// A residual or tangent is infinite or not a number; solvers find it in tangents.
    #[error(
        "{what} gives a value that is not finite: an input, or a function of a joint, an element or a load, has no \
         value or derivative there (`check` names it)"
    )]
    NotFinite {
        /// The element, load or node.
        what: String,
    },
    /// A slice has the wrong length, or a function of the caller gives a wrong value.
    #[error("{what}: expected {expected}, got {found}")]
    Request {
        /// The slice or value.
        what: &'static str,
        /// The expected value.
        expected: String,
        /// The value found.
        found: String,
    },
}

/// A second-order system in chart coordinates.
///
/// Only the pattern and the evaluation are required. The defaults of the other methods suit a small
/// system on one global chart, such as a pendulum; abilities beyond that are traits of their own.
pub trait System {
    /// Block pattern of all tangents, constant, with the kinds of the coordinates
    /// ([`BlockPattern::coordinates`]).
    fn pattern(&self) -> &BlockPattern;

    /// Fills `out` at the given point.
    ///
    /// # Errors
    /// [`SystemError`] if the point is outside the domain of a chart or gives non-finite values, and if a
    /// slice has the wrong length.
    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError>;

    /// Whether the tangents are symmetric, as with conservative loads.
    fn is_symmetric(&self) -> bool {
        false
    }

    /// Magnitudes found at the last evaluation.
    fn scales(&self) -> Scales {
        Scales::default()
    }

    /// Name of coordinate `i` for messages, such as "node 7, rotation about e3".
    fn name(&self, i: usize) -> String {
        format!("coordinate {i}")
    }

    /// Its charts, if they change.
    fn charts(&mut self) -> Option<&mut dyn Charts> {
        None
    }

    /// Its discontinuities, if there are any.
    fn events(&mut self) -> Option<&mut dyn Events> {
        None
    }

    /// Its energies and momenta, if it provides them.
    fn energetics(&mut self) -> Option<&mut dyn Energetics> {
        None
    }
}
