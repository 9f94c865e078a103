//! Robot arms of two links, turned and lifted at their base.

use super::case::{Case, CaseError, Context};
use super::motion::{Run, observed_order};
use crate::input::{Driven, ModelFile, RunUp, Time};
use crate::output::plot::Curve;
use nalgebra::Vector3;

/// Case 6 of [M04]: a spherical joint between the links.
pub const SPHERICAL: Case = Case {
    name: "arm-spherical",
    run: |context| {
        arm(
            context,
            include_str!("../../examples/models/arm_spherical.toml"),
        )
    },
};

/// Case 7 of [M04]: a revolute joint between the links.
pub const REVOLUTE: Case = Case {
    name: "arm-revolute",
    run: |context| {
        arm(
            context,
            include_str!("../../examples/models/arm_revolute.toml"),
        )
    },
};

fn mesh(file: &ModelFile, elements: usize) -> ModelFile {
    let mut file = file.clone();
    for line in &mut file.lines {
        line.elements = elements / 2;
    }
    file
}

/// The drive without the jerk at its start.
fn smooth(file: &ModelFile) -> ModelFile {
    let mut file = file.clone();
    let run_up = |rate| {
        let duration = 0.5;
        Some(Time::RunUp(RunUp { rate, duration }))
    };
    file.supports[0].driven = Some(Driven {
        z: run_up(6.0),
        rz: run_up(3.0),
        ..Driven::default()
    });
    file
}

fn arm(context: &mut Context, text: &str) -> Result<(), CaseError> {
    let file = context.file(text)?;
    let mut curves = Vec::new();
    let mut tips = Vec::new();
    for elements in [40, 8] {
        let run = context.motion(&mesh(&file, elements), &["tip"], Run::FILE)?;
        let mut add = |color: usize, name: &str, curve: Vec<(f64, f64)>| {
            let label = format!("{name}, {elements} elements");
            let curve = if elements == 40 {
                Curve::new(label, curve)
            } else {
                Curve::points(label, curve.into_iter().step_by(6).collect())
            };
            curves.push(curve.colored(color));
        };
        for (k, name) in ["e1", "e2", "e3"].into_iter().enumerate() {
            add(k, name, run.curve(0, |s| s.d[k]));
        }
        add(3, "norm", run.curve(0, |s| s.d.norm()));
        let tip = run.nodes[0].iter().map(|s| s.d);
        tips.push(run.t.into_iter().zip(tip).collect::<Vec<_>>());
    }
    let source = "published: the meshes agree in the plot (Mäkinen 2004)";
    let apart = |until: f64, of: fn(&Vector3<f64>, &Vector3<f64>) -> f64| {
        let both = tips[0].iter().zip(&tips[1]).take_while(|p| p.0.0 <= until);
        both.fold(0.0_f64, |m, (a, b)| m.max(of(&a.1, &b.1))) / 10.0
    };
    let worst = apart(1.0, |a, b| (a - b).norm());
    let what = "meshes apart until t = 1, over the length";
    context.compare(what, worst, 0.0, 0.03, source);
    let worst = apart(3.0, |a, b| (a.norm() - b.norm()).abs());
    let what = "meshes apart in the norm, over the length";
    context.compare(what, worst, 0.0, 0.1, source);
    // The jerk of the base sends out waves: only steps that resolve them show the order.
    let coarse = mesh(&file, 4);
    let [a, b, c] = [1.25e-5, 6.25e-6, 3.125e-6]
        .map(|h| context.motion(&coarse, &["tip"], Run::step(h).to(0.45)));
    let ends = [a?, b?, c?].map(|h| h.at(0, 0.45).d);
    let source = "theory: the trapezoidal rule";
    let what = "order in the step, 4 elements, driven with a jerk";
    context.compare(what, observed_order(&ends), 2.0, 0.2, source);
    let smooth = mesh(&smooth(&file), 8);
    let [a, b, c] =
        [2e-3, 1e-3, 5e-4].map(|h| context.motion(&smooth, &["tip"], Run::step(h).to(1.0)));
    let ends = [a?, b?, c?].map(|h| h.at(0, 1.0).d);
    let what = "order in the step, driven smoothly";
    context.compare(what, observed_order(&ends), 2.0, 0.1, source);
    context.figure(
        file.title.as_deref().unwrap_or("Robot arm"),
        ["time t", "displacement of the tip"],
        curves,
    )
}
