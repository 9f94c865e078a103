//! The energy-momentum projection: what it keeps, on which models, and that it stays of order two.

use crate::support::beams::beam_with;
use crate::support::dynamics::*;
use crate::support::prelude::*;
use pullback::check;
use pullback::elements::energy::EnergyElement;

#[path = "../../../examples/elements/drag.rs"]
mod drag;

const LENGTH: f64 = 1.0;
const MASS: f64 = 1.0;

fn em() -> Scheme {
    "projected-newmark".parse().unwrap()
}

/// Two nodes one length apart with a beam of four elements between them, supported by `support`.
fn model(
    stiff: f64,
    interpolation: Interpolation,
    formulation: Formulation,
    support: impl Fn(&mut ModelBuilder, [NodeId; 2]),
) -> Context {
    let mut b = ModelBuilder::new();
    let ends = [("a", 0.2), ("b", 0.2 + LENGTH)];
    let ends = ends.map(|(name, x)| b.node(name, [x, 0.1, 0.0]).unwrap());
    beam_with(&mut b, "beam", ends, 4, soft(stiff), interpolation);
    support(&mut b, ends);
    b.formulate(formulation);
    Context::new(b.build().unwrap())
}

fn weight(b: &mut ModelBuilder, ends: [NodeId; 2]) {
    let positions = ends.map(|n| b.position(n));
    let load = LineLoad::new(&positions, [0.0, 0.0, -3.0], false, Constant(1.0));
    b.element("weight", load.unwrap(), &ends).unwrap();
}

/// The velocities of a rigid motion about the middle of the beam.
fn spun(context: &mut Context) -> (Vec<f64>, RigidMotion) {
    let motion = RigidMotion {
        velocity: Vector3::new(0.5, -0.3, 0.8),
        omega: Vector3::new(0.6, -1.0, -1.2),
        about: Vector3::new(0.2 + 0.5 * LENGTH, 0.1, 0.0),
    };
    let q = vec![0.0; context.pattern().dim()];
    (moving(context, &q, &motion), motion)
}

/// The model's energy with the potential of its loads, and its momenta.
fn audit(context: &mut Context, at: Point<'_>) -> (f64, [Vector3<f64>; 2]) {
    let audit = context.energies_and_momentum(at).unwrap();
    let energy = audit.energies.kinetic + audit.energies.stored + audit.load_potential;
    (energy, [audit.momentum.linear, audit.momentum.angular])
}

/// Energy and momenta at rest in the reference configuration but for the velocities.
fn at_start(context: &mut Context, v: &[f64]) -> (f64, [Vector3<f64>; 2]) {
    let (t, q, a) = (0.0, context.initial().to_vec(), vec![0.0; v.len()]);
    let (q, a) = (&q, &a);
    audit(context, Point { t, q, v, a })
}

/// The largest differences from an energy, and from those components of momenta that a mask has, along
/// a run.
fn run(
    context: &mut Context,
    v: &[f64],
    options: &DynamicOptions,
    (energy, momenta): (f64, [Vector3<f64>; 2]),
    mask: [Vector3<f64>; 2],
) -> ([f64; 3], Progress) {
    let mut worst = [0.0_f64; 3];
    let q = context.initial().to_vec();
    let progress = observed(context, [&q, v], options, &mut |context, step| {
        let (now, both) = audit(context, point(&step.progress.state));
        worst[0] = worst[0].max((now - energy).abs());
        for k in 0..2 {
            let gap = (both[k] - momenta[k]).component_mul(&mask[k]).norm();
            worst[1 + k] = worst[1 + k].max(gap);
        }
    });
    (worst, progress)
}

fn options(scheme: Scheme, to: f64, steps: usize) -> DynamicOptions {
    DynamicOptions {
        energies: true,
        ..tight(scheme, to, to / steps as f64)
    }
}

const ALL: [Vector3<f64>; 2] = [Vector3::new(1.0, 1.0, 1.0), Vector3::new(1.0, 1.0, 1.0)];

/// Momenta of the beam in a rigid motion: those of a rod of mass m and length L with the section's
/// moments of inertia, (m L²/12 across).
fn rod(motion: &RigidMotion) -> [Vector3<f64>; 2] {
    let across = 0.1 * LENGTH + MASS * LENGTH * LENGTH / 12.0;
    let J = Matrix3::from_diagonal(&Vector3::new(0.2 * LENGTH, across, across));
    let p = motion.velocity * MASS;
    [p, motion.about.cross(&p) + J * motion.omega]
}

