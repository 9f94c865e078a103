//! How long the kinematics of a joint take by our jets, and by nested duals of the num-dual crate.
//!
//! ```text
//! cargo run --release -p pullback-manifold --example jet_speed
//! ```
//!
//! The map is a rigid link, d_s = d_m + (R(Ψ) − I) c, with R by the entire functions of ψ² away from
//! zero; both sides give x, ẋ, ẍ, B, Ḃ and B̈ in one evaluation, and are compared before they are timed.

#![allow(non_snake_case)]

use nalgebra::{Const, SVector, U1};
use num_dual::{Derivative, Dual2, DualNum, DualSVec64};
use pullback_manifold::map::{Map, derived};
use pullback_manifold::scalar::Scalar;
use std::hint::black_box;
use std::time::Instant;

const C: [f64; 3] = [0.3, 1.2, -0.5];
const RUNS: usize = 20_000;
const ROUNDS: usize = 15;

/// The same operations for both: R c = c + (sin ψ/ψ) Ψ×c + ((1−cos ψ)/ψ²) Ψ×(Ψ×c).
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

struct Link;

impl Map<6, 3> for Link {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 6>) -> SVector<S, 3> {
        SVector::from(link!(q))
    }
}

type Dual = Dual2<DualSVec64<6>>;

fn by_num_dual(q: &SVector<f64, 6>, v: &SVector<f64, 6>, a: &SVector<f64, 6>) -> [Dual; 3] {
    let q: [Dual; 6] = std::array::from_fn(|i| {
        let unit = SVector::from_fn(|k, _| f64::from(u8::from(k == i)));
        Dual::new(
            DualSVec64::new(q[i], Derivative::some(unit)),
            DualSVec64::from_re(v[i]),
            DualSVec64::from_re(a[i]),
        )
    });
    link!(q)
}

/// Best time of a run in nanoseconds.
fn time(mut f: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..ROUNDS {
        let start = Instant::now();
        (0..RUNS).for_each(|_| f());
        best = best.min(start.elapsed().as_secs_f64() / RUNS as f64);
    }
    best * 1e9
}

fn main() {
    let q = SVector::<f64, 6>::new(0.1, 0.2, 0.3, 0.8, -0.5, 1.1);
    let v = SVector::<f64, 6>::new(-0.4, 0.9, 0.3, 0.2, 1.5, -0.7);
    let a = SVector::<f64, 6>::new(0.6, -0.1, 0.8, 0.4, -0.3, 0.5);
    let ours = derived::kinematics(&Link, 0.0, &q, &v, &a);
    let theirs = by_num_dual(&q, &v, &a);
    for (i, x) in theirs.iter().enumerate() {
        let B_ddot = x.v2.eps.unwrap_generic(Const::<6>, U1);
        for j in 0..6 {
            let gap = (ours.B_ddot[(i, j)] - B_ddot[j]).abs();
            assert!(gap < 1e-12, "B_ddot ({i}, {j}) differs by {gap:e}");
        }
    }
    let jets = time(|| {
        black_box(derived::kinematics(
            &Link,
            0.0,
            black_box(&q),
            black_box(&v),
            black_box(&a),
        ));
    });
    let duals = time(|| {
        black_box(by_num_dual(black_box(&q), black_box(&v), black_box(&a)));
    });
    println!("x, x_dot, x_ddot, B, B_dot, B_ddot of a rigid link (6 -> 3):");
    println!("  Taylor<Grad<f64, 6>>       {jets:8.0} ns");
    println!("  Dual2<DualSVec64<6>>       {duals:8.0} ns");
    println!("  num-dual / pullback        {:8.2}", duals / jets);
}
