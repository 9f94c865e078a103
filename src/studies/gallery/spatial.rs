//! Cantilevers that bend and twist in space.

use super::case::{CaseProblem, CaseReport, meshed};
use crate::input::Stiffness;
use nalgebra::{Matrix3, Vector3};
use pullback_integrators::statics::StaticOptions;
use pullback_manifold::so3;
use std::f64::consts::PI;

/// S07: pretwisted by 90°.
pub(super) fn twisted(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("twisted")?;
    let d = report.tip(&file)?.state.d;
    let exact = [-1.14152599954, -1.718053346465, -3.593213240272];
    let source = "published: kynema-fmb and BeamDyn (Wang et al. 2017)";
    report.compare_vector("tip displacement", d, exact, 1e-9, source);
    let solid = [-1.134192, -1.714467, -3.58423];
    let source = "published: ANSYS solid (Wang et al. 2017), 1 %";
    report.compare_vector("tip displacement, solid model,", d, solid, 0.036, source);
    Ok(())
}

/// S08: the Princeton beam.
pub(super) fn princeton(report: &mut CaseReport) -> Result<(), CaseProblem> {
    const P: f64 = 8.896;
    const YZ: [[f64; 2]; 7] = [
        [0.0107141763, 0.0],
        [0.01061328706, 0.04208232124],
        [0.0101116963, 0.07939482948],
        [0.008837226265, 0.108987937],
        [0.006604665004, 0.129887616],
        [0.003538889001, 0.14219437],
        [0.0, 0.146245978],
    ];
    let file = report.model("princeton")?;
    for (k, [y, z]) in YZ.into_iter().enumerate() {
        let degrees = 15.0 * k as f64;
        let (s, c) = degrees.to_radians().sin_cos();
        let mut file = file.clone();
        file.loads[0].force = Some([0.0, P * c, P * s]);
        let d = report.tip(&file)?.state.d;
        let source = "published: ANSYS beam (Obrezkov et al. 2022), 0.5 % of the largest";
        for (name, computed, published, largest) in
            [("y", d.y, y, YZ[0][0]), ("z", d.z, z, YZ[6][1])]
        {
            let (what, tolerance) = (format!("u{name} at {degrees}°"), 0.005 * largest);
            report.compare(what, computed, published, tolerance, source);
        }
    }
    Ok(())
}

/// Position and rotation at the end of a rod of constant curvature κ (material components).
fn exact_helix(kappa: &Vector3<f64>, length: f64) -> (Vector3<f64>, Matrix3<f64>) {
    let psi = kappa * length;
    // ∫ R(κ s) ds = L T(κL)ᵀ: T is the mean of the rotations exp(−s Ψ~) over s in [0, 1].
    (
        so3::tangent(&psi).tr_mul(&Vector3::x()) * length,
        so3::rotation(&psi),
    )
}

/// S17: a straight rod becomes a helix, at slenderness 10 to 10⁴.
pub(super) fn bending_torsion(report: &mut CaseReport) -> Result<(), CaseProblem> {
    const SOURCE: &str = "exact: helix of constant curvature (Harsch et al. 2023)";
    let (radius, height, coils) = (10.0, 50.0, 2.0);
    let c = height / (2.0 * PI * coils * radius);
    let a = 2.0 * PI * coils;
    let length = (1.0 + c * c).sqrt() * radius * a;
    let curvature = radius * a * a / (length * length);
    let kappa = Vector3::new(curvature * c, 0.0, curvature);
    let file = report.model("bending_torsion")?;
    let solve = |report: &CaseReport, order: usize, slenderness: f64, load: f64| {
        let mut file = meshed(&file, 100, order);
        // Round section of diameter L/slenderness with Young's modulus such that EI = 1.
        let thickness = length / slenderness;
        let EA = 16.0 / (thickness * thickness);
        for section in file.sections.values_mut() {
            section.stiffness = Some(Stiffness {
                EA,
                GA: [0.5 * EA; 2],
                GJ: 1.0,
                EI: [1.0; 2],
            });
        }
        let mut watched = report.build(&file, "tip")?;
        let options = StaticOptions {
            to: load,
            max_step: 0.1,
            ..StaticOptions::default()
        };
        Ok::<_, CaseProblem>(watched.end(&options)?.state)
    };
    for slenderness in [1e1, 1e2, 1e3, 1e4] {
        // At full load the coils are whole and errors of the position cancel: it is compared at 0.9.
        for (load, order, tolerance) in [(0.9, 2, 1e-7), (1.0, 1, 1e-9)] {
            let (position, R) = exact_helix(&(kappa * load), length);
            let state = solve(report, order, slenderness, load)?;
            let at = format!("at load {load}, slenderness {slenderness:e}");
            let what = format!("rotation matrix of the tip {at}");
            report.compare(what, (state.R - R).norm(), 0.0, 1e-9, SOURCE);
            let error = (Vector3::x() * length + state.d - position).norm() / length;
            let what = format!("position of the tip over length {at}");
            report.compare(what, error, 0.0, tolerance, SOURCE);
        }
    }
    Ok(())
}
