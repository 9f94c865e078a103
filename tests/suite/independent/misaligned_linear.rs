//! Bauchau's linkage with hardly any misalignment by linear theory: the numbers that the gallery compares with.
//!
//! Three straight beams after Timoshenko, a cubic each, in the plane of a parallelogram that stands still:
//! only deflections out of the plane and the rotations about axes in it are unknown. Nothing is shared with
//! the program.

use crate::support::independent::{assert_published, rows};
use crate::support::prelude::*;
use nalgebra::{Matrix2, Matrix6};

/// Torsional, bending and shear stiffness of bars 1 and 2, and of bar 3.
const THICK: [f64; 3] = [733.5, 1131.0, 16.88e6];
const THIN: [f64; 3] = [45.84, 70.66, 4.22e6];

/// Stiffness of a beam between two positions against the deflection and the rotations about e1 and e2 of both
/// ends.
fn beam(from: Vector2<f64>, to: Vector2<f64>, [GJ, EI, GA]: [f64; 3]) -> Matrix6<f64> {
    let way = to - from;
    let L = way.norm();
    let phi = 12.0 * EI / (GA * L * L);
    let a = EI / (L * L * L * (1.0 + phi));
    // Along itself: deflection, twist, and the rotation about its normal, minus the slope.
    let (shear, lever) = (12.0 * a, -6.0 * a * L);
    let (near, far) = ((4.0 + phi) * L * L * a, (2.0 - phi) * L * L * a);
    let twist = GJ / L;
    let block =
        |a: f64, b: f64, c: f64, d: f64, t: f64| Matrix3::new(a, 0.0, b, 0.0, t, 0.0, c, 0.0, d);
    let (c, s) = (way.x / L, way.y / L);
    let turn = Matrix3::new(1.0, 0.0, 0.0, 0.0, c, s, 0.0, -s, c);
    let mut K = Matrix6::zeros();
    for (row, column, block) in [
        (0, 0, block(shear, lever, lever, near, twist)),
        (0, 3, block(-shear, lever, -lever, far, -twist)),
        (3, 0, block(-shear, -lever, lever, far, -twist)),
        (3, 3, block(shear, -lever, -lever, near, twist)),
    ] {
        let global = turn.transpose() * block * turn;
        K.fixed_view_mut::<3, 3>(row, column).copy_from(&global);
    }
    K
}

/// Deflection at C over the tangent of the misalignment, with bar 1 turned by an angle from e2.
fn deflection(angle: f64) -> f64 {
    let (s, c) = angle.sin_cos();
    let bar = Vector2::new(-s, c) * 0.12;
    let (A, D) = (Vector2::zeros(), Vector2::new(0.24, 0.0));
    let mut K = beam(A + bar, D + bar, THICK);
    // Bar 1 holds one end of bar 2, and bar 3 the other, whose foot cannot move.
    let far = |K: Matrix6<f64>| K.fixed_view::<3, 3>(3, 3).into_owned();
    let held = far(beam(D, D + bar, THIN));
    let mut first = K.fixed_view_mut::<3, 3>(0, 0);
    first += far(beam(A, A + bar, THICK));
    let mut last = K.fixed_view_mut::<3, 3>(3, 3);
    last += held;
    // The axis has the direction e3 + e1 in bar 2, which has not turned, and e3 + Q e1 in bar 3, turned by
    // the angle. They agree once bar 3 has turned by as much more as e3 × (e1 − Q e1).
    let [x, y] = (Vector2::x() - Matrix2::new(c, -s, s, c) * Vector2::x()).into();
    let more = Vector3::new(0.0, -y, x);
    let mut load = nalgebra::Vector6::zeros();
    load.fixed_rows_mut::<3>(3).copy_from(&-(held * more));
    K.lu().solve(&load).unwrap()[3]
}

#[test]
fn the_numbers_of_the_hardly_misaligned_axis() {
    let rows = rows("four-bar-hardly-misaligned");
    for angle in [0.6, 0.9, 1.2] {
        let what = format!("deflection at C over misalignment, bar 1 turned by {angle}");
        // The gallery has eleven decimals of it.
        assert_published(&rows, &what, &[deflection(-angle)], 1e-11);
    }
}
