//! Snap-through: paths followed through their limit points.

use super::case::{CaseProblem, CaseReport, StepRecord, meshed};
use crate::output::plot::PlotCurve;
use pullback_elements::model::Dof;
use pullback_integrators::statics::{ArcLengthOptions, Event};

/// S11: Lee's frame.
pub(super) fn lee_frame(report: &mut CaseReport) -> Result<(), CaseProblem> {
    const EXACT: &str = "exact curve: independent shooting, S11";
    const FORCE: f64 = 20000.0;
    let file = report.model("lee_frame")?;
    let mut frame = report.build(&file, "load")?;
    let points = [
        (20.0, 13448.637234, 5.250298),
        (40.0, 17795.965941, 17.543385),
        (60.0, 14829.873945, 52.19503),
    ];
    let mut events = vec![(Event::TurningPoint, false)];
    for (v, ..) in points {
        events.push((frame.passes(Dof::Y, -v)?, false));
    }
    events.push((Event::Load(1.0), true));
    let records = frame.trace(&ArcLengthOptions {
        first_step: 0.02,
        max_step: 0.04,
        events,
        ..ArcLengthOptions::default()
    })?;
    let first = |event: usize| records.iter().find(|r| r.event == Some(event));
    let turns: Vec<_> = records.iter().filter(|r| r.event == Some(0)).collect();
    // Load, deflection and displacement along e1.
    let seen = |r: Option<&&StepRecord>| {
        r.map_or([f64::NAN; 3], |r| [r.t * FORCE, -r.state.d.y, r.state.d.x])
    };
    let [p, v, u] = seen(turns.first());
    for (quantity, computed, exact) in [
        ("limit load", p, 18546.558),
        ("deflection at the limit load", v, 48.751),
        ("displacement along e1 there", u, 26.8786),
    ] {
        report.compare(quantity, computed, exact, 1e-5 * exact, EXACT);
    }
    let source = "published: Lee et al. 1968, 0.2 %";
    report.compare("limit load", p, 18552.0, 37.0, source);
    let source = "published: Simo & Vu-Quoc 1986, 10 quadratic elements, 0.2 %";
    report.compare("limit load", p, 18532.0, 37.0, source);
    for (k, (v, load, u)) in points.into_iter().enumerate() {
        let [p, _, x] = seen(first(k + 1).as_ref());
        let quantity = format!("load at deflection {v}");
        report.compare(quantity, p, load, 1e-5 * load, EXACT);
        let quantity = format!("displacement along e1 at deflection {v}");
        report.compare(quantity, x, u, f64::min(1e-5 * u, 1e-4), EXACT);
    }
    let (what, count) = ("turning points of the load up to 20 000", turns.len());
    let source = "published: Simo & Vu-Quoc 1986, figure";
    report.compare(what, count as f64, 2.0, 0.0, source);
    let path = |pick: fn(&StepRecord) -> f64| -> Vec<(f64, f64)> {
        std::iter::once((0.0, 0.0))
            .chain(records.iter().map(|r| (pick(r), r.t * FORCE)))
            .collect()
    };
    let along_e2 = points.iter().map(|&(v, p, _)| (v, p));
    let exact = along_e2.chain(points.iter().map(|&(_, p, u)| (u, p)));
    report.figure(
        "Lee's frame",
        ["displacement of the loaded point", "load"],
        vec![
            PlotCurve::new("along e1", path(|r| r.state.d.x)),
            PlotCurve::new("along −e2", path(|r| -r.state.d.y)),
            PlotCurve::points("exact curve", exact.collect()),
        ],
    )
}

