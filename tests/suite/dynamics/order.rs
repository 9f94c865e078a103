//! Order of convergence of every scheme on constrained, driven motions that change charts.

use crate::support::beams::beam_with;
use crate::support::dynamics::*;
use crate::support::prelude::*;

/// A model, the nodes whose motion is compared, and its velocities in the reference configuration.
struct Problem {
    context: Context,
    probes: [NodeId; 2],
    v: Vec<f64>,
}

impl Problem {
    /// The spatial history in n steps, and how many charts changed.
    fn run(mut self, scheme: Scheme, to: f64, n: usize) -> (Vec<NodeState>, usize) {
        let options = tight(scheme, to, to / n as f64);
        let start = [&[][..], &self.v];
        let (states, progress) = history(&mut self.context, &self.probes, start, &options, 8);
        (states, progress.summary.chart_changes)
    }
}

/// A carriage driven along e1 and about it, by these amplitudes.
fn carriage(b: &mut ModelBuilder, along: f64, about: f64) -> NodeId {
    let carriage = b.node("carriage", [0.0; 3]).unwrap();
    b.support(carriage, &[Dof::Y, Dof::Z, Dof::RY, Dof::RZ]);
    b.prescribe(carriage, Dof::X, sine(along, 3.0, 0.2));
    b.prescribe(carriage, Dof::RX, sine(about, 2.0, 0.5));
    carriage
}

/// A carriage driven along e1 and about it; a body on a revolute joint; at its arm, by a spherical
/// joint, a second body that spins.
fn two_bodies() -> Problem {
    let mut b = ModelBuilder::new();
    let carriage = carriage(&mut b, 0.3, 0.4);
    let hinge = revolute(&mut b, "hinge", carriage, [0.2, -0.3, 1.0]);
    let arm = b.offset("arm", hinge.frame, [1.0, 0.2, 0.1]).unwrap();
    heavy_body(&mut b, "first", hinge.frame, 2.0, [0.5, 0.1, 0.0]);
    let ball = b.spherical("ball", arm).unwrap();
    heavy_body(&mut b, "second", ball.frame, 1.0, [0.2, 0.1, -0.3]);
    let probe = b.offset("probe", ball.frame, [1.3, 0.6, -0.3]).unwrap();
    b.element("fly", PointMass::new(0.1).unwrap(), &[probe])
        .unwrap();
    let context = Context::new(b.build().unwrap());
    let mut v = vec![0.0; context.pattern().dim()];
    context.set(&mut v, hinge.coordinates[0], 0, 3.0);
    for (k, rate) in [1.0, 7.0, 2.0].into_iter().enumerate() {
        context.set(&mut v, ball.coordinates[0], k, rate);
    }
    Problem {
        context,
        probes: [arm, probe],
        v,
    }
}

/// A flexible beam of two geodesic elements on the arm of a revolute joint whose carriage is driven.
fn swung_beam() -> Problem {
    let mut b = ModelBuilder::new();
    let carriage = carriage(&mut b, 0.2, 0.3);
    let hinge = revolute(&mut b, "hinge", carriage, [0.0, 0.0, 1.0]);
    let arm = b.offset("arm", hinge.frame, [0.3, 0.0, 0.0]).unwrap();
    let tip = b.node("tip", [1.3, 0.0, 0.0]).unwrap();
    let ends = [arm, tip];
    beam_with(&mut b, "beam", ends, 2, soft(1.0), Interpolation::Geodesic);
    let mut context = Context::new(b.build().unwrap());
    let (q, omega) = (vec![0.0; context.pattern().dim()], 5.0);
    let mut v = turning(&mut context, &q, Vector3::z() * omega);
    context.set(&mut v, hinge.coordinates[0], 0, omega);
    Problem {
        context,
        probes: [arm, tip],
        v,
    }
}

/// Runs of a problem by a scheme in a number of steps.
type Run<'a> = &'a dyn Fn(Scheme, usize) -> Vec<NodeState>;

