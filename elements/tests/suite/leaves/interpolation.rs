//! What sets the two interpolations of rotations apart: the geodesic one is a function of relative
//! rotations, the total one is not.

#![allow(non_snake_case)]

use crate::support::{coupled, line, moving, response, straight};
use nalgebra::{Matrix3, Matrix6, SVector, Vector3};
use pullback_conformance as check;
use pullback_conformance::Random;
use pullback_elements::beam::{Beam, Damping, Geodesic, Interpolation, Section};
use pullback_elements::element::{Element, SectionState};
use pullback_elements::energy::{EnergyElement, inside_chart, rate};
use pullback_elements::inertia::Inertia;
use pullback_elements::load::LineLoad;
use pullback_elements::model::{BeamLine, Context, ModelBuilder, frame_along};
use pullback_elements::time::Constant;
use pullback_manifold::domain::DomainError;
use pullback_manifold::quotients::{Quotients, TangentQuotients};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3;
use std::f64::consts::{PI, TAU};

/// An inertia per length with its mass centre off the axis.
fn eccentric() -> Inertia {
    Inertia::about_centre(
        2.3,
        Vector3::new(0.02, 0.3, -0.2),
        Matrix3::new(0.9, 0.1, -0.05, 0.1, 0.7, 0.02, -0.05, 0.02, 0.5),
    )
}

fn massive(damping: Damping) -> Section {
    let section = coupled().with_inertia(eccentric()).unwrap();
    section.with_damping(damping).unwrap()
}

const DAMPING: Damping = Damping {
    mass: 0.7,
    stiffness: 0.04,
};

/// The two-node geodesic beam by its energies: nothing is shared with the one by hand.
struct ByEnergy {
    positions: [Vector3<f64>; 2],
    R0: Matrix3<f64>,
    section: Section,
}

fn triple<S: Scalar>(y: &SVector<S, 12>, i: usize) -> Vector3<S> {
    Vector3::new(y[i], y[i + 1], y[i + 2])
}

impl ByEnergy {
    fn length(&self) -> f64 {
        (self.positions[1] - self.positions[0]).norm()
    }

    /// Strains in the middle, in the section axes.
    fn strains<S: Scalar>(&self, y: &SVector<S, 12>) -> SVector<S, 6> {
        let [d1, psi1, d2, psi2] = [0, 3, 6, 9].map(|i| triple(y, i));
        let (X, L) = (self.positions[1] - self.positions[0], self.length());
        let position = (X.map(S::constant) + d2 - d1) * S::constant(1.0 / L);
        let between = so3::quaternion(&psi1)
            .conjugate()
            .product(&so3::quaternion(&psi2));
        let theta = so3::log_quaternion(&between);
        let back = |psi: &Vector3<S>, a: &Vector3<S>| {
            so3::turned(&-psi, a, &TangentQuotients::new(psi.dot(psi)))
        };
        let Gamma =
            back(&(theta * S::constant(0.5)), &back(&psi1, &position)) - (X / L).map(S::constant);
        // T(θ/2) θ = θ.
        let K = theta * S::constant(1.0 / L);
        let R0 = self.R0.transpose().map(S::constant);
        let (Gamma, K) = (R0 * Gamma, R0 * K);
        SVector::<S, 6>::new(Gamma.x, Gamma.y, Gamma.z, K.x, K.y, K.z)
    }

    fn quadratic<S: Scalar>(&self, e: &SVector<S, 6>) -> S {
        e.dot(&(self.section.C.map(S::constant) * e)) * (0.5 * self.length())
    }

    fn inertial<S: Scalar>(&self, y: &SVector<S, 12>, v: &SVector<S, 12>) -> S {
        let Inertia { mass, S: first, J } = self.section.inertia.rotated(&self.R0);
        let (first, J) = (first.map(S::constant), J.map(S::constant));
        let node = |k: usize| {
            let psi = triple(y, 6 * k + 3);
            let c = TangentQuotients::new(psi.dot(&psi));
            let Omega = so3::spun(&psi, &triple(v, 6 * k + 3), &c);
            let lever = so3::turned(&psi, &Omega.cross(&first), &c);
            (triple(v, 6 * k), Omega, lever)
        };
        let nodes = [node(0), node(1)];
        let mut sum = S::zero();
        for i in 0..2 {
            for j in 0..2 {
                let NN = self.length() / if i == j { 3.0 } else { 6.0 };
                let ((vi, Oi, _), (vj, Oj, lj)) = (&nodes[i], &nodes[j]);
                sum += (vi.dot(vj) * (0.5 * mass) + vi.dot(lj) + Oi.dot(&(J * Oj)) * 0.5) * NN;
            }
        }
        sum
    }
}

