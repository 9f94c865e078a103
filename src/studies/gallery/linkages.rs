//! Planar linkages of one degree of freedom, with closed-form kinematics and an equation of motion.

#![allow(non_snake_case)]

use super::case::{CaseProblem, CaseReport, with_step};
use super::motion::{History, richardson, runge_kutta};
use crate::output::plot::PlotCurve;
use nalgebra::{Vector2, Vector3};
use pullback_elements::model::NodeState;
use pullback_manifold::jet::Moving;
use pullback_manifold::scalar::Scalar;

pub(super) const G: f64 = 9.81;

/// The mass M (kinetic energy ½ M θ̇²) and the potential V of a mechanism with one degree of freedom θ, with their
/// derivatives by θ.
pub(super) type OneFreedom<'a> = &'a dyn Fn(Moving<0>) -> [Moving<0>; 2];

/// θ and θ̇ at a time by the classical Runge-Kutta method: M θ̈ + ½ M′ θ̇² + V′ = 0.
pub(super) fn integrate(system: OneFreedom<'_>, start: [f64; 2], to: f64) -> [f64; 2] {
    let rates = |_, y: &Vector2<f64>| {
        let (theta, rate) = (y.x, y.y);
        let [M, V] = system(with_rate([theta, 1.0]));
        Vector2::new(rate, -(0.5 * M.x[1] * rate * rate + V.x[1]) / M.x[0])
    };
    runge_kutta(rates, start.into(), to, 20_000).into()
}

/// A quantity with its first derivative.
pub(super) fn with_rate([x, rate]: [f64; 2]) -> Moving<0> {
    Moving::given([x, rate, 0.0])
}

/// The derivative by θ of a quantity with two derivatives.
pub(super) fn slope(x: Moving<0>) -> Moving<0> {
    with_rate([x.x[1], x.x[2]])
}

/// Lengths of crank, coupler, rocker and base, the last from the origin along e1.
pub(super) const BARS: [f64; 4] = [1.0, 1.5, 1.941_648_783_894_76, 1.6];
const MASSES: [f64; 3] = [2.0, 1.0, 1.2];

/// Angles of coupler and rocker from that of the crank: the circles of their ends meet.
fn closed_form<S: Scalar>(crank: S) -> [S; 2] {
    let [a, b, c, base] = BARS;
    let (px, py) = (crank.cos() * a, crank.sin() * a);
    let (ux, uy) = (-px + base, -py);
    let r = (ux * ux + uy * uy).sqrt();
    let cosine = (r * r + (b * b - c * c)) / (r * (2.0 * b));
    let opening = (-(cosine * cosine) + 1.0).sqrt().atan2(cosine);
    let coupler = uy.atan2(ux) + opening;
    let (ex, ey) = (px + coupler.cos() * b, py + coupler.sin() * b);
    [coupler, ey.atan2(ex - base)]
}

fn four_bar_system(crank: Moving<0>) -> [Moving<0>; 2] {
    let ([a, b, c, _], [m1, m2, m3]) = (BARS, MASSES);
    let [coupler, rocker] = closed_form(crank);
    let (k2, k3) = (slope(coupler), slope(rocker));
    let M = k2 * k2 * (m2 * b * b / 3.0)
        + k2 * (crank - coupler).cos() * (m2 * a * b)
        + k3 * k3 * (m3 * c * c / 3.0)
        + (m1 / 3.0 + m2) * a * a;
    let V = crank.sin() * ((0.5 * m1 + m2) * G * a)
        + coupler.sin() * (0.5 * m2 * G * b)
        + rocker.sin() * (0.5 * m3 * G * c);
    [M, V]
}

/// Largest distance of two watched nodes.
pub(super) fn gap(run: &History, [a, b]: [usize; 2]) -> f64 {
    let both = run.nodes[a].iter().zip(&run.nodes[b]);
    both.fold(0.0_f64, |m, (a, b)| m.max((a.position - b.position).norm()))
}

pub(super) fn last(run: &History, node: usize) -> NodeState {
    run.nodes[node][run.nodes[node].len() - 1]
}

/// A vector at the end, from two steps.
fn at_end(runs: &[History; 2], node: usize, of: impl Fn(&NodeState) -> Vector3<f64>) -> [f64; 3] {
    let [coarse, fine] = runs;
    richardson(of(&last(coarse, node)).into(), of(&last(fine, node)).into())
}

