//! The Lie-group generalised-α method as Brüls, Cardona & Arnold 2012 publish it, stepped here by hand on
//! their heavy top, beside `lie-ga`; the spin-vector Newmark of Simo & Vu-Quoc 1988; and Newmark's formulas
//! for the increment of rotation, the updated Lagrangian of Cardona & Géradin 1988.

use crate::support::dynamics::{formulated, observed, tight};
use crate::support::heavy_top::HELD;
use crate::support::prelude::*;
use crate::support::program::{changed, example};
use nalgebra::Rotation3;
use pullback::method::Method;

/// Brüls, Cardona & Arnold's top about its fixed point: mass, centre of mass, moments of inertia.
const MASS: f64 = 15.0;
const CENTRE: Vector3<f64> = Vector3::new(0.0, 1.0, 0.0);
const INERTIA: Vector3<f64> = Vector3::new(15.234375, 0.46875, 15.234375);
const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);
const START: Vector3<f64> = Vector3::new(0.0, 150.0, -4.61538);

/// J Ω̇ + Ω×JΩ − X×RᵀmG: zero in motion.
fn out_of_balance(
    R: &Rotation3<f64>,
    Omega: &Vector3<f64>,
    Omega_dot: &Vector3<f64>,
) -> Vector3<f64> {
    let weight = R.inverse() * (GRAVITY * MASS);
    INERTIA.component_mul(Omega_dot) + Omega.cross(&INERTIA.component_mul(Omega))
        - CENTRE.cross(&weight)
}

/// The zero of a function, by Newton's method with differences of this size: the last corrections are
/// those of rounding.
fn zero(mut x: Vector3<f64>, size: f64, f: impl Fn(&Vector3<f64>) -> Vector3<f64>) -> Vector3<f64> {
    for _ in 0..20 {
        let columns = [0, 1, 2].map(|k| {
            let e = Vector3::ith(k, size);
            (f(&(x + e)) - f(&(x - e))) / (2.0 * size)
        });
        x -= Matrix3::from_columns(&columns).lu().solve(&f(&x)).unwrap();
    }
    x
}

/// A rotation and an angular velocity in axes of the body.
type Turning = (Matrix3<f64>, Vector3<f64>);

/// Angular velocity and acceleration, and what else a scheme keeps.
type Kept = [Vector3<f64>; 3];

/// The top stepped by hand; `next` is the end of a step, of its unknown.
fn by_hand(
    steps: usize,
    next: impl Fn(&Rotation3<f64>, &Kept, &Vector3<f64>) -> (Rotation3<f64>, Kept),
) -> Vec<Turning> {
    let forces = out_of_balance(&Rotation3::identity(), &START, &Vector3::zeros());
    let first = -forces.component_div(&INERTIA);
    let (mut R, mut state) = (Rotation3::identity(), [START, first, first]);
    let step = |_| {
        let unknown = zero(state[1], 1e-4 * state[1].norm(), |x| {
            let (R, [Omega, Omega_dot, _]) = next(&R, &state, x);
            out_of_balance(&R, &Omega, &Omega_dot)
        });
        (R, state) = next(&R, &state, &unknown);
        (*R.matrix(), state[0])
    };
    (0..steps).map(step).collect()
}

/// Their algorithm:
///
/// ```text
/// (1−α_m) aₙ₊₁ + α_m aₙ = (1−α_f) v̇ₙ₊₁ + α_f v̇ₙ
/// Δqₙ = vₙ + (½−β) h aₙ + β h aₙ₊₁,   qₙ₊₁ = qₙ ∘ exp(h Δq̃ₙ),   vₙ₊₁ = vₙ + (1−γ) h aₙ + γ h aₙ₊₁
/// ```
fn published([alpha_m, alpha_f, beta, gamma]: [f64; 4], h: f64, steps: usize) -> Vec<Turning> {
    by_hand(steps, |R, [v, v_dot, a], new| {
        let a_new = (new * (1.0 - alpha_f) + v_dot * alpha_f - a * alpha_m) / (1.0 - alpha_m);
        let dq = v + (a * (0.5 - beta) + a_new * beta) * h;
        let v_new = v + (a * (1.0 - gamma) + a_new * gamma) * h;
        (R * Rotation3::new(dq * h), [v_new, *new, a_new])
    })
}

/// Its coefficients with numerical damping ρ.
fn damped(rho: f64) -> [f64; 4] {
    let alpha_m = (2.0 * rho - 1.0) / (rho + 1.0);
    let alpha_f = rho / (rho + 1.0);
    let gamma = 0.5 + alpha_f - alpha_m;
    [alpha_m, alpha_f, 0.25 * (gamma + 0.5).powi(2), gamma]
}

