//! The solution and its derivatives: [M04] (172)–(173) along a motion.

use super::core::{ImplicitMap, RANK, Work};
use super::dense::{product, product_tr};
use super::map::advised;
use crate::domain::DomainError;
use crate::map::{MapState, Order, Parametrization};
use nalgebra::{DMatrix, DVector};

/// Limit of an implicit map in messages.
const ALLOWED: &str = "the positions that its equations allow";

impl Parametrization for ImplicitMap {
    fn kind(&self) -> &'static str {
        self.h.kind()
    }

    fn dims(&self) -> (usize, usize) {
        (self.D + self.p, self.X)
    }

    fn is_objective(&self) -> bool {
        self.h.is_objective()
    }

    fn domain(&mut self, t: f64, q: &[f64]) -> Result<f64, DomainError> {
        match self.solve(t, q) {
            Ok(()) => {
                let margin = DomainError::within(1.0 / self.work.condition - RANK, ALLOWED)?;
                // Where the equations are evaluated already.
                Ok(margin.min(self.h.domain(t, &self.work.linearised)?))
            }
            Err(error) => Err(DomainError::Undefined(advised(error))),
        }
    }

    fn evaluate(&mut self, t: f64, [q, v, a]: [&[f64]; 3], out: &mut [Order<'_>]) {
        if self.solve(t, q).is_err() {
            out.iter_mut()
                .flatten()
                .for_each(|part| part.fill(f64::NAN));
            return;
        }
        let [[x, B], rates @ ..] = out else { return };
        x.copy_from_slice(self.x());
        B.copy_from_slice(&self.work.Y);
        let [[x_dot, B_dot], [x_ddot, B_ddot]] = rates else {
            return;
        };
        let (p, X, M, D) = (self.p, self.X, self.M, self.D);
        let (N, Q) = (p + X, D + p);
        self.find_rates(t, v);
        self.find_accelerations(a);
        let w = &mut self.work;
        x_dot.copy_from_slice(&w.y_dot[p..]);
        x_ddot.copy_from_slice(&w.y_ddot[p..]);
        if w.y_ddot.iter().any(|y| *y != 0.0) {
            along(&mut *self.h, t, w);
        }
        // Ḃ = −P ḣ_y Z; B̈ = −P (ḧ_y Z + 2 ḣ_y Ż).
        product([M, N, Q], &w.J_dot, &w.Z, &mut w.JZ);
        product([X, M, Q], &w.P, &w.JZ, B_dot);
        B_dot.iter_mut().for_each(|b| *b = -*b);
        for j in 0..Q {
            w.Z_dot[j * N..j * N + p].fill(0.0);
            w.Z_dot[j * N + p..(j + 1) * N].copy_from_slice(&B_dot[j * X..(j + 1) * X]);
        }
        product([M, N, Q], &w.J_dot, &w.Z_dot, &mut w.JZ);
        product([M, N, Q], &w.J_ddot, &w.Z, &mut w.KZ[..M * Q]);
        for (b, j) in w.KZ.iter_mut().zip(&w.JZ) {
            *b += 2.0 * j;
        }
        product([X, M, Q], &w.P, &w.KZ[..M * Q], B_ddot);
        B_ddot.iter_mut().for_each(|b| *b = -*b);
    }

    fn geometric_stiffness(&mut self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        if self.solve(t, q).is_err() {
            K.fill(f64::NAN);
            return;
        }
        let (p, X, M, D) = (self.p, self.X, self.M, self.D);
        let (N, Q) = (p + X, D + p);
        self.embed();
        let w = &mut self.work;
        product_tr([M, X, 1], &w.P, f, &mut w.lambda);
        self.h
            .geometric_stiffness(t, &w.y, &w.lambda, &mut w.K_sigma);
        product([N, N, Q], &w.K_sigma, &w.Z, &mut w.KZ[..N * Q]);
        product_tr([Q, N, Q], &w.Z, &w.KZ[..N * Q], K);
        K.iter_mut().for_each(|k| *k = -*k);
    }

    fn state(&mut self) -> Option<&mut dyn MapState> {
        Some(self)
    }
}

