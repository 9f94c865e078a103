//! The choice of the coordinates q, and its changes at converged states.

use super::core::{ImplicitChart, ImplicitMap, RANK, is_singular};
use super::dense::{norm, product_tr};
use super::{Choice, Unknown};
use crate::chart::Complement;
use crate::map::{Map, Reparametrization};
use nalgebra::Vector3;
use std::f64::consts::PI;

/// A split with a condition number larger than that of the tangent space by this factor is poor.
///
/// The best split is worse by √(1 + D(X − D)) at most (Gu & Eisenstat 1996, SIAM J. Sci. Comput.
/// 17): 30 for a hundred unknowns with a tenth of them free. Pivoting misses it by this factor only
/// for matrices like Kahan's, whose columns are less and less independent; linkages have none.
const POOR: f64 = 1e3;
/// A preference of 1 makes an unknown appear less dependent by this factor.
const WEIGHT: f64 = 1e-3;
/// Gain in the condition number that triggers a change of coordinates (hysteresis).
const GAIN: f64 = 2.0;

impl ImplicitMap {
    /// Length of row i of h_x, of coordinates over their sizes.
    pub(super) fn row(&self, i: usize) -> f64 {
        let entry = |k: usize| self.work.J[i + (self.p + k) * self.M] * self.size(k);
        let squares = (0..self.X).map(|k| entry(k).powi(2));
        squares.sum::<f64>().sqrt()
    }

    /// Size of each equation: the length of its row, or its earlier maximum. A shrinking row
    /// indicates a singular configuration, which scaling must not hide; a row that vanishes beside
    /// the others has no size of its own.
    pub(super) fn measure(&mut self) {
        for i in 0..self.M {
            self.sizes[i] = self.row(i).max(self.sizes[i]);
        }
        let units = self.about.equations.iter().map(|e| e.size.unwrap_or(1.0));
        let relative = self
            .sizes
            .iter()
            .zip(units.clone())
            .map(|(s, unit)| s / unit);
        let most = relative.fold(f64::MIN_POSITIVE, f64::max);
        for (size, unit) in self.sizes.iter_mut().zip(units) {
            if *size <= RANK * most * unit {
                *size = most * unit;
            }
        }
    }

    /// Writes h_xᵀ, scaled by the sizes of equations and coordinates, to the workspace and
    /// factorises it for the most independent equations.
    pub(super) fn rank_equations(&mut self) {
        let (p, X, M) = (self.p, self.X, self.M);
        let w = &mut self.work;
        w.scaled.clear();
        for i in 0..M {
            let row =
                (0..X).map(|k| w.J[i + (p + k) * M] * self.about.unknowns[k].size / self.sizes[i]);
            w.scaled.extend(row);
        }
        w.equations.run(X, &w.scaled);
    }

    /// The best equations and coordinates at the present h_y, into the trial chart, with A⁻¹ in the
    /// workspace; returns the condition number, infinite if there are none.
    pub(super) fn best(&mut self, choice: Choice) -> f64 {
        self.best_by(choice, |_| 1.0)
    }

    /// As [`ImplicitMap::best`], with a weight for each unknown.
    fn best_by(&mut self, choice: Choice, weight: impl Fn(&Unknown) -> f64) -> f64 {
        let (X, M, D) = (self.X, self.M, self.D);
        self.rank_equations();
        let w = &mut self.work;
        let chart = &mut w.trial;
        chart.used.clear();
        chart.used.resize(M, false);
        for &i in &w.equations.order[..X - D] {
            chart.used[i] = true;
        }
        chart.L.clear();
        chart.L.resize(X * D, 0.0);
        match choice {
            Choice::Tangent => self.take_tangent(),
            Choice::Split | Choice::Fixed => self.take_split(weight),
        }
        self.try_chart()
    }

    /// The trial chart takes orthonormal directions across the gradients, of coordinates over their
    /// sizes; each is in the unit of its largest component.
    fn take_tangent(&mut self) {
        let (X, D) = (self.X, self.D);
        let w = &mut self.work;
        w.scaled.clear();
        w.scaled.resize(X * X, 0.0);
        for k in 0..X {
            w.scaled[k + k * X] = 1.0;
        }
        for k in 0..X - D {
            let n = w.equations.direction(k);
            for j in 0..X {
                for i in 0..X {
                    w.scaled[i + j * X] -= n[i] * n[j];
                }
            }
        }
        w.columns.run(X, &w.scaled);
        for j in 0..D {
            let direction = w.columns.direction(j);
            let size = |k: usize| self.about.unknowns[k].size;
            let largest = (0..X).max_by(|&a, &b| direction[a].abs().total_cmp(&direction[b].abs()));
            let unit = largest.map_or(1.0, size);
            for k in 0..X {
                w.trial.L[k + j * X] = direction[k] * (unit / size(k));
            }
        }
        w.trial.independent = None;
    }

