//! Closed loops of joints: frames that are one and the same ([`ModelBuilder::close`]).
//!
//! Where the second frame is still free it hangs on the first from now on: an ordinary joint. Where
//! its coordinates are used up (it hangs on something else, or is held) the two chains of joints
//! make a loop: the joint coordinates of the loop become the unknowns x of the equations that the
//! frames coincide ([`Coincide`]), and follow from D coordinates q of their own
//! ([`Closed`](pullback_manifold::implicit::Closed), \[M04\] (171)–(173)):
//!
//! ```text
//! q, driven coordinates  →  x (Closed)  →  joint coordinates (Part)  →  frames (Hung)
//! ```
//!
//! Loops that share a joint coordinate are solved together.

mod chain;
mod tree;

use super::builder::{ModelBuilder, NodeId};
use super::closures::Closure;
use super::dependence::Dependence;
use super::{Form, ModelError, Node, Source};
use crate::joint::{Hung, Offset};
use crate::time::TimeFunction;
pub(super) use chain::upwards;
use chain::{Chain, coordinates};
use nalgebra::Vector3;
use pullback_manifold::implicit::Closed;
use pullback_manifold::implicit::closed::{Description, Unknown};
use pullback_manifold::map::Map;
use pullback_manifold::system::Kind;
use std::collections::{BTreeSet, HashMap};
pub(super) use tree::Coincide;
use tree::{Part, Read, Tree};

/// Distance of the places of two frames that are one, relative to the size of the model.
const APART: f64 = 1e-9;

/// Two frames that are one: the one that hangs on the closing joint, and its child.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closing {
    pub frame: NodeId,
    pub child: NodeId,
    pub by: Closure,
}

/// A part of the report on how loops close: in words, or the map that has more to say.
#[derive(Clone, Debug)]
pub(super) struct Report {
    pub words: String,
    pub map: Option<u32>,
    /// Closing frame and child of each loop, in the order of the equations.
    pub closures: Vec<(u32, u32)>,
    /// The element that enforces it.
    pub element: Option<u32>,
}

impl ModelBuilder {
    /// Makes two frames one and the same: `frame`, which hangs on a joint as a rule, and `child`.
    ///
    /// A child that is free hangs on the frame from now on. One that hangs on something else, or
    /// is held, closes a loop: the builder then makes the coordinates of the joints along the loop
    /// follow from as many independent ones as it leaves free, which change in the run where others
    /// become better. [`Model::notes`](super::Model::notes) tells what became of it.
    ///
    /// # Errors
    /// [`ModelError::ForeignNode`]; [`ModelError::NotFrames`] for anything but two different frames.
    /// When the model is built: [`ModelError::Apart`], [`ModelError::LooseLoop`],
    /// [`ModelError::Loop`].
    pub fn close(&mut self, frame: NodeId, child: NodeId) -> Result<(), ModelError> {
        self.close_by(frame, child, Closure::Map)
    }

    /// Says what value coordinate `k` of a node should have when the loops that it belongs to are
    /// assembled: kept where the loops close with it, a first guess where not. Nothing happens to
    /// coordinates that belong to no loop.
    pub fn start(&mut self, node: NodeId, k: usize, value: f64) {
        self.starts.insert((node, k), value);
    }
}

/// What prescribes the coordinates of the builder's nodes.
pub(super) struct Held<'a>(pub &'a [(NodeId, usize, Box<dyn TimeFunction>)]);

impl Held<'_> {
    fn function(&self, node: usize, k: usize) -> Option<&dyn TimeFunction> {
        let found = self
            .0
            .iter()
            .find(|(n, i, _)| n.0 as usize == node && *i == k);
        found.map(|(.., f)| &**f)
    }

    fn any(&self, node: usize) -> bool {
        self.0.iter().any(|(n, ..)| n.0 as usize == node)
    }

    /// Whether a node stays where it is drawn.
    pub(super) fn still(&self, node: usize, dim: usize) -> bool {
        (0..dim).all(|k| self.function(node, k).is_some_and(TimeFunction::is_zero))
    }
}

/// Whether node n follows from node `from`, through any number of maps.
fn follows(nodes: &[Node], n: u32, from: u32) -> bool {
    n == from
        || match &nodes[n as usize].source {
            Source::Own => false,
            Source::Mapped(d) => (d.segments.iter().flatten()).any(|&m| follows(nodes, m, from)),
        }
}