/// Rotations and body components of angular velocities after each step of `name`, of the model with changes.
fn stepped(changes: &str, name: &str, h: f64, steps: usize) -> Vec<Turning> {
    let method: Method = name.parse().unwrap();
    let text = changed(&example("heavy_top"), changes);
    let mut job = formulated(&text, method.formulation());
    let top = job.context.find("top").unwrap();
    let options = tight(method.scheme(), steps as f64 * h, h);
    let start = [&job.start.q[..], &job.start.v];
    let mut out = Vec::new();
    observed(&mut job.context, start, &options, &mut |model, _| {
        let node = model.node_state(top);
        out.push((node.R, node.R.tr_mul(&node.omega)));
    });
    out
}

/// Largest distances of rotations, and of angular velocities over the largest.
fn apart(a: &[Turning], b: &[Turning]) -> [f64; 2] {
    assert_eq!(a.len(), b.len());
    let pairs = a.iter().zip(b);
    pairs.fold([0.0; 2], |[R, v]: [f64; 2], (a, b)| {
        [R.max((a.0 - b.0).norm()), v.max((a.1 - b.1).norm() / 150.0)]
    })
}

#[test]
fn lie_ga_is_the_published_algorithm() {
    let (h, steps) = (1e-3, 200);
    for rho in [0.8, 0.5] {
        let theirs = published(damped(rho), h, steps);
        // Held by multipliers its foot is at the origin, where all rounding errors of the gap are of numbers that are
        // zero: it stays there to the last bit, and the rotation does not see it.
        for changes in ["", HELD] {
            let ours = stepped(changes, &format!("lie-ga:{rho}"), h, steps);
            let off = apart(&ours, &theirs);
            assert!(off.iter().all(|d| *d < 1e-10), "{rho}: {off:?} {changes}");
        }
    }
    // Other numbers, and the other formulations, are other algorithms.
    let theirs = published(damped(0.8), h, steps);
    for name in ["lie-ga:0.7", "ul-ga:0.8", "ga:0.8"] {
        let off = apart(&stepped("", name, h, steps), &theirs);
        assert!(off[0] > 1e-6, "{name}: {off:?}");
    }
}

/// Simo & Vu-Quoc 1988 in material form: the new rotation R exp Θ by the sum of material spins,
/// Θ = h Ω + h²[(½−β) A + β A′], and Ω′ = Ω + h[(1−γ) A + γ A′], where nothing is averaged: α_m = α_f = 0.
#[test]
fn lie_newmark_is_the_material_form_of_simo_and_vu_quoc() {
    let (h, steps) = (1e-3, 100);
    let theirs = published([0.0, 0.0, 0.25, 0.5], h, steps);
    let off = apart(&stepped("", "lie-newmark", h, steps), &theirs);
    assert!(off.iter().all(|d| *d < 1e-10), "{off:?}");
}

/// Angular velocity and acceleration in axes of the body, from a rotation vector and its rates:
/// Ω = θ̇ − a θ×θ̇ + b θ×(θ×θ̇) with a = (1 − cos φ)/φ², b = (φ − sin φ)/φ³, φ = |θ|, and its derivative.
fn rates(
    theta: &Vector3<f64>,
    theta_dot: &Vector3<f64>,
    theta_ddot: &Vector3<f64>,
) -> [Vector3<f64>; 2] {
    let phi = theta.norm();
    let (sin, cos) = phi.sin_cos();
    let (a, b) = ((1.0 - cos) / phi.powi(2), (phi - sin) / phi.powi(3));
    let along = theta.dot(theta_dot);
    let a_dot = (phi * sin - 2.0 * (1.0 - cos)) / phi.powi(4) * along;
    let b_dot = (3.0 * sin - phi * (2.0 + cos)) / phi.powi(5) * along;
    let (first, second) = (theta.cross(theta_dot), theta.cross(theta_ddot));
    [
        theta_dot - first * a + theta.cross(&first) * b,
        theta_ddot - second * a - first * a_dot
            + (theta_dot.cross(&first) + theta.cross(&second)) * b
            + theta.cross(&first) * b_dot,
    ]
}

/// Cardona & Géradin 1988: in every step the unknown is the rotation vector θ from the last rotation, in
/// whose one tangent space Newmark's formulas stand, θ̇ = Ω and θ̈ = Ω̇ where θ = 0.
#[test]
fn ul_newmark_is_newmarks_scheme_for_the_increment() {
    let (h, steps) = (1e-3, 100);
    let (beta, gamma) = (0.25, 0.5);
    let theirs = by_hand(steps, |R, [Omega, Omega_dot, rest], new| {
        let theta = (Omega + (Omega_dot * (0.5 - beta) + new * beta) * h) * h;
        let theta_dot = Omega + (Omega_dot * (1.0 - gamma) + new * gamma) * h;
        let [Omega, Omega_dot] = rates(&theta, &theta_dot, new);
        (R * Rotation3::new(theta), [Omega, Omega_dot, *rest])
    });
    let off = apart(&stepped("", "ul-newmark", h, steps), &theirs);
    assert!(off.iter().all(|d| *d < 1e-10), "{off:?}");
    let other = apart(&stepped("", "lie-newmark", h, steps), &theirs);
    assert!(other[0] > 1e-6, "{other:?}");
}
