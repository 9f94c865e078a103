//! How long the derivatives of joints take by our jets, and by the number types of num-dual.
//!
//! ```text
//! cargo run --release -p pullback-manifold --example jet_speed
//! ```
//!
//! Each map is one macro, a sequence of operations that both crates evaluate: a rigid link,
//! d_s = d_m + (R(Ψ) − I) c, and a revolute joint with the logarithm of its rotation. Results are
//! compared before they are timed; the two sides take turns, and the best round of each counts. It fails
//! where num-dual takes less than 1.5 times as long for all derivatives of a map, or less time than our
//! jets for some of them: then there is no reason for jets of our own.

#![allow(non_snake_case)]

use nalgebra::{Const, SMatrix, SVector, U1};
use num_dual::{Derivative, Dual2, Dual2SVec64, DualNum, DualSVec64};
use pullback_manifold::map::{Kinematics, Map, derived};
use pullback_manifold::scalar::Scalar;
use std::hint::black_box;
use std::time::Instant;

const C: [f64; 3] = [0.3, 1.2, -0.5];
const AXIS: [f64; 3] = [0.6, 0.0, 0.8];
const RUNS: usize = 200;
const ROUNDS: usize = 1_000;
/// What num-dual takes at least for all derivatives of a map, in units of what our jets take.
const CLEAR: f64 = 1.5;

/// 6 → 3: R c = c + (sin ψ/ψ) Ψ×c + ((1−cos ψ)/ψ²) Ψ×(Ψ×c).
macro_rules! link {
    ($q:expr) => {{
        let q = $q;
        let z = q[3] * q[3] + q[4] * q[4] + q[5] * q[5];
        let psi = z.sqrt();
        let a = psi.sin() / psi;
        let b = (-psi.cos() + 1.0) / z;
        let u = [
            q[4] * C[2] - q[5] * C[1],
            q[5] * C[0] - q[3] * C[2],
            q[3] * C[1] - q[4] * C[0],
        ];
        let w = [
            q[4] * u[2] - q[5] * u[1],
            q[5] * u[0] - q[3] * u[2],
            q[3] * u[1] - q[4] * u[0],
        ];
        [
            q[0] + a * u[0] + b * w[0],
            q[1] + a * u[1] + b * w[1],
            q[2] + a * u[2] + b * w[2],
        ]
    }};
}

/// 7 → 6: d_s = d_m, R_s = R(Ψ) R(φ e), by quaternions, with the rotation vector of R_s.
macro_rules! revolute {
    ($q:expr) => {{
        let q = $q;
        let psi = (q[3] * q[3] + q[4] * q[4] + q[5] * q[5]).sqrt();
        let (half, angle) = (psi * 0.5, q[6] * 0.5);
        let (a, s) = (half.cos(), half.sin() / psi);
        let m = [q[3] * s, q[4] * s, q[5] * s];
        let (b, t) = (angle.cos(), angle.sin());
        let j = [t * AXIS[0], t * AXIS[1], t * AXIS[2]];
        let w = a * b - m[0] * j[0] - m[1] * j[1] - m[2] * j[2];
        let v = [
            m[0] * b + j[0] * a + m[1] * j[2] - m[2] * j[1],
            m[1] * b + j[1] * a + m[2] * j[0] - m[0] * j[2],
            m[2] * b + j[2] * a + m[0] * j[1] - m[1] * j[0],
        ];
        let n = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        let log = n.atan2(w) / n * 2.0;
        [q[0], q[1], q[2], v[0] * log, v[1] * log, v[2] * log]
    }};
}

/// A map by its macro, and its derivatives by num-dual.
macro_rules! job {
    ($name:ident, $phi:ident, $d:literal, $n:literal) => {
        struct $name;

        impl Map<$d, $n> for $name {
            fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, $d>) -> SVector<S, $n> {
                SVector::from($phi!(q))
            }
        }

        impl Dual<$d, $n> for $name {
            fn nested(q: &[f64; $d], v: &[f64; $d], a: &[f64; $d]) -> [Nested<$d>; $n] {
                let q: [Nested<$d>; $d] = std::array::from_fn(|i| {
                    let unit = SVector::from_fn(|k, _| f64::from(k == i));
                    Dual2::new(
                        DualSVec64::new(q[i], Derivative::some(unit)),
                        DualSVec64::from_re(v[i]),
                        DualSVec64::from_re(a[i]),
                    )
                });
                $phi!(q)
            }

            fn energy(q: &[f64; $d], f: &[f64; $n]) -> Dual2SVec64<$d> {
                let q: [Dual2SVec64<$d>; $d] =
                    std::array::from_fn(|i| Dual2SVec64::from_re(q[i]).derivative(i));
                let x = $phi!(q);
                let zero = Dual2SVec64::from_re(0.0);
                x.iter().zip(f).fold(zero, |sum, (x, f)| sum + *x * *f)
            }
        }
    };
}

/// First and second time derivatives of numbers with gradients.
type Nested<const D: usize> = Dual2<DualSVec64<D>>;

