//! A motion does not depend on the charts in which it is computed.
//!
//! What that means for numbers: a change of chart itself is exact, so a state and its consistent
//! accelerations are the same in space to round-off in every chart. A step is not: a scheme is
//! applied to coordinates, and Ψ and its complement are related by a map that is not linear. Steps
//! in different charts differ by their local errors, and histories by an amount of the order of the
//! scheme. Where the axis of rotation is fixed the map is a shift, and histories agree to the
//! tolerance of Newton's method.

use crate::support::beams;
use crate::support::dynamics::*;
use crate::support::prelude::*;

/// A model, the nodes compared, its start, and where its free rotation vectors stand.
struct Problem {
    context: Context,
    probes: Vec<NodeId>,
    q: Vec<f64>,
    v: Vec<f64>,
    rotations: Vec<usize>,
    beams: usize,
}

impl Problem {
    /// The same start with all free rotations in the other chart.
    fn complement(mut self) -> Self {
        for &k in &self.rotations {
            let take = |x: &[f64]| Vector3::new(x[k], x[k + 1], x[k + 2]);
            let (psi, psi_dot) = (take(&self.q), take(&self.v));
            let (other, rate) = (so3::complement(&psi), so3::B_s(&psi) * psi_dot);
            assert!((so3::rotation(&psi) - so3::rotation(&other)).amax() < 1e-14);
            assert!((psi.norm() < PI) && (other.norm() > PI));
            self.q[k..k + 3].copy_from_slice(other.as_slice());
            self.v[k..k + 3].copy_from_slice(rate.as_slice());
        }
        let mut state = self.context.save();
        let charts = &mut state.element_charts[..self.beams];
        charts.iter_mut().for_each(|c| *c ^= 0b11);
        assert!(self.context.restore(&state));
        self
    }

    /// A run in `n` steps with changes of chart as the model has them.
    fn by_itself(mut self, scheme: Scheme, to: f64, n: usize) -> Vec<NodeState> {
        let options = tight(scheme, to, to / n as f64);
        let from = [&self.q[..], &self.v];
        history(&mut self.context, &self.probes, from, &options, 8).0
    }

    /// A run in `n` steps with all charts changed after step `change`, and never otherwise.
    fn changed(self, scheme: Scheme, to: f64, n: usize, change: Option<usize>) -> Vec<NodeState> {
        let mut system = Flipped {
            beams: self.beams,
            ..Flipped::new(self.context, self.rotations, move |step| {
                Some(step) == change
            })
        };
        let options = tight(scheme, to, to / n as f64);
        let from = [&self.q[..], &self.v[..]];
        let (states, progress) = history(&mut system, &self.probes, from, &options, 8);
        let expected = change.map_or(0, |_| system.rotations.len());
        assert_eq!(progress.summary.chart_changes, expected);
        states
    }
}

/// A heavy body on a spherical joint; rotation vector and angular velocity at the start.
fn pendulum(J: Matrix3<f64>, center: [f64; 3], psi: [f64; 3], omega: [f64; 3]) -> Problem {
    let (mut b, ground) = grounded();
    let ball = b.attach_free("ball", ground, Spherical).unwrap();
    let made = RigidBody::new(2.0, J, center.into()).unwrap();
    body(&mut b, "body", ball.frame, made);
    let probe = b.offset("probe", ball.frame, center).unwrap();
    b.element("fly", PointMass::new(0.1).unwrap(), &[probe])
        .unwrap();
    let mut context = Context::new(b.build().unwrap());
    let k = context.unknown_at(ball.coordinates[0], 0).unwrap();
    let mut q = vec![0.0; 3];
    q[k..k + 3].copy_from_slice(&psi);
    let v = turning(&mut context, &q, omega.into());
    Problem {
        context,
        probes: vec![ball.frame, probe],
        q,
        v,
        rotations: vec![k],
        beams: 0,
    }
}

fn spatial() -> Problem {
    let J = Matrix3::new(0.3, 0.02, 0.03, 0.02, 0.4, -0.04, 0.03, -0.04, 0.5);
    pendulum(J, [0.3, -0.2, -0.5], [0.9, -1.1, 0.7], [0.5, 1.5, -1.0])
}

