//! What an integrator solves: a second-order equation of motion in chart coordinates.
//!
//! ```text
//! r(t, q, q̇, q̈) = f_ext − f_int − f_acc = 0,      K = −∂r/∂q,  C = −∂r/∂q̇,  M = −∂r/∂q̈
//! ```
//!
//! Integrators see only [`System`]; they never know what a beam is.

#![allow(non_snake_case)]

use crate::sparse::BlockPattern;

/// Time and state at which a system is evaluated. In statics t is the load parameter, and
/// velocities and accelerations are empty.
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

impl Point<'_> {
    /// Whether this is statics: without velocities and accelerations. Systems have at least one
    /// unknown, so that a motion always has some.
    pub fn is_static(&self) -> bool {
        self.v.is_empty()
    }
}

/// Factors of the combined tangent S = K·(∂r/∂q part) + C·(...) + M·(...).
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
    /// The mass matrix alone.
    pub const MASS: Self = Self {
        K: 0.0,
        C: 0.0,
        M: 1.0,
    };

    /// Whether only the stiffness is asked for.
    pub fn is_static(&self) -> bool {
        self.C == 0.0 && self.M == 0.0
    }
}

/// Where an evaluation goes; everything is overwritten.
pub struct Evaluation<'a> {
    /// Residual covector r.
    pub r: &'a mut [f64],
    /// Combined tangent cK·K + cC·C + cM·M, values in the system's [`BlockPattern`].
    pub S: Option<(Weights, &'a mut [f64])>,
    /// Partial derivative ∂r/∂t at fixed q, in statics only: with t as the load parameter.
    pub r_t: Option<&'a mut [f64]>,
}

impl<'a> Evaluation<'a> {
    /// The residual alone.
    pub fn residual(r: &'a mut [f64]) -> Self {
        Self {
            r,
            S: None,
            r_t: None,
        }
    }

    /// The residual and a combined tangent.
    pub fn with_tangent(r: &'a mut [f64], weights: Weights, S: &'a mut [f64]) -> Self {
        Self {
            r,
            S: Some((weights, S)),
            r_t: None,
        }
    }
}

/// What [`System::change_charts`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ChartChanges {
    /// Number of charts of coordinates that changed.
    pub charts: usize,
    /// Whether residuals may have changed too, by as much as the discretisation depends on charts.
    pub residual: bool,
}

/// What a coordinate measures; its conjugate residual is then a force, a moment, or neither.
/// Convergence tests and norms keep the quantities apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// A length; the residual is a force.
    Length,
    /// An angle or rotation vector component; the residual is a moment.
    Angle,
    /// Anything else.
    Other,
}

impl Quantity {
    /// All quantities, in the order of their indices.
    pub const ALL: [Self; 3] = [Self::Length, Self::Angle, Self::Other];

    /// Index in [`Quantity::ALL`].
    pub fn index(self) -> usize {
        self as usize
    }

    /// Name of the conjugate residual.
    pub fn conjugate(self) -> &'static str {
        match self {
            Self::Length => "force",
            Self::Angle => "moment",
            Self::Other => "residual",
        }
    }
}

/// Typical magnitudes per [`Quantity`] (index [`Quantity::index`]) that make norms and tests scale-aware.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// Magnitude of applied and reaction forces, moments, others at the last evaluation.
    pub force: [f64; 3],
    /// Typical size of coordinates: a length of the model, one radian, one.
    pub coordinate: [f64; 3],
    /// Shortest and longest lever over which forces and moments are compared; zero and infinite
    /// where there is none.
    pub levers: [f64; 2],
}

impl Scales {
    /// What residuals per [`Quantity`] are measured by.
    ///
    /// A force is worth a moment over the shortest lever, a moment is worth a force over the longest
    /// one: a pure moment has no force to be relative to, and a part that is far away or much larger
    /// makes no test coarser.
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
            coordinate: [1.0; 3],
            levers: [0.0, f64::INFINITY],
        }
    }
}

/// Energies and powers of a system at a point, with which a run in time can be audited:
/// d/dt (kinetic + stored) = supplied − dissipated.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// Kinetic energy.
    pub kinetic: f64,
    /// Energy stored in elements (strain energy), loads excluded.
    pub stored: f64,
    /// Power of all loads, supports and driven coordinates on the system.
    pub supplied: f64,
    /// Power lost in damping, ≥ 0.
    pub dissipated: f64,
    /// Potential of the loads that have one and do not depend on time. What they supply is part of
    /// `supplied` all the same.
    pub potential: f64,
    /// That part of `supplied`: −d/dt of `potential`.
    pub drawn: f64,
}

impl Energies {
    /// Kinetic energy, stored energy and potential: what stays where nothing else works.
    pub fn total(&self) -> f64 {
        self.kinetic + self.stored + self.potential
    }

