//! States inside the domains of all maps.

use super::view::{maps, parent_state};
use pullback_elements::model::{Context, NodeForm};
use pullback_manifold::system::Point;

/// Margin below which a joint is at the boundary of its domain, and the step away from there in units.
const NARROW: f64 = 1e-3;
const STEP: f64 = 0.1;

/// Moves joints from the boundaries of their domains, such as a slide at the end of its chain, a little inside:
/// differences require states on all sides.
pub(super) fn step_inside(context: &mut Context, t: f64, q: &mut [f64], units: &[f64]) {
    for k in 0..context.mapped_nodes().len() {
        let Some(margin) = room(context, k, t, q).filter(|&room| room < NARROW) else {
            continue;
        };
        let Some((_, _, parents)) = maps(context).nth(k) else {
            continue;
        };
        let steps: Vec<(usize, f64)> = (parents.iter())
            .filter(|&&m| context.nodes()[m as usize].form() == NodeForm::Coordinates)
            .flat_map(|&m| {
                let free = context.nodes()[m as usize].range();
                let free = free.filter_map(|c| context.unknown_of(c));
                free.map(move |u| (u, STEP * units[m as usize]))
            })
            .collect();
        let mut best = (10.0 * margin, None);
        for (u, step) in steps.into_iter().flat_map(|(u, s)| [(u, s), (u, -s)]) {
            q[u] += step;
            let there = room(context, k, t, q).unwrap_or(0.0);
            q[u] -= step;
            if there > best.0 {
                best = (there, Some((u, step)));
            }
        }
        if let Some((u, step)) = best.1 {
            q[u] += step;
        }
    }
}

/// The margin of map number `k` at a state at rest; none outside of its domain.
fn room(context: &mut Context, k: usize, t: f64, q: &[f64]) -> Option<f64> {
    let (v, a) = (&[][..], &[][..]);
    context.configure(Point { t, q, v, a }).ok()?;
    let (_, mut map, parents) = maps(context).nth(k)?;
    map.domain(t, parent_state(context, parents, t).x.as_slice())
        .ok()
}
