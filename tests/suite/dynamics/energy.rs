//! Energy and momentum along motions: power balances, conservation, numerical and physical damping.

#![allow(non_snake_case, clippy::unwrap_used)]

use crate::support::beams;
use crate::support::dynamics::*;
use nalgebra::{Matrix3, Vector3};
use pullback::elements::beam::{Damping, Interpolation, Section};
use pullback::elements::load::LineLoad;
use pullback::elements::model::{Context, Dof, ModelBuilder, NodeId, RigidMotion};
use pullback::elements::spring::{CoordinateLaw, CoordinateSpring};
use pullback::elements::time::Constant;
use pullback::integrators::dynamics::{DynamicOptions, EnergyBalance, Scheme};
use pullback::manifold::system::{Point, System};
use std::f64::consts::{PI, TAU};

/// A line of beam elements along e1 between two nodes that exist.
fn beam(b: &mut ModelBuilder, ends: [NodeId; 2], elements: usize, section: Section) -> Vec<NodeId> {
    beam_with(b, ends, elements, section, Interpolation::Total)
}

fn beam_with(
    b: &mut ModelBuilder,
    ends: [NodeId; 2],
    elements: usize,
    section: Section,
    interpolation: Interpolation,
) -> Vec<NodeId> {
    let nodes = beams::beam_with(b, "beam", ends, elements, section, interpolation);
    for (k, pair) in nodes.windows(2).enumerate() {
        let positions = [b.position(pair[0]), b.position(pair[1])];
        let force = [0.0, 0.0, -9.81 * section.inertia.mass];
        if force[2] != 0.0 && b.position(ends[0]).norm() > 0.0 {
            let weight = LineLoad::new(&positions, force, false, Constant(1.0)).unwrap();
            b.element(format!("weight {k}"), weight, pair).unwrap();
        }
    }
    nodes
}

/// A section of which no vibration is too fast to be resolved.
fn soft() -> Section {
    let J = Matrix3::from_diagonal(&Vector3::new(0.2, 0.1, 0.1));
    Section::diagonal(60.0, [30.0; 2], 4.0, [4.0, 6.0])
        .unwrap()
        .with_mass(1.0, J)
}

/// Energies at the end of a run.
fn balance(context: &mut Context, v: &[f64], scheme: Scheme, to: f64, n: usize) -> EnergyBalance {
    let options = DynamicOptions {
        energies: true,
        ..tight(scheme, to, to / n as f64)
    };
    let progress = observed(context, [&[], v], &options, &mut |_, _| ());
    progress.summary.energy.unwrap()
}

#[test]
fn the_power_balance_closes_to_the_order_of_the_scheme() {
    for scheme in second_order() {
        let mut supplied = 0.0;
        let defects = [200, 400, 800].map(|n| {
            // A driven shaft carries an arm; on it a damped hinge; on that a flexible beam.
            let (mut b, ground) = grounded();
            let shaft = revolute(&mut b, "shaft", ground, [0.3, 0.2, 1.0]);
            b.prescribe_coordinate(shaft.coordinates[0], 0, sine(1.5, 2.0, 0.0));
            let arm = b.offset("arm", shaft.frame, [0.4, 0.0, 0.0]).unwrap();
            heavy_body(&mut b, "hub", arm, 1.0, [0.1, 0.2, 0.0]);
            let hinge = revolute(&mut b, "hinge", arm, [0.0, 1.0, 0.0]);
            let law = CoordinateLaw {
                k: 5.0,
                k3: 2.0,
                c: 0.8,
                x0: -0.2,
            };
            let damper = CoordinateSpring::new(law).unwrap();
            b.element("damper", damper, &[hinge.coordinates[0]])
                .unwrap();
            let tip = b.node("tip", [1.2, 0.0, 0.0]).unwrap();
            let damping = Damping {
                mass: 0.1,
                stiffness: 0.01,
            };
            beam(
                &mut b,
                [hinge.frame, tip],
                2,
                soft().with_damping(damping).unwrap(),
            );
            let mut context = Context::new(b.build().unwrap());
            let mut v = vec![0.0; context.pattern().dim()];
            context.set(&mut v, hinge.coordinates[0], 0, 0.5);
            // The beam begins to move with the shaft, which turns at 3 rad/s.
            let motion = RigidMotion {
                omega: Vector3::new(0.3, 0.2, 1.0).normalize() * 3.0,
                ..RigidMotion::default()
            };
            context.set_velocity(&vec![0.0; v.len()], &mut v, None, &motion);
            let energy = balance(&mut context, &v, scheme, 1.0, n);
            supplied = energy.work;
            energy.largest_defect
        });
        assert!(supplied.abs() > 0.5, "the drive is to do something");
        for slope in slopes(&defects) {
            assert!((slope - 2.0).abs() < 0.1, "{}: {defects:?}", scheme.name);
        }
    }
}

