//! The jet of energies against nested gradients, which are checked against another crate.

use crate::support::*;

/// Four coordinates and velocities: a three and a rest, with every kind of operation.
fn energy<S: Scalar>(x: &[S; 4], v: &[S; 4]) -> S {
    let a = (x[0] * x[3] + 1.5).sin() / (x[2] * x[2] + 0.5).sqrt();
    let b = (x[3] - v[0] * 0.3).exp() * (v[1].cos() + 2.0).ln();
    let c = -(v[2] * v[3]) * a - (x[1] * v[0]).atan() * 2.0;
    let mut d = a * b - c;
    d += S::constant(0.7) * x[1];
    d * d * 0.5 + v[3] * v[3] * x[2] - (b + 0.7).recip()
}

const X: [f64; 4] = [0.4, 0.9, -0.6, 0.3];
const V: [f64; 4] = [1.1, -0.7, 0.2, 0.5];
const A: [f64; 4] = [-0.3, 0.8, 1.4, -0.9];

type Dual = Grad<f64, 1>;
/// Derivatives in all eight variables, twice, and along the motion.
type Nested = Grad<Grad<Dual, 8>, 8>;

fn dual(value: f64, rate: f64) -> Dual {
    Grad {
        v: value,
        g: [rate],
    }
}

#[test]
fn a_phase_is_what_nested_gradients_are() {
    let nested = |value: Dual, i: usize| Nested::variable(Grad::variable(value, i), i);
    let expected = energy(
        &std::array::from_fn(|i| nested(dual(X[i], V[i]), i)),
        &std::array::from_fn(|i| nested(dual(V[i], A[i]), 4 + i)),
    );
    let found = energy::<Phase<Dual, 4, 4, 4, 4>>(
        &std::array::from_fn(|i| Phase::coordinate(dual(X[i], V[i]), i)),
        &std::array::from_fn(|i| Phase::velocity(dual(V[i], A[i]), i)),
    );
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-13 * (1.0 + b.abs()), "{a} for {b}");
    let both = |a: Dual, b: Dual| {
        close(a.v, b.v);
        close(a.g[0], b.g[0]);
    };
    both(found.value, expected.v.v);
    for i in 0..4 {
        both(found.x[i], expected.v.g[i]);
        both(found.v[i], expected.v.g[4 + i]);
        for j in 0..4 {
            both(found.vx[i][j], expected.g[4 + i].g[j]);
            if j <= i {
                close(found.xx[i][j], expected.g[i].g[j].v);
                both(found.vv[i][j], expected.g[4 + i].g[4 + j]);
            }
        }
    }
    // Without the Hessian the gradient is the same to the last bit.
    let gradient = energy::<Phase<Dual, 4, 4, 0, 0>>(
        &std::array::from_fn(|i| Phase::coordinate(dual(X[i], V[i]), i)),
        &std::array::from_fn(|i| Phase::velocity(dual(V[i], A[i]), i)),
    );
    assert_eq!(gradient.value, found.value);
    assert_eq!(gradient.x, found.x);
    assert_eq!(gradient.v, found.v);
}
