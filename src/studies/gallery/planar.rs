//! Plane cantilevers with exact solutions.

use super::case::{CaseProblem, CaseReport, StepRecord, meshed, order};
use crate::input::ModelFile;
use crate::output::plot::PlotCurve;
use std::f64::consts::{PI, TAU};

/// Rotation about e3 in (−π, π].
fn angle(record: &StepRecord) -> f64 {
    record.state.R[(1, 0)].atan2(record.state.R[(0, 0)])
}

/// S03: one and two full circles.
pub(super) fn rollup(report: &mut CaseReport) -> Result<(), CaseProblem> {
    const SOURCE: &str = "exact: Euler";
    const EI: f64 = 2.0;
    let file = report.model("rollup")?;
    let loads = [0.25, 0.5, 0.75, 1.0];
    for turns in [1, 2] {
        let loads = &loads[..2 * turns];
        let mut beam = report.build(&file, "tip")?;
        let record = &beam.at_loads(loads)?[loads.len() - 1];
        // One and two turns give the same tip position: the energy ½ M φ tells them apart.
        let phi = TAU * turns as f64;
        let energy = beam.model.strain_energy(record.t) / EI;
        let what = format!("strain energy after {turns} turns over EI/L");
        report.compare(what, energy, 0.5 * phi * phi, 1e-9, SOURCE);
        let tip = format!("tip displacement after {turns} turns,");
        report.compare_vector(&tip, record.state.d, [-1.0, 0.0, 0.0], 1e-9, SOURCE);
        let rest = format!("rotation left over after {turns} turns");
        report.compare(rest, angle(record), 0.0, 1e-9, SOURCE);
    }
    // One element bends by any angle below π with the exact rotation.
    let mut one = file.clone();
    one.lines[0].elements = 1;
    let loads = [2.0 / (4.0 * PI), 3.0 / (4.0 * PI)];
    let record = report.build(&one, "tip")?.at_loads(&loads)?[1];
    let what = "rotation of a single element";
    report.compare(what, angle(&record), 3.0, 1e-10, SOURCE);
    Ok(())
}

/// S04: Mattiasson's elastica.
pub(super) fn elastica(report: &mut CaseReport) -> Result<(), CaseProblem> {
    // P L²/EI: w/L, u/L, rotation.
    const EXACT: [(f64, [f64; 3]); 11] = [
        (0.2, [0.06636448214, 0.002646548341, 0.09963616304]),
        (0.4, [0.1309752421, 0.01035392155, 0.1971546237]),
        (0.6, [0.1923502797, 0.02248766798, 0.2907377668]),
        (0.8, [0.249451542, 0.03816561324, 0.3790630076]),
        (1.0, [0.3017207738, 0.05643323628, 0.4613519497]),
        (2.0, [0.4934574804, 0.1606417208, 0.7817498316]),
        (4.0, [0.6699641813, 0.3289412422, 1.121239347]),
        (5.0, [0.7137915236, 0.3876283607, 1.215368118]),
        (6.0, [0.7445711489, 0.4345888287, 1.283697286]),
        (8.0, [0.784982375, 0.5048277321, 1.374431507]),
        (10.0, [0.8106090249, 0.5549955978, 1.430285539]),
    ];
    let file = report.model("elastica")?;
    let loads = EXACT.map(|(a, _)| a / 10.0);
    let records = report.build(&file, "tip")?.at_loads(&loads)?;
    for ((a, exact), r) in EXACT.iter().zip(&records) {
        let computed = [r.state.d.y, -r.state.d.x, angle(r)];
        for ((name, c), e) in ["w/L", "u/L", "rotation"].iter().zip(computed).zip(exact) {
            let source = "exact: elliptic integrals (Mattiasson 1981)";
            report.compare(format!("{name} at PL²/EI = {a}"), c, *e, 1e-8, source);
        }
    }
    Ok(())
}

/// S05: Géradin's cantilever.
pub(super) fn cantilever(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("cantilever")?;
    let r = report.tip(&file)?;
    let rotation = (-r.state.R[(2, 0)].atan2(r.state.R[(0, 0)])).abs();
    for (name, computed, exact, published) in [
        ("shortening", -r.state.d.x, 0.596471272235, 0.596),
        ("deflection", r.state.d.z, 2.15969389449, 2.159),
        ("rotation", rotation, 0.672006063844, 0.672),
    ] {
        let source = "exact curve: independent shooting, S05";
        report.compare(name, computed, exact, 1e-9, source);
        let source = "published: Géradin & Cardona 2001 (3 digits)";
        let what = format!("{name}, published digits");
        report.compare(what, computed, published, 1e-3, source);
    }
    Ok(())
}

