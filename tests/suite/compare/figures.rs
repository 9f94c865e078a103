//! Data of a comparison's figures, on an oscillator whose steps are known in closed form.

use crate::support::comparisons::{self, oscillator};
use crate::support::drawings::graph;
use crate::support::laboratory::options;
use crate::support::program::assert_close;
use pullback::output::plot::{AxisScale, Graph, PlotCurve};
use pullback::studies::compare::{Comparison, ComparisonOptions, ErrorQuantity, Figure, figures};

const STEPS: [f64; 3] = [0.1, 0.05, 0.025];

/// Points of a curve over time, at most.
const PARTS: usize = 32;

fn compared(schemes: &[&str], long: Option<f64>) -> Comparison {
    let options = ComparisonOptions {
        long,
        ..options(schemes, &STEPS)
    };
    comparisons::compared(&oscillator(), &options).unwrap()
}

fn figure(comparison: &Comparison, name: &str) -> Figure {
    let mut all = figures(comparison).unwrap().into_iter();
    all.find(|figure| figure.name == name).unwrap()
}

/// The graphs over time.
fn drift(comparison: &Comparison) -> Vec<Graph> {
    figure(comparison, "drift.svg").graphs
}

fn labels(graph: &Graph) -> Vec<&str> {
    graph.curves.iter().map(|c| &c.label[..]).collect()
}

/// What their caption says of curves that end early.
fn stopping(comparison: &Comparison) -> Option<String> {
    let caption = figure(comparison, "drift.svg").caption;
    let said = caption.split_once("Curves that stop, as their runs failed: ");
    said.map(|(_, said)| said.to_owned())
}

#[test]
fn work_is_what_the_runs_cost_against_their_errors() {
    let comparison = compared(&["newmark", "ga:0.8"], None);
    let graphs = figure(&comparison, "work.svg").graphs;
    let [by_assemblies, by_time] = [&graphs[0], &graphs[1]];
    assert_eq!(by_assemblies.description[0], "assemblies of the model");
    assert!(by_time.description[0].starts_with("wall time"));
    assert_eq!(by_assemblies.description[1], "error of position");
    for graph in [by_assemblies, by_time] {
        assert_eq!(labels(graph), ["newmark", "ga:0.8"]);
    }
    for (k, (work, error)) in by_assemblies.curves[0].points.iter().enumerate() {
        // A linear model takes a tangent and a residual that shows the balance in every step, and a few
        // evaluations at the start.
        let steps = (comparison.to / STEPS[k]).round();
        let few = 2.0 * steps..2.0 * steps + 6.0;
        assert!(few.contains(work), "{work} {steps}");
        let row = comparison.of("newmark").nth(k).unwrap();
        assert_eq!(*error, row.error.unwrap().of(ErrorQuantity::Position));
    }
    let times = by_time.curves[0].points.iter().map(|p| p.0);
    let own = comparison.of("newmark").map(|row| row.seconds);
    assert!(times.zip(own).all(|(found, seconds)| found == seconds));
}

#[test]
fn a_linear_model_takes_one_solution_per_step() {
    let comparison = compared(&["newmark", "radau"], None);
    let [graph] = &figure(&comparison, "iterations.svg").graphs[..] else {
        panic!("one graph");
    };
    // Both stages of Radau IIA are solved together.
    for curve in &graph.curves {
        assert_eq!(curve.points.len(), STEPS.len());
        for ((h, solutions), step) in curve.points.iter().zip(STEPS) {
            assert_close(*h, step, 1e-12, &curve.label);
            assert_eq!(*solutions, 1.0, "{curve:?}");
        }
    }
}

/// Makes a run of Newmark's scheme a failed one.
fn fail(comparison: &mut Comparison, step: f64) {
    let mut rows = comparison.rows.iter_mut();
    let row = rows.find(|r| r.scheme == "newmark" && r.requested_step == step);
    row.unwrap().failure = Some("it failed".to_owned());
}

