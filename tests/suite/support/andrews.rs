//! Andrews' squeezer mechanism: seven bodies, three loops, one coordinate (IFToMM benchmark A03; IVP
//! test set, Mazzia & Magherini 2008, part II-9, whose names the parameters have).

#![allow(non_snake_case, dead_code, clippy::unwrap_used)]

use super::dynamics::*;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use pullback::elements::body::RigidBody;
use pullback::elements::joint::Revolute;
use pullback::elements::load::CoordinateForce;
use pullback::elements::model::{Context, Dof, ModelBuilder, NodeId};
use pullback::elements::spring::AxialSpring;
use pullback::elements::time::Constant;
use pullback::integrators::dynamics::{DynamicOptions, Progress, Scheme};
use pullback::manifold::implicit::{Choice, Implicit, ImplicitMap};
use pullback::manifold::jet::Moving;
use pullback::manifold::map::{Linear, Map};
use pullback::manifold::scalar::Scalar;
use pullback::manifold::system::{Quantity, System};
use pullback::studies::gallery::{self, CaseRow};

// Lengths in m, masses in kg, moments of inertia in kg m².
pub const A: [f64; 3] = [-0.06934, -0.00227, 0.0];
pub const B: [f64; 3] = [-0.03635, 0.03273, 0.0];
pub const C: [f64; 3] = [0.014, 0.072, 0.0];
pub const MASSES: [f64; 7] = [0.04325, 0.00365, 0.02373, 0.00706, 0.0705, 0.00706, 0.05498];
pub const INERTIAS: [f64; 7] = [
    2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5,
];
pub const D: f64 = 0.028;
pub const DA: f64 = 0.0115;
pub const E: f64 = 0.02;
pub const EA: f64 = 0.01421;
pub const RR: f64 = 0.007;
pub const RA: f64 = 0.00092;
pub const SS: f64 = 0.035;
pub const SA: f64 = 0.01874;
pub const SB: f64 = 0.01043;
pub const SC: f64 = 0.018;
pub const SD: f64 = 0.02;
pub const TA: f64 = 0.02308;
pub const TB: f64 = 0.00916;
pub const U: f64 = 0.04;
pub const UA: f64 = 0.01228;
pub const UB: f64 = 0.00449;
pub const ZF: f64 = 0.02;
pub const ZT: f64 = 0.04;
pub const FA: f64 = 0.01421;
pub const STIFFNESS: f64 = 4530.0;
pub const REST: f64 = 0.07785;
pub const MOMENT: f64 = 0.033;

/// β, Θ, γ, Φ, δ, Ω, ε at the start.
pub const START: [f64; 7] = [
    -0.06171389001427645,
    0.0,
    0.45527981916307037,
    0.22266839016588588,
    0.48736497954384256,
    -0.22266839016588588,
    1.2305474445498212,
];

pub const NAMES: [&str; 7] = ["beta", "theta", "gamma", "phi", "delta", "omega", "epsilon"];

/// The point P, at which four bars meet, seen from its four sides.
#[derive(Clone, Copy, Debug)]
pub struct Squeezer;

impl Implicit<7, 6> for Squeezer {
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, 7>) -> SVector<S, 6> {
        let [be, th, ga, ph, de, om, ep] = *x.as_ref();
        let px = be.cos() * RR - (be + th).cos() * D;
        let py = be.sin() * RR - (be + th).sin() * D;
        SVector::<S, 6>::new(
            px - ga.sin() * SS - B[0],
            py + ga.cos() * SS - B[1],
            px - (ph + de).sin() * E - de.cos() * ZT - A[0],
            py + (ph + de).cos() * E - de.sin() * ZT - A[1],
            px - (om + ep).cos() * ZF - ep.sin() * U - A[0],
            py - (om + ep).sin() * ZF + ep.cos() * U - A[1],
        )
    }

    fn coordinate(&self, k: usize) -> String {
        NAMES[k].to_owned()
    }
}