/// Closes what is to be closed: nodes of the loops' coordinates are added behind the others.
pub(super) fn close(
    nodes: &mut Vec<Node>,
    closings: &[Closing],
    held: &Held<'_>,
    starts: &HashMap<(NodeId, usize), f64>,
    length: f64,
) -> Result<Vec<Report>, ModelError> {
    let mut reports = Vec::new();
    let mut loops: Vec<Closing> = Vec::new();
    for &closing in closings {
        let Closing { frame, child, .. } = closing;
        let (a, b) = (&nodes[frame.0 as usize], &nodes[child.0 as usize]);
        let free = b.is_own() && !held.any(child.0 as usize) && !follows(nodes, frame.0, child.0);
        if !free {
            loops.push(closing);
            continue;
        }
        let apart = a.place - b.place;
        if apart.norm() > APART * length {
            return Err(ModelError::Apart {
                joint: a.name.clone(),
                child: b.name.clone(),
                gap: apart.norm(),
            });
        }
        reports.push(Report {
            words: format!("joint {}: {} hangs on it", a.name, b.name),
            map: None,
            closures: Vec::new(),
            element: None,
        });
        let same = Hung::new(Offset {
            c: Vector3::zeros(),
        });
        let dependence = Dependence::new(same.boxed(), vec![vec![frame.0]], 6);
        nodes[child.0 as usize].source = Source::Mapped(Box::new(dependence));
    }
    for set in connected(nodes, &loops, held)? {
        reports.push(close_set(nodes, &set, held, starts, length)?);
    }
    Ok(reports)
}

/// The loops in sets that share a free coordinate, each with the two chains to its root.
fn connected(
    nodes: &[Node],
    loops: &[Closing],
    held: &Held<'_>,
) -> Result<Vec<Vec<Chain>>, ModelError> {
    let mut sets: Vec<(BTreeSet<u32>, Vec<Chain>)> = Vec::new();
    for &closing in loops {
        let chain = Chain::find(nodes, closing, held)?;
        let mut own: BTreeSet<u32> = coordinates(nodes, &chain).into_iter().collect();
        own.retain(|&n| {
            let node = &nodes[n as usize];
            (0..node.dim).any(|k| held.function(n as usize, k).is_none())
        });
        let mut all = vec![chain];
        let (touching, rest) = (sets.into_iter()).partition(|(other, _)| !own.is_disjoint(other));
        sets = rest;
        let touching: Vec<(BTreeSet<u32>, Vec<Chain>)> = touching;
        let mut before = Vec::new();
        for (other, chains) in touching {
            own.extend(other);
            before.extend(chains);
        }
        before.append(&mut all);
        sets.push((own, before));
    }
    Ok(sets.into_iter().map(|(_, chains)| chains).collect())
}

/// The inputs of a set of loops: first the parameters, then the unknowns.
struct Inputs {
    /// Nodes of the parameters and of the unknowns, with their first input.
    nodes: Vec<(u32, usize)>,
    /// How many inputs are parameters, and how many there are.
    parameters: usize,
    count: usize,
    /// How many of the nodes are parameters.
    given: usize,
}

impl Inputs {
    /// Sorts own coordinate nodes, and roots that matter, into parameters and unknowns.
    fn new(nodes: &[Node], own: &[u32], roots: &[u32], held: &Held<'_>) -> Self {
        let moves = |n: &&u32| !held.still(**n as usize, nodes[**n as usize].dim);
        let given = |n: &&u32| roots.contains(n) || held.any(**n as usize);
        let all = roots.iter().chain(own).filter(moves);
        let (parameters, unknowns): (Vec<&u32>, Vec<&u32>) = all.partition(given);
        let mut out = Self {
            nodes: Vec::new(),
            parameters: 0,
            count: 0,
            given: parameters.len(),
        };
        for &&n in parameters.iter().chain(&unknowns) {
            if out.nodes.len() == out.given {
                out.parameters = out.count;
            }
            out.nodes.push((n, out.count));
            out.count += nodes[n as usize].dim;
        }
        if unknowns.is_empty() {
            out.parameters = out.count;
        }
        out
    }

    fn read(&self, node: u32) -> Read {
        let found = self.nodes.iter().find(|(n, _)| *n == node);
        found.map_or(Read::Nothing, |(_, first)| Read::Input(*first))
    }
}

/// The equations of chains as a tree of copies of their maps.
fn tree(nodes: &[Node], chains: &[Chain], inputs: &Inputs) -> Tree {
    let mut tree = Tree::new(inputs.count);
    let mut made: HashMap<(u32, u32), Read> = HashMap::new();
    let mut closures = Vec::new();
    for chain in chains {
        let ends =
            [chain.frame, chain.child].map(|n| add(nodes, n, chain, inputs, &mut tree, &mut made));
        let place = |n: u32| nodes[n as usize].place;
        let apart = place(chain.frame) - place(chain.child);
        closures.push((Coincide { apart }, ends));
    }
    for (between, ends) in closures {
        tree.close(between, ends);
    }
    tree
}

