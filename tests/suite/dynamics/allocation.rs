//! A step in time allocates nothing: all buffers are made when a run begins.

use crate::support::beams::beam;
use crate::support::dynamics::{body, heavy_body, revolute, soft, turning};
use crate::support::loops::Circle;
use crate::support::prelude::*;
use allocation_counter::measure;

/// Two bodies whose angles stay on a circle; the node of their coordinate.
fn circle(b: &mut ModelBuilder) -> NodeId {
    let ground = b.node("ground", [9.0, 0.0, 0.0]).unwrap();
    b.support(ground, &Dof::ALL);
    let map = ImplicitMap::of(Circle, 1, 0.0, [1.0, 0.0], Choice::Split).unwrap();
    let q = b.coordinates("q", &[Quantity::Angle]).unwrap();
    let angles = [Quantity::Angle; 2];
    let x = b
        .mapped_coordinates("x", &angles, Box::new(map), &[q])
        .unwrap();
    for k in 0..2 {
        let pick = Linear::<2, 1>::pick(k, 0.0).boxed();
        let angle = b.mapped_coordinates(format!("x{k}"), &angles[..1], pick, &[x]);
        let hinge = Revolute::new([0.0, 0.0, 1.0]).unwrap();
        let frame = b.add_joint_frame(format!("flap {k}"), ground, hinge, &[angle.unwrap()]);
        let body = RigidBody::new(0.5, Matrix3::identity() * 0.1, Vector3::y() * 0.1).unwrap();
        b.element(format!("flap {k}"), body, &[frame.unwrap()])
            .unwrap();
    }
    q
}

/// A driven base, two arms with a revolute joint between them, a third one on a spherical joint,
/// a body on a rigid link, and a ring on the first arm, all under gravity; two bodies whose angles
/// close a loop beside them. Where the base is not driven it is held. The ring's way, and the coordinate of the loop.
fn everything(formulation: Formulation, driven: bool) -> (Context, [NodeId; 2]) {
    let mut b = ModelBuilder::new();
    b.formulate(formulation);
    let base = b.node("base", [0.0; 3]).unwrap();
    let elbow = b.node("elbow", [2.0, 0.0, 0.0]).unwrap();
    let wrist = b.node("wrist", [4.0, 0.0, 0.0]).unwrap();
    let tip = b.node("tip", [6.0, 0.0, 0.0]).unwrap();
    let section = soft(1e3);
    let first = beam(&mut b, "first", [base, elbow], 4, section);
    let hinge = revolute(&mut b, "hinge", elbow, [0.0, 0.0, 1.0]);
    let second = beam(&mut b, "second", [hinge.frame, wrist], 4, section);
    let ball = b.spherical("ball", wrist).unwrap();
    let damping = Damping {
        mass: 0.01,
        stiffness: 1e-4,
    };
    let damped = section.with_damping(damping).unwrap();
    beam(&mut b, "third", [ball.frame, tip], 4, damped);
    let link = b.offset("link", tip, [6.0, 0.5, 0.0]).unwrap();
    let ring = b.slide("ring", &first, 0.7, Interpolation::Total).unwrap();
    for (name, node) in [("body", link), ("mass", ring.frame)] {
        let made = RigidBody::new(0.5, Matrix3::identity() * 0.1, Vector3::y() * 0.1);
        body(&mut b, name, node, made.unwrap());
    }
    for (k, nodes) in second.windows(2).enumerate() {
        let positions = [b.position(nodes[0]), b.position(nodes[1])];
        let load = LineLoad::new(&positions, [0.0, 0.0, -9.81], false, Constant(1.0));
        b.element(format!("weight {k}"), load.unwrap(), nodes)
            .unwrap();
    }
    // Weak enough for the ring to run over the ends of elements.
    let law = CoordinateLaw {
        k: 15.0,
        c: 0.2,
        ..CoordinateLaw::default()
    };
    let spring = CoordinateSpring::new(law).unwrap();
    b.element("ring spring", spring, &[ring.coordinates[0]])
        .unwrap();
    let motor = CoordinateForce::new(Constant(5.0));
    b.element("motor", motor, &[hinge.coordinates[0]]).unwrap();
    for dof in [Dof::X, Dof::Y, Dof::Z, Dof::RX, Dof::RY] {
        b.support(base, &[dof]);
    }
    // Several turns, so that driven and free rotations change charts.
    match driven {
        true => b.prescribe(base, Dof::RZ, Proportional(3.0)),
        false => b.support(base, &[Dof::RZ]),
    }
    let q = circle(&mut b);
    (Context::new(b.build().unwrap()), [ring.coordinates[0], q])
}

