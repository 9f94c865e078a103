//! Dynamics: the beam with inertia and the revolute joint in units of a static 12×12 by 12×12 product.
//!
//! Residual and combined tangent of the two-node beam must not take longer than 10 products, and a joint
//! derived from its map not longer than 11 times its closed form.

#![allow(missing_docs)]

mod race;

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Matrix3, SMatrix, SVector, Vector6};
use pullback::elements::beam::{Damping, Interpolation};
use pullback::elements::element::{Element, Motion, Response};
use pullback::elements::inertia::Inertia;
use pullback::elements::joint::{JointMap, Pose, Revolute};
use pullback::manifold::map::{Map, Parametrization, derived};
use pullback::manifold::so3;
use pullback::manifold::system::Weights;
use pullback::prelude::*;
use race::race;
use std::hint::black_box;

/// What residual and combined tangent of a two-node beam with inertia may cost, in products.
const BEAM_LIMIT: f64 = 10.0;
/// What a joint derived from its map of rotation vectors may cost, in units of its closed form of poses.
const DERIVED_LIMIT: f64 = 11.0;

/// The unit: one static product.
fn product() -> impl FnMut() {
    let a = SMatrix::<f64, 12, 12>::from_fn(|i, j| ((i * 7 + j * 3) % 5) as f64 + 0.1);
    let b = a.transpose();
    let mut product = a;
    move || {
        black_box(&a).mul_to(black_box(&b), &mut product);
        black_box(&product);
    }
}

/// Time in units of a product.
fn products(f: impl FnMut()) -> f64 {
    race(product(), f)
}

fn section() -> Section {
    Section::diagonal(1e4, [4e3, 4e3], 2.0, [3.0, 4.0]).expect("a valid section")
}

fn inertia(S: Vector3<f64>) -> Inertia {
    Inertia {
        mass: 2.0,
        S,
        J: Matrix3::from_diagonal(&Vector3::new(2.0, 1.0, 1.5)),
    }
}

/// What is asked of the beam in a measurement.
#[derive(Clone, Copy, PartialEq)]
enum Ask {
    Residual,
    Tangents,
    /// The weighted sum of K, C and M.
    Combined,
    /// The same in a Newton iteration that came from elsewhere.
    CombinedFrom,
}

fn beam_with_inertia(c: &mut Criterion) {
    let off = Vector3::new(0.0, 0.1, 0.2);
    let damping = Damping {
        mass: 0.1,
        stiffness: 1e-3,
    };
    let valid = "a valid section";
    let plain = section()
        .with_inertia(inertia(Vector3::zeros()))
        .expect(valid);
    let sections = [
        ("two-node beam", plain),
        (
            "the same, mass centre off the axis",
            section().with_inertia(inertia(off)).expect(valid),
        ),
        (
            "the same, damped",
            plain.with_damping(damping).expect(valid),
        ),
    ];
    let asks = [
        (Ask::Residual, "residual alone"),
        (Ask::Tangents, "residual, K, C, M"),
        (Ask::Combined, "residual and combined tangent"),
        (Ask::CombinedFrom, "the same, stresses extrapolated"),
    ];
    println!("\nin units of one static 12x12 by 12x12 product:");
    let total = sections.map(|(name, section)| (name, section, Interpolation::Total));
    let geodesic = [
        ("geodesic two-node beam", plain, Interpolation::Geodesic),
        ("the same, damped", sections[2].1, Interpolation::Geodesic),
    ];
    for (name, section, interpolation) in total.into_iter().chain(geodesic) {
        let positions = [Vector3::zeros(), Vector3::x()];
        let beam = interpolation.beam(&positions, &|_| Matrix3::identity(), &section);
        let beam = beam.expect("a valid beam");
        for (ask, what) in asks {
            let mut measured = evaluation(&*beam, ask);
            if ask == Ask::Combined {
                c.bench_function(&format!("{name}: {what}"), |bench| {
                    bench.iter(&mut measured)
                });
            }
            let cost = products(measured);
            println!("  {cost:6.2}  {name}: {what}");
            assert!(
                (name, ask) != ("two-node beam", Ask::Combined) || cost <= BEAM_LIMIT,
                "{name}: {what}: {cost:.2} products instead of {BEAM_LIMIT}"
            );
        }
    }
}

