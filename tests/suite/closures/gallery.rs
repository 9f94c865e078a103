//! Every mechanism of the gallery with its loops closed by a map, by multipliers and by a penalty.

use crate::support::dynamics::*;
use crate::support::loops::gap;
use crate::support::prelude::*;
use crate::support::program::{cells, example};
use pullback::studies::gallery::MODELS;
use std::collections::BTreeSet;

/// Models, the end and the step of a short run, a penalty at which its springs give way by a small part of
/// what the step costs, with its damping, and nodes that move.
const RUNS: &str = "
four_bar | 0.5 | 4e-3 | 1e8 | 1e-3 | coupler tip
slider_crank | 0.5 | 4e-3 | 1e8 | 1e-3 | crank pin, slider
parallelograms | 0.4 | 8e-3 | 1e8 | 1e-3 | end 1, end 5
squeezer | 4e-3 | 4e-5 | 1e11 | 1e-5 | P, K6 end
bricard | 0.8 | 8e-3 | 1e8 | 1e-3 | end 2, end 4
four_bar_flexible | 0.4 | 2e-3 | 1e8 | 1e-3 | coupler/4, coupler tip
slider_crank_flexible | 0.4 | 2e-3 | 1e9 | 1e-3 | rod/4, rod end
four_bar_misaligned | 0.5 | 1e-2 | 1e10 | 1e-4 | C, bar 3/4
";

/// Positions of the nodes at the end, and the number of unknowns.
fn end([name, to, nodes]: [&str; 3], words: &str, step: f64) -> (Vec<f64>, usize) {
    let with = |line: &str| match line.starts_with("child = ") {
        true => format!("{line}\n{words}\n"),
        false => format!("{line}\n"),
    };
    let text: String = example(name).lines().map(with).collect();
    let mut job = assemble_text(name, &text).unwrap();
    let nodes = nodes.split(", ").map(|n| job.context.find(n).unwrap());
    let nodes: Vec<NodeId> = nodes.collect();
    let damped = Scheme::chung_hulbert(0.8).unwrap();
    let options = tight(damped, to.parse().unwrap(), step);
    let start = [&job.start.q[..], &job.start.v[..]];
    let (mut positions, mut unknowns) = (Vec::new(), 0);
    observed(&mut job.context, start, &options, &mut |model, step| {
        let position = |n: &_| <[f64; 3]>::from(model.node_state(*n).position);
        positions = nodes.iter().flat_map(position).collect();
        unknowns = step.progress.state.q.len();
    });
    (positions, unknowns)
}

#[test]
fn every_mechanism_moves_alike_however_its_loops_are_closed() {
    for [name, to, h, penalty, damping, nodes] in cells(RUNS) {
        let (run, h) = ([name, to, nodes], h.parse::<f64>().unwrap());
        let methods = ["closure = \"map\"", "closure = \"multipliers\""]
            .map(|words| [h, 0.5 * h].map(|h| end(run, words, h)));
        let [map, other] = &methods;
        assert!(other[0].1 > map[0].1, "{name} has multipliers");
        let steps = methods.each_ref().map(|m| gap(&m[0].0, &m[1].0));
        let [map, other] = methods.each_ref().map(|[coarse, fine]| -> Vec<f64> {
            let both = coarse.0.iter().zip(&fine.0);
            both.map(|(c, f)| f + (f - c) / 3.0).collect()
        });
        let limits = gap(&map, &other);
        let words =
            format!("closure = \"penalty\"\npenalty = {penalty}\npenalty_damping = {damping}");
        let soft = gap(&end(run, &words, 0.5 * h).0, &methods[1][1].0);
        println!("{name}: steps {steps:?}, limits apart {limits:e}, penalty {soft:e}");
        // Of order two, all of them: what is left without steps is a hundredth of what the steps cost.
        assert!(steps[0].min(steps[1]) > 1e-9, "{name} moves: {steps:?}");
        assert!(limits < 0.01 * steps[1], "{name}: {limits} {steps:?}");
        let soft_enough = 1e-13 < soft && soft < 0.5 * steps[1];
        assert!(soft_enough, "{name}: {soft} {steps:?}");
    }
}

#[test]
fn no_mechanism_is_left_out() {
    let loops = MODELS.iter().filter(|m| m.1.contains("\nchild = "));
    let loops: BTreeSet<&str> = loops.map(|m| m.0).collect();
    assert_eq!(loops, cells(RUNS).map(|[name, ..]: [_; 6]| name).collect());
}
