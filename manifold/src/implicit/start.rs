//! The first configuration: h(t, p, x) = 0 from a guess, before coordinates q exist.

use super::core::{
    Anchor, CONSISTENT, CONVERGED, ImplicitChart, ImplicitMap, RANK, ROUNDING, Work,
};
use super::{Description, ImplicitError};
use crate::map::Parametrization;

/// Iterations at most.
pub(super) const ITERATIONS: usize = 200;
/// Number of steps from the drawn configuration to the requested one.
const STAGES: usize = 32;
/// Distance (relative to sizes) at which the rank is checked again, to distinguish a singular
/// configuration from a mechanism that moves.
pub(super) const ASIDE: f64 = 1e-3;
/// A gradient smaller than this relative to its value beside the solution vanishes there: if an
/// equation only touches zero, Newton's method ends about 1e-10 away.
const VANISHES: f64 = 1e-5;

/// Components of a direction that no symmetry distinguishes.
fn aside(k: usize) -> f64 {
    1.0 + (1.7 * (k + 1) as f64).sin()
}

impl ImplicitMap {
    pub(super) fn assemble(
        h: Box<dyn Parametrization>,
        about: Description,
        t: f64,
        p: &[f64],
        guess: &[f64],
    ) -> Result<Self, ImplicitError> {
        let (N, M) = h.dims();
        let X = about.unknowns.len();
        debug_assert_eq!(N, p.len() + X);
        debug_assert_eq!(M, about.equations.len());
        let mut core = Self {
            h,
            about,
            p: p.len(),
            X,
            M,
            D: 0,
            reference: vec![0.0; X],
            chart: ImplicitChart::default(),
            anchor: Anchor {
                t,
                ..Anchor::default()
            },
            sizes: vec![0.0; M],
            work: Work::default(),
        };
        core.reserve();
        core.work.y[..p.len()].copy_from_slice(p);
        core.work.y[p.len()..].copy_from_slice(guess);
        core.close(t)?;
        core.reference = core.x().to_vec();
        let rank = core.rank(t);
        core.refuse_touching(t, rank)?;
        if core.about.freedoms.is_some() && rank < core.most() {
            return Err(core.singular_start(core.most()));
        }
        core.D = X - rank;
        core.look_aside(t, rank)?;
        let y = core.work.y.clone();
        core.reserve();
        core.work.y = y;
        core.change_equation_charts(t);
        core.rank(t);
        if core.choose_first().is_infinite() {
            return Err(core.singular_start(X - rank));
        }
        core.chart = core.work.trial.clone();
        let q = [vec![0.0; core.D], p.to_vec()].concat();
        core.anchor = Anchor {
            t,
            q: q.clone(),
            x: vec![0.0; X],
            Y: vec![0.0; X * (core.D + core.p)],
            P: vec![0.0; X * M],
            closing: 0.0,
        };
        core.refresh(t, &q);
        Ok(core)
    }

    /// Largest possible rank of h_x.
    fn most(&self) -> usize {
        self.X.saturating_sub(self.about.freedoms.unwrap_or(0))
    }

    /// Rank of h_x at the present position, with the sizes of equations there.
    fn rank(&mut self, t: f64) -> usize {
        self.linearise(t);
        self.sizes.fill(0.0);
        self.measure();
        self.rank_equations();
        self.work.equations.rank(RANK)
    }

    /// Finds x that satisfies the equations, from zero or from the desired values.
    fn close(&mut self, t: f64) -> Result<(), ImplicitError> {
        let p = self.p;
        let free = vec![false; self.X];
        let mut held: Vec<bool> = self
            .about
            .unknowns
            .iter()
            .map(|u| u.start.is_some())
            .collect();
        let closed = self.close_as_prescribed(t, &free);
        if !held.contains(&true) {
            return closed;
        }
        let drawn = closed.is_ok() && self.x().iter().all(|x| x.abs() < 1e-6);
        let drawn = drawn.then(|| self.x().to_vec());
        if self.approach(t, drawn.as_deref(), &held) {
            return Ok(());
        }
        // As many as can be satisfied, one after the other.
        let wanted = std::mem::replace(&mut held, free.clone());
        for k in (0..self.X).filter(|&k| wanted[k]) {
            held[k] = true;
            held[k] = self.approach(t, drawn.as_deref(), &held);
        }
        if self.approach(t, drawn.as_deref(), &held) {
            return Ok(());
        }
        self.work.y[p..].fill(0.0);
        self.newton(t, &free)
    }

