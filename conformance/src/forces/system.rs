//! The laws of a system: the assembled tangent in its pattern is that of the residual.

use super::tangents::{CONFIRMED, FIRST, Linearization, Part, tangents};
use super::{Laws, TestState, at_states};
use crate::block::difference;
use crate::layout::Layout;
use crate::report::Report;
use crate::vectors::minus;
use pullback_manifold::system::{Evaluation, Scales, System, Weights};

/// Number of changes in the last digits: the round-off of one may vanish by chance.
const SAMPLES: u32 = 8;
/// Largest round-off of a tangent over its change with the last digits of the coordinates.
const NOISE: f64 = 100.0;

/// Checks a system's residual and tangents at given states.
///
/// ∂r/∂t is verified at rest only: in motion it would require a third derivative of prescribed coordinates, which no
/// solver uses.
pub fn system(subject: &str, system: &mut dyn System, states: &[(String, TestState)]) -> Report {
    let layout = Layout::of(system);
    at_states(subject, &layout, states, |laws| {
        one(laws, system)?;
        accelerations(laws, system)
    })
}

/// As [`system`], with a layout of the coordinates.
pub(crate) fn system_at(
    subject: &str,
    layout: &Layout,
    system: &mut dyn System,
    states: &[(String, TestState)],
) -> Report {
    at_states(subject, layout, states, |laws| one(laws, system))
}

/// The magnitude of the terms of a system's residual in each group, as an energy: its round-off is a fraction of them.
/// `None` outside of the domain.
pub(crate) fn system_sizes(
    layout: &Layout,
    system: &mut dyn System,
    state: &TestState,
) -> Option<Vec<f64>> {
    let (r, values) = parts(system, state)?;
    let all = Linearization {
        pattern: system.pattern(),
        r: &r,
        values,
    };
    Some(all.sizes(layout, state))
}

/// The residual, and the values of K, C and M.
pub(crate) fn parts(
    system: &mut dyn System,
    state: &TestState,
) -> Option<(Vec<f64>, [Vec<f64>; 3])> {
    let (r, K) = combined(system, state, Weights::STATIC)?;
    let (mut C, mut M) = (vec![0.0; K.len()], vec![0.0; K.len()]);
    if !state.is_static() {
        C = combined(system, state, Weights::DAMPING)?.1;
        M = combined(system, state, Weights::MASS)?.1;
    }
    Some((r, [K, C, M]))
}

/// The laws at one state; `None` outside of the domain.
fn one(laws: &mut Laws<'_>, system: &mut dyn System) -> Option<()> {
    let (state, at) = (laws.state, laws.at);
    let pattern = system.pattern().clone();
    let (r, values) = parts(system, state)?;
    let all = Linearization {
        pattern: &pattern,
        r: &r,
        values,
    };
    let sizes = with_noise(all.sizes(laws.layout, state), laws, system, &r);
    tangents(laws, &all, &sizes, &mut |s| residual(system, s));
    let again = combination(laws, system, &all);

    let alone = residual(system, state).unwrap_or_else(|| vec![f64::NAN; r.len()]);
    let gap = alone.iter().zip(&again).map(|(a, b)| (a - b).abs());
    let law = "r does not depend on what else is requested";
    laws.report.defect(law, at, gap.sum(), 0.0);

    if state.is_static() {
        let mut rate = vec![1e3; r.len()];
        let mut again = r.clone();
        let out = Evaluation {
            r_t: Some(&mut rate),
            ..Evaluation::residual(&mut again)
        };
        system.evaluate(state.point(), out).ok()?;
        load_rate(laws, system, &r, &rate, &sizes);
    }
    Some(())
}

