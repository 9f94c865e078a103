//! Andrews' squeezer mechanism to the published digits, by the program and by the equations of the test set.
#![allow(non_snake_case, clippy::unwrap_used)]

use crate::support::andrews::*;
use crate::support::independent::assert_published;
use nalgebra::{SMatrix, SVector};
use pullback::manifold::implicit::{Choice, Implicit};
use pullback::manifold::jet::Taylor;
use pullback::manifold::scalar::Scalar;

/// Accelerations at given angles and rates from the equations of the IVP test set, with
/// multipliers: M q̈ + Gᵀλ = f, G q̈ = −γ. Nothing here comes from bodies, joints or charts.
fn accelerations(q: &[f64; 7], v: &[f64; 7]) -> [f64; 7] {
    let [_, th, ga, ph, _, om, _] = *q;
    let [bep, thp, _, php, dep, omp, epp] = *v;
    let (m, I) = (MASSES, INERTIAS);
    let (e, f) = (E - EA, ZF - FA);
    let mut K = SMatrix::<f64, 13, 13>::zeros();
    let square = |a: f64, b: f64| a * a + b * b;
    K[(0, 0)] =
        m[0] * RA * RA + m[1] * (RR * RR - 2.0 * DA * RR * th.cos() + DA * DA) + I[0] + I[1];
    K[(1, 0)] = m[1] * (DA * DA - DA * RR * th.cos()) + I[1];
    K[(1, 1)] = m[1] * DA * DA + I[1];
    K[(2, 2)] = m[2] * square(SA, SB) + I[2];
    K[(3, 3)] = m[3] * e * e + I[3];
    K[(4, 3)] = m[3] * (e * e + ZT * e * ph.sin()) + I[3];
    K[(4, 4)] =
        m[3] * (ZT * ZT + 2.0 * ZT * e * ph.sin() + e * e) + m[4] * square(TA, TB) + I[3] + I[4];
    K[(5, 5)] = m[5] * f * f + I[5];
    K[(6, 5)] = m[5] * (f * f - U * f * om.sin()) + I[5];
    K[(6, 6)] =
        m[5] * (f * f - 2.0 * U * f * om.sin() + U * U) + m[6] * square(UA, UB) + I[5] + I[6];
    let arm = [SD * ga.cos() + SC * ga.sin(), SD * ga.sin() - SC * ga.cos()];
    let [x, y] = [arm[0] + B[0] - C[0], arm[1] + B[1] - C[1]];
    let length = x.hypot(y);
    let pull = -STIFFNESS * (length - REST) / length;
    let forces = [
        MOMENT - m[1] * DA * RR * thp * (thp + 2.0 * bep) * th.sin(),
        m[1] * DA * RR * bep * bep * th.sin(),
        pull * (y * arm[0] - x * arm[1]),
        m[3] * ZT * e * dep * dep * ph.cos(),
        -m[3] * ZT * e * php * (php + 2.0 * dep) * ph.cos(),
        -m[5] * U * f * epp * epp * om.cos(),
        m[5] * U * f * omp * (omp + 2.0 * epp) * om.cos(),
    ];
    let along = |rate: &dyn Fn(usize) -> f64| {
        let x = SVector::<Taylor<f64>, 7>::from_fn(|k, _| Taylor {
            v: q[k],
            d: rate(k),
            dd: 0.0,
        });
        Squeezer.h(Taylor::constant(0.0), &x)
    };
    let mut b = SVector::<f64, 13>::zeros();
    for j in 0..7 {
        b[j] = forces[j];
        let column = along(&|k| f64::from(u8::from(k == j)));
        for i in 0..6 {
            K[(7 + i, j)] = column[i].d;
        }
    }
    let bend = along(&|k| v[k]);
    for i in 0..6 {
        b[7 + i] = -bend[i].dd;
    }
    K.fill_upper_triangle_with_lower_triangle();
    let solution = K.lu().solve(&b).unwrap();
    std::array::from_fn(|k| solution[k])
}

