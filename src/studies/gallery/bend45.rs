//! The 45° bend: the thesis's case, convergence to the exact curve, effects of a superposed
//! rotation and of another load path.

use super::case::{CaseProblem, CaseReport, meshed, order};
use crate::input::{DofName, Fix, Interpolation, ModelFile, PrescribedMotion, Time};
use nalgebra::Vector3;
use pullback_integrators::statics::StaticOptions;
use std::f64::consts::PI;

/// The thesis's mesh and result.
pub(super) fn thesis(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("bend45")?;
    let d = report.tip(&file)?.state.d;
    let mut bend = report.build(&file, "tip")?;
    let records = bend.solve(&StaticOptions::equal_steps(24))?;
    let most = records.iter().map(|r| r.iterations).max().unwrap_or(0);
    let source = "published: Mäkinen 2004 4.2, 4 to 5 each";
    let what = "most iterations of a step, 24 equal steps";
    report.compare(what, most as f64, 5.0, 1.0, source);
    let (what, published) = ("tip displacement, 8 elements,", [-23.696, -13.668, 53.497]);
    report.compare_vector(what, d, published, 1e-3, "published: Mäkinen 2004 4.2");
    Ok(())
}

/// Stiffness with GJ = EI, for which the exact curve is known, on a mesh.
fn variant(file: &ModelFile, elements: usize, order: usize) -> ModelFile {
    let mut file = meshed(file, elements, order);
    for section in file.sections.values_mut() {
        if let Some(s) = &mut section.stiffness {
            s.GJ = s.EI[0];
        }
    }
    file
}

/// The same bend with geodesic interpolation.
fn geodesic(file: &ModelFile) -> ModelFile {
    let mut file = file.clone();
    file.lines[0].interpolation = Interpolation::Geodesic;
    file
}

/// Meshes of two- and three-node elements against the exact curve.
pub(super) fn convergence(report: &mut CaseReport) -> Result<(), CaseProblem> {
    // Independent Cosserat shooting; its arc turns towards −e2.
    const EXACT: [f64; 3] = [-23.5602395450204, -13.6045213473098, 53.474858791802];
    const SOURCE: &str = "exact curve: independent shooting, S01 variant A";
    let file = report.model("bend45")?;
    let exact = Vector3::from(EXACT);
    let linear = "theory: linear elements converge with h²";
    let quadratic = "theory: quadratic elements converge with h⁴ at nodes";
    for (k, expected, tolerance, source) in [(1, 2.0, 0.1, linear), (2, 4.0, 0.3, quadratic)] {
        let mut errors = Vec::new();
        for elements in [8, 16, 32, 64] {
            let d = report.tip(&variant(&file, elements, k))?.state.d;
            errors.push((d - exact).norm());
            if (k, elements) == (2, 64) {
                report.compare_vector("tip, 64 3-node elements,", d, EXACT, 1e-5, SOURCE);
            }
        }
        for (m, e) in errors.windows(2).enumerate() {
            let [from, to] = [8 << m, 16 << m];
            let what = format!("order, {}-node, {from} to {to} elements", k + 1);
            report.compare(what, order(e[0], e[1]), expected, tolerance, source);
        }
    }
    let d = report.tip(&variant(&file, 32, 3))?.state.d;
    report.compare_vector("tip, 32 4-node elements,", d, EXACT, 1e-7, SOURCE);
    // Geodesic elements converge to the same curve.
    let geodesic = geodesic(&file);
    for (nodes, expected) in [(2, 2.0), (3, 4.0)] {
        let mut errors = Vec::new();
        for elements in [16, 32] {
            let d = report
                .tip(&variant(&geodesic, elements, nodes - 1))?
                .state
                .d;
            errors.push((d - exact).norm());
        }
        let what = format!("order, geodesic {nodes}-node, 16 to 32 elements");
        let source = "theory: as with total rotation vectors";
        report.compare(what, order(errors[0], errors[1]), expected, 0.3, source);
    }
    let d = report.tip(&variant(&geodesic, 32, 3))?.state.d;
    report.compare_vector("tip, 32 geodesic 4-node elements,", d, EXACT, 1e-7, SOURCE);
    Ok(())
}

