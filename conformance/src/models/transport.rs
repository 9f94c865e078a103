//! The assembled system in other charts, and its books of power.

#![allow(non_snake_case)]

use super::states::switch;
use super::view::{Rotation, Snapshot, prescribed_rate, reparametrizes, silent_power, snapshot};
use crate::elements::EXACT;
use crate::{CONFIRMED, Compared, Layout, Random, Report, State, difference, system_sizes};
use nalgebra::Vector3;
use pullback_elements::model::Context;
use pullback_manifold::so3::B_s;
use pullback_manifold::system::{Charts, Energetics, Energies, Events, Point, SystemError};

/// First step along the motion, as in the laws of forces.
const FIRST: f64 = 0.05;
/// Sets of nodes whose charts are changed at a state: all, and random ones.
const SETS: usize = 3;

fn point(s: &State) -> Point<'_> {
    Point {
        t: s.t,
        q: s.x.as_slice(),
        v: s.v.as_slice(),
        a: s.a.as_slice(),
    }
}

/// Notes transport through changes of chart and the balance of power, at a state in motion.
pub(super) fn laws(
    report: &mut Report,
    context: &mut Context,
    layout: &Layout,
    (at, state): &(String, State),
    random: &mut Random,
) {
    let Some(sizes) = system_sizes(layout, context, state) else {
        return report.impossible("domain", at, "outside of the domain");
    };
    let all = context.free_rotations();
    for set in 0..SETS {
        let chosen: Vec<Rotation> = (all.iter().copied())
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

/// What does not depend on charts.
fn spatial(context: &mut Context, s: &State) -> Result<(Snapshot, Energies), SystemError> {
    let now = snapshot(context, s)?;
    let energies = context.energies(point(s))?;
    Ok((now, energies))
}

fn transport(
    report: &mut Report,
    context: &mut Context,
    layout: &Layout,
    sizes: &[f64],
    at: &str,
    s: &State,
    chosen: &[Rotation],
) -> Result<(), SystemError> {
    let before = spatial(context, s)?;
    let mut other = s.clone();
    if switch(context, chosen, &mut other)? == 0 {
        return Ok(());
    }
    let after = spatial(context, &other)?;
    // Forces go back with the transpose of B_s.
    let mut r = after.0.r.clone();
    let mut bend: f64 = 1.0;
    for unknowns in chosen {
        let take = |x: &[f64]| Vector3::from_fn(|i, _| unknowns[i].map_or(0.0, |u| x[u]));
        let psi = take(s.x.as_slice());
        if psi == take(other.x.as_slice()) {
            continue;
        }
        let B = B_s(&psi);
        bend = bend.max(B.amax());
        let f = B.tr_mul(&take(&after.0.r));
        for (u, f) in unknowns.iter().zip(f.iter()) {
            if let Some(u) = *u {
                r[u] = *f;
            }
        }
    }
    let gap: Vec<f64> = r.iter().zip(&before.0.r).map(|(a, b)| a - b).collect();
    let allowed: Vec<f64> = sizes.iter().map(|s| EXACT * s * bend * bend).collect();
    let law = "change of charts: forces stay";
    report.defects(law, at, &layout.forces(&gap), &allowed);
    report.blame(|| {
        Compared {
            matrix: "force",
            rows: layout,
            columns: &Layout::single(),
            forces: true,
            values: vec![(0, r.clone(), before.0.r.clone())],
        }
        .worst()
    });

    let total = sizes.iter().sum();
    stays(
        report,
        "change of charts",
        at,
        [&before, &after],
        [context.length(), layout.rate, total, bend],
    );

    // And back, by what a run does after every step.
    let mut back = other.clone();
    if reparametrizes(context) {
        switch(context, chosen, &mut back)?;
    } else {
        let (q, v, a) = (&mut back.x, &mut back.v, &mut back.a);
        context.change_charts(
            s.t,
            q.as_mut_slice(),
            v.as_mut_slice(),
            &mut [a.as_mut_slice()],
        );
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
    let most = layout
        .coordinates(s.x.as_slice())
        .into_iter()
        .fold(1.0, f64::max);
    let law = "change of charts and back";
    report.defects(law, at, &defects, &[EXACT * bend * bend * most; 3]);
    Ok(())
}

/// Notes that motion and energies are the same; given the model's length, its rate, a size of its
/// energies, and the largest entry of what took one to the other.
fn stays(
    report: &mut Report,
    law: &str,
    at: &str,
    [before, after]: [&(Snapshot, Energies); 2],
    [length, rate, total, bend]: [f64; 4],
) {
    let frames = before.0.frames.iter().zip(&after.0.frames);
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

    let pairs = [
        (before.1.kinetic, after.1.kinetic, 1.0),
        (before.1.stored, after.1.stored, 1.0),
        (before.1.supplied, after.1.supplied, rate),
        (before.1.dissipated, after.1.dissipated, rate),
    ];
    let defects = pairs.map(|(a, b, _)| (a - b).abs());
    let allowed = pairs.map(|(a, _, unit)| EXACT * bend * bend * (a.abs() + total * unit));
    let law = format!("{law}: energies and powers stay");
    report.defects(&law, at, &defects, &allowed);
}

/// v·r: the power of what is out of balance.
fn left(snapshot: &Snapshot, s: &State) -> f64 {
    let parts = snapshot.r.iter().zip(s.v.iter());
    parts.map(|(r, v)| r * v).sum()
}

/// Notes that motion and energies stay where a map gives its coordinates another meaning. Coordinates
/// of before mean nothing to the model afterwards.
///
/// Where a joint of a loop is driven, what the drive has to do depends on which coordinates are free,
/// as these are not in balance: of the power supplied, what is not v·r stays.
pub(super) fn rewriting(
    report: &mut Report,
    context: &mut Context,
    layout: &Layout,
    (at, s): &(String, State),
) {
    let law = "change of coordinates";
    let mut settled = s.clone();
    let balanced =
        |context: &mut Context, s: &State| -> Result<(Snapshot, Energies), SystemError> {
            let (snapshot, mut energies) = spatial(context, s)?;
            energies.supplied -= left(&snapshot, s);
            Ok((snapshot, energies))
        };
    let mut both = || -> Result<[(Snapshot, Energies); 2], SystemError> {
        let before = balanced(context, &settled)?;
        let State { t, x, v, a } = &mut settled;
        context.change_charts(
            *t,
            x.as_mut_slice(),
            v.as_mut_slice(),
            &mut [a.as_mut_slice()],
        );
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

/// How much a change of coordinates may enlarge round-off: the condition of good ones.
const BEND: f64 = 10.0;

/// d(T + U)/dt = supplied − dissipated − q̇·r: the last is zero along a motion that obeys the
/// equations, and any motion will do to check the books.
fn power(
    report: &mut Report,
    context: &mut Context,
    layout: &Layout,
    sizes: &[f64],
    at: &str,
    s: &State,
) -> Result<(), SystemError> {
    let (now, energies) = spatial(context, s)?;
    // What a potential gains by time alone, and what elements do that tell of no energy.
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
        let there = State {
            t: s.t + tau,
            x: &s.x + &s.v * tau + &s.a * (0.5 * tau * tau),
            v: &s.v + &s.a * tau,
            a: s.a.clone(),
        };
        let energies = context.energies(point(&there)).ok()?;
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
