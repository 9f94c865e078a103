//! Derivatives of tangents by differences, and the shape that they show to become unstable.

use super::{PathDirection, load};
use crate::failure::Cause;
use crate::linear_solver::{LinearSolver, null_vector};
use crate::statics::newton::Newton;
use crate::vectors::{add, generic};
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::System;

/// Largest change of a coordinate, relative to its scale, or of the load, relative to the load, in differences of tangents:
/// the first with which the system can be evaluated.
const CHANGES: [f64; 3] = [1e-4, 1e-6, 1e-8];
/// Inverse iterations for an estimate of the shape of a critical point.
const ESTIMATES: usize = 6;

impl Newton {
    /// An estimate of the shape whose stiffness vanishes first along the path through the state evaluated last:
    /// (K + s dK/ds) ψ = 0 with the least |s|.
    pub(super) fn estimate(
        &mut self,
        system: &mut dyn System,
        guess: (&[f64], f64),
    ) -> Result<Vec<f64>, Cause> {
        let K = self.S.clone();
        if self.factorise().is_err() {
            let null = null_vector(system.pattern(), &K);
            return Ok(null.ok_or(Cause::Diverged)?.vector);
        }
        self.solve_rate()?;
        let rate = self.rate.clone();
        let change = self.derivative(system, guess, &rate, &|newton, _| newton.S.clone())?;
        let mut shape = generic(rate.dq.len());
        for _ in 0..ESTIMATES {
            let mut image = vec![0.0; shape.len()];
            (system.pattern()).multiply_add(1.0 / self.size(&shape), &change, &shape, &mut image);
            let solved = self.solver.solve(Some(&K), &mut image);
            solved.map_err(Cause::linear)?;
            shape = image;
        }
        Ok(shape)
    }

    /// Second derivatives of r in one direction and each of some others, by central differences of tangents.
    pub(super) fn second(
        &mut self,
        system: &mut dyn System,
        (q, t): (&[f64], f64),
        along: &PathDirection,
        with: &[&PathDirection],
    ) -> Result<Vec<Vec<f64>>, Cause> {
        let first = |newton: &Self, pattern: &BlockPattern| {
            let derivatives = with.iter().map(|direction| {
                let mut out = vec![0.0; newton.r_t.len()];
                pattern.multiply_add(-1.0, &newton.S, &direction.dq, &mut out);
                add(&mut out, direction.dt, &newton.r_t);
                out
            });
            derivatives.flatten().collect()
        };
        let second = self.derivative(system, (q, t), along, &first)?;
        Ok(second.chunks(q.len()).map(<[f64]>::to_vec).collect())
    }

    /// The derivative of what is read after an evaluation, in a direction, by central differences.
    fn derivative(
        &mut self,
        system: &mut dyn System,
        (q, t): (&[f64], f64),
        along: &PathDirection,
        read: &dyn Fn(&Self, &BlockPattern) -> Vec<f64>,
    ) -> Result<Vec<f64>, Cause> {
        let size = self.size(&along.dq).max(along.dt.abs() / load(t));
        let mut at = |s: f64| {
            let near: Vec<f64> = q.iter().zip(&along.dq).map(|(q, dq)| q + s * dq).collect();
            self.evaluate(system, None, &near, t + s * along.dt)?;
            Ok(read(self, system.pattern()))
        };
        let mut found = Err(Cause::Diverged);
        for change in CHANGES {
            let h = change / size;
            let both = at(-h).and_then(|before| Ok((before, at(h)?)));
            found = both.map_err(Cause::System).map(|(before, after)| {
                let pairs = before.iter().zip(after);
                pairs.map(|(a, b)| (b - a) / (2.0 * h)).collect()
            });
            if found.is_ok() {
                break;
            }
        }
        found
    }
}
