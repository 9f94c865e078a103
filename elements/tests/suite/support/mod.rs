//! Sections, joints, an element and the reference file, shared by the tests.

#[path = "../../../../examples/elements/elastic_joint.rs"]
pub mod elastic_joint;
pub mod everything;
#[path = "../../../../examples/elements/gravity.rs"]
pub mod gravity;
#[path = "../../../../examples/elements/polynomial_spring.rs"]
pub mod polynomial_spring;
#[allow(
    dead_code,
    reason = "one of its two measures of strain is for tests of equilibria"
)]
#[path = "../../../../examples/elements/strain_beam.rs"]
pub mod strain_beam;

pub use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, SMatrix, SVector, Vector3, Vector6};
pub use pullback_conformance::{self as check, InCharts, ModelOptions, Random, Report};
pub use pullback_elements::{beam::*, body::*, element::*, energy::*, inertia::*, joint::*};
pub use pullback_elements::{load::*, model::*, spring::*, time::*};
pub use pullback_manifold::{domain::*, implicit::*, jet::*, map::*, scalar::*, so3, system::*};
pub use serde_json::Value;
pub use std::f64::consts::{PI, TAU};

/// What is refused, row by row, and with which words.
macro_rules! refused {
    ($($outcome:expr => $message:expr),* $(,)?) => {$(
        let Err(error) = $outcome else {
            panic!("accepted: {}", stringify!($outcome));
        };
        assert_eq!(error.to_string(), $message);
    )*};
}
pub(crate) use refused;

/// A diagonal section of which no two stiffnesses are equal.
pub fn section() -> Section {
    Section::diagonal(100.0, [40.0, 50.0], 3.0, [5.0, 7.0]).unwrap()
}

/// A section in which everything couples: an axis away from centroid and shear centre, and more.
pub fn coupled() -> Section {
    let mut C = Matrix6::from_diagonal(&[100.0, 40.0, 50.0, 30.0, 50.0, 70.0].into());
    for i in 0..6 {
        for j in 0..i {
            let c = ((3 * i + 7 * j) as f64).sin() * 8.0;
            C[(i, j)] = c;
            C[(j, i)] = c;
        }
    }
    Section::new(C).unwrap()
}

/// An inertia per length in which everything couples: mass centre off the axis, products.
pub fn eccentric() -> Inertia {
    let J = Matrix3::new(0.9, 0.1, -0.05, 0.1, 0.7, 0.02, -0.05, 0.02, 0.5);
    let inertia = Inertia::about_centre(2.3, Vector3::new(0.02, 0.3, -0.2), J);
    inertia.checked().unwrap()
}

/// The section in which everything couples, with such an inertia.
pub fn massive() -> Section {
    coupled().with_inertia(eccentric()).unwrap()
}

/// Sections with and without coupling, mass and damping.
pub fn sections() -> [Section; 6] {
    let centred = Matrix3::from_diagonal(&[3.0, 1.0, 2.0].into());
    [
        section(),
        coupled(),
        massive(),
        section().with_mass(2.0, centred).unwrap(),
        massive().with_damping(DAMPING).unwrap(),
        section().with_damping(DAMPING).unwrap(),
    ]
}

/// Positions on a quarter of a helix, equidistant in the parameter.
pub fn helix(nodes: usize) -> Vec<Vector3<f64>> {
    (0..nodes)
        .map(|i| {
            let u = 1.2 * i as f64 / (nodes - 1) as f64;
            Vector3::new(u.cos(), u.sin(), 0.4 * u)
        })
        .collect()
}

/// The frame of a section there.
pub fn along_helix(xi: f64) -> Matrix3<f64> {
    let u = 0.6 * (1.0 + xi);
    frame_along(
        &Vector3::new(-u.sin(), u.cos(), 0.4),
        Some(&Vector3::new(0.3 + u, 0.2, 0.9)),
    )
}

pub const DAMPING: Damping = Damping {
    mass: 0.7,
    stiffness: 0.04,
};

/// Where a spring or a bushing is fixed to its two nodes.
pub fn positions() -> [Vector3<f64>; 2] {
    [Vector3::new(0.2, -0.3, 0.5), Vector3::new(1.1, 0.4, -0.2)]
}

/// The axes of a bushing.
pub fn axes() -> Matrix3<f64> {
    so3::rotation(&Vector3::new(0.3, 0.8, -0.5))
}