/// A free beam that spins and flies.
fn free_beam(interpolation: Interpolation) -> (Context, Vec<f64>) {
    let mut b = ModelBuilder::new();
    let ends = [[0.0; 3], [1.0, 0.0, 0.0]];
    let ends = [b.node("a", ends[0]).unwrap(), b.node("b", ends[1]).unwrap()];
    beam_with(&mut b, ends, 2, soft(), interpolation);
    let mut context = Context::new(b.build().unwrap());
    let mut v = vec![0.0; context.pattern().dim()];
    let motion = RigidMotion {
        velocity: Vector3::new(0.5, -0.3, 0.8),
        omega: Vector3::new(0.6, -1.0, -1.2),
        about: Vector3::new(0.5, 0.0, 0.0),
    };
    context.set_velocity(&vec![0.0; v.len()], &mut v, None, &motion);
    (context, v)
}

#[test]
fn a_free_beam_under_the_trapezoidal_rule() {
    free_beam_conserves(Interpolation::Total);
}

#[test]
fn a_free_geodesic_beam_under_the_trapezoidal_rule() {
    free_beam_conserves(Interpolation::Geodesic);
}

fn free_beam_conserves(interpolation: Interpolation) {
    let to = 1.5;
    let mut linear = 0.0_f64;
    let errors = [200, 400, 800].map(|n| {
        let (mut context, v) = free_beam(interpolation);
        let q = vec![0.0; v.len()];
        let start = Point {
            t: 0.0,
            q: &q,
            v: &v,
            a: &q,
        };
        let first = context.energies_and_momentum(start).unwrap();
        assert!(first.momentum.linear.norm() > 0.9 && first.momentum.angular.norm() > 0.3);
        let energy = first.energies.kinetic;
        let mut largest = [0.0_f64; 2];
        let mut stored = 0.0_f64;
        let options = tight(Scheme::default(), to, to / n as f64);
        let progress = observed(&mut context, [&q, &v], &options, &mut |context, step| {
            let at = point(&step.progress.state);
            let now = context.energies_and_momentum(at).unwrap();
            let total = now.energies.kinetic + now.energies.stored;
            stored = stored.max(now.energies.stored);
            largest[0] = largest[0].max((total - energy).abs());
            let spin = now.momentum.angular - first.momentum.angular;
            largest[1] = largest[1].max(spin.norm());
            let gap = now.momentum.linear - first.momentum.linear;
            linear = linear.max(gap.norm());
        });
        assert_eq!(progress.summary.chart_changes, 0);
        assert!(stored > 1e-3, "it is to be strained: {stored}");
        largest.to_vec()
    });
    // The sum of the forces on nodes is linear in the accelerations: exact but for what Newton's
    // method leaves, summed over the steps.
    assert!(linear < 1e-10, "{linear:e}");
    assert_slopes(
        "free beam",
        &["energy", "angular momentum"],
        &errors,
        2.0,
        0.1,
    );
}