/// A failed run is marked in the legend: its curve ends before the others.
#[test]
fn curves_that_stop_say_so() {
    let mut comparison = compared(&["newmark", "ga:0.8"], Some(2.0));
    assert_eq!(stopping(&comparison), None);
    let whole = drift(&comparison)[0].clone();
    let row = &mut comparison.long[1];
    row.failure = Some("the step failed".to_owned());
    row.samples.truncate(5);
    let last = row.samples[4].t;
    let graph = &drift(&comparison)[0];
    assert_eq!(labels(graph), ["newmark", "ga:0.8 (stops: failed)"]);
    assert_eq!(graph.curves[1].points.len(), 4);
    assert_eq!(graph.curves[0].points, whole.curves[0].points);
    let said = stopping(&comparison).unwrap();
    let t = said.strip_prefix("ga:0.8 with h = 0.1 after t = ").unwrap();
    let t: f64 = t.strip_suffix('.').unwrap().parse().unwrap();
    // To three digits.
    assert_close(t, last, 5e-3 * last, &said);
    // So does the short one with the smallest step, which is drawn beside it, and none between.
    comparison.long[1].failure = None;
    fail(&mut comparison, 0.05);
    assert_eq!(stopping(&comparison), None);
    fail(&mut comparison, 0.025);
    let said = stopping(&comparison).unwrap();
    assert!(said.starts_with("newmark with h = 0.025 after"), "{said}");
}

/// There are seven colours: with more curves marks tell them apart.
#[test]
fn lines_of_one_colour_have_marks() {
    let line = |k: usize| {
        let points = (0..50).map(|i| (f64::from(i), (k + 1) as f64));
        PlotCurve::new(k.to_string(), points.collect()).colored(k)
    };
    let circles = |count: usize| {
        let curves = (0..count).map(line).collect();
        let svg = graph([AxisScale::Linear; 2], curves, false);
        svg.matches("<circle").count()
    };
    assert_eq!(circles(7), 0);
    assert!(circles(8) > 5, "{}", circles(8));
}

/// A swing of the amplitude 0.2 e^(t/200) about nothing, in a run of 128 common times, or of 121: its envelope
/// is the amplitude to the end, however near to zero single values are.
#[test]
fn curves_over_time_are_envelopes() {
    for factor in [16.0, 15.125] {
        let mut comparison = compared(&["newmark"], Some(factor));
        let row = &mut comparison.long[0];
        assert!(row.samples.len() > 2 * PARTS);
        let amplitude = |t: f64| 0.2 * (t / 200.0).exp();
        for sample in &mut row.samples {
            sample.energy = amplitude(sample.t) * (2.0 * sample.t).sin();
        }
        let row = &comparison.long[0];
        let swings: Vec<f64> = row.samples.iter().map(|s| s.energy.abs()).collect();
        let least = swings[1..].iter().copied().fold(f64::INFINITY, f64::min);
        assert!(least < 0.02 * 0.2);
        let graph = &drift(&comparison)[0];
        assert_eq!(graph.description[1], "|change of energy|");
        let points = &graph.curves[0].points;
        assert_eq!(points.len(), PARTS);
        for (t, value) in points {
            // Three values of |sin 2t| that are 1 apart in t, and more so four: one is within 0.57 of its top, where it
            // is above 0.84, as π − 2 and 4 − π are 1.14 and 0.86.
            let part = value / amplitude(*t);
            assert!((0.82..1.0 + 1e-12).contains(&part), "{t}: {part}");
            assert!(row.samples.iter().any(|s| s.t == *t));
        }
    }
}

/// A penalty in balance leaves its loop open from the start on: that is no change, and it is drawn.
#[test]
fn what_is_left_of_loops_is_drawn_as_it_is() {
    let mut comparison = compared(&["newmark"], None);
    for row in &mut comparison.rows {
        for sample in &mut row.samples {
            sample.violation = Some(-0.25);
        }
    }
    let graphs = drift(&comparison);
    let name = "residual of the loops' equations";
    let mut own = graphs.iter().filter(|g| g.description[1] == name);
    let points = &own.next().unwrap().curves[0].points;
    assert!(!points.is_empty() && points.iter().all(|p| p.1 == 0.25));
}
