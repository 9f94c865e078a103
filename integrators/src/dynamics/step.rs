//! One step of the generalised-α family: predict, evaluate, solve, correct, accept.

#![allow(non_snake_case)]

use super::{NewtonOptions, Scheme, State};
use crate::failure::Failure;
use crate::linear_solver::LinearSolver;
use crate::statics::Iteration;
use pullback_manifold::system::{Evaluation, Point, System, SystemError, Weights};

/// Where Newton's iteration of a step begins; velocities and accelerations follow by the scheme.
///
/// Measured on the right-angle cantilever and the robot arms of \[M04\] 4.2: going on with the
/// velocity takes 5 to 20 % fewer iterations. It diverges there with a plain tangent, but not with
/// stresses taken from the previous iterate ([`System::evaluate_from`]). Keeping the acceleration
/// instead is worse than both: the trapezoidal rule leaves it oscillating.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Predictor {
    /// Coordinates go on with their velocities, qₙ + h q̇ₙ.
    #[default]
    Velocity,
    /// Coordinates stay: the iteration starts from a configuration that was in balance.
    Keep,
}

/// How often the tangent is factorised in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tangent {
    /// In every iteration: quadratic convergence.
    #[default]
    Every,
    /// Once at the beginning of a step: more iterations, each of them cheaper.
    Once,
}

/// Corrections relative to the scales of their coordinates that are nothing but rounding.
const ROUNDING: f64 = 1e-13;

/// Buffers of the step routine, made once per run.
pub(super) struct Stepper {
    pub r: Vec<f64>,
    pub S: Vec<f64>,
    dq: Vec<f64>,
    /// Coordinates of the iterate before.
    before: Vec<f64>,
    /// The state aimed at.
    pub next: State,
    pub history: Vec<Iteration>,
    pub evaluations: usize,
    pub factorisations: usize,
    options: NewtonOptions,
}

impl Stepper {
    pub(super) fn new<Y: System + ?Sized>(system: &Y, options: &NewtonOptions) -> Self {
        let n = system.pattern().dim();
        let zeros = || vec![0.0; n];
        Self {
            r: zeros(),
            S: vec![0.0; system.pattern().len()],
            dq: zeros(),
            before: zeros(),
            next: State {
                t: 0.0,
                q: zeros(),
                v: zeros(),
                a: zeros(),
                algorithmic: zeros(),
            },
            history: Vec::with_capacity(options.max_iterations.min(100) + 1),
            evaluations: 0,
            factorisations: 0,
            options: *options,
        }
    }

    /// From `state` to the time `t`; the result is in `next`, `state` is not touched.
    pub(super) fn step<Y: System + ?Sized>(
        &mut self,
        system: &mut Y,
        solver: &mut dyn LinearSolver,
        scheme: &Scheme,
        state: &State,
        t: f64,
    ) -> Result<(), Failure> {
        let rates = scheme.rates(t - state.t);
        let weights = Weights {
            K: 1.0,
            C: rates[1],
            M: rates[2],
        };
        self.history.clear();
        self.predict(scheme, state, t);
        let mut allowed = [0.0; 3];
        loop {
            let fresh = self.history.is_empty() || self.options.tangent == Tangent::Every;
            // A state that will turn out to be in balance needs no tangent.
            let last = fresh && self.balance_expected();
            self.evaluate(system, (fresh && !last).then_some(weights), state)?;
            let residual = largest(system, &self.r);
            if self.history.is_empty() {
                allowed = self.allow(system, residual);
            }
            let ratio = (0..3).map(|k| residual[k] / allowed[k]).fold(0.0, f64::max);
            // Corrections of the size of rounding errors that change nothing any more.
            let stalled = self
                .history
                .last()
                .is_some_and(|i| i.correction <= ROUNDING && ratio > 0.1 * i.ratio);
            let converged = ratio <= 1.0 || stalled;
            if converged || self.history.len() >= self.options.max_iterations {
                self.record(residual, ratio, 0.0, 0.0);
                return if converged {
                    Ok(())
                } else {
                    Err(Failure::TooManyIterations)
                };
            }
            if last {
                self.evaluate(system, Some(weights), state)?;
            }
            let correction = self.solve(system, solver, fresh)?;
            self.correct(rates);
            self.record(residual, ratio, correction, 1.0);
            let first = self.history[0].ratio;
            if !(correction.is_finite() && ratio <= 1e12 * first) {
                return Err(Failure::Diverged);
            }
        }
    }

    /// Linear solutions of the last step.
    pub(super) fn iterations(&self) -> usize {
        self.history.iter().filter(|i| i.damping > 0.0).count()
    }

    /// Whether the next residual is below its limit if convergence goes on quadratically: errors
    /// then fall as the squares of the corrections do.
    fn balance_expected(&self) -> bool {
        match self.history[..] {
            [.., before, last] => last.ratio * (last.correction / before.correction).powi(2) <= 1.0,
            _ => false,
        }
    }

