//! Errors planted where the pieces of a map meet: the lines of a chain, the formulas of a curve.

use crate::support::*;
use pullback_conformance::joint;

/// What is wrong on the second line of the chain.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Planted {
    Nothing,
    /// The rotation of its first frame has the other sign.
    Turned,
    /// Its first frame's velocity is not carried on.
    Velocity,
    /// Nothing is handed back to its first frame.
    Stays,
}

/// A slide that goes wrong once it is handed over.
#[derive(Clone)]
struct Along(Slide, Planted);

impl Along {
    fn planted(&self, what: Planted) -> bool {
        self.1 == what && self.0.segment() == 1
    }

    /// Coordinates, or their rates, as the slide sees them.
    fn seen(&self, x: &[f64]) -> Vec<f64> {
        let mut x = x.to_vec();
        if self.planted(Planted::Turned) && !x.is_empty() {
            x[3..6].iter_mut().for_each(|x| *x = -*x);
        }
        x
    }
}

impl Parametrization for Along {
    fn dims(&self) -> (usize, usize) {
        (13, 6)
    }

    fn domain(&mut self, t: f64, q: &[f64]) -> Result<f64, DomainError> {
        Parametrization::domain(&mut self.0, t, q)
    }

    fn evaluate(&mut self, t: f64, motion: [&[f64]; 3], out: &mut [Order<'_>]) {
        let seen = motion.map(|x| self.seen(x));
        self.0.evaluate(t, seen.each_ref().map(|x| &x[..]), out);
        if self.planted(Planted::Turned) {
            let columns = out.iter_mut().flat_map(|[_, B]| &mut B[6 * 3..6 * 6]);
            columns.for_each(|b| *b = -*b);
        }
        if let (true, [[_, B], [x_dot, _], _]) = (self.planted(Planted::Velocity), out) {
            for (column, v) in B.chunks(6).zip(&motion[1][..6]) {
                x_dot.iter_mut().zip(column).for_each(|(x, b)| *x -= b * v);
            }
        }
    }

    fn geometric_stiffness(&mut self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        let seen = self.seen(q);
        Parametrization::geometric_stiffness(&mut self.0, t, &seen, f, K);
        if self.planted(Planted::Turned) {
            let turned = |i: usize| (3..6).contains(&i);
            let entries = K.iter_mut().enumerate();
            let crossed = entries.filter(|(k, _)| turned(k / 13) != turned(k % 13));
            crossed.for_each(|(_, K)| *K = -*K);
        }
    }

    fn state(&mut self) -> Option<&mut dyn MapState> {
        Some(self)
    }

    fn segments(&self) -> Option<&dyn Segments> {
        Some(self)
    }
}

impl MapState for Along {
    fn change_charts(&mut self, t: f64, q: &[f64]) -> ChartChanges {
        self.0.change_charts(t, q)
    }

    fn enter(&mut self, segment: usize) {
        if self.1 != Planted::Stays {
            self.0.enter(segment);
        }
    }

    fn save(&self) -> Vec<f64> {
        self.0.save()
    }

    fn restore(&mut self, saved: &[f64]) -> bool {
        self.0.restore(saved)
    }
}

impl Segments for Along {
    fn count(&self) -> usize {
        self.0.segments().unwrap().count()
    }

    fn segment(&self) -> usize {
        self.0.segment()
    }

