//! A set of loops that share coordinates: dependencies and equations.

use super::chain::{self, JointLoop, coordinates};
use super::coincide::{Coincide, CoincidePoses};
use super::part::Part;
use super::{APART, EQUATIONS, LoopReport, Setting};
use crate::model::assembly::residual::MAX_NODES;
use crate::model::build::builder::NodeId;
use crate::model::kinematics::mapped_node::MappedNode;
use crate::model::{ModelError, NONE, Node, NodeForm, Subject};
use nalgebra::Vector3;
use pullback_manifold::implicit::{Description, Equation, ImplicitMap, Unknown};
use pullback_manifold::map::{MapGraph, Parametrization, Read};
use pullback_manifold::system::Quantity;
use std::collections::HashMap;

/// Condition number, for each unknown, up to which a loop keeps its coordinates: a scheme conserves
/// energy in one set of coordinates, and every change costs some.
const GOOD_CONDITION: f64 = 10.0;

/// The inputs of a set of loops: first the parameters, then the unknowns.
pub(super) struct Inputs {
    /// Nodes of the parameters and of the unknowns, each with its first one among them.
    parameters: Vec<(u32, usize)>,
    unknowns: Vec<(u32, usize)>,
    /// Number of parameters, and of all inputs.
    parameter_count: usize,
    pub(super) count: usize,
}

impl Inputs {
    /// Sorts own coordinate nodes, and required roots, into parameters and unknowns.
    pub(super) fn new(nodes: &[Node], own: &[u32], roots: &[u32], setting: &Setting<'_>) -> Self {
        let moves = |n: &u32| !setting.still(*n as usize, nodes[*n as usize].dim);
        let given = |n: &u32| roots.contains(n) || setting.any(*n as usize);
        let all = roots.iter().chain(own).copied().filter(moves);
        let (parameters, unknowns): (Vec<u32>, Vec<u32>) = all.partition(given);
        let count = |of: &[u32]| of.iter().map(|&n| nodes[n as usize].dim).sum::<usize>();
        let with_first = |of: &[u32]| {
            let first = |k: usize| count(&of[..k]);
            of.iter().enumerate().map(|(k, &n)| (n, first(k))).collect()
        };
        Self {
            parameter_count: count(&parameters),
            count: count(&parameters) + count(&unknowns),
            parameters: with_first(&parameters),
            unknowns: with_first(&unknowns),
        }
    }

    /// All nodes with their first input.
    pub(super) fn all(&self) -> impl Iterator<Item = (u32, usize)> {
        let after = |&(n, first): &(u32, usize)| (n, self.parameter_count + first);
        let parameters = self.parameters.iter().copied();
        parameters.chain(self.unknowns.iter().map(after))
    }

    pub(super) fn read(&self, node: u32) -> Read {
        let found = self.all().find(|(n, _)| *n == node);
        found.map_or(Read::Nothing, |(_, first)| Read::Input(first))
    }
}

/// The equations of chains, as a tree of copies of their maps.
pub(super) fn tree(nodes: &[Node], chains: &[JointLoop], inputs: &Inputs) -> MapGraph {
    let mut tree = MapGraph::new(inputs.count);
    let mut made: HashMap<(u32, u32), Read> = HashMap::new();
    let mut closures = Vec::new();
    for chain in chains {
        let poses = [chain.frame, chain.child].map(|n| nodes[n as usize].partner);
        let ends = poses.map(|n| add(nodes, n, chain, inputs, &mut tree, &mut made));
        let position = |n: u32| nodes[n as usize].position;
        let apart = position(chain.frame) - position(chain.child);
        closures.push((Coincide { apart }, ends));
    }
    for (between, ends) in closures {
        let reads = ends.map(|end| (end, 6)).to_vec();
        tree.add(Box::new(CoincidePoses(between)), reads);
    }
    tree.with_outputs(chains.len()).named("closed loop")
}

/// Adds the map of node n, and of those above it, up to the root.
fn add(
    nodes: &[Node],
    n: u32,
    chain: &JointLoop,
    inputs: &Inputs,
    tree: &mut MapGraph,
    made: &mut HashMap<(u32, u32), Read>,
) -> Read {
    if chain.root == Some(n) {
        return inputs.read(n);
    }
    let node = &nodes[n as usize];
    if node.form == NodeForm::Pose {
        // The pose of a frame that does not move in the equations of the loop.
        let chart = node.partner;
        let ends = chain.root == Some(chart) || nodes[chart as usize].is_own();
        if ends && inputs.read(chart) == Read::Nothing {
            return Read::Nothing;
        }
    }
    let Some(d) = node.mapped() else {
        return inputs.read(n);
    };
    let key = (n, chain.root.unwrap_or(NONE));
    if let Some(&read) = made.get(&key) {
        return read;
    }
    let reads = (d.initial_parents().iter())
        .map(|&m| {
            let read = add(nodes, m, chain, inputs, tree, made);
            (read, nodes[m as usize].dim)
        })
        .collect();
    let read = tree.add(d.map.clone(), reads);
    made.insert(key, read);
    read
}

