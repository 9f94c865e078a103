//! Hooke's joint: two shafts and a cross between them.

#![allow(non_snake_case)]

use super::case::{Case, CaseError, Context};
use super::motion::Run;
use crate::input::{Analysis, DofName, Driven, Fix, ModelFile, RunUp, Scheme, Support, Time};
use crate::output::plot::Curve;
use crate::probe::continue_rotation;
use nalgebra::Vector3;
use pullback_elements::model::NodeState;

/// Case 4 of [M04].
pub const CASE: Case = Case {
    name: "hooke",
    run: hooke,
};

/// R08: the kinematics alone.
pub const UNIVERSAL: Case = Case {
    name: "universal-joint",
    run: universal,
};

/// What the output is ahead of the input by, tan β = tan α / cos γ for shafts at an angle γ.
fn ahead(alpha: f64, cosine: f64) -> f64 {
    let (s, c) = alpha.sin_cos();
    (s * c * (1.0 / cosine - 1.0)).atan2(c * c + s * s / cosine)
}

/// Rotation angle of a node over time, any number of turns.
fn angles(states: &[NodeState]) -> Vec<f64> {
    let mut continued = Vector3::zeros();
    let turn = states.iter().map(|s| {
        continued = continue_rotation(&continued, &s.psi);
        continued.norm()
    });
    turn.collect()
}

/// Angle of the input of rigid shafts with inertias of 20 after the moment 0 → 40 → 0, by the
/// classical Runge-Kutta method: the momentum p = I α̇ with I = 20 (1 + ρ²), ρ = dβ/dα, has the rate
/// M + ½ I' α̇².
fn rigid_shafts(cosine: f64, until: f64) -> f64 {
    let inertia = |alpha: f64| {
        let (s, c) = alpha.sin_cos();
        let bottom = cosine * c * c + s * s / cosine;
        let slope = 2.0 * s * c * (1.0 / cosine - cosine);
        [
            20.0 * (1.0 + bottom.powi(-2)),
            -40.0 * slope * bottom.powi(-3),
        ]
    };
    let rates = |t: f64, [alpha, p]: [f64; 2]| {
        let moment = (40.0 * (1.0 - (2.0 * t - 1.0).abs())).max(0.0);
        let [I, slope] = inertia(alpha);
        let speed = p / I;
        [speed, moment + 0.5 * slope * speed * speed]
    };
    let count = 30_000;
    let h = until / f64::from(count);
    let along = |y: [f64; 2], k: [f64; 2], h: f64| [y[0] + h * k[0], y[1] + h * k[1]];
    let end = (0..count).fold([0.0; 2], |y, n| {
        let t = h * f64::from(n);
        let k1 = rates(t, y);
        let k2 = rates(t + 0.5 * h, along(y, k1, 0.5 * h));
        let k3 = rates(t + 0.5 * h, along(y, k2, 0.5 * h));
        let k4 = rates(t + h, along(y, k3, h));
        let sum = |i: usize| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0;
        along(y, [sum(0), sum(1)], h)
    });
    end[0]
}

