//! The jets against the num-dual crate: one function, two implementations of differentiation.

use crate::support::*;
use num_dual::{Derivative, Dual3, DualNum, DualSVec64};
use pullback_manifold::quotients;
use std::f64::consts::FRAC_PI_2;

const D: usize = 4;
const N: usize = 3;
/// Both evaluate the same few dozen operations; the sums differ in their order only.
const EXACT: f64 = 1e-13;

/// Every operation and elementary function once, nested, with quotients, powers and constants.
///
/// A macro because the two crates have no common trait.
macro_rules! phi {
    ($t:expr, $q:expr) => {{
        let (t, q) = ($t, $q);
        let a = (q[0] * q[1] + 1.5).sin() / (q[2] * q[2] + 0.5).sqrt();
        let b = (q[3] - q[0] * 0.3).exp() * (q[1].cos() + 2.0).ln();
        let c = (q[2] * t).tan() - (q[3] * q[0]).atan() * 2.0;
        let mut d = (a * b - c).powi(3) + (b + 0.7).recip();
        let mut e = -c;
        e += a;
        e -= b - 0.6;
        e *= a;
        d += e;
        [
            a * c + d / 3.0,
            (a * a + b * b + 0.1).sqrt() - q[1].powi(2) * t,
            d.atan2(b + 1.0) + q[1].powi(-1),
        ]
    }};
}

#[derive(Clone)]
struct Phi;

impl Map<D, N> for Phi {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, D>) -> SVector<S, N> {
        SVector::from(phi!(t, q))
    }
}

const Q: [f64; D] = [0.4, 0.9, -0.6, 0.3];
const T: f64 = 0.8;

#[track_caller]
fn close(name: &str, found: f64, expected: f64) {
    let error = (found - expected).abs() / (1.0 + expected.abs());
    assert!(error < EXACT, "{name}: {found} for {expected}: {error:e}");
}

/// A constant with an all-zero gradient (num-dual leaves it empty otherwise).
fn variable(value: f64, i: usize) -> DualSVec64<D> {
    DualSVec64::new(
        value,
        Derivative::some(SVector::from_fn(|k, _| f64::from(k == i))),
    )
}

fn gradient(x: &DualSVec64<D>) -> SVector<f64, D> {
    x.eps.unwrap_generic(nalgebra::Const::<D>, nalgebra::U1)
}

#[test]
fn values_and_gradients_are_those_of_num_dual() {
    let q = Q.map(f64::constant);
    let plain = phi!(T, q);
    let tangent = Phi.tangent(T, &Q.into());
    let dual: [DualSVec64<D>; D] = std::array::from_fn(|i| variable(Q[i], i));
    let dual = phi!(DualSVec64::from_re(T), dual);
    for i in 0..N {
        close("phi", plain[i], dual[i].re);
        close("x", tangent.x[i], dual[i].re);
        let B = gradient(&dual[i]);
        for j in 0..D {
            close("B", tangent.B[(i, j)], B[j]);
        }
    }
}

/// Structure of every kind: q0 enters by a sum only, q1 with the time, q2 by its square, q3 to q6
/// with each other; the number of variables is odd and larger than a block of the Hessian.
#[derive(Clone)]
struct Structured;

const W: [f64; 7] = [0.4, 0.9, -0.6, 0.3, 1.2, -0.8, 0.5];

impl Map<7, 4> for Structured {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, 7>) -> SVector<S, 4> {
        let [x, y, z] = phi!(t, [q[3], q[4], q[5], q[6]]);
        let one = S::one();
        SVector::from([
            q[0] * 2.0 - x * q[6],
            q[1] * t - q[0] + y / (q[2] * q[2] + one),
            z * (one * 3.0) + q[0] / (one + one),
            (q[5] - q[3]) / (q[4] * q[6] - 3.0) - (t * t + q[2]).sin(),
        ])
    }
}

#[test]
fn moving_values_are_nested_jets() {
    let rates: [[f64; 3]; 7] =
        std::array::from_fn(|i| [W[i], (i as f64).sin() + 0.2, 0.7 - 0.3 * i as f64]);
    let moving = SVector::from_fn(|i, _| Moving::<7>::variable(rates[i], i));
    // Along time, twice.
    type Rate<S> = Grad<S, 1>;
    let along = |x: Grad<f64, 7>, v: f64, a: f64| Rate {
        v: Rate {
            v: x,
            g: [Grad::constant(v)],
        },
        g: [Rate {
            v: Grad::constant(v),
            g: [Grad::constant(a)],
        }],
    };
    let nested = SVector::from_fn(|i, _| {
        let [x, v, a] = rates[i];
        along(Grad::variable(x, i), v, a)
    });
    let time = along(Grad::constant(T), 1.0, 0.0);
    let found = Structured.phi(Moving::given([T, 1.0, 0.0]), &moving);
    let expected = Structured.phi(time, &nested);
    for (found, expected) in found.iter().zip(&expected) {
        let all = [expected.v.v, expected.g[0].v, expected.g[0].g[0]];
        for (k, expected) in all.iter().enumerate() {
            close("x", found.x[k], expected.v);
            for j in 0..7 {
                close("g", found.g[k][j], expected.g[j]);
            }
        }
    }
}