#[test]
fn a_flying_beam_keeps_energy_and_momenta() {
    // Soft, and so stiff that it is nearly rigid; a step is 1/200 of a turn, or so, and the rotation
    // vectors change their charts.
    for formulation in [
        Formulation::Total,
        Formulation::Updated,
        Formulation::LieGroup,
        Formulation::WienerMilenkovic,
    ] {
        for stiff in [1.0, 1e4] {
            let make = || model(stiff, Interpolation::Geodesic, formulation, |_, _| ());
            let (v, motion) = spun(&mut make());
            let momenta = rod(&motion);
            let energy = 0.5 * (momenta[0].dot(&motion.velocity))
                + 0.5 * (momenta[1] - motion.about.cross(&momenta[0])).dot(&motion.omega);
            let known = (energy, momenta);
            let go = |scheme| run(&mut make(), &v, &options(scheme, 20.0, 1000), known, ALL);
            let (kept, progress) = go(em());
            for (off, most) in kept.into_iter().zip([1e-12, 1e-12, 1e-11]) {
                assert!(off < most, "{formulation:?}, {stiff}: {kept:?}");
            }
            assert!(progress.summary.chart_changes > 20);
            let (lost, _) = go(Scheme::default());
            assert!(lost[0] > 1e-5 && lost[2] > 1e-5, "newmark: {lost:?}");
        }
    }
}

#[test]
fn it_is_of_order_two() {
    // On smooth motions: what it restores goes to the motion as a whole, wherever it was lost.
    let order = |word: &str, history_of: &dyn Fn(Scheme, usize) -> Vec<NodeState>, n: usize| {
        let exact = richardson(8 * n, &mut |n| history_of(Scheme::default(), n));
        let off = |n: usize| distances(&history_of(word.parse().unwrap(), n), &exact).to_vec();
        let errors = [n / 2, n, 2 * n].map(off);
        assert_slopes(word, &QUANTITIES, &errors, 2.0, 0.1);
    };
    for word in ["projected-newmark", "projected-newmark:0.8"] {
        let top = |scheme, n| {
            let (mut context, v) = heavy_top();
            let node = [context.find("tip").unwrap()];
            let options = options(scheme, 1.0, n);
            history(&mut context, &node, [&[0.0; 3], &v], &options, 10).0
        };
        order(word, &top, 400);
        let free = |scheme, n| {
            let mut beam = model(0.1, Interpolation::Geodesic, Formulation::Total, |_, _| ());
            let (v, _) = spun(&mut beam);
            let nodes: Vec<NodeId> = beam.frames().map(|(id, _)| id).collect();
            let q = vec![0.0; v.len()];
            history(&mut beam, &nodes, [&q, &v], &options(scheme, 1.0, n), 10).0
        };
        order(word, &free, 400);
    }
}

/// An inertia 1 + uneven cos θ about the axis of a hinge.
struct Flywheel {
    uneven: f64,
}

impl EnergyElement<1> for Flywheel {
    fn kinetic<S: Scalar>(&self, x: &SVector<S, 1>, v: &SVector<S, 1>) -> S {
        v[0] * v[0] * (x[0].cos() * self.uneven + 1.0) * 0.5
    }
}