const SOURCE: &str = "exact: closed-form kinematics, M θ̈ + ½ M′ θ̇² + V′ = 0 by Runge-Kutta";

/// A four-bar linkage of rigid bars.
pub(super) fn four_bar(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("four_bar")?;
    let files = [1e-3, 5e-4].map(|h| with_step(&file, h));
    let runs = report.motions(files, &["coupler tip", "rocker tip"])?;
    let start = [std::f64::consts::FRAC_PI_2, 4.5];
    let [_, rocker] = closed_form(with_rate(integrate(&four_bar_system, start, 4.0)));
    let (x, y) = (rocker.cos() * BARS[2] + BARS[3], rocker.sin() * BARS[2]);
    let found = at_end(&runs, 0, |s| s.position);
    let what = "coupler tip at t = 4";
    report.compare_parts(what, &found, &[x, y].map(|x| x.x[0]), 1e-5, SOURCE);
    let found = at_end(&runs, 0, |s| s.velocity);
    report.compare_parts(
        "its velocity",
        &found,
        &[x, y].map(|x| x.x[1]),
        1e-4,
        SOURCE,
    );
    let what = "largest gap of the loop in 8000 steps";
    report.compare_gap(what, gap(&runs[1], [0, 1]), 1e-14);
    report.compare_energy(&runs[1], 1e-4);
    report.figure(
        "Four-bar linkage: path of the coupler's tip",
        ["x", "y"],
        vec![PlotCurve::new(
            "tip of the coupler",
            runs[1].path(0, [0, 1]),
        )],
    )
}

pub(super) const CRANK: f64 = 0.4;
pub(super) const ROD: f64 = 1.0;

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

/// Displacement of the slider and its rate at a time.
fn slider_exact(rod: f64, to: f64) -> [f64; 2] {
    let angle = with_rate(integrate(&slider_crank_system(rod), [0.0, 12.0], to));
    let y = angle.sin() * CRANK;
    let displacement = angle.cos() * CRANK + (-(y * y) + ROD * ROD).sqrt();
    [displacement.x[0], displacement.x[1]]
}

/// A slider-crank mechanism of rigid bars.
pub(super) fn slider_crank(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("slider_crank")?;
    let runs = report.motions(
        [1e-3, 5e-4].map(|h| with_step(&file, h)),
        &["slider", "rod end"],
    )?;
    let [displacement, rate] = slider_exact(1.5, 2.0);
    let found = at_end(&runs, 0, |s| s.position)[0];
    report.compare("slider at t = 2", found, displacement, 1e-5, SOURCE);
    let found = at_end(&runs, 0, |s| s.velocity)[0];
    report.compare("its velocity", found, rate, 1e-4, SOURCE);
    let open = gap(&runs[1], [0, 1]);
    report.compare_gap("largest gap of the loop", open, 1e-14);
    report.compare_energy(&runs[1], 1e-3);
    Ok(())
}

/// Five parallelograms in a row.
///
/// All couplers only translate: a pendulum with the inertia of six cranks and the mass of five couplers at its end.
pub(super) fn parallelograms(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("parallelograms")?;
    let runs = report.motions(
        [4e-3, 2e-3].map(|h| with_step(&file, h)),
        &["end 5", "far 5"],
    )?;
    let system = |angle: Moving<0>| {
        let M = Moving::<0>::constant(6.0 / 3.0 + 5.0);
        [M, -(angle.cos() * (G * (6.0 / 2.0 + 5.0)))]
    };
    let [angle, rate] = integrate(&system, [1.2, 0.0], 4.0);
    let (s, c) = angle.sin_cos();
    let found = at_end(&runs, 0, |s| s.position);
    let source = "exact: a pendulum, Runge-Kutta";
    let what = "last coupler at t = 4";
    report.compare_parts(what, &found, &[5.0 + s, -c], 1e-5, source);
    let found = at_end(&runs, 0, |s| s.velocity);
    report.compare("its velocity along e1", found[0], rate * c, 1e-4, source);
    let source = "exact: the loops are closed at all times";
    let what = "largest gap of the last loop";
    report.compare(what, gap(&runs[1], [0, 1]), 0.0, 2e-14, source);
    report.compare_energy(&runs[1], 1e-4);
    Ok(())
}
