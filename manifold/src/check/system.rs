//! The laws of a system: the assembled tangent, taken out of its pattern, is that of its residual.

use super::forces::{Forces, State, forces_at};
use super::report::Report;
use crate::sparse::BlockPattern;
use crate::system::{Evaluation, Point, System, Weights};
use nalgebra::{DMatrix, DVector};

/// The full matrix of values in a pattern.
pub fn dense(pattern: &BlockPattern, values: &[f64]) -> DMatrix<f64> {
    let n = pattern.dim();
    let mut out = DMatrix::zeros(n, n);
    for j in 0..pattern.blocks() {
        for (i, range) in pattern.column(j) {
            let (rows, columns) = (pattern.unknowns(i), pattern.unknowns(j));
            let block = DMatrix::from_column_slice(rows.len(), columns.len(), &values[range]);
            out.view_mut((rows.start, columns.start), block.shape())
                .copy_from(&block);
        }
    }
    out
}

/// Checks a system's residual and tangents at given states.
///
/// ∂r/∂t is asked at rest only: in motion the path of driven coordinates would need a third time
/// derivative, which no solver asks for.
pub fn system(subject: &str, system: &mut dyn System, states: &[(String, State)]) -> Report {
    let symmetric = system.is_symmetric();
    let mut report = forces_at(subject, states, symmetric, |s| all(system, s));
    for (at, state) in states {
        let Some(f) = all(system, state) else {
            continue;
        };
        // One evaluation with three weights is the weighted sum of three evaluations.
        let weights = Weights {
            K: 0.7,
            C: -1.3,
            M: 2.1,
        };
        let mut sum = &f.K * weights.K;
        if let (Some(C), Some(M)) = (&f.C, &f.M) {
            sum += C * weights.C + M * weights.M;
        }
        let (r, S) =
            one(system, state, weights).unwrap_or_else(|| (f.r.clone(), sum.clone() * f64::NAN));
        report.defect(
            "S = cK K + cC C + cM M",
            at,
            (&S - &sum).norm(),
            1e-12 * (f.K.norm() + sum.norm()),
        );
        let mut alone = DVector::zeros(r.len());
        let done = system.evaluate(point(state), Evaluation::residual(alone.as_mut_slice()));
        let gap = if done.is_ok() {
            (&alone - &r).norm()
        } else {
            f64::NAN
        };
        report.defect("r does not depend on what else is asked", at, gap, 0.0);
    }
    report
}

fn point(s: &State) -> Point<'_> {
    Point {
        t: s.t,
        q: s.x.as_slice(),
        v: s.v.as_slice(),
        a: s.a.as_slice(),
    }
}

fn one(
    system: &mut dyn System,
    state: &State,
    weights: Weights,
) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let mut r = DVector::zeros(state.x.len());
    // Entries that an evaluation forgets to overwrite show up.
    let mut values = vec![1e3; system.pattern().len()];
    let out = Evaluation::with_tangent(r.as_mut_slice(), weights, &mut values);
    system.evaluate(point(state), out).ok()?;
    let S = dense(system.pattern(), &values);
    Some((r, S))
}

fn all(system: &mut dyn System, state: &State) -> Option<Forces> {
    let weights = |K, C, M| Weights { K, C, M };
    let (r, K) = one(system, state, weights(1.0, 0.0, 0.0))?;
    let (mut C, mut M, mut r_t) = (None, None, None);
    if state.is_static() {
        let mut again = r.clone();
        let mut rate = DVector::from_element(r.len(), 1e3);
        let out = Evaluation {
            r: again.as_mut_slice(),
            S: None,
            r_t: Some(rate.as_mut_slice()),
        };
        system.evaluate(point(state), out).ok()?;
        r_t = Some(rate);
    } else {
        C = Some(one(system, state, weights(0.0, 1.0, 0.0))?.1);
        M = Some(one(system, state, weights(0.0, 0.0, 1.0))?.1);
    }
    Some(Forces {
        r,
        K,
        C,
        M,
        r_t,
        energy: None,
    })
}
