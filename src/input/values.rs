//! Initial values of joints, and their effect on attached nodes.

use super::assemble::LineGeometry;
use super::file::{Acts, Analysis, ModelFile};
use super::names::Names;
use super::{InputError, Problem, Text};
use pullback_elements::model::{Context, NodeId};

/// Sets the initial coordinates of joints, and rotates the frames above them with them, those of spherical
/// joints included; unknowns that are `placed` stay.
pub(super) fn start(
    source: &Text<'_>,
    context: &mut Context,
    released: &Names<NodeId>,
    lines: &[LineGeometry],
    file: &ModelFile,
    q: &mut [f64],
    placed: &[usize],
) -> Result<(), InputError> {
    for (index, name, value) in given(file, |acts| acts.value) {
        let at = ["joints", index.as_str(), "value"];
        let node = released.find(source, &at, &name)?;
        // In a model that enforces equations values were taken into account by its assembly, as far as they are
        // compatible.
        let assembled = context.is_enforced() && context.unknown_at(node, 0).is_some();
        if !assembled && !context.set(q, node, 0, value) && !context.in_loop(node) {
            geared(source, &at, file, &name, "value")?;
        }
    }
    if !matches!(file.analysis, Analysis::Dynamic(_)) {
        return Ok(());
    }
    // Where a map cannot be evaluated at the start, the analysis says so.
    let carried = context.carry_rotations(q, placed).unwrap_or_default();
    drawn_apart(source, context, lines, [&carried, placed])
}

/// Values of single joint coordinates in the file: number of the joint, name of the coordinate, and the value.
pub(super) fn given(
    file: &ModelFile,
    pick: fn(&Acts) -> Option<f64>,
) -> impl Iterator<Item = (String, String, f64)> + '_ {
    (file.joints.iter().enumerate()).flat_map(move |(k, joint)| {
        let acts = joint.all_acts();
        let given = acts.filter_map(move |(coordinate, acts)| {
            let name = format!("{} {coordinate}", joint.name);
            Some((k.to_string(), name.trim_end().to_owned(), pick(&acts)?))
        });
        given.collect::<Vec<_>>()
    })
}

/// Refuses a value or rate of a coordinate that depends on another one through a gear.
pub(super) fn geared(
    source: &Text<'_>,
    at: &[&str; 3],
    file: &ModelFile,
    name: &str,
    key: &'static str,
) -> Result<(), InputError> {
    if file
        .gears
        .iter()
        .any(|g| g.joints.iter().any(|j| j == name))
    {
        let joint = name.to_owned();
        return Err(source.value(at, Problem::Geared { joint, key }));
    }
    Ok(())
}

/// Refuses lines between nodes moved along with a spherical joint and nodes that stay.
fn drawn_apart(
    source: &Text<'_>,
    context: &Context,
    lines: &[LineGeometry],
    [carried, placed]: [&[usize]; 2],
) -> Result<(), InputError> {
    for (k, line) in lines.iter().enumerate().filter(|_| !carried.is_empty()) {
        let among = |n: NodeId, some: &[usize]| {
            let behind = context.unknowns_behind(&[n]);
            behind.iter().any(|u| some.contains(u))
        };
        let moves = |n: &&NodeId| !context.is_own(**n) && among(**n, carried);
        let stays = |n: &NodeId| context.is_own(*n) && !among(*n, placed);
        let Some(&moves) = line.nodes.iter().find(moves) else {
            continue;
        };
        if line.nodes.iter().any(stays) {
            let mut frames = context.frames();
            let node = frames.find(|(id, _)| *id == moves);
            let problem = Problem::DrawnApart {
                line: line.name.clone(),
                node: node.map_or_else(String::new, |(_, name)| name.to_owned()),
            };
            return Err(source.value(&["lines", &k.to_string(), "name"], problem));
        }
    }
    Ok(())
}
