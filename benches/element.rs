//! Element kernels in units of a static 12×12 by 12×12 matrix product, measured in the same run.
//!
//! Internal force and tangent of the two-node beam must not take longer than 4 products.

#![allow(missing_docs)]

mod race;

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Matrix3, SMatrix};
use pullback::elements::beam::Interpolation;
use pullback::elements::element::{Element, Motion, Response};
use pullback::manifold::chart::Complement;
use pullback::manifold::map::{Map, derived};
use pullback::prelude::*;
use race::race;
use std::hint::black_box;

/// What force and tangent of a two-node beam may cost, in products.
const LIMIT: f64 = 4.0;

/// A straight beam element of the given number of nodes along e1, and a bent state of it.
fn beam(nodes: usize, interpolation: Interpolation) -> (Box<dyn Element>, Vec<f64>) {
    let positions: Vec<Vector3<f64>> = (0..nodes)
        .map(|k| Vector3::x() * k as f64 / (nodes - 1) as f64)
        .collect();
    let section = Section::diagonal(1e4, [4e3, 4e3], 2.0, [3.0, 4.0]).expect("a valid section");
    let beam = interpolation
        .beam(&positions, &|_| Matrix3::identity(), &section)
        .expect("a valid beam");
    let x = (0..6 * nodes).map(|i| 0.1 * (i as f64).sin()).collect();
    (beam, x)
}

/// Residual, and tangent where wanted, at x; from a previous iterate where given.
fn evaluate(
    beam: &dyn Element,
    x: &[f64],
    previous: Option<&[f64]>,
    r: &mut [f64],
    K: Option<&mut [f64]>,
) {
    r.fill(0.0);
    let at = Motion {
        t: 0.0,
        inputs: &[],
        x: black_box(x),
        v: &[],
        a: &[],
        previous,
    };
    let mut out = Response {
        r,
        K,
        C: None,
        M: None,
        r_t: None,
    };
    beam.evaluate(&at, &mut out).expect("inside the chart");
}

/// Time in units of a product.
fn products(f: impl FnMut()) -> f64 {
    let a = SMatrix::<f64, 12, 12>::from_fn(|i, j| ((i * 7 + j * 3) % 5) as f64 + 0.1);
    let b = a.transpose();
    let mut product = a;
    let unit = || {
        black_box(&a).mul_to(black_box(&b), &mut product);
        black_box(&product);
    };
    race(unit, f)
}

fn kernels(c: &mut Criterion) {
    let a = SMatrix::<f64, 12, 12>::from_fn(|i, j| ((i * 7 + j * 3) % 5) as f64 + 0.1);
    let b = a.transpose();
    let mut product = a;
    c.bench_function("12x12 product", |bench| {
        bench.iter(|| black_box(&a).mul_to(black_box(&b), &mut product));
    });
    let mut rows = Vec::new();
    let interpolations = [
        ("", Interpolation::Total),
        ("geodesic ", Interpolation::Geodesic),
    ];
    let kinds = interpolations.map(|(kind, i)| (2..=4).map(move |nodes| (kind, i, nodes)));
    for (kind, interpolation, nodes) in kinds.into_iter().flatten() {
        let (element, x) = beam(nodes, interpolation);
        let previous: Vec<f64> = x.iter().map(|x| 1.1 * x).collect();
        let n = 6 * nodes;
        let (mut r, mut K) = (vec![0.0; n], vec![0.0; n * n]);
        let mut force_and_tangent = |previous: Option<&[f64]>| {
            K.fill(0.0);
            evaluate(&*element, &x, previous, &mut r, Some(&mut K));
            black_box(&K);
        };
        c.bench_function(
            &format!("{nodes}-node {kind}beam, force and tangent"),
            |bench| {
                bench.iter(|| force_and_tangent(None));
            },
        );
        rows.push((
            format!("{nodes}-node {kind}beam, force and tangent"),
            products(|| force_and_tangent(None)),
        ));
        rows.push((
            format!("{nodes}-node {kind}beam, the same with extrapolated stresses"),
            products(|| force_and_tangent(Some(&previous))),
        ));
        rows.push((
            format!("{nodes}-node {kind}beam, force alone"),
            products(|| {
                evaluate(&*element, &x, None, &mut r, None);
                black_box(&r);
            }),
        ));
    }
    let psi = Vector3::new(1.0, -2.0, 2.4);
    let (v, a) = (Vector3::new(0.3, 0.1, -0.5), Vector3::new(1.0, -0.7, 0.2));
    rows.push((
        "change of chart: closed form of B, Ḃ, B̈".to_owned(),
        products(|| {
            black_box(Complement.kinematics(0.0, black_box(&psi), &v, &a));
        }),
    ));
    rows.push((
        "change of chart: the same derived from φ alone".to_owned(),
        products(|| {
            black_box(derived::kinematics(
                &Complement,
                0.0,
                black_box(&psi),
                &v,
                &a,
            ));
        }),
    ));
    println!("\nin units of one static 12x12 by 12x12 product:");
    for (name, cost) in &rows {
        println!("  {cost:6.2}  {name}");
    }
    let (name, cost) = &rows[0];
    assert!(
        *cost <= LIMIT,
        "{name}: {cost:.2} products instead of {LIMIT}"
    );
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(30).measurement_time(std::time::Duration::from_secs(2));
    targets = kernels
}
criterion_main!(benches);