/// Loops without dependent joint coordinates: valid if the frames coincide as drawn.
fn nothing_follows(
    nodes: &[Node],
    chains: &[JointLoop],
    joints: Subject,
    given: &[(u32, usize)],
    equations: &mut dyn Parametrization,
    setting: &Setting<'_>,
) -> Result<LoopReport, ModelError> {
    if !given.is_empty() {
        let names: Vec<&str> = (given.iter())
            .map(|&(n, _)| nodes[n as usize].name.as_str())
            .collect();
        let prescribed = names.join(", ");
        return Err(ModelError::AllPrescribed { joints, prescribed });
    }
    let mut h = vec![0.0; 6 * chains.len()];
    equations.evaluate(0.0, [&[]; 3], &mut [[&mut h, &mut []]]);
    for (chain, h) in chains.iter().zip(h.chunks_exact(6)) {
        let gap = Vector3::new(h[0], h[1], h[2]).norm();
        let turn = Vector3::new(h[3], h[4], h[5]).norm();
        if gap > APART * setting.length || turn > APART {
            return Err(ModelError::Rigid {
                joint: Subject::node(nodes, chain.frame),
                child: nodes[chain.child as usize].name.clone(),
                gap,
                turn,
            });
        }
    }
    Ok(LoopReport::say(format!(
        "{joints}: nothing can move between the frames, which are one as drawn; redundant"
    )))
}

/// Report on desired values that are inconsistent.
fn displaced(nodes: &[Node], unknowns: &[(u32, usize)], map: &ImplicitMap) -> String {
    let mut words = String::new();
    for (k, x) in map.displaced() {
        let of = |(n, first): &&(u32, usize)| (*first..first + nodes[*n as usize].dim).contains(&k);
        if let Some(&(n, first)) = unknowns.iter().find(of) {
            let name = nodes[n as usize].coordinate_name(k - first);
            words += &format!("; {name} starts at {x:.6}, as its value does not close the loop");
        }
    }
    words
}

/// Report on frames that coincide but are drawn apart.
fn drawn_apart(nodes: &[Node], chains: &[JointLoop], setting: &Setting<'_>) -> String {
    let mut words = String::new();
    for chain in chains {
        let (a, b) = (&nodes[chain.frame as usize], &nodes[chain.child as usize]);
        let gap = (a.position - b.position).norm();
        if gap > APART * setting.length {
            words += &format!("; {} and {} were drawn {gap:.3e} apart", a.name, b.name);
        }
    }
    words
}

/// Preference of a coordinate as an independent one: above a half if requested by the user, and
/// larger near the root of its loop.
fn preference(nodes: &[Node], chains: &[JointLoop], n: u32, setting: &Setting<'_>) -> f64 {
    let depth = chains.iter().flat_map(|chain| {
        [chain.frame, chain.child].into_iter().filter_map(|end| {
            let path = chain::upwards(nodes, end);
            let below = path.iter().position(|f| Some(*f) == chain.root);
            let below = &path[..below.unwrap_or(path.len())];
            let reads = |f: &u32| {
                let mapped = nodes[*f as usize].mapped();
                mapped.is_some_and(|d| d.initial_parents().contains(&n))
            };
            below.iter().rev().position(reads)
        })
    });
    let near = 0.5 / (1 + depth.min().unwrap_or(0)) as f64;
    if setting.preferred.contains(&NodeId(n)) {
        0.5 + near
    } else {
        near
    }
}

/// Describes the unknowns, parameters and equations of a set of loops.
fn described(
    nodes: &[Node],
    chains: &[JointLoop],
    inputs: &Inputs,
    setting: &Setting<'_>,
) -> Description {
    let mut about = Description {
        good_condition: GOOD_CONDITION,
        ..Description::default()
    };
    for (n, first) in inputs.all() {
        let node = &nodes[n as usize];
        let rotation = node.rotation().map(|_| first + node.dim - 3);
        about.rotations.extend(rotation);
    }
    for &(n, _) in &inputs.unknowns {
        let node = &nodes[n as usize];
        for (k, quantity) in node.quantities.iter().enumerate() {
            about.unknowns.push(Unknown {
                name: node.coordinate_name(k),
                size: quantity.size(setting.length),
                start: setting.starts.get(&(NodeId(n), k)).copied(),
                preference: preference(nodes, chains, n, setting),
            });
        }
    }
    for chain in chains {
        let name = &nodes[chain.frame as usize].name;
        about.equations.extend((0..6).map(|i| Equation {
            name: format!("{} at joint {name}", EQUATIONS[i]),
            size: Some(if i < 3 { setting.length } else { 1.0 }),
        }));
    }
    let of = |&(n, _): &(u32, usize)| {
        let node = &nodes[n as usize];
        std::iter::repeat_n(node.name.clone(), node.dim)
    };
    about.parameters = inputs.parameters.iter().flat_map(of).collect();
    about
}