/// A symmetric positive definite 6×6 matrix in which everything couples.
pub fn full(shift: f64) -> Matrix6<f64> {
    let A = Matrix6::from_fn(|i, j| ((5 * i + 3 * j) as f64 + shift).sin());
    A * A.transpose() + Matrix6::identity() * 0.5
}

/// The law of a spring and a damper at a coordinate.
pub const LAW: CoordinateLaw = CoordinateLaw {
    k: 2.0,
    k3: 0.7,
    c: 0.4,
    x0: 0.3,
};

pub fn sine(amplitude: f64) -> Sine {
    Sine {
        amplitude,
        omega: 2.3,
        phase: 0.4,
        offset: 0.1,
    }
}

pub fn reference(section: &str) -> Vec<Value> {
    let text = include_str!("../../../../tests/reference/tensors.json");
    let data: Value = serde_json::from_str(text).expect("valid JSON");
    data[section].as_array().expect("rows").clone()
}

pub fn numbers(v: &Value) -> Vec<f64> {
    let list = v.as_array().expect("list");
    list.iter().map(|x| x.as_f64().expect("number")).collect()
}

pub fn vector(v: &Value) -> DVector<f64> {
    DVector::from_vec(numbers(v))
}

pub fn matrix(v: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = v.as_array().expect("rows").iter().map(numbers).collect();
    DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
}

/// Rigid link: d_s = d_m + (R_m − I) c(t), Ψ_s = Ψ_m, with an offset that grows.
#[derive(Clone)]
pub struct GrowingOffset(pub [f64; 3]);

impl Map<6, 6> for GrowingOffset {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, 6>) -> SVector<S, 6> {
        let psi = Vector3::new(q[3], q[4], q[5]);
        let c = Vector3::from(self.0).map(S::constant);
        let u = so3::rotation(&psi) * c * (t * t + 1.0) - c;
        SVector::<S, 6>::new(q[0] + u.x, q[1] + u.y, q[2] + u.z, q[3], q[4], q[5])
    }
}

/// The frame of its parent, with its rotation in the other chart.
#[derive(Clone)]
pub struct Twin;

impl Map<6, 6> for Twin {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 6>) -> SVector<S, 6> {
        let psi = so3::complement(&Vector3::new(q[3], q[4], q[5]));
        SVector::<S, 6>::new(q[0], q[1], q[2], psi.x, psi.y, psi.z)
    }
}

pub fn straight(b: &ModelBuilder, ends: [NodeId; 2]) -> StraightLine {
    StraightLine::new(b.position(ends[0]), b.position(ends[1]))
}

pub fn line(elements: usize, order: usize) -> BeamLine {
    BeamLine {
        order,
        ..BeamLine::new(elements, section())
    }
}

/// Elements in a straight line between two nodes; the nodes of the line.
pub fn lay(
    b: &mut ModelBuilder,
    name: &str,
    ends: [NodeId; 2],
    elements: usize,
    order: usize,
    section: Section,
) -> Vec<NodeId> {
    lay_twisted(b, name, ends, [elements, order], section, 0.0)
}

/// The same of so many elements of an order, twisted by an angle from end to end.
pub fn lay_twisted(
    b: &mut ModelBuilder,
    name: &str,
    ends: [NodeId; 2],
    [elements, order]: [usize; 2],
    section: Section,
    twist: f64,
) -> Vec<NodeId> {
    let axis = StraightLine {
        twist,
        ..straight(b, ends)
    };
    let line = BeamLine {
        section,
        ..line(elements, order)
    };
    b.line(name, &axis, ends, &line).unwrap().nodes
}

/// A line of one element between two named nodes.
pub fn beam(b: &mut ModelBuilder, name: &str, ends: [NodeId; 2]) {
    lay(b, name, ends, 1, 1, section());
}

/// Two nodes a metre apart and a beam.
pub fn simple() -> (ModelBuilder, [NodeId; 2]) {
    let mut b = ModelBuilder::new();
    let ends = [
        b.node("a", [0.0; 3]).unwrap(),
        b.node("b", [1.0, 0.0, 0.0]).unwrap(),
    ];
    beam(&mut b, "beam", ends);
    (b, ends)
}

/// A point mass of one at a node.
pub fn mass(b: &mut ModelBuilder, node: NodeId) {
    let mass = PointMass::new(1.0).unwrap();
    b.element("mass", mass, &[node]).unwrap();
}

