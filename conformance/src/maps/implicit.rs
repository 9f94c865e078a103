//! The laws of the map of an implicit constraint, whose coordinates are changed during a run.

use super::kinematics::motion;
use super::map::{agree, shortened, slopes};
use crate::forces::TestState;
use crate::report::Report;
use crate::sample::Random;
use crate::vectors::{norm, relative};
use nalgebra::DVector;
use pullback_manifold::implicit::ImplicitMap;
use pullback_manifold::map::Parametrization;

/// Residual of the equations, relative to their sizes and to the coordinates.
const RESIDUAL: f64 = 1e-12;
/// Largest condition number of a chart: beyond it digits are lost.
const REGULAR: f64 = 100.0;
/// Largest distance of a position from q = 0.
const REACH: f64 = 0.1;

/// Checks every law of a solved constraint around its present configuration, at time `t`: that of its equations, those
/// of a map, and those of a change to other coordinates and to the tangent space.
pub fn implicit(map: &ImplicitMap, t: f64) -> Report {
    let mut report = Report::new(shortened(map.kind()));
    let mut random = Random::default();
    let (d, n) = map.dims();
    let positions = [
        ("0", 0.0),
        ("1e-8", 1e-8),
        ("near", 0.3 * REACH),
        ("far", REACH),
    ];
    for (at, reach) in positions {
        let Some(q) = inside(map, t, reach, &mut random) else {
            report.impossible("domain", at, "outside the domain");
            continue;
        };
        let rest = vec![0.0; d];
        let allowed = RESIDUAL * (1.0 + norm(&motion(map, t, [&q, &rest, &rest])[0]));
        let h = map.clone().violation(t, &q);
        report.defect("h(t, phi) = 0", at, h, allowed);
        let mut vector = || random_vector(d, &mut random);
        let s = state(t, &q, [vector(), vector()]);
        slopes(&mut report, "", map, at, &s, &mut random);
        // A chart per coordinate and the tangent space; all coordinates take part.
        let splits = (0..n).map(|k| Some((0..d).map(|j| (k + j) % n).collect::<Vec<_>>()));
        for independent in splits.chain([None]) {
            let to = |m: &mut ImplicitMap, q: &mut [f64], v: &mut [f64], a: &mut [Vec<f64>]| {
                m.switch(t, independent.as_deref(), q, v, a)
            };
            let (mut probe, mut there) = (map.clone(), q.clone());
            if !to(&mut probe, &mut there, &mut vec![0.0; d], &mut []) || !roomy(&probe, t, &there)
            {
                continue;
            }
            let own = map.independent();
            let back = |m: &mut ImplicitMap, q: &mut [f64], v: &mut [f64], a: &mut [Vec<f64>]| {
                m.switch(t, own.as_deref(), q, v, a)
            };
            // The change back into a tangent space leads to another one.
            let back: Option<&Change<_>> = own.is_some().then_some(&back);
            let name = match &independent {
                Some(k) => format!("{at}, to {k:?}"),
                None => format!("{at}, to the tangent space"),
            };
            exchange(&mut report, &name, map, (t, &q), &to, back, &mut random);
        }
    }
    report
}

/// A change of the coordinates of a map, with their velocities and accelerations; false if there is
/// none.
type Change<'a, M> = dyn Fn(&mut M, &mut [f64], &mut [f64], &mut [Vec<f64>]) -> bool + 'a;

/// Checks the laws of a change of coordinates of any map at time `t` and `q`: x, ẋ, ẍ and forces are the same before and
/// after `change`, the laws of a map hold afterwards, and `back`, if given, is the inverse.
pub fn rewriting<M: Parametrization + Clone>(
    map: &M,
    t: f64,
    q: &[f64],
    change: &Change<'_, M>,
    back: Option<&Change<'_, M>>,
) -> Report {
    let mut report = Report::new(shortened(map.kind()));
    let mut random = Random::default();
    exchange(&mut report, "q", map, (t, q), change, back, &mut random);
    report
}

fn exchange<M: Parametrization + Clone>(
    report: &mut Report,
    at: &str,
    map: &M,
    (t, q): (f64, &[f64]),
    change: &Change<'_, M>,
    back: Option<&Change<'_, M>>,
    random: &mut Random,
) {
    let d = q.len();
    let v = random_vector(d, random);
    // ẍ is affine in the accelerations: d + 1 of them determine B, and hence the forces.
    let a: Vec<Vec<f64>> = (0..=d).map(|_| random_vector(d, random)).collect();
    let mut changed = map.clone();
    let (mut new_q, mut new_v, mut new_a) = (q.to_vec(), v.clone(), a.clone());
    if !change(&mut changed, &mut new_q, &mut new_v, &mut new_a) {
        return report.impossible("change", at, "no change was made");
    }
    let mut unit = 1.0;
    for (a, new_a) in a.iter().zip(&new_a) {
        let before = motion(map, t, [q, &v, a]);
        let after = motion(&changed, t, [&new_q, &new_v, new_a]);
        let [x, x_dot, x_ddot, ..] = [0, 1, 2].map(|k| norm(&before[k]));
        unit = 1.0 + x + x_dot + x_ddot;
        let gaps = [0, 1, 2].map(|k| relative(&after[k], &before[k], unit));
        agree(report, "change: x, x_dot, x_ddot stay", at, &gaps);
        unit += norm(&before[3]) * norm(&after[3]);
    }
    let s = state(t, &new_q, [new_v.clone(), new_a[0].clone()]);
    slopes(report, "changed: ", &changed, at, &s, random);
    let Some(back) = back else { return };
    if !back(&mut changed, &mut new_q, &mut new_v, &mut new_a) {
        return report.impossible("change and back", at, "there is no change back");
    }
    let mut gaps = vec![relative(&new_q, q, unit), relative(&new_v, &v, unit)];
    let both = new_a.iter().zip(&a);
    gaps.extend(both.map(|(found, a)| relative(found, a, unit * unit)));
    agree(report, "change and back", at, &gaps);
}

/// A position at this distance, or at half of it as often as needed to be inside the domain.
fn inside(map: &ImplicitMap, t: f64, reach: f64, random: &mut Random) -> Option<Vec<f64>> {
    let mut q = vec![0.0; map.dims().0];
    random.direction(reach, &mut q);
    for _ in 0..20 {
        if roomy(map, t, &q) {
            return Some(q);
        }
        q.iter_mut().for_each(|q| *q *= 0.5);
    }
    None
}

/// Whether a position and the steps of the laws from there are inside the domain.
fn roomy(map: &ImplicitMap, t: f64, q: &[f64]) -> bool {
    let mut map = map.clone();
    let margin = map.domain(t, q).unwrap_or(0.0);
    let mut step = |j: usize, sign: f64| {
        let mut there = q.to_vec();
        // Steps are in all directions at once, and the motion is curved.
        there[j] += sign * 0.6 * margin.min(0.3) * (q.len() as f64).sqrt();
        map.domain(t, &there).is_ok()
    };
    margin * REGULAR > 1.0 && (0..q.len()).all(|j| step(j, 1.0) && step(j, -1.0))
}

fn state(t: f64, q: &[f64], [v, a]: [Vec<f64>; 2]) -> TestState {
    TestState {
        t,
        x: DVector::from_column_slice(q),
        v: v.into(),
        a: a.into(),
    }
}

fn random_vector(d: usize, random: &mut Random) -> Vec<f64> {
    let mut out = vec![0.0; d];
    random.fill(&mut out);
    out
}
