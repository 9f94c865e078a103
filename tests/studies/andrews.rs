//! Andrews' squeezer mechanism (IFToMM benchmark A03): the gallery's values beside an integration of the equations
//! of the IVP test set (Mazzia & Magherini 2008, part II-9), whose names the parameters have.

use crate::support::dynamics::integrate_ode;
use crate::support::independent::{assert_published, rows};
use nalgebra::{SMatrix, SVector};
use pullback::manifold::jet::Moving;
use pullback::manifold::scalar::Scalar;
use pullback::studies::gallery::CaseRow;

// Lengths in m, masses in kg, moments of inertia in kg m².
const A: [f64; 3] = [-0.06934, -0.00227, 0.0];
const B: [f64; 3] = [-0.03635, 0.03273, 0.0];
const C: [f64; 3] = [0.014, 0.072, 0.0];
const MASSES: [f64; 7] = [0.04325, 0.00365, 0.02373, 0.00706, 0.0705, 0.00706, 0.05498];
const INERTIAS: [f64; 7] = [
    2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5,
];
const D: f64 = 0.028;
const DA: f64 = 0.0115;
const E: f64 = 0.02;
const EA: f64 = 0.01421;
const RR: f64 = 0.007;
const RA: f64 = 0.00092;
const SS: f64 = 0.035;
const SA: f64 = 0.01874;
const SB: f64 = 0.01043;
const SC: f64 = 0.018;
const SD: f64 = 0.02;
const TA: f64 = 0.02308;
const TB: f64 = 0.00916;
const U: f64 = 0.04;
const UA: f64 = 0.01228;
const UB: f64 = 0.00449;
const ZF: f64 = 0.02;
const ZT: f64 = 0.04;
const FA: f64 = 0.01421;
const STIFFNESS: f64 = 4530.0;
const REST: f64 = 0.07785;
const MOMENT: f64 = 0.033;

/// β, Θ, γ, Φ, δ, Ω, ε at the start.
const START: [f64; 7] = [
    -0.06171389001427645,
    0.0,
    0.45527981916307037,
    0.22266839016588588,
    0.48736497954384256,
    -0.22266839016588588,
    1.2305474445498212,
];

/// Gaps at the point P, at which four bars meet, seen from its four sides.
fn gaps<S: Scalar>(x: &SVector<S, 7>) -> SVector<S, 6> {
    let [be, th, ga, ph, de, om, ep] = *x.as_ref();
    let px = be.cos() * RR - (be + th).cos() * D;
    let py = be.sin() * RR - (be + th).sin() * D;
    SVector::<S, 6>::new(
        px - ga.sin() * SS - B[0],
        py + ga.cos() * SS - B[1],
        px - (ph + de).sin() * E - de.cos() * ZT - A[0],
        py + (ph + de).cos() * E - de.sin() * ZT - A[1],
        px - (om + ep).cos() * ZF - ep.sin() * U - A[0],
        py - (om + ep).sin() * ZF + ep.cos() * U - A[1],
    )
}

const END: f64 = 0.03;

/// Values, rates and accelerations of the seven angles.
type Angles = [[f64; 7]; 3];

/// Largest difference of values (rates, accelerations) relative to the largest of them.
fn gap(found: &[f64; 7], exact: &[f64; 7]) -> f64 {
    let size = exact.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let gaps = found.iter().zip(exact).map(|(a, b)| (a - b).abs() / size);
    gaps.fold(0.0, f64::max)
}

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
        let x = SVector::<Moving<0>, 7>::from_fn(|k, _| Moving::<0>::given([q[k], rate(k), 0.0]));
        gaps(&x)
    };
    let mut b = SVector::<f64, 13>::zeros();
    for j in 0..7 {
        b[j] = forces[j];
        let column = along(&|k| f64::from(k == j));
        for i in 0..6 {
            K[(7 + i, j)] = column[i].x[1];
        }
    }
    let bend = along(&|k| v[k]);
    for i in 0..6 {
        b[7 + i] = -bend[i].x[2];
    }
    K.fill_upper_triangle_with_lower_triangle();
    let solution = K.lu().solve(&b).unwrap();
    std::array::from_fn(|k| solution[k])
}

/// Angles at the end by the classical Runge–Kutta method.
fn by_runge_kutta(steps: usize) -> [f64; 7] {
    let rates = |_: f64, z: &SVector<f64, 14>| {
        let [q, v] = [0, 7].map(|from| std::array::from_fn(|k| z[from + k]));
        let a = accelerations(&q, &v);
        SVector::from_fn(|k, _| if k < 7 { v[k] } else { a[k - 7] })
    };
    let start = SVector::from_fn(|k, _| START.get(k).copied().unwrap_or_default());
    let end = integrate_ode(&rates, start, END, steps);
    std::array::from_fn(|k| end[k])
}

#[test]
fn the_gallery_agrees_with_the_equations_of_the_test_set() {
    let rows = rows("squeezer");
    let of = |value: fn(&CaseRow) -> f64| -> Angles {
        ["angle", "rate", "acceleration"].map(|what| {
            let rows = rows.iter().filter(|row| row.quantity.starts_with(what));
            rows.map(value).collect::<Vec<_>>().try_into().unwrap()
        })
    };
    let (found, published) = (of(|row| row.computed), of(|row| row.published));
    // Angles, by an explicit method; the published beta is above both.
    let explicit = [20_000, 40_000].map(by_runge_kutta);
    let (own, ours) = (
        gap(&explicit[0], &explicit[1]),
        gap(&found[0], &explicit[1]),
    );
    assert!(own < 1e-12 && ours < 1e-11, "{own:e} {ours:e}");
    for beta in [explicit[1][0], found[0][0]] {
        let below = (published[0][0] - beta) / published[0][0];
        assert!((6e-11..8e-11).contains(&below), "{below:e}");
    }
    // The published accelerations are those of a method that integrates them, and 1.0e-7 off those
    // that follow from the published angles and rates.
    let exact = accelerations(&published[0], &published[1]);
    let off = gap(&published[2], &exact);
    assert!((0.9e-7..1.1e-7).contains(&off), "{off:e}");
    assert_published(&rows, "following", &exact, 1e-6);
    let ours = gap(&found[2], &exact);
    assert!(ours < 5e-9, "{ours:e}");
}