/// One evaluation with three weights is the weighted sum of three evaluations; at rest there is K alone. Also the
/// symmetry of tangents. Returns the residual of that evaluation.
fn combination(laws: &mut Laws<'_>, system: &mut dyn System, all: &Linearization<'_>) -> Vec<f64> {
    let (state, at, pattern) = (laws.state, laws.at, all.pattern);
    let rates = if state.is_static() { 0.0 } else { 1.0 };
    let w = Weights {
        K: 0.7,
        C: -1.3 * rates,
        M: 2.1 * rates,
    };
    let [K, C, M] = &all.values;
    let nowhere = || (all.r.to_vec(), vec![f64::NAN; K.len()]);
    let (again, S) = combined(system, state, w).unwrap_or_else(nowhere);
    let (mut gap, mut size) = (Vec::new(), Vec::new());
    for (k, S) in S.iter().enumerate() {
        let parts = [w.K * K[k], w.C * C[k], w.M * M[k]];
        gap.push((S - parts.iter().sum::<f64>()).abs());
        size.push(parts.iter().map(|p| p.abs()).sum());
    }
    let by_row = |values: &[f64]| {
        let mut rows = vec![0.0; all.r.len()];
        pattern.multiply_add(1.0, values, &laws.layout.units(), &mut rows);
        laws.layout.forces(&rows)
    };
    // Stiff parts that cancel leave their round-off, which only the change of S with the last digits of the
    // coordinates shows.
    let mut noise = vec![0.0_f64; S.len()];
    let mut of_parts = [K, C, M].map(|values| vec![0.0_f64; values.len()]);
    for sample in 1..=SAMPLES {
        let beside = beside(state, laws.layout, sample);
        let whole = combined(system, &beside, w);
        let (Some((_, there)), Some((_, parts))) = (whole, parts(system, &beside)) else {
            continue;
        };
        for k in 0..S.len() {
            let part = |i: usize| (parts[i][k] - all.values[i][k]).abs();
            for (i, noise) in of_parts.iter_mut().enumerate() {
                noise[k] = noise[k].max(NOISE * part(i));
            }
            let parts = w.K.abs() * part(0) + w.C.abs() * part(1) + w.M.abs() * part(2);
            noise[k] = noise[k].max((there[k] - S[k]).abs() + parts);
        }
    }
    if system.is_symmetric() {
        let part = if state.is_static() { Part::K } else { Part::M };
        all.symmetric(laws, part, &of_parts[part as usize]);
    }
    let allowed = by_row(&size).into_iter().zip(by_row(&noise));
    let allowed: Vec<f64> = allowed.map(|(s, n)| 1e-12 * s + NOISE * n).collect();
    let law = "S = cK K + cC C + cM M";
    laws.report.defects(law, at, &by_row(&gap), &allowed);
    again
}

/// The equations of multipliers for consistent accelerations: −ḧ instead of −h, and ∂h/∂q with M alone.
fn accelerations(laws: &mut Laws<'_>, system: &mut dyn System) -> Option<()> {
    let (state, pattern) = (laws.state, system.pattern().clone());
    let is_gap = |i: usize| pattern.coordinates()[i].is_multiplier;
    if state.is_static() || !(0..pattern.dim()).any(is_gap) {
        return Some(());
    }
    let (r, values) = parts(system, state)?;
    let (mut second, mut M) = (r.clone(), vec![1e3; pattern.len()]);
    let out = Evaluation {
        accelerations: Some(0.0),
        ..Evaluation::with_tangent(&mut second, Weights::MASS, &mut M)
    };
    system.evaluate(state.point(), out).ok()?;
    let entries = pattern.triplets(&values[0]).zip(&M);
    let of_gaps = entries.filter(|((r, c, _), _)| is_gap(*r) || is_gap(*c));
    let (mut off, mut size) = (0.0, 0.0);
    of_gaps.for_each(|((_, _, K), M)| (off, size) = (off + (M - K).abs(), size + K.abs()));
    let law = "dh/dq with M for accelerations";
    laws.report.defect(law, laws.at, off, 1e-12 * size);

    let mut at = |e: f64| {
        let there = residual(system, &state.later(e));
        there.unwrap_or_else(|| vec![f64::NAN; r.len()])
    };
    let (layout, law) = (laws.layout, "d2h/dt2 for accelerations");
    let sizes = Linearization {
        pattern: &pattern,
        r: &r,
        values,
    }
    .sizes(layout, state);
    laws.report.slopes(law, laws.at, 4.0, FIRST, &sizes, |e| {
        let (before, after) = (at(-e), at(e));
        let left = (0..after.len()).map(|i| match is_gap(i) {
            true => before[i] + after[i] - 2.0 * r[i] - second[i] * e * e,
            false => 0.0,
        });
        layout.forces(&left.collect::<Vec<_>>())
    });
    Some(())
}

