//! Newton's method for equilibrium, at a fixed load or together with a condition on the load.
//!
//! ```text
//! K δq = r + r_λ δλ,        c·δq + c_λ δλ = ds − c·(q − q₀) − c_λ (λ − λ₀)
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

#![allow(non_snake_case)]

use super::{Iteration, StaticNewtonOptions, StaticSummary};
use crate::convergence::ConvergencePredictor;
use crate::failure::{Cost, FailedStep, Failure, FailureContext, StepParameter};
use crate::linear_solver::LinearSolver;
use crate::rounding::{allowed, inverse_scales, is_rounding, rounding_of_gaps};
use pullback_manifold::system::{Evaluation, Point, Quantity, System, SystemError, Weights};

/// A condition c·(q − q₀) + c_λ (λ − λ₀) = ds that replaces a fixed load.
pub(super) struct Condition<'a> {
    pub c: &'a [f64],
    pub c_lambda: f64,
    pub q0: &'a [f64],
    pub lambda0: f64,
    pub ds: f64,
}

impl Condition<'_> {
    fn defect(&self, q: &[f64], lambda: f64) -> f64 {
        let along: f64 = (self.c.iter().zip(q).zip(self.q0))
            .map(|((c, q), q0)| c * (q - q0))
            .sum();
        self.ds - along - self.c_lambda * (lambda - self.lambda0)
    }
}

/// Buffers and history of an iteration.
#[derive(Default)]
pub(super) struct Newton {
    pub r: Vec<f64>,
    pub S: Vec<f64>,
    pub r_lambda: Vec<f64>,
    /// δq at a fixed load, then the whole correction.
    pub dq: Vec<f64>,
    /// dq/dλ at a fixed state of the factorisation.
    pub q_lambda: Vec<f64>,
    trial: Vec<f64>,
    simplified: Vec<f64>,
    /// 1 / typical size of each coordinate; zero for multipliers.
    pub inverse_scale: Vec<f64>,
    pub history: Vec<Iteration>,
    pub evaluations: usize,
    pub factorisations: usize,
    /// First nonzero residual per quantity of a step; for a prediction, the change of the loads.
    unbalanced: [f64; 3],
    /// Whether there are gaps of multipliers, and the largest rounding error in them.
    has_gaps: bool,
    gaps: f64,
    /// Tolerance of the residual per quantity.
    allowed: [f64; 3],
    /// Number of predictions in the history, made before any residual was known.
    predicted: usize,
    options: StaticNewtonOptions,
}

impl Newton {
    pub(super) fn new(system: &dyn System, options: &StaticNewtonOptions) -> Self {
        let n = system.pattern().dim();
        let zeros = || vec![0.0; n];
        Self {
            r: zeros(),
            S: vec![0.0; system.pattern().len()],
            r_lambda: zeros(),
            dq: zeros(),
            q_lambda: zeros(),
            trial: zeros(),
            simplified: zeros(),
            inverse_scale: inverse_scales(system),
            history: Vec::with_capacity(options.max_iterations.min(100) + 1),
            evaluations: 0,
            factorisations: 0,
            unbalanced: [0.0; 3],
            gaps: 0.0,
            has_gaps: (0..n).any(|i| system.coordinate_info(i).is_multiplier),
            allowed: [0.0; 3],
            predicted: 0,
            options: *options,
        }
    }

    /// Largest entry of a coordinate vector relative to the coordinates' scales.
    pub(super) fn size(&self, v: &[f64]) -> f64 {
        (v.iter().zip(&self.inverse_scale)).fold(0.0, |m: f64, (v, s)| {
            let x = (v * s).abs();
            if x > m || x.is_nan() { x } else { m }
        })
    }

    /// Residual, tangent and ∂r/∂λ; the tangent may extrapolate from a previous iterate.
    pub(super) fn evaluate(
        &mut self,
        system: &mut dyn System,
        previous: Option<(f64, &[f64])>,
        q: &[f64],
        lambda: f64,
    ) -> Result<(), SystemError> {
        self.evaluations += 1;
        let rest = |t, q| Point {
            t,
            q,
            v: &[],
            a: &[],
        };
        let out = Evaluation {
            r: &mut self.r,
            S: Some((Weights::STATIC, &mut self.S)),
            r_t: Some(&mut self.r_lambda),
            previous: previous.map(|(t, from)| rest(t, from)),
            accelerations: None,
        };
        system.evaluate(rest(lambda, q), out)
    }

