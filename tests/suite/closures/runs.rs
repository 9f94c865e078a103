//! Changes of chart and drives that jump: multipliers against the map.

use super::started_with;
use crate::support::closures::{CLOSURES, GROUND, RUN, arm, body, joint, probe};
use crate::support::dynamics::*;
use crate::support::loops::four_bar::*;
use crate::support::loops::linkage::*;
use crate::support::loops::*;
use crate::support::prelude::*;
use crate::support::program::{Ran, assert_close, number, run_of};

/// A crank and a rocker with a coupler between two balls that spins, in n steps: how far its energy drifts, and where
/// the coupler ends.
fn spun(by: Closure, scheme: Scheme, n: u32) -> (f64, Vector3<f64>) {
    let mut b = ModelBuilder::new();
    let (rotation, e) = balls(&mut b, by);
    let mut context = Context::new(b.build().unwrap());
    let spin = [0, 1, 2].map(|k| (rotation, k, 7.0 * e[k]));
    let [q, v] = started_with(&mut context, &spin);
    let options = tight(scheme, 1.5, 1.5 / f64::from(n));
    let ends = ["coupler end", "rocker end"].map(|n| context.find(n).unwrap());
    let (mut position, mut start) = (Vector3::zeros(), None);
    let (mut drift, mut residual, mut turned) = (0.0_f64, 0.0_f64, 0.0_f64);
    let run = observed(&mut context, [&q, &v], &options, &mut |context, step| {
        let at = point(&step.progress.state);
        let audit = context.energies_and_momentum(at).unwrap();
        let energy = audit.energies.kinetic + audit.load_potential;
        drift = drift.max((energy - *start.get_or_insert(energy)).abs());
        let [p, q] = ends.map(|n| context.node_state(n).position);
        position = p;
        residual = residual.max((p - q).norm());
        turned = turned.max(context.coordinate(rotation, 0).unwrap()[0].abs());
    });
    if by == Closure::Map {
        // Eight unknowns, six equations: the mechanism's freedom and the spin of the coupler.
        assert_eq!(q.len(), 2);
        assert!(residual < 1e-13, "{residual:e}");
    }
    assert!(residual < 1e-11, "{residual:e}");
    assert!(run.summary.chart_changes >= 2, "{:?}", run.summary);
    assert!(turned <= PI, "{turned}");
    (drift, position)
}

#[test]
fn ball_joints_in_a_loop_change_their_charts() {
    let by_map = [500, 1000, 2000].map(|n| spun(Closure::Map, Scheme::default(), n));
    assert_order("energy", &by_map.map(|run| run.0), 2.0, 0.25);
    let [coarse, medium, fine] = by_map.map(|run| run.1);
    let steps = [coarse - medium, medium - fine].map(|step| step.norm());
    assert_order("position", &steps, 2.0, 0.25);
    // The limit of the map, extrapolated from two steps.
    let limit = fine + (fine - medium) / 3.0;
    let damped = Scheme::chung_hulbert(0.9).unwrap();
    let off = |n| (spun(Closure::Multipliers, damped, n).1 - limit).norm();
    assert_order("multipliers", &[400, 800, 1600].map(off), 2.0, 0.25);
}

#[test]
fn a_drive_that_jumps_strikes_the_whole_loop() {
    // The crank is driven, and its velocity jumps: the free pendulum on the coupler takes it.
    let go = |by: Closure, h: f64| {
        let mut b = ModelBuilder::new();
        let angles = linkage(&mut b, CRANK_START, at_once, by);
        let tip = b.find("tip of the coupler").unwrap();
        let from: [f64; 3] = b.position(tip).into();
        let to = [from[0] + 0.3, from[1] - 0.2, 0.0];
        let pendulum = link(&mut b, "pendulum", tip, [from, to], (0.4, at_once)).coordinates[0];
        let points = vec![[0.0, 0.0], [0.1, 0.1], [0.2, 0.4], [0.4, 0.5]];
        let drive = Table::new(points).unwrap();
        b.prescribe_coordinate(angles[0], 0, drive);
        let mut context = Context::new(b.build().unwrap());
        let mut q = context.initial().to_vec();
        let mut v = vec![0.0; q.len()];
        // Of a model that enforces nothing this takes nothing.
        context
            .project_state(BEFORE_START, &mut q, &mut v, &[])
            .unwrap();
        let options = tight(Scheme::chung_hulbert(0.8).unwrap(), 0.3, h);
        let mut end = Vec::new();
        observed(&mut context, [&q, &v], &options, &mut |context, _| {
            let [x, x_dot, _] = context.coordinate(pendulum, 0).unwrap();
            end = vec![x, x_dot];
        });
        end
    };
    let all = [2e-3, 1e-3, 5e-4].map(|h| {
        let [map, other] = [Closure::Map, Closure::Multipliers].map(|by| go(by, h));
        gap(&map, &other)
    });
    assert_order("struck", &all, 2.0, 0.3);
}

/// A shaft on a ball joint, whose far end turns in a bearing that multipliers close, under a constant moment M about it:
/// ω = M t/J. The bearing stays as it is where the ball joint's rotation vector changes to its complement.
#[test]
fn a_ball_joint_turns_through_half_turns_before_a_bearing() {
    for axis in [[0.0, 0.0, 1.0], [0.48, 0.6, 0.64]] {
        let text = [
            GROUND,
            &joint("ball", "spherical", "ground", ""),
            &arm("end", "ball", axis),
            &arm("foot", "ground", axis),
            &joint(
                "bearing",
                "revolute",
                "end",
                &format!("axis = {axis:?}\nchild = \"foot\"\n{}", CLOSURES[1]),
            ),
            &body("ball"),
            &format!("[[loads]]\nnode = \"ball\"\nmoment = {axis:?}\n"),
            &probe("w", "angular_velocity", "ball"),
            RUN,
        ]
        .concat()
        .replace("to = 0.5", "to = 3");
        let Ran { rows, result, .. } = run_of("closures_shaft", &text);
        assert!(result["statistics"]["chart_changes"].as_u64() > Some(7));
        for row in &rows {
            for (name, e) in ["w.x", "w.y", "w.z"].into_iter().zip(axis) {
                assert_close(number(row, name), 10.0 * e * number(row, "t"), 1e-8, name);
            }
        }
    }
}
