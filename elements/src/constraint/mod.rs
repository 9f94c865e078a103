//! Constraints h(t, x) = 0 that are enforced by forces, not by coordinates.
//!
//! The equations of a map ([`ImplicitMap`](pullback_manifold::implicit::ImplicitMap)) can also be
//! enforced by the solver:
//!
//! | method | element | unknowns | what is exact |
//! |---|---|---|---|
//! | map | none: x = φ(t, q) | X − rank | h = 0 at every state, velocities, accelerations |
//! | multipliers | [`Multipliers`] | X + M | h = 0 at converged states; index 3 |
//! | penalty | [`Penalty`] | X | nothing: h is of order 1/p |
//!
//! h is a [`Map`] from the coordinates of the element's nodes to its M residuals, written once, and evaluated in its domain
//! only; in an element it has no [state](pullback_manifold::map::MapState), and stays in the piece of its start;
//! h_x, Σ λᵢ D²hᵢ, ḣ and ḧ are its derivatives as a map. Divide each equation by its size, so that "closed to 10⁻¹²" means the
//! same for a length, an angle and a length squared. The solvers equilibrate rows and columns of multipliers, so that neither the
//! step size nor the unit of λ affects conditioning (\[Bottasso2007\]).

mod multipliers;
mod penalty;

pub use multipliers::Multipliers;
pub use penalty::{Penalty, PenaltyError, PenaltyStiffness};

use crate::element::{Motion, Properties};
use nalgebra::SVector;
use pullback_manifold::map::Map;

/// Largest number of equations of one constraint.
pub const MAX_EQUATIONS: usize = 32;

/// Equations of an element at one motion, with their derivatives in time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Levels {
    /// h (M).
    pub h: Vec<f64>,
    /// ḣ along the motion (M).
    pub h_dot: Vec<f64>,
    /// ḧ along the motion (M).
    pub h_ddot: Vec<f64>,
    /// h_x, M×N, column by column.
    pub J: Vec<f64>,
}

/// An element that enforces equations h(t, x) = 0 on its first N coordinates; an initial state must
/// satisfy them.
pub trait Enforced: Send + Sync {
    /// (N, M): number of coordinates in the equations and number of equations.
    fn dims(&self) -> (usize, usize);

    /// Writes the equations at a motion of the element's coordinates; missing velocities and accelerations
    /// are zero.
    fn levels(&self, at: &Motion<'_>, out: &mut Levels);

    /// Writes h (M) alone.
    fn residual(&self, at: &Motion<'_>, h: &mut [f64]);

    /// Name of equation `i`, for messages.
    fn equation(&self, i: usize) -> String;

    /// Stiffness of a penalty; `None` if the last M coordinates of the element are multipliers.
    fn penalty(&self) -> Option<f64>;
}

/// The equations of a map, with names for messages.
#[derive(Clone, Copy, Debug, PartialEq)]
struct NamedEquations<H, const N: usize, const M: usize> {
    h: H,
    names: &'static [&'static str],
    penalty: Option<f64>,
}

impl<H: Map<N, M>, const N: usize, const M: usize> NamedEquations<H, N, M> {
    fn new(h: H, penalty: Option<f64>) -> Self {
        const { assert!(M <= MAX_EQUATIONS, "too many equations") };
        Self {
            h,
            names: &[],
            penalty,
        }
    }

    fn properties(&self) -> Properties {
        Properties {
            objective: self.h.is_objective(),
            ..Properties::INTERNAL
        }
    }
}

impl<H: Map<N, M>, const N: usize, const M: usize> Enforced for NamedEquations<H, N, M> {
    fn dims(&self) -> (usize, usize) {
        (N, M)
    }

    fn levels(&self, at: &Motion<'_>, out: &mut Levels) {
        let [x, v, a] = vectors(at);
        let k = self.h.kinematics(at.t, &x, &v, &a);
        let Levels {
            h,
            h_dot,
            h_ddot,
            J,
        } = out;
        let orders = [(h, k.x), (h_dot, k.x_dot), (h_ddot, k.x_ddot)];
        for (out, values) in orders {
            out.clear();
            out.extend(&values);
        }
        J.clear();
        J.extend(&k.B);
    }

    fn residual(&self, at: &Motion<'_>, h: &mut [f64]) {
        let [x, ..] = vectors(at);
        h.copy_from_slice(self.h.phi(at.t, &x).as_slice());
    }

    fn equation(&self, i: usize) -> String {
        match self.names.get(i) {
            Some(name) => (*name).to_owned(),
            None => format!("equation {}", i + 1),
        }
    }

    fn penalty(&self) -> Option<f64> {
        self.penalty
    }
}

/// The first N coordinates, velocities and accelerations of a motion; zero if missing.
fn vectors<const N: usize>(at: &Motion<'_>) -> [SVector<f64, N>; 3] {
    [at.x, at.v, at.a].map(|x| SVector::from_fn(|i, _| x.get(i).copied().unwrap_or(0.0)))
}
