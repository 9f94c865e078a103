//! Redundant equations in the residual of an element.

use crate::constraint::MAX_EQUATIONS;
use crate::element::Response;
use crate::model::ElementEntry;

/// The omitted equations of an element: their multipliers λ are zero, with the rows −λ.
pub(in crate::model) struct Omitted {
    equations: u32,
    /// Number of coordinates before the multipliers.
    first: usize,
    lambda: [f64; MAX_EQUATIONS],
}

impl Omitted {
    /// Removes the multipliers of the omitted equations from the coordinates.
    pub fn of(e: &ElementEntry, equations: u32, x: &mut [f64]) -> Option<Self> {
        if equations == 0 {
            return None;
        }
        let (first, count) = e.element.abilities().enforced?.dims();
        let mut lambda = [0.0; MAX_EQUATIONS];
        for i in (0..count).filter(|i| equations & (1 << i) != 0) {
            lambda[i] = std::mem::take(&mut x[first + i]);
        }
        Some(Self {
            equations,
            first,
            lambda,
        })
    }

    /// Restores them, and replaces the equations.
    pub fn replace(&self, x: &mut [f64], out: &mut Response<'_>) {
        let n = out.r.len();
        for i in (0..MAX_EQUATIONS).filter(|i| self.equations & (1 << i) != 0) {
            let row = self.first + i;
            x[row] = self.lambda[i];
            out.r[row] = -self.lambda[i];
            if let Some(r_t) = &mut out.r_t {
                r_t[row] = 0.0;
            }
            if let Some(K) = &mut out.K {
                for k in 0..n {
                    K[row + k * n] = 0.0;
                    K[k + row * n] = 0.0;
                }
                K[row + row * n] = 1.0;
            }
        }
    }
}