#[test]
fn symmetries_are_found() {
    let count = |context: &mut Context| {
        let q = context.initial().to_vec();
        let v = vec![0.1; q.len()];
        context.symmetries([0.0, 10.0], &q, &v).len()
    };
    use Interpolation::{Geodesic, Total};
    let total = Formulation::Total;
    assert_eq!(count(&mut model(1.0, Geodesic, total, |_, _| ())), 6);
    // Total rotation vectors are not objective: translations alone.
    assert_eq!(count(&mut model(1.0, Total, total, |_, _| ())), 3);
    // Three translations, along the weight with its force, and turns about it.
    assert_eq!(count(&mut model(1.0, Geodesic, total, weight)), 4);
    let pin = |b: &mut ModelBuilder, ends: [NodeId; 2]| {
        b.support(ends[0], &[Dof::X, Dof::Y, Dof::Z]);
    };
    assert_eq!(count(&mut model(1.0, Geodesic, total, pin)), 3);
    let hung = |b: &mut ModelBuilder, ends: [NodeId; 2]| {
        pin(b, ends);
        weight(b, ends);
    };
    assert_eq!(count(&mut model(1.0, Geodesic, total, hung)), 1);
    // A part that turns by itself, and a free joint on it.
    let turned = |b: &mut ModelBuilder, ends: [NodeId; 2]| {
        let hinge = || Revolute::new([0.0, 0.6, 0.8]).unwrap();
        let prescribed = b.attach("prescribed", ends[1], hinge()).unwrap();
        let sine = Sine {
            amplitude: 0.8,
            omega: 3.0,
            phase: 0.0,
            offset: 0.0,
        };
        b.prescribe_coordinate(prescribed.coordinates[0], 0, sine);
        let free = b.attach("free", prescribed.frame, hinge()).unwrap();
        let J = Matrix3::from_diagonal(&Vector3::new(0.1, 0.2, 0.25));
        let body = RigidBody::new(0.6, J, Vector3::new(0.2, 0.1, 0.0)).unwrap();
        b.element("turned", body, &[free.frame]).unwrap();
    };
    assert_eq!(count(&mut model(1.0, Geodesic, total, turned)), 6);
    let mut spins = model(1.0, Geodesic, Formulation::LieGroup, hung);
    assert_eq!(count(&mut spins), 1);
    let clamped = |b: &mut ModelBuilder, ends: [NodeId; 2]| b.support(ends[0], &Dof::ALL);
    assert_eq!(count(&mut model(1.0, Geodesic, total, clamped)), 0);

    // A flywheel whose inertia depends on its angle: nothing turns it, and yet its momentum changes.
    for (uneven, symmetries) in [(0.0, 1), (0.5, 0)] {
        let (mut b, ground) = grounded();
        let hinge = revolute(&mut b, "hinge", ground, [0.0, 0.0, 1.0]);
        heavy_body(&mut b, "body", hinge.frame, 1.0, [0.1, 0.2, 0.0]);
        let wheel = Flywheel { uneven }.into_element();
        b.element("flywheel", wheel, &[hinge.coordinates[0]])
            .unwrap();
        let found = count(&mut Context::new(b.build().unwrap()));
        assert_eq!(found, symmetries, "{uneven}");
    }

    // A body on an axis through a ground that is no origin. The weight works about any axis but a vertical one.
    for (axis, symmetries) in [([0.0, 0.0, 1.0], 1), ([0.0, 1.0, 1.0], 0)] {
        let mut b = ModelBuilder::new();
        let ground = b.node("ground", [0.3, -0.2, 0.1]).unwrap();
        b.support(ground, &Dof::ALL);
        let hinge = revolute(&mut b, "hinge", ground, axis);
        heavy_body(&mut b, "body", hinge.frame, 1.0, [0.1, 0.2, 0.0]);
        let found = count(&mut Context::new(b.build().unwrap()));
        assert_eq!(found, symmetries, "{axis:?}");
    }
}

/// A heavy top of three moments of inertia, hung from a ball joint, and its velocities.
fn heavy_top() -> (Context, Vec<f64>) {
    let (mut b, ground) = grounded();
    let ball = b.spherical("ball", ground).unwrap();
    let J = Matrix3::from_diagonal(&Vector3::new(0.3, 0.25, 0.1));
    let top = RigidBody::new(1.0, J, [0.0, 0.1, 0.4].into()).unwrap();
    body(&mut b, "top", ball.frame, top);
    b.offset("tip", ball.frame, [0.0, 0.0, 1.0]).unwrap();
    let mut context = Context::new(b.build().unwrap());
    let v = turning(&mut context, &[0.0; 3], Vector3::new(0.5, 0.2, 9.0));
    (context, v)
}

#[test]
fn a_heavy_top_keeps_energy_and_vertical_momentum() {
    let go = |scheme: &str| {
        let (mut context, v) = heavy_top();
        let start = at_start(&mut context, &v);
        let mask = [Vector3::zeros(), Vector3::z()];
        let scheme = scheme.parse().unwrap();
        run(&mut context, &v, &options(scheme, 20.0, 4000), start, mask)
    };
    let (kept, progress) = go("projected-newmark");
    assert_eq!(progress.invariants.unwrap().momenta.len(), 1);
    assert!(progress.summary.chart_changes > 10);
    assert!(kept[0] < 1e-13 && kept[2] < 1e-13, "{kept:?}");
    let (lost, _) = go("newmark");
    assert!(lost[0] > 1e-4 && lost[2] > 1e-4, "{lost:?}");
}

