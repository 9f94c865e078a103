//! The assembled system in other charts, and its balance of power.

use super::states::switch;
use super::view::{Observables, observables, prescribed_rate, reparametrizes, silent_power};
use crate::block::{Rows, difference, wrong_entries};
use crate::elements::EXACT;
use crate::forces::{CONFIRMED, FIRST, system_sizes};
use crate::vectors::{dot, minus};
use crate::{Layout, Random, Report, TestState};
use pullback_elements::model::{Context, FreeRotation};
use pullback_manifold::chart::Complement;
use pullback_manifold::map::Map;
use pullback_manifold::system::{Charts, Energetics, Events, SystemError};

/// Number of sets of nodes whose charts are changed at a state: all, and random ones.
const SETS: usize = 3;

/// Transport through changes of chart and the balance of power, at a state in motion.
pub(super) fn laws(
    report: &mut Report,
    context: &mut Context,
    layout: &Layout,
    (at, state): &(String, TestState),
    random: &mut Random,
) {
    let Some(sizes) = system_sizes(layout, context, state) else {
        return report.impossible("domain", at, "outside of the domain");
    };
    let all = context.free_rotations();
    for set in 0..SETS {
        let chosen: Vec<FreeRotation> = (all.iter().copied())
            .filter(|_| set == 0 || random.unit() < 0.5)
            .collect();
        if let Err(error) = transport(report, context, layout, &sizes, at, state, &chosen) {
            report.impossible("change of charts", at, error.to_string());
        }
    }
    if let Err(error) = power(report, context, layout, &sizes, at, state) {
        report.impossible("balance of power", at, error.to_string());
    }
}

fn transport(
    report: &mut Report,
    context: &mut Context,
    layout: &Layout,
    sizes: &[f64],
    at: &str,
    s: &TestState,
    chosen: &[FreeRotation],
) -> Result<(), SystemError> {
    let before = observables(context, s)?;
    let mut other = s.clone();
    if switch(context, chosen, &mut other)? == 0 {
        return Ok(());
    }
    let after = observables(context, &other)?;
    let (r, bend) = forces_before(chosen, [s, &other], &after.r);
    let gap = layout.forces(&minus(&r, &before.r));
    let allowed: Vec<f64> = sizes.iter().map(|s| EXACT * s * bend * bend).collect();
    let law = "change of charts: forces stay";
    report.defects(law, at, &gap, &allowed);
    report.blame(|| wrong_entries("force", Rows::Forces(layout), &r, &before.r));

    let scale = [context.length(), layout.rate, sizes.iter().sum(), bend];
    stays(report, "change of charts", at, [&before, &after], scale);

    // And back, as a run does after every step.
    let mut back = other.clone();
    if reparametrizes(context) {
        switch(context, chosen, &mut back)?;
    } else {
        change_charts(context, &mut back);
    }
    let rate = layout.rate;
    let off = |a: &[f64], b: &[f64], rate: f64| {
        let gap: Vec<f64> = a.iter().zip(b).map(|(a, b)| (a - b) / rate).collect();
        layout.coordinates(&gap).into_iter().fold(0.0, f64::max)
    };
    let defects = [
        off(back.x.as_slice(), s.x.as_slice(), 1.0),
        off(back.v.as_slice(), s.v.as_slice(), rate),
        off(back.a.as_slice(), s.a.as_slice(), rate * rate),
    ];
    let coordinates = layout.coordinates(s.x.as_slice());
    let most = coordinates.into_iter().fold(1.0, f64::max);
    let law = "change of charts and back";
    report.defects(law, at, &defects, &[EXACT * bend * bend * most; 3]);
    Ok(())
}

/// The forces in the charts before a change, by the transpose of its B, and its largest entry.
fn forces_before(
    chosen: &[FreeRotation],
    [s, other]: [&TestState; 2],
    after: &[f64],
) -> (Vec<f64>, f64) {
    let (mut r, mut bend) = (after.to_vec(), 1.0_f64);
    for rotation in chosen {
        let psi = rotation.of(s.x.as_slice());
        if psi == rotation.of(other.x.as_slice()) {
            continue;
        }
        let B = Complement.tangent(0.0, &psi).B;
        bend = bend.max(B.amax());
        rotation.write(&mut r, &B.tr_mul(&rotation.of(after)));
    }
    (r, bend)
}

/// The change of charts at the end of a step.
fn change_charts(context: &mut Context, s: &mut TestState) {
    let [q, v, a] = [&mut s.x, &mut s.v, &mut s.a].map(|x| x.as_mut_slice());
    context.change_charts(s.t, q, v, &mut [a]);
}