/// Kinetic and stored energy after each step, over that of the start, of a bar that vibrates along
/// itself: a linear problem. The velocity at the start is `v` along the bar.
fn bar(scheme: Scheme, elements: usize, [h, to]: [f64; 2], v: &dyn Fn(f64) -> f64) -> Vec<f64> {
    let mut b = ModelBuilder::new();
    let ends = [[0.0; 3], [1.0, 0.0, 0.0]];
    let ends = [b.node("a", ends[0]).unwrap(), b.node("b", ends[1]).unwrap()];
    let stiff = Section::diagonal(1e6, [1e6; 2], 1e4, [1e4; 2]).unwrap();
    let nodes = beam(
        &mut b,
        ends,
        elements,
        stiff.with_mass(1.0, Matrix3::identity()),
    );
    b.support(ends[0], &Dof::ALL);
    for &node in &nodes[1..] {
        b.support(node, &[Dof::Y, Dof::Z, Dof::RX, Dof::RY, Dof::RZ]);
    }
    let mut context = Context::new(b.build().unwrap());
    let mut rates = vec![0.0; context.pattern().dim()];
    for &node in &nodes[1..] {
        let x = context.node(node).position().x;
        context.set(&mut rates, node, 0, v(x));
    }
    let mut options = DynamicOptions {
        energies: true,
        ..tight(scheme, to, h)
    };
    // Forces die away, and are to be balanced all the same.
    options.newton.absolute = f64::MIN_POSITIVE;
    let mut energies = vec![1.0];
    observed(&mut context, [&[], &rates], &options, &mut |_, step| {
        let energy = step.progress.summary.energy.unwrap();
        energies.push((energy.now.kinetic + energy.now.stored) / energy.start);
    });
    energies
}

#[test]
fn schemes_with_damping_lose_energy_in_stiff_vibrations() {
    // Steps of a third of the first period, several periods of the others.
    let h = 0.3 * TAU / (0.5 * PI * 1e3);
    let shape = |x: f64| (0.5 * PI * x).sin() + 0.3 * (3.5 * PI * x).sin();
    let run = |scheme| bar(scheme, 6, [h, 60.0 * h], &shape);
    for e in run(Scheme::default()) {
        assert!(
            (e - 1.0).abs() < 1e-10,
            "the trapezoidal rule keeps it: {e}"
        );
    }
    for scheme in [
        Scheme::wbz(0.5).unwrap(),
        Scheme::chung_hulbert(0.5).unwrap(),
    ] {
        let energies = run(scheme);
        for e in energies.windows(2) {
            assert!(e[1] < e[0], "{}: {energies:?}", scheme.name);
        }
    }
    // HHT loses energy too, but not in every single step: its decreasing norm is another one than
    // the energy, and that swings within a vibration.
    let energies = run(Scheme::hht(-0.1).unwrap());
    for e in energies.windows(9) {
        assert!(e[8] < e[0], "{energies:?}");
    }
}

#[test]
fn the_energy_of_one_vibration_falls_with_the_spectral_radius() {
    // One element: ω² = (EA/l) / (Aρ l/3) = 3e6. At ωh = 10 the spectral radii are those of the
    // characteristic polynomials (computed from them apart from this library).
    let omega = 3e6_f64.sqrt();
    for (scheme, radius) in [
        (Scheme::default(), 1.0),
        (Scheme::chung_hulbert(0.8).unwrap(), 0.929_791_767_2_f64),
        (Scheme::chung_hulbert(0.5).unwrap(), 0.682_528_421_5),
        (Scheme::wbz(0.5).unwrap(), 0.555_288_206_9),
        (Scheme::hht(-1.0 / 9.0).unwrap(), 0.822_713_106_1),
    ] {
        let h = 10.0 / omega;
        let energies = bar(scheme, 1, [h, 100.0 * h], &|x| 1e20 * x);
        // The vibration begins so large that it does not reach the round-off of lengths of one. From the least squares line through log E: energies swing about it.
        let n = energies.len() as f64;
        let (mut above, mut below) = (0.0, 0.0);
        for (k, e) in energies.iter().enumerate() {
            let x = k as f64 - 0.5 * (n - 1.0);
            above += x * e.ln();
            below += x * x;
        }
        let found = (0.5 * above / below).exp();
        assert!(
            (found / radius - 1.0).abs() < 1e-3,
            "{}: {found} for {radius}",
            scheme.name
        );
    }
}

