//! A constraint enforced by Lagrange multipliers.

use super::{NamedEquations, vectors};
use crate::blocks::{add, add_block};
use crate::element::{Abilities, Element, Motion, Properties, Response};
use nalgebra::SVector;
use pullback_manifold::domain::DomainError;
use pullback_manifold::map::Map;

/// The equations h(t, x) = 0 with multipliers λ that are unknowns of the model:
///
/// ```text
/// r_x = −h_xᵀ λ        r_λ = −h        K = [Σ λᵢ D²hᵢ  h_xᵀ; h_x  0],  symmetric
/// ```
///
/// Coordinates are those of the nodes in the equations, N in all, followed by those of a node of
/// multipliers (M, [`ModelBuilder::multipliers`](crate::model::ModelBuilder::multipliers)). The
/// equations of motion have index 3 and need a scheme with damping at infinite frequencies
/// (\[ArnoldBruls2007\]): q, q̇ and λ are then of order 2. h_xᵀ λ are the constraint forces, so λ
/// has the unit of a force times that of x over that of h.
///
/// The energy balance does not include the power of equations that depend on time explicitly.
/// A model omits redundant equations, and sets their multipliers to zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Multipliers<H, const N: usize, const M: usize> {
    equations: NamedEquations<H, N, M>,
}

impl<H: Map<N, M>, const N: usize, const M: usize> Multipliers<H, N, M> {
    /// Enforces the given equations, divided by their sizes.
    pub fn new(h: H) -> Self {
        Self {
            equations: NamedEquations::new(h, None),
        }
    }

    /// Names the equations, for messages.
    #[must_use]
    pub fn named(mut self, names: &'static [&'static str]) -> Self {
        self.equations.names = names;
        self
    }
}

impl<H: Map<N, M> + 'static, const N: usize, const M: usize> Element for Multipliers<H, N, M> {
    fn dim(&self) -> usize {
        N + M
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        let [x, ..] = vectors::<N>(at);
        self.equations.h.domain(at.t, &x)?;
        let lambda = SVector::<f64, M>::from_column_slice(&at.x[N..]);
        let h = self.equations.h.tangent(at.t, &x);
        add(out.r, 0, &-h.B.tr_mul(&lambda));
        add(out.r, N, &-h.x);
        if let Some(K) = &mut out.K {
            let n = N + M;
            let K_sigma = self.equations.h.geometric_stiffness(at.t, &x, &lambda);
            add_block(K, n, 0, 0, &K_sigma);
            add_block(K, n, N, 0, &h.B);
            add_block(K, n, 0, N, &h.B.transpose());
        }
        if let Some(r_t) = &mut out.r_t {
            // Along t alone: h_t, and the rate of h_xᵀ λ at a fixed λ.
            let still = SVector::zeros();
            let k = self.equations.h.kinematics(at.t, &x, &still, &still);
            add(r_t, 0, &-k.B_dot.tr_mul(&lambda));
            add(r_t, N, &-k.x_dot);
        }
        Ok(())
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities {
            enforced: Some(&self.equations),
            ..Abilities::default()
        }
    }

    fn properties(&self) -> Properties {
        self.equations.properties()
    }
}
