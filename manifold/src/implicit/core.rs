//! Newton's method on h(t, p, x) = 0.

use super::dense::{Inverse, Pivoted, norm, product};
use super::{Description, EvaluationError};
use crate::map::Parametrization;

/// Equations whose gradients add less than this to the span of the others depend on them; a
/// condition number beyond its inverse is singular.
pub(super) const RANK: f64 = 1e-8;
/// Largest residual of a redundant equation, as a relative change of coordinates, that counts as zero.
pub(super) const CONSISTENT: f64 = 1e-9;
/// Correction relative to the sizes of the coordinates that ends Newton's method; the next one
/// would be its square.
pub(super) const CONVERGED: f64 = 1e-13;
/// Correction that may be rounding if the condition number is large.
pub(super) const ROUNDING: f64 = 1e-10;

/// Largest number of iterations from the last converged state.
const ITERATIONS: usize = 30;

/// Selection of the coordinates q and of the independent equations.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ImplicitChart {
    /// q = Lᵀ (x − x_ref); X×D.
    pub L: Vec<f64>,
    /// The selected unknowns if L picks some.
    pub independent: Option<Vec<usize>>,
    /// Equations in use; the others follow from them.
    pub used: Vec<bool>,
}

/// The map (q, p) ↦ x of equations h(t, p, x) = 0, solved for x in D = X − rank(h_x) of its own
/// coordinates and the parameters p.
///
/// q = 0 is the initial configuration. Redundant equations are found, dropped and named.
pub struct ImplicitMap {
    pub(super) h: Box<dyn Parametrization>,
    pub(super) about: Description,
    pub(super) p: usize,
    pub(super) X: usize,
    pub(super) M: usize,
    pub(super) D: usize,
    /// Configuration at q = 0.
    pub(super) reference: Vec<f64>,
    pub(super) chart: ImplicitChart,
    /// The last converged (q, p), x, its derivatives Y by them and P by the equations, from which
    /// Newton's method starts.
    pub(super) anchor: Anchor,
    /// Largest length of each row of h_x so far.
    pub(super) sizes: Vec<f64>,
    pub(super) work: Work,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Anchor {
    pub t: f64,
    pub q: Vec<f64>,
    pub x: Vec<f64>,
    pub Y: Vec<f64>,
    pub P: Vec<f64>,
    /// d ln|det A|/dt = tr(A⁻¹ Ȧ) along the motion there.
    pub closing: f64,
}

/// The last solution, and scratch.
#[derive(Debug, Default)]
pub(super) struct Work {
    /// Time and (q, p) of the present content, if any.
    t: f64,
    q: Vec<f64>,
    valid: bool,
    /// Whether the equations have gone to another piece since the last change of charts.
    pub piece_changed: bool,
    /// (p, x).
    pub y: Vec<f64>,
    /// The same where h_y was found last, before the last correction.
    pub linearised: Vec<f64>,
    pub h: Vec<f64>,
    /// h_y, M×(p + X).
    pub J: Vec<f64>,
    /// A⁻¹ = [B | P]: B (X×D) of q, P (X×M) with zeros for equations that are not used.
    pub B: Vec<f64>,
    pub P: Vec<f64>,
    /// ∂x/∂(q, p), X×(D + p).
    pub Y: Vec<f64>,
    pub condition: f64,
    A: Vec<f64>,
    inverse: Vec<f64>,
    factors: Inverse,
    length: Vec<f64>,
    pub dx: Vec<f64>,
    /// Second and third derivatives of the equations, and motions.
    pub h_dot: Vec<f64>,
    pub h_ddot: Vec<f64>,
    pub J_dot: Vec<f64>,
    pub J_ddot: Vec<f64>,
    pub y_dot: Vec<f64>,
    pub y_ddot: Vec<f64>,
    pub Z: Vec<f64>,
    pub Z_dot: Vec<f64>,
    pub JZ: Vec<f64>,
    pub lambda: Vec<f64>,
    pub K_sigma: Vec<f64>,
    /// K_σ Z, or ḧ_y Z.
    pub KZ: Vec<f64>,
    pub scaled: Vec<f64>,
    pub rows: Vec<f64>,
    pub equations: Pivoted,
    pub columns: Pivoted,
    pub trial: ImplicitChart,
}

impl Clone for ImplicitMap {
    fn clone(&self) -> Self {
        let mut copy = Self {
            h: self.h.duplicate(),
            about: self.about.clone(),
            reference: self.reference.clone(),
            chart: self.chart.clone(),
            anchor: self.anchor.clone(),
            sizes: self.sizes.clone(),
            work: Work::default(),
            ..*self
        };
        copy.reserve();
        copy
    }
}

impl ImplicitMap {
    /// Allocates all buffers.
    pub(super) fn reserve(&mut self) {
        let (p, X, M, D) = (self.p, self.X, self.M, self.D);
        let (N, Q) = (p + X, D + p);
        let z = |n: usize| vec![0.0; n];
        self.work = Work {
            q: z(Q),
            y: z(N),
            linearised: z(N),
            h: z(M),
            J: z(M * N),
            B: z(X * D),
            P: z(X * M),
            Y: z(X * Q),
            A: z(X * X),
            inverse: z(X * X),
            length: z(X),
            dx: z(X),
            h_dot: z(M),
            h_ddot: z(M),
            J_dot: z(M * N),
            J_ddot: z(M * N),
            y_dot: z(N),
            y_ddot: z(N),
            Z: z(N * Q),
            Z_dot: z(N * Q),
            JZ: z(M * Q),
            lambda: z(M),
            K_sigma: z(N * N),
            KZ: z(N.max(M) * Q),
            ..Work::default()
        };
        self.work.factors.reserve(X);
    }

