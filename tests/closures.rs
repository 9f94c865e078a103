//! One constraint, three methods: the map, multipliers and a penalty, against each other and against
//! closed-form kinematics, an equation of motion of one freedom, and Newton's laws for the pin.

#![allow(non_snake_case, clippy::unwrap_used)]

mod dynamics_support;
mod loops_support;

use dynamics_support::*;
use loops_support::four_bar::*;
use loops_support::linkage::*;
use loops_support::*;
use nalgebra::{Vector2, Vector3};
use pullback::elements::constraint::Stiffness;
use pullback::elements::model::{Closure, Model, ModelBuilder, NodeId};
use pullback::integrators::dynamics::{Progress, Scheme};
use pullback::manifold::system::{Evaluation, Point, System};

fn penalty(p: f64) -> Closure {
    Closure::Penalty(Stiffness { p, tau: 0.0 })
}

/// What a run leaves behind.
struct Outcome {
    /// Angles of crank, coupler and rocker, and their rates.
    end: Vec<f64>,
    /// Force of the coupler on the rocker at the end, as vectors at all times.
    force: Vec<Vector3<f64>>,
    /// Largest gap on the way.
    gap: f64,
    unknowns: usize,
    progress: Progress,
}

/// Starts the linkage with the crank's rate.
fn started(model: &mut Model, crank: NodeId) -> [Vec<f64>; 2] {
    let mut q = model.initial().to_vec();
    let mut v = vec![0.0; q.len()];
    match model.unknown_at(crank, 0) {
        Some(u) => {
            v[u] = CRANK_RATE;
            let left = model.satisfy(0.0, &mut q, &mut v, &[u]).unwrap();
            assert!(left < 1e-12, "{left:e}");
        }
        None => {
            let rates = [(crank, 0, CRANK_RATE)];
            let left = model.fit_coordinate_rates(&q, &mut v, &rates).unwrap();
            assert!(left < 1e-12, "{left:e}");
        }
    }
    [q, v]
}

fn go(by: Closure, [to, step]: [f64; 2]) -> Outcome {
    let mut b = ModelBuilder::new();
    let angles = linkage_by(&mut b, CRANK_START, at_once, by);
    let mut model = b.build().unwrap();
    let unknowns = model.pattern().dim();
    let [q, v] = started(&mut model, angles[0]);
    let mut options = tight(Scheme::chung_hulbert(0.8).unwrap(), to, step);
    options.newton.absolute = 1e-12;
    let [tip, other, pin] =
        ["tip of the coupler", "tip of the rocker", "C"].map(|n| model.find(n).unwrap());
    let [coupler, rocker] = closed_form(CRANK_START);
    let (mut end, mut force, mut gap) = (Vec::new(), Vec::new(), 0.0_f64);
    let progress = observed(&mut model, [&q, &v], &options, &mut |model, step| {
        let [a, b, d] = [0, 1, 3].map(|k| model.coordinate(angles[k], 0).unwrap());
        end = vec![
            CRANK_START + a[0],
            coupler + a[0] + b[0],
            rocker + d[0],
            a[1],
            a[1] + b[1],
            d[1],
        ];
        gap = gap.max((model.node_state(tip).place - model.node_state(other).place).norm());
        let s = &step.progress.state;
        let at = Point {
            t: s.t,
            q: &s.q,
            v: &s.v,
            a: &s.a,
        };
        let mut r = vec![0.0; s.q.len()];
        model.evaluate(at, Evaluation::residual(&mut r)).unwrap();
        force.push(model.joint_force(pin).unwrap()[0]);
    });
    Outcome {
        end,
        force,
        gap,
        unknowns,
        progress,
    }
}

fn flat(force: &Vector3<f64>) -> Vector2<f64> {
    assert_eq!(force.z.abs() < 1e-9, true, "{force}");
    force.xy()
}

#[test]
fn multipliers_are_of_order_two_with_their_forces() {
    let to = 1.6;
    let exact = four_bar_exact(to);
    let force = pin_force(exact[0], exact[3]);
    for by in [Closure::Map, Closure::Multipliers] {
        let runs = [800, 1600, 3200].map(|n| go(by, [to, to / f64::from(n)]));
        for run in &runs {
            let summary = &run.progress.summary;
            println!(
                "{by:?}: {} unknowns, gap {:.1e}, error {:.2e}, force {:.2e} of {:.1}, {:.2} iterations a step",
                run.unknowns,
                run.gap,
                gap(&run.end, &exact),
                (flat(run.force.last().unwrap()) - force).norm(),
                force.norm(),
                summary.iterations as f64 / summary.steps as f64,
            );
        }
        let errors: Vec<Vec<f64>> = runs
            .iter()
            .map(|run| {
                let off = (flat(run.force.last().unwrap()) - force).norm();
                vec![
                    gap(&run.end[..3], &exact[..3]),
                    gap(&run.end[3..], &exact[3..]),
                    off,
                ]
            })
            .collect();
        let names = ["angles", "rates", "force"];
        assert_slopes("four-bar", &names, &errors, 2.0, 0.2);
        assert!(runs.iter().all(|r| r.gap < 1e-11));
    }
}
