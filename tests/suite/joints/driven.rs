//! Models of which everything is driven: the forces of given motions.
#![allow(clippy::unwrap_used, non_snake_case)]

use crate::support::program::{directory, history, number, program, succeeded, write};
use std::f64::consts::TAU;

/// An arm of mass 2 and centre 0.5 from a motor that prescribes its angle: `analysis` and the angle.
fn driven_arm(analysis: &str, angle: &str) -> String {
    format!(
        r#"
[nodes]
ground = [0, 0, 0]

[[joints]]
name = "motor"
type = "revolute"
parent = "ground"
axis = [0, 0, 1]
prescribed = {angle}

[[bodies]]
name = "arm"
node = "motor"
mass = 2
center = [0.5, 0, 0]
inertia = [0.1, 0.2, 0.3]

[[supports]]
node = "ground"
fix = "all"

[[loads]]
gravity = [0, -9.81, 0]

{analysis}

[[probes]]
name = "angle"
quantity = "joint_coordinate"
joint = "motor"

[[probes]]
name = "moment"
quantity = "joint_moment"
node = "motor"

[[probes]]
name = "support"
quantity = "reaction_moment"
node = "ground"

[[probes]]
name = "force"
quantity = "reaction_force"
node = "ground"
"#
    )
}

/// Inverse dynamics: the moment that a given motion takes, with nothing left to solve for.
#[test]
fn a_model_of_which_everything_is_driven_gives_the_moments_of_its_drives() {
    let (rate, T) = (6.0, 0.5);
    let angle = format!("{{ spin_up = {{ rate = {rate}, duration = {T} }} }}");
    let analysis = "[analysis.dynamic]\nto = 0.4\nstep = 0.01";
    let out = directory("all-driven");
    let output = program(&[&write(&out, &driven_arm(analysis, &angle))]);
    let said = succeeded(&output);
    assert!(said.is_empty(), "{said}");
    let rows = history(&out.join("model.out"));
    assert_eq!(rows.len(), 41);
    for row in &rows {
        let t = number(row, "t");
        let phase = TAU * t / T;
        let theta = rate / T * (t * t / 2.0 + (T / TAU).powi(2) * (phase.cos() - 1.0));
        let omega = rate / T * (t - T / TAU * phase.sin());
        let alpha = rate / T * (1.0 - phase.cos());
        // About the pivot: (0.3 + 2 0.5²) θ̈ + 2 g 0.5 cos θ; with it 2 (a − g) at the pin.
        let moment = 0.8 * alpha + 9.81 * theta.cos();
        let fx = -alpha * theta.sin() - omega * omega * theta.cos();
        let fy = alpha * theta.cos() - omega * omega * theta.sin() + 2.0 * 9.81;
        let close = |name: &str, exact: f64| {
            let found = number(row, name);
            assert!((found - exact).abs() < 1e-10, "{t} {name}: {found} {exact}");
        };
        close("angle", theta);
        close("moment.z", moment);
        close("support.z", moment);
        close("force.x", fx);
        close("force.y", fy);
    }
    // At rest the weight alone, at its full size from the end of a load step of one.
    let analysis = "[analysis.static]\nsteps = 4";
    let out = directory("all-driven-at-rest");
    let output = program(&[&write(
        &out,
        &driven_arm(analysis, "{ proportional = 0.8 }"),
    )]);
    let said = succeeded(&output);
    assert!(said.is_empty(), "{said}");
    for row in &history(&out.join("model.out")) {
        let t = number(row, "t");
        let (found, exact) = (number(row, "moment.z"), t * 9.81 * (0.8 * t).cos());
        assert!((found - exact).abs() < 1e-12 * 9.81, "{t}: {found} {exact}");
    }
}