/// Angles at the end by the midpoint rule with 2, 4 … 16 substeps in each step, extrapolated (Gragg).
fn by_midpoints(steps: u32) -> [f64; 7] {
    type State = SVector<f64, 14>;
    let rates = |z: &State| -> State {
        let part = |from: usize| std::array::from_fn(|k| z[from + k]);
        let (q, v) = (part(0), part(7));
        let a = accelerations(&q, &v);
        State::from_fn(|k, _| if k < 7 { v[k] } else { a[k - 7] })
    };
    let H = END / f64::from(steps);
    let step = |z: State| {
        let mut row: Vec<State> = Vec::new();
        for k in 1..=8 {
            let h = H / f64::from(2 * k);
            let (mut before, mut now) = (z, z + rates(&z) * h);
            for _ in 1..2 * k {
                (before, now) = (now, before + rates(&now) * (2.0 * h));
            }
            // Errors have even powers of h.
            let mut next = vec![(now + before + rates(&now) * h) * 0.5];
            for (j, coarse) in (1..k).zip(&row) {
                let ratio = f64::from(k) / f64::from(k - j);
                let fine = next[next.len() - 1];
                next.push(fine + (fine - coarse) / (ratio * ratio - 1.0));
            }
            row = next;
        }
        row[row.len() - 1]
    };
    let start = State::from_fn(|k, _| if k < 7 { START[k] } else { 0.0 });
    let end = (0..steps).fold(start, |z, _| step(z));
    std::array::from_fn(|k| end[k])
}

#[test]
fn extrapolated_to_the_published_digits() {
    let map = Loops::with(Squeezer, 0.0, START, Choice::Fixed).unwrap();
    let map = map.with_independent(0.0, [0]).unwrap();
    let runs = [1500, 3000, 6000].map(|n| {
        let run = run(map, n);
        assert!(run.residual < 1e-15, "{:e}", run.residual);
        run.end
    });
    let (reference, rows) = reference();
    println!("errors {:?}", runs.map(|r| errors(&r, &reference)));
    // The trapezoidal rule is symmetric: its errors have even powers of the step.
    let mix = |coarse: &Angles, fine: &Angles, power: f64| -> Angles {
        std::array::from_fn(|d| {
            std::array::from_fn(|k| fine[d][k] + (fine[d][k] - coarse[d][k]) / (power - 1.0))
        })
    };
    let once = [mix(&runs[0], &runs[1], 4.0), mix(&runs[1], &runs[2], 4.0)];
    let twice = mix(&once[0], &once[1], 16.0);
    let found = errors(&twice, &reference);
    println!("extrapolated {found:?}");
    assert!(found[0] < 5e-10 && found[1] < 1e-9, "{found:?}");
    // So do the test set's equations, integrated explicitly; the published beta is above both.
    let explicit = [100, 200].map(by_midpoints);
    let beta = |x: f64| (reference[0][0] - x) / reference[0][0];
    println!(
        "beta below: {:e} {:e}",
        beta(explicit[1][0]),
        beta(twice[0][0])
    );
    let (own, ours) = (
        gap(&explicit[0], &explicit[1]),
        gap(&twice[0], &explicit[1]),
    );
    println!("half the step {own:e}, the program {ours:e}");
    assert!(own < 1e-12 && ours < 1e-11, "{own:e} {ours:e}");
    for beta in [beta(explicit[1][0]), beta(twice[0][0])] {
        assert!((6e-11..8e-11).contains(&beta), "{beta:e}");
    }
    // The published accelerations are those of a method that integrates them, and 1.0e-7 off those
    // that follow from the published angles and rates.
    let [q, v, a] = reference;
    let exact = accelerations(&q, &v);
    let published = gap(&a, &exact);
    let ours = gap(&twice[2], &exact);
    println!("accelerations: published {published:.2e}, found {ours:.2e}");
    assert!((0.9e-7..1.1e-7).contains(&published), "{published:e}");
    assert_published(&rows, "following", &exact, 1e-6);
    assert!(found[2] < 1.2e-7 && ours < 5e-9, "{found:?}, {ours:e}");
}

#[test]
fn all_choices_of_coordinates_give_the_same_motion() {
    assert_choices([750, 1500, 3000]);
}