#[test]
fn constant_loads_change_momentum_by_their_impulse() {
    let push = |b: &mut ModelBuilder, ends: [NodeId; 2]| {
        weight(b, ends);
        for (end, force) in ends.into_iter().zip([[0.6, 0.1, 0.3], [-0.4, 0.2, -0.1]]) {
            let load = NodalLoad::new(LoadKind::DeadForce, force, Constant(1.0));
            b.element("push", load, &[end]).unwrap();
        }
    };
    let beam = model(1.0, Interpolation::Geodesic, Formulation::Total, push);
    // The weight of a body acts beside its node, and turns it.
    let mut b = ModelBuilder::new();
    let node = b.node("body", [0.7, 0.1, 0.0]).unwrap();
    heavy_body(&mut b, "body", node, 0.5, [0.0, 0.2, 0.4]);
    let beam_force = Vector3::new(0.2, 0.3, 0.2 - 3.0 * LENGTH);
    let body_force = Vector3::new(0.0, 0.0, -0.5 * 9.81);
    let body = Context::new(b.build().unwrap());
    for (mut context, force) in [(beam, beam_force), (body, body_force)] {
        let (v, _) = spun(&mut context);
        let (start, [p, _]) = at_start(&mut context, &v);
        let mut worst = [0.0_f64; 2];
        let q = vec![0.0; v.len()];
        let options = options(em(), 10.0, 500);
        observed(&mut context, [&q, &v], &options, &mut |context, step| {
            let s = &step.progress.state;
            let (energy, [now, _]) = audit(context, point(s));
            let off = [energy - start, (now - p - force * s.t).norm()];
            worst = std::array::from_fn(|k| worst[k].max(off[k].abs()));
        });
        assert!(worst[0] < 1e-10 && worst[1] < 1e-11, "{worst:?}");
    }
}

#[test]
fn a_swinging_cantilever_keeps_energy() {
    // From rest, under its weight: it comes to rest again now and then, where velocities cannot mend
    // an energy.
    for interpolation in [Interpolation::Geodesic, Interpolation::Total] {
        let support = |b: &mut ModelBuilder, ends: [NodeId; 2]| {
            b.support(ends[0], &Dof::ALL);
            weight(b, ends);
        };
        let go = |scheme: &str| {
            let mut beam = model(1.0, interpolation, Formulation::Total, support);
            let v = vec![0.0; beam.pattern().dim()];
            let start = (0.0, [Vector3::zeros(); 2]);
            let scheme = scheme.parse().unwrap();
            run(&mut beam, &v, &options(scheme, 30.0, 3000), start, start.1)
        };
        for word in ["projected-newmark", "projected-newmark:0.8"] {
            let (kept, progress) = go(word);
            assert!(progress.invariants.unwrap().momenta.is_empty());
            assert!(kept[0] < 1e-13, "{word}: {kept:?}");
        }
        assert!(go("newmark").0[0] > 1e-5 && go("ga:0.8").0[0] > 1e-4);
    }
}

#[test]
fn what_a_load_has_left_is_kept() {
    // A force at one end until 0.5 s, then nothing.
    let push = |b: &mut ModelBuilder, ends: [NodeId; 2]| {
        let pulse = Pulse::new(0.0, 0.5, 1.0).unwrap();
        let load = NodalLoad::new(LoadKind::DeadForce, [3.0, 0.0, 1.0], pulse);
        b.element("push", load, &[ends[1]]).unwrap();
    };
    let mut beam = model(1.0, Interpolation::Geodesic, Formulation::Total, push);
    let v = vec![0.0; beam.pattern().dim()];
    let mut left = None;
    let mut worst = [0.0_f64; 3];
    let q = v.clone();
    let options = options(em(), 4.0, 800);
    let run = observed(&mut beam, [&q, &v], &options, &mut |model, step| {
        let s = &step.progress.state;
        let kept = &step.progress.invariants.as_ref().unwrap().momenta;
        let (energy, [p, L]) = audit(model, point(s));
        if s.t < 0.499 {
            // Translations across the force, and turns about an axis along it.
            assert_eq!(kept.len(), 3, "{kept:?}");
            return;
        }
        assert_eq!(kept.len(), 6);
        let (first, p_first, L_first) = *left.get_or_insert((energy, p, L));
        let off = [energy - first, (p - p_first).norm(), (L - L_first).norm()];
        worst = std::array::from_fn(|k| worst[k].max(off[k].abs()));
    });
    assert!(run.summary.finished);
    let (_, p, L) = left.unwrap();
    // The impulse to the order of the scheme.
    assert!((p - Vector3::new(1.5, 0.0, 0.5)).norm() < 1e-3, "{p}");
    assert!(L.norm() > 0.1, "{L}");
    assert!(worst.iter().all(|w| *w < 1e-11), "{worst:?}");
}