    /// Rate of [`Energies::total`].
    pub fn power(&self) -> f64 {
        self.supplied - self.drawn - self.dissipated
    }
}

/// A motion of the whole as a rigid body: the velocity of the point at the origin, and the angular
/// velocity, global components.
pub type RigidRates = [f64; 6];

/// A rigid motion of the whole along which the momentum changes at a constant rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Symmetry {
    /// The motion.
    pub motion: RigidRates,
    /// Power of constant forces along it, and so the rate of the momentum; zero where it is kept.
    pub force: f64,
}

/// What coordinates leave when a step is too large for their chart; smaller ones help, if there are
/// any.
pub const CHART_EDGE: &str = "the domain of its chart (it moved or turned too far at once)";

/// Why a system cannot be evaluated at a point. An integrator takes it as a failed trial step.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SystemError {
    /// Coordinates have left the domain of their chart or map.
    #[error("{what} left {edge}{}", if *edge == CHART_EDGE { ": take smaller steps" } else { "" })]
    OutsideChart {
        /// What it left, and what to do about it where it is not [`CHART_EDGE`].
        edge: &'static str,
        /// The node or joint.
        what: String,
        /// Distance to the edge of validity, ≤ 0.
        margin: f64,
    },
    /// Coordinates ask for what the equations behind a map do not allow.
    #[error("{what}: {why}")]
    Unsolved {
        /// The joint.
        what: String,
        /// Why, and what to do about it.
        why: String,
    },
    /// A residual or tangent came out infinite or not a number.
    #[error(
        "{what} gives a value that is not finite: a function of a joint, an element or a load has no \
         value or derivative there (`check` names it)"
    )]
    NotFinite {
        /// The element, load or node.
        what: String,
    },
    /// The caller asks for what a point does not hold, or hands over a slice of another length.
    #[error("{what}: expected {expected}, got {found}")]
    Request {
        /// The slice or value.
        what: &'static str,
        /// What it has to be.
        expected: String,
        /// What it is.
        found: String,
    },
}

/// A second-order system in chart coordinates, as integrators see it.
///
/// Required: the pattern and the evaluation. Everything else has a default that is right for a
/// small system on one global chart, a pendulum of thirty lines, say.
pub trait System {
    /// Block pattern of all tangents; its dimension is the number of coordinates. Never changes.
    fn pattern(&self) -> &BlockPattern;

    /// Fills `out` at the given point.
    ///
    /// # Errors
    /// [`SystemError`] when the point is outside the domain of a chart or gives non-finite values, when
    /// C or M is asked for at a static point, and when a slice has a wrong length.
    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError>;

    /// As [`System::evaluate`], in a Newton iteration that came from the state `previous`: the
    /// tangent may use this to be a better guide, at a difference of the second order in the step.
    /// Ignored by default.
    ///
    /// # Errors
    /// As [`System::evaluate`].
    fn evaluate_from(
        &mut self,
        previous: Point<'_>,
        at: Point<'_>,
        out: Evaluation<'_>,
    ) -> Result<(), SystemError> {
        let _ = previous;
        self.evaluate(at, out)
    }

    /// As [`System::evaluate`], for accelerations (and multipliers) that fit a state: the rows of
    /// multipliers hold the second time derivatives −ḧ of their equations in place of −h, and the
    /// matrix of M alone is [M h_xᵀ; h_x 0]. Springs much stiffer than a step of size `h` resolves
    /// may do the same by their inertia p h², which leaves out vibrations that the step cannot show;
    /// `h` is zero where impulses are asked for. For a system without such things that is the
    /// evaluation itself, and the default.
    ///
    /// # Errors
    /// As [`System::evaluate`].
    fn evaluate_accelerations(
        &mut self,
        at: Point<'_>,
        h: f64,
        out: Evaluation<'_>,
    ) -> Result<(), SystemError> {
        let _ = h;
        self.evaluate(at, out)
    }

    /// Whether coordinate `i` is a Lagrange multiplier: an unknown without mass whose row of the
    /// residual is an equation of the coordinates. Its velocity and acceleration mean nothing, and
    /// its momentum is the rate ḣ of the equation. None is by default.
    fn is_multiplier(&self, i: usize) -> bool {
        let _ = i;
        false
    }

    /// Changes charts where that is due, after a converged step at time `t`.
    ///
    /// Transforms the coordinates `q`, a velocity-like vector `v` and any number of
    /// acceleration-like vectors (ä ↦ B a + Ḃ v) in place.
    fn change_charts(
        &mut self,
        t: f64,
        q: &mut [f64],
        v: &mut [f64],
        accelerations: &mut [&mut [f64]],
    ) -> ChartChanges {
        let _ = (t, q, v, accelerations);
        ChartChanges::default()
    }

