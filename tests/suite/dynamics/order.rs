//! Order of convergence of every scheme on constrained, driven motions that change charts.

use crate::support::beams::beam_with;
use crate::support::dynamics::*;
use crate::support::prelude::*;
use pullback::manifold::sparse::BlockPattern;

/// A model, the nodes whose motion is compared, and its start; without coordinates from the reference configuration.
struct Problem {
    context: Context,
    probes: Vec<NodeId>,
    q: Vec<f64>,
    v: Vec<f64>,
}

impl Problem {
    /// The spatial history in n steps, and how many charts changed.
    fn run(mut self, scheme: Scheme, to: f64, n: usize) -> (Vec<NodeState>, usize) {
        let options = tight(scheme, to, to / n as f64);
        let start = [&self.q[..], &self.v];
        let (states, progress) = history(&mut self.context, &self.probes, start, &options, 8);
        (states, progress.summary.chart_changes)
    }

    /// The same where the charts of its first elements change after one step, and no others ever.
    fn changed(self, scheme: Scheme, to: f64, n: usize, change: [usize; 2]) -> Vec<NodeState> {
        let mut system = Flipped {
            context: self.context,
            change,
            steps: 0,
        };
        let options = tight(scheme, to, to / n as f64);
        history(&mut system, &self.probes, [&self.q, &self.v], &options, 8).0
    }

    /// The same in one chart.
    fn unchanged(self, scheme: Scheme, to: f64, n: usize) -> Vec<NodeState> {
        self.changed(scheme, to, n, [usize::MAX, 0])
    }
}

/// A model whose changes of chart are made here and not by itself.
struct Flipped {
    context: Context,
    /// The step after which charts change, and how many elements change theirs: the first ones.
    change: [usize; 2],
    /// Steps so far, and one.
    steps: usize,
}

impl System for Flipped {
    fn pattern(&self) -> &BlockPattern {
        self.context.pattern()
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        let previous = None;
        self.context.evaluate(at, Evaluation { previous, ..out })
    }

    fn name(&self, i: usize) -> String {
        self.context.name(i)
    }

    fn scales(&self) -> Scales {
        self.context.scales()
    }

    fn charts(&mut self) -> Option<&mut dyn Charts> {
        Some(self)
    }
}

impl Charts for Flipped {
    fn change_charts(
        &mut self,
        _: f64,
        _: &mut [f64],
        _: &mut [f64],
        _: &mut [&mut [f64]],
    ) -> ChartChanges {
        let [after, elements] = self.change;
        if self.steps == after {
            let mut state = self.context.save();
            let charts = &mut state.element_charts[..elements];
            charts.iter_mut().for_each(|c| *c ^= 0b11);
            assert!(self.context.restore(&state));
        }
        // The first call is that before the first step.
        self.steps += 1;
        ChartChanges::default()
    }
}

impl Modelled for Flipped {
    fn model(&mut self) -> &mut Context {
        &mut self.context
    }
}

/// A carriage driven along e1 and about it; a body on a revolute joint; at its arm, by a spherical
/// joint, a second body that spins.
fn two_bodies(spin: [f64; 3]) -> Problem {
    let mut b = ModelBuilder::new();
    let carriage = b.node("carriage", [0.0; 3]).unwrap();
    b.support(carriage, &[Dof::Y, Dof::Z, Dof::RY, Dof::RZ]);
    b.prescribe(carriage, Dof::X, sine(0.3, 3.0, 0.2));
    b.prescribe(carriage, Dof::RX, sine(0.4, 2.0, 0.5));
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
    for (k, rate) in spin.into_iter().enumerate() {
        context.set(&mut v, ball.coordinates[0], k, rate);
    }
    Problem {
        context,
        probes: vec![arm, probe],
        q: Vec::new(),
        v,
    }
}

/// A flexible beam on the arm of a revolute joint whose carriage is driven. With a `tilt` the
/// motion is spatial.
fn swung_beam(elements: usize, tilt: f64) -> Problem {
    swung_beam_with(elements, tilt, Interpolation::Total)
}

