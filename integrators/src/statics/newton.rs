//! Newton's method for equilibrium, at a fixed load or together with a condition on the load.
//!
//! ```text
//! K δq = r + r_t δt,        tangent·(δq, δt) = ds − tangent·(q − q₀, t − t₀)    or    δq_i = value − q_i
//! ```
//!
//! Both right-hand sides share one factorisation, so a step along a path costs one more solution
//! than a step at a fixed load and passes limit points, where K alone is singular.
//!
//! The first corrections are full: the first large correction of a slender beam bends it without its
//! axis following, the axial residual explodes, and the next correction repairs it (no line search
//! allows this; measured on the 45° bend, such a search needs five steps instead of one). After that,
//! corrections are damped by the natural monotonicity test: a trial is accepted if the residual or the
//! simplified correction K⁻¹r at the new point is smaller (Deuflhard 2004, Newton Methods for Nonlinear
//! Problems, section 3.3). A trial outside the domain of a chart is always damped.

use super::arc_length::{Norm, Position};
use super::critical::PathDirection;
use super::{Iteration, StaticNewtonOptions, StaticSummary, StaticsError, solutions};
use crate::convergence::ConvergencePredictor;
use crate::failure::{Cause, FailedStep, FailureContext, StepParameter};
use crate::linear_solver::{AutoSolver, LinearSolver, MatrixSymmetry, max_abs};
use crate::rounding::{ResidualTest, inverse_scales, is_rounding, largest, rounding_errors};
use crate::vectors::add;
use pullback_manifold::system::{Evaluation, Point, System, SystemError, Weights};

/// What is given instead of the load.
pub(super) enum Condition<'a> {
    /// The distance along the tangent at a position (q₀, t₀).
    Distance {
        at: &'a Position,
        norm: &'a Norm,
        ds: f64,
    },
    /// The value of a coordinate.
    Coordinate { unknown: usize, value: f64 },
}

impl Condition<'_> {
    /// What is missing from the condition.
    fn defect(&self, q: &[f64], t: f64) -> f64 {
        match *self {
            Self::Distance { at, norm, ds } => ds - norm.distance(at, q, t),
            Self::Coordinate { unknown, value } => value - q[unknown],
        }
    }

    /// Its change by (dq, dt).
    fn change(&self, dq: &[f64], dt: f64) -> f64 {
        match *self {
            Self::Distance { at, norm, .. } => norm.product(&at.tangent, dq.iter().copied(), dt),
            Self::Coordinate { unknown, .. } => dq[unknown],
        }
    }

    /// Whether the condition holds but for rounding errors.
    fn holds(&self, q: &[f64], t: f64) -> bool {
        let size = match *self {
            Self::Distance { ds, .. } => 1e-9 * ds.abs(),
            Self::Coordinate { value, .. } => 1e-12 * value.abs(),
        };
        self.defect(q, t).abs() <= size + 1e-14
    }
}

/// The linear solver, buffers and history of an iteration.
pub(super) struct Newton {
    pub solver: AutoSolver,
    pub r: Vec<f64>,
    pub S: Vec<f64>,
    pub r_t: Vec<f64>,
    /// δq at a fixed load, then the whole correction.
    pub dq: Vec<f64>,
    /// (dq/dt, 1) at a fixed state of the factorisation.
    pub rate: PathDirection,
    trial: Vec<f64>,
    simplified: Vec<f64>,
    /// 1 / typical size of each coordinate; zero for multipliers.
    pub inverse_scale: Vec<f64>,
    pub history: Vec<Iteration>,
    /// Counters and results of the analysis.
    pub summary: StaticSummary,
    pub test: ResidualTest,
    /// Number of predictions in the history, made before any residual was known.
    predicted: usize,
    pub options: StaticNewtonOptions,
    /// Coordinates that are held, and their values.
    pub held_coordinates: Vec<(usize, f64)>,
    /// The residual that is to remain; empty for none.
    pub remaining: Vec<f64>,
}

/// Stiffness that holds a coordinate, relative to the largest entry of the tangent.
const HARD: f64 = 1e6;

impl Newton {
    /// A solver and buffers for an analysis that begins at load parameter `from`.
    pub(super) fn new(
        system: &dyn System,
        options: &StaticNewtonOptions,
        from: f64,
    ) -> Result<Self, StaticsError> {
        let symmetry = match system.is_symmetric() {
            true => MatrixSymmetry::Symmetric,
            false => MatrixSymmetry::General,
        };
        let solver = AutoSolver::new(system.pattern(), symmetry)
            .map_err(|source| StaticsError::Analysis { source })?;
        let n = system.pattern().dim();
        let zeros = || vec![0.0; n];
        Ok(Self {
            solver,
            r: zeros(),
            S: vec![0.0; system.pattern().len()],
            r_t: zeros(),
            dq: zeros(),
            rate: PathDirection {
                dq: zeros(),
                dt: 1.0,
            },
            trial: zeros(),
            simplified: zeros(),
            inverse_scale: inverse_scales(system),
            history: Vec::with_capacity(options.max_iterations.min(100) + 1),
            summary: StaticSummary {
                t: from,
                ..StaticSummary::default()
            },
            test: ResidualTest::new(options.relative, options.absolute),
            predicted: 0,
            options: *options,
            held_coordinates: Vec::new(),
            remaining: Vec::new(),
        })
    }

