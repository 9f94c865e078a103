//! Weight of lines whose mass centre is beside their axis, from model files.
#![allow(clippy::unwrap_used)]

use pullback::input::{Plan, assemble_text};
use pullback::integrators::dynamics::{Progress, start};
use pullback::solve::solve;
use std::ops::ControlFlow;

/// A line along e1 with its mass centre at c = 0.2 along e2, of Aρ = 3 and J₁ = 0.05 per length.
fn model(section: &str, line: &str, rest: &str) -> String {
    format!(
        r#"
[sections.beam]
{section}
mass = {{ A_rho = 3, J = [0.05, 0.03, 0.02], center = [0.2, 0] }}

[nodes]
root = [0, 0, 0]
tip = [2, 0, 0]

[[lines]]
name = "line"
to = "tip"
elements = 4
section = "beam"
{line}

[[supports]]
node = "root"
fix = "all"

[[loads]]
gravity = [0, 0, -9.81]
{rest}
"#
    )
}

#[test]
fn it_twists_a_cantilever() {
    for order in [1, 2, 3] {
        for interpolation in ["total", "geodesic"] {
            let text = model(
                "stiffness = { EA = 1e9, GA = [1e9, 1e9], GJ = 1e6, EI = [1e9, 1e9] }",
                &format!("from = \"root\"\norder = {order}\ninterpolation = \"{interpolation}\""),
                "[analysis.static]",
            );
            let job = assemble_text("cantilever", &text).unwrap();
            let mut model = job.context;
            let tip = model.find("tip").unwrap();
            let q = vec![0.0; job.start.q.len()];
            let zeros = start(&model, 0.0, &q, &q).unwrap();
            let mut twist = f64::NAN;
            let ended = solve(
                &mut model,
                &job.plan,
                &mut Progress::new(zeros),
                &mut |model, _| {
                    twist = model.node_state(tip).R[(2, 1)];
                    ControlFlow::Continue(())
                },
            );
            assert!(ended.finished, "{:?}", ended.failure);
            // GJ θ'' = Aρ g c: the weight turns its centre down.
            let exact = -3.0 * 9.81 * 0.2 * 2.0 * 2.0 / (2.0 * 1e6);
            assert!(
                (twist - exact).abs() < 1e-6 * exact.abs(),
                "order {order}, {interpolation}: {twist} for {exact}"
            );
        }
    }
}

/// Largest rate of the line as a pendulum about its own axis, let go with its centre beside it.
fn fastest(interpolation: &str, step: f64) -> f64 {
    let text = model(
        "stiffness = { EA = 1e8, GA = [1e8, 1e8], GJ = 1e8, EI = [1e8, 1e8] }",
        &format!("from = \"pivot\"\norder = 1\ninterpolation = \"{interpolation}\""),
        &format!(
            r#"
[[joints]]
name = "pivot"
type = "revolute"
parent = "root"
axis = [1, 0, 0]

[[supports]]
node = "tip"
fix = ["x", "y", "z", "ry", "rz"]

[analysis.dynamic]
to = 1
step = {step}
"#
        ),
    );
    let job = assemble_text("pendulum", &text).unwrap();
    let mut model = job.context;
    let Plan::Dynamic(_) = job.plan else {
        panic!("it is a motion");
    };
    let tip = model.find("tip").unwrap();
    let mut progress = Progress::new(start(&model, 0.0, &job.start.q, &job.start.v).unwrap());
    let mut rates = Vec::new();
    let ended = solve(&mut model, &job.plan, &mut progress, &mut |model, _| {
        rates.push(model.node_state(tip).omega.x.abs());
        ControlFlow::Continue(())
    });
    assert!(ended.finished, "{:?}", ended.failure);
    rates.into_iter().fold(0.0, f64::max)
}

#[test]
fn it_swings_a_line_about_its_axis() {
    // ½ (J₁ + Aρ c²) ω² = Aρ g c, whatever the elements.
    let exact = f64::sqrt(2.0 * 3.0 * 9.81 * 0.2 / (0.05 + 3.0 * 0.04));
    for interpolation in ["total", "geodesic"] {
        let errors = [0.01, 0.005].map(|h| (fastest(interpolation, h) - exact).abs());
        assert!(errors[1] < 1e-3 * exact, "{interpolation}: {errors:?}");
    }
}

#[test]
fn what_falls_freely_does_not_turn() {
    for order in [1, 2, 3] {
        for interpolation in ["total", "geodesic"] {
            let text = model(
                "stiffness = { EA = 3e3, GA = [1e3, 1.2e3], GJ = 20, EI = [20, 15] }",
                &format!(
                    "from = \"root\"\norder = {order}\ninterpolation = \"{interpolation}\"\n\
                     twist_deg = 200"
                ),
                "[analysis.dynamic]\nto = 0.5\nstep = 0.05\n",
            );
            let support = "[[supports]]\nnode = \"root\"\nfix = \"all\"\n";
            let job = assemble_text("falling", &text.replace(support, "")).unwrap();
            let mut model = job.context;
            let tip = model.find("tip").unwrap();
            let start = start(&model, 0.0, &job.start.q, &job.start.v).unwrap();
            let ended = solve(
                &mut model,
                &job.plan,
                &mut Progress::new(start),
                &mut |_, _| ControlFlow::Continue(()),
            );
            assert!(ended.finished, "{:?}", ended.failure);
            let state = model.node_state(tip);
            let about = format!("order {order}, {interpolation}: {state:?}");
            assert!((state.velocity.z + 9.81 * 0.5).abs() < 1e-10, "{about}");
            assert!(state.omega.norm() < 1e-10, "{about}");
        }
    }
}