/// The loops in coordinates of a choice.
pub fn loops(choice: Choice) -> ImplicitMap {
    ImplicitMap::of(Squeezer, 1, 0.0, START, choice).unwrap()
}

fn squeezer(map: &ImplicitMap) -> (Context, NodeId) {
    let mut b = ModelBuilder::new();
    let q = b.coordinates("q", &[Quantity::Angle]).unwrap();
    let x = b
        .mapped_coordinates("x", &[Quantity::Angle; 7], Box::new(map.clone()), &[q])
        .unwrap();
    let angles: [NodeId; 7] = std::array::from_fn(|k| {
        let pick = Linear::<7, 1>::pick(k, 0.0).boxed();
        b.mapped_coordinates(NAMES[k], &[Quantity::Angle], pick, &[x])
            .unwrap()
    });
    let ground = b.node("ground", [0.0; 3]).unwrap();
    b.support(ground, &Dof::ALL);
    // Bodies as they lie where all angles are zero.
    let along = |p: [f64; 3], x: f64, y: f64| [p[0] + x, p[1] + y, 0.0];
    let mut bar = |k: usize, on: NodeId, position: [f64; 3], angle: usize, center: [f64; 2]| {
        let pin = b.offset(format!("pin {k}"), on, position).unwrap();
        let hinge = Revolute::new([0.0, 0.0, 1.0]).unwrap();
        let frame = b
            .add_joint_frame(format!("K{k}"), pin, hinge, &[angles[angle]])
            .unwrap();
        let J = Matrix3::from_diagonal(&Vector3::new(0.5, 0.5, 1.0)) * INERTIAS[k - 1];
        let body = RigidBody::new(MASSES[k - 1], J, Vector3::new(center[0], center[1], 0.0));
        b.element(format!("bar {k}"), body.unwrap(), &[frame])
            .unwrap();
        frame
    };
    let K1 = bar(1, ground, [0.0; 3], 0, [RA, 0.0]);
    bar(2, K1, [RR, 0.0, 0.0], 1, [-DA, 0.0]);
    let K3 = bar(3, ground, B, 2, [SB, -SA]);
    let K5 = bar(5, ground, A, 4, [TA, TB]);
    bar(4, K5, along(A, ZT, 0.0), 3, [0.0, -(E - EA)]);
    let K7 = bar(7, ground, A, 6, [UA, UB]);
    bar(6, K7, along(A, 0.0, -U), 5, [ZF - FA, 0.0]);
    let end = b.offset("spring end", K3, along(B, SD, -SC)).unwrap();
    let foot = b.offset("spring foot", ground, C).unwrap();
    let spring = AxialSpring::new(&[b.position(end), b.position(foot)], STIFFNESS, 0.0).unwrap();
    let spring = spring.with_rest_length(REST).unwrap();
    b.element("spring", spring, &[end, foot]).unwrap();
    b.element(
        "motor",
        CoordinateForce::new(Constant(MOMENT)),
        &[angles[0]],
    )
    .unwrap();
    (Context::new(b.build().unwrap()), x)
}

pub const END: f64 = 0.03;

/// Values, rates and accelerations of the seven angles.
pub type Angles = [[f64; 7]; 3];

pub struct Run {
    pub end: Angles,
    pub residual: f64,
    pub changes: Vec<String>,
    pub progress: Progress,
}

pub fn run(map: &ImplicitMap, steps: usize) -> Run {
    let (mut context, x) = squeezer(map);
    let zero = vec![0.0; context.pattern().dim()];
    let mut options: DynamicOptions = tight(Scheme::default(), END, END / steps as f64);
    options.newton.absolute = 1e-18;
    options.newton.relative = 1e-14;
    options.energies = true;
    let mut out = Run {
        end: [[0.0; 7]; 3],
        residual: 0.0,
        changes: Vec::new(),
        progress: Progress::default(),
    };
    let (mut note, mut residual, mut changes) = (context.describe(x), 0.0_f64, Vec::new());
    let mut end = [[0.0; 7]; 3];
    out.progress = observed(&mut context, [&zero, &zero], &options, &mut |context, _| {
        let motion: [[f64; 3]; 7] =
            std::array::from_fn(|k| context.coordinate_motion(x, k).unwrap());
        end = std::array::from_fn(|d| motion.map(|x| x[d]));
        residual = residual.max(Squeezer.h(0.0, &end[0].into()).amax());
        let now = context.describe(x);
        if now != note {
            changes.extend(now.clone());
            note = now;
        }
    });
    (out.end, out.residual, out.changes) = (end, residual, changes);
    out
}