fn swung_beam_with(elements: usize, tilt: f64, interpolation: Interpolation) -> Problem {
    let mut b = ModelBuilder::new();
    let carriage = b.node("carriage", [0.0; 3]).unwrap();
    b.support(carriage, &[Dof::Y, Dof::Z, Dof::RY, Dof::RZ]);
    b.prescribe(carriage, Dof::X, sine(0.2, 3.0, 0.2));
    b.prescribe(carriage, Dof::RX, sine(tilt, 2.0, 0.5));
    let hinge = revolute(&mut b, "hinge", carriage, [0.0, 0.0, 1.0]);
    let arm = b.offset("arm", hinge.frame, [0.3, 0.0, 0.0]).unwrap();
    let tip = b.node("tip", [1.3, 0.0, 0.0]).unwrap();
    let ends = [arm, tip];
    beam_with(&mut b, "beam", ends, elements, soft(1.0), interpolation);
    let mut context = Context::new(b.build().unwrap());
    let (q, omega) = (vec![0.0; context.pattern().dim()], 5.0);
    let mut v = turning(&mut context, &q, Vector3::z() * omega);
    context.set(&mut v, hinge.coordinates[0], 0, omega);
    Problem {
        context,
        probes: vec![arm, tip],
        q: Vec::new(),
        v,
    }
}

/// Errors at n, 2n and 4n steps.
fn errors(
    n: usize,
    reference: &[NodeState],
    run: &mut dyn FnMut(usize) -> Vec<NodeState>,
) -> Vec<Vec<f64>> {
    [n, 2 * n, 4 * n]
        .map(|n| distances(&run(n), reference).to_vec())
        .to_vec()
}

/// Runs of a problem by a scheme in a number of steps.
type Run<'a> = &'a dyn Fn(Scheme, usize) -> Vec<NodeState>;

/// A solution to compare with.
fn reference(run: Run<'_>) -> Vec<NodeState> {
    richardson(1280, &mut |n| run(Scheme::default(), n))
}

/// The schemes of order two are so on a problem, from n steps on.
fn assert_order_two(run: Run<'_>, reference: &[NodeState], n: usize) {
    for scheme in second_order() {
        let e = errors(n, reference, &mut |n| run(scheme, n));
        assert_slopes(scheme.name, &QUANTITIES, &e, 2.0, 0.1);
    }
}

/// Radau IIA is of order three on a problem, from n steps on.
fn assert_order_three(run: Run<'_>, reference: &[NodeState], n: usize) {
    let e = errors(n, reference, &mut |n| run(Scheme::radau(), n));
    assert_slopes("Radau IIA", &QUANTITIES, &e, 3.0, 0.15);
}

#[test]
fn bodies_on_joints_of_a_driven_carriage() {
    let to = 1.6;
    let run = |scheme, n| {
        let (states, changes) = two_bodies([1.0, 7.0, 2.0]).run(scheme, to, n);
        // The second body turns by more than a whole turn.
        assert!(changes >= 2, "{changes} changes");
        states
    };
    let reference = reference(&run);
    assert_order_two(&run, &reference, 160);
    for word in [
        "central-difference",
        "projected-newmark",
        "projected-newmark:0.8",
    ] {
        let scheme: Scheme = word.parse().unwrap();
        assert_eq!(scheme.order(), 2);
        let e = errors(160, &reference, &mut |n| run(scheme, n));
        assert_slopes(word, &QUANTITIES, &e, 2.0, 0.1);
    }
    assert_order_three(&run, &reference, 80);
    let first = Scheme::newmark(0.3025, 0.6).unwrap();
    assert_eq!(first.order(), 1);
    let e = errors(320, &reference, &mut |n| run(first, n));
    assert_slopes("Newmark with gamma = 0.6", &QUANTITIES, &e, 1.0, 0.1);
}

/// A body whose reference configuration is upside down: hanging, it has turned by π, and every
/// swing takes its rotation vector across the border of its chart.
fn upside_down() -> Problem {
    let mut b = ModelBuilder::new();
    let carriage = b.node("carriage", [0.0; 3]).unwrap();
    b.support(carriage, &[Dof::Y, Dof::Z, Dof::RX, Dof::RY, Dof::RZ]);
    b.prescribe(carriage, Dof::X, sine(0.05, 2.0, 0.2));
    let ball = b.spherical("ball", carriage).unwrap();
    heavy_body(&mut b, "body", ball.frame, 1.0, [0.0, 0.05, 0.9]);
    let probe = b.offset("probe", ball.frame, [0.3, 0.1, 0.9]).unwrap();
    b.element("fly", PointMass::new(0.1).unwrap(), &[probe])
        .unwrap();
    let context = Context::new(b.build().unwrap());
    let k = context.unknown_at(ball.coordinates[0], 0).unwrap();
    let (mut q, mut v) = (vec![0.0; 3], vec![0.0; 3]);
    q[k..k + 3].copy_from_slice(&[PI - 0.3, 0.1, 0.2]);
    v[k..k + 3].copy_from_slice(&[0.3, 0.1, 0.05]);
    Problem {
        context,
        probes: vec![ball.frame, probe],
        q,
        v,
    }
}