impl EnergyElement<12> for ByEnergy {
    fn potential<S: Scalar>(&self, _t: S, y: &SVector<S, 12>) -> S {
        self.quadratic(&self.strains(y))
    }

    fn kinetic<S: Scalar>(&self, y: &SVector<S, 12>, v: &SVector<S, 12>) -> S {
        self.inertial(y, v)
    }

    fn dissipation<S: Scalar>(&self, y: &SVector<S, 12>, v: &SVector<S, 12>) -> S {
        let Damping { mass, stiffness } = self.section.damping;
        let viscous = self.quadratic(&rate(|y| self.strains(y), y, v));
        viscous * stiffness + self.inertial(y, v) * mass
    }

    fn domain(&self, y: &SVector<f64, 12>) -> Result<(), DomainError> {
        inside_chart(&triple(y, 3))?;
        inside_chart(&triple(y, 9))
    }
}

#[test]
fn the_element_by_hand_is_the_one_by_its_energies() {
    let positions = [Vector3::new(0.2, -0.1, 0.3), Vector3::new(0.9, 0.5, 0.7)];
    let R0 = frame_along(
        &(positions[1] - positions[0]),
        Some(&Vector3::new(0.1, 0.9, 0.3)),
    );
    for section in [massive(Damping::default()), massive(DAMPING)] {
        let hand = Beam::<2, Geodesic<2>>::new(&positions, &|_| R0, &section).unwrap();
        let energies = ByEnergy {
            positions,
            R0,
            section,
        };
        check::same(&hand, &energies.into_element()).assert();
    }
}

/// Motion of one element's nodes in the fixed frame: position, rotation, their velocities (ẋ, Ω
/// material) and accelerations (ẍ, Ω̇).
#[derive(Clone)]
struct Node {
    X: Vector3<f64>,
    x: Vector3<f64>,
    R: Matrix3<f64>,
    rates: [Vector3<f64>; 4],
}

impl Node {
    fn turned(&self, Q: &Matrix3<f64>) -> Self {
        let [v, Omega, a, A] = self.rates;
        Self {
            X: self.X,
            x: Q * self.x,
            R: Q * self.R,
            rates: [Q * v, Omega, Q * a, A],
        }
    }

    /// Coordinates, velocities, accelerations; the rotation vector on the branch of `near`.
    fn coordinates(&self, near: &Vector3<f64>) -> [[Vector3<f64>; 2]; 3] {
        let psi = so3::log_rotation(&self.R, near);
        let T_inverse = so3::tangent_inverse(&psi);
        let [v, Omega, a, A] = self.rates;
        let psi_dot = T_inverse * Omega;
        let rest = so3::T_dot_psi_dot(&psi_dot, &psi, &Quotients::new(psi.norm()));
        [
            [self.x - self.X, psi],
            [v, psi_dot],
            [a, T_inverse * (A - rest)],
        ]
    }
}

/// What an element answers, in the fixed frame.
struct Answer {
    energy: f64,
    dissipation: f64,
    states: Vec<SectionState>,
    /// Force and moment at each node.
    forces: Vec<[Vector3<f64>; 2]>,
}

/// The element's answer; all rotation vectors on the branch of `near`, or in the other chart.
fn answer(element: &dyn Element, nodes: &[Node], near: &Vector3<f64>, other: bool) -> Answer {
    let mut motion = [Vec::new(), Vec::new(), Vec::new()];
    let mut vectors = Vec::new();
    for node in nodes {
        let mut parts = node.coordinates(near);
        if other {
            let psi = so3::complement(&parts[0][1]);
            parts = node.coordinates(&psi);
        }
        vectors.push(parts[0][1]);
        for (out, part) in motion.iter_mut().zip(parts) {
            out.extend(part.iter().flat_map(|p| p.iter().copied()));
        }
    }
    let [x, v, a] = &motion;
    let at = moving(x, v, a);
    let mut r = vec![0.0; x.len()];
    let mut out = response(&mut r);
    element.evaluate(&at, &mut out).unwrap();
    let (abilities, mut states) = (element.abilities(), Vec::new());
    abilities.section_states(&at, &mut states);
    let forces = r.chunks(6).zip(&vectors).map(|(r, psi)| {
        // The covector of a spatial moment m is T m.
        let moment = so3::tangent_inverse(psi) * Vector3::from_column_slice(&r[3..]);
        [Vector3::from_column_slice(&r[..3]), moment]
    });
    Answer {
        energy: abilities.energy(&at),
        dissipation: abilities.dissipation(&at),
        forces: forces.collect(),
        states,
    }
}