fn hooke(context: &mut Context) -> Result<(), CaseError> {
    let file = context.file(include_str!("../../examples/models/hooke.toml"))?;
    let cosine = 0.5_f64.sqrt();
    let run = context.motion(&file, &["A", "B"], Run::FILE)?;
    let [a, b] = [0, 1].map(|k| angles(&run.nodes[k]));
    let difference: Vec<f64> = a.iter().zip(&b).map(|(a, b)| b - a).collect();
    let exact: Vec<f64> = a.iter().map(|&a| ahead(a, cosine)).collect();
    let after = |t: &f64| *t > 1.0;
    let worst = (run.t.iter().zip(difference.iter().zip(&exact)))
        .filter(|(t, _)| after(t))
        .fold(0.0_f64, |m, (_, (d, e))| m.max((d - e).abs()));
    let source = "exact: tan β = tan α / cos 45°";
    context.compare("largest error after the moment", worst, 0.0, 1e-3, source);
    let amplitude = difference.iter().fold(0.0_f64, |m, d| m.max(d.abs()));
    let most = ((1.0 - cosine) / (1.0 + cosine)).asin();
    context.compare("amplitude", amplitude, most, 2e-3, source);
    let source = "independent: rigid shafts, Runge-Kutta";
    let last = a.last().copied().unwrap_or(f64::NAN);
    let what = "angle of the input at t = 30";
    context.compare(what, last, rigid_shafts(cosine, 30.0), 0.02, source);
    let curve = |values: &[f64]| -> Vec<(f64, f64)> {
        run.t.iter().copied().zip(values.iter().copied()).collect()
    };
    context.figure(
        "Hooke's joint",
        ["time t", "‖Ψ_B‖ − ‖Ψ_A‖ (rad)"],
        vec![
            Curve::new("two beams, two revolute joints", curve(&difference)),
            Curve::points("exact", curve(&exact).into_iter().step_by(12).collect()),
        ],
    )
}

/// The input shaft runs up to a constant speed; the shafts are stiff and light.
fn light(file: &ModelFile, degrees: f64) -> ModelFile {
    let mut file = file.clone();
    let (s, c) = degrees.to_radians().sin_cos();
    file.nodes.insert("B".to_owned(), [c, s, 0.0]);
    for section in file.sections.values_mut() {
        if let Some(mass) = &mut section.mass {
            mass.J = [2e-3, 1e-3, 1e-3];
        }
    }
    file.loads.clear();
    file.supports[0] = Support {
        node: "A".to_owned(),
        fix: Some(Fix::List(
            (DofName::ALL.into_iter())
                .filter(|dof| *dof != DofName::RX)
                .collect(),
        )),
        driven: Some(Driven {
            rx: Some(Time::RunUp(RunUp {
                rate: 1.0,
                duration: 2.0,
            })),
            ..Driven::default()
        }),
    };
    if let Analysis::Dynamic(d) = &mut file.analysis {
        d.to = 9.0;
        d.step = 0.005;
        d.scheme = Scheme::from("ga:0.5");
    }
    file
}

fn universal(context: &mut Context) -> Result<(), CaseError> {
    let file = context.file(include_str!("../../examples/models/hooke.toml"))?;
    let source = "exact: R08, angles from where the input yoke lies in the plane";
    for (degrees, points) in [
        (
            30.0,
            &[
                (30.0, 33.690067526, 1.06587742004),
                (45.0, 49.1066053509, 0.989743318611),
                (90.0, 90.0, 0.866025403784),
            ][..],
        ),
        (45.0, &[(60.0, 67.7923457014, 0.808122035642)][..]),
    ] {
        let run = context.motion(&light(&file, degrees), &["A", "B"], Run::FILE)?;
        let [a, b] = [0, 1].map(|k| angles(&run.nodes[k]));
        let ratio: Vec<f64> = (run.nodes[0].iter().zip(&run.nodes[1]))
            .map(|(a, b)| b.omega.norm() / a.omega.norm())
            .collect();
        for &(alpha, beta, speed) in points {
            let alpha = f64::to_radians(alpha);
            let Some(k) = a.windows(2).position(|w| w[0] <= alpha && alpha < w[1]) else {
                return Err(context.setup("the input shaft does not turn far enough"));
            };
            let part = (alpha - a[k]) / (a[k + 1] - a[k]);
            let between = |x: &[f64]| x[k] + part * (x[k + 1] - x[k]);
            let at = format!("{degrees}°, input {:.0}°", alpha.to_degrees());
            let what = format!("shafts at {at}: output (degrees)");
            let computed = between(&b).to_degrees();
            context.compare(what, computed, beta, 1e-3, source);
            let what = format!("shafts at {at}: ratio of speeds");
            context.compare(what, between(&ratio), speed, 1e-4, source);
        }
    }
    Ok(())
}
