//! Continuity of a map along a chain of elements from one segment to the next.

use super::view::parent_state;
use crate::block::{Rows, wrong_entries};
use crate::elements::{Carrier, EXACT, FrameAt, carry};
use crate::maps::{freeze_piece, saved};
use crate::vectors::{dot, larger};
use crate::{Layout, Mapped, Random, Report, TestState};
use nalgebra::DVector;
use pullback_elements::model::{Context, Node};
use pullback_manifold::map::Parametrization;
use std::collections::BTreeMap;

/// Checks that motion and forces of the node of a map are the same on both segments where they meet. The coordinate
/// along the chain is at rest there, since a chain may have a corner; all others have the motion of the state.
pub(super) fn laws(
    report: &mut Report,
    (node, rows): (&Node, &Layout),
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
        let (t, x) = (side.state.t, side.state.x.as_slice());
        side.map.duplicate().domain(t, x).is_err()
    };
    // The frame may be outside of its chart there.
    if sides.iter().any(outside) {
        return;
    }
    saved(
        report,
        at,
        sides.each_ref().map(|side| &*side.map),
        &sides[1].state,
    );
    let [(before, B_before), (mut after, B_after)] = sides.each_ref().map(motion);
    // f after the change is Jᵀ f before it if the two are in different charts.
    let f = random.entries(&vec![1.0; before.x.len()]);
    let mut back = f.clone();
    if node.is_frame() && (&before.x - &after.x).rows(3, 3).norm() > 1.0 {
        let own = [FrameAt {
            first: 0,
            position: node.position(),
        }];
        let other = carry(Carrier::Chart, &own, &after);
        let J = carry(Carrier::Chart, &own, &before).B;
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
        gaps.extend(rows.coordinates((*b - *a).as_slice()));
        let sizes = rows.magnitudes(a.as_slice(), order as i32);
        let behind = sides[0].state.x.amax().max(1.0);
        let sizes = rows.coordinates(&sizes);
        allowed.extend(sizes.iter().map(|s| EXACT * s * behind));
    }
    let worst = report.defects(law, at, &gaps, &allowed);
    report.blame(|| {
        let (name, right, found) = pairs[worst / rows.groups().len()];
        let rows = Rows::Coordinates(rows);
        wrong_entries(name, rows, found.as_slice(), right.as_slice())
    });
    forces_stay(report, at, sides, [(&B_before, &back), (&B_after, &f)]);
}

/// Checks the forces on the coordinates of the parents, given B and the force on both sides. The force on the
/// coordinate along the chain changes at a corner.
fn forces_stay(
    report: &mut Report,
    at: &str,
    sides: &[Side; 2],
    both: [(&Vec<f64>, &DVector<f64>); 2],
) {
    let mut forces: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
    for (k, (side, (B, f))) in sides.iter().zip(both).enumerate() {
        for (&c, b) in side.coordinates.iter().zip(B.chunks_exact(f.len())) {
            if Some(c) != side.along {
                forces.entry(c).or_default()[k] += dot(b, f.as_slice());
            }
        }
    }
    let gaps = forces.values().map(|[right, found]| (found - right).abs());
    let sizes = forces.values().map(|[right, _]| right.abs());
    let size = both.map(|(_, f)| f.norm()).into_iter().fold(0.0, f64::max);
    let allowed = EXACT * size * (1.0 + sizes.fold(0.0, f64::max));
    let law = "change of segment: forces stay";
    report.defect(law, at, gaps.fold(0.0, larger), allowed);
}

/// The motion of the node of a map, and B.
fn motion(side: &Side) -> (TestState, Vec<f64>) {
    let (d, n) = side.map.dims();
    let of = Mapped {
        map: &*side.map,
        rows: &Layout::plain(n),
        columns: &Layout::plain(d),
    };
    let [x, x_dot, x_ddot, B, ..] = of.kinematics(&side.state);
    let [x, v, a] = [x, x_dot, x_ddot].map(DVector::from_vec);
    let t = side.state.t;
    (TestState { t, x, v, a }, B)
}

/// A map before or after a change of segment, and the motion of its parents there.
pub(super) struct Side {
    map: Box<dyn Parametrization>,
    state: TestState,
    /// Numbers of the parents' coordinates in the model.
    coordinates: Vec<usize>,
    /// The coordinate along the chain, which is at rest at a change.
    along: Option<usize>,
}

/// Size of the step that ends at a change of segment.
const NUDGE: f64 = 1e-3;

/// The map of a node before and after the next changes of segment, along each coordinate of its parents from the
/// present configuration.
pub(super) fn changes(context: &Context, n: u32, t: f64) -> Vec<[Side; 2]> {
    let node = &context.nodes()[n as usize];
    let Some(map) = context.map_of(node) else {
        return Vec::new();
    };
    let Some(segments) = map.segments() else {
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
            let ahead = segments.overshoot(NUDGE, [&from, &v], [q, &v]);
            let Some((late, segment)) = ahead.filter(|(late, _)| late.is_finite()) else {
                continue;
            };
            let border = Some((along, q[j] - sign * late));
            let before = side(context, node, map.duplicate(), t, border);
            let mut next = map.duplicate();
            if let Some(state) = next.state() {
                state.enter(segment);
            }
            change_charts(&mut *next, &before.state);
            // It depends on other parents now, whose charts may have to change.
            let mut after = side(context, node, next, t, border);
            change_charts(&mut *after.map, &after.state);
            all.push([before, after]);
        }
    }
    all
}

fn change_charts(map: &mut dyn Parametrization, at: &TestState) {
    if let Some(state) = map.state() {
        state.change_charts(at.t, at.x.as_slice());
    }
}

fn side(
    context: &Context,
    node: &Node,
    mut map: Box<dyn Parametrization>,
    t: f64,
    border: Option<(usize, f64)>,
) -> Side {
    freeze_piece(&mut *map, None);
    let parents = node.parents(map.segment());
    let ranges = parents.iter().map(|&m| context.nodes()[m as usize].range());
    let coordinates: Vec<usize> = ranges.flatten().collect();
    let mut state = parent_state(context, parents, t);
    for (j, c) in coordinates.iter().enumerate() {
        if let Some((_, x)) = border.filter(|(along, _)| along == c) {
            (state.x[j], state.v[j], state.a[j]) = (x, 0.0, 0.0);
        }
    }
    Side {
        map,
        state,
        coordinates,
        along: border.map(|(along, _)| along),
    }
}
