//! The right-angle cantilever, struck at its elbow.

use super::case::{Case, CaseError, Context, peak};
use super::motion::{History, Run};
use crate::input::ModelFile;
use crate::output::plot::Curve;

/// Case 5 of [M04].
pub const CASE: Case = Case {
    name: "elbow",
    run: elbow,
};

/// D01: the same on a converged mesh.
pub const CONVERGED: Case = Case {
    name: "elbow-converged",
    run: converged,
};

const FILE: &str = include_str!("../../examples/models/elbow.toml");

fn mesh(file: &ModelFile, elements: usize, order: usize) -> ModelFile {
    let mut file = file.clone();
    for line in &mut file.lines {
        line.elements = elements;
        line.order = order;
    }
    file
}

/// The highest or lowest point of a curve between two times.
fn extremum(curve: &[(f64, f64)], [from, to]: [f64; 2], sign: f64) -> (f64, f64) {
    let inside = |k: &usize| (from..=to).contains(&curve[*k].0);
    let best = (0..curve.len())
        .filter(inside)
        .max_by(|&a, &b| (sign * curve[a].1).total_cmp(&(sign * curve[b].1)));
    peak(curve, best.unwrap_or(0))
}

fn height(run: &History, node: usize) -> Vec<(f64, f64)> {
    run.curve(node, |s| s.d.z)
}

fn elbow(context: &mut Context) -> Result<(), CaseError> {
    let file = context.file(FILE)?;
    let nodes = ["tip", "elbow"];
    let mut curves = Vec::new();
    for elements in [10, 2] {
        let run = context.motion(&mesh(&file, elements, 1), &nodes, Run::FILE)?;
        let all = 2 * elements;
        let [tip, elbow] = [0, 1].map(|k| height(&run, k));
        if elements == 10 {
            let source = "published: Simo & Vu-Quoc 1988, digitised";
            for (curve, name, span, sign, (t, z)) in [
                (&tip, "tip, first maximum", [5.0, 10.0], 1.0, (7.67, 8.295)),
                (&tip, "tip, minimum", [12.0, 20.0], -1.0, (15.99, -9.673)),
                (&tip, "tip, last maximum", [22.0, 29.0], 1.0, (26.08, 6.98)),
                (
                    &elbow,
                    "elbow, first maximum",
                    [1.0, 5.0],
                    1.0,
                    (3.05, 5.5035),
                ),
                (&elbow, "elbow, minimum", [8.0, 14.0], -1.0, (10.82, -3.87)),
            ] {
                let (at, value) = extremum(curve, span, sign);
                context.compare(format!("{name}: height"), value, z, 0.35, source);
                context.compare(format!("{name}: time"), at, t, 0.35, source);
            }
        }
        for (color, name, curve) in [(0, "tip", tip), (1, "elbow", elbow)] {
            let label = format!("{name}, {all} elements");
            let curve = match elements {
                10 => Curve::new(label, curve),
                _ => Curve::points(label, curve.into_iter().step_by(2).collect()),
            };
            curves.push(curve.colored(color));
        }
    }
    context.figure(
        "Right-angle cantilever",
        ["time t", "displacement along e3"],
        curves,
    )
}

fn converged(context: &mut Context) -> Result<(), CaseError> {
    let file = mesh(&context.file(FILE)?, 5, 3);
    let run = context.motion(&file, &["tip", "elbow"], Run::step(0.01).to(17.0))?;
    let [tip, elbow] = [0, 1].map(|k| height(&run, k));
    let source = "independent: spectral elements, Gauss, D01";
    for (curve, name, span, sign, (t, z), tolerance) in [
        (
            &tip,
            "tip, first maximum",
            [5.0, 10.0],
            1.0,
            (7.438, 8.2521),
            1e-3,
        ),
        (
            &tip,
            "tip, minimum",
            [12.0, 17.0],
            -1.0,
            (15.875, -9.727),
            2e-3,
        ),
        (
            &elbow,
            "elbow, first maximum",
            [1.0, 5.0],
            1.0,
            (3.1, 5.5129),
            1e-3,
        ),
        (
            &elbow,
            "elbow, minimum",
            [8.0, 14.0],
            -1.0,
            (10.862, -4.06),
            2e-3,
        ),
    ] {
        let (at, value) = extremum(curve, span, sign);
        context.compare(format!("{name}: height"), value, z, tolerance, source);
        context.compare(format!("{name}: time"), at, t, 0.02, source);
    }
    for (curve, name, span, sign, z) in [
        (&tip, "tip, first maximum", [5.0, 10.0], 1.0, 8.25),
        (&tip, "tip, minimum", [12.0, 17.0], -1.0, -9.73),
        (&elbow, "elbow, minimum", [8.0, 14.0], -1.0, -4.06),
    ] {
        let (_, value) = extremum(curve, span, sign);
        let source = "other code: Exudyn, 40 elements, h = 0.005";
        context.compare(name, value, z, 0.005 + 2e-3, source);
    }
    for (name, span, sign, z) in [
        ("tip, first maximum", [5.0, 10.0], 1.0, 8.2513),
        ("tip, minimum", [12.0, 17.0], -1.0, -9.734),
    ] {
        let (_, value) = extremum(&tip, span, sign);
        let source = "other code: AeroBeams, 20 elements per leg, h = 0.05";
        context.compare(name, value, z, 0.01, source);
    }
    Ok(())
}
