//! The first configuration: h(t, p, x) = 0 from a guess, before coordinates q exist.

use super::super::ImplicitError;
use super::super::chart::RANK;
use super::super::solve::{CONSISTENT, CONVERGED, ROUNDING};
use super::Description;
use super::core::{Anchor, Chart, Core, Work};
use crate::map::Parametrization;

/// Iterations at most.
const ITERATIONS: usize = 200;
/// Number of steps from the drawn configuration to the requested one.
const STAGES: usize = 32;
/// Distance (relative to sizes) at which the rank is checked again, to distinguish a singular
/// configuration from a mechanism that moves.
pub(super) const ASIDE: f64 = 1e-3;

/// Components of a direction that no symmetry distinguishes.
pub(in crate::implicit) fn aside(k: usize) -> f64 {
    1.0 + (1.7 * (k + 1) as f64).sin()
}

impl Core {
    pub(super) fn assemble(
        h: Box<dyn Parametrization>,
        about: Description,
        t: f64,
        p: &[f64],
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
            chart: Chart::default(),
            anchor: Anchor::default(),
            sizes: vec![0.0; M],
            work: Work::default(),
            parked: Anchor::default(),
        };
        core.reserve();
        core.work.y[..p.len()].copy_from_slice(p);
        core.close(t)?;
        core.reference = core.x().to_vec();
        core.sizes.fill(0.0);
        core.linearise(t);
        core.measure();
        core.rank_equations();
        let rank = core.work.equations.rank(RANK);
        core.D = X - rank;
        core.look_aside(t, rank)?;
        let y = core.work.y.clone();
        core.reserve();
        core.work.y = y;
        core.h.change_charts(t, &core.work.y);
        core.linearise(t);
        core.sizes.fill(0.0);
        core.measure();
        if core.choose_first().is_infinite() {
            return Err(core.singular_start(X - rank));
        }
        core.chart = core.work.trial.clone();
        core.anchor = Anchor {
            t,
            q: vec![0.0; core.D],
            x: vec![0.0; X],
            Y: vec![0.0; X * (core.D + core.p)],
            P: vec![0.0; X * M],
        };
        core.anchor.q.extend_from_slice(p);
        core.parked = core.anchor.clone();
        let q = core.anchor.q.clone();
        core.refresh(t, &q);
        Ok(core)
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
        if !held.contains(&true) {
            return self.newton(t, &free);
        }
        let drawn = self.newton(t, &free).is_ok() && self.x().iter().all(|x| x.abs() < 1e-6);
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
            let finite = |i: usize| {
                let J = &self.work.J;
                self.work.h[i].is_finite() && (0..p + X).all(|k| J[i + k * M].is_finite())
            };
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
            let w = &mut self.work;
            // With the basis Q of their gradients the equations are triangular in y, ξ = Q y.
            let mut step = vec![0.0; X];
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            for k in 0..w.equations.rank(RANK) {
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

    /// Whether all equations hold.
    fn hold(&mut self, t: f64) -> Result<(), ImplicitError> {
        self.linearise(t);
        self.sizes.fill(0.0);
        self.measure();
        let wrong = |i: &usize| {
            self.work.h[*i].abs() > CONSISTENT * self.sizes[*i].max(self.about.equations[*i].size)
        };
        match (0..self.M).find(wrong) {
            None => Ok(()),
            Some(_) => Err(self.open()),
        }
    }

    fn open(&self) -> ImplicitError {
        let i = self.worst();
        let (equation, residual) = (self.about.equations[i].name.clone(), self.work.h[i]);
        if self.p > 0 {
            return ImplicitError::Overdriven {
                driven: self.driven(|_| true),
                equation,
                residual,
            };
        }
        ImplicitError::NotAssembled {
            equation,
            residual,
            iterations: ITERATIONS,
        }
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
