//! Closed loops of joints: frames that coincide ([`ModelBuilder::close`]).
//!
//! If the second frame is free, it is attached to the first: an ordinary joint. If its coordinates
//! are in use (it is attached to something else, or is held), the two chains of joints make a loop:
//! the joint coordinates of the loop become the unknowns x of the equations that the frames
//! coincide ([`Coincide`]), and follow from D independent coordinates q
//! ([`ImplicitMap`](pullback_manifold::implicit::ImplicitMap), \[M04\] (171)–(173)):
//!
//! ```text
//! q, prescribed coordinates  →  x (ImplicitMap)  →  joint coordinates (Part)  →  frames (JointMap)
//! ```
//!
//! Loops that share a joint coordinate are solved together.

mod chain;
mod coincide;
mod part;
mod set;

use super::kinematics::mapped_node::MappedNode;
use super::{ModelError, Node, Subject};
use crate::joint::{JointMap, Offset};
use crate::model::build::builder::{ModelBuilder, NodeId};
use crate::model::build::closures::Closure;
use crate::model::build::dependency_graph::ancestors;
use crate::model::kinematics::pose::add_pose;
use crate::time::TimeFunction;
use chain::coordinates;
pub(in crate::model) use chain::{JointLoop, upwards};
pub(in crate::model) use coincide::Coincide;
use nalgebra::Vector3;
use pullback_manifold::map::ToChart;
use set::close_set;
use std::collections::{BTreeSet, HashMap, HashSet};
use std::sync::Arc;

/// Names of the equations of a frame at a joint, in the order of [`Coincide`].
pub(in crate::model) const EQUATIONS: [&str; 6] = [
    "the gap along e1",
    "the gap along e2",
    "the gap along e3",
    "the misalignment about e1",
    "the misalignment about e2",
    "the misalignment about e3",
];

/// Largest distance of coinciding frames as drawn, relative to the size of the model.
const APART: f64 = 1e-9;

/// Two coinciding frames: the one that is attached to the closing joint, and its child.
#[derive(Clone, Copy, Debug)]
pub(in crate::model) struct Closing {
    pub frame: NodeId,
    pub child: NodeId,
    pub by: Closure,
}

/// A part of the report on loops: text, or a map with a description.
#[derive(Clone, Debug, Default)]
pub(in crate::model) struct LoopReport {
    pub words: String,
    pub map: Option<u32>,
    /// The loops that it closes, in the order of their equations.
    pub loops: Vec<JointLoop>,
    /// The element that enforces it.
    pub element: Option<u32>,
}

impl LoopReport {
    /// A report with text only.
    pub(in crate::model) fn say(words: String) -> Self {
        Self {
            words,
            ..Self::default()
        }
    }
}

impl ModelBuilder {
    /// Makes two frames coincide: `frame`, usually attached to a joint, and `child`.
    ///
    /// A free child is attached to the frame. One that is attached to something else, or is held,
    /// closes a loop: the builder then makes the coordinates of the joints along the loop follow from
    /// as many independent ones as are free. The independent ones change during a run if others become
    /// better. [`Context::descriptions`](super::Context::descriptions) reports the result.
    ///
    /// # Errors
    /// [`ModelError::ForeignNode`]; [`ModelError::NotFrames`] for anything but two different frames;
    /// [`ModelError::OwnParent`]. When the model is built: [`ModelError::Apart`],
    /// [`ModelError::LooseLoop`], [`ModelError::Loop`], [`ModelError::Rigid`],
    /// [`ModelError::AllPrescribed`].
    pub fn close(&mut self, frame: NodeId, child: NodeId) -> Result<(), ModelError> {
        self.close_by(frame, child, Closure::Map)
    }

    /// Sets the desired initial value of coordinate `k` of a node in loops: kept if the loops close
    /// with it, a first guess otherwise. Ignored for coordinates outside of loops.
    pub fn start(&mut self, node: NodeId, k: usize, value: f64) {
        self.starts.insert((node, k), value);
    }

    /// Prefers this joint coordinate as an independent one of its loop, if it is about as good as
    /// others. Coordinates with a spring, an actuator or an initial value are preferred by default;
    /// next come those near the root of the loop.
    pub fn prefer(&mut self, node: NodeId) {
        self.preferred.insert(node);
    }
}

/// What is known about the coordinates of the builder's nodes.
#[derive(Clone, Copy)]
pub(in crate::model) struct Setting<'a> {
    /// Prescribed coordinates, and the values of inputs that they may read.
    pub functions: &'a [(NodeId, usize, Arc<dyn TimeFunction>)],
    pub inputs: &'a [f64],
    /// Desired initial values.
    pub starts: &'a HashMap<(NodeId, usize), f64>,
    /// Preferred independent coordinates.
    pub preferred: &'a HashSet<NodeId>,
    /// Size of the model.
    pub length: f64,
}