/// Tip displacement (shortening, deflection) of the stub with a mesh and a force.
fn stub(
    report: &CaseReport,
    file: &ModelFile,
    elements: usize,
    order: usize,
    force: f64,
) -> Result<StepRecord, CaseProblem> {
    let mut file = meshed(file, elements, order);
    file.loads[0].force = Some([0.0, force, 0.0]);
    report.tip(&file)
}

/// S09: a stubby cantilever in which shear counts.
pub(super) fn shear_flexible(report: &mut CaseReport) -> Result<(), CaseProblem> {
    const EXACT: &str = "exact curve: independent shooting, S09";
    const PUBLISHED: &str = "published: Nachbagauer et al. 2011, converged mesh";
    let file = report.model("shear_flexible")?;
    let large = stub(report, &file, 10, 3, 6.25e7)?;
    for (what, computed, exact) in [
        ("shortening", -large.state.d.x, 0.150971144239),
        ("deflection", large.state.d.y, 0.710568597854),
        ("rotation", angle(&large), 0.520173166012),
    ] {
        report.compare(format!("large load, {what}"), computed, exact, 1e-9, EXACT);
    }
    let (what, d) = ("large load, deflection", large.state.d.y);
    report.compare(what, d, 0.71056837, 1e-6, PUBLISHED);
    let d = stub(report, &file, 10, 3, 62500.0)?.state.d;
    let what = "small load, shortening";
    report.compare(what, -d.x, 1.888491636404e-07, 1e-15, EXACT);
    let what = "small load, deflection";
    report.compare(what, d.y, 0.0008099032539769, 1e-12, EXACT);
    let mut errors = Vec::new();
    for elements in [2, 4, 8, 16] {
        let r = stub(report, &file, elements, 1, 6.25e7)?;
        errors.push(0.710568597854 - r.state.d.y);
    }
    let source = "theory: h², no shear locking at slenderness 4";
    for (k, e) in errors.windows(2).enumerate() {
        let [from, to] = [2 << k, 4 << k];
        let what = format!("order of the deflection, {from} to {to} 2-node elements");
        report.compare(what, order(e[0], e[1]), 2.0, 0.1, source);
    }
    Ok(())
}

/// S18: a transverse follower force.
pub(super) fn follower(report: &mut CaseReport) -> Result<(), CaseProblem> {
    // F: ux, uy, rotation modulo a turn.
    const EXACT: [(f64, [f64; 3]); 8] = [
        (1e4, [-41.69280982, 71.10951873, 1.34023618]),
        (2e4, [-92.02918421, 75.38621521, 2.29449211]),
        (3e4, [-108.70890889, 60.54841418, 2.83801516]),
        (4e4, [-106.99446559, 50.37532659, 3.08798014]),
        (5e4, [-97.99151017, 44.8006409, 3.13903109]),
        (6e4, [-85.76708862, 40.06418127, 3.04816023]),
        (7e4, [-72.43392741, 32.97705002, 2.8504906]),
        (9e4, [-52.41067404, 6.0436343, 2.23838433]),
    ];
    let file = report.model("follower")?;
    let loads = EXACT.map(|(f, _)| f / 9e4);
    let records = report.build(&file, "tip")?.at_loads(&loads)?;
    let path = |pick: fn(&[f64; 3]) -> f64| EXACT.iter().map(|(f, e)| (*f, pick(e))).collect();
    let fine: Vec<f64> = (1..=90).map(|k| f64::from(k) / 90.0).collect();
    let curve = report.build(&file, "tip")?.at_loads(&fine)?;
    let along = |pick: fn(&StepRecord) -> f64| {
        let points = curve.iter().map(|r| (r.t * 9e4, pick(r)));
        std::iter::once((0.0, 0.0)).chain(points).collect()
    };
    report.figure(
        "Cantilever with follower force",
        ["force", "tip displacement"],
        vec![
            PlotCurve::new("along e1", along(|r| r.state.d.x)),
            PlotCurve::new("along e2", along(|r| r.state.d.y)),
            PlotCurve::points("exact, along e1", path(|e| e[0])),
            PlotCurve::points("exact, along e2", path(|e| e[1])),
        ],
    )?;
    for ((f, exact), r) in EXACT.iter().zip(&records) {
        let computed = [r.state.d.x, r.state.d.y, angle(r).rem_euclid(TAU)];
        for ((name, c), e) in ["ux", "uy", "rotation"].iter().zip(computed).zip(exact) {
            let source = "exact curve: independent shooting, S18";
            report.compare(format!("{name} at F = {f}"), c, *e, 1e-7, source);
        }
    }
    Ok(())
}