    /// Report of a failed step to `to`.
    pub(super) fn fail(
        &self,
        system: &mut dyn System,
        failure: Failure,
        summary: &StaticSummary,
        to: f64,
    ) -> Box<FailedStep> {
        let context = FailureContext {
            failure,
            r: &self.r,
            S: &self.S,
            history: &self.history,
        };
        let (parameter, span) = (StepParameter::Load, [summary.t, to]);
        let (steps, rejected) = (summary.steps, summary.rejected);
        let cost = Cost {
            evaluations: self.evaluations,
            factorisations: self.factorisations,
        };
        let step = FailedStep::new(system, context, parameter, span, steps, rejected, cost);
        Box::new(step)
    }

    pub(super) fn factorise(&mut self, solver: &mut dyn LinearSolver) -> Result<(), Failure> {
        self.factorisations += 1;
        solver.factorise(&self.S).map_err(Failure::Linear)
    }

    /// dq/dλ = K⁻¹ r_λ with the present factorisation.
    pub(super) fn solve_rate(&mut self, solver: &mut dyn LinearSolver) -> Result<(), Failure> {
        self.q_lambda.copy_from_slice(&self.r_lambda);
        solver
            .solve(Some(&self.S), &mut self.q_lambda)
            .map_err(Failure::Linear)
    }

    /// Linear solutions made since the history was cleared.
    pub(super) fn iterations(&self) -> usize {
        self.history.iter().filter(|i| i.damping > 0.0).count()
    }

    /// Largest entry per quantity of a residual vector.
    pub(super) fn largest(&self, system: &dyn System, r: &[f64]) -> [f64; 3] {
        let mut largest = [0.0_f64; 3];
        for (i, r) in r.iter().enumerate() {
            let k = system.coordinate_info(i).quantity.index();
            largest[k] = largest[k].max(r.abs());
        }
        largest
    }

    /// Whether the last correction left only rounding errors. A prediction, by the tangent at
    /// another load, says nothing about convergence.
    fn is_rounding(&mut self, system: &dyn System, q: &[f64], residual: [f64; 3]) -> bool {
        let corrections = &self.history[self.predicted..];
        ConvergencePredictor::new(corrections, true).is_stagnation(residual, self.allowed, true)
            && {
                let room = [&mut self.trial[..], &mut self.simplified[..]];
                is_rounding(system, &self.S, q, &self.r, room)
            }
    }

    /// Residual per quantity, and the largest of them relative to the tolerance.
    fn test(&mut self, system: &dyn System) -> ([f64; 3], f64) {
        let largest = self.largest(system, &self.r);
        let measures = system.scales().measures();
        let mut ratio = 0.0_f64;
        for (first, &most) in self.unbalanced.iter_mut().zip(&largest) {
            if *first == 0.0 {
                *first = most;
            }
        }
        let StaticNewtonOptions {
            relative, absolute, ..
        } = self.options;
        let mut least = [absolute; 3];
        least[Quantity::Other.index()] = absolute.max(self.gaps);
        self.allowed = allowed(measures, self.unbalanced, relative, least);
        for (most, allowed) in largest.iter().zip(self.allowed) {
            ratio = ratio.max(most / allowed);
        }
        (largest, ratio)
    }