impl Setting<'_> {
    fn function(&self, node: usize, k: usize) -> Option<&dyn TimeFunction> {
        let found = self
            .functions
            .iter()
            .find(|(n, i, _)| n.0 as usize == node && *i == k);
        found.map(|(.., f)| &**f)
    }

    /// Value at the start, if coordinate `k` is prescribed.
    fn initial(&self, node: usize, k: usize) -> Option<f64> {
        let function = self.function(node, k)?;
        Some(function.at(0.0, self.inputs)[0])
    }

    fn any(&self, node: usize) -> bool {
        self.functions.iter().any(|(n, ..)| n.0 as usize == node)
    }

    /// Whether a node is fixed as drawn.
    pub(in crate::model) fn still(&self, node: usize, dim: usize) -> bool {
        (0..dim).all(|k| self.function(node, k).and_then(TimeFunction::constant) == Some(0.0))
    }
}

/// Closes all loops; adds nodes of the loops' coordinates after the others.
pub(in crate::model) fn close(
    nodes: &mut Vec<Node>,
    closings: &[Closing],
    setting: &Setting<'_>,
) -> Result<Vec<LoopReport>, ModelError> {
    let mut reports = Vec::new();
    let mut loops: Vec<Closing> = Vec::new();
    for &closing in closings {
        let Closing { frame, child, .. } = closing;
        let (a, b) = (&nodes[frame.0 as usize], &nodes[child.0 as usize]);
        let follows = || ancestors(nodes, &[frame.0], None, |d| &d.segments).contains(&child.0);
        let free = b.is_own() && !setting.any(child.0 as usize) && !follows();
        if !free {
            // Poses are compared.
            add_pose(nodes, frame.0);
            add_pose(nodes, child.0);
            loops.push(closing);
            continue;
        }
        let apart = a.position - b.position;
        if apart.norm() > APART * setting.length {
            return Err(ModelError::Apart {
                joint: Subject::node(nodes, frame.0),
                child: b.name.clone(),
                gap: apart.norm(),
            });
        }
        let words = format!("joint {}: {} is attached to it", a.name, b.name);
        reports.push(LoopReport::say(words));
        let same = JointMap::new(Offset {
            c: Vector3::zeros(),
        });
        let parent = add_pose(nodes, frame.0);
        let pose = add_pose(nodes, child.0);
        let chart = Box::new(ToChart::default());
        nodes[pose as usize].map = Some(MappedNode::of(Box::new(same), vec![parent]));
        nodes[child.0 as usize].map = Some(MappedNode::of(chart, vec![pose]));
    }
    for set in connected(nodes, &loops, setting)? {
        reports.push(close_set(nodes, &set, setting)?);
    }
    Ok(reports)
}

/// Initial coordinates: node, index and value of each.
pub(in crate::model) type Positions = Vec<(u32, usize, f64)>;

/// Initial coordinates of loops if closed by maps. Loops that no map
/// can close, over beams or bodies that fly, are omitted; if there are none of these, the result
/// includes the values of coordinates outside of loops.
pub(in crate::model) fn positions(
    nodes: &[Node],
    closings: &[Closing],
    setting: &Setting<'_>,
) -> Positions {
    let by_joints = |c: &&Closing| JointLoop::find(nodes, **c, setting).is_ok();
    let all = closings.len();
    let closings: Vec<Closing> = closings.iter().filter(by_joints).copied().collect();
    let mut copies: Vec<Node> = nodes.iter().map(Node::clone).collect();
    if close(&mut copies, &closings, setting).is_err() {
        return Vec::new();
    }
    let mut known = HashMap::new();
    let mut positions = Vec::new();
    let is_own = |nodes: &[Node], n: u32| nodes[n as usize].is_own();
    if closings.len() == all {
        let starts = setting.starts.iter();
        let kept = starts.filter(|((n, _), _)| is_own(nodes, n.0) && is_own(&copies, n.0));
        positions.extend(kept.map(|(&(n, k), &x)| (n.0, k, x)));
    }
    let replaced = |&n: &u32| is_own(nodes, n) && !is_own(&copies, n);
    for n in (0..nodes.len() as u32).filter(replaced) {
        let Some(x) = value(&copies, n, setting, &mut known) else {
            return Vec::new();
        };
        positions.extend(x.into_iter().enumerate().map(|(k, x)| (n, k, x)));
    }
    positions
}