    /// Rejects a vector of another length than that of the unknowns.
    pub(super) fn check(&self, what: &'static str, x: &[f64]) -> Result<(), StaticsError> {
        let (found, expected) = (x.len(), self.r.len());
        match found == expected {
            true => Ok(()),
            false => Err(StaticsError::Length {
                what,
                found,
                expected,
            }),
        }
    }

    /// The coordinates of a start; missing ones are zero.
    pub(super) fn start(&self, mut q: Vec<f64>) -> Result<Vec<f64>, StaticsError> {
        q.resize(q.len().max(self.r.len()), 0.0);
        self.check("q", &q)?;
        Ok(q)
    }

    /// Largest entry of a coordinate vector relative to the coordinates' scales.
    pub(super) fn size(&self, v: &[f64]) -> f64 {
        (v.iter().zip(&self.inverse_scale)).fold(0.0, |m: f64, (v, s)| {
            let x = (v * s).abs();
            if x > m || x.is_nan() { x } else { m }
        })
    }

    /// Residual, tangent and ∂r/∂t; the tangent may extrapolate from a previous iterate.
    pub(super) fn evaluate(
        &mut self,
        system: &mut dyn System,
        previous: Option<(f64, &[f64])>,
        q: &[f64],
        t: f64,
    ) -> Result<(), SystemError> {
        self.summary.evaluations += 1;
        let out = Evaluation {
            r: &mut self.r,
            S: Some((Weights::STATIC, &mut self.S)),
            r_t: Some(&mut self.r_t),
            previous: previous.map(|(t, from)| Point::statics(t, from)),
            accelerations: None,
        };
        system.evaluate(Point::statics(t, q), out)?;
        add(&mut self.r[..self.remaining.len()], -1.0, &self.remaining);
        for &(i, value) in &self.held_coordinates {
            let hard = HARD * max_abs(&self.S);
            self.r[i] = hard * (value - q[i]);
            self.r_t[i] = 0.0;
            if let Some(d) = system.pattern().diagonal().nth(i) {
                self.S[d] += hard;
            }
        }
        Ok(())
    }

    /// Report of a failed step to `to`.
    pub(super) fn fail(&self, system: &mut dyn System, cause: Cause, to: f64) -> Box<FailedStep> {
        let summary = &self.summary;
        let context = FailureContext {
            cause,
            r: &self.r,
            S: &self.S,
            history: &self.history,
            parameter: StepParameter::Load,
            span: [summary.t, to],
            steps: summary.steps,
            rejected: summary.rejected,
            evaluations: summary.evaluations,
            factorisations: summary.factorisations,
        };
        FailedStep::new(system, context)
    }

    pub(super) fn factorise(&mut self) -> Result<(), Cause> {
        self.summary.factorisations += 1;
        self.solver.factorise(&self.S).map_err(Cause::linear)
    }

    /// dq/dt = K⁻¹ r_t with the present factorisation.
    pub(super) fn solve_rate(&mut self) -> Result<(), Cause> {
        self.rate.dq.copy_from_slice(&self.r_t);
        let solved = self.solver.solve(Some(&self.S), &mut self.rate.dq);
        solved.map_err(Cause::linear)
    }

    /// Linear solutions made since the history was cleared.
    pub(super) fn iterations(&self) -> usize {
        solutions(&self.history)
    }

    /// Whether the last correction left only rounding errors. A prediction, by the tangent at
    /// another load, says nothing about convergence.
    fn is_rounding(&mut self, system: &dyn System, q: &[f64], residual: [f64; 3]) -> bool {
        let corrections = &self.history[self.predicted..];
        let predictor = ConvergencePredictor::new(corrections, true);
        let work = [&mut self.trial[..], &mut self.simplified[..]];
        predictor.is_stagnation(residual, self.test.allowed, true)
            && is_rounding(system, &self.S, q, &self.r, work)
    }

    /// Whether the residual evaluated last is within the tolerance, or rounding.
    pub(super) fn is_balanced(&mut self, system: &dyn System, q: &[f64]) -> bool {
        let residual = largest(system.pattern(), &self.r, [0.0; 3]);
        let work = [&mut self.trial[..], &mut self.simplified[..]];
        self.test.ratio(residual, system.scales().measures()) <= 1.0
            || is_rounding(system, &self.S, q, &self.r, work)
    }