    /// The trial chart takes a split: coordinates that the equations in use determine best are
    /// dependent, the rest is q.
    fn take_split(&mut self, weight: impl Fn(&Unknown) -> f64) {
        let (X, rows) = (self.X, self.X - self.D);
        let w = &mut self.work;
        w.rows.clear();
        w.rows.resize(rows * X, 0.0);
        let used = (0..self.M).filter(|&i| w.trial.used[i]);
        for (row, i) in used.enumerate() {
            for k in 0..X {
                w.rows[row + k * rows] = w.scaled[k + i * X] * weight(&self.about.unknowns[k]);
            }
        }
        w.columns.run(rows, &w.rows);
        let chosen = w.trial.independent.get_or_insert_default();
        chosen.clear();
        if rows == 0 {
            chosen.extend(0..X);
        } else {
            chosen.extend_from_slice(&w.columns.order[rows..]);
        }
        chosen.sort_unstable();
        for (j, &k) in chosen.iter().enumerate() {
            w.trial.L[k + j * X] = 1.0;
        }
    }

    /// A⁻¹ in the trial chart; the condition number, infinite if A is singular to working precision.
    fn try_chart(&mut self) -> f64 {
        match self.factorise(true) {
            condition if is_singular(condition) => f64::INFINITY,
            condition => condition,
        }
    }

    /// The best split, or the tangent space if that is the choice or no split is good.
    pub(super) fn choose(&mut self) -> f64 {
        if self.about.choice == Choice::Tangent {
            return self.best(Choice::Tangent);
        }
        let split = self.best(Choice::Split);
        if split < POOR {
            return split;
        }
        let tangent = self.best(Choice::Tangent);
        if split > POOR * tangent {
            tangent
        } else {
            self.best(Choice::Split)
        }
    }

    /// As [`ImplicitMap::choose`], preferring some unknowns among those that are about as good: all
    /// preferences first, then the strong ones alone.
    pub(super) fn choose_first(&mut self) -> f64 {
        let best = self.choose();
        let chosen = self.work.trial.clone();
        if chosen.independent.is_none() {
            return best;
        }
        let most = self.good().max(GAIN * best);
        for least in [0.0, 0.5] {
            let condition = self.best_by(Choice::Split, |u| {
                let preference = if u.preference > least {
                    u.preference
                } else {
                    0.0
                };
                WEIGHT.powf(preference)
            });
            if condition <= most {
                return condition;
            }
        }
        self.work.trial = chosen;
        self.factorise(true)
    }

    /// Condition number up to which coordinates are kept. (That of the identity is one per unknown.)
    fn good(&self) -> f64 {
        self.about.good_condition * self.X as f64
    }

    /// Makes a converged state the start of Newton's method.
    pub(super) fn remember(&mut self, t: f64, q: &[f64]) -> bool {
        if self.solve(t, q).is_err() {
            return false;
        }
        if self.anchor.t != t || self.anchor.q != q {
            self.change_equation_charts(t);
            if !self.refresh(t, q) {
                return false;
            }
        }
        self.anchor.closing = self.closing();
        true
    }

    /// Changes the chart at (q, p) in any case: to the unknowns `independent` as q, or to the
    /// tangent space there. False, without a change, if they do not determine x.
    ///
    /// The parameters follow q in `q`, in its velocity `v` and in the accelerations `a`.
    pub fn switch(
        &mut self,
        t: f64,
        independent: Option<&[usize]>,
        q: &mut [f64],
        v: &mut [f64],
        a: &mut [Vec<f64>],
    ) -> bool {
        let fits = |k: &[usize]| k.len() == self.D && k.iter().all(|&k| k < self.X);
        if !independent.is_none_or(fits) || !self.remember(t, q) {
            return false;
        }
        self.change_chart(t, Some(independent), q, v, a)
    }

