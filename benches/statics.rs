//! Roll-up of a cantilever with 100 to 10,000 elements: time per element and Newton iteration,
//! everything included, its growth with the model, and where it goes.

#![allow(missing_docs)]

use criterion::{Criterion, criterion_group, criterion_main};
use pullback::integrators::linear_solver::{BlockLu, FaerLu, LinearSolver, MatrixSymmetry};
use pullback::manifold::system::System;
use pullback::manifold::system::{Evaluation, Point, Weights};
use pullback::prelude::*;
use std::f64::consts::PI;
use std::time::Instant;

/// A cantilever of unit length with an end moment that rolls it up twice.
fn rollup(elements: usize) -> Context {
    let mut builder = ModelBuilder::new();
    let root = builder.node("root", [0.0; 3]).expect("a new name");
    let tip = builder.node("tip", [1.0, 0.0, 0.0]).expect("a new name");
    let axis = StraightLine::new(builder.position(root), builder.position(tip));
    let section = Section::diagonal(1e4, [1e4, 1e4], 2.0, [2.0, 2.0]).expect("positive");
    let line = BeamLine::new(elements, section);
    builder
        .line("beam", &axis, [root, tip], &line)
        .expect("a straight line");
    builder.support(root, &Dof::ALL);
    let moment = NodalLoad::new(
        LoadKind::SpatialMoment,
        [0.0, 0.0, 8.0 * PI],
        Proportional(1.0),
    );
    builder.element("moment", moment, &[tip]).expect("one node");
    Context::new(builder.build().expect("a valid model"))
}

/// Seconds and iterations of the whole analysis in equal steps.
fn analyse(context: &mut Context) -> (f64, usize) {
    let start = Instant::now();
    let options = StaticOptions::equal_steps(8);
    let mut run = LoadSteps::new(context, Vec::new(), &options).expect("valid options");
    run.finish().expect("converges");
    (start.elapsed().as_secs_f64(), run.summary().iterations)
}

/// Best of several averages over at least 100,000 elements, in seconds.
fn seconds(elements: usize, mut f: impl FnMut()) -> f64 {
    let count = (100_000 / elements).max(1);
    (0..7)
        .map(|_| {
            let start = Instant::now();
            for _ in 0..count {
                f();
            }
            start.elapsed().as_secs_f64() / count as f64
        })
        .fold(f64::INFINITY, f64::min)
}

/// Numbers of elements.
const SIZES: [usize; 3] = [100, 1_000, 10_000];
/// Rounds of whole analyses.
const ROUNDS: usize = 15;

/// Microseconds per element and Newton iteration of whole analyses, best of all rounds for each
/// of [`SIZES`], and the growth from the second to the third.
///
/// Every round runs all sizes, the smaller ones as often as makes the same number of elements,
/// and its growth is a ratio of averages a few seconds apart; the middle of these is what other
/// work on the machine, which comes and goes, disturbs least.
fn whole_and_growth() -> ([f64; 3], f64) {
    let mut models = SIZES.map(rollup);
    let mut best = [f64::INFINITY; 3];
    let mut growths: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let mut round = [0.0; 3];
            for (i, model) in models.iter_mut().enumerate() {
                let runs = SIZES[2] / SIZES[i];
                for _ in 0..runs {
                    let (seconds, iterations) = analyse(model);
                    let one = 1e6 * seconds / (iterations * SIZES[i]) as f64;
                    best[i] = best[i].min(one);
                    round[i] += one / runs as f64;
                }
            }
            round[2] / round[1]
        })
        .collect();
    growths.sort_by(f64::total_cmp);
    (best, growths[ROUNDS / 2])
}

fn whole_analysis(c: &mut Criterion) {
    let mut model = rollup(100);
    c.bench_function("roll-up, 100 elements, 8 steps", |bench| {
        bench.iter(|| analyse(&mut model));
    });
    println!("\nper element and Newton iteration, microseconds:");
    println!(
        "elements   whole   force  +tangent  clear+add  factorise   solve | faer factorise+solve"
    );
    let (whole, growth) = whole_and_growth();
    for (elements, whole) in SIZES.into_iter().zip(whole) {
        let unit = 1e-6 * elements as f64;

        let mut model = rollup(elements);
        let n = model.pattern().dim();
        let q: Vec<f64> = (0..n).map(|i| 1e-3 * (i as f64).sin()).collect();
        let (mut r, mut S) = (vec![0.0; n], vec![0.0; model.pattern().len()]);
        let at = Point::statics(1.0, &q);
        let force = seconds(elements, || {
            model
                .evaluate(at, Evaluation::residual(&mut r))
                .expect("inside the chart");
        });
        let assembled = seconds(elements, || {
            let out = Evaluation::with_tangent(&mut r, Weights::STATIC, &mut S);
            model.evaluate(at, out).expect("inside the chart");
        });
        // Clearing one array of the pattern's length and adding another to it: the streaming part of an
        // assembly, without its addressing. The column before it is the rest of the tangent.
        let mut sink = S.clone();
        let clear_and_add = seconds(elements, || {
            sink.fill(0.0);
            for (a, b) in sink.iter_mut().zip(&S) {
                *a += b;
            }
        });
        let mut times = [0.0; 4];
        let mut block = BlockLu::new(model.pattern(), MatrixSymmetry::General).expect("a chain");
        let mut faer = FaerLu::new(model.pattern()).expect("a chain");
        let solvers: [&mut dyn LinearSolver; 2] = [&mut block, &mut faer];
        for (k, solver) in solvers.into_iter().enumerate() {
            let mut b = r.clone();
            if solver.factorise(&S).is_err() {
                times[2 * k] = f64::NAN;
                continue;
            }
            times[2 * k] = seconds(elements, || solver.factorise(&S).expect("regular"));
            times[2 * k + 1] = seconds(elements, || {
                b.copy_from_slice(&r);
                solver.solve(Some(&S), &mut b).expect("regular");
            });
        }
        println!(
            "{elements:8}  {:6.2}  {:6.2}  {:8.2}  {:9.2}  {:9.2}  {:6.2} | {:6.2}",
            whole,
            force / unit,
            (assembled - clear_and_add) / unit,
            clear_and_add / unit,
            times[0] / unit,
            times[1] / unit,
            (times[2] + times[3]) / unit,
        );
    }
    println!("growth from 1,000 to 10,000 elements: {growth:.2} (middle of {ROUNDS} rounds)");
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).measurement_time(std::time::Duration::from_secs(2));
    targets = whole_analysis
}
criterion_main!(benches);