/// A state that differs in its last digits.
fn beside(state: &TestState, layout: &Layout, sample: u32) -> TestState {
    let mut beside = state.clone();
    for (i, (x, unit)) in beside.x.iter_mut().zip(layout.units()).enumerate() {
        let digit = f64::from(sample) * f64::EPSILON * (x.abs() + unit);
        *x += if i % 2 == 0 { digit } else { -digit };
    }
    beside
}

/// The magnitudes of the terms of the residual, raised to those that its change with the last digits of the
/// coordinates implies: forces of a loop that do no work on its coordinates are in no row.
fn with_noise(
    mut sizes: Vec<f64>,
    laws: &Laws<'_>,
    system: &mut dyn System,
    r: &[f64],
) -> Vec<f64> {
    for sample in 1..=SAMPLES {
        let Some(there) = residual(system, &beside(laws.state, laws.layout, sample)) else {
            continue;
        };
        let digit = f64::from(sample) * f64::EPSILON;
        let gaps = laws.layout.forces(&minus(&there, r));
        for (size, gap) in sizes.iter_mut().zip(gaps) {
            *size = size.max(gap / digit);
        }
    }
    sizes
}

/// Least magnitude of forces over the largest, loads included: terms that cancel in a group, such as a weight on a plane,
/// are in no tangent, and leave some rounding errors.
const ROUGH: f64 = 1e-2;

/// ∂r/∂t, on steps that do not reach the next kink of a function of time.
fn load_rate(laws: &mut Laws<'_>, system: &mut dyn System, r: &[f64], rate: &[f64], sizes: &[f64]) {
    let (state, layout) = (laws.state, laws.layout);
    let kinks = (system.events()).map_or_else(Vec::new, |events| events.kinks());
    let kinks = kinks.into_iter().map(|k| k - state.t);
    let next = kinks
        .filter(|&ahead| ahead > 0.0)
        .fold(f64::INFINITY, f64::min);
    let rates = layout.forces(rate);
    let Scales { force, length, .. } = system.scales();
    let loads = (force[0] * length).max(force[1]);
    let largest = sizes.iter().copied().fold(loads, f64::max);
    let sizes: Vec<f64> = (rates.iter().zip(sizes))
        .map(|(rate, size)| size.max(ROUGH * largest) + rate * (1.0 + state.t.abs()))
        .collect();
    let first = FIRST.min(0.5 * next);
    let mut at = |t: f64| residual(system, &TestState { t, ..state.clone() });
    laws.report
        .slopes("r_t = dr/dt", laws.at, 2.0, first, &sizes, |e| {
            let there = at(state.t + e).unwrap_or_else(|| vec![f64::NAN; r.len()]);
            let parts = there.iter().zip(r).zip(rate);
            let left: Vec<f64> = parts.map(|((a, b), rate)| a - b - rate * e).collect();
            layout.forces(&left)
        });
    laws.report.second_opinion(|| {
        let right = difference(1e-2 * first, |e| at(state.t + e))?;
        let gaps = layout.forces(&minus(&right, rate));
        let strains = gaps.into_iter().zip(&sizes);
        let worst = strains.map(|(gap, size)| gap / size).fold(0.0, f64::max);
        Some((worst, CONFIRMED))
    });
}

fn residual(system: &mut dyn System, state: &TestState) -> Option<Vec<f64>> {
    let mut r = vec![0.0; state.x.len()];
    let out = Evaluation::residual(&mut r);
    system.evaluate(state.point(), out).ok()?;
    Some(r)
}

fn combined(
    system: &mut dyn System,
    state: &TestState,
    weights: Weights,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let mut r = vec![0.0; state.x.len()];
    // Entries that an evaluation forgets to overwrite show up.
    let mut values = vec![1e3; system.pattern().len()];
    let out = Evaluation::with_tangent(&mut r, weights, &mut values);
    system.evaluate(state.point(), out).ok()?;
    Some((r, values))
}