/// S12: the deep circular arch.
pub(super) fn deep_arch(report: &mut CaseReport) -> Result<(), CaseProblem> {
    const EXACT: &str = "exact curve: independent shooting, S12";
    const LOAD: f64 = 1000.0;
    // States after the limit point: load, deflection of the crown and its
    // displacement along e1. Shooting with the equations of the plane arch (Runge and Kutta's
    // method), continued from the unloaded state; it gives the limit load of S12 to all its digits.
    const BEYOND_EXACT: &str =
        "exact curve: independent shooting, continued beyond the limit point";
    const BEYOND: [(f64, f64, f64); 2] = [
        (500.0, 120.354209478, -64.933228891),
        (0.0, 118.486579799, -60.880951149),
    ];
    let file = report.model("deep_arch")?;
    let path = |elements: usize, order: usize, events| -> Result<Vec<StepRecord>, CaseProblem> {
        let file = meshed(&file, elements, order);
        report.build(&file, "crown")?.trace(&ArcLengthOptions {
            first_step: 0.01,
            max_step: 0.03,
            events,
            ..ArcLengthOptions::default()
        })
    };
    // The last occurrence of an event.
    let point = |records: &[StepRecord], event: usize| {
        let found = records.iter().rfind(|r| r.event == Some(event));
        found.map_or([f64::NAN; 3], |r| [LOAD * r.t, -r.state.d.y, r.state.d.x])
    };
    let [first, second] = BEYOND.map(|(load, ..)| Event::Load(load / LOAD));
    let events = vec![(Event::TurningPoint, false), (first, false), (second, true)];
    let whole = path(30, 3, events)?;
    let fine = point(&whole, 0);
    let to_limit = || vec![(Event::TurningPoint, true)];
    let linear = point(&path(20, 1, to_limit())?, 0);
    let curved = point(&path(10, 2, to_limit())?, 0);
    for (what, found, exact) in [
        ("limit load", fine[0], 897.2891),
        ("crown deflection there", fine[1], 113.7308),
        ("crown displacement along e1", fine[2], -61.1417),
    ] {
        report.compare(what, found, exact, 1e-3, EXACT);
    }
    for (k, (load, deflection, along)) in BEYOND.into_iter().enumerate() {
        let [_, v, u] = point(&whole, k + 1);
        let quantity = format!("crown deflection at load {load} beyond the limit point");
        report.compare(quantity, v, deflection, 1e-5, BEYOND_EXACT);
        let quantity = format!("crown displacement along e1 at load {load} beyond it");
        report.compare(quantity, u, along, 1e-5, BEYOND_EXACT);
    }
    let passed = |event: usize| whole.iter().filter(|r| r.event == Some(event)).count();
    let source = "exact curve: one limit point before zero load";
    let what = "turning points of the load";
    report.compare(what, passed(0) as f64, 1.0, 0.0, source);
    let source = "published: DaDeppo & Schmidt 1975";
    report.compare("limit load", fine[0], 897.0, 0.5, source);
    let source = "published: Simo & Vu-Quoc 1986, the same mesh";
    let what = "limit load, 40 2-node elements";
    report.compare(what, linear[0], 905.28, 0.5, source);
    let source = "published: Ibrahimbegovic 1995, the same mesh";
    let what = "limit load, 20 3-node elements";
    report.compare(what, curved[0], 897.3, 0.5, source);
    Ok(())
}

/// A column beyond its critical load.
pub(super) fn column(report: &mut CaseReport) -> Result<(), CaseProblem> {
    const EXACT: &str = "exact: the elastica, P L²/EI = 4 K(k)², by elliptic integrals";
    const FORCE: f64 = 20.0;
    let file = report.model("column")?;
    let end = ArcLengthOptions {
        switch_branch: true,
        max_step: 0.05,
        events: vec![
            (Event::Bifurcation, false),
            (Event::Load(18.0 / FORCE), true),
        ],
        ..ArcLengthOptions::default()
    };
    let head = report.build(&file, "head")?.trace(&end)?;
    let middle = report.build(&file, "column/12")?.trace(&end)?;
    let critical = head.iter().find(|r| r.event == Some(0));
    let critical = critical.map_or(f64::NAN, |r| FORCE * r.t);
    let exact = std::f64::consts::PI.powi(2);
    report.compare("critical load", critical, exact, 1e-6 * exact, EXACT);
    let last = |records: &[StepRecord]| records.last().map(|r| r.state.d);
    let shortening = last(&head).map_or(f64::NAN, |d| -d.z);
    let deflection = last(&middle).map_or(f64::NAN, |d| d.x.abs());
    // 2 (1 − E/K) + P/EA and k/K.
    for (quantity, found, exact) in [
        ("shortening at the load 18", shortening, 0.847976419806),
        ("deflection at the load 18", deflection, 0.402632385551),
    ] {
        report.compare(quantity, found, exact, 1e-5, EXACT);
    }
    Ok(())
}
