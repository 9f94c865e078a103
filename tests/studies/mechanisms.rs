//! Mechanisms of the gallery with one degree of freedom, and its top, solved by other means: the numbers that it
//! compares with.
//!
//! Closed-form kinematics with their derivatives, equations of motion in one coordinate or in quaternions, and the
//! classical Runge-Kutta method.

use crate::support::dynamics::integrate_ode;
use crate::support::independent::{assert_published, rows};
use crate::support::loops::four_bar::{DRAWN, closed_form, mass_and_potential};
use crate::support::loops::{G, one_freedom, slope};
use nalgebra::{Quaternion, SVector, UnitQuaternion, Vector2, Vector3, stack};
use pullback::manifold::jet::Moving;
use pullback::manifold::scalar::Scalar;
use pullback::manifold::so3;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

/// Largest difference of two sums of the same terms, after tens of thousands of steps.
const ROUNDING: f64 = 1e-11;

/// The mass M (kinetic energy ½ M θ̇²) and the potential V of a mechanism with one degree of freedom θ, with their
/// derivatives by θ.
type OneFreedom<'a> = &'a dyn Fn(Moving<0>) -> [Moving<0>; 2];

/// θ and θ̇ at a time by the classical Runge-Kutta method: M θ̈ + ½ M′ θ̇² + V′ = 0.
fn integrate(system: OneFreedom<'_>, start: [f64; 2], to: f64) -> [f64; 2] {
    let rates = |_: f64, y: &Vector2<f64>| {
        let (theta, rate) = (y.x, y.y);
        let [M, V] = system(with_rate([theta, 1.0]));
        Vector2::new(rate, one_freedom(M, V, rate))
    };
    integrate_ode(&rates, start.into(), to, 20_000).into()
}

/// A quantity with its first derivative.
fn with_rate([x, rate]: [f64; 2]) -> Moving<0> {
    Moving::given([x, rate, 0.0])
}

#[test]
fn the_numbers_of_the_four_bar_linkage() {
    let system = |crank: Moving<0>| {
        let [coupler, rocker] = closed_form(DRAWN, crank);
        mass_and_potential(DRAWN, [crank, coupler, rocker])
    };
    let end = integrate(&system, [FRAC_PI_2, 4.5], 4.0);
    let [_, rocker] = closed_form(DRAWN, with_rate(end));
    let tip = [rocker.cos() * DRAWN[2] + DRAWN[3], rocker.sin() * DRAWN[2]];
    let rows = rows("four-bar");
    assert_published(&rows, "coupler tip", &tip.map(|x| x.x[0]), ROUNDING);
    assert_published(&rows, "its velocity", &tip.map(|x| x.x[1]), ROUNDING);
}

const CRANK: f64 = 0.4;
const ROD: f64 = 1.0;

fn slider_crank_system(rod: f64) -> impl Fn(Moving<0>) -> [Moving<0>; 2] {
    move |angle: Moving<0>| {
        let (x, y) = (angle.cos() * CRANK, angle.sin() * CRANK);
        let displacement = x + (-(y * y) + ROD * ROD).sqrt();
        let tilt = (y * (1.0 / ROD)).atan2((-(y * y) * (1.0 / (ROD * ROD)) + 1.0).sqrt());
        let (cx, cy) = (slope((x + displacement) * 0.5), slope(y * 0.5));
        let (turn, s) = (slope(tilt), slope(displacement));
        let M = (cx * cx + cy * cy) * rod
            + turn * turn * (rod * ROD * ROD / 12.0)
            + s * s * 0.8
            + CRANK * CRANK / 3.0;
        let V = y * (G * 0.5 * (1.0 + rod));
        [M, V]
    }
}

#[test]
fn the_numbers_of_the_slider_crank() {
    let angle = with_rate(integrate(&slider_crank_system(1.5), [0.0, 12.0], 2.0));
    let y = angle.sin() * CRANK;
    let displacement = angle.cos() * CRANK + (-(y * y) + ROD * ROD).sqrt();
    let rows = rows("slider-crank");
    assert_published(&rows, "slider at", &displacement.x[..1], ROUNDING);
    assert_published(&rows, "its velocity", &displacement.x[1..2], ROUNDING);
}

#[test]
fn the_numbers_of_the_parallelograms() {
    let system = |angle: Moving<0>| {
        let M = Moving::<0>::constant(6.0 / 3.0 + 5.0);
        [M, -(angle.cos() * (G * (6.0 / 2.0 + 5.0)))]
    };
    let [angle, rate] = integrate(&system, [1.2, 0.0], 4.0);
    let (s, c) = angle.sin_cos();
    let rows = rows("parallelograms");
    assert_published(&rows, "last coupler", &[5.0 + s, -c], ROUNDING);
    assert_published(&rows, "its velocity", &[rate * c], ROUNDING);
}

/// Angles x and y of the odd and the even hinges of Bricard's mechanism. Of
/// cos θ + cos φ + cos θ cos φ = 0 with θ = 90° + x and φ = 90° + y remains, for the mean m and the
/// difference 4w of x and y, sin m = −2 sin² w: a closed curve with the parameter s, √2 sin w = sin s.
fn bricard_angles(s: Moving<0>) -> [Moving<0>; 2] {
    let sine = s.sin();
    let square = sine * sine;
    let m = (-square).atan2(s.cos() * (square + 1.0).sqrt());
    let w = (sine * FRAC_1_SQRT_2).atan2((-(square * 0.5) + 1.0).sqrt());
    [m + w * 2.0, m - w * 2.0]
}

