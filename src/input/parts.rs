//! Lines and joints, constructed in an order in which the nodes of each exist before it.

use super::assemble::LineGeometry;
use super::file::{Closure as Word, Joint, ModelFile};
use super::names::Names;
use super::registry::Registry;
use super::{InputError, Problem, Text, joints, lines};
use pullback_elements::beam::Section;
use pullback_elements::constraint::PenaltyStiffness;
use pullback_elements::model::{Closure, ModelBuilder, NodeId};
use std::collections::BTreeMap;

/// The constructed lines and joints.
pub(super) struct Parts {
    /// Lines in the order of the file.
    pub lines: Vec<LineGeometry>,
    /// Nodes of released coordinates, by the name of their joint.
    pub released: Names<NodeId>,
}

/// The lines of the file, with their nodes once they are meshed.
pub(super) struct Laid {
    pub names: Names<usize>,
    pub lines: Vec<Option<LineGeometry>>,
}

/// A part whose nodes do not exist yet.
#[derive(Clone, Copy)]
enum Part {
    Line(usize),
    Joint(usize),
}

/// Constructs all lines and joints; their nodes are added to `nodes`.
pub(super) fn make(
    source: &Text<'_>,
    registry: &Registry,
    builder: &mut ModelBuilder,
    nodes: &mut Names<NodeId>,
    sections: &BTreeMap<String, Section>,
    file: &ModelFile,
) -> Result<Parts, InputError> {
    let mut laid = Laid {
        names: Names::lines(file),
        lines: file.lines.iter().map(|_| None).collect(),
    };
    let mut released = Names::new("joint with a released coordinate (a node of one coordinate)");
    let all = (0..file.lines.len()).map(Part::Line);
    let mut waiting: Vec<Part> = all.chain((0..file.joints.len()).map(Part::Joint)).collect();
    while !waiting.is_empty() {
        let before = waiting.len();
        let mut rest = Vec::new();
        for part in waiting {
            match part {
                Part::Line(k) => {
                    let line = &file.lines[k];
                    if !(nodes.knows(&line.from) && nodes.knows(&line.to)) {
                        rest.push(part);
                        continue;
                    }
                    let made = lines::lay(source, builder, nodes, sections, k, line)?;
                    for &node in &made.nodes[1..made.nodes.len() - 1] {
                        nodes.add(builder.node_name(node).to_owned(), node);
                    }
                    laid.lines[k] = Some(made);
                }
                Part::Joint(k) => {
                    let joint = &file.joints[k];
                    if !ready(joint, nodes, &laid) {
                        rest.push(part);
                        continue;
                    }
                    let made = joints::make(source, registry, builder, nodes, file, &laid, k)?;
                    nodes.add(joint.name.clone(), made.frame);
                    for &coordinate in &made.coordinates {
                        // A single coordinate has the name of the joint.
                        let name = match made.coordinates.len() {
                            1 => joint.name.clone(),
                            _ => builder.node_name(coordinate).to_owned(),
                        };
                        released.add(name, coordinate);
                    }
                }
            }
        }
        waiting = rest;
        if waiting.len() == before {
            return Err(stuck(source, nodes, file, &waiting));
        }
    }
    for (k, joint) in file.joints.iter().enumerate() {
        let index = k.to_string();
        let by = closure(source, joint, &index)?;
        let Some(child) = &joint.child else { continue };
        let path = ["joints", index.as_str(), "child"];
        let child = nodes.find(source, &path, child)?;
        let frame = nodes.find(source, &path, &joint.name)?;
        let refuse = |error| source.value(&path, Problem::Model(error));
        builder.close_by(frame, child, by).map_err(refuse)?;
    }
    for (k, gear) in file.gears.iter().enumerate() {
        let index = k.to_string();
        let path = |inner: &'static str| ["gears", index.as_str(), "joints", inner];
        let first = released.find(source, &path("0"), &gear.joints[0])?;
        let second = released.find(source, &path("1"), &gear.joints[1])?;
        builder
            .gear([first, second], gear.ratio)
            .map_err(|error| source.value(&["gears", &index], Problem::Model(error)))?;
    }
    Ok(Parts {
        lines: laid.lines.into_iter().flatten().collect(),
        released,
    })
}

