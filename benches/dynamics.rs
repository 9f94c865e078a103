//! Dynamics: the beam with inertia and the revolute joint in units of a static 12×12 by 12×12
//! product, and whole runs in units of an element and iteration, their growth with the model, and
//! where the time goes.
//!
//! Residual and combined tangent of the two-node beam must not take longer than 10 products, and a joint
//! derived from its map not longer than 4 times its closed form; the aim for the falling cantilever is
//! 2 µs per element and iteration.

#![allow(non_snake_case, missing_docs)]

mod models;

use criterion::{Criterion, criterion_group, criterion_main};
use models::{falling, flying, robot_arm};
use nalgebra::{Matrix3, SMatrix, SVector, Vector6};
use pullback::elements::beam::{Damping, Interpolation};
use pullback::elements::element::{Element, Motion, Response};
use pullback::elements::inertia::Inertia;
use pullback::elements::joint::{Hung, Revolute};
use pullback::integrators::dynamics::{
    DynamicOptions, Progress, StepReport, Summary, integrate, start,
};
use pullback::integrators::linear_solver::{AutoSolver, LinearSolver, Symmetry};
use pullback::manifold::map::{Map, derived};
use pullback::manifold::system::{Evaluation, Point, Weights};
use pullback::prelude::*;
use std::hint::black_box;
use std::time::Instant;

/// What residual and combined tangent of a two-node beam with inertia may cost, in products.
const BEAM_LIMIT: f64 = 10.0;
/// What a joint derived from its map may cost, in units of its closed form.
const DERIVED_LIMIT: f64 = 4.0;

/// Seconds of one call, averaged over `count` of them.
fn average(count: usize, f: &mut impl FnMut()) -> f64 {
    let start = Instant::now();
    for _ in 0..count {
        f();
    }
    start.elapsed().as_secs_f64() / count as f64
}

/// Best of several averages, in seconds.
fn seconds(count: usize, mut f: impl FnMut()) -> f64 {
    let averages = (0..15).map(|_| average(count, &mut f));
    averages.fold(f64::INFINITY, f64::min)
}

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

/// Time in units of a product, both measured in turn, best of several averages.
fn products(mut f: impl FnMut()) -> f64 {
    let mut unit = product();
    let mut best = [f64::INFINITY; 2];
    for _ in 0..25 {
        best[0] = best[0].min(average(2000, &mut f));
        best[1] = best[1].min(average(2000, &mut unit));
    }
    best[0] / best[1]
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
        let places = [Vector3::zeros(), Vector3::x()];
        let beam = interpolation.beam(&places, &|_| Matrix3::identity(), &section);
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
            x: black_box(&x),
            v: black_box(&v),
            a: black_box(&a),
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
                let previous = (ask == Ask::CombinedFrom).then_some(&previous[..]);
                let weights = Weights {
                    K: 1.0,
                    C: 20.0,
                    M: 400.0,
                };
                let combined = beam.combined().expect("an element with a way of its own");
                combined.evaluate_combined(previous, &at, weights, &mut r, &mut K)
            }
        }
        .expect("inside the chart");
        black_box((&r, &K, &C, &M));
    }
}

fn revolute_joint(c: &mut Criterion) {
    let joint = Hung::new(Revolute::new([0.3, -0.5, 0.8]).expect("an axis"));
    let wave = |size: f64| SVector::<f64, 7>::from_fn(|i, _| size * (i as f64 + 0.5).sin());
    let (q, v, a) = (wave(0.6), wave(0.3), wave(-0.2));
    let f = Vector6::new(1.0, -2.0, 0.5, 0.3, 0.7, -1.1);
    let closed = || {
        black_box(joint.kinematics(0.0, black_box(&q), &v, &a));
    };
    let jets = || {
        black_box(derived::kinematics(&joint, 0.0, black_box(&q), &v, &a));
    };
    let stiffness = || {
        black_box(joint.geometric_stiffness(0.0, black_box(&q), &f));
    };
    let jets_stiffness = || {
        black_box(derived::geometric_stiffness(&joint, 0.0, black_box(&q), &f));
    };
    c.bench_function("revolute joint, closed kinematics", |b| b.iter(closed));
    c.bench_function("revolute joint, derived kinematics", |b| b.iter(jets));
    println!("\nrevolute joint, in products, and derived over closed:");
    let mut sum = [0.0; 2];
    let mut row = |name: &str, [closed, derived]: [f64; 2]| {
        println!(
            "  {:6.2} closed  {:6.2} derived  {:5.2}  {name}",
            closed,
            derived,
            derived / closed
        );
        (sum[0], sum[1]) = (sum[0] + closed, sum[1] + derived);
        sum
    };
    let both = [products(closed), products(jets)];
    row("x, x', x'', B, B', B''", both);
    let both = [products(stiffness), products(jets_stiffness)];
    let both = row("geometric stiffness", both);
    row("both", both);
    let [closed, derived] = both;
    assert!(
        derived <= DERIVED_LIMIT * closed,
        "derived kinematics and stiffness take {:.2} times as long as closed ones instead of \
         {DERIVED_LIMIT}",
        derived / closed
    );
}