/// Largest relative difference between answers, the second one turned by Q from the first.
fn gap(a: &Answer, b: &Answer, Q: &Matrix3<f64>) -> f64 {
    let mut most = 0.0_f64;
    let mut compare = |a: Vector3<f64>, b: Vector3<f64>, size: f64| {
        most = most.max((a - b).norm() / size.max(1e-300));
    };
    let number = |x: f64| Vector3::x() * x;
    compare(number(a.energy), number(b.energy), a.energy.abs());
    compare(number(a.dissipation), number(b.dissipation), a.dissipation);
    for kind in 0..2 {
        let size = a.forces.iter().map(|f| f[kind].norm()).fold(0.0, f64::max);
        for (f, g) in a.forces.iter().zip(&b.forces) {
            compare(Q * f[kind], g[kind], size);
        }
    }
    for (s, t) in a.states.iter().zip(&b.states) {
        compare(s.Gamma, t.Gamma, s.Gamma.norm());
        compare(s.K, t.K, s.K.norm());
        compare(s.N, t.N, s.N.norm());
        compare(s.M, t.M, s.M.norm());
        compare(Q * s.position, t.position, 1.0);
        for k in 0..3 {
            let [e, f] = [s, t].map(|s| s.frame.column(k).into_owned());
            compare(Q * e, f, 1.0);
        }
    }
    most
}

/// Nodes on a curve, strained, bent and in motion.
fn nodes(count: usize, random: &mut Random) -> Vec<Node> {
    (0..count)
        .map(|k| {
            let u = 1.2 * k as f64 / (count - 1) as f64;
            let X = Vector3::new(u.cos(), u.sin(), 0.4 * u);
            Node {
                X,
                x: X + random.vector::<3>() * 0.1,
                R: so3::rotation(&(random.vector::<3>() * 0.5)),
                rates: std::array::from_fn(|_| random.vector::<3>()),
            }
        })
        .collect()
}

fn frame(xi: f64) -> Matrix3<f64> {
    let u = 0.6 * (1.0 + xi);
    frame_along(&Vector3::new(-u.sin(), u.cos(), 0.4), None)
}

#[test]
fn a_rigid_rotation_or_another_chart_changes_nothing_geodesic() {
    let mut random = Random::new(41);
    let turn = Vector3::new(1.0, -1.4, 1.1);
    let Q = so3::rotation(&turn);
    for count in 2..=4 {
        for _ in 0..10 {
            let nodes = nodes(count, &mut random);
            let positions: Vec<_> = nodes.iter().map(|n| n.X).collect();
            let turned: Vec<_> = nodes.iter().map(|n| n.turned(&Q)).collect();
            let wind = |i| {
                let load = LineLoad::new(&positions, [0.3, 1.0, -0.4], true, Constant(1.0));
                load.unwrap().with_interpolation(i)
            };
            let beam = |i: Interpolation| i.beam(&positions, &frame, &massive(DAMPING)).unwrap();
            let elements = |i| -> [Box<dyn Element>; 2] { [beam(i), Box::new(wind(i))] };
            let zero = Vector3::zeros();
            for element in elements(Interpolation::Geodesic) {
                let plain = answer(&*element, &nodes, &zero, false);
                let rotated = answer(&*element, &turned, &turn, false);
                let g = gap(&plain, &rotated, &Q);
                assert!(g < 1e-12, "{count} nodes, turned: {g:e}");
                let other = answer(&*element, &turned, &turn, true);
                let g = gap(&plain, &other, &Q);
                assert!(g < 1e-12, "{count} nodes, the other chart: {g:e}");
            }
            // The comparison sees what there is to see.
            for element in elements(Interpolation::Total) {
                let plain = answer(&*element, &nodes, &zero, false);
                let rotated = answer(&*element, &turned, &turn, false);
                let g = gap(&plain, &rotated, &Q);
                assert!(g > 1e-4, "{count} nodes, total: {g:e}");
                let other = answer(&*element, &turned, &turn, true);
                let g = gap(&rotated, &other, &Matrix3::identity());
                assert!(g > 1e-4, "{count} nodes, total, the other chart: {g:e}");
            }
        }
    }
}