/// The same job by num-dual.
trait Dual<const D: usize, const N: usize>: Map<D, N> {
    /// x, ẋ, ẍ with their gradients B, Ḃ, B̈.
    fn nested(q: &[f64; D], v: &[f64; D], a: &[f64; D]) -> [Nested<D>; N];
    /// f·φ with its Hessian K_σ(f).
    fn energy(q: &[f64; D], f: &[f64; N]) -> Dual2SVec64<D>;
}

job!(Link, link, 6, 3);
job!(Revolute, revolute, 7, 6);

/// Nanoseconds of a call of each, the best of many rounds in turns.
fn race(mut f: impl FnMut(), mut g: impl FnMut()) -> [f64; 2] {
    fn round(f: &mut impl FnMut()) -> f64 {
        let start = Instant::now();
        (0..RUNS).for_each(|_| f());
        start.elapsed().as_secs_f64() / RUNS as f64 * 1e9
    }
    let mut best = [f64::INFINITY; 2];
    for _ in 0..ROUNDS {
        best = [best[0].min(round(&mut f)), best[1].min(round(&mut g))];
    }
    best
}

/// Prints a row of the table; its ratio.
fn print(job: &str, [jets, duals]: [f64; 2]) -> f64 {
    let ratio = duals / jets;
    println!("{job:24} {jets:8.0} {duals:10.0} {ratio:10.2}");
    ratio
}

fn agree<const N: usize, const D: usize>(
    name: &str,
    x: &SMatrix<f64, N, D>,
    y: &SMatrix<f64, N, D>,
) {
    let gap = (x - y).amax();
    assert!(gap < 1e-12 * (1.0 + y.amax()), "{name} differs by {gap:e}");
}

fn compare<M: Dual<D, N>, const D: usize, const N: usize>(
    name: &str,
    map: &M,
) -> Result<(), String> {
    let q = SVector::<f64, D>::from_fn(|i, _| [0.1, 0.2, 0.3, 0.8, -0.5, 1.1, 0.7][i]);
    let v = SVector::<f64, D>::from_fn(|i, _| [-0.4, 0.9, 0.3, 0.2, 1.5, -0.7, 0.5][i]);
    let a = SVector::<f64, D>::from_fn(|i, _| [0.6, -0.1, 0.8, 0.4, -0.3, 0.5, -0.9][i]);
    let f = SVector::<f64, N>::from_fn(|i, _| [0.7, -1.2, 0.4, 0.9, 0.2, -0.6][i]);
    let array = |x: &SVector<f64, D>| std::array::from_fn::<f64, D, _>(|i| x[i]);
    let (q_, v_, a_) = (array(&q), array(&v), array(&a));
    let f_: [f64; N] = std::array::from_fn(|i| f[i]);

    let k: Kinematics<D, N> = derived::kinematics(map, 0.0, &q, &v, &a);
    let x = M::nested(&q_, &v_, &a_);
    let gradients = |part: fn(&Nested<D>) -> &DualSVec64<D>| {
        SMatrix::from_fn(|i, j| part(&x[i]).eps.unwrap_generic(Const::<D>, U1)[j])
    };
    agree("x_ddot", &k.x_ddot, &SVector::from_fn(|i, _| x[i].v2.re));
    agree("B", &k.B, &gradients(|x| &x.re));
    agree("B_dot", &k.B_dot, &gradients(|x| &x.v1));
    agree("B_ddot", &k.B_ddot, &gradients(|x| &x.v2));
    let K = derived::geometric_stiffness(map, 0.0, &q, &f);
    let energy = M::energy(&q_, &f_);
    agree(
        "K_sigma",
        &K,
        &energy.v2.unwrap_generic(Const::<D>, Const::<D>),
    );

    let kinematics = race(
        || {
            black_box(derived::kinematics(
                map,
                0.0,
                black_box(&q),
                black_box(&v),
                black_box(&a),
            ));
        },
        || {
            black_box(M::nested(black_box(&q_), black_box(&v_), black_box(&a_)));
        },
    );
    let stiffness = race(
        || {
            black_box(derived::geometric_stiffness(
                map,
                0.0,
                black_box(&q),
                black_box(&f),
            ));
        },
        || {
            black_box(M::energy(black_box(&q_), black_box(&f_)));
        },
    );
    let both = [0, 1].map(|side| kinematics[side] + stiffness[side]);
    for (job, times, least) in [
        ("B B_dot B_ddot", kinematics, 1.0),
        ("K_sigma", stiffness, 1.0),
        ("all of them", both, CLEAR),
    ] {
        let ratio = print(&format!("{name}, {job}"), times);
        if ratio < least {
            return Err(format!(
                "{name}, {job}: num-dual takes {ratio:.2} times as long as our jets, not {least}"
            ));
        }
    }
    Ok(())
}

fn main() -> Result<(), String> {
    println!(
        "{:24} {:>8} {:>10} {:>10}",
        "", "jets/ns", "duals/ns", "ratio"
    );
    compare("link", &Link)?;
    compare("revolute", &Revolute)
}
