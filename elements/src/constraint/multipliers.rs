//! A constraint enforced by Lagrange multipliers.

#![allow(non_snake_case)]

use super::{Enforced, Levels, MAX_EQUATIONS, equation, levels, rates, vectors};
use crate::element::{Element, ElementError, Motion, Properties, Response};
use nalgebra::SVector;
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
    h: H,
    names: &'static [&'static str],
}

impl<H: Map<N, M>, const N: usize, const M: usize> Multipliers<H, N, M> {
    /// Enforces the given equations; [`Scaled`](super::Scaled) gives them comparable sizes.
    pub fn new(h: H) -> Self {
        const { assert!(M <= MAX_EQUATIONS, "too many equations") };
        Self { h, names: &[] }
    }

    /// Names the equations, for messages.
    #[must_use]
    pub fn named(self, names: &'static [&'static str]) -> Self {
        Self { names, ..self }
    }
}

impl<H: Map<N, M> + 'static, const N: usize, const M: usize> Element for Multipliers<H, N, M> {
    fn dim(&self) -> usize {
        N + M
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), ElementError> {
        let [x, ..] = vectors::<N>(at);
        let lambda = SVector::<f64, M>::from_column_slice(&at.x[N..]);
        let h = self.h.tangent(at.t, &x);
        let force = h.B.tr_mul(&lambda);
        for (r, f) in out.r.iter_mut().zip(force.iter()) {
            *r -= f;
        }
        for (r, h) in out.r[N..].iter_mut().zip(h.x.iter()) {
            *r -= h;
        }
        if let Some(K) = &mut out.K {
            let n = N + M;
            let K_sigma = self.h.geometric_stiffness(at.t, &x, &lambda);
            for j in 0..N {
                for i in 0..N {
                    K[i + j * n] += K_sigma[(i, j)];
                }
            }
            for i in 0..M {
                for j in 0..N {
                    K[N + i + j * n] += h.B[(i, j)];
                    K[j + (N + i) * n] += h.B[(i, j)];
                }
            }
        }
        if let Some(r_t) = &mut out.r_t {
            // Along t alone: h_t, and the rate of h_xᵀ λ at a fixed λ.
            let still = SVector::zeros();
            let k = self.h.kinematics(at.t, &x, &still, &still);
            let force = k.B_dot.tr_mul(&lambda);
            for (r, f) in r_t.iter_mut().zip(force.iter()) {
                *r -= f;
            }
            for (r, h_dot) in r_t[N..].iter_mut().zip(k.x_dot.iter()) {
                *r -= h_dot;
            }
        }
        Ok(())
    }

    fn enforced(&self) -> Option<&dyn Enforced> {
        Some(self)
    }

    fn properties(&self) -> Properties {
        Properties {
            objective: self.h.is_objective(),
            ..Properties::INTERNAL
        }
    }
}

impl<H: Map<N, M>, const N: usize, const M: usize> Enforced for Multipliers<H, N, M> {
    fn dims(&self) -> (usize, usize) {
        (N, M)
    }

    fn levels(&self, at: &Motion<'_>) -> Levels {
        levels(&self.h, at)
    }

    fn residual(&self, at: &Motion<'_>, h: &mut [f64]) {
        let [x, ..] = vectors::<N>(at);
        h.copy_from_slice(self.h.phi(at.t, &x).as_slice());
    }

    fn rates(&self, at: &Motion<'_>, h_dot: &mut [f64]) {
        rates(&self.h, at, h_dot);
    }

    fn equation(&self, i: usize) -> String {
        equation(self.names, i)
    }

    fn penalty(&self) -> Option<f64> {
        None
    }
}
