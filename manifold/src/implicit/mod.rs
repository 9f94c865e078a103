//! Implicit constraints h(t, x) = 0, and the maps that the implicit function theorem gives.
//!
//! A loop of rigid parts has no explicit map x = φ(t, q), but its equations h(t, x) = 0 are easily
//! written. Near a point at which h_x has full rank the D = X − rank coordinates
//!
//! ```text
//! q = Lᵀ (x − x_ref)
//! ```
//!
//! determine x if the matrix A = [Lᵀ; h_x] is regular there (\[M04\] (171)–(173)). The columns of L
//! are a **chart** of the configurations ([`Choice`]): D unit vectors (the coordinates themselves,
//! *independent* of each other, the others *dependent*), or a basis of the null space of h_x at one
//! point. With A⁻¹ = [B | P], differentiation of h(t, φ(t, q)) = 0 gives everything else:
//!
//! ```text
//! D_q φ = B       ẋ = B q̇ − P h_t       ẍ = B q̈ − P (d²h/dt²)|ẍ=0                    (173)
//! Ḃ = −P (h_x)˙ B       B̈ = −P [(h_x)¨ B + 2 (h_x)˙ Ḃ]
//! K_σ(f) = −Bᵀ (Σ λ_i D²h_i) B,       λ = Pᵀ f
//! ```
//!
//! −λ are the Lagrange multipliers of the constraint under the force f, the same as in other
//! formulations.
//!
//! The condition number of A is monitored at converged states. If another choice of L is better by
//! more than [`GAIN`], the coordinates are reparametrized ([`crate::map::Reparametrized`]): x, ẋ
//! and ẍ are kept, and the new coordinates are linear in them.

#![allow(non_snake_case)]

mod assemble;
mod chart;
pub mod closed;
mod error;
mod factor;
mod map;
mod names;
mod solve;

pub use closed::Closed;
pub use error::{DomainError, ImplicitError};
pub use solve::Solved;

use crate::map::Map;
use crate::scalar::Scalar;
use nalgebra::SVector;

/// Gain in the condition number of A that triggers a change of chart (hysteresis). [`Closed`] also
/// keeps charts that are good enough.
pub const GAIN: f64 = 2.0;

/// An implicit holonomic constraint: M equations h(t, x) = 0 for X coordinates.
///
/// Only [`Implicit::h`] is required; [`Solved`] is the map.
pub trait Implicit<const X: usize, const M: usize>: Send + Sync {
    /// The left-hand sides of the equations h(t, x) = 0, in any units.
    fn h<S: Scalar>(&self, t: S, x: &SVector<S, X>) -> SVector<S, M>;

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

impl<H: Implicit<X, M>, const X: usize, const M: usize> Implicit<X, M> for &H {
    fn h<S: Scalar>(&self, t: S, x: &SVector<S, X>) -> SVector<S, M> {
        (**self).h(t, x)
    }

    fn size(&self, k: usize) -> f64 {
        (**self).size(k)
    }

    fn coordinate(&self, k: usize) -> String {
        (**self).coordinate(k)
    }

    fn equation(&self, i: usize) -> String {
        (**self).equation(i)
    }
}

/// Selection of the coordinates q of a [`Solved`] constraint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Choice {
    /// D of the coordinates x, those with the best conditioned equations for the others; changed at
    /// a converged state if others are better by more than [`GAIN`].
    #[default]
    Split,
    /// As `Split`, but selected once: for coordinates that are prescribed or have a spring.
    Fixed,
    /// Coordinates in the null space of h_x at one point, changed by the same rule: for
    /// configurations at which no split is good.
    Tangent,
}

/// The left-hand sides of an implicit constraint as a map x ↦ h(t, x), with all derivatives, for
/// other methods of enforcing them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equations<H>(pub H);

impl<H, const X: usize, const M: usize> Map<X, M> for Equations<H>
where
    H: Implicit<X, M>,
{
    fn phi<S: Scalar>(&self, t: S, x: &SVector<S, X>) -> SVector<S, M> {
        self.0.h(t, x)
    }
}
