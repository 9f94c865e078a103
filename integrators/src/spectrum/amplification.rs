//! The amplification matrix of a scheme, by its steps.

use crate::dynamics::{
    DynamicOptions, DynamicsError, NewtonOptions, Scheme, State, Stepper, Summary,
};
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::{Evaluation, Point, System, SystemError};

/// q̈ + ω² q = 0.
struct Oscillator {
    pattern: BlockPattern,
    /// ω².
    k: f64,
}

impl System for Oscillator {
    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        out.r[0] = -self.k * at.q[0] - at.a[0];
        if let Some((w, S)) = out.S {
            S[0] = w.K * self.k + w.M;
        }
        Ok(())
    }
}

/// The amplification matrix at Ω = ω h, by rows, of (q, h q̇/(1 + Ω), h² y/(1 + Ω²)), scaled so that
/// its entries stay of order one. Found by one step of size 1 from each unit state, by the step
/// routine of all runs; limits of the step size are ignored.
///
/// # Errors
/// [`DynamicsError::Option`] unless Ω is positive and finite, or that of a step that fails.
pub fn amplification(scheme: &Scheme, Omega: f64) -> Result<[[f64; 3]; 3], DynamicsError> {
    if !(Omega > 0.0 && Omega.is_finite()) {
        return Err(DynamicsError::Option {
            name: "Omega",
            value: Omega,
            wanted: "it must be positive and finite",
        });
    }
    let mut system = Oscillator {
        pattern: BlockPattern::dense(1),
        k: Omega * Omega,
    };
    let options = DynamicOptions {
        scheme: *scheme,
        newton: NewtonOptions {
            relative: 1e-15,
            absolute: f64::MIN_POSITIVE,
            ..NewtonOptions::default()
        },
        ..DynamicOptions::new(1.0, 1.0)
    };
    let mut stepper = Stepper::new(&system, &options)?;
    let unit = [1.0, 1.0 + Omega, 1.0 + Omega * Omega];
    let mut A = [[0.0; 3]; 3];
    for (j, size) in unit.into_iter().enumerate() {
        let entry = |i: usize| if i == j { size } else { 0.0 };
        let state = State {
            t: 0.0,
            q: vec![entry(0)],
            v: vec![entry(1)],
            // The true acceleration is that of the equation of motion.
            a: vec![-system.k * entry(0)],
            algorithmic: vec![entry(2)],
            filtered: vec![-system.k * entry(0)],
        };
        stepper
            .step(&mut system, scheme, &state, 1.0)
            .map_err(|failure| {
                stepper.fail(&mut system, failure, [0.0, 1.0], &Summary::default())
            })?;
        let State {
            q, v, algorithmic, ..
        } = &stepper.next;
        for (i, end) in [q[0], v[0], algorithmic[0]].into_iter().enumerate() {
            A[i][j] = end / unit[i];
        }
    }
    Ok(A)
}
