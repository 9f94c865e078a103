//! Jumps of driven velocities: what is free takes the impulse.
#![allow(clippy::unwrap_used)]

use pullback::elements::model::Model;
use pullback::input::{Plan, assemble_text};
use pullback::integrators::dynamics::{Progress, integrate, start};
use pullback::manifold::system::Point;
use pullback::solve::begin;
use std::ops::ControlFlow;

/// A free body with a rotor on a driven hinge, about a principal axis of both.
const ROTOR: &str = r#"
[nodes]
A = [0, 0, 0]

[[bodies]]
name = "hull"
node = "A"
mass = 3
inertia = [2, 2, 2]

[[joints]]
name = "hinge"
type = "revolute"
master = "A"
axis = [0, 0, 1]
driven = { table = [[0.5, 0], [1, 2]] }

[[bodies]]
name = "rotor"
node = "hinge"
mass = 1
inertia = [1, 1, 0.5]

[analysis.dynamic]
to = 2
step = 0.1
"#;

#[test]
fn a_rotor_that_is_jerked_turns_its_free_hull_back() {
    let job = assemble_text("rotor", ROTOR).unwrap();
    let mut model = job.model;
    let Plan::Dynamic(plan) = job.plan else {
        panic!("it is a motion");
    };
    let hull = model.find("A").unwrap();
    let mut progress = Progress::new(start(&model, 0.0, &job.start.q, &job.start.v).unwrap());
    let mut seen = 0;
    integrate(
        &mut model,
        &mut progress,
        &plan.options,
        &mut |model, step| {
            let state = &step.progress.state;
            let at = Point {
                t: state.t,
                q: &state.q,
                v: &state.v,
                a: &state.a,
            };
            let audit = model.audit(at).unwrap();
            assert!(audit.momentum.angular.norm() < 1e-12, "at {}", state.t);
            // (2 + ½) Ω + ½ ω = 0 with the rate ω of the drive.
            let rate = if (0.5..1.0).contains(&state.t) {
                4.0
            } else {
                0.0
            };
            let omega = model.node_state(hull).omega;
            assert!(
                (omega.z + rate * 0.5 / 2.5).abs() < 1e-12,
                "at {}: {omega}",
                state.t
            );
            seen += 1;
            ControlFlow::Continue(())
        },
    )
    .unwrap();
    assert_eq!(seen, 20);
    // The hull has turned by the integral of Ω.
    let psi = model.node_state(hull).psi;
    assert!((psi.z + 0.4).abs() < 1e-12, "{psi}");
    // What the drive has done is what went into the energy, and out again.
    let energy = progress.summary.energy.unwrap();
    assert!(energy.largest_defect < 1e-12, "{energy:?}");
}

/// A mass on a stiff spring that starts 0.1 off, on a base that is jerked, with or without a hinge
/// beside it that has no mass.
fn jerked(idle: &str) -> Vec<[f64; 3]> {
    let text = format!(
        r#"
[nodes]
base = [0, 0, 0]

[[supports]]
node = "base"
fix = ["y", "z", "rx", "ry", "rz"]
driven = {{ x = {{ table = [[0.03, 0], [0.1, 0.07]] }} }}

[[joints]]
name = "way"
type = "prismatic"
master = "base"
axis = [1, 0, 0]
spring = {{ k = 1e4, x0 = 0.1 }}

{idle}
[[bodies]]
name = "bob"
node = "way"
mass = 1

[analysis.dynamic]
to = 0.06
step = 0.01
"#
    );
    let job = assemble_text("jerked", &text).unwrap();
    let mut model = job.model;
    let Plan::Dynamic(plan) = job.plan else {
        panic!("it is a motion");
    };
    let node = model.find("way").unwrap();
    let mut progress = Progress::new(start(&model, 0.0, &job.start.q, &job.start.v).unwrap());
    begin(&mut model, &plan.options, &mut progress).unwrap();
    let row = |model: &Model| {
        let state = model.node_state(node);
        [state.place.x, state.velocity.x, state.acceleration.x]
    };
    let mut rows = vec![row(&model)];
    integrate(&mut model, &mut progress, &plan.options, &mut |model, _| {
        rows.push(row(model));
        ControlFlow::Continue(())
    })
    .unwrap();
    rows
}

#[test]
fn what_has_no_mass_leaves_alone_what_it_has_nothing_to_do_with() {
    let hinge = "[[joints]]\nname = \"idle\"\ntype = \"revolute\"\nmaster = \"base\"\n\
                 axis = [0, 1, 0]\nspring = { k = 1 }\n";
    let (alone, beside) = (jerked(""), jerked(hinge));
    // k x0/m.
    assert!((alone[0][2] - 1e3).abs() < 1e-9, "{:?}", alone[0]);
    assert_eq!(alone.len(), 7);
    for (a, b) in alone.iter().zip(&beside) {
        for (a, b) in a.iter().zip(b) {
            assert!(
                (a - b).abs() < 1e-9 * (1.0 + a.abs()),
                "{alone:?}\n{beside:?}"
            );
        }
    }
}