    /// Closes the loop from the drawn configuration; if that fails, its prescribed coordinates are approached in steps.
    fn close_as_prescribed(&mut self, t: f64, free: &[bool]) -> Result<(), ImplicitError> {
        let (p, y) = (self.p, self.work.y.clone());
        let direct = self.newton(t, free);
        if direct.is_ok() || y[..p].iter().all(|p| *p == 0.0) {
            return direct;
        }
        let failed = self.work.y.clone();
        self.work.y.copy_from_slice(&y);
        let stage = |core: &mut Self, part: f64| {
            let parameters = core.work.y[..p].iter_mut().zip(&y);
            parameters.for_each(|(now, p)| *now = part * p);
            core.newton(t, free)
        };
        if (0..=STAGES).all(|k| stage(self, k as f64 / STAGES as f64).is_ok()) {
            return Ok(());
        }
        self.work.y = failed;
        direct
    }

    /// Closes the loop with the desired values of the unknowns in `held`. If it is closed as drawn,
    /// they are approached in steps, on one branch; if that fails, these and all other values are a
    /// first guess.
    fn approach(&mut self, t: f64, drawn: Option<&[f64]>, held: &[bool]) -> bool {
        let p = self.p;
        let wanted: Vec<Option<f64>> = self.about.unknowns.iter().map(|u| u.start).collect();
        if let Some(from) = drawn {
            self.work.y[p..].copy_from_slice(from);
            let stage = |core: &mut Self, part: f64| {
                for (k, wanted) in wanted.iter().enumerate() {
                    if let Some(to) = wanted.filter(|_| held[k]) {
                        core.work.y[p + k] = from[k] + part * (to - from[k]);
                    }
                }
                core.newton(t, held)
            };
            if (1..=STAGES).all(|k| stage(self, k as f64 / STAGES as f64).is_ok()) {
                return true;
            }
        }
        for (k, wanted) in wanted.iter().enumerate() {
            self.work.y[p + k] = wanted.unwrap_or(0.0);
        }
        self.newton(t, held).is_ok()
    }

    /// Newton's method with steps of least length (of scaled unknowns), at most 1 long, on the
    /// independent equations; the unknowns in `held` stay fixed.
    fn newton(&mut self, t: f64, held: &[bool]) -> Result<(), ImplicitError> {
        let (p, X, M) = (self.p, self.X, self.M);
        let mut before = f64::INFINITY;
        for _ in 0..ITERATIONS {
            self.linearise(t);
            let finite = |i: usize| self.work.h[i].is_finite() && self.row(i).is_finite();
            if let Some(i) = (0..M).find(|&i| !finite(i)) {
                let equation = self.about.equations[i].name.clone();
                return Err(ImplicitError::NotFinite { equation });
            }
            self.sizes.fill(0.0);
            self.measure();
            for (k, _) in held.iter().enumerate().filter(|(_, held)| **held) {
                self.work.J[(p + k) * M..(p + k + 1) * M].fill(0.0);
            }
            self.rank_equations();
            let most = self.most();
            let w = &mut self.work;
            // With the basis Q of their gradients the equations are triangular in y, ξ = Q y.
            let mut step = vec![0.0; X];
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            for k in 0..w.equations.rank(RANK).min(most) {
                let i = w.equations.order[k];
                let row = &w.scaled[i * X..(i + 1) * X];
                let direction = w.equations.direction(k);
                let h = w.h[i] / self.sizes[i];
                let y = -(h + dot(row, &step)) / dot(row, direction);
                step.iter_mut()
                    .zip(direction)
                    .for_each(|(s, d)| *s += d * y);
            }
            let size = dot(&step, &step).sqrt();
            let part = 1.0 / size.max(1.0);
            for k in 0..X {
                w.y[p + k] += step[k] * part * self.about.unknowns[k].size;
            }
            if size <= CONVERGED || (size <= ROUNDING && size > 0.5 * before) {
                return self.hold(t);
            }
            before = size;
        }
        Err(self.open())
    }