/// Checks that motion and energies are the same, given the length of the model, its rate, the magnitude of its
/// energies, and the largest entry of the operator of the change.
fn stays(
    report: &mut Report,
    law: &str,
    at: &str,
    [before, after]: [&Observables; 2],
    [length, rate, total, bend]: [f64; 4],
) {
    let frames = before.frames.iter().zip(&after.frames);
    let (mut worst, mut most) = ([0.0_f64; 5], [0.0_f64; 5]);
    for (a, b) in frames {
        for k in 0..5 {
            worst[k] = worst[k].max((a[k] - b[k]).norm());
            most[k] = most[k].max(a[k].norm());
        }
    }
    // Positions, orientations, velocities, angular velocities, accelerations.
    let least = [length, 1.0, length * rate, rate, length * rate * rate];
    let allowed: Vec<f64> = (0..5)
        .map(|k| EXACT * bend * (least[k] + most[k]))
        .collect();
    report.defects(&format!("{law}: motion stays"), at, &worst, &allowed);

    let [a, b] = [before.energies, after.energies];
    let pairs = [
        (a.kinetic, b.kinetic, 1.0),
        (a.stored, b.stored, 1.0),
        (a.supplied, b.supplied, rate),
        (a.dissipated, b.dissipated, rate),
    ];
    let defects = pairs.map(|(a, b, _)| (a - b).abs());
    let allowed = pairs.map(|(a, _, unit)| EXACT * bend * bend * (a.abs() + total * unit));
    let law = format!("{law}: energies and powers stay");
    report.defects(&law, at, &defects, &allowed);
}

/// v·r, the power of the residual.
fn left(observables: &Observables, s: &TestState) -> f64 {
    dot(&observables.r, s.v.as_slice())
}

/// Checks that motion and energies stay the same when a map reparametrizes. The model cannot be evaluated at its former
/// coordinates afterwards.
///
/// The power of a prescribed joint in a loop depends on which coordinates are free, since these are not in equilibrium:
/// the power supplied less v·r stays the same.
pub(super) fn rewriting(
    report: &mut Report,
    context: &mut Context,
    layout: &Layout,
    (at, s): &(String, TestState),
) {
    let law = "change of coordinates";
    let mut settled = s.clone();
    let balanced = |context: &mut Context, s: &TestState| -> Result<Observables, SystemError> {
        let mut now = observables(context, s)?;
        now.energies.supplied -= left(&now, s);
        Ok(now)
    };
    let mut both = || -> Result<[Observables; 2], SystemError> {
        let before = balanced(context, &settled)?;
        change_charts(context, &mut settled);
        Ok([before, balanced(context, &settled)?])
    };
    let pair = match both() {
        Ok(pair) => pair,
        Err(error) => return report.impossible(law, at, error.to_string()),
    };
    let Some(sizes) = system_sizes(layout, context, &settled) else {
        return report.impossible(law, at, "outside of the domain");
    };
    let scale = [context.length(), layout.rate, sizes.iter().sum(), BEND];
    stays(report, law, at, [&pair[0], &pair[1]], scale);
}

/// Largest amplification of round-off by a change of coordinates, the condition number of good ones.
const BEND: f64 = 10.0;

/// d(T + U)/dt = supplied − dissipated − q̇·r along any motion; the last term is zero if it satisfies the equations.
fn power(
    report: &mut Report,
    context: &mut Context,
    layout: &Layout,
    sizes: &[f64],
    at: &str,
    s: &TestState,
) -> Result<(), SystemError> {
    let now = observables(context, s)?;
    let energies = now.energies;
    // The change of a potential with time, and the power of elements without an energy.
    let h = 1e-4 / layout.rate;
    let gained = (context.strain_energy(s.t + h) - context.strain_energy(s.t - h)) / (2.0 * h);
    let silent = silent_power(context, s.t);
    let gain = energies.supplied - energies.dissipated - left(&now, s) + gained + silent;
    let start = energies.kinetic + energies.stored;

    let speeds = layout.coordinates(s.v.as_slice());
    let work: f64 = sizes.iter().zip(&speeds).map(|(f, v)| f * v).sum();
    let size = start.abs() + (work + energies.supplied.abs() + energies.dissipated) / layout.rate;
    let ahead = context.kinks().into_iter().map(|k| k - s.t);
    let next = ahead.filter(|&k| k > 0.0).fold(f64::INFINITY, f64::min);
    let first = (FIRST / layout.rate.max(prescribed_rate(context))).min(0.5 * next);
    let mut energy = |tau: f64| {
        let energies = context.energies(s.later(tau).point()).ok()?;
        Some(energies.kinetic + energies.stored)
    };
    let law = "d(T + U)/dt = supplied - dissipated - v.r";
    report.slope(law, at, 2.0, first, size, |tau| {
        energy(tau).map_or(f64::NAN, |e| (e - start - gain * tau).abs())
    });
    report.second_opinion(|| {
        let found = difference(1e-2 * first, |tau| Some(vec![energy(tau)?]))?[0];
        Some(((found - gain).abs() / layout.rate, CONFIRMED * size))
    });
    Ok(())
}
