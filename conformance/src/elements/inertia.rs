//! Inertial forces follow from a kinetic energy, and the power of all forces is balanced.

use super::element::{One, Request, evaluate, motion};
use crate::block::{Rows, difference, wrong_entries};
use crate::forces::{CONFIRMED, FIRST, STEP, sizes};
use crate::vectors::minus;
use crate::{Random, Report, TestState};
use nalgebra::{DMatrix, DVector};

/// Largest relative difference of masses at two velocities that do not depend on them.
const SAME: f64 = 1e-12;

/// The laws of inertia at a state in motion; `conservative` if the element has an energy.
pub(crate) fn laws(report: &mut Report, one: &One<'_>, conservative: bool, random: &mut Random) {
    if one.state.is_static() || !one.element.properties().symmetric {
        return;
    }
    let M = &one.all.M;
    let mass = |state: &TestState| Some(evaluate(one.element, state, Request::All)?.M);
    let heavy = M.norm() > 0.0;
    if heavy {
        symmetric(report, one, M);
    }
    // The kinetic energy is ½ ẋ·M(x) ẋ and a part linear in ẋ.
    let Some(at_rest) = mass(&one.state.still()) else {
        return;
    };
    let (gap, law) = (one.norm(&(&at_rest - M)), "M the same at rest");
    report.defect(law, one.at, gap, SAME * one.norm(M));
    if gap > SAME * one.norm(M) {
        return;
    }
    if let Some(T) = one.element.abilities().kinetic_energy(&motion(one.state)) {
        let v = &one.state.v;
        let gap = (T - 0.5 * v.dot(&(M * v))).abs();
        let size = v.abs().dot(&(M.abs() * v.abs()));
        report.defect("T = v.Mv/2", one.at, gap, 1e-13 * size);
    }
    if heavy {
        lagrange(report, one, M, &mass, random);
    }
    // The energy of an element that exerts forces at rest and has none is unknown.
    let rest = evaluate(one.element, &one.state.still(), Request::Residual);
    let silent = rest.is_none_or(|f| f.r.norm() > 0.0) && !conservative;
    if !(one.element.properties().load || silent) {
        power(report, one, &mass);
    }
}

/// M is symmetric and positive semidefinite.
fn symmetric(report: &mut Report, one: &One<'_>, M: &DMatrix<f64>) {
    let scaled = one.scaled(M);
    let size = scaled.norm();
    let gap = (&scaled - scaled.transpose()).norm();
    report.defect("M symmetric", one.at, gap, 1e-13 * size);
    let least = ((&scaled + scaled.transpose()) * 0.5)
        .symmetric_eigenvalues()
        .min();
    let law = "M positive semidefinite";
    report.defect(law, one.at, (-least).max(0.0), 1e-12 * size);
}

/// f_acc = d/dt ∂T/∂ẋ − ∂T/∂x with T = ½ ẋ·M ẋ (theory of \[M04\] (119)): it reveals a wrong force whose tangents are
/// consistent with it.
///
/// The force is the part that is even in ẋ: damping and gyroscopic potentials are odd.
fn lagrange(
    report: &mut Report,
    one: &One<'_>,
    M: &DMatrix<f64>,
    mass: &dyn Fn(&TestState) -> Option<DMatrix<f64>>,
    random: &mut Random,
) {
    let (s, rate) = (one.state, one.layout.rate);
    let r = |s: &TestState| evaluate(one.element, s, Request::Residual).map(|f| f.r);
    let back = TestState {
        v: -&s.v,
        ..s.clone()
    };
    let (Some(rest), Some(back)) = (r(&one.state.still()), r(&back)) else {
        return;
    };
    let force = rest - (&one.all.r + back) * 0.5;
    let at = |x: DVector<f64>| one.moved(x);
    let momentum = |tau: f64| -> Option<DVector<f64>> {
        let there = at(&s.x + &s.v * tau);
        Some(mass(&there)? * (&s.v + &s.a * tau))
    };
    let kinetic = |x: DVector<f64>| Some(0.5 * s.v.dot(&(mass(&at(x))? * &s.v)));
    let (p, T) = (M * &s.v, 0.5 * s.v.dot(&(M * &s.v)));

    let d = random.direction_in(&one.layout.units());
    let work = force.dot(&d);
    let absolute = |A: &DMatrix<f64>, x: &DVector<f64>| (A.abs() * x.abs()).dot(&d.abs());
    let size = absolute(M, &s.v) * rate + absolute(M, &s.a) + T.abs() + work.abs();
    let law = "inertia = d/dt dT/dv - dT/dx";
    report.slope(law, one.at, 2.0, FIRST, size, |e| {
        let ahead = momentum(e / rate).map(|m| (m - &p).dot(&d) * rate);
        let aside = kinetic(&s.x + &d * e).map(|k| k - T);
        match (ahead, aside) {
            (Some(ahead), Some(aside)) => (ahead - aside - work * e).abs(),
            _ => f64::NAN,
        }
    });
    let right = || -> Option<Vec<f64>> {
        let units = one.layout.units();
        let mut right = difference(STEP / rate, |tau| Some(momentum(tau)?.as_slice().to_vec()))?;
        for (i, unit) in units.iter().enumerate() {
            let slope = difference(STEP * unit, |e| {
                let mut x = s.x.clone();
                x[i] += e;
                Some(vec![kinetic(x)?])
            });
            right[i] -= slope?[0];
        }
        Some(right)
    };
    let force = force.as_slice();
    report.second_opinion(|| {
        let right = right()?;
        let gap = one.layout.forces(&minus(force, &right));
        Some((gap.iter().sum(), CONFIRMED * size))
    });
    let rows = Rows::Forces(one.layout);
    let blocks = |right: Vec<f64>| wrong_entries("inertial force", rows, force, &right);
    report.blame(|| right().map_or_else(Vec::new, blocks));
}

/// d/dt (U + T) = −ẋ·r − dissipation, at constant time in the potential.
fn power(report: &mut Report, one: &One<'_>, mass: &dyn Fn(&TestState) -> Option<DMatrix<f64>>) {
    let (s, rate) = (one.state, one.layout.rate);
    let energy = |tau: f64| {
        let there = one.moved(s.ahead(tau));
        let v = &s.v + &s.a * tau;
        let M = mass(&there)?;
        Some(one.element.abilities().energy(&motion(&there)) + 0.5 * v.dot(&(M * &v)))
    };
    let Some(now) = energy(0.0) else { return };
    let lost = one.element.abilities().dissipation(&motion(s));
    let gain = -one.all.r.dot(&s.v) - lost;
    // The power of each group: its speed in units times the magnitude of its forces.
    let sizes = sizes(one.layout, s, one.all);
    let speeds = one.layout.coordinates(s.v.as_slice());
    let work: f64 = sizes.iter().zip(&speeds).map(|(f, v)| f * v).sum();
    let size = now.abs() + (work + lost) / rate;
    let law = "d(U + T)/dt = -v.r - dissipation";
    report.slope(law, one.at, 2.0, FIRST / rate, size, |tau| {
        energy(tau).map_or(f64::NAN, |there| (there - now - gain * tau).abs())
    });
    report.second_opinion(|| {
        let found = difference(STEP / rate, |tau| Some(vec![energy(tau)?]))?[0];
        Some(((found - gain).abs() / rate, CONFIRMED * size))
    });
}
