//! Whole runs: seconds in units of an element and iteration, or step, their growth with the model, where
//! the time goes, and Newton's iteration done otherwise.
//!
//! The aim for the falling cantilever is 2 µs per element and iteration.

#![allow(missing_docs)]

mod models;

use criterion::{Criterion, criterion_group, criterion_main};
use models::{falling, flying, robot_arm, struck};
use pullback::integrators::dynamics::{
    DynamicOptions, Predictor, Progress, Simulation, Summary, TangentUpdate, start,
};
use pullback::integrators::linear_solver::{AutoSolver, LinearSolver, MatrixSymmetry};
use pullback::manifold::system::{Charts, Energetics, System};
use pullback::manifold::system::{Evaluation, Point, Weights};
use pullback::prelude::*;
use std::hint::black_box;
use std::time::Instant;

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

/// Seconds of a whole run, everything included, and what it did.
fn run(context: &mut Context, options: &DynamicOptions) -> (f64, Progress) {
    let start_time = Instant::now();
    let state = start(context, 0.0, &[], &[]).expect("a valid start");
    let mut run = Simulation::new(context, state, options).expect("a valid start");
    run.finish().expect("converges");
    (start_time.elapsed().as_secs_f64(), run.progress().clone())
}

/// Microseconds per element: of a whole run over its iterations, and of the parts of a step.
struct Costs {
    whole: f64,
    /// Seconds of a whole run over its steps and elements.
    step: f64,
    force: f64,
    tangent: f64,
    factorise: f64,
    solve: f64,
    /// Once per step.
    energies: f64,
    charts: f64,
    summary: Summary,
}

fn costs(make: &dyn Fn(usize) -> Context, elements: usize, options: &DynamicOptions) -> Costs {
    let unit = 1e-6 * elements as f64;
    let repeats = (20_000 / elements).clamp(2, 7);
    let mut best = (f64::INFINITY, Progress::default());
    let mut model = make(elements);
    for _ in 0..repeats {
        // A fresh model: charts are part of its state.
        model = make(elements);
        let now = run(&mut model, options);
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
        let out = Evaluation {
            previous: Some(at),
            ..Evaluation::with_tangent(&mut r, weights, &mut S)
        };
        model.evaluate(at, out).expect(inside);
    });
    let energies = seconds(count, || {
        black_box(model.energies(at).expect(inside));
    });
    let regular = "regular";
    let mut solver = AutoSolver::new(model.pattern(), MatrixSymmetry::General).expect(regular);
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
        step: whole / (summary.steps * elements) as f64,
        force: force / unit,
        tangent: tangent / unit,
        factorise: factorise / unit,
        solve: solve / unit,
        energies: energies / unit,
        charts: charts / unit,
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
    println!("\nmicroseconds per element and iteration, then of the parts:");
    println!(
        "                elements steps iterations   whole | residual  +tangent  factorise  \
         solve | per step: energies  charts | seconds per step and element"
    );
    let mut growth = Vec::new();
    type Make<'a> = &'a dyn Fn(usize) -> Context;
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
            "{name:>14}  {elements:8} {:5} {:10}  {:6.2} |   {:6.2}    {:6.2}     \
             {:6.2}  {:6.2}  |           {:6.2}  {:6.2}  |  {:.2e}",
            it.summary.steps,
            it.summary.iterations,
            it.whole,
            it.force,
            it.tangent,
            it.factorise,
            it.solve,
            it.energies,
            it.charts,
            it.step,
        );
        if name == "flying beam" {
            growth.push([it.whole, it.step]);
        }
    }
    println!(
        "growth of the flying beam from 100 to 10,000 elements: {:.2} per element and iteration, {:.2} \
         per element and step",
        growth[2][0] / growth[0][0],
        growth[2][1] / growth[0][1]
    );
}

/// What a Newton iteration in motion may do otherwise, on the same motions: begin at the old
/// coordinates, or keep one tangent for a whole step.
fn newton(_: &mut Criterion) {
    println!("\nNewton's iteration as it is, and otherwise:");
    println!(
        "                elements     h                    iterations  factorisations  rejected  \
         time over the first"
    );
    type Make<'a> = &'a dyn Fn() -> Context;
    let arm = || robot_arm(40);
    let rod = || falling(1_000);
    let rows: [(&str, usize, Make<'_>, DynamicOptions); 4] = [
        ("right angle", 20, &struck, DynamicOptions::new(30.0, 0.2)),
        ("right angle", 20, &struck, DynamicOptions::new(30.0, 0.05)),
        ("robot arm", 40, &arm, DynamicOptions::new(3.0, 0.01)),
        ("cantilever", 1_000, &rod, DynamicOptions::new(1.0, 0.02)),
    ];
    let ways = [
        ("", Predictor::Velocity, TangentUpdate::Every),
        ("predictor keep", Predictor::Keep, TangentUpdate::Every),
        ("tangent once", Predictor::Velocity, TangentUpdate::Once),
    ];
    for (name, elements, make, options) in rows {
        let mut best = [(f64::INFINITY, Summary::default()); 3];
        // In turn, so that whatever slows the machine slows all.
        for _ in 0..3 {
            for (best, (_, predictor, tangent)) in best.iter_mut().zip(ways) {
                let mut options = options;
                (options.newton.predictor, options.newton.tangent) = (predictor, tangent);
                let (time, progress) = run(&mut make(), &options);
                *best = (best.0.min(time), progress.summary);
            }
        }
        for ((way, ..), (time, summary)) in ways.iter().zip(best) {
            println!(
                "{name:>14}  {elements:8}  {:.2}  {way:>16}  {:12}  {:14}  {:8}  {:.2}",
                options.step,
                summary.iterations,
                summary.factorisations,
                summary.failed,
                time / best[0].0
            );
        }
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10).measurement_time(std::time::Duration::from_secs(2));
    targets = whole_runs, newton
}
criterion_main!(benches);