    pub(super) fn x(&self) -> &[f64] {
        &self.work.y[self.p..]
    }

    pub(super) fn size(&self, k: usize) -> f64 {
        self.about.unknowns[k].size
    }

    /// Size of equation `i`.
    pub(super) fn scale(&self, i: usize) -> f64 {
        self.about.equations[i].size.unwrap_or(self.sizes[i])
    }

    /// h and h_y at y, into the workspace.
    pub(super) fn linearise(&mut self, t: f64) {
        let w = &mut self.work;
        w.valid = false;
        w.linearised.copy_from_slice(&w.y);
        self.h.tangent(t, &w.y, &mut w.h, &mut w.J);
    }

    /// A⁻¹ in a chart at the present h_y, into the workspace; returns the condition number of A
    /// with rows of unit length and scaled coordinates, infinite if it is singular.
    pub(super) fn factorise(&mut self, trial: bool) -> f64 {
        let (p, X, M, D) = (self.p, self.X, self.M, self.D);
        let about = &self.about;
        let size = |k: usize| about.unknowns[k].size;
        let w = &mut self.work;
        let chart = if trial { &w.trial } else { &self.chart };
        w.condition = f64::INFINITY;
        for row in 0..D {
            let L = &chart.L[row * X..(row + 1) * X];
            for k in 0..X {
                w.A[row + k * X] = L[k] * size(k);
            }
            let squares = (0..X).map(|k| w.A[row + k * X].powi(2));
            w.length[row] = squares.sum::<f64>().sqrt();
        }
        let used = (D..).zip((0..M).filter(|&i| chart.used[i]));
        for (row, i) in used {
            for k in 0..X {
                w.A[row + k * X] = w.J[i + (p + k) * M] * size(k);
            }
            w.length[row] = self.sizes[i];
        }
        for k in 0..X {
            for row in 0..X {
                w.A[row + k * X] /= w.length[row];
            }
        }
        let of_A = norm(&w.A);
        if !w.factors.run(X, &mut w.A, &mut w.inverse) {
            return f64::INFINITY;
        }
        w.condition = of_A * norm(&w.inverse);
        for row in 0..X {
            for k in 0..X {
                w.inverse[k + row * X] *= size(k) / w.length[row];
            }
        }
        w.B.copy_from_slice(&w.inverse[..X * D]);
        w.P.fill(0.0);
        let used = (D..).zip((0..M).filter(|&i| chart.used[i]));
        for (row, i) in used {
            let column = &w.inverse[row * X..(row + 1) * X];
            w.P[i * X..(i + 1) * X].copy_from_slice(column);
        }
        w.condition
    }

    /// ∂x/∂(q, p) from A⁻¹ and h_p.
    pub(super) fn operators(&mut self) {
        let (p, X, M, D) = (self.p, self.X, self.M, self.D);
        let w = &mut self.work;
        w.Y[..X * D].copy_from_slice(&w.B);
        product([X, M, p], &w.P, &w.J[..M * p], &mut w.Y[X * D..]);
        w.Y[X * D..].iter_mut().for_each(|y| *y = -*y);
    }

    /// Solves for x at (q, p), with A⁻¹, into the workspace; returns at once if it is there already.
    pub(super) fn solve(&mut self, t: f64, q: &[f64]) -> Result<(), EvaluationError> {
        if self.work.valid && self.work.t == t && self.work.q == q {
            return Ok(());
        }
        if self.anchor.t == t && self.anchor.q == q {
            self.work.y[self.p..].copy_from_slice(&self.anchor.x);
            self.work.y[..self.p].copy_from_slice(&q[self.D..]);
            let regular = self.refresh(t, q);
            return regular.then_some(()).ok_or_else(|| self.singular());
        }
        self.follow(t, q)?;
        let w = &mut self.work;
        (w.t, w.valid) = (t, true);
        w.q.copy_from_slice(q);
        Ok(())
    }