/// One evaluation of a moving two-node beam.
fn evaluation(beam: &dyn Element, ask: Ask) -> impl FnMut() {
    let wave = |size: f64| -> [f64; 12] { std::array::from_fn(|i| size * (i as f64).sin()) };
    let (x, previous, v, a) = (wave(0.1), wave(0.11), wave(0.3), wave(-0.2));
    let mut r = [0.0; 12];
    let [mut K, mut C, mut M] = [[0.0; 144]; 3];
    move || {
        r.fill(0.0);
        let at = Motion {
            t: 0.0,
            inputs: &[],
            x: black_box(&x),
            v: black_box(&v),
            a: black_box(&a),
            previous: (ask == Ask::CombinedFrom).then_some(&previous[..]),
        };
        match ask {
            Ask::Residual | Ask::Tangents => {
                let wanted = ask == Ask::Tangents;
                for matrix in [&mut K, &mut C, &mut M] {
                    matrix.fill(0.0);
                }
                let mut out = Response {
                    r: &mut r,
                    K: wanted.then_some(&mut K),
                    C: wanted.then_some(&mut C),
                    M: wanted.then_some(&mut M),
                    r_t: None,
                };
                beam.evaluate(&at, &mut out)
            }
            Ask::Combined | Ask::CombinedFrom => {
                K.fill(0.0);
                let weights = Weights {
                    K: 1.0,
                    C: 20.0,
                    M: 400.0,
                };
                let combined = beam.abilities().combined.expect("a combined tangent");
                combined.add(&at, &mut r, &mut [Some((weights, &mut K[..])), None, None])
            }
        }
        .expect("inside the chart");
        black_box((&r, &K, &C, &M));
    }
}

/// The map of a revolute joint by differentiation of its composed pose.
struct ByJets(Revolute);

impl Map<7, 6> for ByJets {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, 7>) -> SVector<S, 6> {
        let own = self.0.pose(t, &SVector::<S, 1>::new(q[6]));
        let child = Pose::of(q, 0).translated(&own.d).rotated(&own.rotation);
        let (d, psi) = (child.d, so3::log_quaternion(&child.rotation));
        SVector::<S, 6>::new(d.x, d.y, d.z, psi.x, psi.y, psi.z)
    }
}

fn revolute_joint(c: &mut Criterion) {
    let revolute = Revolute::new([0.3, -0.5, 0.8]).expect("an axis");
    let (joint, by_jets) = (JointMap::new(revolute), ByJets(revolute));
    let wave = |size: f64| SVector::<f64, 7>::from_fn(|i, _| size * (i as f64 + 0.5).sin());
    let (q, v, a) = (wave(0.6), wave(0.3), wave(-0.2));
    let f = Vector6::new(1.0, -2.0, 0.5, 0.3, 0.7, -1.1);
    let closed_kinematics = move || {
        let mut joint = joint;
        let (mut x, mut B) = ([[0.0; 6]; 3], [[0.0; 42]; 3]);
        let ([x, x_dot, x_ddot], [B, B_dot, B_ddot]) = (&mut x, &mut B);
        let q = black_box(q.as_slice());
        let motion = [q, v.as_slice(), a.as_slice()];
        let out = &mut [[&mut x[..], &mut B[..]], [x_dot, B_dot], [x_ddot, B_ddot]];
        joint.evaluate(0.0, motion, out);
        black_box(&B_ddot);
    };
    let derived_kinematics = || {
        black_box(derived::kinematics(&by_jets, 0.0, black_box(&q), &v, &a));
    };
    let closed_stiffness = move || {
        let mut joint = joint;
        let mut K = [0.0; 49];
        joint.geometric_stiffness(0.0, black_box(q.as_slice()), f.as_slice(), &mut K);
        black_box(&K);
    };
    let derived_stiffness = || {
        let q = black_box(&q);
        black_box(derived::geometric_stiffness(&by_jets, 0.0, q, &f));
    };
    c.bench_function("revolute joint, closed kinematics", |b| {
        b.iter(closed_kinematics)
    });
    c.bench_function("revolute joint, derived kinematics", |b| {
        b.iter(derived_kinematics)
    });
    println!("\nrevolute joint, derived over closed:");
    let row = |name: &str, ratio: f64| {
        println!("  {ratio:5.2}  {name}");
        ratio
    };
    row(
        "x, x', x'', B, B', B''",
        race(closed_kinematics, derived_kinematics),
    );
    row(
        "geometric stiffness",
        race(closed_stiffness, derived_stiffness),
    );
    let closed = || {
        closed_kinematics();
        closed_stiffness();
    };
    let derived = || {
        derived_kinematics();
        derived_stiffness();
    };
    let both = row("both", race(closed, derived));
    assert!(
        both <= DERIVED_LIMIT,
        "derived kinematics and stiffness take {both:.2} times as long as closed ones instead of \
         {DERIVED_LIMIT}"
    );
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10).measurement_time(std::time::Duration::from_secs(2));
    targets = beam_with_inertia, revolute_joint
}
criterion_main!(benches);