    /// Iterates (q, λ) from their present values; if `history` is not empty, a first linear
    /// correction was made from the state `previous`. On success the tangent and r_λ at the
    /// solution are up to date.
    pub(super) fn correct(
        &mut self,
        system: &mut dyn System,
        solver: &mut dyn LinearSolver,
        q: &mut [f64],
        lambda: &mut f64,
        condition: Option<&Condition<'_>>,
        previous: Option<(f64, &[f64])>,
    ) -> Result<(), Failure> {
        let options = self.options;
        self.predicted = 0;
        self.unbalanced = [0.0; 3];
        if let (Some(prediction), true) = (self.history.last(), previous.is_some()) {
            self.predicted = self.history.len();
            self.unbalanced = prediction.residual;
        }
        self.evaluate(system, previous, q, *lambda)
            .map_err(Failure::System)?;
        if self.has_gaps {
            let room = [&mut self.trial[..], &mut self.simplified[..]];
            self.gaps = rounding_of_gaps(system, &self.S, q, room);
        }
        loop {
            let (residual, ratio) = self.test(system);
            let on_condition =
                condition.is_none_or(|c| c.defect(q, *lambda).abs() <= 1e-9 * c.ds.abs() + 1e-14);
            // One correction is made even if the prediction is in balance: a small load beside a
            // large one that sets the tolerance would otherwise only see the tangent of the step
            // before.
            let corrected = self.history.len() > self.predicted || ratio == 0.0;
            let balanced = corrected && (ratio <= 1.0 || self.is_rounding(system, q, residual));
            let stop = on_condition && balanced;
            if stop || self.history.len() >= options.max_iterations {
                self.history.push(Iteration {
                    residual,
                    ratio,
                    correction: 0.0,
                    damping: 0.0,
                });
                return if stop {
                    Ok(())
                } else {
                    Err(Failure::TooManyIterations)
                };
            }
            self.factorisations += 1;
            self.dq.copy_from_slice(&self.r);
            solver
                .factorise_and_solve(&self.S, &mut self.dq)
                .map_err(Failure::Linear)?;
            let mut d_lambda = 0.0;
            if let Some(c) = condition {
                self.solve_rate(solver)?;
                let dot = |v: &[f64]| -> f64 { c.c.iter().zip(v).map(|(c, v)| c * v).sum() };
                let slope = dot(&self.q_lambda) + c.c_lambda;
                d_lambda = (c.defect(q, *lambda) - dot(&self.dq)) / slope;
                if !d_lambda.is_finite() {
                    return Err(Failure::Diverged);
                }
                for (dq, rate) in self.dq.iter_mut().zip(&self.q_lambda) {
                    *dq += d_lambda * rate;
                }
            }
            let damping = self.damped_step(system, solver, q, lambda, d_lambda, ratio)?;
            self.history.push(Iteration {
                residual,
                ratio,
                correction: self.size(&self.dq),
                damping,
            });
        }
    }

    /// Steps along `dq` as far as the natural monotonicity test allows; updates q, λ and the
    /// evaluation.
    fn damped_step(
        &mut self,
        system: &mut dyn System,
        solver: &mut dyn LinearSolver,
        q: &mut [f64],
        lambda: &mut f64,
        d_lambda: f64,
        ratio: f64,
    ) -> Result<f64, Failure> {
        let full = self.size(&self.dq);
        let free = self.history.len() <= self.options.full_corrections;
        if !full.is_finite() {
            return Err(Failure::Diverged);
        }
        let mut damping = 1.0;
        let mut last = None;
        while damping >= self.options.smallest_damping {
            self.trial.copy_from_slice(q);
            for (x, d) in self.trial.iter_mut().zip(&self.dq) {
                *x += damping * d;
            }
            let trial = std::mem::take(&mut self.trial);
            let outcome = self.evaluate(
                system,
                Some((*lambda, &*q)),
                &trial,
                *lambda + damping * d_lambda,
            );
            self.trial = trial;
            let accepted = match outcome {
                Err(error) => {
                    last = Some(error);
                    false
                }
                Ok(()) => {
                    last = None;
                    free || self.test(system).1 <= ratio || {
                        self.simplified.copy_from_slice(&self.r);
                        solver
                            .solve(None, &mut self.simplified)
                            .map_err(Failure::Linear)?;
                        self.size(&self.simplified) <= (1.0 - 0.25 * damping) * full
                    }
                }
            };
            if accepted {
                q.copy_from_slice(&self.trial);
                *lambda += damping * d_lambda;
                return Ok(damping);
            }
            damping *= 0.5;
        }
        Err(last.map_or(Failure::Diverged, Failure::System))
    }
}
