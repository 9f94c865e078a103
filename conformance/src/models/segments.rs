//! Where a map along a chain of elements changes from one segment to the next.

#![allow(non_snake_case)]

use super::view::parent_state;
use crate::elements::{Carrier, EXACT, FrameAt, carry};
use crate::{Compared, Layout, Mapped, Random, Report, State};
use nalgebra::{DVector, Vector3};
use pullback_elements::model::{Context, Node};
use pullback_manifold::map::Parametrization;

/// What is attached to a map.
pub(super) struct Child<'a> {
    pub rows: &'a Layout,
    /// Whether it is a frame, and its position in the reference configuration.
    pub framed: bool,
    pub position: Vector3<f64>,
}

/// Notes that the map gives the same motion, and hands the same forces back, on both segments where they
/// meet: with the coordinate along the chain at rest there, as a chain may have a corner. All others have
/// the motion of the state.
pub(super) fn laws(
    report: &mut Report,
    of: &Child<'_>,
    at: &str,
    sides: &[Side; 2],
    random: &mut Random,
) {
    let law = "change of segment: motion stays";
    let segments = sides.each_ref().map(|side| side.map.segment());
    if segments[0] == segments[1] {
        return report.impossible(law, at, "the map stays where it is");
    }
    let outside = |side: &Side| {
        side.map
            .duplicate()
            .margin(side.state.t, side.state.x.as_slice())
            <= 0.0
    };
    // The frame may have turned out of its chart there.
    if sides.iter().any(outside) {
        return;
    }
    let [(before, B_before), (mut after, B_after)] = sides.each_ref().map(motion);
    // f on the side after is Jᵀ f on the side before where the two are in different charts.
    let mut f = DVector::zeros(before.x.len());
    random.fill(f.as_mut_slice());
    let mut back = f.clone();
    if of.framed && (&before.x - &after.x).rows(3, 3).norm() > 1.0 {
        let own = [FrameAt {
            first: 0,
            position: of.position,
        }];
        let other = carry(Carrier::Chart, 0.0, &own, &after);
        let J = carry(Carrier::Chart, 0.0, &own, &before).B;
        after = other.state;
        back = J.tr_mul(&f);
    }
    let pairs = [
        ("x", &before.x, &after.x),
        ("x_dot", &before.v, &after.v),
        ("x_ddot", &before.a, &after.a),
    ];
    let [mut gaps, mut allowed] = [Vec::new(), Vec::new()];
    for (order, (_, a, b)) in pairs.iter().enumerate() {
        gaps.extend(of.rows.coordinates((*b - *a).as_slice()));
        let sizes = of.rows.magnitudes(a.as_slice(), order as i32);
        let behind = sides[0].state.x.amax().max(1.0);
        let sizes = of.rows.coordinates(&sizes);
        allowed.extend(sizes.iter().map(|s| EXACT * s * behind));
    }
    let worst = report.defects(law, at, &gaps, &allowed);
    report.blame(|| {
        let (name, right, found) = pairs[worst / of.rows.groups().len()];
        Compared {
            matrix: name,
            rows: of.rows,
            columns: &Layout::single(),
            forces: false,
            values: vec![(0, found.as_slice().to_vec(), right.as_slice().to_vec())],
        }
        .worst()
    });

    // The force on the coordinate along the chain changes at a corner.
    let handed = |side: &Side, B: &[f64], f: &DVector<f64>| {
        let columns = B.chunks_exact(f.len());
        let parts = columns.map(|b| b.iter().zip(f.iter()).map(|(b, f)| b * f).sum::<f64>());
        let all = side.coordinates.iter().copied().zip(parts);
        all.filter(|(c, _)| *c != side.along).collect::<Vec<_>>()
    };
    let [forces, others] = [
        handed(&sides[0], &B_before, &back),
        handed(&sides[1], &B_after, &f),
    ];
    let on = |all: &[(usize, f64)], c: usize| -> f64 {
        let own = all.iter().filter(|(other, _)| *other == c);
        own.map(|(_, f)| f).sum()
    };
    let mut everywhere: Vec<usize> = forces.iter().chain(&others).map(|(c, _)| *c).collect();
    everywhere.sort_unstable();
    everywhere.dedup();
    let [found, right] = [&others, &forces].map(|all| {
        let all = everywhere.iter().map(|&c| on(all, c));
        DVector::from_iterator(everywhere.len(), all)
    });
    let size = back.norm().max(f.norm()) * (1.0 + right.amax());
    let law = "change of segment: forces stay";
    report.defect(law, at, (&found - &right).amax(), EXACT * size);
}

