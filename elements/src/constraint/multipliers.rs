//! A constraint enforced by Lagrange multipliers.

#![allow(non_snake_case)]

use super::{Enforced, Levels, MAX_EQUATIONS, equation, levels, rates, vectors};
use crate::element::{Element, ElementError, Motion, Response};
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
/// Omitted equations ([`Enforced::leave_out`]) have zero multipliers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Multipliers<H, const N: usize, const M: usize> {
    h: H,
    left_out: u32,
    names: &'static [&'static str],
}

impl<H: Map<N, M>, const N: usize, const M: usize> Multipliers<H, N, M> {
    /// Enforces the given equations; [`Scaled`](super::Scaled) gives them comparable sizes.
    pub fn new(h: H) -> Self {
        const { assert!(M <= MAX_EQUATIONS, "too many equations") };
        Self {
            h,
            left_out: 0,
            names: &[],
        }
    }

    /// Names the equations, for messages.
    #[must_use]
    pub fn named(self, names: &'static [&'static str]) -> Self {
        Self { names, ..self }
    }

    /// Whether equation i is in use.
    fn counts(&self, i: usize) -> bool {
        self.left_out & (1 << i) == 0
    }
}

impl<H: Map<N, M> + 'static, const N: usize, const M: usize> Element for Multipliers<H, N, M> {
    fn dim(&self) -> usize {
        N + M
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), ElementError> {
        let [x, ..] = vectors::<N>(at);
        let given = &at.x[N..];
        let lambda = SVector::<f64, M>::from_fn(|i, _| if self.counts(i) { given[i] } else { 0.0 });
        let h = self.h.tangent(at.t, &x);
        let force = h.B.tr_mul(&lambda);
        for (r, f) in out.r.iter_mut().zip(force.iter()) {
            *r -= f;
        }
        for (i, (r, given)) in out.r[N..].iter_mut().zip(given).enumerate() {
            *r -= if self.counts(i) { h.x[i] } else { *given };
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
                if !self.counts(i) {
                    K[(N + i) * (n + 1)] += 1.0;
                    continue;
                }
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
            for i in (0..M).filter(|&i| self.counts(i)) {
                r_t[N + i] -= k.x_dot[i];
            }
        }
        Ok(())
    }

    fn is_objective(&self) -> bool {
        self.h.is_objective()
    }

    fn enforced(&self) -> Option<&dyn Enforced> {
        Some(self)
    }

    fn enforced_mut(&mut self) -> Option<&mut dyn Enforced> {
        Some(self)
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

    fn leave_out(&mut self, equations: u32) {
        self.left_out = equations;
    }

    fn left_out(&self) -> u32 {
        self.left_out
    }
}