    /// Whether all equations hold, and leave enough coordinates free.
    fn hold(&mut self, t: f64) -> Result<(), ImplicitError> {
        let rank = self.rank(t);
        if rank > self.most() {
            let last = self.work.equations.order[rank - 1];
            return Err(ImplicitError::TooManyEquations {
                equation: self.about.equations[last].name.clone(),
                rank,
                coordinates: self.X,
                expected: self.X - self.most(),
            });
        }
        let wrong =
            |i: &usize| self.work.h[*i].abs() > CONSISTENT * self.sizes[*i].max(self.scale(*i));
        let Some(i) = (0..self.M).find(wrong) else {
            return Ok(());
        };
        if self.p > 0 {
            return Err(self.open());
        }
        let (equation, residual) = (self.about.equations[i].name.clone(), self.work.h[i]);
        if self.row(i) <= RANK * self.sizes[i] {
            return Err(ImplicitError::Flat { equation, residual });
        }
        Err(ImplicitError::Inconsistent {
            equation,
            others: self.others(i),
            residual,
        })
    }

    /// Length of each row of h_x beside the present position.
    pub(super) fn rows_beside(&mut self, t: f64) -> Vec<f64> {
        let (p, y) = (self.p, self.work.y.clone());
        for k in 0..self.X {
            self.work.y[p + k] += ASIDE * aside(k) * self.size(k);
        }
        self.linearise(t);
        let rows = (0..self.M).map(|i| self.row(i)).collect();
        self.work.y = y;
        self.linearise(t);
        rows
    }

    /// Refuses equations in use with a gradient that vanishes here and does not beside.
    fn refuse_touching(&mut self, t: f64, rank: usize) -> Result<(), ImplicitError> {
        let beside = self.rows_beside(t);
        let used = self.work.equations.order.iter().take(rank.max(1));
        let mut flat = used.filter(|&&i| self.row(i) < VANISHES * beside[i]);
        flat.next().map_or(Ok(()), |&i| {
            let equation = self.about.equations[i].name.clone();
            Err(ImplicitError::Touching { equation })
        })
    }

    fn open(&self) -> ImplicitError {
        let i = self.worst();
        let (equation, residual) = (self.about.equations[i].name.clone(), self.work.h[i]);
        if self.p > 0 {
            return ImplicitError::Overprescribed {
                prescribed: self.prescribed(|_| true),
                equation,
                residual,
            };
        }
        ImplicitError::NotAssembled { equation, residual }
    }

    /// Checks the rank beside the configuration. If it is larger there, or if nothing can move that
    /// far although the rank allows it, the configuration is singular.
    fn look_aside(&mut self, t: f64, rank: usize) -> Result<(), ImplicitError> {
        let (p, X) = (self.p, self.X);
        if rank == X {
            return Ok(());
        }
        let y = self.work.y.clone();
        let sizes = self.sizes.clone();
        // A direction across the gradients.
        let mut n: Vec<f64> = (0..X).map(aside).collect();
        for k in 0..rank {
            let d = self.work.equations.direction(k);
            let along: f64 = n.iter().zip(d).map(|(n, d)| n * d).sum();
            n.iter_mut().zip(d).for_each(|(n, d)| *n -= along * d);
        }
        let length = super::dense::norm(&n);
        for k in 0..X {
            self.work.y[p + k] += ASIDE * n[k] / length * self.size(k);
        }
        let found = self.newton(t, &vec![false; X]).is_ok();
        let moved: f64 = (0..X)
            .map(|k| ((self.work.y[p + k] - y[p + k]) / self.size(k)).powi(2))
            .sum();
        self.linearise(t);
        self.sizes = sizes;
        self.rank_equations();
        let there = self.work.equations.rank(RANK);
        self.work.y = y;
        self.linearise(t);
        if found && moved.sqrt() > 0.5 * ASIDE && there <= rank {
            return Ok(());
        }
        Err(self.singular_start(there.max(rank + 1)))
    }

    fn singular_start(&mut self, expected: usize) -> ImplicitError {
        self.rank_equations();
        let rank = self.work.equations.rank(RANK);
        let expected = expected.min(self.X);
        let (equations, coordinates) = self.dependences(expected);
        ImplicitError::Singular {
            equations,
            coordinates,
            left: self.X - rank,
            expected: self.X - expected,
        }
    }
}