    fn overshoot(&self, h: f64, from: [&[f64]; 2], to: [&[f64]; 2]) -> Option<(f64, usize)> {
        self.0.overshoot(h, from, to)
    }
}

fn body() -> RigidBody {
    let J = Matrix3::from_diagonal(&Vector3::new(0.2, 0.3, 0.45));
    RigidBody::new(2.0, J, Vector3::new(0.1, 0.0, 0.2)).unwrap()
}

/// Three lines with a corner between free bodies, and a body that runs along them; driven or free.
fn chained(planted: Planted, interpolation: Interpolation, driven: bool, seed: u64) -> Report {
    let mut b = ModelBuilder::new();
    let positions = [[0.0; 3], [1.0, 0.0, 0.0], [1.6, 0.7, 0.0], [2.0, 0.9, 0.5]];
    let nodes: Vec<NodeId> = (positions.iter().enumerate())
        .map(|(k, position)| b.node(format!("n{k}"), *position).unwrap())
        .collect();
    for (k, node) in nodes.iter().enumerate() {
        b.element(format!("b{k}"), body(), &[*node]).unwrap();
    }
    let way = b.coordinates("way", &[Quantity::Length]).unwrap();
    let chain = Chain::new(&positions.map(Vector3::from), 0.7).unwrap();
    let start = chain.start();
    let map = Along(Slide::new(chain, interpolation), planted);
    let segments: Vec<[NodeId; 3]> = nodes.windows(2).map(|p| [p[0], p[1], way]).collect();
    let segments: Vec<&[NodeId]> = segments.iter().map(|s| &s[..]).collect();
    let frame = b
        .mapped_node_along("runner", start.into(), Box::new(map), &segments)
        .unwrap();
    b.element("runner body", body(), &[frame]).unwrap();
    if driven {
        b.prescribe_coordinate(way, 0, Constant(0.05));
    }
    checked(b, seed)
}

const MOTION: [&str; 2] = ["joint runner (along)", "change of segment: motion stays"];
const FORCES: [&str; 2] = ["joint runner (along)", "change of segment: forces stay"];

#[test]
fn a_chain_hands_over_and_loses_nothing() {
    for interpolation in [Interpolation::Total, Interpolation::Geodesic] {
        for driven in [false, true] {
            for seed in 0..6 {
                let report = chained(Planted::Nothing, interpolation, driven, seed);
                report.assert();
                for [_, law] in [MOTION, FORCES] {
                    assert!(report.rows().iter().any(|r| r.law == law), "{report}");
                }
            }
        }
    }
}

#[test]
fn errors_behind_a_hand_over() {
    for driven in [false, true] {
        for (planted, expected) in [
            (Planted::Turned, &[MOTION, FORCES][..]),
            (Planted::Velocity, &[MOTION]),
            (Planted::Stays, &[MOTION]),
        ] {
            let report = chained(planted, Interpolation::Total, driven, 0);
            assert_eq!(failures(&report), expected, "{report}");
        }
    }
    let report = chained(Planted::Velocity, Interpolation::Total, false, 0);
    let blocks = &report.failures()[0].blocks;
    assert_eq!(blocks[0].matrix, "x_dot", "{report}");
    assert!(report.to_string().contains("x_dot of"), "{report}");
}

/// A straight line that bends from s = 0.4 on, by the given power of the way from there.
#[derive(Clone)]
struct Bent(i32, Option<bool>);

impl Curve for Bent {
    fn at<S: Scalar>(&self, s: S) -> Vector3<S> {
        let from = s - 0.4;
        let mut bend = S::constant(0.3);
        for _ in 0..self.0 {
            bend *= from;
        }
        if !self.1.unwrap_or(s.re() >= 0.4) {
            bend = S::zero();
        }
        Vector3::new(s, bend, S::zero())
    }

    fn freeze_piece(&mut self, at: Option<f64>) {
        self.1 = at.map(|s| s >= 0.4);
    }
}

#[test]
fn pieces_of_a_curve_meet_with_two_derivatives() {
    let law = "pieces meet: x, x_dot, x_ddot, B, B_dot";
    joint(&OnCurve::new(Bent(3, None))).assert();
    for (power, worst) in [(0, "x"), (1, "x_dot"), (2, "x_ddot")] {
        let report = joint(&OnCurve::new(Bent(power, None)));
        let failures = report.failures();
        assert!(failures.len() > 2, "{report}");
        assert!(failures.iter().all(|row| row.law == law), "{report}");
        let named: Vec<&str> = (failures.iter())
            .map(|row| row.blocks[0].matrix.as_str())
            .collect();
        assert!(named.contains(&worst), "{named:?}");
    }
    for (power, count) in [(3, 0), (1, 1)] {
        let mut b = ModelBuilder::new();
        let base = b.node("base", [0.0; 3]).unwrap();
        b.element("base", body(), &[base]).unwrap();
        let bead = b
            .attach_free("bead", base, OnCurve::new(Bent(power, None)))
            .unwrap();
        b.element("bead", body(), &[bead.frame]).unwrap();
        let report = checked(b, 0);
        let expected = [["joint bead (on curve)", law]];
        assert_eq!(failures(&report), expected[..count], "{report}");
    }
}
