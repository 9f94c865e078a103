//! Implicit constraints h(t, x) = 0, and the maps that the implicit function theorem gives.
//!
//! A loop of rigid parts has no explicit map x = φ(t, q), but its equations h(t, x) = 0 are easily
//! written, or composed from the maps of its joints. The D = X − rank(h_x) coordinates
//!
//! ```text
//! q = Lᵀ (x − x_ref)
//! ```
//!
//! determine x near a point at which the matrix A = [Lᵀ; h_x] is regular (\[M04\] (171)–(173)). The
//! columns of L are a **chart** of the configurations ([`Choice`]): D unit vectors (the coordinates
//! themselves, *independent* of each other, the others *dependent*), or a basis of the null space of
//! h_x at one point. The equations h(t, p, x) = 0 of a loop also have **parameters** p: prescribed
//! coordinates, the frame that carries the loop. They follow q in the coordinates of the map
//! (q, p) ↦ x. With A⁻¹ = [B | P] and y = (p, x), differentiation gives everything else:
//!
//! ```text
//! ∂x/∂q = B       ∂x/∂p = −P h_p       Z = ∂(p, x)/∂(q, p)
//! ẏ = Z (q̇, ṗ) − (0, P h_t)            ÿ = Z (q̈, p̈) − (0, P (d²h/dt²)|q̈=p̈=0)          (173)
//! Ḃ = −P ḣ_y Z    B̈ = −P (ḧ_y Z + 2 ḣ_y Ż)
//! K_σ(f) = −Zᵀ (Σ λ_i D²h_i) Z,        λ = Pᵀ f
//! ```
//!
//! −λ are the Lagrange multipliers of the constraint under the force f, the same as in other
//! formulations.
//!
//! The condition number of A is monitored at converged states. If that of another chart is better by
//! a factor of 2, the coordinates are reparametrized: x, ẋ and ẍ are kept, and the new coordinates
//! are linear in them. A map ends where A is singular. So that no step passes over such a point and goes on
//! along the branch from which it came, (q, p) may not turn back before a zero of det A to which their
//! velocities lead, by d ln|det A|/dt = tr(A⁻¹ Ȧ).

#![allow(
    clippy::needless_range_loop,
    reason = "matrices in slices are read by their indices"
)]

mod charts;
mod core;
mod dense;
mod derivatives;
mod error;
mod map;
mod names;
mod start;
mod state;
mod walk;

pub use self::core::ImplicitMap;
pub use error::ImplicitError;

use error::EvaluationError;

use crate::map::Map;
use crate::scalar::Scalar;
use nalgebra::SVector;

/// An implicit holonomic constraint: M equations h(t, x) = 0 for X coordinates.
///
/// Only [`Implicit::h`] is required; [`ImplicitMap::of`] is the map.
pub trait Implicit<const X: usize, const M: usize>: Send + Sync {
    /// The left-hand sides of the equations h(t, x) = 0, in any units.
    fn h<S: Scalar>(&self, t: S, x: &SVector<S, X>) -> SVector<S, M>;

    /// See [`Map::is_objective`]: false for equations that are tied to space.
    fn is_objective(&self) -> bool {
        true
    }

    /// Typical size of coordinate `k`, in its unit: 1 for an angle, a length of the mechanism for a
    /// length. Ranks and condition numbers refer to coordinates divided by their sizes.
    fn size(&self, k: usize) -> f64 {
        let _ = k;
        1.0
    }

    /// Name of coordinate `k`, for messages.
    fn coordinate(&self, k: usize) -> String {
        format!("x{}", k + 1)
    }

    /// Name of equation `i`, for messages.
    fn equation(&self, i: usize) -> String {
        format!("h{}", i + 1)
    }
}

/// The left-hand sides of an implicit constraint as a map x ↦ h(t, x), with all derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equations<H>(pub H);

impl<H, const X: usize, const M: usize> Map<X, M> for Equations<H>
where
    H: Implicit<X, M>,
{
    fn phi<S: Scalar>(&self, t: S, x: &SVector<S, X>) -> SVector<S, M> {
        self.0.h(t, x)
    }

    fn is_objective(&self) -> bool {
        self.0.is_objective()
    }
}

/// Selection of the coordinates q of an [`ImplicitMap`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Choice {
    /// D of the coordinates x, those with the best conditioned equations for the others; changed at
    /// a converged state if the condition number of A is better by a factor of 2 for others. If no
    /// split is good, coordinates in the null space.
    #[default]
    Split,
    /// As `Split`, but selected once: for coordinates that are prescribed or have a spring.
    Fixed,
    /// Coordinates in the null space of h_x at one point, changed by the same rule; each has the unit of the coordinate x of which
    /// it has most.
    Tangent,
}

/// One of the unknowns x.
#[derive(Clone, Debug, PartialEq)]
pub struct Unknown {
    /// Name, for messages.
    pub name: String,
    /// Typical size in its unit: 1 for an angle, a length of the mechanism for a length.
    pub size: f64,
    /// Desired initial value.
    pub start: Option<f64>,
    /// Preference as an independent coordinate at the start, from 0 to 1, as far as the condition
    /// number allows.
    pub preference: f64,
}

/// One of the equations h = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Equation {
    /// Name, for messages.
    pub name: String,
    /// Size in its unit: 1 for an angle, a length of the mechanism for a gap; that of its gradient
    /// if `None`.
    pub size: Option<f64>,
}

/// Names, sizes and the choice of coordinates of an [`ImplicitMap`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Description {
    /// The unknowns x.
    pub unknowns: Vec<Unknown>,
    /// First of each three of (p, x) that are a rotation vector; its chart changes at ψ > π.
    pub rotations: Vec<usize>,
    /// The equations.
    pub equations: Vec<Equation>,
    /// Name of the owner of each parameter p, for messages.
    pub parameters: Vec<String>,
    /// Number D of coordinates q, if it is known; else it follows from the rank.
    pub freedoms: Option<usize>,
    /// Selection of the coordinates q.
    pub choice: Choice,
    /// Condition number of A, for each unknown, up to which coordinates are kept even if others are
    /// better: every change costs a scheme some energy.
    pub good_condition: f64,
}