/// S21: path independence, and invariance under superposed rotations.
pub(super) fn objectivity(report: &mut CaseReport) -> Result<(), CaseProblem> {
    const CLOSED: &str = "exact: S21, conservative loads";
    const TURN: f64 = 1.6;
    let file = report.model("bend45")?;

    // Load and unload.
    let time = "{ table = [[0, 0], [1, 1], [2, 0]] }";
    let cycle = report.model_with("bend45", &[("loads.0.time", time)])?;
    let end = report.build(&cycle, "tip")?.end(&until(2.0))?.state.d;
    let what = "tip after loading and unloading";
    report.compare(what, end.norm(), 0.0, 1e-9, CLOSED);

    // Two loads in either order.
    let mut tips = Vec::new();
    for [first, second] in [[0, 1], [1, 0]] {
        let load = |force: [u32; 3], from: u32| {
            let time = [[from, 0], [from + 1, 1]];
            format!("{{ node = \"tip\", force = {force:?}, time = {{ table = {time:?} }} }}")
        };
        let loads = [load([0, 0, 600], first), load([0, 300, 0], second)];
        let both = report.model_with("bend45", &[("loads", &format!("[{}]", loads.join(", ")))])?;
        tips.push(report.build(&both, "tip")?.end(&until(2.0))?.state.d);
    }
    let gap = (tips[0] - tips[1]).norm();
    report.compare("tip for two orders of two loads", gap, 0.0, 1e-9, CLOSED);

    // The same bend with a follower force, its clamp turned: the strain energy must not change.
    let geodesic = geodesic(&file);
    for (file, name) in [(&file, ""), (&geodesic, "geodesic ")] {
        let free = energy(report, file, 8, TURN, 0.0)?;
        let scale = energy(report, file, 8, 0.0, 300.0)?;
        let what =
            format!("strain energy of the unloaded {name}bend, turned by {TURN} rad, relative");
        report.compare(what, free / scale, 0.0, 1e-12, "exact: S21");
    }
    let straight = energy(report, &geodesic, 8, 0.0, 300.0)?;
    for turn in [1e-3, 0.5, TURN, 3.1, 2.5 * PI] {
        let what = format!(
            "relative change of strain energy when the loaded geodesic bend is turned by \
             {turn:.4} rad, 8 elements"
        );
        let change = energy(report, &geodesic, 8, turn, 300.0)? / straight - 1.0;
        let source = "exact: S21; to what Newton's method leaves";
        report.compare(what, change, 0.0, 1e-10, source);
    }
    let mut errors = Vec::new();
    for elements in [16, 32] {
        let straight = energy(report, &file, elements, 0.0, 300.0)?;
        errors.push(energy(report, &file, elements, TURN, 300.0)? / straight - 1.0);
    }
    let what = "relative change of strain energy when the loaded bend is turned, 32 elements";
    let source = "exact: S21; total rotation vectors meet it only up to the mesh error";
    report.compare(what, errors[1], 0.0, 1e-3, source);
    let what = "order in which that change vanishes with the mesh";
    let source = "theory: interpolation error of linear elements";
    report.compare(what, order(errors[0], errors[1]), 2.0, 0.2, source);
    Ok(())
}

/// Load stepping from 0 to a load parameter.
fn until(to: f64) -> StaticOptions {
    StaticOptions {
        to,
        ..StaticOptions::default()
    }
}

/// Strain energy of the bend under a follower force, with its clamp turned afterwards by an angle.
fn energy(
    report: &CaseReport,
    file: &ModelFile,
    elements: usize,
    turn: f64,
    force: f64,
) -> Result<f64, CaseProblem> {
    let mut file = file.clone();
    file.lines[0].elements = elements;
    file.loads[0].force = Some([0.0, 0.0, force]);
    file.loads[0].follower = true;
    if turn != 0.0 {
        let axis = Vector3::new(0.8, -1.1, 0.9).normalize();
        file.supports[0].fix = Some(Fix::List(DofName::ALL[..3].to_vec()));
        let ramp = |part: f64| Some(Time::Table(vec![[1.0, 0.0], [2.0, turn * part]]));
        file.supports[0].prescribed = Some(PrescribedMotion {
            rx: ramp(axis.x),
            ry: ramp(axis.y),
            rz: ramp(axis.z),
            ..PrescribedMotion::default()
        });
        file.loads[0].time = Some(Time::Table(vec![[0.0, 0.0], [1.0, 1.0]]));
    }
    let mut watched = report.build(&file, "tip")?;
    let options = until(if turn != 0.0 { 2.0 } else { 1.0 });
    watched.end(&options)?;
    Ok(watched.model.strain_energy(options.to))
}