/// The motion of what is attached to a map, and B.
fn motion(side: &Side) -> (State, Vec<f64>) {
    let (d, n) = side.map.dims();
    let of = Mapped {
        map: &*side.map,
        rows: &Layout::plain(n),
        columns: &Layout::plain(d),
    };
    let [x, x_dot, x_ddot, B, ..] = of.kinematics(&side.state);
    let [x, v, a] = [x, x_dot, x_ddot].map(DVector::from_vec);
    let t = side.state.t;
    (State { t, x, v, a }, B)
}

/// A map on one side of a change of segment, and the motion of the parents that it has there.
pub(super) struct Side {
    map: Box<dyn Parametrization>,
    state: State,
    /// Which of the model's coordinates those of the parents are.
    coordinates: Vec<usize>,
    /// The coordinate along the chain: it rests where the segment changes.
    along: usize,
}

/// Size of the step that ends at a change of segment.
const NUDGE: f64 = 1e-3;

/// The positions of the next changes of segment of a node's map, along each of the coordinates that it
/// reads, as the configuration last set has all others: the map before and after.
pub(super) fn changes(context: &Context, n: u32, t: f64) -> Vec<[Side; 2]> {
    let node = &context.nodes()[n as usize];
    let Some(map) = context.map_of(node) else {
        return Vec::new();
    };
    let here = side(context, node, map.duplicate(), t, None);
    let mut all = Vec::new();
    for (j, &along) in here.coordinates.iter().enumerate() {
        for sign in [1.0, -1.0] {
            let mut v = vec![0.0; here.coordinates.len()];
            v[j] = sign;
            let q = here.state.x.as_slice();
            let mut from = q.to_vec();
            from[j] -= sign * NUDGE;
            let ahead = map.overshoot(NUDGE, [&from, &v], [q, &v]);
            let Some((late, segment)) = ahead.filter(|(late, _)| late.is_finite()) else {
                continue;
            };
            let border = Some((along, q[j] - sign * late));
            let before = side(context, node, map.duplicate(), t, border);
            let mut next = map.duplicate();
            next.enter(segment);
            next.change_charts(t, before.state.x.as_slice());
            // It reads other parents now, and may want other charts for them.
            let mut after = side(context, node, next, t, border);
            after.map.change_charts(t, after.state.x.as_slice());
            all.push([before, after]);
        }
    }
    all
}

fn side(
    context: &Context,
    node: &Node,
    mut map: Box<dyn Parametrization>,
    t: f64,
    border: Option<(usize, f64)>,
) -> Side {
    map.freeze_piece(None);
    let parents = node.parents(map.segment());
    let ranges = parents.iter().map(|&m| context.nodes()[m as usize].range());
    let coordinates: Vec<usize> = ranges.flatten().collect();
    let mut state = parent_state(context, parents, t);
    let along = border.map_or(usize::MAX, |(along, _)| along);
    for (j, _) in coordinates.iter().enumerate().filter(|(_, c)| **c == along) {
        state.x[j] = border.map_or(state.x[j], |b| b.1);
        (state.v[j], state.a[j]) = (0.0, 0.0);
    }
    Side {
        map,
        state,
        coordinates,
        along,
    }
}