/// The inputs of a set of loops: the joint coordinates of their chains, and roots that matter.
fn inputs_of(nodes: &[Node], chains: &[JointLoop], setting: &Setting<'_>) -> Inputs {
    let mut own: Vec<u32> = chains.iter().flat_map(|c| coordinates(nodes, c)).collect();
    own.sort_unstable();
    own.dedup();
    let mut roots: Vec<u32> = Vec::new();
    for chain in chains {
        let matters = |root: &u32| chain::root_matters(nodes, chain, *root, setting);
        roots.extend(chain.root.filter(matters));
        roots.extend(chain.ends.iter().flatten());
    }
    roots.sort_unstable();
    roots.dedup();
    Inputs::new(nodes, &own, &roots, setting)
}

/// Adds the nodes of a set of loops: the independent coordinates and all unknowns, which the map gives to the joints.
/// Returns the node of the unknowns.
fn add_map(
    nodes: &mut Vec<Node>,
    map: ImplicitMap,
    inputs: &Inputs,
    joints: &str,
) -> Result<u32, ModelError> {
    let of = |&(n, _): &(u32, usize)| nodes[n as usize].quantities.clone();
    let quantities: Vec<Quantity> = inputs.unknowns.iter().flat_map(of).collect();
    let D = map.freedoms();
    let first = map.independent().and_then(|k| k.first().copied());
    let quantity = first.map_or(Quantity::Angle, |k| quantities[k]);
    let mut parents: Vec<u32> = inputs.parameters.iter().map(|&(n, _)| n).collect();
    if D > 0 {
        let (name, own) = (format!("loop of {joints}"), vec![quantity; D]);
        nodes.push(Node::new(name, NodeForm::Coordinates, &own, None));
        parents.insert(0, nodes.len() as u32 - 1);
    }
    if parents.len() > MAX_NODES {
        return Err(ModelError::TooManyNodes {
            element: format!("the loop of {joints}"),
            found: parents.len(),
            limit: MAX_NODES,
        });
    }
    let map = MappedNode::of(Box::new(map), parents);
    let name = format!("coordinates of {joints}");
    nodes.push(Node::new(
        name,
        NodeForm::Coordinates,
        &quantities,
        Some(map),
    ));
    let x = nodes.len() as u32 - 1;
    for &(n, first) in &inputs.unknowns {
        let node = &mut nodes[n as usize];
        let part = Part {
            of: quantities.len(),
            first,
            len: node.dim,
        };
        node.map = Some(MappedNode::of(Box::new(part), vec![x]));
    }
    Ok(x)
}

/// Closes a set of loops; returns its report.
pub(super) fn close_set(
    nodes: &mut Vec<Node>,
    chains: &[JointLoop],
    setting: &Setting<'_>,
) -> Result<LoopReport, ModelError> {
    let inputs = inputs_of(nodes, chains, setting);
    let joints: Vec<&str> = (chains.iter())
        .map(|c| nodes[c.frame as usize].name.as_str())
        .collect();
    let joints = Subject::named(chains[0].frame, joints.join(", "));
    let about = described(nodes, chains, &inputs, setting);
    let mut p = Vec::with_capacity(inputs.parameter_count);
    for &(n, _) in &inputs.parameters {
        let value = |k| setting.initial(n as usize, k).unwrap_or(0.0);
        p.extend((0..nodes[n as usize].dim).map(value));
    }
    let mut equations = Box::new(tree(nodes, chains, &inputs));
    if inputs.unknowns.is_empty() {
        let given = &inputs.parameters;
        return nothing_follows(nodes, chains, joints, given, &mut *equations, setting);
    }
    let map = ImplicitMap::new(equations, about, 0.0, &p).map_err(|source| ModelError::Loop {
        joints: joints.clone(),
        source,
    })?;
    let moved = displaced(nodes, &inputs.unknowns, &map);
    let apart = drawn_apart(nodes, chains, setting);
    let x = add_map(nodes, map, &inputs, &joints.name)?;
    let closing = match chains.len() {
        1 => format!("joint {joints} closes a loop"),
        _ => format!("joints {joints} close loops"),
    };
    Ok(LoopReport {
        words: closing + &apart + &moved,
        map: Some(x),
        loops: chains.to_vec(),
        element: None,
    })
}
