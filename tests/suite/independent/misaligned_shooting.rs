//! Bauchau's linkage with its axis 5 degrees off, in equilibrium: the numbers that the gallery compares with.
//!
//! Three rods after Reissner, each an initial value problem for position, rotation and moment along it (the force
//! is constant where nothing acts between the ends), shot from A over B to C and from D to C. Unknown are the
//! force and the moment at A and at D and the angles of the joints there; what is left open at B and C is to
//! vanish. Nothing is shared with the program.

use crate::support::independent::{assert_published, rows};
use crate::support::prelude::*;
use nalgebra::{Rotation3, SMatrix};

/// Stretching, shear, torsional and bending stiffness of bars 1 and 2, and of bar 3.
const THICK: [f64; 4] = [52.99e6, 16.88e6, 733.5, 1131.0];
const THIN: [f64; 4] = [13.25e6, 4.22e6, 45.84, 70.66];

/// Force (10 kN) and moment (kN m) at A, angles at B and D, force and moment across the axis at D, and the
/// angle of bar 1.
type Unknowns = SVector<f64, 14>;
const ANGLE: usize = 13;

/// Position, rotation from where it is straight, and moment.
type Section = (Vector3<f64>, Matrix3<f64>, Vector3<f64>);

/// A section further along: the other end of a straight rod of this direction and length, which carries the
/// force n.
fn shoot(from: Section, n: Vector3<f64>, way: Vector3<f64>, k: [f64; 4], steps: u32) -> Section {
    let [EA, GA, GJ, EI] = k;
    let d = way.normalize();
    let soft = |along: f64, across: f64| {
        let P = d * d.transpose();
        P / along + (Matrix3::identity() - P) / across
    };
    let (strain, bend) = (soft(EA, GA), soft(GJ, EI));
    let slope = |(_, R, m): &Section| {
        let x = R * (d + strain * R.tr_mul(&n));
        let turn = R * (bend * R.tr_mul(m)).cross_matrix();
        (x, turn, -x.cross(&n))
    };
    let add = |a: &Section, b: &Section, h: f64| (a.0 + b.0 * h, a.1 + b.1 * h, a.2 + b.2 * h);
    let h = way.norm() / f64::from(steps);
    (0..steps).fold(from, |at, _| {
        let k1 = slope(&at);
        let k2 = slope(&add(&at, &k1, 0.5 * h));
        let k3 = slope(&add(&at, &k2, 0.5 * h));
        let k4 = slope(&add(&at, &k3, h));
        let once = add(&add(&at, &k1, h / 6.0), &k2, h / 3.0);
        add(&add(&once, &k3, h / 3.0), &k4, h / 6.0)
    })
}

/// What is open: the moment about the axis at B, and at C the gap, the tilt of one axis against the other,
/// force, moment, and the moment about the axis. Also the position of C.
fn open(y: &Unknowns, steps: u32) -> (SVector<f64, 13>, Vector3<f64>) {
    let turned = |angle: f64| Rotation3::from_axis_angle(&Vector3::z_axis(), angle).into_inner();
    let three = |k: usize| y.fixed_rows::<3>(k).into_owned();
    let (n, m) = (three(0) * 1e4, three(3) * 1e3);
    let (n_D, m_D) = (three(8) * 1e4, Vector3::new(y[11], y[12], 0.0) * 1e3);
    let (up, across) = (Vector3::y() * 0.12, Vector3::x() * 0.24);
    let start = (Vector3::zeros(), turned(y[ANGLE]), m);
    let (x, R_B, m_B) = shoot(start, n, up, THICK, steps);
    let (C, R, m) = shoot((x, R_B * turned(y[6]), m_B), n, across, THICK, steps);
    let (tip, R_3, m_3) = shoot((across, turned(y[7]), m_D), n_D, up, THIN, steps);
    let (s, c) = 5.0_f64.to_radians().sin_cos();
    let axis = R * Vector3::new(s, 0.0, c);
    let other = R_3 * Vector3::new(s, 0.0, c);
    let mut out = SVector::<f64, 13>::zeros();
    out[0] = m_B.dot(&R_B.column(2)) / 1e3;
    out.fixed_rows_mut::<3>(1).copy_from(&((C - tip) * 10.0));
    out[4] = other.dot(&(R * Vector3::new(c, 0.0, -s)));
    out[5] = other.dot(&(R * Vector3::y()));
    out.fixed_rows_mut::<3>(6).copy_from(&((n + n_D) / 1e4));
    out.fixed_rows_mut::<3>(9).copy_from(&((m + m_3) / 1e3));
    out[12] = m.dot(&axis) / 1e3;
    (out, C)
}