/// Everything in the plane of e2 and e3.
fn planar() -> Problem {
    let J = Matrix3::from_diagonal(&Vector3::new(0.3, 0.4, 0.5));
    pendulum(J, [0.0, 0.3, -0.5], [1.4, 0.0, 0.0], [1.0, 0.0, 0.0])
}

/// A free flexible beam, turned by `psi` as a whole and spinning.
fn beam(psi: [f64; 3], omega: [f64; 3]) -> Problem {
    let mut b = ModelBuilder::new();
    let ends = [[0.0; 3], [1.0, 0.0, 0.0]];
    let ends = [b.node("a", ends[0]).unwrap(), b.node("b", ends[1]).unwrap()];
    let J = Matrix3::from_diagonal(&Vector3::new(0.02, 0.01, 0.01));
    let section = Section::diagonal(60.0, [30.0; 2], 4.0, [4.0, 6.0]).unwrap();
    let nodes = beams::beam(&mut b, "beam", ends, 2, section.with_mass(1.0, J));
    let mut context = Context::new(b.build().unwrap());
    let psi = Vector3::from(psi);
    let mut q = vec![0.0; context.pattern().dim()];
    let mut rotations = Vec::new();
    for &node in &nodes {
        let X = context.node(node).position();
        let d = so3::rotation(&psi) * X - X;
        for k in 0..3 {
            context.set(&mut q, node, k, d[k]);
            context.set(&mut q, node, 3 + k, psi[k]);
        }
        rotations.push(context.unknown(node, Dof::RX).unwrap());
    }
    let v = turning(&mut context, &q, omega.into());
    Problem {
        context,
        probes: nodes,
        q,
        v,
        rotations,
        beams: 2,
    }
}

/// Largest distance over all quantities, relative to their sizes.
fn gap(a: &[NodeState], b: &[NodeState]) -> f64 {
    let size = a.iter().fold(1.0_f64, |s, x| s.max(x.acceleration.norm()));
    let d = distances(a, b);
    d[..4].iter().copied().fold(d[4] / size, f64::max)
}

#[test]
fn a_start_in_the_other_chart_is_the_same_start() {
    let problems: [&dyn Fn() -> Problem; 3] = [&spatial, &planar, &|| {
        beam([0.3, 0.8, -1.0], [1.0, -0.5, 3.0])
    }];
    for problem in problems {
        for scheme in second_order() {
            let a = problem().by_itself(scheme, 0.8, 80);
            let b = problem().complement().by_itself(scheme, 0.8, 80);
            assert!(gap(&a, &b) < 1e-10, "{}: {:e}", scheme.name, gap(&a, &b));
        }
    }
}

#[test]
fn accelerations_in_space_do_not_depend_on_the_chart() {
    for problem in [spatial, || beam([0.3, 0.8, -1.0], [1.0, -0.5, 3.0])] {
        // One step so short that nothing but the start counts: ẍ is that of the equations of
        // motion in the chart of the start.
        let [a, b] = [problem(), problem().complement()]
            .map(|p| p.changed(Scheme::default(), 8e-9, 8, None));
        assert!(gap(&a, &b) < 1e-9, "{:e}", gap(&a, &b));
    }
}

#[test]
fn about_a_fixed_axis_histories_agree_to_round_off() {
    for problem in [planar, || beam([0.0, 0.0, 1.2], [0.0, 0.0, 2.0])] {
        for scheme in second_order() {
            // Until the rotation vector of the other chart reaches 2π.
            let (to, n) = (0.6, 64);
            let plain = problem().changed(scheme, to, n, None);
            let other = problem().complement().changed(scheme, to, n, None);
            let midway = problem().changed(scheme, to, n, Some(n / 2 + 3));
            assert!(gap(&plain, &other) < 1e-9, "{:e}", gap(&plain, &other));
            assert!(gap(&plain, &midway) < 1e-9, "{:e}", gap(&plain, &midway));
        }
    }
}