    /// Transforms (q, p), velocities and accelerations to the best chart, or to the one `wanted`.
    /// q′ = L′ᵀ(x − x_ref) is linear in x; x, ẋ and ẍ stay the same, but rotation vectors beyond π
    /// change to their complements.
    fn change_chart(
        &mut self,
        t: f64,
        wanted: Option<Option<&[usize]>>,
        q: &mut [f64],
        v: &mut [f64],
        a: &mut [Vec<f64>],
    ) -> bool {
        let (p, X, D) = (self.p, self.X, self.D);
        let turned = wanted.is_none();
        if turned {
            self.complement_rotations(0);
        }
        self.linearise(t);
        let condition = match wanted {
            None => self.choose(),
            Some(Some(k)) => self.split(k),
            Some(None) => self.best(Choice::Tangent),
        };
        // The motion in the old chart.
        self.work.y[p..].copy_from_slice(&self.anchor.x);
        self.refresh(t, q);
        if condition.is_infinite() {
            return false;
        }
        self.find_rates(t, v);
        for a in a {
            self.find_accelerations(a);
            if turned {
                self.complement_rotations(2);
            }
            let w = &self.work;
            product_tr([D, X, 1], &w.trial.L, &w.y_ddot[p..], &mut a[..D]);
        }
        if turned {
            self.complement_rotations(1);
            self.complement_rotations(0);
        }
        let w = &mut self.work;
        product_tr([D, X, 1], &w.trial.L, &w.y_dot[p..], &mut v[..D]);
        let relative = w.dx.iter_mut().zip(&w.y[p..]).zip(&self.reference);
        relative.for_each(|((dx, x), reference)| *dx = x - reference);
        product_tr([D, X, 1], &w.trial.L, &w.dx, &mut q[..D]);
        std::mem::swap(&mut self.chart, &mut w.trial);
        self.change_equation_charts(t);
        let regular = self.refresh(t, q);
        self.anchor.closing = self.closing();
        regular
    }

    /// Trial chart of selected coordinates with the equations in use.
    fn split(&mut self, independent: &[usize]) -> f64 {
        let mut trial = ImplicitChart {
            L: vec![0.0; self.X * self.D],
            independent: Some(independent.to_vec()),
            used: self.chart.used.clone(),
        };
        for (j, &k) in independent.iter().enumerate() {
            trial.L[k + j * self.X] = 1.0;
        }
        self.work.trial = trial;
        self.try_chart()
    }

    /// Changes rotation vectors beyond π to their complements: those of x, or the rates or
    /// accelerations of these rotations.
    fn complement_rotations(&mut self, order: usize) {
        let p = self.p;
        let w = &mut self.work;
        for k in self.about.rotations.iter().filter_map(|k| k.checked_sub(p)) {
            let three = |x: &[f64]| Vector3::new(x[k], x[k + 1], x[k + 2]);
            let psi = three(&self.anchor.x);
            let [rate, second] = [&w.y_dot, &w.y_ddot].map(|x| three(&x[p..]));
            if psi.norm() <= PI {
                continue;
            }
            let turned = Complement.kinematics(0.0, &psi, &rate, &second);
            let (to, turned) = match order {
                0 => (&mut w.y, turned.x),
                1 => (&mut w.y_dot, turned.x_dot),
                _ => (&mut w.y_ddot, turned.x_ddot),
            };
            to[p + k..p + k + 3].copy_from_slice(turned.as_slice());
        }
    }
}

impl Reparametrization for ImplicitMap {
    /// Changes the chart if needed, and makes the state the new start.
    fn reparametrize(&mut self, t: f64, q: &mut [f64], v: &mut [f64], a: &mut [Vec<f64>]) -> bool {
        if !self.remember(t, q) || self.about.choice == Choice::Fixed {
            return false;
        }
        let now = self.work.condition;
        let mut rotations = (self.about.rotations.iter()).filter_map(|k| k.checked_sub(self.p));
        let turned = rotations.any(|k| norm(&self.x()[k..k + 3]) > PI);
        if !turned && now <= self.good() {
            return false;
        }
        if !turned {
            let best = self.choose();
            // The workspace holds the trial chart.
            if now <= GAIN * best {
                self.refresh(t, q);
                return false;
            }
        }
        self.change_chart(t, None, q, v, a)
    }
}