/// Its mass and potential. Bars are slender, of mass and length 1: one whose ends move with a and b has
/// the energy (a² + a·b + b²)/6.
fn bricard_system(s: Moving<0>) -> [Moving<0>; 2] {
    let [x, y] = bricard_angles(s);
    let zero = Moving::<0>::constant(0.0);
    let mut turn = so3::Quaternion::about(&Vector3::x(), zero);
    let mut end = Vector3::repeat(zero);
    let (mut M, mut V) = (zero, zero);
    let [e1, e2, e3] = [Vector3::x(), Vector3::y(), Vector3::z()];
    for (axis, bar, angle) in [
        (-e2, e1, x),
        (e3, e2, y),
        (e1, e3, x),
        (-e2, -e1, y),
        (e3, -e2, x),
    ] {
        turn = turn.product(&so3::Quaternion::about(&axis, angle));
        let next = end + turn.rotate(&bar.map(Moving::<0>::constant));
        let [a, b] = [end.map(slope), next.map(slope)];
        M += (a.dot(&a) + a.dot(&b) + b.dot(&b)) * (1.0 / 3.0);
        V += (end.y + next.y) * (0.5 * G);
        end = next;
    }
    [M, V]
}

#[test]
fn the_numbers_of_bricards_mechanism() {
    let [x, _] = bricard_angles(with_rate(integrate(&bricard_system, [0.0; 2], 5.0)));
    let rows = rows("bricard");
    assert_published(&rows, "hinge 1", &[x.x[0]; 2], ROUNDING);
    assert_published(&rows, "rate of hinge 1", &[x.x[1]; 2], ROUNDING);
}

/// Angle of the input of rigid shafts with inertias of 20 after the moment 0 → 40 → 0, by the
/// classical Runge-Kutta method: the momentum p = I α̇ with I = 20 (1 + ρ²), ρ = dβ/dα, has the rate
/// M + ½ I' α̇².
fn rigid_shafts(cosine: f64, until: f64) -> f64 {
    let inertia = |alpha: f64| {
        let (s, c) = alpha.sin_cos();
        let bottom = cosine * c * c + s * s / cosine;
        let slope = 2.0 * s * c * (1.0 / cosine - cosine);
        let I = 20.0 * (1.0 + bottom.powi(-2));
        [I, -40.0 * slope * bottom.powi(-3)]
    };
    let rates = |t: f64, y: &Vector2<f64>| {
        let (alpha, p) = (y.x, y.y);
        let moment = (40.0 * (1.0 - (2.0 * t - 1.0).abs())).max(0.0);
        let [I, slope] = inertia(alpha);
        let speed = p / I;
        Vector2::new(speed, moment + 0.5 * slope * speed * speed)
    };
    integrate_ode(&rates, Vector2::zeros(), until, 30_000).x
}

#[test]
fn the_numbers_of_hookes_joint() {
    let last = rigid_shafts(0.5_f64.sqrt(), 30.0);
    assert_published(&rows("hooke"), "angle of the input", &[last], ROUNDING);
}

/// A rigid body with a fixed point by Euler's equations for the quaternion p and the angular velocity Ω in axes of the
/// body, as an independent solution.
struct Gyroscope {
    /// Principal moments about the fixed point.
    J: Vector3<f64>,
    /// Weight times the position of the centre of mass in axes of the body.
    arm: Vector3<f64>,
}

/// p and Ω.
type GyroState = SVector<f64, 7>;

impl Gyroscope {
    fn rates(&self, y: &GyroState) -> GyroState {
        let (p, omega) = (quaternion(y), y.fixed_rows::<3>(4).into_owned());
        let R = UnitQuaternion::from_quaternion(p);
        let down = R.inverse_transform_vector(&-Vector3::z());
        let moment = self.arm.cross(&down) - omega.cross(&self.J.component_mul(&omega));
        let half = Quaternion::from_parts(0.0, omega) * 0.5;
        stack![(p * half).coords; moment.component_div(&self.J)]
    }
}

/// The quaternion p of a state.
fn quaternion(y: &GyroState) -> Quaternion<f64> {
    Quaternion::from(y.fixed_rows::<4>(0).into_owned())
}

#[test]
fn the_numbers_of_the_fast_top() {
    let gyroscope = Gyroscope {
        J: Vector3::new(5.0, 5.0, 1.0),
        arm: Vector3::new(0.0, 0.0, 20.0),
    };
    let tilt = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, 0.0, 0.0));
    let begin: GyroState = stack![tilt.quaternion().coords; Vector3::new(0.0, 0.0, 50.0)];
    let rows = rows("top");
    for t in [0.5, 1.0, 1.5] {
        let end = integrate_ode(&|_, y| gyroscope.rates(y), begin, t, 100_000);
        let axis = UnitQuaternion::from_quaternion(quaternion(&end)) * Vector3::z();
        let what = format!("axis at t = {t} ");
        assert_published(&rows, &what, axis.as_slice(), ROUNDING);
    }
}