    /// Writes (p, x) where the slopes at the anchor lead, by the parameters too if it follows them; returns the largest
    /// change of x, in sizes of the unknowns.
    pub(super) fn predict(&mut self, q: &[f64], follow: bool) -> f64 {
        let (p, X, D) = (self.p, self.X, self.D);
        let w = &mut self.work;
        w.y[..p].copy_from_slice(&q[D..]);
        w.y[p..].copy_from_slice(&self.anchor.x);
        for j in 0..if follow { D + p } else { D } {
            let dq = q[j] - self.anchor.q[j];
            if dq != 0.0 {
                for (x, Y) in w.y[p..].iter_mut().zip(&self.anchor.Y[j * X..]) {
                    *x += Y * dq;
                }
            }
        }
        let moved = w.y[p..].iter().zip(&self.anchor.x);
        let moved = moved.zip(&self.about.unknowns);
        moved.fold(0.0, |most, ((y, x), u)| {
            f64::max(most, ((y - x) / u.size).abs())
        })
    }

    /// Newton's method from the prediction.
    pub(super) fn search(&mut self, t: f64, q: &[f64]) -> Result<(), EvaluationError> {
        let (p, X, M, D) = (self.p, self.X, self.M, self.D);
        let mut before = f64::INFINITY;
        for _ in 0..ITERATIONS {
            self.linearise(t);
            let condition = self.factorise(false);
            if is_singular(condition) {
                return Err(self.singular());
            }
            let w = &mut self.work;
            product([X, M, 1], &w.P, &w.h, &mut w.dx);
            w.dx.iter_mut().for_each(|dx| *dx = -*dx);
            for j in 0..D {
                let now: f64 = (0..X)
                    .map(|k| self.chart.L[k + j * X] * (w.y[p + k] - self.reference[k]))
                    .sum();
                for (dx, B) in w.dx.iter_mut().zip(&w.B[j * X..]) {
                    *dx += B * (q[j] - now);
                }
            }
            let mut size = 0.0_f64;
            for k in 0..X {
                w.y[p + k] += w.dx[k];
                let relative = (w.dx[k] / self.about.unknowns[k].size).abs();
                // A sum keeps NaN.
                size = size.max(relative) + 0.0 * (size + relative);
            }
            // Newton's method contracts near the branch of solutions on which it started; otherwise
            // it may end on another one.
            let rounding = ROUNDING.max(f64::EPSILON * 10.0 * condition);
            if size <= CONVERGED || (size <= rounding && size > 0.5 * before) {
                return self.check_unused();
            }
            if size.is_nan() || size > 0.5 * before || size > 1.0 {
                break;
            }
            before = size;
        }
        let i = self.worst();
        Err(EvaluationError::TooFar {
            equation: self.about.equations[i].name.clone(),
            residual: self.work.h[i],
        })
    }

    /// Largest residual at φ(t, q) of the equations, each relative to its size; not a number if they
    /// have no solution.
    pub fn violation(&mut self, t: f64, q: &[f64]) -> f64 {
        if self.solve(t, q).is_err() {
            return f64::NAN;
        }
        // Newton's method leaves the residual before its last correction.
        self.linearise(t);
        let worst = self.worst();
        (self.work.h[worst] / self.scale(worst)).abs()
    }

    /// The equation with the largest residual relative to its size.
    pub(super) fn worst(&self) -> usize {
        let off = |i: usize| (self.work.h[i] / self.scale(i)).abs();
        let mut worst = 0;
        for i in 0..self.M {
            if off(i) > off(worst) || off(i).is_nan() {
                worst = i;
            }
        }
        worst
    }

    fn check_unused(&self) -> Result<(), EvaluationError> {
        for i in (0..self.M).filter(|&i| !self.chart.used[i]) {
            let h = self.work.h[i];
            if h.is_nan() || h.abs() > CONSISTENT * self.sizes[i] {
                return Err(EvaluationError::Inconsistent {
                    equation: self.about.equations[i].name.clone(),
                    residual: h,
                });
            }
        }
        Ok(())
    }

    /// Updates A⁻¹ and all operators to the x in the workspace, where Newton's method starts next;
    /// false if A is singular there.
    pub(super) fn refresh(&mut self, t: f64, q: &[f64]) -> bool {
        self.linearise(t);
        self.measure();
        if is_singular(self.factorise(false)) {
            return false;
        }
        self.operators();
        let w = &mut self.work;
        (w.t, w.valid) = (t, true);
        w.q.copy_from_slice(q);
        self.set_anchor(t, q);
        true
    }

    /// Makes the solution in the workspace, with its operators, the start of Newton's method.
    pub(super) fn set_anchor(&mut self, t: f64, q: &[f64]) {
        let (anchor, w) = (&mut self.anchor, &self.work);
        anchor.t = t;
        anchor.q.copy_from_slice(q);
        anchor.x.copy_from_slice(&w.y[self.p..]);
        anchor.Y.copy_from_slice(&w.Y);
        anchor.P.copy_from_slice(&w.P);
    }
}

/// Whether A with this condition number is singular to working precision.
pub(super) fn is_singular(condition: f64) -> bool {
    condition.is_nan() || condition * RANK >= 1.0
}