/// Seconds of a whole run, everything included, and what it did.
fn run(model: &mut Model, options: &DynamicOptions) -> (f64, Progress) {
    let start_time = Instant::now();
    let mut progress = Progress::new(start(model, 0.0, &[], &[]).expect("a valid start"));
    let onward = &mut |_: &mut Model, _: &StepReport<'_>| ControlFlow::Continue(());
    integrate(model, &mut progress, options, onward).expect("converges");
    (start_time.elapsed().as_secs_f64(), progress)
}

/// Microseconds per element: of a whole run over its iterations, and of the parts of a step.
struct Costs {
    whole: f64,
    force: f64,
    tangent: f64,
    factorise: f64,
    solve: f64,
    /// Once per step.
    energies: f64,
    charts: f64,
    /// A product, measured between the runs.
    product: f64,
    summary: Summary,
}

fn costs(make: &dyn Fn(usize) -> Model, elements: usize, options: &DynamicOptions) -> Costs {
    let unit = 1e-6 * elements as f64;
    let repeats = (20_000 / elements).clamp(2, 7);
    let mut best = (f64::INFINITY, Progress::default());
    let mut model = make(elements);
    let (mut unit_step, mut product_time) = (product(), f64::INFINITY);
    for _ in 0..repeats {
        // A fresh model: charts are part of its state.
        model = make(elements);
        let now = run(&mut model, options);
        product_time = product_time.min(average(20_000, &mut unit_step));
        if now.0 < best.0 {
            best = now;
        }
    }
    let (
        whole,
        Progress {
            mut state, summary, ..
        },
    ) = best;
    let count = (50_000 / elements).max(1);
    let n = model.pattern().dim();
    let (mut r, mut S) = (vec![0.0; n], vec![0.0; model.pattern().len()]);
    let h = options.step;
    let weights = Weights {
        K: 1.0,
        C: 2.0 / h,
        M: 4.0 / (h * h),
    };
    let at = Point {
        t: state.t,
        q: &state.q,
        v: &state.v,
        a: &state.a,
    };
    let inside = "inside the chart";
    let force = seconds(count, || {
        model
            .evaluate(at, Evaluation::residual(&mut r))
            .expect(inside);
    });
    let tangent = seconds(count, || {
        let out = Evaluation::with_tangent(&mut r, weights, &mut S);
        model.evaluate_from(at, at, out).expect(inside);
    });
    let energies = seconds(count, || {
        black_box(model.energies(at).expect(inside));
    });
    let mut solver = AutoSolver::new();
    let regular = "regular";
    solver
        .analyse(model.pattern(), Symmetry::General)
        .expect(regular);
    let factorise = seconds(count, || solver.factorise(&S).expect(regular));
    let mut b = r.clone();
    let solve = seconds(count, || {
        b.copy_from_slice(&r);
        solver.solve(Some(&S), &mut b).expect(regular);
    });
    let charts = seconds(count, || {
        let (q, v) = (&mut state.q, &mut state.v);
        model.change_charts(state.t, q, v, &mut [&mut state.a]);
    });
    Costs {
        whole: whole / summary.iterations as f64 / unit,
        force: force / unit,
        tangent: tangent / unit,
        factorise: factorise / unit,
        solve: solve / unit,
        energies: energies / unit,
        charts: charts / unit,
        product: 1e6 * product_time,
        summary,
    }
}

fn whole_runs(c: &mut Criterion) {
    let arm = DynamicOptions::new(3.0, 0.01);
    let flight = DynamicOptions::new(2.5, 0.05);
    let fall = DynamicOptions::new(1.0, 0.02);
    c.bench_function("robot arm, 40 elements, 300 steps", |bench| {
        bench.iter(|| run(&mut robot_arm(40), &arm));
    });
    println!("\nmicroseconds per element and iteration (products in brackets), then of the parts:");
    println!(
        "                elements steps iterations      whole     | residual  +tangent  factorise  \
         solve | per step: energies  charts"
    );
    let mut growth = Vec::new();
    type Make<'a> = &'a dyn Fn(usize) -> Model;
    let rows: [(&str, Make<'_>, usize, &DynamicOptions); 5] = [
        ("robot arm", &robot_arm, 40, &arm),
        ("flying beam", &flying, 100, &flight),
        ("flying beam", &flying, 1_000, &flight),
        ("flying beam", &flying, 10_000, &flight),
        ("cantilever", &falling, 1_000, &fall),
    ];
    for (name, make, elements, options) in rows {
        let it = costs(make, elements, options);
        println!(
            "{name:>14}  {elements:8} {:5} {:10}  {:6.2} ({:5.1})  |   {:6.2}    {:6.2}     \
             {:6.2}  {:6.2}  |           {:6.2}  {:6.2}",
            it.summary.steps,
            it.summary.iterations,
            it.whole,
            it.whole / it.product,
            it.force,
            it.tangent,
            it.factorise,
            it.solve,
            it.energies,
            it.charts,
        );
        if name == "flying beam" {
            growth.push(it.whole);
        }
    }
    println!(
        "growth of the flying beam from 100 to 10,000 elements: {:.2}",
        growth[2] / growth[0]
    );
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10).measurement_time(std::time::Duration::from_secs(2));
    targets = beam_with_inertia, revolute_joint, whole_runs
}
criterion_main!(benches);