/// The equilibrium by Newton's method in the hyperplane through a guess across a direction, and which way the
/// path of equilibria goes on from it.
fn equilibrium(guess: &Unknowns, across: &Unknowns, steps: u32) -> Option<(Unknowns, Unknowns)> {
    const H: f64 = 1e-6;
    let mut y = *guess;
    for _ in 0..8 {
        let mut K = SMatrix::<f64, 14, 14>::zeros();
        K.row_mut(13).copy_from(&across.transpose());
        for k in 0..14 {
            let step = Unknowns::ith(k, H);
            let slope = (open(&(y + step), steps).0 - open(&(y - step), steps).0) / (2.0 * H);
            K.fixed_view_mut::<13, 1>(0, k).copy_from(&slope);
        }
        let mut b = Unknowns::zeros();
        b.fixed_rows_mut::<13>(0).copy_from(&open(&y, steps).0);
        b[13] = across.dot(&(y - guess));
        let K = K.lu();
        let correction = K.solve(&b)?;
        y -= correction;
        if correction.norm() < 1e-10 {
            return Some((y, K.solve(&Unknowns::ith(13, 1.0))?.normalize()));
        }
    }
    None
}

/// With bar 1 turned by an angle, near a guess: the angles at B and D, and C.
fn fixed(guess: &Unknowns, angle: f64) -> (Unknowns, Vector3<f64>) {
    let mut guess = *guess;
    guess[ANGLE] = angle;
    let (y, _) = equilibrium(&guess, &Unknowns::ith(ANGLE, 1.0), 32).unwrap();
    (y, open(&y, 32).1)
}

/// The path of equilibria, bar 1 turned from −0.1 to beyond −7.2, by its length.
fn path() -> Vec<Unknowns> {
    let mut y = Unknowns::zeros();
    (y[6], y[7], y[ANGLE]) = (0.1, -0.1, -0.1);
    let (mut y, way) = equilibrium(&y, &Unknowns::ith(ANGLE, 1.0), 8).unwrap();
    let (mut way, mut step, mut path) = (-way, 0.15, vec![y]);
    while y[ANGLE] > -7.2 {
        let next = equilibrium(&(y + way * step), &way, 8);
        // The next direction is the last one's side of the path.
        let next = next.filter(|(_, next)| next.dot(&way) > 0.9);
        let Some((found, direction)) = next else {
            step *= 0.5;
            assert!(step > 1e-6, "lost at {y}");
            continue;
        };
        (y, way, step) = (found, direction, (1.3 * step).min(0.15));
        path.push(y);
    }
    path
}

#[test]
fn the_numbers_of_the_misaligned_axis() {
    let path = path();
    // Each angle of bar 1 is met once: there is nothing to snap through, and a slow motion stays near the
    // path. Bar 3 turns back at the first flat position and once more at the second.
    for pair in path.windows(2) {
        assert!(pair[1][ANGLE] < pair[0][ANGLE], "{}", pair[1]);
    }
    let at = |angle: f64| {
        let k = path.partition_point(|y| y[ANGLE] > angle);
        let (a, b) = (path[k - 1], path[k]);
        let part = (angle - a[ANGLE]) / (b[ANGLE] - a[ANGLE]);
        fixed(&(a + (b - a) * part), angle)
    };
    let rows = rows("four-bar-misaligned");
    for angle in [0.6, 0.9, 1.2, 1.8, 3.6, 7.2] {
        let (_, C) = at(-angle);
        let d: [f64; 3] = (C - Vector3::new(0.24, 0.12, 0.0)).into();
        let what = format!("C in equilibrium, bar 1 turned by {angle},");
        assert_published(&rows, &what, &d, 1e-10);
    }
    let turned = at(-7.2).0[7];
    assert_published(&rows, "angle of bar 3", &[turned], 1e-9);
    // The vertex of a parabola.
    let angles = [-1.508, -1.512, -1.516];
    let [a, b, c] = angles.map(|angle| at(angle).1.z);
    let largest = (b - (c - a).powi(2) / (8.0 * (a - 2.0 * b + c))).abs();
    assert_published(&rows, "largest deflection", &[largest], 1e-10);
    // Beyond the flat position the parallelogram is in equilibrium, too, but not on this path.
    let mut guess = Unknowns::zeros();
    (guess[6], guess[7]) = (1.8, -1.8);
    let (parallel, _) = fixed(&guess, -1.8);
    assert!((parallel[7] + 1.8).abs() < 0.01 && at(-1.8).0[7] > -1.0);
}