/// What the gallery compares with, and its rows.
pub fn reference() -> (Angles, Vec<CaseRow>) {
    let rows = gallery::run(&["squeezer".to_owned()], None, &mut |_| {}).unwrap();
    let published = ["angle", "rate", "acceleration"].map(|what| {
        let rows = rows.iter().filter(|row| row.quantity.starts_with(what));
        let values: Vec<f64> = rows.map(|row| row.published).collect();
        values.try_into().unwrap()
    });
    (published, rows)
}

/// Largest difference of values (rates, accelerations) relative to the largest of them.
pub fn gap(found: &[f64; 7], exact: &[f64; 7]) -> f64 {
    let size = exact.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let gaps = found.iter().zip(exact).map(|(a, b)| (a - b).abs() / size);
    gaps.fold(0.0, f64::max)
}

pub fn errors(found: &Angles, exact: &Angles) -> [f64; 3] {
    std::array::from_fn(|d| gap(&found[d], &exact[d]))
}

/// Accelerations at given angles and rates from the equations of the IVP test set, with
/// multipliers: M q̈ + Gᵀλ = f, G q̈ = −γ. Nothing here comes from bodies, joints or charts.
pub fn accelerations(q: &[f64; 7], v: &[f64; 7]) -> [f64; 7] {
    let [_, th, ga, ph, _, om, _] = *q;
    let [bep, thp, _, php, dep, omp, epp] = *v;
    let (m, I) = (MASSES, INERTIAS);
    let (e, f) = (E - EA, ZF - FA);
    let mut K = SMatrix::<f64, 13, 13>::zeros();
    let square = |a: f64, b: f64| a * a + b * b;
    K[(0, 0)] =
        m[0] * RA * RA + m[1] * (RR * RR - 2.0 * DA * RR * th.cos() + DA * DA) + I[0] + I[1];
    K[(1, 0)] = m[1] * (DA * DA - DA * RR * th.cos()) + I[1];
    K[(1, 1)] = m[1] * DA * DA + I[1];
    K[(2, 2)] = m[2] * square(SA, SB) + I[2];
    K[(3, 3)] = m[3] * e * e + I[3];
    K[(4, 3)] = m[3] * (e * e + ZT * e * ph.sin()) + I[3];
    K[(4, 4)] =
        m[3] * (ZT * ZT + 2.0 * ZT * e * ph.sin() + e * e) + m[4] * square(TA, TB) + I[3] + I[4];
    K[(5, 5)] = m[5] * f * f + I[5];
    K[(6, 5)] = m[5] * (f * f - U * f * om.sin()) + I[5];
    K[(6, 6)] =
        m[5] * (f * f - 2.0 * U * f * om.sin() + U * U) + m[6] * square(UA, UB) + I[5] + I[6];
    let arm = [SD * ga.cos() + SC * ga.sin(), SD * ga.sin() - SC * ga.cos()];
    let [x, y] = [arm[0] + B[0] - C[0], arm[1] + B[1] - C[1]];
    let length = x.hypot(y);
    let pull = -STIFFNESS * (length - REST) / length;
    let forces = [
        MOMENT - m[1] * DA * RR * thp * (thp + 2.0 * bep) * th.sin(),
        m[1] * DA * RR * bep * bep * th.sin(),
        pull * (y * arm[0] - x * arm[1]),
        m[3] * ZT * e * dep * dep * ph.cos(),
        -m[3] * ZT * e * php * (php + 2.0 * dep) * ph.cos(),
        -m[5] * U * f * epp * epp * om.cos(),
        m[5] * U * f * omp * (omp + 2.0 * epp) * om.cos(),
    ];
    let along = |rate: &dyn Fn(usize) -> f64| {
        let x = SVector::<Moving<0>, 7>::from_fn(|k, _| Moving::<0>::given([q[k], rate(k), 0.0]));
        Squeezer.h(Moving::<0>::constant(0.0), &x)
    };
    let mut b = SVector::<f64, 13>::zeros();
    for j in 0..7 {
        b[j] = forces[j];
        let column = along(&|k| f64::from(u8::from(k == j)));
        for i in 0..6 {
            K[(7 + i, j)] = column[i].x[1];
        }
    }
    let bend = along(&|k| v[k]);
    for i in 0..6 {
        b[7 + i] = -bend[i].x[2];
    }
    K.fill_upper_triangle_with_lower_triangle();
    let solution = K.lu().solve(&b).unwrap();
    std::array::from_fn(|k| solution[k])
}