/// The closure between a joint and its child; refuses inapplicable and missing keys.
fn closure(source: &Text<'_>, joint: &Joint, index: &str) -> Result<Closure, InputError> {
    let path = |key: &'static str| ["joints", index, key];
    let useless = |key: &'static str, needs: &'static str| {
        let joint = joint.name.clone();
        source.key(&path(key), Problem::ClosureKey { joint, key, needs })
    };
    if joint.closure.is_some() && joint.child.is_none() {
        return Err(useless(
            "closure",
            "child, the node that is one with the joint's",
        ));
    }
    let by = joint.closure.unwrap_or(Word::Map);
    for (key, given) in [
        ("penalty", joint.penalty),
        ("penalty_damping", joint.penalty_damping),
    ] {
        if given.is_some() && by != Word::Penalty {
            return Err(useless(key, "closure = \"penalty\""));
        }
    }
    let at = ["joints", index];
    match (by, joint.penalty) {
        (Word::Map, _) => Ok(Closure::Map),
        (Word::Multipliers, _) => Ok(Closure::Multipliers),
        (Word::Penalty, None) => Err(useless(
            "closure",
            "penalty, its stiffness (force over gap)",
        )),
        (Word::Penalty, Some(p)) => {
            let tau = joint.penalty_damping.unwrap_or(0.0);
            if p <= 0.0 {
                return Err(source.range(&at, "penalty", p, "a positive stiffness"));
            }
            if tau < 0.0 {
                let expected = "a time that is zero or positive";
                return Err(source.range(&at, "penalty_damping", tau, expected));
            }
            Ok(Closure::Penalty(PenaltyStiffness { p, tau }))
        }
    }
}

/// Whether a joint's parents exist.
fn ready(joint: &Joint, nodes: &Names<NodeId>, laid: &Laid) -> bool {
    let line_ready = |name: &String| {
        // An unknown line is refused with the joint.
        let k = laid.names.get(name);
        k.is_none_or(|k| laid.lines[k].is_some())
    };
    joint.lines.iter().all(line_ready) && joint.parent.as_ref().is_none_or(|m| nodes.knows(m))
}

/// Why no remaining part can be constructed: an unknown node, or a cycle of dependencies.
fn stuck(
    source: &Text<'_>,
    nodes: &Names<NodeId>,
    file: &ModelFile,
    waiting: &[Part],
) -> InputError {
    let mut wanted = Vec::new();
    for part in waiting {
        match *part {
            Part::Line(k) => {
                let line = &file.lines[k];
                wanted.push(("lines", k, "from", &line.from));
                wanted.push(("lines", k, "to", &line.to));
            }
            Part::Joint(k) => {
                let joint = &file.joints[k];
                if let Some(parent) = &joint.parent {
                    wanted.push(("joints", k, "parent", parent));
                }
            }
        }
    }
    wanted.retain(|(.., name)| !nodes.knows(name));
    let comes = |name: &str| {
        file.joints.iter().any(|j| j.name == name)
            || (name.split_once('/')).is_some_and(|(l, _)| file.lines.iter().any(|x| x.name == l))
    };
    for (table, k, key, name) in &wanted {
        let index = k.to_string();
        if !comes(name) {
            let path = [*table, index.as_str(), *key];
            if let Err(error) = nodes.find(source, &path, name) {
                return error;
            }
        }
    }
    let names = wanted.iter().map(|(.., name)| (*name).clone()).collect();
    let Some((table, k, key, _)) = wanted.first() else {
        return InputError::whole(Problem::Cycle { names });
    };
    let index = k.to_string();
    source.value(&[*table, index.as_str(), *key], Problem::Cycle { names })
}