/// Allocations of a run of so many steps, what it did, and how often the ring came to another
/// element.
fn allocations(
    steps: usize,
    options: &DynamicOptions,
    formulation: Formulation,
) -> (u64, Summary, usize) {
    // Energy is kept where nothing is driven.
    let driven = !options.scheme.keeps_energy();
    let (mut context, [way, q]) = everything(formulation, driven);
    let n = context.pattern().dim();
    let mut v = turning(&mut context, &vec![0.0; n], Vector3::z() * 3.0);
    assert!(context.set(&mut v, q, 0, 3.0));
    let mut progress = Progress::new(start(&context, 0.0, &[], &v).unwrap());
    let way = context.unknown_at(way, 0).unwrap();
    let (mut element, mut moves) = (1.0, 0);
    let mut observer = |_: &mut Context, report: &StepReport<'_>| {
        // Elements of length 0.5, the ring started at 0.7.
        let now = ((0.7 + report.progress.state.q[way]) / 0.5).floor();
        moves += usize::from(now != element);
        element = now;
        match report.progress.summary.steps < steps {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        }
    };
    let counted = measure(|| {
        integrate(&mut context, &mut progress, options, &mut observer).unwrap();
    });
    (counted.count_total, progress.summary, moves)
}

#[test]
fn twice_as_many_steps_allocate_no_more() {
    use Formulation::{LieGroup, MixedSpins, SpatialSpins, Total, Updated, WienerMilenkovic};
    let by = |word: &str| DynamicOptions {
        scheme: word.parse().unwrap(),
        ..DynamicOptions::new(100.0, 0.005)
    };
    let plain = by("ga:0.8");
    let adaptive = DynamicOptions {
        adaptivity: Some(Adaptivity {
            tolerance: 1e-3,
            max_step: 0.01,
        }),
        ..plain
    };
    // What the first run in a process sets up is not counted.
    allocations(150, &plain, Total);
    let total = [plain, adaptive, by("bathe:0.5"), by("radau")].map(|o| (o, Total));
    let others = [
        Updated,
        LieGroup,
        SpatialSpins,
        MixedSpins,
        WienerMilenkovic,
    ]
    .map(|f| (plain, f));
    // One that finds multipliers for what the motion keeps, in every step.
    let keeping = by("projected-newmark:0.8");
    let keepers = [Total, Updated, LieGroup, WienerMilenkovic].map(|f| (keeping, f));
    for (options, formulation) in total.into_iter().chain(others).chain(keepers) {
        let (few, short, early) = allocations(150, &options, formulation);
        let (many, long, all) = allocations(300, &options, formulation);
        assert_eq!([short.steps, long.steps], [150, 300]);
        // The second half has what might allocate.
        assert!(long.chart_changes > short.chart_changes, "{long:?}");
        // On the base that is held it stays on one.
        let held = options.scheme.keeps_energy();
        assert!(all > early || held, "the ring comes to another element");
        assert!(long.energy.is_some());
        assert!(few > 0, "the counter counts");
        assert_eq!(few, many, "{short:?} {long:?}");
    }
}

#[test]
fn momenta_are_kept_without_allocations() {
    let count = |steps: usize| {
        let mut b = ModelBuilder::new();
        let node = b.node("body", [0.0; 3]).unwrap();
        heavy_body(&mut b, "body", node, 1.0, [0.1, 0.2, 0.0]);
        let mut context = Context::new(b.build().unwrap());
        let v = [0.0, 0.0, 0.0, 1.0, 2.0, 3.0];
        let mut progress = Progress::new(start(&context, 0.0, &[], &v).unwrap());
        let options = DynamicOptions {
            scheme: "projected-newmark".parse().unwrap(),
            ..DynamicOptions::new(0.005 * steps as f64, 0.005)
        };
        let go_on = &mut |_: &mut Context, _: &StepReport<'_>| ControlFlow::Continue(());
        let counted = measure(|| {
            integrate(&mut context, &mut progress, &options, go_on).unwrap();
        });
        assert_eq!(progress.invariants.unwrap().momenta.len(), 4);
        counted.count_total
    };
    count(150);
    assert_eq!(count(150), count(300));
}