    /// qₙ₊₁ by the predictor; aₙ₊₁, q̇ₙ₊₁ and q̈ₙ₊₁ by the scheme.
    fn predict(&mut self, scheme: &Scheme, state: &State, t: f64) {
        let h = t - state.t;
        let Scheme {
            alpha_m,
            alpha_f,
            beta,
            gamma,
            ..
        } = *scheme;
        self.next.t = t;
        for i in 0..state.q.len() {
            let (v, old) = (state.v[i], state.algorithmic[i]);
            let free = h * v + h * h * (0.5 - beta) * old;
            let dq = match self.options.predictor {
                Predictor::Keep => 0.0,
                Predictor::Velocity => h * v,
            };
            let new = (dq - free) / (beta * h * h);
            self.next.q[i] = state.q[i] + dq;
            self.next.algorithmic[i] = new;
            self.next.v[i] = v + h * ((1.0 - gamma) * old + gamma * new);
            self.next.a[i] =
                ((1.0 - alpha_m) * new + alpha_m * old - alpha_f * state.a[i]) / (1.0 - alpha_f);
        }
    }

    fn evaluate<Y: System + ?Sized>(
        &mut self,
        system: &mut Y,
        weights: Option<Weights>,
        state: &State,
    ) -> Result<(), Failure> {
        self.evaluations += 1;
        let at = Point {
            t: self.next.t,
            q: &self.next.q,
            v: &self.next.v,
            a: &self.next.a,
        };
        let out = Evaluation {
            r: &mut self.r,
            S: weights.map(|w| (w, &mut self.S[..])),
            r_t: None,
        };
        // The tangent may take its stresses from the iterate before: a slender structure's large
        // corrections leave stresses that are none.
        if self.history.is_empty() {
            self.before.copy_from_slice(&state.q);
        }
        let from = Point {
            t: if self.history.is_empty() {
                state.t
            } else {
                self.next.t
            },
            q: &self.before,
            ..at
        };
        match weights {
            Some(_) => system.evaluate_from(from, at, out),
            None => system.evaluate(at, out),
        }
        .map_err(Failure::System)?;
        match self.r.iter().position(|r| !r.is_finite()) {
            None => Ok(()),
            Some(i) => Err(Failure::System(SystemError::NotFinite {
                what: system.name(i),
            })),
        }
    }

    /// What residual per kind counts as balance, relative to the forces of this step.
    fn allow<Y: System + ?Sized>(&self, system: &Y, first: [f64; 3]) -> [f64; 3] {
        let scales = system.scales();
        let mut force: [f64; 3] = std::array::from_fn(|k| scales.force[k].max(first[k]));
        // Forces and moments measure each other over the size of the system.
        let length = scales.coordinate[0];
        let (f, m) = (force[0], force[1]);
        force[0] = f.max(m / length);
        force[1] = m.max(f * length);
        force.map(|f| (self.options.relative * f).max(self.options.absolute))
    }

    /// Solves for the correction; its size relative to the scales of the coordinates.
    fn solve<Y: System + ?Sized>(
        &mut self,
        system: &Y,
        solver: &mut dyn LinearSolver,
        fresh: bool,
    ) -> Result<f64, Failure> {
        if fresh {
            self.factorisations += 1;
            solver.factorise(&self.S).map_err(Failure::Linear)?;
        }
        self.dq.copy_from_slice(&self.r);
        solver
            .solve(Some(&self.S), &mut self.dq)
            .map_err(Failure::Linear)?;
        let scales = system.scales().coordinate;
        // Multipliers are judged by the residual that they leave.
        let judged = |(i, _): &(usize, &f64)| !system.is_multiplier(*i);
        let size = |(i, dq): (usize, &f64)| dq.abs() / scales[system.kind(i).index()];
        let all = self.dq.iter().enumerate().filter(judged);
        Ok(all.map(size).fold(0.0, f64::max))
    }

    fn correct(&mut self, [a, v, q_ddot]: [f64; 3]) {
        self.before.copy_from_slice(&self.next.q);
        for (i, dq) in self.dq.iter().enumerate() {
            self.next.q[i] += dq;
            self.next.algorithmic[i] += a * dq;
            self.next.v[i] += v * dq;
            self.next.a[i] += q_ddot * dq;
        }
    }

    fn record(&mut self, residual: [f64; 3], ratio: f64, correction: f64, damping: f64) {
        self.history.push(Iteration {
            residual,
            ratio,
            correction,
            damping,
        });
    }
}

/// Largest entry per kind of a residual.
fn largest<Y: System + ?Sized>(system: &Y, r: &[f64]) -> [f64; 3] {
    let mut largest = [0.0_f64; 3];
    for (i, r) in r.iter().enumerate() {
        let k = system.kind(i).index();
        largest[k] = largest[k].max(r.abs());
    }
    largest
}