/// A force in a time of 6 ms about 0.8 s, of impulse 1.
#[derive(Debug)]
struct LateBlow;

impl TimeFunction for LateBlow {
    fn at(&self, t: f64, _: &[f64]) -> [f64; 3] {
        let width = 0.0015;
        let z = (t - 0.8) / width;
        let f = (-0.5 * z * z).exp() / (width * TAU.sqrt());
        [f, -f * z / width, f * (z * z - 1.0) / (width * width)]
    }
}

#[test]
fn a_momentum_ends_when_a_load_works_along_it() {
    // Nothing works at the start, at rest or in any state about it.
    let body = |load: &dyn Fn(&mut ModelBuilder, NodeId), v: f64| {
        let mut b = ModelBuilder::new();
        let node = b.node("body", [0.0; 3]).unwrap();
        let body = RigidBody::new(2.0, Matrix3::identity(), Vector3::zeros()).unwrap();
        b.element("body", body, &[node]).unwrap();
        load(&mut b, node);
        let mut context = Context::new(b.build().unwrap());
        let options = options(em(), 2.0, 4000);
        let run = observed(
            &mut context,
            [&[0.0; 6], &[v, 0.0, 0.0, 0.0, 0.0, 0.0]],
            &options,
            &mut |_, _| (),
        );
        (run.state.v[0], run.invariants.unwrap().momenta.len())
    };
    let drag = |b: &mut ModelBuilder, node| {
        let (direction, speed) = (Vector3::x(), Constant(0.0).into());
        let still = drag::Drag {
            c: 0.5,
            direction,
            speed,
        };
        b.element("drag", still, &[node]).unwrap();
    };
    // m v̇ = −c v²: v = v₀ / (1 + c v₀ t / m). A force along e1 through the origin works along that motion alone.
    let (v, kept) = body(&drag, 3.0);
    assert!((v - 1.2).abs() < 1e-6 && kept == 5, "{v}, {kept}");
    let blow = |b: &mut ModelBuilder, node| {
        let load = NodalLoad::new(LoadKind::DeadForce, [4.0, 0.0, 0.0], LateBlow);
        b.element("blow", load, &[node]).unwrap();
    };
    let (v, kept) = body(&blow, 1.0);
    assert!((v - 3.0).abs() < 1e-6 && kept == 5, "{v}, {kept}");
}

#[test]
fn drag_in_a_wind_is_that_of_its_page() {
    // From rest in a wind w: u = w − v, m u̇ = −c u², so v = w − w / (1 + c w t / m).
    let speed = Box::new(Proportional(2.0));
    check::element(&drag::Drag {
        c: 0.3,
        direction: Vector3::new(0.6, 0.0, 0.8),
        speed,
    })
    .assert();
    let mut b = ModelBuilder::new();
    let node = b.node("body", [0.0; 3]).unwrap();
    let body = RigidBody::new(2.0, Matrix3::identity(), Vector3::zeros()).unwrap();
    b.element("body", body, &[node]).unwrap();
    let wind = b.input(4.0);
    let made = drag::Drag {
        c: 0.5,
        direction: Vector3::y(),
        speed: wind.into(),
    };
    b.element("wind", made, &[node]).unwrap();
    let mut context = Context::new(b.build().unwrap());
    let options = options(Scheme::default(), 2.0, 2000);
    let rest = [0.0; 6];
    let run = observed(&mut context, [&rest, &rest], &options, &mut |_, _| ());
    let exact = 4.0 - 4.0 / (1.0 + 0.5 * 4.0 * 2.0 / 2.0);
    assert!((run.state.v[1] - exact).abs() < 1e-6, "{:?}", run.state.v);
}
