//! The laws of the map of an implicit constraint, whose coordinates are changed during a run.

use super::kinematics::{Mapped, motion};
use super::map::{agree, shortened, slopes, unscaled};
use crate::forces::TestState;
use crate::layout::Layout;
use crate::report::Report;
use crate::sample::Random;
use crate::vectors::{minus, norm};
use nalgebra::DVector;
use pullback_manifold::implicit::ImplicitMap;
use pullback_manifold::map::Parametrization;

/// Residual of the equations, relative to their sizes and to the coordinates.
const RESIDUAL: f64 = 1e-12;
/// Largest condition number of a chart: beyond it digits are lost.
const REGULAR: f64 = 100.0;
/// Largest distance of a position from q = 0, in the units of the coordinates.
const REACH: f64 = 0.1;

/// Checks every law of a solved constraint around its present configuration, at time `t`: that of its equations, those
/// of a map, and those of a change to other coordinates and to the tangent space.
pub fn implicit(map: &ImplicitMap, t: f64) -> Report {
    let mut report = Report::new(shortened(map.kind()));
    let mut random = Random::default();
    let (d, n) = map.dims();
    let own = layouts(map);
    let [rows, columns] = &own;
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
        let x = rows.coordinates(&motion(map, t, [&q, &rest, &rest])[0]);
        let allowed = RESIDUAL * (1.0 + norm(&x));
        let h = map.clone().violation(t, &q);
        report.defect("h(t, phi) = 0", at, h, allowed);
        let mut vector = || random.entries(&columns.units());
        let s = state(t, &q, [vector(), vector()]);
        slopes(&mut report, "", Mapped::of(map, &own), at, &s, &mut random);
        // A chart per coordinate and the tangent space; all coordinates take part.
        let splits = (0..n).map(|k| Some((0..d).map(|j| (k + j) % n).collect::<Vec<_>>()));
        for independent in splits.chain([None]) {
            let to = |m: &mut ImplicitMap, q: &mut [f64], v: &mut [f64], a: &mut [Vec<f64>]| {
                m.switch(t, independent.as_deref(), q, v, a)
            };
            let (mut probe, mut there) = (map.clone(), q.clone());
            if !to(&mut probe, &mut there, &mut vec![0.0; d], &mut [])
                || !regular(&probe, t, &there)
            {
                continue;
            }
            let split = map.independent();
            let back = |m: &mut ImplicitMap, q: &mut [f64], v: &mut [f64], a: &mut [Vec<f64>]| {
                m.switch(t, split.as_deref(), q, v, a)
            };
            // The change back into a tangent space leads to another one.
            let back: Option<&Change<_>> = split.is_some().then_some(&back);
            let name = match &independent {
                Some(k) => format!("{at}, to {k:?}"),
                None => format!("{at}, to the tangent space"),
            };
            let changes = (&to as &Change<_>, back);
            let (report, random) = (&mut report, &mut random);
            exchange(report, &name, (map, &layouts), (t, &q), changes, random);
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
    let of: (&M, Layouts<'_, M>) = (map, &|map| unscaled(map));
    exchange(&mut report, "q", of, (t, q), (change, back), &mut random);
    report
}

/// The layouts of x and of q at present.
type Layouts<'a, M> = &'a dyn Fn(&M) -> [Layout; 2];

/// The layouts of a constraint: each coordinate has the size of its unknown, or none in the tangent space.
fn layouts(map: &ImplicitMap) -> [Layout; 2] {
    let sizes = map.unknown_sizes();
    let columns = match map.independent() {
        Some(independent) => independent.iter().map(|&k| sizes[k]).collect(),
        None => vec![1.0; map.dims().0],
    };
    [&sizes, &columns].map(|units| Layout::in_units(units))
}

fn exchange<M: Parametrization + Clone>(
    report: &mut Report,
    at: &str,
    (map, layouts): (&M, Layouts<'_, M>),
    (t, q): (f64, &[f64]),
    (change, back): (&Change<'_, M>, Option<&Change<'_, M>>),
    random: &mut Random,
) {
    let d = q.len();
    let own = layouts(map);
    let of = Mapped::of(map, &own);
    let [rows, columns] = &own;
    let mut vector = || random.entries(&columns.units()).as_slice().to_vec();
    let v = vector();
    // ẍ is affine in the accelerations: d + 1 of them determine B, and hence the forces.
    let a: Vec<Vec<f64>> = (0..=d).map(|_| vector()).collect();
    let mut changed = map.clone();
    let (mut new_q, mut new_v, mut new_a) = (q.to_vec(), v.clone(), a.clone());
    if !change(&mut changed, &mut new_q, &mut new_v, &mut new_a) {
        return report.impossible("change", at, "no change was made");
    }
    let new_layouts = layouts(&changed);
    let there = Mapped::of(&changed, &new_layouts);
    let mut unit = 1.0;
    for (a, new_a) in a.iter().zip(&new_a) {
        let before = motion(map, t, [q, &v, a]);
        let after = motion(&changed, t, [&new_q, &new_v, new_a]);
        let [x, x_dot, x_ddot] = [0, 1, 2].map(|k| norm(&rows.coordinates(&before[k])));
        unit = 1.0 + x + x_dot + x_ddot;
        let gaps = [0, 1, 2].map(|k| relative(rows, [&after[k], &before[k]], unit));
        agree(report, "change: x, x_dot, x_ddot stay", at, &gaps);
        unit += norm(&of.row_norms(&before[3])) * norm(&there.row_norms(&after[3]));
    }
    let [v_there, a_there] = [&new_v, &new_a[0]].map(|x| DVector::from_column_slice(x));
    let s = state(t, &new_q, [v_there, a_there]);
    slopes(report, "changed: ", there, at, &s, random);
    let Some(back) = back else { return };
    if !back(&mut changed, &mut new_q, &mut new_v, &mut new_a) {
        return report.impossible("change and back", at, "there is no change back");
    }
    let relative = |found, exact, unit| relative(columns, [found, exact], unit);
    let mut gaps = vec![relative(&new_q, q, unit), relative(&new_v, &v, unit)];
    let both = new_a.iter().zip(&a);
    gaps.extend(both.map(|(found, a)| relative(found, a, unit * unit)));
    agree(report, "change and back", at, &gaps);
}

/// The difference of two vectors over the size of the second one, in the units of a layout and `unit` included.
fn relative(layout: &Layout, [found, exact]: [&[f64]; 2], unit: f64) -> f64 {
    let size = |x: &[f64]| norm(&layout.coordinates(x));
    size(&minus(found, exact)) / (size(exact) + unit)
}

/// A position at this distance, or at half of it as often as needed to be inside the domain.
fn inside(map: &ImplicitMap, t: f64, reach: f64, random: &mut Random) -> Option<Vec<f64>> {
    let mut q = vec![0.0; map.dims().0];
    random.direction(reach, &mut q);
    let units = layouts(map)[1].units();
    q.iter_mut().zip(&units).for_each(|(q, unit)| *q *= unit);
    for _ in 0..20 {
        if regular(map, t, &q) {
            return Some(q);
        }
        q.iter_mut().for_each(|q| *q *= 0.5);
    }
    None
}

/// Whether a position is inside the domain, in a chart of good condition.
fn regular(map: &ImplicitMap, t: f64, q: &[f64]) -> bool {
    map.clone().domain(t, q).unwrap_or(0.0) * REGULAR > 1.0
}

fn state(t: f64, q: &[f64], [v, a]: [DVector<f64>; 2]) -> TestState {
    let x = DVector::from_column_slice(q);
    TestState { t, x, v, a }
}
