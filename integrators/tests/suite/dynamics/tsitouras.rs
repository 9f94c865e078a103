//! The pair of Tsitouras: its order conditions, adaptive steps.

use crate::support::dynamics::*;
use crate::support::*;
use std::f64::consts::FRAC_PI_2;

type Vector = [f64; 7];

fn dot(a: &Vector, b: &Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// By how much weights miss the conditions of order 1 to 5, one for each rooted tree (Hairer, Nørsett &
/// Wanner, *Solving Ordinary Differential Equations I*, II.2): Σ bᵢ Φᵢ = 1/γ.
fn conditions(b: &Vector, A: &[Vector; 7], c: &Vector) -> Vec<(usize, f64)> {
    let one = [1.0; 7];
    let of = |x: &Vector| A.map(|row| dot(&row, x));
    let times = |a: &Vector, b: &Vector| -> Vector { std::array::from_fn(|i| a[i] * b[i]) };
    let (c2, Ac) = (times(c, c), of(c));
    let (c3, Ac2, AAc) = (times(&c2, c), of(&c2), of(&Ac));
    [
        (1, one, 1.0),
        (2, *c, 2.0),
        (3, c2, 3.0),
        (3, Ac, 6.0),
        (4, c3, 4.0),
        (4, times(c, &Ac), 8.0),
        (4, Ac2, 12.0),
        (4, AAc, 24.0),
        (5, times(&c2, &c2), 5.0),
        (5, times(&c2, &Ac), 10.0),
        (5, times(&Ac, &Ac), 20.0),
        (5, times(c, &Ac2), 15.0),
        (5, of(&c3), 20.0),
        (5, times(c, &AAc), 30.0),
        (5, of(&times(c, &Ac)), 40.0),
        (5, of(&Ac2), 60.0),
        (5, of(&AAc), 120.0),
    ]
    .map(|(order, tree, gamma)| (order, (dot(b, &tree) - 1.0 / gamma).abs()))
    .to_vec()
}

#[test]
fn the_coefficients_satisfy_the_order_conditions() {
    let scheme = Scheme::tsitouras();
    let rows = scheme.stages();
    assert_eq!(rows.len(), 6);
    let (mut A, mut c) = ([[0.0; 7]; 7], [0.0; 7]);
    for (i, row) in rows.iter().enumerate() {
        (A[i + 1], c[i + 1]) = (row.v, row.c);
        assert!((row.v.iter().sum::<f64>() - row.c).abs() < 1e-15, "{row:?}");
        // Explicit.
        assert!(row.v[i + 1..].iter().all(|a| *a == 0.0), "{row:?}");
    }
    // The last stage is the new state, and the first one of the next step.
    let (b, embedded) = (A[6], scheme.embedded().unwrap());
    assert_eq!(c[6], 1.0);
    for (order, gap) in conditions(&b, &A, &c) {
        assert!(gap < 2e-15, "order {order}: {gap:e}");
    }
    let gaps = conditions(&embedded.v, &A, &c);
    for (order, gap) in &gaps {
        assert!(*order == 5 || *gap < 2e-15, "order {order}: {gap:e}");
    }
    // An estimate of every term of order 5.
    assert!(gaps.iter().all(|(order, gap)| *order < 5 || *gap > 1e-4));
    // Positions are those of the same method: Q = A A.
    for row in rows.iter().chain([embedded]) {
        for (k, q) in row.q.iter().enumerate() {
            let column = A.map(|row| row[k]);
            assert!((q - dot(&row.v, &column)).abs() < 1e-14, "{row:?}");
        }
    }
}

#[test]
fn adaptive_steps_meet_the_tolerance() {
    // IFToMM A01: from the horizontal at rest, the position at 1.
    let exact = [0.986_291_751_131_875_f64, -0.165_010_853_125_541];
    let exact = exact[0].atan2(-exact[1]);
    for exponent in 4..12 {
        let tolerance = 10.0_f64.powi(-exponent);
        let options = adaptive(steps_of(Scheme::tsitouras(), 1.0, 0.5), tolerance, 10.0);
        let end = run(Pendulum::new(), -FRAC_PI_2, 0.0, &options);
        let error = (end.state.q[0] - exact).abs();
        assert!(error < tolerance, "{tolerance:e}: {error:e}");
        // The number of steps goes like the power 1/5 of the tolerance.
        let most = 8.0 * tolerance.powf(-0.2);
        assert!((end.summary.evaluations as f64) < most, "{:?}", end.summary);
    }
}
