//! A second-order system as a first-order one.

use pullback_elements::model::Context;
use pullback_integrators::dynamics::DynamicsError;
use pullback_integrators::linear_solver::{AutoSolver, LinearSolver, MatrixSymmetry};
use pullback_manifold::system::{Evaluation, Point, System, Weights};

/// ẏ of y = (q, q̇) and its derivative, with counts of their cost. A state that cannot be evaluated gives
/// NaN, and the reason is stored.
pub(super) struct FirstOrderSystem<'a> {
    pub system: &'a mut Context,
    solver: AutoSolver,
    n: usize,
    r: Vec<f64>,
    M: Vec<f64>,
    K: Vec<f64>,
    C: Vec<f64>,
    zero: Vec<f64>,
    a: Vec<f64>,
    /// Time and y of K, C and the factors of M.
    at: Option<(f64, Vec<f64>)>,
    pub evaluations: usize,
    pub factorisations: usize,
    pub failure: Option<String>,
}

impl<'a> FirstOrderSystem<'a> {
    pub fn new(system: &'a mut Context) -> Result<Self, DynamicsError> {
        let solver = AutoSolver::new(system.pattern(), MatrixSymmetry::General)
            .map_err(|source| DynamicsError::Analysis { source })?;
        let (n, len) = (system.pattern().dim(), system.pattern().len());
        Ok(Self {
            system,
            solver,
            n,
            r: vec![0.0; n],
            M: vec![0.0; len],
            K: vec![0.0; len],
            C: vec![0.0; len],
            zero: vec![0.0; n],
            a: vec![0.0; n],
            at: None,
            evaluations: 0,
            factorisations: 0,
            failure: None,
        })
    }

    /// q̈ into `a`, the factors of M in the solver.
    fn accelerate(&mut self, t: f64, y: &[f64]) -> Result<(), String> {
        self.at = None;
        if y.iter().any(|y| !y.is_finite()) {
            return Err("it evaluates a state that is not finite".to_owned());
        }
        let (q, v) = y.split_at(self.n);
        let a = &self.zero[..];
        let out = Evaluation::with_tangent(&mut self.r, Weights::MASS, &mut self.M);
        self.evaluations += 1;
        let done = self.system.evaluate(Point { t, q, v, a }, out);
        done.map_err(|error| error.to_string())?;
        self.factorisations += 1;
        self.a.copy_from_slice(&self.r);
        let solved = self.solver.factorise_and_solve(&self.M, &mut self.a);
        solved.map_err(|error| format!("the mass matrix: {error}"))
    }

    /// ẏ; NaN where it cannot be evaluated.
    pub fn rate(&mut self, t: f64, y: &[f64], out: &mut [f64]) {
        let solved = self.accelerate(t, y);
        let parts = [&y[self.n..], &self.a];
        self.failure = write(solved, parts, out).or(self.failure.take());
    }

    /// K and C at y.
    fn linearise(&mut self, t: f64, y: &[f64]) -> Result<(), String> {
        if (self.at.as_ref()).is_some_and(|(known, state)| *known == t && state == y) {
            return Ok(());
        }
        self.accelerate(t, y)?;
        let (q, v) = y.split_at(self.n);
        for (weights, S) in Weights::PARTS.into_iter().zip([&mut self.K, &mut self.C]) {
            let out = Evaluation::with_tangent(&mut self.r, weights, S);
            let a = &self.a[..];
            self.evaluations += 1;
            let done = self.system.evaluate(Point { t, q, v, a }, out);
            done.map_err(|error| error.to_string())?;
        }
        self.at = Some((t, y.to_vec()));
        Ok(())
    }

    /// The derivative of ẏ in the direction `dy`.
    pub fn derivative(&mut self, t: f64, y: &[f64], dy: &[f64], out: &mut [f64]) {
        let (dq, dv) = dy.split_at(self.n);
        let solved = self.linearise(t, y).and_then(|()| {
            let pattern = self.system.pattern();
            self.r.fill(0.0);
            pattern.multiply_add(-1.0, &self.K, dq, &mut self.r);
            pattern.multiply_add(-1.0, &self.C, dv, &mut self.r);
            let solved = self.solver.solve(Some(&self.M), &mut self.r);
            solved.map_err(|error| format!("the mass matrix: {error}"))
        });
        self.failure = write(solved, [dv, &self.r], out).or(self.failure.take());
    }
}

/// Writes both halves of a result; where it cannot be evaluated NaN, and returns the reason.
fn write(solved: Result<(), String>, halves: [&[f64]; 2], out: &mut [f64]) -> Option<String> {
    let (first, second) = out.split_at_mut(out.len() / 2);
    first.copy_from_slice(halves[0]);
    second.copy_from_slice(halves[1]);
    let failure = solved.err();
    if failure.is_some() {
        out.fill(f64::NAN);
    }
    failure
}