impl ImplicitMap {
    /// ẏ at the solution in the workspace, and what ḧ is without accelerations of q and p.
    pub(super) fn find_rates(&mut self, t: f64, v: &[f64]) {
        let (p, X, M, N) = (self.p, self.X, self.M, self.p + self.X);
        self.embed();
        let w = &mut self.work;
        // Z (q̇, ṗ), less the explicit time term; ÿ is not known yet.
        product([N, v.len(), 1], &w.Z, v, &mut w.y_dot);
        w.y_ddot.fill(0.0);
        along(&mut *self.h, t, w);
        if w.h_dot.iter().any(|h| h.abs() > 0.0) {
            let mut moved = false;
            for k in 0..X {
                let by: f64 = (0..M).map(|i| w.P[k + i * X] * w.h_dot[i]).sum();
                moved |= by.abs() > 1e-14 * (1.0 + w.y_dot[p + k].abs());
                w.y_dot[p + k] -= by;
            }
            if moved {
                along(&mut *self.h, t, w);
            }
        }
    }

    /// ÿ after [`ImplicitMap::find_rates`].
    pub(super) fn find_accelerations(&mut self, a: &[f64]) {
        let (p, X, M, N) = (self.p, self.X, self.M, self.p + self.X);
        let w = &mut self.work;
        product([N, a.len(), 1], &w.Z, a, &mut w.y_ddot);
        for k in 0..X {
            let by: f64 = (0..M).map(|i| w.P[k + i * X] * w.h_ddot[i]).sum();
            w.y_ddot[p + k] -= by;
        }
    }

    /// tr(A⁻¹ Ȧ) along the last motion that was evaluated.
    pub(super) fn closing(&self) -> f64 {
        let (p, X, M, w) = (self.p, self.X, self.M, &self.work);
        let along = |i: usize| (0..X).map(move |k| w.P[k + i * X] * w.J_dot[i + (p + k) * M]);
        (0..M).flat_map(along).sum()
    }

    /// Z = ∂(p, x)/∂(q, p).
    fn embed(&mut self) {
        let (p, X, D) = (self.p, self.X, self.D);
        let N = p + X;
        let w = &mut self.work;
        w.Z.fill(0.0);
        for j in 0..D + p {
            w.Z[j * N + p..(j + 1) * N].copy_from_slice(&w.Y[j * X..(j + 1) * X]);
        }
        for j in 0..p {
            w.Z[j + (D + j) * N] = 1.0;
        }
    }

    /// Lagrange multipliers of the equations under the covector `f` (X), one per equation: μ of
    /// f + h_xᵀ μ = 0 along the dependent coordinates. Not numbers where the equations have no
    /// solution.
    pub fn multipliers(&mut self, t: f64, q: &[f64], f: &[f64], mu: &mut [f64]) {
        if self.solve(t, q).is_err() {
            return mu.fill(f64::NAN);
        }
        product_tr([self.M, self.X, 1], &self.work.P, f, mu);
        mu.iter_mut().for_each(|m| *m = -*m);
        if self.chart.used.iter().any(|used| !used) {
            self.share(mu);
        }
    }

    /// With redundant equations, the solution of least norm, each entry times the size of its
    /// equation: the load sharing of equal springs.
    fn share(&mut self, mu: &mut [f64]) {
        self.rank_equations();
        let (p, M, rank) = (self.p, self.M, self.X - self.D);
        let (w, about) = (&self.work, &self.about);
        let size = |i: usize| self.scale(i);
        // The gradients of equations over their sizes, in an orthonormal basis of their space.
        let C = DMatrix::from_fn(rank, M, |k, i| {
            let direction = w.equations.direction(k).iter().enumerate();
            let along = direction.map(|(j, n)| n * w.J[i + (p + j) * M] * about.unknowns[j].size);
            along.sum::<f64>() / size(i)
        });
        let given = DVector::from_fn(M, |i, _| mu[i] * size(i));
        let Some(factors) = (&C * C.transpose()).cholesky() else {
            return;
        };
        let shared = C.tr_mul(&factors.solve(&(&C * given)));
        for (i, (mu, shared)) in mu.iter_mut().zip(shared.iter()).enumerate() {
            *mu = shared / size(i);
        }
    }
}

/// The equations along the motion in the workspace.
fn along(h: &mut dyn Parametrization, t: f64, w: &mut Work) {
    let motion = [&w.y[..], &w.y_dot, &w.y_ddot];
    let out = &mut [
        [&mut w.h[..], &mut w.J[..]],
        [&mut w.h_dot, &mut w.J_dot],
        [&mut w.h_ddot, &mut w.J_ddot],
    ];
    h.evaluate(t, motion, out);
}
