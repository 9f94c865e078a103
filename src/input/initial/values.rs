//! Initial values of joints, and their effect on attached nodes.

use crate::input::file::{Acts, ModelFile};
use crate::input::parts::Assembly;
use crate::input::{InputError, InputProblem, Location};
use pullback_elements::model::{Context, NodeId};

/// Sets the initial coordinates of joints, and rotates the frames that they carry, those of spherical
/// joints included; unknowns that are `placed` stay.
pub(super) fn start(
    assembly: &Assembly<'_>,
    context: &mut Context,
    q: &mut [f64],
    placed: &[usize],
) -> Result<(), InputError> {
    for (joint, name, value) in given(assembly.file, |acts| acts.value) {
        let at = assembly.at("joints").at(joint).at("value");
        let node = assembly.joint_coordinates.find(&at, &name)?;
        // In a model that enforces equations values were taken into account by its assembly, as far as they are
        // compatible.
        let assembled = context.is_enforced() && context.unknown_at(node, 0).is_some();
        if !assembled && !context.set(q, node, 0, value) && !context.in_loop(node) {
            geared(&at, assembly.file, &name, "value")?;
        }
    }
    if !assembly.file.analysis.is_dynamic() {
        return Ok(());
    }
    // Where a map cannot be evaluated at the start, the analysis says so.
    let carried = context.carry_rotations(q, placed).unwrap_or_default();
    drawn_apart(assembly, context, [&carried, placed])
}

/// Values of single joint coordinates in the file: number of the joint, name of the coordinate, and the value.
pub(super) fn given(
    file: &ModelFile,
    pick: fn(&Acts) -> Option<f64>,
) -> impl Iterator<Item = (usize, String, f64)> + '_ {
    (file.joints.iter().enumerate()).flat_map(move |(k, joint)| {
        let acts = joint.all_acts();
        acts.filter_map(move |(coordinate, acts)| {
            let name = format!("{} {coordinate}", joint.name);
            Some((k, name.trim_end().to_owned(), pick(&acts)?))
        })
    })
}

/// Refuses a value or rate of a coordinate that depends on another one through a gear.
pub(super) fn geared(
    at: &Location<'_>,
    file: &ModelFile,
    name: &str,
    key: &'static str,
) -> Result<(), InputError> {
    let joint = name.to_owned();
    match file.gears.iter().any(|g| g.joints.contains(&joint)) {
        true => Err(at.refuse(InputProblem::Geared { joint, key })),
        false => Ok(()),
    }
}

/// Refuses lines between nodes moved along with a spherical joint and nodes that stay.
fn drawn_apart(
    assembly: &Assembly<'_>,
    context: &Context,
    [carried, placed]: [&[usize]; 2],
) -> Result<(), InputError> {
    let lines = assembly.geometry.lines.iter().enumerate();
    for (k, line) in lines.filter(|_| !carried.is_empty()) {
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
            let problem = InputProblem::DrawnApart {
                line: line.name.clone(),
                node: node.map_or_else(String::new, |(_, name)| name.to_owned()),
            };
            return Err(assembly.at("lines").at(k).at("name").refuse(problem));
        }
    }
    Ok(())
}
