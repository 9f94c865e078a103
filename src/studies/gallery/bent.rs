//! Planar linkages with a flexible part.

use super::case::{CaseProblem, CaseReport, until};
use super::linkages::{gap, last};
use super::motion::History;
use crate::input::{ModelFile, Stiffness, Tensor};
use crate::output::plot::PlotCurve;
use nalgebra::Vector3;

/// All stiffnesses of all sections times a factor.
pub(super) fn stiffer(file: &ModelFile, factor: f64) -> ModelFile {
    let mut file = file.clone();
    for stiffness in (file.sections.values_mut()).filter_map(|s| s.stiffness.as_mut()) {
        let Stiffness { EA, GA, GJ, EI } = stiffness;
        let all = [EA, GJ].into_iter().chain(GA).chain(EI);
        all.for_each(|x| *x *= factor);
    }
    file
}

/// The flexible part with 8 quadratic elements, in steps of 5e-4. Half the step changes the positions below by
/// 4e-6 and the deflection of the middle by 5e-5; half the elements by 2e-5 and 1.2e-4, a sixteenth of which
/// remains. The tolerances are twice the sum of both; the independent values are within 4e-6.
fn fine(report: &CaseReport, file: &ModelFile, nodes: &[&str]) -> Result<History, CaseProblem> {
    let mut file = file.clone();
    file.lines[0].elements = 8;
    report.motion(&until(&file, 5e-4, 2.0), nodes)
}

const POSITION: f64 = 1e-5;
const BENDING: f64 = 1e-4;
/// `tests/studies/rods.rs`
const INDEPENDENT: &str =
    "independent: finite volumes, ends on crank and carrier, Nyström's method";

/// Signed distance of the second watched node, a middle, from the line between the first and the third.
fn off_the_line(run: &History, t: f64) -> f64 {
    let [a, m, b] = [0, 1, 2].map(|node| run.at(node, t).position);
    let chord = b - a;
    chord.cross(&(m - a)).dot(&Vector3::z()) / chord.norm()
}

/// A four-bar linkage with a flexible coupler.
pub(super) fn coupler(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let rigid = report.model("four_bar")?;
    let file = report.model("four_bar_flexible")?;
    // The coupler of the other file weighs 1; this one weighs its length.
    let mut alike = rigid.clone();
    let l = 1.5;
    // Both start at rest.
    alike.joints[0].rate = None;
    alike.bodies[1].mass = l;
    if let Some(Tensor::Full(rows)) = &mut alike.bodies[1].inertia {
        rows.iter_mut().flatten().for_each(|x| *x *= l);
    }
    let files = [alike, stiffer(&file, 1e3)].map(|file| until(&file, 1e-3, 2.0));
    let runs = report.motions(files, &["coupler tip"])?;
    let [a, b] = runs.map(|run| last(&run, 0).position);
    let source = "independent: the rigid linkage, whose loop closes implicitly";
    for (k, name) in ["e1", "e2"].into_iter().enumerate() {
        let what = format!("tip at t = 2 along {name}, coupler 1000 times stiffer");
        report.compare(what, b[k], a[k], POSITION, source);
    }
    let watched = ["crank tip", "coupler/8", "coupler tip", "rocker tip"];
    let bent = fine(report, &file, &watched)?;
    for (t, [x, y, off]) in [
        (0.5, [1.056_236, 1.863_953, -0.007_841]),
        (1.25, [-0.224_015, 0.665_558, 0.024_064]),
        (2.0, [1.574_806, 1.941_485, -0.003_976]),
    ] {
        let tip = bent.at(2, t).position;
        let what = format!("tip at t = {t}, bent coupler,");
        report.compare_parts(&what, &[tip.x, tip.y], &[x, y], POSITION, INDEPENDENT);
        let what = format!("middle off the line between the ends at t = {t}");
        let found = off_the_line(&bent, t);
        report.compare(what, found, off, BENDING, INDEPENDENT);
    }
    let open = gap(&bent, [2, 3]);
    report.compare_gap("largest gap of the loop", open, 1e-13);
    let source = "theory: generalised-alpha keeps energy but for its damping";
    let what = "largest relative change of energy";
    report.compare(what, bent.energy_error(), 0.0, 1e-3, source);
    Ok(())
}

/// Lengths of the crank and of the rod of the slider-crank mechanism.
const CRANK: f64 = 0.4;
const ROD: f64 = 1.0;

/// A slider-crank mechanism with a flexible rod.
pub(super) fn connecting_rod(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("slider_crank_flexible")?;
    let stiff = report.motion(&until(&stiffer(&file, 1e3), 5e-4, 1.0), &["slider"])?;
    let source = "exact: closed-form kinematics of the driven crank, which has turned by 6 rad";
    let what = "slider at t = 1, rod 1000 times stiffer";
    let y = 6.0_f64.sin() * CRANK;
    let x = 6.0_f64.cos() * CRANK + (ROD * ROD - y * y).sqrt();
    report.compare(what, last(&stiff, 0).position.x, x, POSITION, source);
    let watched = ["crank pin", "rod/8", "slider", "rod end"];
    let bent = fine(report, &file, &watched)?;
    // At t = 0.5 half the step changes it by 1e-5 only, twice as many elements by 7e-7.
    for (t, [x, off], bending) in [
        (0.5, [1.201_438, 0.000_629], 3e-5),
        (1.0, [1.377_863, -0.003_715], BENDING),
        (2.0, [1.217_908, -0.005_812], BENDING),
    ] {
        let what = format!("slider at t = {t}, bent rod");
        let found = bent.at(2, t).position.x;
        report.compare(what, found, x, POSITION, INDEPENDENT);
        let what = format!("middle off the line between the ends at t = {t}");
        let found = off_the_line(&bent, t);
        report.compare(what, found, off, bending, INDEPENDENT);
    }
    let open = gap(&bent, [2, 3]);
    report.compare_gap("largest gap of the loop", open, 1e-13);
    let source = "theory: what the crank supplies is there, but for the scheme's damping";
    let off = bent.summary.energy.map_or(f64::NAN, |e| e.largest_defect);
    let what = "largest relative energy defect";
    report.compare(what, off / bent.largest_kinetic(), 0.0, 1e-3, source);
    let displacement = |node: usize, run: &History| run.curve(node, |s| s.position.x);
    report.figure(
        "Slider-crank mechanism",
        ["time t", "slider"],
        vec![
            PlotCurve::new("flexible rod", displacement(2, &bent)),
            PlotCurve::new("rod 1000 times stiffer", displacement(0, &stiff)),
        ],
    )
}