/// Largest error of strains, over all elements of a mesh on a bent and twisted curve, that a rigid
/// rotation by `turn` makes.
fn strain_error(interpolation: Interpolation, elements: usize, turn: &Vector3<f64>) -> f64 {
    let Q = so3::rotation(turn);
    // Rotation and position on the way s of the deformed curve; the reference is straight.
    let at = |s: f64| {
        let R = so3::rotation(&Vector3::new(0.9 * s, 0.6 * s * s, 0.8 * s));
        let x = Vector3::new(s.sin(), 1.0 - s.cos(), 0.3 * s * s);
        (x, R)
    };
    let h = 1.0 / elements as f64;
    let mut worst = 0.0_f64;
    for e in 0..elements {
        let nodes: Vec<Node> = [e, e + 1]
            .map(|k| {
                let s = k as f64 * h;
                let (x, R) = at(s);
                Node {
                    X: Vector3::x() * s,
                    x,
                    R,
                    rates: [Vector3::zeros(); 4],
                }
            })
            .into();
        let positions: Vec<_> = nodes.iter().map(|n| n.X).collect();
        let beam = interpolation.beam(&positions, &|_| Matrix3::identity(), &coupled());
        let beam = beam.unwrap();
        let turned: Vec<_> = nodes.iter().map(|n| n.turned(&Q)).collect();
        let plain = answer(&*beam, &nodes, &Vector3::zeros(), false);
        let rotated = answer(&*beam, &turned, turn, false);
        for (s, t) in plain.states.iter().zip(&rotated.states) {
            worst = worst.max((s.Gamma - t.Gamma).norm().max((s.K - t.K).norm()));
        }
    }
    worst
}

#[test]
fn the_strain_error_of_total_vectors_under_a_rigid_rotation_falls_with_the_mesh() {
    let turn = Vector3::new(0.8, -1.1, 0.9);
    let meshes = [8, 16, 32, 64];
    let errors = meshes.map(|n| strain_error(Interpolation::Total, n, &turn));
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 2.0).abs() < 0.2, "{errors:?}");
    }
    for n in meshes {
        // Strains are differences of rotations over h.
        let error = strain_error(Interpolation::Geodesic, n, &turn);
        assert!(error < 1e-15 * 10.0 * n as f64, "{n} elements: {error:e}");
    }
}

/// The laws of objectivity and of charts that the check of a model finds for its beams.
fn laws_found(interpolation: Interpolation) -> Vec<String> {
    let mut b = ModelBuilder::new();
    let ends = [[0.0; 3], [1.0, 0.2, 0.1]];
    let ends = [b.node("a", ends[0]).unwrap(), b.node("b", ends[1]).unwrap()];
    let line = BeamLine {
        section: massive(DAMPING),
        ..line(1, 2)
    };
    let laid = b.line_with("beam", &straight(&b, ends), ends, &line, interpolation);
    laid.unwrap();
    let report = check::model(
        &mut Context::new(b.build().unwrap()),
        &check::ModelOptions::default(),
    );
    report.assert();
    let found = report
        .rows()
        .iter()
        .filter(|r| r.component.contains("beam"));
    let law = |l: &String| l.starts_with("objective") || l.starts_with("the same in the other");
    let mut laws: Vec<_> = found.map(|r| r.law.clone()).filter(law).collect();
    laws.sort();
    laws.dedup();
    laws
}

#[test]
fn the_check_of_a_model_finds_the_geodesic_beam_exactly_objective() {
    let exact = ["objective", "the same in the other chart"];
    assert_eq!(laws_found(Interpolation::Geodesic), exact);
    let limits = exact.map(|law| format!("{law} in the limit of small strains"));
    assert_eq!(laws_found(Interpolation::Total), limits);
}

/// A straight element of unit length rolled up by α about an axis across: curvature α.
fn rolled(alpha: f64) -> [f64; 12] {
    let e = Vector3::new(0.0, 0.6, 0.8) * alpha;
    let mut x = [0.0; 12];
    x[9..].copy_from_slice(e.as_slice());
    x
}

#[test]
fn nodes_may_turn_against_each_other_by_less_than_one_turn() {
    let positions = [Vector3::zeros(), Vector3::x()];
    let section = Section::new(Matrix6::identity()).unwrap();
    let beam = Interpolation::Geodesic.beam(&positions, &|_| Matrix3::identity(), &section);
    let beam = beam.unwrap();
    // Through half a turn without a jump.
    for alpha in [0.0, 1e-9, 1.0, PI - 1e-6, PI, PI + 1e-6, 5.0, TAU - 0.01] {
        let x = rolled(alpha);
        let mut states = Vec::new();
        let abilities = beam.abilities();
        abilities.section_states(&moving(&x, &[], &[]), &mut states);
        let K = states[0].K;
        let error = (K - Vector3::new(0.0, 0.6, 0.8) * alpha).norm();
        assert!(error < 1e-12, "{alpha}: {K:?}");
    }
    // Both in one chart, and apart by almost a whole turn.
    let mut x = rolled(3.13);
    x[3..6].copy_from_slice((Vector3::new(0.0, 0.6, 0.8) * -3.1528).as_slice());
    let mut r = [0.0; 12];
    let mut out = response(&mut r);
    let refused = beam.evaluate(&moving(&x, &[], &[]), &mut out).unwrap_err();
    let DomainError::Beyond { margin, .. } = refused else {
        panic!("{refused}");
    };
    assert!((margin - (TAU - 6.2828)).abs() < 1e-3, "{margin}");
}