/// The coordinates of a node at t = 0 with all free coordinates at their start, as drawn or with a
/// value; `None` outside the domain of a map.
fn value(
    nodes: &[Node],
    n: u32,
    setting: &Setting<'_>,
    known: &mut HashMap<u32, Vec<f64>>,
) -> Option<Vec<f64>> {
    if let Some(found) = known.get(&n) {
        return Some(found.clone());
    }
    let node = &nodes[n as usize];
    let mut x = vec![0.0; node.dim];
    match node.mapped() {
        None => {
            for (k, x) in x.iter_mut().enumerate() {
                let given = || setting.starts.get(&(NodeId(n), k)).copied().unwrap_or(0.0);
                *x = setting.initial(n as usize, k).unwrap_or_else(given);
            }
        }
        Some(d) => {
            let mut q = Vec::new();
            for &m in d.initial_parents() {
                q.extend(value(nodes, m, setting, known)?);
            }
            let mut B = vec![0.0; node.dim * q.len()];
            let mut map = d.map.clone();
            if map.domain(0.0, &q).is_err() {
                return None;
            }
            map.tangent(0.0, &q, &mut x, &mut B);
        }
    }
    known.insert(n, x.clone());
    Some(x)
}

/// Free coordinates of loops that share some, and the numbers of these loops.
type Set = (BTreeSet<u32>, Vec<usize>);

/// Groups loops into sets that share a free coordinate, each with the two chains to its root.
///
/// If a loop reads a root that follows from coordinates of its own set, or of a set that in turn
/// reads a root that follows from its own, the chains are extended above that root.
fn connected(
    nodes: &[Node],
    loops: &[Closing],
    setting: &Setting<'_>,
) -> Result<Vec<Vec<JointLoop>>, ModelError> {
    let chains = loops.iter().map(|&l| JointLoop::find(nodes, l, setting));
    let mut chains = chains.collect::<Result<Vec<_>, _>>()?;
    loop {
        let sets = sharing(nodes, &chains, setting);
        let Some(k) = circular(nodes, &chains, &sets, setting) else {
            let of = |(_, set): Set| set.iter().map(|&k| chains[k].clone()).collect();
            return Ok(sets.into_iter().map(of).collect());
        };
        chains[k].lengthen(nodes)?;
    }
}

/// Groups loops into sets that share a free coordinate.
fn sharing(nodes: &[Node], chains: &[JointLoop], setting: &Setting<'_>) -> Vec<Set> {
    let mut sets: Vec<Set> = Vec::new();
    for (k, chain) in chains.iter().enumerate() {
        let mut own: BTreeSet<u32> = coordinates(nodes, chain).into_iter().collect();
        own.retain(|&n| {
            let node = &nodes[n as usize];
            (0..node.dim).any(|k| setting.function(n as usize, k).is_none())
        });
        let (touching, rest): (Vec<Set>, _) =
            (sets.into_iter()).partition(|(other, _)| !own.is_disjoint(other));
        sets = rest;
        let mut before = Vec::new();
        for (other, chains) in touching {
            own.extend(other);
            before.extend(chains);
        }
        before.push(k);
        sets.push((own, before));
    }
    sets
}

/// A loop whose root follows from its own coordinates, directly or through other sets.
fn circular(
    nodes: &[Node],
    chains: &[JointLoop],
    sets: &[Set],
    setting: &Setting<'_>,
) -> Option<usize> {
    // The sets that each loop needs for its root.
    let needs = |k: usize| -> Vec<usize> {
        let Some(root) = chains[k].root else {
            return Vec::new();
        };
        let above = JointLoop {
            frame: root,
            child: root,
            root: None,
            ends: [None; 2],
        };
        let above = coordinates(nodes, &above);
        let set = |s: &usize| above.iter().any(|n| sets[*s].0.contains(n));
        let needed: Vec<usize> = (0..sets.len()).filter(set).collect();
        if needed.is_empty() || !chain::root_matters(nodes, &chains[k], root, setting) {
            return Vec::new();
        }
        needed
    };
    let needed: Vec<Vec<usize>> = (0..chains.len()).map(needs).collect();
    let of_set = |s: usize| sets[s].1.iter().flat_map(|&k| needed[k].iter().copied());
    let leads_back = |from: usize, to: usize| {
        let (mut seen, mut waiting) = (BTreeSet::new(), vec![from]);
        while let Some(s) = waiting.pop() {
            if s == to {
                return true;
            }
            if seen.insert(s) {
                waiting.extend(of_set(s));
            }
        }
        false
    };
    for (s, (_, own)) in sets.iter().enumerate() {
        for &k in own {
            if needed[k].iter().any(|&other| leads_back(other, s)) {
                return Some(k);
            }
        }
    }
    None
}