    /// Iterates (q, t) from their present values, after a first linear correction from the state
    /// `previous`, if it is given. On success the tangent and r_t at the solution are up to date.
    pub(super) fn correct(
        &mut self,
        system: &mut dyn System,
        q: &mut [f64],
        t: &mut f64,
        condition: Option<&Condition<'_>>,
        previous: Option<(f64, &[f64])>,
    ) -> Result<(), Cause> {
        let prediction = self.history.last().filter(|_| previous.is_some());
        self.predicted = prediction.map_or(0, |_| self.history.len());
        self.test.first = prediction.map_or([0.0; 3], |prediction| prediction.residual);
        let begun = self.history.len() - self.predicted;
        self.evaluate(system, previous, q, *t)
            .map_err(Cause::System)?;
        let work = [&mut self.trial[..], &mut self.simplified[..]];
        self.test.rounding = rounding_errors(system, &self.S, q, work);
        loop {
            let residual = largest(system.pattern(), &self.r, [0.0; 3]);
            let ratio = (self.test).ratio(residual, system.scales().measures());
            let on_condition = condition.is_none_or(|c| c.holds(q, *t));
            // One correction is made even if the prediction is in balance: a small load beside a
            // large one that sets the tolerance would otherwise only see the tangent of the step
            // before.
            let corrected = self.history.len() > self.predicted || ratio == 0.0;
            let balanced = corrected && (ratio <= 1.0 || self.is_rounding(system, q, residual));
            let converged = on_condition && balanced;
            let (mut correction, mut damping) = (0.0, 0.0);
            let ended = converged || self.history.len() - begun >= self.options.max_iterations;
            if !ended {
                let dt = self.solve(q, *t, condition)?;
                let free = self.history.len() - begun <= self.options.full_corrections;
                damping = self.damped_step(system, q, t, (dt, free), ratio)?;
                correction = self.size(&self.dq);
            }
            self.history.push(Iteration {
                residual,
                ratio,
                correction,
                damping,
            });
            if ended {
                return converged.then_some(()).ok_or(Cause::TooManyIterations);
            }
        }
    }

    /// Writes the correction at (q, t) to `dq`; returns that of t.
    pub(super) fn solve(
        &mut self,
        q: &[f64],
        t: f64,
        condition: Option<&Condition<'_>>,
    ) -> Result<f64, Cause> {
        self.summary.factorisations += 1;
        self.dq.copy_from_slice(&self.r);
        self.solver
            .factorise_and_solve(&self.S, &mut self.dq)
            .map_err(Cause::linear)?;
        let Some(c) = condition else {
            return Ok(0.0);
        };
        self.solve_rate()?;
        let missing = c.defect(q, t) - c.change(&self.dq, 0.0);
        let dt = missing / c.change(&self.rate.dq, self.rate.dt);
        if !dt.is_finite() {
            return Err(Cause::Diverged);
        }
        add(&mut self.dq, dt, &self.rate.dq);
        Ok(dt)
    }

    /// Steps along `dq` as far as the natural monotonicity test allows; updates q, t and the
    /// evaluation.
    fn damped_step(
        &mut self,
        system: &mut dyn System,
        q: &mut [f64],
        t: &mut f64,
        (dt, free): (f64, bool),
        ratio: f64,
    ) -> Result<f64, Cause> {
        let full = self.size(&self.dq);
        if !full.is_finite() {
            return Err(Cause::Diverged);
        }
        let mut damping = 1.0;
        let mut last = None;
        while damping >= self.options.smallest_damping {
            self.trial.copy_from_slice(q);
            add(&mut self.trial, damping, &self.dq);
            let trial = std::mem::take(&mut self.trial);
            let next = *t + damping * dt;
            let outcome = self.evaluate(system, Some((*t, &*q)), &trial, next);
            self.trial = trial;
            last = outcome.err();
            if last.is_none() && (free || self.approaches(system, damping, full, ratio)?) {
                q.copy_from_slice(&self.trial);
                *t = next;
                return Ok(damping);
            }
            damping *= 0.5;
        }
        Err(last.map_or(Cause::Diverged, Cause::System))
    }

    /// The natural monotonicity test at the trial.
    fn approaches(
        &mut self,
        system: &dyn System,
        damping: f64,
        full: f64,
        ratio: f64,
    ) -> Result<bool, Cause> {
        let measures = system.scales().measures();
        let residual = largest(system.pattern(), &self.r, [0.0; 3]);
        if self.test.ratio(residual, measures) <= ratio {
            return Ok(true);
        }
        self.simplified.copy_from_slice(&self.r);
        let solved = self.solver.solve(None, &mut self.simplified);
        solved.map_err(Cause::linear)?;
        Ok(self.size(&self.simplified) <= (1.0 - 0.25 * damping) * full)
    }
}
