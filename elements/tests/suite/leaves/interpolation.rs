//! What sets the two interpolations of rotations apart: the geodesic one is a function of relative
//! rotations, the total one is not.

use crate::support::*;
use pullback_manifold::quotients::TangentQuotients;
use std::collections::BTreeSet;

/// The energies of the two-node geodesic beam: nothing is shared with the element.
struct Energies {
    positions: [Vector3<f64>; 2],
    R0: Matrix3<f64>,
    section: Section,
}

fn triple<S: Scalar>(y: &SVector<S, 12>, i: usize) -> Vector3<S> {
    Vector3::new(y[i], y[i + 1], y[i + 2])
}

impl Energies {
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

    fn kinetic(&self, y: &SVector<f64, 12>, v: &SVector<f64, 12>) -> f64 {
        let Inertia { mass, S: first, J } = self.section.inertia.rotated(&self.R0);
        let node = |k: usize| {
            let psi = triple(y, 6 * k + 3);
            let Omega = so3::tangent(&psi) * triple(v, 6 * k + 3);
            let lever = so3::rotation(&psi) * Omega.cross(&first);
            (triple(v, 6 * k), Omega, lever)
        };
        let nodes = [node(0), node(1)];
        let mut sum = 0.0;
        for i in 0..2 {
            for j in 0..2 {
                let NN = self.length() / if i == j { 3.0 } else { 6.0 };
                let ((vi, Oi, _), (vj, Oj, lj)) = (&nodes[i], &nodes[j]);
                sum += (vi.dot(vj) * (0.5 * mass) + vi.dot(lj) + Oi.dot(&(J * Oj)) * 0.5) * NN;
            }
        }
        sum
    }

    fn dissipation(&self, y: &SVector<f64, 12>, v: &SVector<f64, 12>) -> f64 {
        let Damping { mass, stiffness } = self.section.damping;
        let viscous = self.quadratic(&rate(|y| self.strains(y), y, v));
        viscous * stiffness + self.kinetic(y, v) * mass
    }
}

/// Forces follow from energies by the laws of elements, but for those of damping.
#[test]
fn the_element_has_the_energies_of_its_definition() {
    let positions = [Vector3::new(0.2, -0.1, 0.3), Vector3::new(0.9, 0.5, 0.7)];
    let R0 = frame_along(
        &(positions[1] - positions[0]),
        Some(&Vector3::new(0.1, 0.9, 0.3)),
    );
    let beam = |section| Beam::<2, Geodesic<2>>::new(&positions, &|_| R0, &section).unwrap();
    let section = massive().with_damping(DAMPING).unwrap();
    let [elastic, damped] = [beam(massive()), beam(section)];
    let energies = Energies {
        positions,
        R0,
        section,
    };
    let mut random = Random::new(7);
    for _ in 0..8 {
        let [y, v] = [0.3, 1.5].map(|size| random.vector::<12>() * size);
        let (x, v_slice) = (y.as_slice(), v.as_slice());
        let (beam, at) = (damped.abilities(), moving(x, v_slice, &[0.0; 12]));
        let [U, T] = [
            energies.quadratic(&energies.strains(&y)),
            energies.kinetic(&y, &v),
        ];
        let found = beam.energy(&at);
        assert!((found - U).abs() < 1e-12 * U, "{found} {U}");
        let found = beam.kinetic_energy(&at).unwrap();
        assert!((found - T).abs() < 1e-12 * T, "{found} {T}");
        // The derivative of a quadratic form by its difference.
        let force = SVector::<f64, 12>::from_fn(|i, _| {
            let e = SVector::ith(i, 1.0);
            let ends = [v - e, v + e].map(|v| energies.dissipation(&y, &v));
            0.5 * (ends[0] - ends[1])
        });
        let [with, without] = [&damped, &elastic].map(|beam| residual(beam, x, v_slice).unwrap());
        let off = (with - without - force).norm();
        assert!(off < 1e-12 * force.norm(), "{off:e} {force}");
    }
}

/// Coordinates of the nodes of an element after the rotation of space R(turn), with all rotation vectors on the
/// branch of `turn` or in the other chart.
fn turned(positions: &[Vector3<f64>], x: &[f64], turn: &Vector3<f64>, other: bool) -> Vec<f64> {
    let Q = so3::rotation(turn);
    let node = |(X, x): (&Vector3<f64>, &[f64])| {
        let [d, psi] = [&x[..3], &x[3..]].map(Vector3::from_column_slice);
        let psi = so3::log_quaternion(&so3::quaternion(turn).product(&so3::quaternion(&psi)));
        let psi = if other { so3::complement(&psi) } else { psi };
        [Q * (X + d) - X, psi]
    };
    let nodes = positions.iter().zip(x.chunks(6)).flat_map(node);
    nodes.flat_map(<[f64; 3]>::from).collect()
}