    /// By what time the first change of the system's maps is overdue at the end of a step between two
    /// points in motion, negative before that. A change that leaves values as they are, but not their
    /// derivatives, costs a step that crosses it its order: the step is made to end there.
    /// `None` where none lies ahead, and by default.
    fn overshoot(&mut self, from: Point<'_>, to: Point<'_>) -> Option<f64> {
        let _ = (from, to);
        None
    }

    /// The next [`System::change_charts`] makes the changes that are overdue by the time `since` at
    /// least ([`System::overshoot`]).
    fn change_segments(&mut self, from: Point<'_>, to: Point<'_>, since: f64) {
        let _ = (from, to, since);
    }

    /// A run starts from `q` at time `t`, or goes on from there after a step that failed: a system
    /// that remembers more of its way than its coordinates takes what belongs to this state.
    /// Nothing by default.
    fn start(&mut self, t: f64, q: &[f64]) {
        let _ = (t, q);
    }

    /// What makes steps from the last converged state fail though the system can be evaluated there, in
    /// words for the report of a failure: a mechanism close to a singular configuration, say.
    fn singularity_warnings(&self) -> Vec<String> {
        Vec::new()
    }

    /// Times at which a prescribed function has a kink: a derivative jumps there, so that a time
    /// step may end there but not cross it. In any order, possibly repeated; none by default.
    fn kinks(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Values that are set from outside while a run goes on. Where one has changed between two steps
    /// accelerations jump, as behind a kink. None by default.
    fn inputs(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Energies and powers at a point in motion; `None` for a system that does not know them.
    ///
    /// # Errors
    /// As [`System::evaluate`].
    fn energies(&mut self, at: Point<'_>) -> Result<Option<Energies>, SystemError> {
        let _ = at;
        Ok(None)
    }

    /// The generalised momentum p = ∂T/∂q̇ at a point in motion, into `p`; false (and `p`
    /// untouched) for a system whose momentum does not depend on t at fixed q and q̇.
    ///
    /// Where a driven velocity jumps, p does not: the free velocities take the impulse.
    ///
    /// # Errors
    /// As [`System::evaluate`].
    fn momentum(&mut self, at: Point<'_>, p: &mut [f64]) -> Result<bool, SystemError> {
        let _ = (at, p);
        Ok(false)
    }

    /// The momentum that the last change of charts has to keep, into `p`, where it has handed a map
    /// over whose values stay and whose operator jumps from B₋ to B₊: that before the change, or at a
    /// point behind it. False where it has not.
    ///
    /// It is ½ (B₊ + B₋)ᵀ M ẋ: what is handed over goes on as along a curve that the corner stands for,
    /// however the whole moves, while B₋ᵀ M ẋ₋ = B₊ᵀ M ẋ₊ depends on who looks.
    ///
    /// # Errors
    /// As [`System::evaluate`].
    fn kept_momentum(&mut self, at: Option<Point<'_>>, p: &mut [f64]) -> Result<bool, SystemError> {
        let _ = (at, p);
        Ok(false)
    }

    /// Symmetries of the system: a basis of those motions of the whole as a rigid body (velocity of
    /// the origin, angular velocity) along which steady loads have a constant power and neither other
    /// forces nor constraints do work between two times, looked for around the state q, q̇. None by
    /// default.
    fn symmetries(&mut self, span: [f64; 2], q: &[f64], v: &[f64]) -> Vec<Symmetry> {
        let _ = (span, q, v);
        Vec::new()
    }

    /// The rates of all coordinates in a rigid motion that [`System::symmetries`] has found, or in a
    /// sum of such, at q.
    fn rigid_rates(&self, q: &[f64], motion: &RigidRates, rates: &mut [f64]) {
        let _ = (q, motion);
        rates.fill(0.0);
    }

    /// Whether the tangents are symmetric (conservative loads).
    fn is_symmetric(&self) -> bool {
        false
    }

    /// What coordinate `i` measures.
    fn quantity(&self, i: usize) -> Quantity {
        let _ = i;
        Quantity::Other
    }

    /// Name of coordinate `i` for messages, such as "node 7, rotation about e3".
    fn name(&self, i: usize) -> String {
        format!("coordinate {i}")
    }

    /// Size of the numbers that coordinate `i` is added to, such as a position in space: the rounding
    /// errors of the sum are theirs. The scale of its quantity by default.
    fn magnitude(&self, i: usize) -> f64 {
        self.scales().coordinate[self.quantity(i).index()]
    }

    /// Magnitudes found at the last evaluation.
    fn scales(&self) -> Scales {
        Scales::default()
    }
}
