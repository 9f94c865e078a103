//! What adding spins of different tangent spaces does to Newmark's scheme, after theory.
//!
//! Equal steps of the trapezoidal rule, β = 1/4 and γ = 1/2, on a free symmetrical body. With
//! Ω̇ linear in a step each formulation's rotation θ over it is off by Newmark's quadrature of what
//! it integrates, less what the true rotation vector has besides ∫Ω, which is (h³/12) Ω×Ω̇ (Magnus):
//!
//! ```text
//! Lie group             (h³/12) (Ω̈ − Ω×Ω̇)       sums of Ω
//! updated Lagrangian    (h³/12) (Ω̈ + ½ Ω×Ω̇)     θ⃛ = Ω̈ + ½ Ω×Ω̇ at θ = 0
//! spatial spins         (h³/12) (Ω̈ + 2 Ω×Ω̇)     sums of ω = RΩ, ω̈ = R(Ω̈ + Ω×Ω̇)
//! ```
//!
//! Mixed spins add rates in the components of the body to a velocity in the fixed frame,
//! ω′ = ω + (h/2) Rₙ(Ω̇ + Ω̇′), which leaves out the turn of Ω̇′ by hΩ: ω is off by −(h²/2) Rₙ(Ω×Ω̇) in every
//! step, and an order is lost.

use crate::support::comparisons::{BODY, precession};
use crate::support::dynamics::{assert_order, formulated, observed, tight};
use crate::support::prelude::*;
use nalgebra::{Rotation3, UnitQuaternion};
use pullback::method::Method;

const METHODS: [&str; 3] = ["lie-newmark", "ul-newmark", "spin-newmark"];

const J: Vector3<f64> = Vector3::new(2.0, 2.0, 1.0);
const OMEGA: Vector3<f64> = Vector3::new(3.0, 0.0, 4.0);

/// Runs a model until `to`: where the run is.
fn run(job: &mut Job, method: &Method, to: f64, h: f64) -> Progress {
    let options = tight(method.scheme(), to, h);
    let start = [&job.start.q[..], &job.start.v];
    observed(&mut job.context, start, &options, &mut |_, _| ())
}

/// J⁻¹ (J a × b).
fn euler(a: &Vector3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
    J.component_mul(a).cross(b).component_div(&J)
}

/// How far the free body is off after a run to a time: its rotation vector, and its angular velocity.
fn off(name: &str, to: f64, h: f64) -> [Vector3<f64>; 2] {
    let method: Method = name.parse().unwrap();
    let mut job = formulated(BODY, method.formulation());
    run(&mut job, &method, to, h);
    let (node, _) = job.context.frames().next().unwrap();
    let node = job.context.node_state(node);
    // ω goes round L, too.
    let [round, R] = precession(to).map(|exact| exact.to_rotation_matrix());
    let turn =
        UnitQuaternion::from(Rotation3::from_matrix_unchecked(R.inverse() * node.R)).scaled_axis();
    [turn, node.omega - round * OMEGA]
}

/// An error in one step as a multiple of hᵏ, in powers of h, extrapolated once.
fn local(error: impl Fn(f64) -> Vector3<f64>, k: i32) -> Vector3<f64> {
    let part = |h: f64| error(h) / h.powi(k);
    part(1e-3) * 2.0 - part(2e-3)
}

#[test]
fn the_local_error_is_that_of_what_is_added_up() {
    let Omega_dot = euler(&OMEGA, &OMEGA);
    let Omega_ddot = euler(&Omega_dot, &OMEGA) + euler(&OMEGA, &Omega_dot);
    for (name, factor) in METHODS.into_iter().zip([-1.0, 0.5, 2.0]) {
        let found = local(|h| off(name, h, h)[0], 3);
        let expected = (Omega_ddot + OMEGA.cross(&Omega_dot) * factor) / 12.0;
        let off = (found - expected).norm() / expected.norm();
        assert!(off < 1e-3, "{name}: {found} {expected}");
    }
}

#[test]
fn rates_that_are_not_transported_cost_an_order() {
    // R = 1 at the beginning of the step.
    let found = local(|h| off("mixed-newmark", h, h)[1], 2);
    let expected = OMEGA.cross(&euler(&OMEGA, &OMEGA)) * -0.5;
    let gap = (found - expected).norm() / expected.norm();
    assert!(gap < 1e-3, "{found} {expected}");
    let errors = [2e-3, 1e-3, 5e-4].map(|h| off("mixed-newmark", 2.0, h));
    for k in 0..2 {
        assert_order("mixed", &errors.map(|off| off[k].norm()), 1.0, 0.1);
    }
}

/// How far a run ends from its start, R = 1, when velocities are turned round half way.
fn returned(name: &str, h: f64) -> f64 {
    let method: Method = name.parse().unwrap();
    let mut job = formulated(BODY, method.formulation());
    let mut progress = run(&mut job, &method, 1.0, h);
    progress.state.v.iter_mut().for_each(|v| *v = -*v);
    let options = tight(method.scheme(), 2.0, h);
    let back = Simulation::resume(&mut job.context, progress, &options);
    back.unwrap().finish().unwrap();
    let (node, _) = job.context.frames().next().unwrap();
    (job.context.node_state(node).R - Matrix3::identity()).norm()
}

#[test]
fn sums_of_spins_can_be_run_backwards_and_charts_of_a_steps_beginning_cannot() {
    // With θ = h Ωₙ + (h²/4)(aₙ + aₙ₊₁) and Ωₙ₊₁ = Ωₙ + (h/2)(aₙ + aₙ₊₁) the step from n + 1 with −Ωₙ₊₁
    // has −θ, whichever spins they are.
    for name in ["lie-newmark", "spin-newmark"] {
        let back = returned(name, 0.02);
        assert!(back < 1e-9, "{name}: {back:e}");
    }
    // The updated Lagrangian adds up in the chart at Rₙ: from Rₙ₊₁ it is another one.
    let [coarse, fine] = [0.02, 0.01].map(|h| returned("ul-newmark", h));
    assert!(coarse > 1e-6, "{coarse:e}");
    // What does not return is an error of the scheme, which is of order 2.
    assert!((coarse / fine).log2() > 1.9, "{coarse:e} {fine:e}");
}