/// Largest difference between the sections of a beam, and forces of a follower load on it, at x and at y,
/// turned by Q from x.
fn gap(beam: &dyn Element, wind: &LineLoad, [x, y]: [&[f64]; 2], Q: &Matrix3<f64>) -> f64 {
    let [(s, f), (t, g)] = [x, y].map(|x| {
        let (at, mut states) = (moving(x, &[], &[]), Vec::new());
        beam.abilities().section_states(&at, &mut states);
        (states, forces(wind, &at).unwrap().0)
    });
    let mut most = 0.0_f64;
    let mut compare = |a: Vector3<f64>, b: Vector3<f64>| most = most.max((a - b).norm() / b.norm());
    for (s, t) in s.iter().zip(&t) {
        compare(s.Gamma, t.Gamma);
        compare(s.K, t.K);
        compare(s.N, t.N);
        compare(s.M, t.M);
        compare(Q * s.position, t.position);
        for k in 0..3 {
            compare(Q * s.frame.column(k), t.frame.column(k).into());
        }
    }
    for i in (0..x.len()).step_by(6) {
        compare(Q * f.fixed_rows::<3>(i), g.fixed_rows::<3>(i).into());
    }
    most
}

/// Section states are no part of the laws of an element, and a load on a line declares no objectivity.
#[test]
fn sections_and_follower_loads_turn_with_a_geodesic_element() {
    let mut random = Random::new(41);
    let turn = Vector3::new(1.0, -1.4, 1.1);
    let Q = so3::rotation(&turn);
    for count in 2..=4 {
        let positions = helix(count);
        for interpolation in [Interpolation::Geodesic, Interpolation::Total] {
            let beam = interpolation
                .beam(&positions, &along_helix, &coupled())
                .unwrap();
            let wind = LineLoad::new(&positions, [0.3, 1.0, -0.4], true, Constant(1.0)).unwrap();
            let wind = wind.with_interpolation(interpolation);
            for _ in 0..10 {
                let node = |_| [0.1, 0.5].map(|size| random.vector::<3>() * size);
                let nodes = (0..count).flat_map(node);
                let x: Vec<f64> = nodes.flat_map(<[f64; 3]>::from).collect();
                for other in [false, true] {
                    let y = turned(&positions, &x, &turn, other);
                    let gap = gap(&*beam, &wind, [&x, &y], &Q);
                    let found = (gap < 1e-12, gap > 1e-4);
                    let geodesic = interpolation == Interpolation::Geodesic;
                    assert_eq!(found, (geodesic, !geodesic), "{count} nodes: {gap:e}");
                }
            }
        }
    }
}

/// The laws of objectivity and of charts that the check of a model finds for its beams.
fn laws_found(interpolation: Interpolation, order: usize) -> Vec<String> {
    let mut b = ModelBuilder::new();
    let ends = [[0.0; 3], [1.0, 0.2, 0.1]];
    let ends = [b.node("a", ends[0]).unwrap(), b.node("b", ends[1]).unwrap()];
    let line = BeamLine {
        section: massive().with_damping(DAMPING).unwrap(),
        interpolation,
        ..line(1, order)
    };
    let axis = straight(&b, ends);
    b.line("beam", &axis, ends, &line).unwrap();
    let report = checked(b, 0);
    report.assert();
    let rows = report.rows().iter();
    let found = rows.filter(|r| r.component.contains("beam"));
    let law = |l: &String| l.starts_with("objective") || l.starts_with("the same in the other");
    let laws: BTreeSet<_> = found.map(|r| r.law.clone()).filter(law).collect();
    laws.into_iter().collect()
}

#[test]
fn the_check_of_a_model_finds_the_geodesic_beam_exactly_objective() {
    let exact = ["objective", "the same in the other chart"];
    let limits = exact.map(|law| format!("{law} in the limit of small strains"));
    for order in 1..=3 {
        assert_eq!(laws_found(Interpolation::Geodesic, order), exact);
        assert_eq!(laws_found(Interpolation::Total, order), limits);
    }
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
    let refused = forces(&*beam, &moving(&x, &[], &[])).unwrap_err();
    let DomainError::Beyond { margin, .. } = refused else {
        panic!("{refused}");
    };
    assert!((margin - (LARGEST_ANGLE - 6.2828)).abs() < 1e-3, "{margin}");
}
