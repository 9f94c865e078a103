//! The conformance kit for elements: every law of an element in one line.
//!
//! ```
//! # use pullback_elements::{check, load::{NodalLoad, Which}, time::Constant};
//! check::element(&NodalLoad::new(Which::FollowerForce, [1.0, 2.0, 3.0], Constant(2.0))).assert();
//! ```
//!
//! A joint has one line as well: [`map`] of [`Hung`](crate::joint::Hung) of it. Places, slopes and
//! reports are those of [`pullback_manifold::check`]. Objectivity is no law: the
//! interpolation of total rotation vectors has it only in the limit of small elements.

#![allow(non_snake_case)]

use crate::element::{Element, Motion, Response};
use nalgebra::{DMatrix, DVector};
pub use pullback_manifold::check::map;
use pullback_manifold::check::{Forces, Random, Report, State, forces_at, states};
use pullback_manifold::system::Weights;

/// Checks every law of an element at every place within its domain.
///
/// Tangents by slope, at rest and in motion; symmetry where the element claims it; the force as
/// derivative of the energy where there is one; the power of its velocities where it dissipates;
/// that neither the residual nor a tangent depends on what else is asked for; and that a combined
/// tangent is the sum of its parts.
pub fn element(element: &dyn Element) -> Report {
    let n = element.dim();
    let states = states(n);
    // An element without energy answers zero: only one that differs somewhere is held to it.
    let energies: Vec<f64> = states
        .iter()
        .map(|(_, s)| element.energy(&motion(s)))
        .collect();
    let conservative = energies.iter().any(|&e| e != 0.0);
    let mut report = forces_at(
        &format!("element of {n} coordinates"),
        &states,
        element.is_symmetric(),
        |s| {
            let mut f = evaluate(element, s, Ask::All)?;
            f.energy = conservative.then(|| element.energy(&motion(s)));
            Some(f)
        },
    );
    let dissipative = states
        .iter()
        .any(|(_, s)| element.dissipation(&motion(s)) != 0.0);
    let mut random = Random::default();
    for (at, state) in &states {
        if let Some(all) = evaluate(element, state, Ask::All) {
            if dissipative {
                dissipation(&mut report, element, at, state, &all);
            }
            requests(&mut report, element, at, state, &all);
            iterates(&mut report, element, at, state, &all, &mut random);
            combination(&mut report, element, at, state, &all);
        }
    }
    report
}

/// Compares an element that is derived by hand with one that should be the same, for instance by
/// its [`energy`](crate::energy): residual, tangents, rate, stored energy and dissipation to 1e-12.
///
/// What [`element`] cannot see is an error in the force that its own tangents share.
pub fn same(found: &dyn Element, expected: &dyn Element) -> Report {
    let n = expected.dim();
    let mut report = Report::new(format!("two elements of {n} coordinates"));
    if found.dim() != n {
        let why = format!("{} coordinates and {n}", found.dim());
        report.impossible("dimensions", "everywhere", why);
        return report;
    }
    for (at, s) in &states(n) {
        let pair = [found, expected].map(|e| (e, evaluate(e, s, Ask::All)));
        let [(_, Some(f)), (_, Some(e))] = &pair else {
            if pair[0].1.is_some() != pair[1].1.is_some() {
                report.impossible(
                    "domain",
                    at,
                    "inside that of one, outside that of the other",
                );
            }
            continue;
        };
        let mut near = |law: &str, gap: f64, size: f64, cancelled: f64| {
            report.defect(law, at, gap, 1e-12 * size + 1e-14 * cancelled);
        };
        // What is zero is so by terms that cancel: stiffness times coordinates, force times these.
        let (r, K, x) = (e.r.norm(), e.K.norm(), 1.0 + s.x.norm());
        near("r", (&f.r - &e.r).norm(), r, K * x);
        near("K", (&f.K - &e.K).norm(), K, 0.0);
        let none = DMatrix::zeros(n, n);
        for (law, found, expected) in [("C", &f.C, &e.C), ("M", &f.M, &e.M)] {
            let [found, expected] = [found, expected].map(|m| m.as_ref().unwrap_or(&none));
            near(law, (found - expected).norm(), expected.norm(), 0.0);
        }
        if let (Some(found), Some(expected)) = (&f.r_t, &e.r_t) {
            near("r_t", (found - expected).norm(), expected.norm(), 0.0);
        }
        let [a, b] = [found, expected].map(|e| e.energy(&motion(s)));
        near("energy", (a - b).abs(), b.abs(), r * x);
        let [a, b] = [found, expected].map(|e| e.dissipation(&motion(s)));
        near("dissipation", (a - b).abs(), b.abs(), 0.0);
    }
    report
}

/// What is asked for in one evaluation.
#[derive(Clone, Copy, PartialEq)]
enum Ask {
    All,
    Residual,
    Stiffness,
}

fn motion(s: &State) -> Motion<'_> {
    Motion {
        t: s.t,
        x: s.x.as_slice(),
        v: s.v.as_slice(),
        a: s.a.as_slice(),
    }
}

fn evaluate(element: &dyn Element, s: &State, ask: Ask) -> Option<Forces> {
    evaluate_from(element, None, s, ask)
}