/// Angles, rates and accelerations at the end by the midpoint rule with 2, 4 … 16 substeps in each step, extrapolated (Gragg).
pub fn by_midpoints(steps: u32) -> Angles {
    type State = SVector<f64, 14>;
    let rates = |z: &State| -> State {
        let part = |from: usize| std::array::from_fn(|k| z[from + k]);
        let (q, v) = (part(0), part(7));
        let a = accelerations(&q, &v);
        State::from_fn(|k, _| if k < 7 { v[k] } else { a[k - 7] })
    };
    let H = END / f64::from(steps);
    let step = |z: State| {
        let mut row: Vec<State> = Vec::new();
        for k in 1..=8 {
            let h = H / f64::from(2 * k);
            let (mut before, mut now) = (z, z + rates(&z) * h);
            for _ in 1..2 * k {
                (before, now) = (now, before + rates(&now) * (2.0 * h));
            }
            // Errors have even powers of h.
            let mut next = vec![(now + before + rates(&now) * h) * 0.5];
            for (j, coarse) in (1..k).zip(&row) {
                let ratio = f64::from(k) / f64::from(k - j);
                let fine = next[next.len() - 1];
                next.push(fine + (fine - coarse) / (ratio * ratio - 1.0));
            }
            row = next;
        }
        row[row.len() - 1]
    };
    let start = State::from_fn(|k, _| if k < 7 { START[k] } else { 0.0 });
    let end = (0..steps).fold(start, |z, _| step(z));
    let part = |from: usize| std::array::from_fn(|k| end[from + k]);
    let (q, v) = (part(0), part(7));
    [q, v, accelerations(&q, &v)]
}

/// Errors over steps of every choice of coordinates.
pub fn assert_choices(steps: [usize; 3], reference: &Angles) {
    for (choice, first) in [
        (Choice::Split, Some(0)),
        (Choice::Split, Some(1)),
        (Choice::Tangent, None),
    ] {
        let map = match first {
            Some(k) => loops(choice).with_independent(&[k]).unwrap(),
            None => loops(choice),
        };
        let runs = steps.map(|n| run(&map, n));
        for run in &runs {
            let defect = run.progress.summary.energy.unwrap().largest_defect;
            println!(
                "{:?}: {:?}, errors {:?}, energy {defect:.1e}, residual {:.1e}",
                map.describe(),
                run.changes,
                errors(&run.end, reference),
                run.residual
            );
            assert!(run.residual < 1e-15, "{:e}", run.residual);
        }
        let errors: Vec<Vec<f64>> = runs
            .iter()
            .map(|run| {
                let mut errors = errors(&run.end, reference).to_vec();
                errors.push(run.progress.summary.energy.unwrap().largest_defect);
                errors
            })
            .collect();
        let names = ["angles", "rates", "accelerations", "energy"];
        assert_slopes("squeezer", &names, &errors, 2.0, 0.1);
    }
}