/// Adds the map of node n, and of those that it follows, up to the root.
fn add(
    nodes: &[Node],
    n: u32,
    chain: &Chain,
    inputs: &Inputs,
    tree: &mut Tree,
    made: &mut HashMap<(u32, u32), Read>,
) -> Read {
    if chain.root == Some(n) {
        return inputs.read(n);
    }
    let Source::Mapped(d) = &nodes[n as usize].source else {
        return inputs.read(n);
    };
    let key = (n, chain.root.unwrap_or(super::NONE));
    if let Some(&read) = made.get(&key) {
        return read;
    }
    let reads = (d.masters().iter())
        .map(|&m| {
            let read = add(nodes, m, chain, inputs, tree, made);
            (read, nodes[m as usize].dim)
        })
        .collect();
    let read = Read::Link(tree.link(d.map.duplicate(), reads));
    made.insert(key, read);
    read
}

/// What the equations of a frame at a joint are called, in the order of [`Coincide`].
pub(super) const EQUATIONS: [&str; 6] = [
    "the gap along e1",
    "the gap along e2",
    "the gap along e3",
    "the misalignment about e1",
    "the misalignment about e2",
    "the misalignment about e3",
];

/// Closes a set of loops: its coordinates, and what there is to say about it.
fn close_set(
    nodes: &mut Vec<Node>,
    chains: &[Chain],
    held: &Held<'_>,
    starts: &HashMap<(NodeId, usize), f64>,
    length: f64,
) -> Result<Report, ModelError> {
    let mut own: Vec<u32> = chains.iter().flat_map(|c| coordinates(nodes, c)).collect();
    own.sort_unstable();
    own.dedup();
    let mut roots: Vec<u32> = Vec::new();
    for chain in chains {
        let matters = |root: &u32| chain::root_matters(nodes, chain, *root, held);
        roots.extend(chain.root.filter(matters));
        roots.extend(chain.ends.iter().flatten());
    }
    roots.sort_unstable();
    roots.dedup();
    let inputs = Inputs::new(nodes, &own, &roots, held);
    let (given, unknown) = inputs.nodes.split_at(inputs.given);
    let joints: Vec<&str> = (chains.iter())
        .map(|c| nodes[c.frame as usize].name.as_str())
        .collect();
    let joints = joints.join(", ");
    let mut about = Description::default();
    let mut kinds = Vec::new();
    for &(n, first) in unknown {
        let node = &nodes[n as usize];
        if node.form == Form::Rotation {
            about.rotations.push(first - inputs.parameters);
        }
        for (k, &kind) in node.kinds.iter().enumerate() {
            kinds.push(kind);
            about.unknowns.push(Unknown {
                name: node.coordinate_name(k),
                size: if kind == Kind::Length { length } else { 1.0 },
                start: starts.get(&(NodeId(n), k)).copied(),
            });
        }
    }
    for chain in chains {
        let name = &nodes[chain.frame as usize].name;
        let names = EQUATIONS.iter().map(|e| format!("{e} at joint {name}"));
        about.equations.extend(names);
    }
    let mut p = Vec::with_capacity(inputs.parameters);
    for &(n, _) in given {
        let value = |k| held.function(n as usize, k).map_or(0.0, |f| f.at(0.0)[0]);
        p.extend((0..nodes[n as usize].dim).map(value));
    }
    let equations = Box::new(tree(nodes, chains, &inputs));
    let map = Closed::new(equations, about, 0.0, &p).map_err(|source| ModelError::Loop {
        joints: joints.clone(),
        source,
    })?;
    let (count, D) = (kinds.len(), map.freedoms());
    let first = map.independent().and_then(|k| k.first().copied());
    let kind = first.map_or(Kind::Angle, |k| kinds[k]);
    let mut masters: Vec<u32> = given.iter().map(|&(n, _)| n).collect();
    if D > 0 {
        let name = format!("loop of {joints}");
        nodes.push(Node::new(
            name,
            Form::Coordinates,
            &vec![kind; D],
            Source::Own,
        ));
        masters.insert(0, nodes.len() as u32 - 1);
    }
    if masters.len() > super::assembly::MAX_NODES {
        return Err(ModelError::TooManyNodes {
            element: format!("(loop of {joints})"),
            found: masters.len(),
            limit: super::assembly::MAX_NODES,
        });
    }
    let all = Dependence::new(Box::new(map), vec![masters], D + p.len());
    let source = Source::Mapped(Box::new(all));
    let name = format!("coordinates of {joints}");
    nodes.push(Node::new(name, Form::Coordinates, &kinds, source));
    let x = nodes.len() as u32 - 1;
    for &(n, first) in unknown {
        let node = &mut nodes[n as usize];
        let part = Part {
            of: count,
            first: first - inputs.parameters,
            len: node.dim,
        };
        let dependence = Dependence::new(Box::new(part), vec![vec![x]], count);
        node.source = Source::Mapped(Box::new(dependence));
    }
    Ok(Report {
        words: format!(
            "{} {joints} close{} {}",
            if chains.len() == 1 { "joint" } else { "joints" },
            if chains.len() == 1 { "s" } else { "" },
            if chains.len() == 1 { "a loop" } else { "loops" },
        ),
        map: Some(x),
        closures: chains.iter().map(|c| (c.frame, c.child)).collect(),
        element: None,
    })
}
