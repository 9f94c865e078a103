//! Velocities prescribed by initial conditions in models whose loops are closed by multipliers or
//! penalties: kept where the loops allow them, refused otherwise.

use super::velocities::Velocities;
use super::{Start, VELOCITY_TOLERANCE};
use crate::input::parts::Assembly;
use crate::input::{InputError, InputProblem, Location};
use pullback_elements::model::{BEFORE_START, Context, ModelError, NodeId};

/// The unknowns whose velocities an entry of `[[initial]]` prescribes.
pub(super) struct VelocityRequest<'a> {
    pub at: Location<'a>,
    pub unknowns: Vec<usize>,
    /// Whether it applies to one node. Rates of joints and velocities of nodes take precedence over
    /// entries for lines and for the whole model.
    pub of_node: bool,
}

/// The unknowns of a node's position (first), of its rotation (second), or both.
pub(super) fn unknowns(
    context: &Context,
    node: NodeId,
    of: [bool; 2],
) -> impl Iterator<Item = usize> + '_ {
    let (free, turn) = rotation(context, node);
    let all = [(node, 0, of[0]), (free, turn, of[1])].into_iter();
    let chosen = all.filter(|(.., chosen)| *chosen);
    chosen
        .flat_map(|(node, first, _)| (first..first + 3).map(move |k| (node, k)))
        .filter_map(|(node, k)| context.unknown_at(node, k))
}

/// The node whose free coordinates are the rotation of a node, and the first of them.
pub(super) fn rotation(context: &Context, node: NodeId) -> (NodeId, usize) {
    let free = context.free_rotation_of(node);
    (free, if free == node { 3 } else { 0 })
}

/// The rate of a coordinate of a joint, or a component of the velocity of a frame that is attached to one.
pub(super) struct Rate<'a> {
    pub node: NodeId,
    /// The number of the coordinate, or of the component.
    pub k: usize,
    /// Its unknown; `None` of a frame, and in a loop that a map closes.
    pub u: Option<usize>,
    /// Name of the coordinate, or of the node.
    pub of: String,
    /// The key that gives it.
    pub key: &'static str,
    pub at: Location<'a>,
    /// Prescribed rate.
    pub rate: f64,
}

/// The refusal of rates that contradict each other, by what is left of the largest.
pub(super) fn contradiction(rates: &[&Rate<'_>], left: f64) -> InputProblem {
    let mut names: Vec<&str> = rates.iter().map(|r| &*r.of).collect();
    names.dedup();
    let most = rates.iter().fold(0.0_f64, |m, r| m.max(r.rate.abs()));
    InputProblem::LoopRates {
        of: names.join(", "),
        left: left * most,
    }
}

/// Projects initial coordinates and velocities onto the equations of multipliers and penalties by the smallest changes. Positions
/// and rotations, the unknowns that are `placed`, are kept if possible, in the order of the file; rates of joints are kept, those in loops of maps with the unknowns
/// that are `held`, then velocities of nodes in the order of the file.
pub(super) fn project(
    assembly: &Assembly<'_>,
    context: &mut Context,
    velocities: Velocities<'_>,
    placed: &[Vec<usize>],
) -> Result<Start, InputError> {
    let Velocities {
        mut start,
        rates,
        determined_unknowns: mut held,
        mut requests,
    } = velocities;
    if !context.is_enforced() {
        return Ok(start);
    }
    let failed = |error| assembly.locate(error);
    if !assembly.file.analysis.begins_in_equilibrium() {
        (context.project_positions(0.0, &mut start.q, &held, placed)).map_err(failed)?;
    }
    let (left, _) = remaining_error(context, &start, &held).map_err(failed)?;
    let moves = rates.iter().any(|r| r.rate.abs() > 0.0);
    if let (Some(first), true) = (rates.first(), moves && left > VELOCITY_TOLERANCE) {
        for (rate, u) in rates.iter().filter_map(|r| Some((r, r.u?))) {
            if context.is_locked(0.0, &start.q, u).map_err(failed)? {
                let of = rate.of.clone();
                return Err(rate.at.refuse(InputProblem::LoopLocked { of }));
            }
        }
        let all: Vec<_> = rates.iter().collect();
        return Err(first.at.refuse(contradiction(&all, left)));
    }
    // As with maps of loops, prescribed motion has a velocity of its own, whatever that of the whole model.
    let file = assembly.file;
    let prescribed = file.supports.iter().any(|s| s.prescribed.is_some())
        || (file.joints.iter()).any(|j| j.acts_any(|a| a.prescribed.is_some()));
    let yields = prescribed || requests.iter().any(|a| a.of_node) || !held.is_empty();
    requests.sort_by_key(|a| !a.of_node);
    for request in requests {
        let before = held.len();
        held.extend(request.unknowns);
        let (left, joint) = remaining_error(context, &start, &held).map_err(failed)?;
        if left <= VELOCITY_TOLERANCE {
            continue;
        }
        if request.of_node || !yields {
            return Err(request.at.refuse(InputProblem::LoopMotion { joint }));
        }
        held.truncate(before);
    }
    let Start { q, v, .. } = &mut start;
    (context.project_velocities(BEFORE_START, q, v, &held)).map_err(failed)?;
    Ok(start)
}

/// The remaining error of velocities with the unknowns `held`, and the joint where it is largest.
fn remaining_error(
    context: &mut Context,
    start: &Start,
    held: &[usize],
) -> Result<(f64, String), ModelError> {
    let mut v = start.v.clone();
    context.project_velocities(BEFORE_START, &start.q, &mut v, held)
}
