//! Models of which everything is driven: the forces of given motions.

use crate::support::closures::{
    GROUND, PLAIN, STATIC, angle, body_of, hinge, motion, probe, probe_of,
};
use crate::support::dynamics::integrate_ode;
use crate::support::prelude::*;
use crate::support::program::{Rows, assert_close, number, recorded, run_of};

/// What an arm of mass 2 and centre 0.5 does whose angle a motor prescribes.
fn driven_arm(name: &str, analysis: &str, angle_of: &str) -> Rows {
    let inertia = "center = [0.5, 0, 0]\ninertia = [0.1, 0.2, 0.3]";
    let text = [
        GROUND,
        &hinge("motor", "ground", &format!("prescribed = {angle_of}")),
        &body_of("motor", 2.0, inertia),
        "[[loads]]\ngravity = [0, -9.81, 0]\n",
        analysis,
        &angle("motor"),
        &probe("moment", "joint_moment", "motor"),
        &probe_of("effort", "joint_effort", "joint = \"motor\""),
        &probe("support", "reaction_moment", "ground"),
        &probe("force", "reaction_force", "ground"),
    ];
    let ran = run_of(name, &text.concat());
    assert!(ran.said.is_empty(), "{}", ran.said);
    ran.rows
}

/// Inverse dynamics: the moment that a given motion takes, with nothing left to solve for.
#[test]
fn a_model_of_which_everything_is_driven_gives_the_moments_of_its_drives() {
    let (rate, T) = (6.0, 0.5);
    let angle = format!("{{ spin_up = {{ rate = {rate}, duration = {T} }} }}");
    let analysis = "[analysis.dynamic]\nto = 0.4\nstep = 0.01\n";
    let rows = driven_arm("all-driven", analysis, &angle);
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
        for (name, exact) in [
            ("motor", theta),
            ("moment.z", moment),
            ("effort", moment),
            ("support.z", moment),
            ("force.x", fx),
            ("force.y", fy),
        ] {
            assert_close(number(row, name), exact, 1e-10, name);
        }
    }
    // At rest the weight alone, at its full size from the end of a load step of one.
    let drive = "{ proportional = 0.8 }";
    for row in &driven_arm("all-driven-at-rest", STATIC, drive) {
        let t = number(row, "t");
        let exact = t * 9.81 * (0.8 * t).cos();
        for name in ["moment.z", "effort"] {
            assert_close(number(row, name), exact, 1e-12 * 9.81, t);
        }
    }
}

/// Two hinges with springs and dampers in series carry one inertia: of their rates only the sum is given, and the rest follows
/// from the balance of the dampers. The schemes have their order.
#[test]
fn dampers_in_series_begin_with_consistent_rates() {
    let spring = |k: f64, c: f64| format!("spring = {{ k = {k:?}, c = {c:?} }}");
    let ([k1, c1], [k2, c2], J) = ([2.0, 0.05], [1.0, 0.02], 0.1);
    // (q₁, θ, θ̇) with θ = q₁ + q₂.
    let rate = |y: &Vector3<f64>| (c2 * y.z + k2 * (y.y - y.x) - k1 * y.x) / (c1 + c2);
    let ode = |_: f64, y: &Vector3<f64>| Vector3::new(rate(y), y.z, -(k1 * y.x + c1 * rate(y)) / J);
    let exact = integrate_ode(&ode, Vector3::new(0.3, 0.3, 0.0), 0.5, 50_000);
    for scheme in ["ga:0.9", "newmark", "bathe"] {
        let error = |h: f64| {
            let text = [
                GROUND,
                &hinge("A", "ground", &format!("{}\nvalue = 0.3", spring(k1, c1))),
                &hinge("B", "A", &spring(k2, c2)),
                &body_of("B", 1.0, "inertia = [0.1, 0.1, 0.1]"),
                &motion(0.5, h),
                &format!("scheme = \"{scheme}\"\n{PLAIN}"),
                &angle("A"),
                &angle("B"),
            ];
            let rows = recorded("series", &text.concat());
            let last = rows.last().unwrap();
            let [q1, q2] = ["A", "B"].map(|joint| number(last, joint));
            (q1 - exact.x).abs().max((q1 + q2 - exact.y).abs())
        };
        let [coarse, fine] = [0.005, 0.0025].map(error);
        let second = coarse > 3.4 * fine && coarse < 1e-3;
        assert!(second, "{scheme}: {coarse:e} {fine:e}");
    }
}