#[test]
fn hessians_are_nested_gradients() {
    type G<S> = Grad<S, 7>;
    let f = [0.7, -1.2, 0.4, 0.9];
    let K = Structured.geometric_stiffness(T, &W.into(), &f.into());
    let q = SVector::from_fn(|i, _| G::variable(G::<f64>::variable(W[i], i), i));
    let x = Structured.phi(G::<G<f64>>::constant(T), &q);
    for i in 0..7 {
        for j in 0..7 {
            let expected: f64 = x.iter().zip(&f).map(|(x, f)| f * x.g[i].g[j]).sum();
            close("K_sigma", K[(i, j)], expected);
        }
    }
}

#[test]
fn a_trace_knows_where_a_map_bends() {
    let q = SVector::from_fn(|i, _| Trace::variable(W[i], i));
    let x = Structured.phi(Trace::constant(T), &q);
    let values = Structured.phi(T, &W.into());
    let bent = |i: usize| [0, 1, 2, 3, 4, 5, 6].map(|k| x[i].bends(k));
    assert_eq!(bent(0), [false, false, false, true, true, true, true]);
    assert_eq!(bent(1), [false, false, true, true, true, true, true]);
    assert_eq!(bent(2), [false, false, false, true, true, true, true]);
    assert_eq!(bent(3), [false, false, true, true, true, true, true]);
    for (x, value) in x.iter().zip(&values) {
        close("value", x.re(), *value);
    }
    // Variables beyond the last bit are taken for bent together.
    let far = Trace::variable(1.0, 70) * Trace::variable(1.0, 80);
    assert!(far.bends(70) && far.bends(90) && !far.bends(5));
}

#[test]
fn third_derivatives_are_those_of_num_dual() {
    // Grad of Grad of Grad along one variable is the third derivative.
    type G<S> = Grad<S, 1>;
    let x0 = 0.35;
    let one = G::<f64>::variable(x0, 0);
    let two = G::<G<f64>>::variable(one, 0);
    let three = G::<G<G<f64>>>::variable(two, 0);
    let fixed = |x: f64| G::<G<G<f64>>>::constant(x);
    let found = phi!(
        fixed(T),
        [three, fixed(0.9), three * three, fixed(0.3) - three]
    );
    let x = Dual3::from_re(x0).derivative();
    let c = Dual3::from_re;
    let expected = phi!(c(T), [x, c(0.9), x * x, c(0.3) - x]);
    for i in 0..N {
        close("f'''", found[i].g[0].g[0].g[0], expected[i].v3);
        close("f''", found[i].v.g[0].g[0], expected[i].v2);
    }
}

#[test]
fn angles_and_powers_at_their_special_points() {
    // atan2 in every quadrant, at the axes, and its derivatives −s/r², c/r².
    for angle in [0.0, 0.5, 1.6, 3.1, -3.1, -1.6, -0.5, FRAC_PI_2] {
        let (s, c) = f64::sin_cos(angle);
        let (y, x) = (
            Grad::<f64, 2>::variable(2.0 * s, 0),
            Grad::variable(2.0 * c, 1),
        );
        let found = y.atan2(x);
        close("atan2", found.v, angle);
        close("d atan2/dy", found.g[0], 0.5 * c);
        close("d atan2/dx", found.g[1], -0.5 * s);
    }
    // Powers at zero: no 0·∞ from derivatives that vanish.
    let zero = Moving::<0>::given([0.0, 1.0, 0.0]);
    for (n, expected) in [
        (0, [1.0, 0.0, 0.0]),
        (1, [0.0, 1.0, 0.0]),
        (2, [0.0, 0.0, 2.0]),
    ] {
        let p = zero.powi(n);
        assert_eq!(p.x, expected, "x^{n}");
    }
}

/// The derivative of every elementary function and quotient by its argument, taken inside a map.
#[derive(Clone)]
struct Inside;

impl Map<2, 13> for Inside {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, 2>) -> SVector<S, 13> {
        let x = Grad::<S, 1>::variable((q[0] * q[1] + t).sin() * 0.3 + 0.6, 0);
        let heads = quotients::TangentQuotients::new(x);
        let tails = quotients::TangentQuotients::new(x + quotients::SERIES_LIMIT);
        SVector::from([
            x.recip(),
            x.sqrt(),
            x.sin(),
            x.cos(),
            x.exp(),
            x.ln(),
            x.atan(),
            x.powi(6),
            heads.sinc + heads.one_minus_cos + heads.psi_minus_sin,
            tails.sinc + tails.one_minus_cos * 2.0 + tails.psi_minus_sin * 3.0,
            quotients::cos_sqrt(x),
            quotients::log_factor(x),
            quotients::log_factor(x - 1.0),
        ])
        .map(|x| x.g[0])
    }
}

/// B̈ takes three derivatives of what is a derivative already.
#[test]
fn a_map_may_differentiate_once_inside() {
    check::map(&Inside).assert();
    // Against the derivatives by hand, of the fourth order.
    type G<S> = Grad<S, 1>;
    let three = G::variable(G::variable(G::<f64>::variable(0.6, 0), 0), 0);
    let x = G::variable(three, 0);
    let fourth = |x: G<G<G<G<f64>>>>| x.g[0].g[0].g[0].g[0];
    close("1/x", fourth(x.recip()), 24.0 * 0.6_f64.powi(-5));
    close("sqrt x", fourth(x.sqrt()), -0.9375 * 0.6_f64.powf(-3.5));
    close("sin x", fourth(x.sin()), 0.6_f64.sin());
    close("exp x", fourth(x.exp()), 0.6_f64.exp());
    close("ln x", fourth(x.ln()), -6.0 * 0.6_f64.powi(-4));
    close("x^6", fourth(x.powi(6)), 360.0 * 0.36);
}