/// A solution to compare with.
fn reference(run: Run<'_>) -> Vec<NodeState> {
    richardson(1280, &mut |n| run(Scheme::default(), n))
}

/// A scheme has its order on a problem, in n, 2n and 4n steps.
fn assert_order_of(scheme: Scheme, run: Run<'_>, reference: &[NodeState], n: usize) {
    let errors = [n, 2 * n, 4 * n].map(|n| distances(&run(scheme, n), reference).to_vec());
    let order = scheme.order() as f64;
    let within = if order > 2.0 { 0.15 } else { 0.1 };
    assert_slopes(scheme.name, &QUANTITIES, &errors, order, within);
}

#[test]
fn bodies_on_joints_of_a_driven_carriage() {
    let run = |scheme, n| {
        let (states, changes) = two_bodies().run(scheme, 1.6, n);
        // The second body turns by more than a whole turn.
        assert!(changes >= 2, "{changes} changes");
        states
    };
    let reference = reference(&run);
    for scheme in second_order() {
        assert_order_of(scheme, &run, &reference, 160);
    }
    for (word, n) in [
        ("central-difference", 160),
        ("projected-newmark", 160),
        ("projected-newmark:0.8", 160),
        ("radau", 80),
        ("newmark:0.3025:0.6", 320),
    ] {
        assert_order_of(word.parse().unwrap(), &run, &reference, n);
    }
}

#[test]
fn a_geodesic_beam_swung_in_space_across_changes_of_chart() {
    let run = |scheme, n| {
        let (states, changes) = swung_beam().run(scheme, 1.0, n);
        assert_eq!(changes, 3);
        states
    };
    let reference = reference(&run);
    for scheme in second_order() {
        assert_order_of(scheme, &run, &reference, 320);
    }
}

/// A mass with the velocity 1 on a damper comes to rest at m/c, as m v + c q does not change: schemes keep that to rounding, if
/// they begin with the acceleration of the damper. Where its base is jerked instead, it lags behind by as much.
#[test]
fn a_damper_stops_a_mass_in_less_than_a_step() {
    for word in ["newmark", "projected-newmark", "bathe", "radau"] {
        for (c, jerked) in [150.0, 250.0, 900.0]
            .map(|c| [(c, false), (c, true)])
            .concat()
        {
            let mut b = ModelBuilder::new();
            let base = b.node("base", [0.0; 3]).unwrap();
            match jerked {
                true => b.prescribe(
                    base,
                    Dof::X,
                    Table::new(vec![[0.0, 0.0], [2.0, 2.0]]).unwrap(),
                ),
                false => b.support(base, &[Dof::X]),
            }
            b.support(base, &[Dof::Y, Dof::Z, Dof::RX, Dof::RY, Dof::RZ]);
            let slide = Prismatic::new([1.0, 0.0, 0.0]).unwrap();
            let slide = b.attach("slide", base, slide).unwrap();
            b.element("mass", PointMass::new(1.0).unwrap(), &[slide.frame])
                .unwrap();
            let law = CoordinateLaw {
                c,
                ..CoordinateLaw::default()
            };
            let damper = CoordinateSpring::new(law).unwrap();
            b.element("damper", damper, &slide.coordinates).unwrap();
            let mut context = Context::new(b.build().unwrap());
            let options = DynamicOptions {
                scheme: word.parse().unwrap(),
                ..DynamicOptions::new(1.0, 0.01)
            };
            let [v, exact] = if jerked { [0.0, -1.0] } else { [1.0, 1.0] };
            let run = observed(&mut context, [&[0.0], &[v]], &options, &mut |_, _| ());
            let [q, v] = [run.state.q[0], run.state.v[0]];
            assert!((c * q - exact).abs() < 1e-12, "{word} {c}: {q}");
            assert!(v.abs() < 1e-9, "{word} {c}: {v}");
        }
    }
}