fn evaluate_from(
    element: &dyn Element,
    previous: Option<&DVector<f64>>,
    s: &State,
    ask: Ask,
) -> Option<Forces> {
    let n = element.dim();
    let matrix = || DMatrix::zeros(n, n);
    let (mut r, mut r_t) = (DVector::zeros(n), DVector::zeros(n));
    let (mut K, mut C, mut M) = (matrix(), matrix(), matrix());
    let moving = ask == Ask::All && !s.is_static();
    let mut out = Response {
        r: r.as_mut_slice(),
        K: (ask != Ask::Residual).then_some(K.as_mut_slice()),
        C: moving.then_some(C.as_mut_slice()),
        M: moving.then_some(M.as_mut_slice()),
        r_t: (ask == Ask::All).then_some(r_t.as_mut_slice()),
    };
    let done = match previous {
        None => element.evaluate(&motion(s), &mut out),
        Some(x) => element.evaluate_from(x.as_slice(), &motion(s), &mut out),
    };
    done.ok()?;
    Some(Forces {
        r,
        K,
        C: moving.then_some(C),
        M: moving.then_some(M),
        r_t: Some(r_t),
        energy: None,
    })
}

/// A request for less gives the same numbers, to the last bit.
fn requests(report: &mut Report, element: &dyn Element, at: &str, s: &State, all: &Forces) {
    let gap =
        |f: Option<Forces>, of: fn(&Forces, &Forces) -> f64| f.map_or(f64::NAN, |f| of(&f, all));
    report.defect(
        "r does not depend on what else is asked",
        at,
        gap(evaluate(element, s, Ask::Residual), |f, all| {
            (&f.r - &all.r).norm()
        }),
        0.0,
    );
    report.defect(
        "K does not depend on what else is asked",
        at,
        gap(evaluate(element, s, Ask::Stiffness), |f, all| {
            (&f.K - &all.K).norm() + (&f.r - &all.r).norm()
        }),
        0.0,
    );
    if s.is_static() {
        let n = s.x.len();
        let rest = State {
            v: DVector::zeros(n),
            a: DVector::zeros(n),
            ..s.clone()
        };
        // Sums of terms that are zero may still be ordered differently.
        let size = all.r.norm() + all.K.norm();
        report.defect(
            "statics is the motion at rest",
            at,
            gap(evaluate(element, &rest, Ask::All), |f, all| {
                (&f.r - &all.r).norm() + (&f.K - &all.K).norm()
            }),
            1e-14 * size,
        );
    }
}

/// The combined tangent is the sum of its parts, and an element that is dead has none.
fn combination(report: &mut Report, element: &dyn Element, at: &str, s: &State, all: &Forces) {
    let parts = [
        (1.0, Some(&all.K)),
        (2.0, all.C.as_ref()),
        (3.0, all.M.as_ref()),
    ];
    let mut sum = DMatrix::zeros(s.x.len(), s.x.len());
    let mut size = all.r.norm();
    for (weight, part) in parts {
        if let Some(part) = part {
            sum += part * weight;
            size += weight * part.norm();
        }
    }
    if element.is_dead() {
        report.defect("a dead element has no tangent", at, sum.norm(), 0.0);
    }
    let Some(combined) = element.combined() else {
        return;
    };
    let (mut r, mut S) = (all.r.clone() * 0.0, sum.clone() * 0.0);
    let weights = Weights {
        K: 1.0,
        C: 2.0,
        M: 3.0,
    };
    let (r_slice, S_slice) = (r.as_mut_slice(), S.as_mut_slice());
    let done = combined.evaluate_combined(None, &motion(s), weights, r_slice, S_slice);
    let gap = done.map_or(f64::NAN, |()| (r - &all.r).norm() + (S - &sum).norm());
    report.defect("S = cK K + cC C + cM M", at, gap, 1e-13 * size);
}

/// Damping takes the power it says, and never gives any.
///
/// Without inertia, what the velocities change in the force is damping: its power at ẋ is the
/// dissipation. With inertia only the sign is known, gyroscopic forces also have power.
fn dissipation(report: &mut Report, element: &dyn Element, at: &str, s: &State, all: &Forces) {
    let lost = element.dissipation(&motion(s));
    report.defect("dissipation >= 0", at, (-lost).max(0.0), 0.0);
    if s.is_static() {
        report.defect("no dissipation at rest", at, lost.abs(), 0.0);
    } else if all.M.as_ref().is_none_or(|M| M.norm() == 0.0) {
        let n = s.x.len();
        let rest = State {
            v: DVector::zeros(n),
            a: DVector::zeros(n),
            ..s.clone()
        };
        let power = evaluate(element, &rest, Ask::Residual)
            .map_or(f64::NAN, |rest| (&all.r - rest.r).dot(&s.v));
        let size = lost + all.r.norm() * s.v.norm();
        report.defect(
            "power of damping = -dissipation",
            at,
            (power + lost).abs(),
            1e-12 * size,
        );
    }
}

/// The tangent of a Newton iterate: exact without a step, and off by its square otherwise.
fn iterates(
    report: &mut Report,
    element: &dyn Element,
    at: &str,
    s: &State,
    all: &Forces,
    random: &mut Random,
) {
    let mut d = DVector::zeros(s.x.len());
    random.direction(1.0, d.as_mut_slice());
    let from = |e: f64| evaluate_from(element, Some(&(&s.x - &d * e)), s, Ask::Stiffness);
    let gap =
        |f: Option<Forces>, of: fn(&Forces, &Forces) -> f64| f.map_or(f64::NAN, |f| of(&f, all));
    report.defect(
        "r does not depend on the previous iterate",
        at,
        gap(from(0.05), |f, all| (&f.r - &all.r).norm()),
        0.0,
    );
    report.slope(
        "K from the previous iterate",
        at,
        2.0,
        0.05,
        all.K.norm() * (1.0 + s.x.norm()),
        |e| gap(from(e), |f, all| (&f.K - &all.K).norm()),
    );
}