/// An L of two lines, quadratic and linear, with nodal loads of all kinds at its tip and a line load.
pub fn frame_model(b: &mut ModelBuilder, inertia: Option<Inertia>) -> [NodeId; 3] {
    let root = b.node("root", [0.0; 3]).unwrap();
    let corner = b.node("corner", [1.0, 0.2, 0.0]).unwrap();
    let tip = b.node("tip", [1.0, 1.0, 0.5]).unwrap();
    for (name, ends, order, mut section) in [
        ("arm", [root, corner], 2, coupled()),
        ("leg", [corner, tip], 1, section()),
    ] {
        if let Some(inertia) = inertia {
            section = section.with_inertia(inertia).unwrap();
        }
        lay_twisted(b, name, ends, [2, order], section, 0.3);
    }
    for (which, k) in [
        (LoadKind::FollowerForce, 0.0),
        (LoadKind::SpatialMoment, 1.0),
        (LoadKind::DeadForce, 2.0),
        (LoadKind::FollowerMoment, 3.0),
    ] {
        let load = NodalLoad::new(which, [1.0 + k, -2.0, 0.5 * k], sine(1.0 + k));
        b.element(format!("load {k}"), load, &[tip]).unwrap();
    }
    let first = [corner, b.find("leg/1").unwrap()];
    let positions = first.map(|n| b.position(n));
    let wind = LineLoad::new(&positions, [0.0, 2.0, 1.0], true, sine(2.0)).unwrap();
    b.element("wind", wind, &first).unwrap();
    [root, corner, tip]
}

/// Any number of coordinates, no force.
pub struct Idle(pub usize);

impl Element for Idle {
    fn dim(&self) -> usize {
        self.0
    }

    fn evaluate(&self, _: &Motion<'_>, _: &mut Response<'_>) -> Result<(), DomainError> {
        Ok(())
    }
}

/// A state of a model.
pub fn point<'a>(t: f64, [q, v, a]: [&'a [f64]; 3]) -> Point<'a> {
    Point { t, q, v, a }
}

pub fn weights(K: f64, C: f64, M: f64) -> Weights {
    Weights { K, C, M }
}

/// A motion at t = 0, at rest where it has neither rates nor accelerations.
pub fn moving<'a>(x: &'a [f64], v: &'a [f64], a: &'a [f64]) -> Motion<'a> {
    Motion {
        t: 0.0,
        inputs: &[],
        x,
        v,
        a,
        previous: None,
    }
}

/// Residual, K, C and M of an element at a motion; frames in their charts.
pub fn forces(element: &dyn Element, at: &Motion<'_>) -> Result<Answer, DomainError> {
    let n = element.dim();
    let (mut r, zeros) = (DVector::zeros(n), || DMatrix::zeros(n, n));
    let [mut K, mut C, mut M] = [zeros(), zeros(), zeros()];
    let mut out = Response {
        r: r.as_mut_slice(),
        K: Some(K.as_mut_slice()),
        C: Some(C.as_mut_slice()),
        M: Some(M.as_mut_slice()),
        r_t: None,
    };
    match element.properties().reads_poses {
        true => InCharts(element).evaluate(at, &mut out)?,
        false => element.evaluate(at, &mut out)?,
    }
    Ok((r, [K, C, M]))
}

type Answer = (DVector<f64>, [DMatrix<f64>; 3]);

/// Its residual alone, without accelerations.
pub fn residual(element: &dyn Element, x: &[f64], v: &[f64]) -> Result<DVector<f64>, DomainError> {
    Ok(forces(element, &moving(x, v, &vec![0.0; v.len()]))?.0)
}

pub fn seeded(seed: u64) -> ModelOptions {
    ModelOptions {
        seed,
        ..ModelOptions::default()
    }
}

/// The laws of a model, at states of a seed.
pub fn checked(b: ModelBuilder, seed: u64) -> Report {
    check::model(&mut Context::new(b.build().unwrap()), &seeded(seed))
}

/// What fails: components and their laws.
pub fn failures(report: &Report) -> Vec<[&str; 2]> {
    let rows = report.failures().into_iter();
    rows.map(|r| [&r.component[..], &r.law[..]]).collect()
}

/// Spatial force and moment of the covector `r` of a node at `x`: R T⁻ᵀ = T⁻¹.
pub fn spatial(x: &[f64], r: &[f64]) -> [Vector3<f64>; 2] {
    let [psi, force, f] = [&x[3..6], &r[..3], &r[3..6]].map(Vector3::from_column_slice);
    [force, so3::tangent_inverse(&psi) * f]
}