/// Logarithmic decrement and angular frequency of a cantilever in its first bending mode.
fn cantilever(damping: Damping) -> [f64; 2] {
    // Slender: EI = 1, Aρ = 1, L = 1, shear and rotary inertia of no account.
    let mut b = ModelBuilder::new();
    let ends = [
        b.node("root", [0.0; 3]).unwrap(),
        b.node("tip", [1.0, 0.0, 0.0]).unwrap(),
    ];
    let section = Section::diagonal(1e5, [1e5; 2], 1.0, [1.0; 2])
        .unwrap()
        .with_mass(1.0, Matrix3::identity() * 1e-6)
        .with_damping(damping)
        .unwrap();
    let nodes = beam(&mut b, ends, 12, section);
    b.support(ends[0], &Dof::ALL);
    let mut context = Context::new(b.build().unwrap());
    let mut q = vec![0.0; context.pattern().dim()];
    // Euler–Bernoulli: w = cosh κx − cos κx − σ (sinh κx − sin κx), cos κ cosh κ = −1.
    let kappa: f64 = 1.875_104_068_711_961;
    let sigma = (kappa.sinh() - kappa.sin()) / (kappa.cosh() + kappa.cos());
    for &node in &nodes[1..] {
        let x = kappa * context.node(node).position().x;
        let w = x.cosh() - x.cos() - sigma * (x.sinh() - x.sin());
        let slope = kappa * (x.sinh() + x.sin() - sigma * (x.cosh() - x.cos()));
        context.set(&mut q, node, Dof::Z.index(), 5e-4 * w);
        context.set(&mut q, node, Dof::RY.index(), -5e-4 * slope);
    }
    let omega = kappa * kappa;
    let h = TAU / omega / 200.0;
    let mut tips = Vec::new();
    let options = tight(Scheme::default(), 1220.0 * h, h);
    observed(&mut context, [&q, &[]], &options, &mut |context, _| {
        tips.push(context.node_state(ends[1]).d.z);
    });
    let mut maxima = Vec::new();
    for (k, w) in tips.windows(3).enumerate() {
        if w[1] > w[0] && w[1] >= w[2] {
            // Of the parabola through three points.
            let (slope, curve) = (0.5 * (w[2] - w[0]), w[2] - 2.0 * w[1] + w[0]);
            let shift = -slope / curve;
            maxima.push(((k + 2) as f64 + shift, w[1] + 0.5 * slope * shift));
        }
    }
    assert_eq!(maxima.len(), 6, "{maxima:?}");
    let (first, last) = (maxima[0], maxima[5]);
    let decrement = (first.1 / last.1).ln() / 5.0;
    let damped = TAU / ((last.0 - first.0) * h / 5.0);
    [decrement, damped]
}

#[test]
fn the_decrement_of_a_damped_cantilever() {
    let omega = 1.875_104_068_711_961_f64.powi(2);
    for [mass, stiffness] in [[0.2, 0.0], [0.0, 0.016], [0.1, 0.008]] {
        let zeta = 0.5 * (mass / omega + stiffness * omega);
        let root = (1.0 - zeta * zeta).sqrt();
        let exact = [TAU * zeta / root, omega * root];
        let found = cantilever(Damping { mass, stiffness });
        for k in 0..2 {
            // 12 elements: (κ/12)²/12 = 2e-3 in stiffness.
            assert!(
                (found[k] / exact[k] - 1.0).abs() < 2e-3,
                "{found:?} {exact:?}"
            );
        }
    }
}