#[test]
fn swings_about_the_border_of_a_chart() {
    let to = 8.0;
    let run = |scheme, n: usize| {
        let (states, changes) = upside_down().run(scheme, to, n);
        // At the largest step more often than after every twelfth.
        assert!(12 * changes >= 80, "{changes} changes");
        states
    };
    let reference = reference(&run);
    assert_order_two(&run, &reference, 80);
    assert_order_three(&run, &reference, 40);
}

#[test]
fn a_flexible_beam_swung_in_a_plane_across_changes_of_chart() {
    let to = 1.6;
    let run = |scheme, n| {
        let (states, changes) = swung_beam(2, 0.0).run(scheme, to, n);
        // Both free nodes and the hung one.
        assert_eq!(changes, 3);
        states
    };
    let reference = reference(&run);
    assert_order_two(&run, &reference, 320);
    assert_order_three(&run, &reference, 160);
}

#[test]
fn a_flexible_beam_swung_in_space_within_one_chart() {
    let to = 1.0;
    let run = |scheme, n| swung_beam(2, 0.3).unchanged(scheme, to, n);
    assert_order_two(&run, &reference(&run), 320);
}

#[test]
fn a_geodesic_beam_swung_in_space_across_changes_of_chart() {
    let to = 1.0;
    let run = |scheme, n| {
        let problem = swung_beam_with(2, 0.3, Interpolation::Geodesic);
        let (states, changes) = problem.run(scheme, to, n);
        assert_eq!(changes, 3);
        states
    };
    assert_order_two(&run, &reference(&run), 320);
}

/// What it does to the swung beam that all its elements change their charts at half the time, in n
/// steps: the distance to the motion with that one step later, and to the one without.
fn of_a_change(elements: usize, interpolation: Interpolation, n: usize) -> [Vec<f64>; 2] {
    let run = |when: usize| {
        let problem = swung_beam_with(elements, 0.3, interpolation);
        problem.changed(Scheme::default(), 1.0, n, [when, elements])
    };
    let changed = run(n / 2);
    [n / 2 + 1, usize::MAX].map(|when| distances(&changed, &run(when)).to_vec())
}

/// The interpolation of two total rotation vectors depends on their chart by its mesh error: forces jump
/// where an element changes it, and the step is the time to which a run knows when.
#[test]
fn where_elements_of_total_rotation_vectors_change_charts_in_space_the_order_is_one() {
    let both = [320, 640, 1280].map(|n| of_a_change(2, Interpolation::Total, n));
    let [later, never] = [0, 1].map(|k| both.each_ref().map(|both| both[k].clone()));
    assert_slopes("a step later", &QUANTITIES, &later, 1.0, 0.1);
    // The jump itself is one of the mesh: smaller steps do not mend it.
    assert_slopes("never", &QUANTITIES, &never, 0.0, 0.1);
    // Relative rotations do not know of charts.
    for distance in of_a_change(2, Interpolation::Geodesic, 320).concat() {
        assert!(distance < 1e-9, "{distance:e}");
    }
}

#[test]
fn what_a_change_of_chart_does_to_a_beam_in_space_falls_with_the_mesh() {
    // The same motion with elements that change their charts, and with elements that never do.
    let (to, n) = (1.0, 1280);
    let [coarse, fine] = [1, 8].map(|elements| {
        let scheme = Scheme::default();
        let (changing, changes) = swung_beam(elements, 0.3).run(scheme, to, n);
        assert_eq!(changes, elements + 1);
        let staying = swung_beam(elements, 0.3).unchanged(scheme, to, n);
        distances(&changing, &staying)
    });
    // At least with order 1 in the length of an element.
    for k in 0..2 {
        assert!(fine[k] < coarse[k] / 8.0, "{coarse:?} {fine:?}");
    }
}
